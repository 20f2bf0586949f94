// VK_LAYER_COPPICE_probe: finds which command of a frame a GPU hangs in, and reads of memory that nobody has written.
//
//   PROBE_MARKS=1          a timestamp after every command; when a wait lasts, says which command did not end
//   PROBE_SERIAL=1         also a full barrier after every command outside of rendering
//   PROBE_ARGS=1           copies arguments of indirect commands before they run; a dump says them
//   PROBE_TIMEOUT=8        seconds of a wait after which to dump and to exit with 86
//   PROBE_COMPILE_TIMEOUT=120  seconds of one vkCreate*Pipelines after which to dump and to exit with 87
//   PROBE_SKIP=a,b         commands that are not recorded: dispatch dispatchIndirect draw drawIndexed drawIndexedIndirectCount fill update
//                          copy copyImage; or the label of a pipeline: its dispatches and draws are left out (leaf_raster, resolve, ...)
//   PROBE_LOG=1            says pipelines as they are built, submissions, waits of more than 0.5 s
//   PROBE_CPU=1            the driver says that it is a software one: work is dealt out as for that
//   PROBE_NO_INT64=1       no 64-bit atomics: the rasteriser's way in two passes
//   PROBE_LIST=FILE        at the end: every command of the last submission, with the time it took and its arguments
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "layer_calls.h"

namespace {

using layer::Callbacks;
using layer::Functions;
using layer::number_of;

using Clock = std::chrono::steady_clock;

int env_int(const char* name, int fallback) {
  const char* value = std::getenv(name);
  return value ? static_cast<int>(std::strtol(value, nullptr, 0)) : fallback;
}
const bool kMarks = env_int("PROBE_MARKS", 0) != 0, kSerial = env_int("PROBE_SERIAL", 0) != 0, kArgs = env_int("PROBE_ARGS", 0) != 0,
           kLog = env_int("PROBE_LOG", 0) != 0;
const int kTimeout_s = env_int("PROBE_TIMEOUT", 8), kCompileTimeout_s = env_int("PROBE_COMPILE_TIMEOUT", 120);
const char* const kList = std::getenv("PROBE_LIST");
const std::set<std::string> kSkip = [] {
  std::set<std::string> skip;
  const char* value = std::getenv("PROBE_SKIP");
  std::istringstream names(value ? value : "");
  for (std::string name; std::getline(names, name, ',');) skip.insert(name);
  return skip;
}();
/// pipeline: the label of what a dispatch or draw runs
bool skipped(const char* command, const std::string& pipeline = "") {
  return kSkip.contains(command) ||
         std::ranges::any_of(kSkip, [&](const std::string& skip) { return pipeline.find(skip) != std::string::npos; });
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
  std::vector<std::function<void()>> held;  // what a rendering runs at its end
  std::uint32_t mark_count = 0;
  std::uint64_t submission = 0;
};

struct DeviceData : layer::Device {
  VkPhysicalDeviceMemoryProperties memory{};
  float tick_ns = 1;
  std::mutex mutex;
  std::unordered_map<VkCommandBuffer, std::unique_ptr<Recording>> recordings;
  std::map<std::uint64_t, std::string> modules, pipelines, buffers;
  std::uint64_t submissions = 0;
  std::vector<Recording*> submitted;  // newest last
};

// Never destroyed: the watching thread outlives main().
layer::States<layer::Instance>& instances = *new layer::States<layer::Instance>;
layer::States<DeviceData>& devices = *new layer::States<DeviceData>;

// ---- what is being waited for

struct Wait {
  const char* call = nullptr;
  std::string about;
  Clock::time_point since;
  DeviceData* device = nullptr;
  int timeout_s = 0, exit_code = 0;
};
std::mutex& wait_mutex = *new std::mutex;
std::map<std::uint64_t, Wait>& waits = *new std::map<std::uint64_t, Wait>;
std::uint64_t wait_number = 0;

std::string args_text(const Recording& r, const Command& c) {
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
    }
    text += ")";
  }
  return text;
}

/// Time and availability of each mark.
std::vector<std::uint64_t> results_of(DeviceData& d, const Recording& r) {
  std::vector<std::uint64_t> results(2 * r.mark_count);
  NEXT(d, GetQueryPoolResults)
  (d.handle, r.pool, 0, r.mark_count, results.size() * 8, results.data(), 16,
   VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WITH_AVAILABILITY_BIT);
  return results;
}

