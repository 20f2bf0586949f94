// VK_LAYER_COPPICE_probe: finds which command of a frame a GPU hangs in, and reads of memory that nobody has written.
//
//   PROBE_FILL=0xCD        every new allocation of host-visible memory is filled with this byte (on CPU drivers: all device memory)
//   PROBE_MARKS=1          a timestamp after every command; when a wait lasts, says which command did not end
//   PROBE_SERIAL=1         also a full barrier after every command outside of rendering
//   PROBE_ARGS=1           copies arguments of indirect commands before they run; a dump says them
//   PROBE_TIMEOUT=8        seconds of a wait after which to dump and to exit with 86
//   PROBE_COMPILE_TIMEOUT=120  seconds of one vkCreate*Pipelines after which to dump and to exit with 87
//   PROBE_SKIP=a,b         commands that are not recorded: dispatch dispatchIndirect draw drawIndexed drawIndexedIndirectCount fill update
//                          copy copyImage; or the label of a pipeline: its dispatches and draws are left out (leaf_raster, resolve, ...)
//   PROBE_LOG=1            says pipelines as they are built, submissions, waits of more than 0.5 s
//   PROBE_GPU=1            the driver says that it is a discrete GPU: work is dealt out as on one, shadow maps and antialiasing are as
//   there PROBE_NO_LABELS=1      labels and names of VK_EXT_debug_utils do not reach the driver PROBE_CPU=1            the other way round:
//   work is dealt out as for a software driver PROBE_NO_INT64=1       no 64-bit atomics: the rasteriser's way in two passes
//   PROBE_GRANULARITY=N    bufferImageGranularity
//   PROBE_SPIRV=FOLDER     each shader module as a file
//   PROBE_LIST=FILE        at the end: every command of the last submission, with the time it took and its arguments
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cinttypes>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#define EXPORT extern "C" __attribute__((visibility("default")))

