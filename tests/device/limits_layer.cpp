// VK_LAYER_COPPICE_limits: a driver of one memory type, such as lavapipe, reports the limits, memory and missing features of another device
// and refuses what that would refuse. Each refusal is a line on standard error that begins with "limits_layer refuses".
//
//   COPPICE_TEST_DEVICE=NAME   a row of device_rows.cpp; without it the driver stays as it is
//   COPPICE_TEST_FILL=0xFF     every new allocation is filled with this byte
//   COPPICE_TEST_LATE=1        nothing that is submitted runs before it is waited for
//   COPPICE_TEST_REVERSE=1     dispatches, copies and fills that no barrier parts run in reverse
//
// Memory that is not coherent is a copy beside the driver's: only flushes and invalidations carry bytes from one to the other. The layer
// stands below the validation layer, which holds the program to all other limits and features that are reported.

#include <algorithm>
#include <cinttypes>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "device_rows.h"
#include "layer_state.h"

namespace limits_layer {

void refuse(const DeviceRow& row, const char* format, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  std::fprintf(stderr, "limits_layer refuses, as %s: %s\n", row.name, text);
}

namespace {

using coppice::test::for_each_missing;
using coppice::test::lacks_extension;
using coppice::test::lower;
using coppice::test::tighten;

/// Says so if it is not.
bool within(const DeviceRow& row, const char* what, std::uint64_t value, std::uint64_t most) {
  if (value <= most) return true;
  refuse(row, "%s %" PRIu64 ", at most %" PRIu64, what, value, most);
  return false;
}

// ---- What is reported

void get_physical_device_features2(VkPhysicalDevice physical, VkPhysicalDeviceFeatures2* features) {
  const Instance& instance = instance_of(physical);
  instance.get_physical_device_features2(physical, features);
  for_each_missing(*instance.row, *features, [](const char*, VkBool32& present) { present = VK_FALSE; });
}

void get_physical_device_features(VkPhysicalDevice physical, VkPhysicalDeviceFeatures* features) {
  VkPhysicalDeviceFeatures2 chain{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  get_physical_device_features2(physical, &chain);
  *features = chain.features;
}

void get_physical_device_properties2(VkPhysicalDevice physical, VkPhysicalDeviceProperties2* properties) {
  const Instance& instance = instance_of(physical);
  const DeviceRow& row = *instance.row;
  instance.get_physical_device_properties2(physical, properties);
  tighten(properties->properties.limits, row);
  if (row.type != VK_PHYSICAL_DEVICE_TYPE_MAX_ENUM) properties->properties.deviceType = row.type;
  const std::uint32_t size = row.subgroup_size;
  for (auto* next = static_cast<VkBaseOutStructure*>(properties->pNext); next != nullptr; next = next->pNext) {
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES) {
      auto& vulkan11 = *reinterpret_cast<VkPhysicalDeviceVulkan11Properties*>(next);
      if (size != 0) vulkan11.subgroupSize = size;
      lower(vulkan11.maxMemoryAllocationSize, row.max_allocation_bytes);
    } else if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES) {
      if (size != 0) reinterpret_cast<VkPhysicalDeviceSubgroupProperties*>(next)->subgroupSize = size;
    } else if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES) {
      lower(reinterpret_cast<VkPhysicalDeviceMaintenance3Properties*>(next)->maxMemoryAllocationSize, row.max_allocation_bytes);
    }
  }
}