void dump(DeviceData& d) {
  std::unique_lock lock(d.mutex, std::try_to_lock);
  if (!kMarks) return say("no marks: PROBE_MARKS=1 says which command hangs");
  for (Recording* r : d.submitted) {
    if (r->mark_count == 0) continue;
    const std::vector<std::uint64_t> results = results_of(d, *r);
    std::uint32_t done = 0;
    for (std::uint32_t i = 0; i < r->mark_count; ++i) done += results[2 * i + 1] != 0;
    if (done == r->mark_count) continue;
    say("submission %llu: %u of %u commands have ended", static_cast<unsigned long long>(r->submission), done, r->mark_count);
    const auto has_ended = [&](const Command& c) { return c.mark == ~0u || results[2 * c.mark + 1] != 0; };
    const auto first = static_cast<std::size_t>(std::ranges::find_if_not(r->commands, has_ended) - r->commands.begin());
    const std::size_t from = first > 12 ? first - 12 : 0, to = std::min(first + 9, r->commands.size());
    for (std::size_t i = from; i < to; ++i) {
      const Command& c = r->commands[i];
      say("%s %4zu %s%s", i == first ? ">>>" : has_ended(c) ? "   " : " ? ", i, c.label.c_str(), args_text(*r, c).c_str());
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
    if (kLog && seconds() > 0.5) say("%s%s took %.2f s", call, about.c_str(), seconds());
  }
  double seconds() const { return std::chrono::duration<double>(Clock::now() - since).count(); }
};

void list(DeviceData& d) {
  if (!kList || !kMarks || d.submitted.empty()) return;
  std::FILE* file = std::fopen(kList, "w");
  if (!file) return;
  for (Recording* r : d.submitted) {
    if (r->mark_count == 0) continue;
    const std::vector<std::uint64_t> results = results_of(d, *r);
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

void full_barrier(DeviceData& d, VkCommandBuffer cmd) {
  const VkMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                 .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                 .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                 .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                                 .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT | VK_ACCESS_2_HOST_READ_BIT};
  const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
  NEXT(d, CmdPipelineBarrier2)(cmd, &info);
}

/// The time when all commands before it have ended, as a mark of this one.
void mark(DeviceData& d, Recording& r, Command command) {
  if (!kMarks) return;
  if (r.mark_count < kMaxMarks && r.pool) {
    command.mark = r.mark_count++;
    const auto write = [&d, cmd = r.cmd, pool = r.pool, index = command.mark] {
      NEXT(d, CmdWriteTimestamp2)(cmd, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool, index);
    };
    if (r.rendering)
      r.held.push_back(write);
    else
      write();
  }
  r.commands.push_back(std::move(command));
  if (kSerial && !r.rendering) full_barrier(d, r.cmd);
}

/// Where in r.args the words come to lie; ~0u: nowhere. Outside of rendering, or before one.
std::uint32_t copy_args(DeviceData& d, Recording& r, VkBuffer from, VkDeviceSize offset, std::uint32_t bytes) {
  if (!kArgs || !r.args || r.args_used + bytes > kMaxMarks * kArgBytes) return ~0u;
  const VkBufferCopy region{offset, r.args_used, bytes};
  NEXT(d, CmdCopyBuffer)(r.cmd, from, r.args, 1, &region);
  const std::uint32_t at = r.args_used;
  r.args_used += bytes;
  return at;
}

std::string buffer_name(DeviceData& d, VkBuffer buffer) {
  const std::lock_guard lock(d.mutex);
  const auto found = d.buffers.find(number_of(buffer));
  return found == d.buffers.end() ? "?" : found->second;
}

void begin(DeviceData& d, Recording& r) {
  if (!kMarks) return;
  if (!r.pool) {
    const VkQueryPoolCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = kMaxMarks};
    if (NEXT(d, CreateQueryPool)(d.handle, &info, nullptr, &r.pool) != VK_SUCCESS) say("no query pool");
  }
  if (kArgs && !r.args) {
    const VkBufferCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = kMaxMarks * kArgBytes, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    NEXT(d, CreateBuffer)(d.handle, &info, nullptr, &r.args);
    VkMemoryRequirements needs;
    NEXT(d, GetBufferMemoryRequirements)(d.handle, r.args, &needs);
    VkMemoryAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size};
    constexpr VkMemoryPropertyFlags kWanted = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    for (std::uint32_t i = 0; i < d.memory.memoryTypeCount; ++i)
      if ((needs.memoryTypeBits >> i & 1) && (d.memory.memoryTypes[i].propertyFlags & kWanted) == kWanted) {
        allocate.memoryTypeIndex = i;
        break;
      }
    void* mapped = nullptr;
    if (NEXT(d, AllocateMemory)(d.handle, &allocate, nullptr, &r.args_memory) != VK_SUCCESS ||
        NEXT(d, BindBufferMemory)(d.handle, r.args, r.args_memory, 0) != VK_SUCCESS ||
        NEXT(d, MapMemory)(d.handle, r.args_memory, 0, VK_WHOLE_SIZE, 0, &mapped) != VK_SUCCESS) {
      say("no memory for arguments");
      r.args = VK_NULL_HANDLE;
    }
    r.args_mapped = static_cast<std::uint8_t*>(mapped);
  }
  r.commands.clear();
  r.mark_count = 0;
  r.args_used = 0;
  if (r.args_mapped) std::memset(r.args_mapped, 0xee, kMaxMarks * kArgBytes);
  if (r.pool) NEXT(d, CmdResetQueryPool)(r.cmd, r.pool, 0, kMaxMarks);
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
  for (const Known& known : kKnown)
    if (text.find(known.text) != std::string::npos) return known.label;
  std::uint32_t hash = 2166136261u;
  for (unsigned char c : text) hash = (hash ^ c) * 16777619u;
  char name[40];
  std::snprintf(name, sizeof name, "shader_%08x_%zu", hash, bytes);
  return name;
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

// ---- entry points

#define D(handle) DeviceData& d = devices.of(handle)

VkResult create_buffer(VkDevice device, const VkBufferCreateInfo* info, Callbacks callbacks, VkBuffer* buffer) {
  D(device);
  VkBufferCreateInfo with = *info;
  if (kArgs && (info->usage & VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT)) with.usage |= VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  const VkResult result = NEXT(d, CreateBuffer)(device, &with, callbacks, buffer);
  const std::lock_guard lock(d.mutex);
  if (result == VK_SUCCESS) d.buffers[number_of(*buffer)] = std::to_string(info->size) + "B";
  return result;
}

VkDeviceAddress get_buffer_device_address(VkDevice device, const VkBufferDeviceAddressInfo* info) {
  D(device);
  const VkDeviceAddress address = NEXT(d, GetBufferDeviceAddress)(device, info);
  if (kLog) say("address 0x%llx of buffer %s", static_cast<unsigned long long>(address), buffer_name(d, info->buffer).c_str());
  return address;
}

VkResult set_object_name(VkDevice device, const VkDebugUtilsObjectNameInfoEXT* info) {
  D(device);
  if (info->pObjectName && info->objectType == VK_OBJECT_TYPE_BUFFER) {
    const std::lock_guard lock(d.mutex);
    d.buffers[info->objectHandle] = info->pObjectName;
  }
  return NEXT(d, SetDebugUtilsObjectNameEXT)(device, info);
}

VkResult create_shader_module(VkDevice device, const VkShaderModuleCreateInfo* info, Callbacks callbacks, VkShaderModule* module) {
  D(device);
  const VkResult result = NEXT(d, CreateShaderModule)(device, info, callbacks, module);
  if (result != VK_SUCCESS) return result;
  const std::string label = label_of(info->pCode, info->codeSize);
  const std::lock_guard lock(d.mutex);
  d.modules[number_of(*module)] = label;
  return result;
}

std::string stage_label(DeviceData& d, const VkPipelineShaderStageCreateInfo& stage) {
  const std::lock_guard lock(d.mutex);
  return d.modules[number_of(stage.module)] + constants_text(stage.pSpecializationInfo);
}

std::string pipeline_label(DeviceData& d, const VkComputePipelineCreateInfo& info) {
  return stage_label(d, info.stage);
}

std::string pipeline_label(DeviceData& d, const VkGraphicsPipelineCreateInfo& info) {
  std::string label;
  for (std::uint32_t i = 0; i < info.stageCount; ++i) label += (i ? "+" : "") + stage_label(d, info.pStages[i]);
  return label;
}

template <class Info, class Create>
VkResult create_pipelines(DeviceData& d, Create create, VkPipelineCache cache, std::uint32_t count, const Info* infos, Callbacks callbacks,
                          VkPipeline* pipelines) {
  constexpr bool kIsCompute = std::is_same_v<Info, VkComputePipelineCreateInfo>;
  const std::string first = " of " + pipeline_label(d, infos[0]);
  VkResult result;
  {
    const Waiting waiting(&d, kIsCompute ? "vkCreateComputePipelines" : "vkCreateGraphicsPipelines", kCompileTimeout_s, 87, first);
    result = create(d.handle, cache, count, infos, callbacks, pipelines);
    if (kLog) say("%s pipeline%s: %d, %.2f s", kIsCompute ? "compute" : "graphics", first.c_str(), result, waiting.seconds());
  }
  for (std::uint32_t i = 0; i < count && result == VK_SUCCESS; ++i) {
    const std::string label = pipeline_label(d, infos[i]);
    const std::lock_guard lock(d.mutex);
    d.pipelines[number_of(pipelines[i])] = label;
  }
  return result;
}
VkResult create_compute_pipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count, const VkComputePipelineCreateInfo* infos,
                                  Callbacks callbacks, VkPipeline* pipelines) {
  D(device);
  return create_pipelines(d, NEXT(d, CreateComputePipelines), cache, count, infos, callbacks, pipelines);
}
VkResult create_graphics_pipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count, const VkGraphicsPipelineCreateInfo* infos,
                                   Callbacks callbacks, VkPipeline* pipelines) {
  D(device);
  return create_pipelines(d, NEXT(d, CreateGraphicsPipelines), cache, count, infos, callbacks, pipelines);
}