namespace {

using Clock = std::chrono::steady_clock;

int env_int(const char* name, int fallback) {
  const char* value = std::getenv(name);
  return value ? static_cast<int>(std::strtol(value, nullptr, 0)) : fallback;
}
const int kFill = env_int("PROBE_FILL", -1);
const bool kMarks = env_int("PROBE_MARKS", 0) != 0, kSerial = env_int("PROBE_SERIAL", 0) != 0, kArgs = env_int("PROBE_ARGS", 0) != 0,
           kLog = env_int("PROBE_LOG", 0) != 0;
const int kTimeout_s = env_int("PROBE_TIMEOUT", 8), kCompileTimeout_s = env_int("PROBE_COMPILE_TIMEOUT", 120);
const char* const kList = std::getenv("PROBE_LIST");
const std::set<std::string> kSkip = [] {
  std::set<std::string> skip;
  const char* value = std::getenv("PROBE_SKIP");
  std::string all = value ? value : "";
  for (std::size_t at = 0; at < all.size();) {
    std::size_t end = std::min(all.find(',', at), all.size());
    skip.insert(all.substr(at, end - at));
    at = end + 1;
  }
  return skip;
}();
bool skipped(const std::string& what) {
  return kSkip.count(what) != 0;
}

void say(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  std::fprintf(stderr, "probe: ");
  std::vfprintf(stderr, format, arguments);
  std::fprintf(stderr, "\n");
  std::fflush(stderr);
  va_end(arguments);
}

void* key_of(const void* handle) {
  return *static_cast<void* const*>(handle);
}

struct InstanceData {
  VkInstance instance;
  PFN_vkGetInstanceProcAddr next;
  // Asked for once: later the loader would answer with the first layer's.
  std::map<std::string, PFN_vkVoidFunction> functions;
};

constexpr std::uint32_t kMaxMarks = 8192, kArgBytes = 64;

struct Command {
  std::string label;
  std::uint32_t mark = ~0u;                       // its timestamp
  std::uint32_t arg_offset = ~0u, arg_words = 0;  // in the recording's args
  std::uint32_t count_offset = ~0u;
  std::uint32_t max_count = 0;
};

struct Recording {
  VkCommandBuffer cmd = VK_NULL_HANDLE;
  VkQueryPool pool = VK_NULL_HANDLE;
  VkBuffer args = VK_NULL_HANDLE;
  VkDeviceMemory args_memory = VK_NULL_HANDLE;
  std::uint8_t* args_mapped = nullptr;
  std::uint32_t args_used = 0;
  std::vector<Command> commands;
  std::string compute = "?", graphics = "?";
  bool rendering = false;
  std::vector<std::function<void()>> held;  // of a rendering, until its end
  std::uint32_t mark_count = 0;
  std::uint64_t submission = 0;
};

/// Of the next layer, or the driver.
#define PROBE_FUNCTIONS(X)         \
  X(vkAllocateMemory)              \
  X(vkBeginCommandBuffer)          \
  X(vkBindBufferMemory)            \
  X(vkCmdBeginRendering)           \
  X(vkCmdBindDescriptorSets)       \
  X(vkCmdBindIndexBuffer)          \
  X(vkCmdBindPipeline)             \
  X(vkCmdBindVertexBuffers)        \
  X(vkCmdCopyBuffer)               \
  X(vkCmdCopyBufferToImage)        \
  X(vkCmdCopyImageToBuffer)        \
  X(vkCmdDispatch)                 \
  X(vkCmdDispatchIndirect)         \
  X(vkCmdDraw)                     \
  X(vkCmdDrawIndexed)              \
  X(vkCmdDrawIndexedIndirect)      \
  X(vkCmdDrawIndexedIndirectCount) \
  X(vkCmdEndRendering)             \
  X(vkCmdFillBuffer)               \
  X(vkCmdPipelineBarrier2)         \
  X(vkCmdPushConstants)            \
  X(vkCmdResetQueryPool)           \
  X(vkCmdSetScissor)               \
  X(vkCmdSetViewport)              \
  X(vkCmdUpdateBuffer)             \
  X(vkCmdWriteTimestamp2)          \
  X(vkCreateBuffer)                \
  X(vkCreateComputePipelines)      \
  X(vkCreateGraphicsPipelines)     \
  X(vkCreateQueryPool)             \
  X(vkCreateShaderModule)          \
  X(vkDestroyBuffer)               \
  X(vkDestroyDevice)               \
  X(vkDeviceWaitIdle)              \
  X(vkFreeCommandBuffers)          \
  X(vkGetBufferDeviceAddress)      \
  X(vkGetBufferMemoryRequirements) \
  X(vkGetQueryPoolResults)         \
  X(vkMapMemory)                   \
  X(vkQueueSubmit2)                \
  X(vkQueueWaitIdle)               \
  X(vkSetDebugUtilsObjectNameEXT)  \
  X(vkUnmapMemory)                 \
  X(vkWaitForFences)               \
  X(vkWaitSemaphores)

struct DeviceData {
  VkDevice device;
  VkPhysicalDevice physical;
  InstanceData* instance;
  PFN_vkGetDeviceProcAddr next;
  PFN_vkSetDeviceLoaderData set_loader_data = nullptr;
  VkPhysicalDeviceMemoryProperties memory{};
  float tick_ns = 1;
  std::mutex mutex;
  std::unordered_map<VkCommandBuffer, std::unique_ptr<Recording>> recordings;
  std::map<std::uint64_t, std::string> modules, pipelines, buffers;
  std::uint64_t submissions = 0;
  std::vector<Recording*> submitted;  // newest last
#define FN(name) PFN_##name name = nullptr;
  PROBE_FUNCTIONS(FN)
#undef FN
};

std::mutex& global_mutex = *new std::mutex;
std::map<void*, std::unique_ptr<InstanceData>>& instances = *new std::map<void*, std::unique_ptr<InstanceData>>;
std::map<void*, std::unique_ptr<DeviceData>>& devices = *new std::map<void*, std::unique_ptr<DeviceData>>;

DeviceData* device_of(const void* handle) {
  const std::lock_guard lock(global_mutex);
  const auto found = devices.find(key_of(handle));
  return found == devices.end() ? nullptr : found->second.get();
}

// ---- what is being waited for

struct Wait {
  const char* call = nullptr;
  std::string about;
  Clock::time_point since;
  DeviceData* device = nullptr;
  int timeout_s = 0, exit_code = 0;
};
// Never destroyed: the watching thread outlives main().
std::mutex& wait_mutex = *new std::mutex;
std::map<std::uint64_t, Wait>& waits = *new std::map<std::uint64_t, Wait>;
std::uint64_t wait_number = 0;

std::string args_text(const Recording& r, const Command& c, bool* absurd = nullptr) {
  std::string text;
  if (c.count_offset != ~0u) {
    std::uint32_t count;
    std::memcpy(&count, r.args_mapped + c.count_offset, 4);
    text += " count=" + std::to_string(count) + " of most " + std::to_string(c.max_count);
  }
  if (c.arg_offset != ~0u) {
    text += " args=(";
    for (std::uint32_t i = 0; i < c.arg_words; ++i) {
      std::uint32_t word;
      std::memcpy(&word, r.args_mapped + c.arg_offset + 4 * i, 4);
      text += (i ? "," : "") + std::to_string(word);
      if (absurd && c.count_offset == ~0u && word > 65535) *absurd = true;
    }
    text += ")";
  }
  return text;
}

void dump(DeviceData& d) {
  std::unique_lock lock(d.mutex, std::try_to_lock);
  if (!kMarks) return say("no marks: PROBE_MARKS=1 says which command hangs");
  for (Recording* r : d.submitted) {
    std::vector<std::uint64_t> results(2 * std::max(r->mark_count, 1u));
    if (r->mark_count == 0) continue;
    d.vkGetQueryPoolResults(d.device, r->pool, 0, r->mark_count, results.size() * 8, results.data(), 16,
                            VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    std::uint32_t done = 0;
    for (std::uint32_t i = 0; i < r->mark_count; ++i) done += results[2 * i + 1] != 0;
    if (done == r->mark_count) continue;
    say("submission %llu: %u of %u commands have ended", static_cast<unsigned long long>(r->submission), done, r->mark_count);
    std::size_t first = r->commands.size();
    for (std::size_t i = 0; i < r->commands.size(); ++i)
      if (r->commands[i].mark != ~0u && results[2 * r->commands[i].mark + 1] == 0) {
        first = i;
        break;
      }
    const std::size_t from = first > 12 ? first - 12 : 0, to = std::min(first + 9, r->commands.size());
    for (std::size_t i = from; i < to; ++i) {
      const Command& c = r->commands[i];
      const bool ended = c.mark == ~0u || results[2 * c.mark + 1] != 0;
      say("%s %4zu %s%s", i == first ? ">>>" : ended ? "   " : " ? ", i, c.label.c_str(), args_text(*r, c).c_str());
    }
  }
}

void watch() {
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
    Wait late;
    {
      const std::lock_guard lock(wait_mutex);
      for (const auto& [number, wait] : waits)
        if (wait.timeout_s > 0 && Clock::now() - wait.since > std::chrono::seconds(wait.timeout_s)) late = wait;
    }
    if (!late.call) continue;
    say("HANG: %s%s has lasted %d s", late.call, late.about.c_str(), late.timeout_s);
    if (late.exit_code == 86) dump(*late.device);
    std::fflush(nullptr);
    _exit(late.exit_code);
  }
}

struct Waiting {
  std::uint64_t number;
  Clock::time_point since = Clock::now();
  const char* call;
  std::string about;
  Waiting(DeviceData* device, const char* call_in, int timeout_s, int exit_code, std::string about_in = "")
      : call(call_in), about(about_in) {
    static std::once_flag once;
    std::call_once(once, [] { std::thread(watch).detach(); });
    const std::lock_guard lock(wait_mutex);
    number = ++wait_number;
    waits[number] = {call, about, since, device, timeout_s, exit_code};
  }
  ~Waiting() {
    {
      const std::lock_guard lock(wait_mutex);
      waits.erase(number);
    }
    const double s = std::chrono::duration<double>(Clock::now() - since).count();
    if (kLog && s > 0.5) say("%s%s took %.2f s", call, about.c_str(), s);
  }
};

void list(DeviceData& d) {
  if (!kList || !kMarks || d.submitted.empty()) return;
  std::FILE* file = std::fopen(kList, "w");
  if (!file) return;
  for (Recording* r : d.submitted) {
    if (r->mark_count == 0) continue;
    std::vector<std::uint64_t> results(2 * r->mark_count);
    d.vkGetQueryPoolResults(d.device, r->pool, 0, r->mark_count, results.size() * 8, results.data(), 16,
                            VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
    std::uint64_t before = 0;
    std::fprintf(file, "submission %llu\n", static_cast<unsigned long long>(r->submission));
    for (std::size_t i = 0; i < r->commands.size(); ++i) {
      const Command& c = r->commands[i];
      double us = 0;
      if (c.mark != ~0u) {
        if (before) us = static_cast<double>(results[2 * c.mark] - before) * d.tick_ns * 1e-3;
        before = results[2 * c.mark];
      }
      std::fprintf(file, "%5zu %10.1f us  %s%s\n", i, us, c.label.c_str(), args_text(*r, c).c_str());
    }
  }
  std::fclose(file);
}

// ---- recording

Recording& recording(DeviceData& d, VkCommandBuffer cmd) {
  const std::lock_guard lock(d.mutex);
  std::unique_ptr<Recording>& r = d.recordings[cmd];
  if (!r) {
    r = std::make_unique<Recording>();
    r->cmd = cmd;
  }
  return *r;
}

void mark(DeviceData& d, Recording& r, Command command) {
  if (!kMarks) return;
  if (r.mark_count < kMaxMarks && r.pool) {
    command.mark = r.mark_count++;
    const auto write = [&d, cmd = r.cmd, pool = r.pool, index = command.mark] {
      d.vkCmdWriteTimestamp2(cmd, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool, index);
    };
    if (r.rendering)
      r.held.push_back(write);
    else
      write();
  }
  r.commands.push_back(std::move(command));
  if (kSerial && !r.rendering) {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,   nullptr,
                             VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                             VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT};
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.memoryBarrierCount = 1;
    info.pMemoryBarriers = &barrier;
    d.vkCmdPipelineBarrier2(r.cmd, &info);
  }
}

void full_barrier(DeviceData& d, VkCommandBuffer cmd) {
  VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                           nullptr,
                           VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                           VK_ACCESS_2_MEMORY_WRITE_BIT,
                           VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                           VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_HOST_READ_BIT};
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &barrier;
  d.vkCmdPipelineBarrier2(cmd, &info);
}