void get_physical_device_properties(VkPhysicalDevice physical, VkPhysicalDeviceProperties* properties) {
  VkPhysicalDeviceProperties2 chain{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  get_physical_device_properties2(physical, &chain);
  *properties = chain.properties;
}

void get_physical_device_memory_properties(VkPhysicalDevice physical, VkPhysicalDeviceMemoryProperties* memory) {
  const Instance& instance = instance_of(physical);
  instance.get_physical_device_memory_properties(physical, memory);
  *memory = tighten(*memory, *instance.row);
}

void get_physical_device_memory_properties2(VkPhysicalDevice physical, VkPhysicalDeviceMemoryProperties2* memory) {
  get_physical_device_memory_properties(physical, &memory->memoryProperties);
}

VkResult enumerate_device_extension_properties(VkPhysicalDevice physical, const char* layer, std::uint32_t* count,
                                               VkExtensionProperties* properties) {
  const Instance& instance = instance_of(physical);
  if (layer != nullptr) return instance.enumerate_device_extension_properties(physical, layer, count, properties);
  std::uint32_t all_count = 0;
  instance.enumerate_device_extension_properties(physical, nullptr, &all_count, nullptr);
  std::vector<VkExtensionProperties> all(all_count);
  instance.enumerate_device_extension_properties(physical, nullptr, &all_count, all.data());
  std::erase_if(all, [&](const VkExtensionProperties& extension) { return lacks_extension(*instance.row, extension.extensionName); });
  const auto most = static_cast<std::uint32_t>(all.size());
  if (properties == nullptr) {
    *count = most;
    return VK_SUCCESS;
  }
  *count = std::min(*count, most);
  std::copy_n(all.begin(), *count, properties);
  return *count < most ? VK_INCOMPLETE : VK_SUCCESS;
}

// ---- Memory

bool has(const Device& device, std::uint32_t type, VkMemoryPropertyFlags flags) {
  return (device.memory.memoryTypes[type].propertyFlags & flags) == flags;
}

VkResult allocate_memory(VkDevice handle, const VkMemoryAllocateInfo* info, Callbacks callbacks, VkDeviceMemory* memory) {
  Device& device = device_of(handle);
  const DeviceRow& row = *device.instance->row;
  const std::lock_guard lock(device.mutex);
  const std::uint32_t type = info->memoryTypeIndex;
  if (!within(row, "memory type", type + 1, device.memory.memoryTypeCount)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  const std::uint32_t heap = device.memory.memoryTypes[type].heapIndex;
  if (!within(row, "bytes of an allocation", info->allocationSize, device.max_allocation_bytes) ||
      !within(row, "bytes allocated of a heap", device.heap_bytes[heap] + info->allocationSize, device.memory.memoryHeaps[heap].size))
    return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  if (!within(row, "allocations", device.allocations.size() + 1, device.limits.maxMemoryAllocationCount)) return VK_ERROR_TOO_MANY_OBJECTS;
  VkMemoryAllocateInfo real = *info;
  real.memoryTypeIndex = 0;
  if (const VkResult result = NEXT(device, AllocateMemory)(handle, &real, callbacks, memory); result != VK_SUCCESS) return result;
  Allocation made{.bytes = info->allocationSize, .type = type};
  void* mapped = nullptr;
  if (const VkResult result = NEXT(device, MapMemory)(handle, *memory, 0, VK_WHOLE_SIZE, 0, &mapped); result != VK_SUCCESS) {
    NEXT(device, FreeMemory)(handle, *memory, callbacks);
    return result;
  }
  made.real = static_cast<std::uint8_t*>(mapped);
  if (device.instance->fill) std::memset(made.real, *device.instance->fill, made.bytes);
  // What nobody has flushed or invalidated is neither 0 nor what the other side has.
  if (has(device, type, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) && !has(device, type, VK_MEMORY_PROPERTY_HOST_COHERENT_BIT))
    made.shadow.assign(made.bytes, static_cast<std::uint8_t>(~device.instance->fill.value_or(0x5a)));
  device.heap_bytes[heap] += made.bytes;
  device.allocations[*memory] = std::move(made);
  return VK_SUCCESS;
}

void free_memory(VkDevice handle, VkDeviceMemory memory, Callbacks callbacks) {
  Device& device = device_of(handle);
  const std::lock_guard lock(device.mutex);
  if (const auto found = device.allocations.find(memory); found != device.allocations.end()) {
    device.heap_bytes[device.memory.memoryTypes[found->second.type].heapIndex] -= found->second.bytes;
    device.allocations.erase(found);
  }
  NEXT(device, FreeMemory)(handle, memory, callbacks);
}

VkResult map_memory(VkDevice handle, VkDeviceMemory memory, VkDeviceSize offset, VkDeviceSize, VkMemoryMapFlags, void** data) {
  Device& device = device_of(handle);
  const std::lock_guard lock(device.mutex);
  Allocation& allocation = device.allocations.at(memory);
  if (!has(device, allocation.type, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)) {
    refuse(*device.instance->row, "mapping memory of type %u, which is not host-visible", allocation.type);
    return VK_ERROR_MEMORY_MAP_FAILED;
  }
  *data = (allocation.shadow.empty() ? allocation.real : allocation.shadow.data()) + offset;
  return VK_SUCCESS;
}

// The driver's stays mapped.
void unmap_memory(VkDevice, VkDeviceMemory) {}

enum class Way { to_device, to_host };

VkResult carry(VkDevice handle, std::uint32_t count, const VkMappedMemoryRange* ranges, Way way) {
  Device& device = device_of(handle);
  const std::lock_guard lock(device.mutex);
  for (const VkMappedMemoryRange& range : std::vector(ranges, ranges + count)) {
    Allocation& allocation = device.allocations.at(range.memory);
    const VkDeviceSize atom = device.limits.nonCoherentAtomSize;
    const VkDeviceSize end = range.size == VK_WHOLE_SIZE ? allocation.bytes : range.offset + range.size;
    if (range.offset % atom != 0 || (end % atom != 0 && end != allocation.bytes) || end > allocation.bytes || range.offset > end) {
      refuse(*device.instance->row, "a mapped range from byte %" PRIu64 " to %" PRIu64 " of %" PRIu64 ", atoms of %" PRIu64, range.offset,
             end, allocation.bytes, atom);
      return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    if (allocation.shadow.empty()) continue;
    std::uint8_t* real = allocation.real + range.offset;
    std::uint8_t* shadow = allocation.shadow.data() + range.offset;
    std::memcpy(way == Way::to_device ? real : shadow, way == Way::to_device ? shadow : real, end - range.offset);
  }
  return VK_SUCCESS;
}

VkResult flush_mapped_memory_ranges(VkDevice handle, std::uint32_t count, const VkMappedMemoryRange* ranges) {
  return carry(handle, count, ranges, Way::to_device);
}

VkResult invalidate_mapped_memory_ranges(VkDevice handle, std::uint32_t count, const VkMappedMemoryRange* ranges) {
  return carry(handle, count, ranges, Way::to_host);
}

// ---- Buffers and images

VkResult create_image(VkDevice handle, const VkImageCreateInfo* info, Callbacks callbacks, VkImage* image) {
  Device& device = device_of(handle);
  const VkResult result = NEXT(device, CreateImage)(handle, info, callbacks, image);
  const std::lock_guard lock(device.mutex);
  if (result == VK_SUCCESS) device.optimal_images[*image] = info->tiling == VK_IMAGE_TILING_OPTIMAL;
  return result;
}

bool is_optimal(Device& device, VkImage image) {
  const std::lock_guard lock(device.mutex);
  const auto found = device.optimal_images.find(image);
  return found == device.optimal_images.end() || found->second;
}

void as_of_row(const Device& device, VkMemoryRequirements& needs, bool optimal) {
  const DeviceRow& row = *device.instance->row;
  const std::uint32_t all = (1u << device.memory.memoryTypeCount) - 1;
  needs.memoryTypeBits = all & (optimal ? row.image_types : row.buffer_types);
  if (!optimal) return;
  needs.alignment = std::max(needs.alignment, row.image_alignment_bytes);
  needs.size = (needs.size + needs.alignment - 1) / needs.alignment * needs.alignment;
}

void get_buffer_memory_requirements2(VkDevice handle, const VkBufferMemoryRequirementsInfo2* info, VkMemoryRequirements2* needs) {
  Device& device = device_of(handle);
  NEXT(device, GetBufferMemoryRequirements2)(handle, info, needs);
  as_of_row(device, needs->memoryRequirements, false);
}

void get_buffer_memory_requirements(VkDevice handle, VkBuffer buffer, VkMemoryRequirements* needs) {
  const VkBufferMemoryRequirementsInfo2 info{.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_REQUIREMENTS_INFO_2, .buffer = buffer};
  VkMemoryRequirements2 chain{.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
  get_buffer_memory_requirements2(handle, &info, &chain);
  *needs = chain.memoryRequirements;
}

void get_image_memory_requirements2(VkDevice handle, const VkImageMemoryRequirementsInfo2* info, VkMemoryRequirements2* needs) {
  Device& device = device_of(handle);
  NEXT(device, GetImageMemoryRequirements2)(handle, info, needs);
  as_of_row(device, needs->memoryRequirements, is_optimal(device, info->image));
}

void get_image_memory_requirements(VkDevice handle, VkImage image, VkMemoryRequirements* needs) {
  const VkImageMemoryRequirementsInfo2 info{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_REQUIREMENTS_INFO_2, .image = image};
  VkMemoryRequirements2 chain{.sType = VK_STRUCTURE_TYPE_MEMORY_REQUIREMENTS_2};
  get_image_memory_requirements2(handle, &info, &chain);
  *needs = chain.memoryRequirements;
}

/// What one may not bind: memory of a type or at an offset that the row does not allow, or a page of bufferImageGranularity that buffers
/// and optimal images share.
void check_bound(Device& device, VkDeviceMemory memory, const Bound& bound, const VkMemoryRequirements& needs) {
  const DeviceRow& row = *device.instance->row;
  const std::lock_guard lock(device.mutex);
  Allocation& allocation = device.allocations.at(memory);
  if ((needs.memoryTypeBits >> allocation.type & 1u) == 0) refuse(row, "binding to memory of type %u", allocation.type);
  if (bound.offset % needs.alignment != 0)
    refuse(row, "binding at byte %" PRIu64 ", which is no multiple of %" PRIu64, bound.offset, needs.alignment);
  const VkDeviceSize page = device.limits.bufferImageGranularity;
  for (const Bound& other : allocation.bound)
    if (other.optimal != bound.optimal && bound.offset / page <= (other.offset + other.bytes - 1) / page &&
        other.offset / page <= (bound.offset + bound.bytes - 1) / page)
      refuse(row, "a buffer and an image, at bytes %" PRIu64 " and %" PRIu64 ", within one page of bufferImageGranularity %" PRIu64,
             bound.offset, other.offset, page);
  allocation.bound.push_back(bound);
}

VkResult bind_buffer_memory2(VkDevice handle, std::uint32_t count, const VkBindBufferMemoryInfo* infos) {
  Device& device = device_of(handle);
  for (const VkBindBufferMemoryInfo& info : std::vector(infos, infos + count)) {
    VkMemoryRequirements needs;
    get_buffer_memory_requirements(handle, info.buffer, &needs);
    check_bound(device, info.memory, {number_of(info.buffer), info.memoryOffset, needs.size, false}, needs);
  }
  return NEXT(device, BindBufferMemory2)(handle, count, infos);
}

VkResult bind_buffer_memory(VkDevice handle, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize offset) {
  const VkBindBufferMemoryInfo info{VK_STRUCTURE_TYPE_BIND_BUFFER_MEMORY_INFO, nullptr, buffer, memory, offset};
  return bind_buffer_memory2(handle, 1, &info);
}

VkResult bind_image_memory2(VkDevice handle, std::uint32_t count, const VkBindImageMemoryInfo* infos) {
  Device& device = device_of(handle);
  for (const VkBindImageMemoryInfo& info : std::vector(infos, infos + count)) {
    VkMemoryRequirements needs;
    get_image_memory_requirements(handle, info.image, &needs);
    check_bound(device, info.memory, {number_of(info.image), info.memoryOffset, needs.size, is_optimal(device, info.image)}, needs);
  }
  return NEXT(device, BindImageMemory2)(handle, count, infos);
}

VkResult bind_image_memory(VkDevice handle, VkImage image, VkDeviceMemory memory, VkDeviceSize offset) {
  const VkBindImageMemoryInfo info{VK_STRUCTURE_TYPE_BIND_IMAGE_MEMORY_INFO, nullptr, image, memory, offset};
  return bind_image_memory2(handle, 1, &info);
}

/// What is destroyed is bound nowhere any longer.
template <class Object, class Known>
void forget(Device& device, std::map<Object, Known>& all, Object object) {
  const std::lock_guard lock(device.mutex);
  all.erase(object);
  for (auto& [memory, allocation] : device.allocations)
    std::erase_if(allocation.bound, [&](const Bound& bound) { return bound.object == number_of(object); });
}

void destroy_buffer(VkDevice handle, VkBuffer buffer, Callbacks callbacks) {
  Device& device = device_of(handle);
  forget(device, device.buffer_bytes, buffer);
  NEXT(device, DestroyBuffer)(handle, buffer, callbacks);
}

void destroy_image(VkDevice handle, VkImage image, Callbacks callbacks) {
  Device& device = device_of(handle);
  forget(device, device.optimal_images, image);
  NEXT(device, DestroyImage)(handle, image, callbacks);
}

VkResult create_buffer(VkDevice handle, const VkBufferCreateInfo* info, Callbacks callbacks, VkBuffer* buffer) {
  Device& device = device_of(handle);
  if (!within(*device.instance->row, "bytes of a buffer", info->size, device.max_allocation_bytes)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  const VkResult result = NEXT(device, CreateBuffer)(handle, info, callbacks, buffer);
  const std::lock_guard lock(device.mutex);
  if (result == VK_SUCCESS) device.buffer_bytes[*buffer] = info->size;
  return result;
}

/// Knows the formats that Coppice reads; any other counts as the largest.
std::uint32_t texel_bytes(VkFormat format) {
  if (format == VK_FORMAT_R32_UINT) return 4;
  return format == VK_FORMAT_R32G32_UINT ? 8 : 16;
}

VkResult create_buffer_view(VkDevice handle, const VkBufferViewCreateInfo* info, Callbacks callbacks, VkBufferView* view) {
  Device& device = device_of(handle);
  VkDeviceSize bytes = info->range;
  if (bytes == VK_WHOLE_SIZE) {
    const std::lock_guard lock(device.mutex);
    bytes = device.buffer_bytes.at(info->buffer) - info->offset;
  }
  if (!within(*device.instance->row, "elements of a texel buffer", bytes / texel_bytes(info->format), device.limits.maxTexelBufferElements))
    return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return NEXT(device, CreateBufferView)(handle, info, callbacks, view);
}

VkResult create_pipeline_layout(VkDevice handle, const VkPipelineLayoutCreateInfo* info, Callbacks callbacks, VkPipelineLayout* layout) {
  Device& device = device_of(handle);
  for (std::uint32_t i = 0; i < info->pushConstantRangeCount; ++i) {
    const VkPushConstantRange& range = info->pPushConstantRanges[i];
    if (!within(*device.instance->row, "bytes of push constants", range.offset + range.size, device.limits.maxPushConstantsSize))
      return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  }
  return NEXT(device, CreatePipelineLayout)(handle, info, callbacks, layout);
}

/// One that is refused is not recorded.
void cmd_dispatch(VkCommandBuffer cmd, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const Device& device = device_of(cmd);
  const DeviceRow& row = *device.instance->row;
  const std::uint32_t* most = device.limits.maxComputeWorkGroupCount;
  if (!within(row, "groups in x", x, most[0]) || !within(row, "groups in y", y, most[1]) || !within(row, "groups in z", z, most[2])) return;
  if (device.instance->reversed)
    hold_dispatch(cmd, x, y, z);
  else
    NEXT(device, CmdDispatch)(cmd, x, y, z);
}

// ---- Instance and device

VkResult create_instance(const VkInstanceCreateInfo* info, Callbacks callbacks, VkInstance* handle) {
  static const DeviceRow nothing{.name = "no other device", .source = "", .type = VK_PHYSICAL_DEVICE_TYPE_MAX_ENUM};
  auto made = std::make_unique<Instance>();
  made->row = &nothing;
  if (const char* name = std::getenv("COPPICE_TEST_DEVICE")) made->row = coppice::test::find_row(name);
  if (made->row == nullptr) {
    std::fprintf(stderr, "limits_layer: COPPICE_TEST_DEVICE=%s is none of\n", std::getenv("COPPICE_TEST_DEVICE"));
    for (const DeviceRow& row : coppice::test::device_rows()) std::fprintf(stderr, "  %s\n", row.name);
    return VK_ERROR_INITIALIZATION_FAILED;
  }
  if (const char* fill = std::getenv("COPPICE_TEST_FILL")) {
    char* end = nullptr;
    const long value = std::strtol(fill, &end, 0);
    if (end == fill || *end != '\0' || value < 0 || value > 255) {
      std::fprintf(stderr, "limits_layer: COPPICE_TEST_FILL=%s is no byte, such as 0xFF\n", fill);
      return VK_ERROR_INITIALIZATION_FAILED;
    }
    made->fill = static_cast<int>(value);
  }
  made->late = std::getenv("COPPICE_TEST_LATE") != nullptr;
  made->reversed = std::getenv("COPPICE_TEST_REVERSE") != nullptr;
  if (const VkResult result = made->create(info, callbacks, handle); result != VK_SUCCESS) return result;
  instances.add(*handle, std::move(made));
  return VK_SUCCESS;
}

void destroy_instance(VkInstance handle, Callbacks callbacks) {
  if (handle != VK_NULL_HANDLE) instances.take(handle)->destroy_instance(handle, callbacks);
}

VkResult create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info, Callbacks callbacks, VkDevice* handle) {
  Instance& instance = instance_of(physical);
  const DeviceRow& row = *instance.row;
  for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
    if (!lacks_extension(row, info->ppEnabledExtensionNames[i])) continue;
    refuse(row, "the extension %s", info->ppEnabledExtensionNames[i]);
    return VK_ERROR_EXTENSION_NOT_PRESENT;
  }
  VkPhysicalDeviceFeatures2 wanted{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = const_cast<void*>(info->pNext)};
  if (info->pEnabledFeatures != nullptr) wanted.features = *info->pEnabledFeatures;
  bool lacking = false;
  for_each_missing(row, wanted, [&](const char* name, const VkBool32& enabled) {
    if (!enabled) return;
    lacking = true;
    refuse(row, "the feature %s", name);
  });
  if (lacking) return VK_ERROR_FEATURE_NOT_PRESENT;

  auto made = std::make_unique<Device>();
  made->instance = &instance;
  VkPhysicalDeviceMemoryProperties driver;
  instance.get_physical_device_memory_properties(physical, &driver);
  if (!within(row, "memory types of the driver below", driver.memoryTypeCount, 1)) return VK_ERROR_INITIALIZATION_FAILED;
  made->memory = tighten(driver, row);
  VkPhysicalDeviceMaintenance3Properties maintenance{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &maintenance};
  get_physical_device_properties2(physical, &properties);
  made->limits = properties.properties.limits;
  made->max_allocation_bytes = maintenance.maxMemoryAllocationSize;

  if (const VkResult result = made->create(instance, physical, info, callbacks, handle); result != VK_SUCCESS) return result;
  if (const VkResult result = create_gate(*made); result != VK_SUCCESS) return result;
  devices.add(*handle, std::move(made));
  return VK_SUCCESS;
}

void destroy_device(VkDevice handle, Callbacks callbacks) {
  if (handle == VK_NULL_HANDLE) return;
  const auto device = devices.take(handle);
  destroy_gate(*device);
  NEXT(*device, DestroyDevice)(handle, callbacks);
}

PFN_vkVoidFunction our_function(std::string_view name);

PFN_vkVoidFunction get_device_proc_addr(VkDevice handle, const char* name) {
  const Device& device = device_of(handle);
  if (const PFN_vkVoidFunction late = device.instance->late ? late_function(name) : nullptr) return late;
  if (const PFN_vkVoidFunction reversed = device.instance->reversed ? reversed_function(name) : nullptr) return reversed;
  const PFN_vkVoidFunction ours = our_function(name);
  return ours != nullptr ? ours : device.next(handle, name);
}

PFN_vkVoidFunction get_instance_proc_addr(VkInstance handle, const char* name) {
  if (const PFN_vkVoidFunction ours = our_function(name)) return ours;
  return handle != VK_NULL_HANDLE ? instance_of(handle).next(handle, name) : nullptr;
}

/// Knows a call's old name too, which ends in KHR.
PFN_vkVoidFunction our_function(std::string_view name) {
  static const Functions hooks{OURS(GetInstanceProcAddr, get_instance_proc_addr),
                               OURS(GetDeviceProcAddr, get_device_proc_addr),
                               OURS(CreateInstance, create_instance),
                               OURS(DestroyInstance, destroy_instance),
                               OURS(CreateDevice, create_device),
                               OURS(DestroyDevice, destroy_device),
                               OURS(GetPhysicalDeviceFeatures, get_physical_device_features),
                               OURS(GetPhysicalDeviceFeatures2, get_physical_device_features2),
                               OURS(GetPhysicalDeviceProperties, get_physical_device_properties),
                               OURS(GetPhysicalDeviceProperties2, get_physical_device_properties2),
                               OURS(GetPhysicalDeviceMemoryProperties, get_physical_device_memory_properties),
                               OURS(GetPhysicalDeviceMemoryProperties2, get_physical_device_memory_properties2),
                               OURS(EnumerateDeviceExtensionProperties, enumerate_device_extension_properties),
                               OURS(AllocateMemory, allocate_memory),
                               OURS(FreeMemory, free_memory),
                               OURS(MapMemory, map_memory),
                               OURS(UnmapMemory, unmap_memory),
                               OURS(FlushMappedMemoryRanges, flush_mapped_memory_ranges),
                               OURS(InvalidateMappedMemoryRanges, invalidate_mapped_memory_ranges),
                               OURS(CreateBuffer, create_buffer),
                               OURS(DestroyBuffer, destroy_buffer),
                               OURS(CreateImage, create_image),
                               OURS(DestroyImage, destroy_image),
                               OURS(GetBufferMemoryRequirements, get_buffer_memory_requirements),
                               OURS(GetBufferMemoryRequirements2, get_buffer_memory_requirements2),
                               OURS(GetImageMemoryRequirements, get_image_memory_requirements),
                               OURS(GetImageMemoryRequirements2, get_image_memory_requirements2),
                               OURS(BindBufferMemory, bind_buffer_memory),
                               OURS(BindBufferMemory2, bind_buffer_memory2),
                               OURS(BindImageMemory, bind_image_memory),
                               OURS(BindImageMemory2, bind_image_memory2),
                               OURS(CreateBufferView, create_buffer_view),
                               OURS(CreatePipelineLayout, create_pipeline_layout),
                               OURS(CmdDispatch, cmd_dispatch)};
  if (name.ends_with("KHR")) name.remove_suffix(3);
  return layer::find_function(hooks, name);
}

}  // namespace
}  // namespace limits_layer

extern "C" __attribute__((visibility("default"))) VkResult vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
  return layer::negotiate(version, limits_layer::get_instance_proc_addr, limits_layer::get_device_proc_addr);
}