VkResult begin_command_buffer(VkCommandBuffer cmd, const VkCommandBufferBeginInfo* info) {
  D(cmd);
  const VkResult result = NEXT(d, BeginCommandBuffer)(cmd, info);
  if (result == VK_SUCCESS) begin(d, recording(d, cmd));
  return result;
}

void bind_pipeline(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipeline pipeline) {
  D(cmd);
  Recording& r = recording(d, cmd);
  {
    const std::lock_guard lock(d.mutex);
    (point == VK_PIPELINE_BIND_POINT_COMPUTE ? r.compute : r.graphics) = d.pipelines[number_of(pipeline)];
  }
  record(r, [&d, cmd, point, pipeline] { NEXT(d, CmdBindPipeline)(cmd, point, pipeline); });
}

void dispatch(VkCommandBuffer cmd, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("dispatch", r.compute)) return;
  NEXT(d, CmdDispatch)(cmd, x, y, z);
  mark(d, r, {"dispatch " + r.compute + " " + std::to_string(x) + "x" + std::to_string(y) + "x" + std::to_string(z)});
}

void dispatch_indirect(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("dispatchIndirect", r.compute)) return;
  Command command{"dispatchIndirect " + r.compute + " @" + std::to_string(offset)};
  if (kArgs && kMarks) {
    full_barrier(d, cmd);
    command.arg_offset = copy_args(d, r, buffer, offset, 12);
    command.arg_words = 3;
    full_barrier(d, cmd);
  }
  NEXT(d, CmdDispatchIndirect)(cmd, buffer, offset);
  mark(d, r, std::move(command));
}