/// Where in r.args the words come to lie; ~0u: nowhere. Outside of rendering, or before one.
std::uint32_t copy_args(DeviceData& d, Recording& r, VkBuffer from, VkDeviceSize offset, std::uint32_t bytes) {
  if (!kArgs || !r.args || r.args_used + bytes > kMaxMarks * kArgBytes) return ~0u;
  const VkBufferCopy region{offset, r.args_used, bytes};
  d.vkCmdCopyBuffer(r.cmd, from, r.args, 1, &region);
  const std::uint32_t at = r.args_used;
  r.args_used += bytes;
  return at;
}

std::string buffer_name(DeviceData& d, VkBuffer buffer) {
  const std::lock_guard lock(d.mutex);
  const auto found = d.buffers.find(reinterpret_cast<std::uint64_t>(buffer));
  return found == d.buffers.end() ? "?" : found->second;
}

void begin(DeviceData& d, Recording& r) {
  if (!kMarks) return;
  if (!r.pool) {
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = kMaxMarks;
    if (d.vkCreateQueryPool(d.device, &info, nullptr, &r.pool) != VK_SUCCESS) say("no query pool");
  }
  if (kArgs && !r.args) {
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = kMaxMarks * kArgBytes;
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    d.vkCreateBuffer(d.device, &info, nullptr, &r.args);
    VkMemoryRequirements needs;
    d.vkGetBufferMemoryRequirements(d.device, r.args, &needs);
    VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    allocate.allocationSize = needs.size;
    constexpr VkMemoryPropertyFlags kWanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    for (std::uint32_t i = 0; i < d.memory.memoryTypeCount; ++i)
      if ((needs.memoryTypeBits >> i & 1) && (d.memory.memoryTypes[i].propertyFlags & kWanted) == kWanted) {
        allocate.memoryTypeIndex = i;
        break;
      }
    void* mapped = nullptr;
    if (d.vkAllocateMemory(d.device, &allocate, nullptr, &r.args_memory) != VK_SUCCESS ||
        d.vkBindBufferMemory(d.device, r.args, r.args_memory, 0) != VK_SUCCESS ||
        d.vkMapMemory(d.device, r.args_memory, 0, VK_WHOLE_SIZE, 0, &mapped) != VK_SUCCESS) {
      say("no memory for arguments");
      r.args = VK_NULL_HANDLE;
    }
    r.args_mapped = static_cast<std::uint8_t*>(mapped);
  }
  r.commands.clear();
  r.mark_count = 0;
  r.args_used = 0;
  if (r.args_mapped) std::memset(r.args_mapped, 0xee, kMaxMarks * kArgBytes);
  if (r.pool) d.vkCmdResetQueryPool(r.cmd, r.pool, 0, kMaxMarks);
  mark(d, r, {"begin"});
}

/// Runs it now, or keeps it for the end of a rendering where arguments must be copied before that.
template <class Call>
void record(Recording& r, const Call& call) {
  if (r.rendering && kMarks)
    r.held.push_back(call);
  else
    call();
}

// ---- labels of shaders, by names that glslang leaves in them

struct Known {
  const char* text;
  const char* label;
};
constexpr Known kKnown[] = {{"smallest_of_picture", "leaf_tiles"},
                            {"append_quads", "cull_raster"},
                            {"expand_together", "leaf_expand"},
                            {"raster_splat", "leaf_splats"},
                            {"raster_block", "leaf_raster"},
                            {"shade_pixel", "big_leaves"},
                            {"motion_of", "cluster_motion"},
                            {"key_bits", "occluder"},
                            {"draw_pages", "cull"},
                            {"culling_pass_of", "leaf_blocks"},
                            {"draw_meshes", "hardware_draws"},
                            {"resolve(", "resolve"},
                            {"mapped_normal", "relief.frag"},
                            {"toned_at", "temporal"},
                            {"displayed", "tone_map"},
                            {"gloss", "light"},
                            {"stalk_m", "leaf_mesh.vert"},
                            {"list_index", "leaf.vert"},
                            {"slot_of_draw", "wood.vert"},
                            {"textured_albedo", "plant/leaf.frag"},
                            {"out_of_surface", "relief.frag"},
                            {"kLitterTile_m", "terrain.frag"},
                            {"in_foot", "terrain.vert"},
                            {"tremble", "tufts.vert"},
                            {"zenith", "sky.frag"},
                            {"trodden", "terrain.frag"}};

std::string label_of(const std::uint32_t* words, std::size_t bytes) {
  const std::string text(reinterpret_cast<const char*>(words), bytes);
  std::string label;
  for (const Known& known : kKnown)
    if (text.find(known.text) != std::string::npos) {
      label = known.label;
      break;
    }
  if (label.empty()) {
    std::uint32_t hash = 2166136261u;
    for (unsigned char c : text) hash = (hash ^ c) * 16777619u;
    char name[40];
    std::snprintf(name, sizeof name, "shader_%08x_%zu", hash, bytes);
    label = name;
  }
  return label;
}

std::string constants_text(const VkSpecializationInfo* info) {
  if (!info) return "";
  std::string text = "[";
  for (std::uint32_t i = 0; i < info->mapEntryCount; ++i) {
    std::uint32_t word = 0;
    std::memcpy(&word, static_cast<const char*>(info->pData) + info->pMapEntries[i].offset, 4);
    text += (i ? " " : "") + std::to_string(word);
  }
  return text + "]";
}

}  // namespace

// ---- entry points

#define D(handle) DeviceData& d = *device_of(handle)