void draw(VkCommandBuffer cmd, std::uint32_t vertices, std::uint32_t instances, std::uint32_t first_vertex, std::uint32_t first_instance) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("draw", r.graphics)) return;
  record(r, [=, &d] { NEXT(d, CmdDraw)(cmd, vertices, instances, first_vertex, first_instance); });
  mark(d, r, {"draw " + r.graphics + " " + std::to_string(vertices) + " x " + std::to_string(instances)});
}

void draw_indexed(VkCommandBuffer cmd, std::uint32_t indices, std::uint32_t instances, std::uint32_t first_index,
                  std::int32_t vertex_offset, std::uint32_t first_instance) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("drawIndexed", r.graphics)) return;
  record(r, [=, &d] { NEXT(d, CmdDrawIndexed)(cmd, indices, instances, first_index, vertex_offset, first_instance); });
  mark(d, r, {"drawIndexed " + r.graphics + " " + std::to_string(indices) + " x " + std::to_string(instances)});
}

void draw_indexed_indirect_count(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, VkBuffer count_buffer,
                                 VkDeviceSize count_offset, std::uint32_t max_count, std::uint32_t stride) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("drawIndexedIndirectCount", r.graphics)) return;
  Command command{"drawIndexedIndirectCount " + r.graphics + " @" + std::to_string(offset) + " count@" + std::to_string(count_offset)};
  command.max_count = max_count;
  if (kArgs && kMarks) {
    command.count_offset = copy_args(d, r, count_buffer, count_offset, 4);
    command.arg_offset = copy_args(d, r, buffer, offset, 20);
    command.arg_words = 5;
  }
  record(r, [=, &d] { NEXT(d, CmdDrawIndexedIndirectCount)(cmd, buffer, offset, count_buffer, count_offset, max_count, stride); });
  mark(d, r, std::move(command));
}

void draw_indexed_indirect(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, std::uint32_t count, std::uint32_t stride) {
  D(cmd);
  Recording& r = recording(d, cmd);
  if (skipped("drawIndexedIndirect", r.graphics)) return;
  Command command{"drawIndexedIndirect " + r.graphics + " " + std::to_string(count)};
  if (kArgs && kMarks) {
    command.arg_offset = copy_args(d, r, buffer, offset, 20);
    command.arg_words = 5;
  }
  record(r, [=, &d] { NEXT(d, CmdDrawIndexedIndirect)(cmd, buffer, offset, count, stride); });
  mark(d, r, std::move(command));
}

void fill_buffer(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size, std::uint32_t data) {
  D(cmd);
  if (skipped("fill")) return;
  NEXT(d, CmdFillBuffer)(cmd, buffer, offset, size, data);
  mark(d, recording(d, cmd), {"fill " + buffer_name(d, buffer) + " " + std::to_string(size)});
}

void update_buffer(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size, const void* data) {
  D(cmd);
  if (skipped("update")) return;
  NEXT(d, CmdUpdateBuffer)(cmd, buffer, offset, size, data);
  mark(d, recording(d, cmd), {"update " + buffer_name(d, buffer) + " " + std::to_string(size)});
}

void copy_buffer(VkCommandBuffer cmd, VkBuffer from, VkBuffer to, std::uint32_t count, const VkBufferCopy* regions) {
  D(cmd);
  if (skipped("copy")) return;
  NEXT(d, CmdCopyBuffer)(cmd, from, to, count, regions);
  std::uint64_t bytes = 0;
  for (std::uint32_t i = 0; i < count; ++i) bytes += regions[i].size;
  mark(d, recording(d, cmd), {"copy " + buffer_name(d, from) + " to " + buffer_name(d, to) + " " + std::to_string(bytes)});
}

void copy_buffer_to_image(VkCommandBuffer cmd, VkBuffer from, VkImage to, VkImageLayout layout, std::uint32_t count,
                          const VkBufferImageCopy* regions) {
  D(cmd);
  if (skipped("copyImage")) return;
  NEXT(d, CmdCopyBufferToImage)(cmd, from, to, layout, count, regions);
  const VkExtent3D& size = regions[0].imageExtent;
  mark(d, recording(d, cmd), {"copyBufferToImage " + std::to_string(size.width) + "x" + std::to_string(size.height)});
}

void copy_image_to_buffer(VkCommandBuffer cmd, VkImage from, VkImageLayout layout, VkBuffer to, std::uint32_t count,
                          const VkBufferImageCopy* regions) {
  D(cmd);
  NEXT(d, CmdCopyImageToBuffer)(cmd, from, layout, to, count, regions);
  mark(d, recording(d, cmd), {"copyImageToBuffer"});
}

void pipeline_barrier(VkCommandBuffer cmd, const VkDependencyInfo* info) {
  D(cmd);
  NEXT(d, CmdPipelineBarrier2)(cmd, info);
  mark(d, recording(d, cmd), {info->imageMemoryBarrierCount ? "barrier of an image" : "barrier"});
}

void begin_rendering(VkCommandBuffer cmd, const VkRenderingInfo* info) {
  D(cmd);
  if (!kMarks) return NEXT(d, CmdBeginRendering)(cmd, info);
  Recording& r = recording(d, cmd);
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
  r.held.push_back([&d, cmd, copy] { NEXT(d, CmdBeginRendering)(cmd, &copy->info); });
  const VkExtent2D& size = info->renderArea.extent;
  mark(d, r,
       {"beginRendering " + std::to_string(size.width) + "x" + std::to_string(size.height) + " colours " +
        std::to_string(info->colorAttachmentCount) + (info->pDepthAttachment ? " depth" : "")});
}