static VKAPI_ATTR VkResult VKAPI_CALL probe_AllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                                           const VkAllocationCallbacks* a, VkDeviceMemory* memory) {
  D(device);
  const VkResult result = d.vkAllocateMemory(device, info, a, memory);
  if (result != VK_SUCCESS || kFill < 0) return result;
  if (!(d.memory.memoryTypes[info->memoryTypeIndex].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)) return result;
  void* mapped = nullptr;
  if (d.vkMapMemory(device, *memory, 0, VK_WHOLE_SIZE, 0, &mapped) != VK_SUCCESS) return result;
  std::memset(mapped, kFill, info->allocationSize);
  d.vkUnmapMemory(device, *memory);
  return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_CreateBuffer(VkDevice device, const VkBufferCreateInfo* info, const VkAllocationCallbacks* a,
                                                         VkBuffer* buffer) {
  D(device);
  VkBufferCreateInfo with = *info;
  if (kArgs && (info->usage & VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT)) with.usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  const VkResult result = d.vkCreateBuffer(device, &with, a, buffer);
  if (result == VK_SUCCESS) {
    const std::lock_guard lock(d.mutex);
    d.buffers[reinterpret_cast<std::uint64_t>(*buffer)] = std::to_string(info->size) + "B";
  }
  return result;
}

static VKAPI_ATTR VkDeviceAddress VKAPI_CALL probe_GetBufferDeviceAddress(VkDevice device, const VkBufferDeviceAddressInfo* info) {
  D(device);
  const VkDeviceAddress address = d.vkGetBufferDeviceAddress(device, info);
  if (kLog) say("address 0x%llx of buffer %s", static_cast<unsigned long long>(address), buffer_name(d, info->buffer).c_str());
  return address;
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_SetDebugUtilsObjectNameEXT(VkDevice device, const VkDebugUtilsObjectNameInfoEXT* info) {
  D(device);
  if (info->pObjectName) {
    const std::lock_guard lock(d.mutex);
    if (info->objectType == VK_OBJECT_TYPE_BUFFER) d.buffers[info->objectHandle] = std::string(info->pObjectName);
  }
  return d.vkSetDebugUtilsObjectNameEXT ? d.vkSetDebugUtilsObjectNameEXT(device, info) : VK_SUCCESS;
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_CreateShaderModule(VkDevice device, const VkShaderModuleCreateInfo* info,
                                                               const VkAllocationCallbacks* a, VkShaderModule* module) {
  D(device);
  const VkResult result = d.vkCreateShaderModule(device, info, a, module);
  if (result == VK_SUCCESS) {
    const std::lock_guard lock(d.mutex);
    d.modules[reinterpret_cast<std::uint64_t>(*module)] = label_of(info->pCode, info->codeSize);
    if (const char* folder = std::getenv("PROBE_SPIRV")) {
      static std::atomic<int> number{0};
      char path[300];
      std::string label = d.modules[reinterpret_cast<std::uint64_t>(*module)];
      for (char& c : label)
        if (c == '/') c = '_';
      std::snprintf(path, sizeof path, "%s/%03d_%s.spv", folder, number++, label.c_str());
      if (std::FILE* file = std::fopen(path, "wb")) {
        std::fwrite(info->pCode, 1, info->codeSize, file);
        std::fclose(file);
      }
    }
  }
  return result;
}

static std::string stage_label(DeviceData& d, const VkPipelineShaderStageCreateInfo& stage) {
  const std::lock_guard lock(d.mutex);
  return d.modules[reinterpret_cast<std::uint64_t>(stage.module)] + constants_text(stage.pSpecializationInfo);
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_CreateComputePipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count,
                                                                   const VkComputePipelineCreateInfo* infos, const VkAllocationCallbacks* a,
                                                                   VkPipeline* pipelines) {
  D(device);
  std::string label = " of " + stage_label(d, infos[0].stage);
  VkResult result;
  {
    const Waiting waiting(&d, "vkCreateComputePipelines", kCompileTimeout_s, 87, label);
    result = d.vkCreateComputePipelines(device, cache, count, infos, a, pipelines);
    if (kLog)
      say("compute pipeline%s: %d, %.2f s", label.c_str(), result, std::chrono::duration<double>(Clock::now() - waiting.since).count());
  }
  for (std::uint32_t i = 0; i < count && result == VK_SUCCESS; ++i) {
    const std::string name = stage_label(d, infos[i].stage);
    const std::lock_guard lock(d.mutex);
    d.pipelines[reinterpret_cast<std::uint64_t>(pipelines[i])] = name;
  }
  return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_CreateGraphicsPipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count,
                                                                    const VkGraphicsPipelineCreateInfo* infos,
                                                                    const VkAllocationCallbacks* a, VkPipeline* pipelines) {
  D(device);
  const auto label_of_pipeline = [&](const VkGraphicsPipelineCreateInfo& info) {
    std::string label;
    for (std::uint32_t i = 0; i < info.stageCount; ++i) label += (i ? "+" : "") + stage_label(d, info.pStages[i]);
    return label;
  };
  VkResult result;
  {
    const std::string label = " of " + label_of_pipeline(infos[0]);
    const Waiting waiting(&d, "vkCreateGraphicsPipelines", kCompileTimeout_s, 87, label);
    result = d.vkCreateGraphicsPipelines(device, cache, count, infos, a, pipelines);
    if (kLog)
      say("graphics pipeline%s: %d, %.2f s", label.c_str(), result, std::chrono::duration<double>(Clock::now() - waiting.since).count());
  }
  for (std::uint32_t i = 0; i < count && result == VK_SUCCESS; ++i) {
    const std::string name = label_of_pipeline(infos[i]);
    const std::lock_guard lock(d.mutex);
    d.pipelines[reinterpret_cast<std::uint64_t>(pipelines[i])] = name;
  }
  return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_BeginCommandBuffer(VkCommandBuffer cmd, const VkCommandBufferBeginInfo* info) {
  D(cmd);
  const VkResult result = d.vkBeginCommandBuffer(cmd, info);
  if (result == VK_SUCCESS) begin(d, recording(d, cmd));
  return result;
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdBindPipeline(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipeline pipeline) {
  D(cmd);
  Recording& r = recording(d, cmd);
  {
    const std::lock_guard lock(d.mutex);
    (point == VK_PIPELINE_BIND_POINT_COMPUTE ? r.compute : r.graphics) = d.pipelines[reinterpret_cast<std::uint64_t>(pipeline)];
  }
  record(r, [&d, cmd, point, pipeline] { d.vkCmdBindPipeline(cmd, point, pipeline); });
}

static bool skipped_pipeline(const std::string& label) {
  for (const std::string& skip : kSkip)
    if (label.find(skip) != std::string::npos) return true;
  return false;
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdDispatch(VkCommandBuffer cmd, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("dispatch") || skipped_pipeline(r.compute)) return;
  d.vkCmdDispatch(cmd, x, y, z);
  mark(d, r, {"dispatch " + r.compute + " " + std::to_string(x) + "x" + std::to_string(y) + "x" + std::to_string(z)});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdDispatchIndirect(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("dispatchIndirect") || skipped_pipeline(r.compute)) return;
  Command command{"dispatchIndirect " + r.compute + " @" + std::to_string(offset)};
  if (kArgs && kMarks) {
    full_barrier(d, cmd);
    command.arg_offset = copy_args(d, r, buffer, offset, 12);
    command.arg_words = 3;
    full_barrier(d, cmd);
  }
  d.vkCmdDispatchIndirect(cmd, buffer, offset);
  mark(d, r, std::move(command));
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdDraw(VkCommandBuffer cmd, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t e) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("draw") || skipped_pipeline(r.graphics)) return;
  record(r, [&d, cmd, a, b, c, e] { d.vkCmdDraw(cmd, a, b, c, e); });
  mark(d, r, {"draw " + r.graphics + " " + std::to_string(a) + " x " + std::to_string(b)});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdDrawIndexed(VkCommandBuffer cmd, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                                                       std::int32_t e, std::uint32_t f) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("drawIndexed") || skipped_pipeline(r.graphics)) return;
  record(r, [&d, cmd, a, b, c, e, f] { d.vkCmdDrawIndexed(cmd, a, b, c, e, f); });
  mark(d, r, {"drawIndexed " + r.graphics + " " + std::to_string(a) + " x " + std::to_string(b)});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdDrawIndexedIndirectCount(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset,
                                                                    VkBuffer count_buffer, VkDeviceSize count_offset,
                                                                    std::uint32_t max_count, std::uint32_t stride) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("drawIndexedIndirectCount") || skipped_pipeline(r.graphics)) return;
  Command command{"drawIndexedIndirectCount " + r.graphics + " @" + std::to_string(offset) + " count@" + std::to_string(count_offset)};
  command.max_count = max_count;
  if (kArgs && kMarks) {
    command.count_offset = copy_args(d, r, count_buffer, count_offset, 4);
    command.arg_offset = copy_args(d, r, buffer, offset, 20);
    command.arg_words = 5;
  }
  record(r, [&d, cmd, buffer, offset, count_buffer, count_offset, max_count, stride] {
    d.vkCmdDrawIndexedIndirectCount(cmd, buffer, offset, count_buffer, count_offset, max_count, stride);
  });
  mark(d, r, std::move(command));
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdDrawIndexedIndirect(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset,
                                                               std::uint32_t count, std::uint32_t stride) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("drawIndexedIndirect") || skipped_pipeline(r.graphics)) return;
  Command command{"drawIndexedIndirect " + r.graphics + " " + std::to_string(count)};
  if (kArgs && kMarks) {
    command.arg_offset = copy_args(d, r, buffer, offset, 20);
    command.arg_words = 5;
  }
  record(r, [&d, cmd, buffer, offset, count, stride] { d.vkCmdDrawIndexedIndirect(cmd, buffer, offset, count, stride); });
  mark(d, r, std::move(command));
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdFillBuffer(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
                                                      std::uint32_t data) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("fill")) return;
  d.vkCmdFillBuffer(cmd, buffer, offset, size, data);
  mark(d, r, {"fill " + buffer_name(d, buffer) + " " + std::to_string(size)});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdUpdateBuffer(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
                                                        const void* data) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("update")) return;
  d.vkCmdUpdateBuffer(cmd, buffer, offset, size, data);
  mark(d, r, {"update " + buffer_name(d, buffer) + " " + std::to_string(size)});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdCopyBuffer(VkCommandBuffer cmd, VkBuffer from, VkBuffer to, std::uint32_t count,
                                                      const VkBufferCopy* regions) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("copy")) return;
  d.vkCmdCopyBuffer(cmd, from, to, count, regions);
  std::uint64_t bytes = 0;
  for (std::uint32_t i = 0; i < count; ++i) bytes += regions[i].size;
  mark(d, r, {"copy " + buffer_name(d, from) + " to " + buffer_name(d, to) + " " + std::to_string(bytes)});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdCopyBufferToImage(VkCommandBuffer cmd, VkBuffer from, VkImage to, VkImageLayout layout,
                                                             std::uint32_t count, const VkBufferImageCopy* regions) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("copyImage")) return;
  d.vkCmdCopyBufferToImage(cmd, from, to, layout, count, regions);
  mark(d, r, {"copyBufferToImage " + std::to_string(regions[0].imageExtent.width) + "x" + std::to_string(regions[0].imageExtent.height)});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdCopyImageToBuffer(VkCommandBuffer cmd, VkImage from, VkImageLayout layout, VkBuffer to,
                                                             std::uint32_t count, const VkBufferImageCopy* regions) {
  D(cmd);
  Recording& r = recording(d, cmd);
  d.vkCmdCopyImageToBuffer(cmd, from, layout, to, count, regions);
  mark(d, r, {"copyImageToBuffer"});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdPipelineBarrier2(VkCommandBuffer cmd, const VkDependencyInfo* info) {
  D(cmd);
  Recording& r = recording(d, cmd);
  d.vkCmdPipelineBarrier2(cmd, info);
  mark(d, r, {"barrier" + std::string(info->imageMemoryBarrierCount ? " of an image" : "")});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdBeginRendering(VkCommandBuffer cmd, const VkRenderingInfo* info) {
  D(cmd);
  Recording& r = recording(d, cmd);
  std::string label = "beginRendering " + std::to_string(info->renderArea.extent.width) + "x" +
                      std::to_string(info->renderArea.extent.height) + " colours " + std::to_string(info->colorAttachmentCount) +
                      (info->pDepthAttachment ? " depth" : "");
  if (!kMarks) return d.vkCmdBeginRendering(cmd, info);
  // Deep copy: it begins when it ends, so that arguments are copied before.
  struct Copy {
    VkRenderingInfo info;
    std::vector<VkRenderingAttachmentInfo> colors;
    VkRenderingAttachmentInfo depth{}, stencil{};
  };
  auto copy = std::make_shared<Copy>();
  copy->info = *info;
  copy->colors.assign(info->pColorAttachments, info->pColorAttachments + info->colorAttachmentCount);
  copy->info.pColorAttachments = copy->colors.data();
  if (info->pDepthAttachment) copy->depth = *info->pDepthAttachment, copy->info.pDepthAttachment = &copy->depth;
  if (info->pStencilAttachment) copy->stencil = *info->pStencilAttachment, copy->info.pStencilAttachment = &copy->stencil;
  if (kArgs) full_barrier(d, cmd);
  r.rendering = true;
  r.held.push_back([&d, cmd, copy] { d.vkCmdBeginRendering(cmd, &copy->info); });
  mark(d, r, {label});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdEndRendering(VkCommandBuffer cmd) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (!kMarks) return d.vkCmdEndRendering(cmd);
  if (kArgs) full_barrier(d, cmd);
  for (const auto& call : r.held) call();
  r.held.clear();
  r.rendering = false;
  d.vkCmdEndRendering(cmd);
  mark(d, r, {"endRendering"});
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdBindDescriptorSets(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipelineLayout layout,
                                                              std::uint32_t first, std::uint32_t count, const VkDescriptorSet* sets,
                                                              std::uint32_t dynamic_count, const std::uint32_t* dynamic) {
  D(cmd);
  Recording& r = recording(d, cmd);
  std::vector<VkDescriptorSet> copy(sets, sets + count);
  std::vector<std::uint32_t> offsets(dynamic, dynamic + dynamic_count);
  record(r, [&d, cmd, point, layout, first, copy, offsets] {
    d.vkCmdBindDescriptorSets(cmd, point, layout, first, static_cast<std::uint32_t>(copy.size()), copy.data(),
                              static_cast<std::uint32_t>(offsets.size()), offsets.data());
  });
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdPushConstants(VkCommandBuffer cmd, VkPipelineLayout layout, VkShaderStageFlags stages,
                                                         std::uint32_t offset, std::uint32_t size, const void* values) {
  D(cmd);
  Recording& r = recording(d, cmd);
  std::vector<std::uint8_t> copy(static_cast<const std::uint8_t*>(values), static_cast<const std::uint8_t*>(values) + size);
  record(r, [&d, cmd, layout, stages, offset, copy] {
    d.vkCmdPushConstants(cmd, layout, stages, offset, static_cast<std::uint32_t>(copy.size()), copy.data());
  });
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdSetViewport(VkCommandBuffer cmd, std::uint32_t first, std::uint32_t count,
                                                       const VkViewport* viewports) {
  D(cmd);
  std::vector<VkViewport> copy(viewports, viewports + count);
  record(recording(d, cmd),
         [&d, cmd, first, copy] { d.vkCmdSetViewport(cmd, first, static_cast<std::uint32_t>(copy.size()), copy.data()); });
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdSetScissor(VkCommandBuffer cmd, std::uint32_t first, std::uint32_t count,
                                                      const VkRect2D* scissors) {
  D(cmd);
  std::vector<VkRect2D> copy(scissors, scissors + count);
  record(recording(d, cmd),
         [&d, cmd, first, copy] { d.vkCmdSetScissor(cmd, first, static_cast<std::uint32_t>(copy.size()), copy.data()); });
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdBindIndexBuffer(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, VkIndexType type) {
  D(cmd);
  record(recording(d, cmd), [&d, cmd, buffer, offset, type] { d.vkCmdBindIndexBuffer(cmd, buffer, offset, type); });
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdBindVertexBuffers(VkCommandBuffer cmd, std::uint32_t first, std::uint32_t count,
                                                             const VkBuffer* buffers, const VkDeviceSize* offsets) {
  D(cmd);
  std::vector<VkBuffer> copy(buffers, buffers + count);
  std::vector<VkDeviceSize> at(offsets, offsets + count);
  record(recording(d, cmd), [&d, cmd, first, copy, at] {
    d.vkCmdBindVertexBuffers(cmd, first, static_cast<std::uint32_t>(copy.size()), copy.data(), at.data());
  });
}

static VKAPI_ATTR void VKAPI_CALL probe_CmdWriteTimestamp2(VkCommandBuffer cmd, VkPipelineStageFlags2 stage, VkQueryPool pool,
                                                           std::uint32_t query) {
  D(cmd);
  record(recording(d, cmd), [&d, cmd, stage, pool, query] { d.vkCmdWriteTimestamp2(cmd, stage, pool, query); });
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_QueueSubmit2(VkQueue queue, std::uint32_t count, const VkSubmitInfo2* submits, VkFence fence) {
  D(queue);
  {
    const std::lock_guard lock(d.mutex);
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t k = 0; k < submits[i].commandBufferInfoCount; ++k) {
        const auto found = d.recordings.find(submits[i].pCommandBufferInfos[k].commandBuffer);
        if (found == d.recordings.end()) continue;
        Recording* r = found->second.get();
        r->submission = ++d.submissions;
        std::erase(d.submitted, r);
        d.submitted.push_back(r);
        if (kLog) say("submission %llu: %zu commands", static_cast<unsigned long long>(r->submission), r->commands.size());
      }
  }
  return d.vkQueueSubmit2(queue, count, submits, fence);
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_WaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo* info, std::uint64_t timeout) {
  D(device);
  const Waiting waiting(&d, "vkWaitSemaphores", kTimeout_s, 86);
  const VkResult result = d.vkWaitSemaphores(device, info, timeout);
  if (result == VK_ERROR_DEVICE_LOST) say("DEVICE LOST in vkWaitSemaphores"), dump(d);
  return result;
}
static VKAPI_ATTR VkResult VKAPI_CALL probe_WaitForFences(VkDevice device, std::uint32_t count, const VkFence* fences, VkBool32 all,
                                                          std::uint64_t timeout) {
  D(device);
  const Waiting waiting(&d, "vkWaitForFences", kTimeout_s, 86);
  const VkResult result = d.vkWaitForFences(device, count, fences, all, timeout);
  if (result == VK_ERROR_DEVICE_LOST) say("DEVICE LOST in vkWaitForFences"), dump(d);
  if (kList) list(d);
  return result;
}
static VKAPI_ATTR VkResult VKAPI_CALL probe_QueueWaitIdle(VkQueue queue) {
  D(queue);
  const Waiting waiting(&d, "vkQueueWaitIdle", kTimeout_s, 86);
  const VkResult result = d.vkQueueWaitIdle(queue);
  if (result == VK_ERROR_DEVICE_LOST) say("DEVICE LOST in vkQueueWaitIdle"), dump(d);
  return result;
}
static VKAPI_ATTR VkResult VKAPI_CALL probe_DeviceWaitIdle(VkDevice device) {
  D(device);
  const Waiting waiting(&d, "vkDeviceWaitIdle", kTimeout_s, 86);
  const VkResult result = d.vkDeviceWaitIdle(device);
  if (result == VK_ERROR_DEVICE_LOST) say("DEVICE LOST in vkDeviceWaitIdle"), dump(d);
  list(d);
  return result;
}

static void free_recording(DeviceData& d, Recording& r) {
  const auto destroy_pool = reinterpret_cast<PFN_vkDestroyQueryPool>(d.next(d.device, "vkDestroyQueryPool"));
  const auto free_memory = reinterpret_cast<PFN_vkFreeMemory>(d.next(d.device, "vkFreeMemory"));
  if (r.pool) destroy_pool(d.device, r.pool, nullptr);
  if (r.args) d.vkDestroyBuffer(d.device, r.args, nullptr);
  if (r.args_memory) free_memory(d.device, r.args_memory, nullptr);
}

static VKAPI_ATTR void VKAPI_CALL probe_FreeCommandBuffers(VkDevice device, VkCommandPool pool, std::uint32_t count,
                                                           const VkCommandBuffer* buffers) {
  D(device);
  {
    const std::lock_guard lock(d.mutex);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto found = d.recordings.find(buffers[i]);
      if (found == d.recordings.end()) continue;
      std::erase(d.submitted, found->second.get());
      free_recording(d, *found->second);
      d.recordings.erase(found);
    }
  }
  d.vkFreeCommandBuffers(device, pool, count, buffers);
}

static VKAPI_ATTR void VKAPI_CALL probe_DestroyDevice(VkDevice device, const VkAllocationCallbacks* a) {
  D(device);
  const auto destroy = d.vkDestroyDevice;
  // Query pools and arguments go with it.
  for (auto& [cmd, r] : d.recordings) free_recording(d, *r);
  void* key = key_of(device);
  destroy(device, a);
  const std::lock_guard lock(global_mutex);
  devices.erase(key);
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_CreateDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                                         const VkAllocationCallbacks* a, VkDevice* device) {
  auto* chain = reinterpret_cast<VkLayerDeviceCreateInfo*>(const_cast<void*>(info->pNext));
  while (chain && !(chain->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO && chain->function == VK_LAYER_LINK_INFO))
    chain = reinterpret_cast<VkLayerDeviceCreateInfo*>(const_cast<void*>(chain->pNext));
  if (!chain) return VK_ERROR_INITIALIZATION_FAILED;
  const auto next_device = chain->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  chain->u.pLayerInfo = chain->u.pLayerInfo->pNext;
  InstanceData* instance;
  {
    const std::lock_guard lock(global_mutex);
    instance = instances[key_of(physical)].get();
  }
  const auto create = reinterpret_cast<PFN_vkCreateDevice>(instance->functions["vkCreateDevice"]);
  const VkResult result = create(physical, info, a, device);
  if (result != VK_SUCCESS) return result;
  auto made = std::make_unique<DeviceData>();
  DeviceData& d = *made;
  d.device = *device;
  d.physical = physical;
  d.instance = instance;
  d.next = next_device;
  reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties>(instance->functions["vkGetPhysicalDeviceMemoryProperties"])(physical,
                                                                                                                        &d.memory);
  VkPhysicalDeviceProperties properties;
  reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(instance->functions["vkGetPhysicalDeviceProperties"])(physical, &properties);
  d.tick_ns = properties.limits.timestampPeriod;
#define LOAD(name) d.name = reinterpret_cast<PFN_##name>(next_device(*device, #name));
  PROBE_FUNCTIONS(LOAD)
#undef LOAD
  if (kLog) {
    say("vkCmdBeginDebugUtilsLabelEXT of the next: %p, vkSetDebugUtilsObjectNameEXT: %p",
        reinterpret_cast<void*>(next_device(*device, "vkCmdBeginDebugUtilsLabelEXT")),
        reinterpret_cast<void*>(d.vkSetDebugUtilsObjectNameEXT));
    say("device %s, driver %u.%u.%u (0x%x), granularity %llu, texel elements %u, memory types %u", properties.deviceName,
        properties.driverVersion >> 22, properties.driverVersion >> 14 & 255, properties.driverVersion >> 6 & 255, properties.driverVersion,
        static_cast<unsigned long long>(properties.limits.bufferImageGranularity), properties.limits.maxTexelBufferElements,
        d.memory.memoryTypeCount);
    for (std::uint32_t i = 0; i < d.memory.memoryTypeCount; ++i)
      say("memory type %u: flags %u, heap %u of %llu MiB", i, d.memory.memoryTypes[i].propertyFlags, d.memory.memoryTypes[i].heapIndex,
          static_cast<unsigned long long>(d.memory.memoryHeaps[d.memory.memoryTypes[i].heapIndex].size >> 20));
  }
  const std::lock_guard lock(global_mutex);
  devices[key_of(*device)] = std::move(made);
  return result;
}

static PFN_vkVoidFunction next_function(VkPhysicalDevice physical, const char* name) {
  InstanceData* instance;
  {
    const std::lock_guard lock(global_mutex);
    instance = instances[key_of(physical)].get();
  }
  return instance->functions[name];
}

static VKAPI_ATTR void VKAPI_CALL probe_GetPhysicalDeviceFeatures2(VkPhysicalDevice physical, VkPhysicalDeviceFeatures2* features) {
  reinterpret_cast<PFN_vkGetPhysicalDeviceFeatures2>(next_function(physical, "vkGetPhysicalDeviceFeatures2"))(physical, features);
  const bool no_int64 = env_int("PROBE_NO_INT64", 0) != 0;
  if (no_int64) features->features.shaderInt64 = VK_FALSE;
  for (auto* next = static_cast<VkBaseOutStructure*>(features->pNext); next; next = next->pNext) {
    if (next->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES) continue;
    if (no_int64) reinterpret_cast<VkPhysicalDeviceVulkan12Features*>(next)->shaderBufferInt64Atomics = VK_FALSE;
  }
}
static VKAPI_ATTR void VKAPI_CALL probe_GetPhysicalDeviceProperties(VkPhysicalDevice physical, VkPhysicalDeviceProperties* properties) {
  reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(next_function(physical, "vkGetPhysicalDeviceProperties"))(physical, properties);
  if (env_int("PROBE_GPU", 0)) properties->deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  if (env_int("PROBE_CPU", 0)) properties->deviceType = VK_PHYSICAL_DEVICE_TYPE_CPU;
  if (const int granularity = env_int("PROBE_GRANULARITY", 0))
    properties->limits.bufferImageGranularity = static_cast<VkDeviceSize>(granularity);
}
static VKAPI_ATTR void VKAPI_CALL probe_GetPhysicalDeviceProperties2(VkPhysicalDevice physical, VkPhysicalDeviceProperties2* properties) {
  reinterpret_cast<PFN_vkGetPhysicalDeviceProperties2>(next_function(physical, "vkGetPhysicalDeviceProperties2"))(physical, properties);
  if (env_int("PROBE_GPU", 0)) properties->properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  if (env_int("PROBE_CPU", 0)) properties->properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_CPU;
  if (const int granularity = env_int("PROBE_GRANULARITY", 0))
    properties->properties.limits.bufferImageGranularity = static_cast<VkDeviceSize>(granularity);
}

static VKAPI_ATTR VkResult VKAPI_CALL probe_CreateInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* a,
                                                           VkInstance* instance) {
  auto* chain = reinterpret_cast<VkLayerInstanceCreateInfo*>(const_cast<void*>(info->pNext));
  while (chain && !(chain->sType == VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO && chain->function == VK_LAYER_LINK_INFO))
    chain = reinterpret_cast<VkLayerInstanceCreateInfo*>(const_cast<void*>(chain->pNext));
  if (!chain) return VK_ERROR_INITIALIZATION_FAILED;
  const auto next = chain->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  chain->u.pLayerInfo = chain->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(next(VK_NULL_HANDLE, "vkCreateInstance"));
  const VkResult result = create(info, a, instance);
  if (result != VK_SUCCESS) return result;
  const std::lock_guard lock(global_mutex);
  auto made = std::make_unique<InstanceData>(InstanceData{*instance, next, {}});
  for (const char* name : {"vkDestroyInstance", "vkCreateDevice", "vkGetPhysicalDeviceFeatures2", "vkGetPhysicalDeviceProperties",
                           "vkGetPhysicalDeviceProperties2", "vkGetPhysicalDeviceMemoryProperties"})
    made->functions[name] = next(*instance, name);
  instances[key_of(*instance)] = std::move(made);
  return result;
}

static VKAPI_ATTR void VKAPI_CALL probe_DestroyInstance(VkInstance instance, const VkAllocationCallbacks* a) {
  PFN_vkDestroyInstance destroy;
  void* key = key_of(instance);
  {
    const std::lock_guard lock(global_mutex);
    destroy = reinterpret_cast<PFN_vkDestroyInstance>(instances[key]->functions["vkDestroyInstance"]);
    instances.erase(key);
  }
  destroy(instance, a);
}

EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL probe_GetDeviceProcAddr(VkDevice device, const char* name);
EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL probe_GetInstanceProcAddr(VkInstance instance, const char* name);

static VKAPI_ATTR void VKAPI_CALL nothing_begins(VkCommandBuffer, const VkDebugUtilsLabelEXT*) {}
static VKAPI_ATTR void VKAPI_CALL nothing_ends(VkCommandBuffer) {}
static VKAPI_ATTR VkResult VKAPI_CALL nothing_is_named(VkDevice, const VkDebugUtilsObjectNameInfoEXT*) {
  return VK_SUCCESS;
}

static PFN_vkVoidFunction device_function(const char* name) {
  // Not null: the loader would put a function of its own there, which calls the driver's. It asks vkGetInstanceProcAddr for these.
  static const bool no_labels = env_int("PROBE_NO_LABELS", 0) != 0;
  if (no_labels && !std::strcmp(name, "vkCmdBeginDebugUtilsLabelEXT")) return reinterpret_cast<PFN_vkVoidFunction>(nothing_begins);
  if (no_labels && !std::strcmp(name, "vkCmdEndDebugUtilsLabelEXT")) return reinterpret_cast<PFN_vkVoidFunction>(nothing_ends);
  if (no_labels && !std::strcmp(name, "vkSetDebugUtilsObjectNameEXT")) return reinterpret_cast<PFN_vkVoidFunction>(nothing_is_named);
#define OURS(function) \
  if (!std::strcmp(name, "vk" #function)) return reinterpret_cast<PFN_vkVoidFunction>(probe_##function)
  OURS(AllocateMemory);
  OURS(CreateBuffer);
  OURS(CreateShaderModule);
  OURS(CreateComputePipelines);
  OURS(CreateGraphicsPipelines);
  OURS(BeginCommandBuffer);
  OURS(CmdBindPipeline);
  OURS(CmdDispatch);
  OURS(CmdDispatchIndirect);
  OURS(CmdDraw);
  OURS(CmdDrawIndexed);
  OURS(CmdDrawIndexedIndirectCount);
  OURS(CmdDrawIndexedIndirect);
  OURS(CmdFillBuffer);
  OURS(CmdUpdateBuffer);
  OURS(CmdCopyBuffer);
  OURS(CmdCopyBufferToImage);
  OURS(CmdCopyImageToBuffer);
  OURS(CmdPipelineBarrier2);
  OURS(CmdBeginRendering);
  OURS(CmdEndRendering);
  OURS(CmdBindDescriptorSets);
  OURS(CmdPushConstants);
  OURS(CmdSetViewport);
  OURS(CmdSetScissor);
  OURS(CmdBindIndexBuffer);
  OURS(CmdBindVertexBuffers);
  OURS(CmdWriteTimestamp2);
  OURS(QueueSubmit2);
  OURS(WaitSemaphores);
  OURS(WaitForFences);
  OURS(QueueWaitIdle);
  OURS(DeviceWaitIdle);
  OURS(DestroyDevice);
  OURS(FreeCommandBuffers);
  OURS(GetBufferDeviceAddress);
  if (!std::strcmp(name, "vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(probe_GetDeviceProcAddr);
  return nullptr;
}

EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL probe_GetDeviceProcAddr(VkDevice device, const char* name) {
  if (PFN_vkVoidFunction ours = device_function(name)) return ours;
  DeviceData* d = device_of(device);
  if (d && d->vkSetDebugUtilsObjectNameEXT && !std::strcmp(name, "vkSetDebugUtilsObjectNameEXT"))
    return reinterpret_cast<PFN_vkVoidFunction>(probe_SetDebugUtilsObjectNameEXT);
  return d ? d->next(device, name) : nullptr;
}

EXPORT VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL probe_GetInstanceProcAddr(VkInstance instance, const char* name) {
  OURS(CreateInstance);
  OURS(DestroyInstance);
  OURS(CreateDevice);
  OURS(GetPhysicalDeviceFeatures2);
  OURS(GetPhysicalDeviceProperties);
  OURS(GetPhysicalDeviceProperties2);
  if (!std::strcmp(name, "vkGetInstanceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(probe_GetInstanceProcAddr);
  if (PFN_vkVoidFunction ours = device_function(name)) return ours;
  if (!instance) return nullptr;
  PFN_vkGetInstanceProcAddr next;
  {
    const std::lock_guard lock(global_mutex);
    next = instances[key_of(instance)]->next;
  }
  return next(instance, name);
}

EXPORT VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
  if (version->loaderLayerInterfaceVersion > 2) version->loaderLayerInterfaceVersion = 2;
  version->pfnGetInstanceProcAddr = probe_GetInstanceProcAddr;
  version->pfnGetDeviceProcAddr = probe_GetDeviceProcAddr;
  version->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}