void end_rendering(VkCommandBuffer cmd) {
  D(cmd);
  if (!kMarks) return NEXT(d, CmdEndRendering)(cmd);
  Recording& r = recording(d, cmd);
  if (kArgs) full_barrier(d, cmd);
  for (const auto& call : r.held) call();
  r.held.clear();
  r.rendering = false;
  NEXT(d, CmdEndRendering)(cmd);
  mark(d, r, {"endRendering"});
}

/// For commands that are held: what they point to.
template <class T>
std::vector<T> copied(const T* first, std::uint32_t count) {
  return {first, first + count};
}

void bind_descriptor_sets(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipelineLayout layout, std::uint32_t first, std::uint32_t count,
                          const VkDescriptorSet* sets, std::uint32_t dynamic_count, const std::uint32_t* dynamic) {
  D(cmd);
  record(recording(d, cmd), [=, &d, sets = copied(sets, count), dynamic = copied(dynamic, dynamic_count)] {
    NEXT(d, CmdBindDescriptorSets)(cmd, point, layout, first, count, sets.data(), dynamic_count, dynamic.data());
  });
}

void push_constants(VkCommandBuffer cmd, VkPipelineLayout layout, VkShaderStageFlags stages, std::uint32_t offset, std::uint32_t size,
                    const void* values) {
  D(cmd);
  record(recording(d, cmd), [=, &d, values = copied(static_cast<const std::uint8_t*>(values), size)] {
    NEXT(d, CmdPushConstants)(cmd, layout, stages, offset, size, values.data());
  });
}

void set_viewport(VkCommandBuffer cmd, std::uint32_t first, std::uint32_t count, const VkViewport* viewports) {
  D(cmd);
  record(recording(d, cmd), [=, &d, viewports = copied(viewports, count)] {
    NEXT(d, CmdSetViewport)(cmd, first, count, viewports.data());
  });
}

void set_scissor(VkCommandBuffer cmd, std::uint32_t first, std::uint32_t count, const VkRect2D* scissors) {
  D(cmd);
  record(recording(d, cmd), [=, &d, scissors = copied(scissors, count)] { NEXT(d, CmdSetScissor)(cmd, first, count, scissors.data()); });
}

void bind_vertex_buffers(VkCommandBuffer cmd, std::uint32_t first, std::uint32_t count, const VkBuffer* buffers,
                         const VkDeviceSize* offsets) {
  D(cmd);
  record(recording(d, cmd), [=, &d, buffers = copied(buffers, count), offsets = copied(offsets, count)] {
    NEXT(d, CmdBindVertexBuffers)(cmd, first, count, buffers.data(), offsets.data());
  });
}

VkResult queue_submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo2* submits, VkFence fence) {
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
  return NEXT(d, QueueSubmit2)(queue, count, submits, fence);
}

template <class Call>
VkResult watched(DeviceData& d, const char* name, const Call& call) {
  const Waiting waiting(&d, name, kTimeout_s, 86);
  const VkResult result = call();
  if (result == VK_ERROR_DEVICE_LOST) {
    say("DEVICE LOST in %s", name);
    dump(d);
  }
  return result;
}

VkResult wait_semaphores(VkDevice device, const VkSemaphoreWaitInfo* info, std::uint64_t timeout) {
  D(device);
  return watched(d, "vkWaitSemaphores", [&] { return NEXT(d, WaitSemaphores)(device, info, timeout); });
}
VkResult wait_for_fences(VkDevice device, std::uint32_t count, const VkFence* fences, VkBool32 all, std::uint64_t timeout) {
  D(device);
  const VkResult result = watched(d, "vkWaitForFences", [&] { return NEXT(d, WaitForFences)(device, count, fences, all, timeout); });
  list(d);
  return result;
}
VkResult queue_wait_idle(VkQueue queue) {
  D(queue);
  return watched(d, "vkQueueWaitIdle", [&] { return NEXT(d, QueueWaitIdle)(queue); });
}
VkResult device_wait_idle(VkDevice device) {
  D(device);
  const VkResult result = watched(d, "vkDeviceWaitIdle", [&] { return NEXT(d, DeviceWaitIdle)(device); });
  list(d);
  return result;
}

void free_recording(DeviceData& d, Recording& r) {
  if (r.pool) NEXT(d, DestroyQueryPool)(d.handle, r.pool, nullptr);
  if (r.args) NEXT(d, DestroyBuffer)(d.handle, r.args, nullptr);
  if (r.args_memory) NEXT(d, FreeMemory)(d.handle, r.args_memory, nullptr);
}

void free_command_buffers(VkDevice device, VkCommandPool pool, std::uint32_t count, const VkCommandBuffer* buffers) {
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
  NEXT(d, FreeCommandBuffers)(device, pool, count, buffers);
}

void destroy_device(VkDevice device, Callbacks callbacks) {
  const auto d = devices.take(device);
  for (auto& [cmd, r] : d->recordings) free_recording(*d, *r);
  NEXT(*d, DestroyDevice)(device, callbacks);
}

void say_device(const DeviceData& d, const VkPhysicalDeviceProperties& properties) {
  say("vkCmdBeginDebugUtilsLabelEXT of the next: %p, vkSetDebugUtilsObjectNameEXT: %p",
      reinterpret_cast<void*>(NEXT(d, CmdBeginDebugUtilsLabelEXT)), reinterpret_cast<void*>(NEXT(d, SetDebugUtilsObjectNameEXT)));
  say("device %s, driver %u.%u.%u (0x%x), granularity %llu, texel elements %u, memory types %u", properties.deviceName,
      properties.driverVersion >> 22, properties.driverVersion >> 14 & 255, properties.driverVersion >> 6 & 255, properties.driverVersion,
      static_cast<unsigned long long>(properties.limits.bufferImageGranularity), properties.limits.maxTexelBufferElements,
      d.memory.memoryTypeCount);
  for (std::uint32_t i = 0; i < d.memory.memoryTypeCount; ++i)
    say("memory type %u: flags %u, heap %u of %llu MiB", i, d.memory.memoryTypes[i].propertyFlags, d.memory.memoryTypes[i].heapIndex,
        static_cast<unsigned long long>(d.memory.memoryHeaps[d.memory.memoryTypes[i].heapIndex].size >> 20));
}

VkResult create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info, Callbacks callbacks, VkDevice* device) {
  const layer::Instance& instance = instances.of(physical);
  auto made = std::make_unique<DeviceData>();
  if (const VkResult result = made->create(instance, physical, info, callbacks, device); result != VK_SUCCESS) return result;
  instance.get_physical_device_memory_properties(physical, &made->memory);
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  instance.get_physical_device_properties2(physical, &properties);
  made->tick_ns = properties.properties.limits.timestampPeriod;
  if (kLog) say_device(*made, properties.properties);
  devices.add(*device, std::move(made));
  return VK_SUCCESS;
}

void get_physical_device_features2(VkPhysicalDevice physical, VkPhysicalDeviceFeatures2* features) {
  instances.of(physical).get_physical_device_features2(physical, features);
  if (!env_int("PROBE_NO_INT64", 0)) return;
  features->features.shaderInt64 = VK_FALSE;
  for (auto* next = static_cast<VkBaseOutStructure*>(features->pNext); next; next = next->pNext)
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES)
      reinterpret_cast<VkPhysicalDeviceVulkan12Features*>(next)->shaderBufferInt64Atomics = VK_FALSE;
}

void get_physical_device_properties2(VkPhysicalDevice physical, VkPhysicalDeviceProperties2* properties) {
  instances.of(physical).get_physical_device_properties2(physical, properties);
  if (env_int("PROBE_CPU", 0)) properties->properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_CPU;
}
void get_physical_device_properties(VkPhysicalDevice physical, VkPhysicalDeviceProperties* properties) {
  VkPhysicalDeviceProperties2 chain{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  get_physical_device_properties2(physical, &chain);
  *properties = chain.properties;
}

VkResult create_instance(const VkInstanceCreateInfo* info, Callbacks callbacks, VkInstance* instance) {
  auto made = std::make_unique<layer::Instance>();
  const VkResult result = made->create(info, callbacks, instance);
  if (result == VK_SUCCESS) instances.add(*instance, std::move(made));
  return result;
}

void destroy_instance(VkInstance instance, Callbacks callbacks) {
  instances.take(instance)->destroy_instance(instance, callbacks);
}

// ---- names

// A command that points to nothing.
#define HELD(call)                                                            \
  OURS(call, [](VkCommandBuffer cmd, auto... arguments) {                     \
    D(cmd);                                                                   \
    record(recording(d, cmd), [=, &d] { NEXT(d, call)(cmd, arguments...); }); \
  })

PFN_vkVoidFunction get_device_proc_addr(VkDevice device, const char* name);

PFN_vkVoidFunction device_function(const char* name) {
  static const Functions ours{OURS(CreateBuffer, create_buffer),
                              OURS(CreateShaderModule, create_shader_module),
                              OURS(CreateComputePipelines, create_compute_pipelines),
                              OURS(CreateGraphicsPipelines, create_graphics_pipelines),
                              OURS(BeginCommandBuffer, begin_command_buffer),
                              OURS(CmdBindPipeline, bind_pipeline),
                              OURS(CmdDispatch, dispatch),
                              OURS(CmdDispatchIndirect, dispatch_indirect),
                              OURS(CmdDraw, draw),
                              OURS(CmdDrawIndexed, draw_indexed),
                              OURS(CmdDrawIndexedIndirectCount, draw_indexed_indirect_count),
                              OURS(CmdDrawIndexedIndirect, draw_indexed_indirect),
                              OURS(CmdFillBuffer, fill_buffer),
                              OURS(CmdUpdateBuffer, update_buffer),
                              OURS(CmdCopyBuffer, copy_buffer),
                              OURS(CmdCopyBufferToImage, copy_buffer_to_image),
                              OURS(CmdCopyImageToBuffer, copy_image_to_buffer),
                              OURS(CmdPipelineBarrier2, pipeline_barrier),
                              OURS(CmdBeginRendering, begin_rendering),
                              OURS(CmdEndRendering, end_rendering),
                              OURS(CmdBindDescriptorSets, bind_descriptor_sets),
                              OURS(CmdPushConstants, push_constants),
                              OURS(CmdSetViewport, set_viewport),
                              OURS(CmdSetScissor, set_scissor),
                              HELD(CmdBindIndexBuffer),
                              OURS(CmdBindVertexBuffers, bind_vertex_buffers),
                              HELD(CmdWriteTimestamp2),
                              OURS(QueueSubmit2, queue_submit),
                              OURS(WaitSemaphores, wait_semaphores),
                              OURS(WaitForFences, wait_for_fences),
                              OURS(QueueWaitIdle, queue_wait_idle),
                              OURS(DeviceWaitIdle, device_wait_idle),
                              OURS(DestroyDevice, destroy_device),
                              OURS(FreeCommandBuffers, free_command_buffers),
                              OURS(GetBufferDeviceAddress, get_buffer_device_address),
                              OURS(GetDeviceProcAddr, get_device_proc_addr)};
  return layer::find_function(ours, name);
}

PFN_vkVoidFunction get_device_proc_addr(VkDevice device, const char* name) {
  if (const PFN_vkVoidFunction ours = device_function(name)) return ours;
  const DeviceData& d = devices.of(device);
  const PFN_vkVoidFunction next = d.next(device, name);
  const bool names_object = std::string_view(name) == "vkSetDebugUtilsObjectNameEXT";
  return next && names_object ? reinterpret_cast<PFN_vkVoidFunction>(set_object_name) : next;
}

PFN_vkVoidFunction get_instance_proc_addr(VkInstance instance, const char* name) {
  static const Functions ours{OURS(CreateInstance, create_instance),
                              OURS(DestroyInstance, destroy_instance),
                              OURS(CreateDevice, create_device),
                              OURS(GetPhysicalDeviceFeatures2, get_physical_device_features2),
                              OURS(GetPhysicalDeviceProperties, get_physical_device_properties),
                              OURS(GetPhysicalDeviceProperties2, get_physical_device_properties2),
                              OURS(GetInstanceProcAddr, get_instance_proc_addr)};
  if (const PFN_vkVoidFunction function = layer::find_function(ours, name)) return function;
  if (const PFN_vkVoidFunction function = device_function(name)) return function;
  return instance ? instances.of(instance).next(instance, name) : nullptr;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) VkResult vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
  return layer::negotiate(version, get_instance_proc_addr, get_device_proc_addr);
}
