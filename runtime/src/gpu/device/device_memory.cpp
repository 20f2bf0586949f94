#include "device_memory.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "debug_label.h"
#include "device.h"

namespace coppice::gpu {
namespace {

/// The place for a request.
struct Plan {
  std::uint32_t block = MemoryRange::kNone;  ///< kNone: in a new one
  std::size_t run = 0;                       ///< index of the free run
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t block_bytes = 0;        ///< size of the new block
  MemoryKind kind = MemoryKind::alone;  ///< kind of the new block
};

std::uint64_t round_up(std::uint64_t value, std::uint64_t step) {
  return (value + step - 1) / step * step;
}

std::uint64_t in_units(const DeviceMemory& memory, std::uint64_t bytes) {
  return bytes / memory.unit_bytes * memory.unit_bytes;
}

bool is_there(const MemoryBlock& block) {
  return block.source.memory != VK_NULL_HANDLE;
}

bool is_empty(const MemoryBlock& block) {
  return block.free.size() == 1 && block.free[0].bytes == block.bytes;
}

/// Free bytes of a block as free_bytes counts them.
std::uint64_t counted(const DeviceMemory& memory, MemoryKind kind, std::uint64_t bytes) {
  return kind == MemoryKind::device ? in_units(memory, bytes) : 0;
}

std::uint64_t committed(const DeviceMemory& memory, std::uint64_t allocated_bytes, std::uint64_t free_bytes) {
  return allocated_bytes + memory.block_bytes - std::min(free_bytes, memory.block_bytes);
}

/// Size of the blocks that requests of a kind share.
std::uint64_t shared_block_bytes(const DeviceMemory& memory, MemoryKind kind) {
  constexpr std::uint64_t kSmaller = 4;
  if (kind == MemoryKind::device) return memory.block_bytes;
  return std::min(memory.block_bytes,
                  std::max(DeviceMemory::kMinBlockBytes, memory.block_bytes / kSmaller / memory.granule * memory.granule));
}

bool accepts(const DeviceMemory& memory, const MemoryBlock& block, const MemoryRequest& request) {
  return is_there(block) && block.kind == request.kind && (request.requirements.memoryTypeBits >> block.source.memory_type & 1u) != 0 &&
         block.images == (request.image && memory.images_apart);
}

std::uint64_t free_bytes_of(const MemoryBlock& block) {
  std::uint64_t sum = 0;
  for (const FreeRun& run : block.free) sum += run.bytes;
  return sum;
}

/// Finds the fullest block with enough space, so that others empty; in it the smallest run.
void find_run(const DeviceMemory& memory, const MemoryRequest& request, Plan& plan) {
  const std::uint64_t alignment = std::max<std::uint64_t>(request.requirements.alignment, memory.granule);
  std::uint64_t min_free = ~std::uint64_t{0};
  for (std::uint32_t index = 0; index < memory.blocks.size(); ++index) {
    const MemoryBlock& block = memory.blocks[index];
    if (!accepts(memory, block, request)) continue;
    const std::uint64_t free = free_bytes_of(block);
    if (free < plan.bytes || free >= min_free) continue;
    std::uint64_t min_run = ~std::uint64_t{0};
    for (std::size_t i = 0; i < block.free.size(); ++i) {
      const FreeRun& run = block.free[i];
      const std::uint64_t start = round_up(block.source.offset + run.offset, alignment) - block.source.offset;
      if (start + plan.bytes > run.offset + run.bytes || run.bytes >= min_run) continue;
      min_free = free;
      min_run = run.bytes;
      plan.block = index;
      plan.run = i;
      plan.offset = start;
    }
  }
}

std::uint64_t committed_after(const DeviceMemory& memory, const Plan& plan) {
  if (plan.block == MemoryRange::kNone)
    return committed(memory, memory.allocated_bytes + plan.block_bytes,
                     memory.free_bytes + counted(memory, plan.kind, plan.block_bytes - plan.bytes));
  const MemoryBlock& block = memory.blocks[plan.block];
  const FreeRun& run = block.free[plan.run];
  const std::uint64_t before = plan.offset - run.offset, after = run.bytes - before - plan.bytes;
  return committed(memory, memory.allocated_bytes,
                   memory.free_bytes - counted(memory, block.kind, run.bytes) + counted(memory, block.kind, before) +
                       counted(memory, block.kind, after));
}

/// The ledger's limit.
std::uint64_t limit_bytes(const DeviceMemory& memory) {
  if (memory.ledger == nullptr) return Ledger::kUnlimited;
  const std::uint64_t now = committed_bytes(memory);
  return now + std::min(memory.ledger->free(), Ledger::kUnlimited - now);
}

/// Call it after every change.
void settle(DeviceMemory& memory, std::uint64_t bytes) {
  const std::uint64_t before = std::exchange(memory.reserved_bytes, bytes);
  if (memory.ledger == nullptr) return;
  memory.ledger->release(before);
  memory.ledger->reserve(bytes);
}

/// Plans a free run, or else a new block that is shared; or a block of its own if the limit allows only that.
Plan plan_for(const DeviceMemory& memory, const MemoryRequest& request) {
  const std::uint64_t bytes = round_up(request.requirements.size, memory.granule);
  const Plan alone{.bytes = bytes, .block_bytes = bytes};
  if (request.kind == MemoryKind::alone) return alone;
  const std::uint64_t maximum = std::max(limit_bytes(memory), committed_after(memory, alone));
  Plan plan{.bytes = bytes};
  find_run(memory, request, plan);
  if (plan.block != MemoryRange::kNone) return committed_after(memory, plan) <= maximum ? plan : alone;
  // A request above half a block would leave too much of one unused.
  plan.block_bytes = shared_block_bytes(memory, request.kind);
  if (bytes > plan.block_bytes / 2) return alone;
  plan.kind = request.kind;
  const std::uint64_t after = committed_after(memory, plan);
  // If less than a block is left beside it, a chunk with reserved bytes must still find them.
  return after <= committed_after(memory, alone) || after + memory.block_bytes <= maximum ? plan : alone;
}

Result<std::uint32_t> find_memory_type(const DeviceMemory& memory, std::uint32_t type_bits, VkMemoryPropertyFlags properties) {
  for (std::uint32_t type = 0; type < memory.properties.memoryTypeCount; ++type)
    if ((type_bits >> type & 1u) && (memory.properties.memoryTypes[type].propertyFlags & properties) == properties) return type;
  return Error{Status::unsupported, "no memory type fits", Error::kNoOffset,
               properties & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT ? "device local" : "host coherent"};
}

Result<coppice_memory_block> allocate_by_vulkan(Device& device, const VkMemoryRequirements& requirements,
                                                VkMemoryPropertyFlags properties) {
  COPPICE_TRY(type, find_memory_type(device.memory, requirements.memoryTypeBits, properties));
  const VkMemoryAllocateFlagsInfo flags{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                        .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .pNext = properties & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT ? &flags : nullptr,
                                  .allocationSize = requirements.size,
                                  .memoryTypeIndex = type};
  coppice_memory_block block{.struct_size = sizeof block, .memory_type = type};
  COPPICE_CHECK(check(device, device.vk.vkAllocateMemory(device.device, &info, nullptr, &block.memory), "vkAllocateMemory"));
  name_object(device, VK_OBJECT_TYPE_DEVICE_MEMORY, block.memory, "coppice memory");
  if (!(properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)) return block;
  const auto mapped = check(device, device.vk.vkMapMemory(device.device, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped), "vkMapMemory");
  if (mapped) return block;
  device.vk.vkFreeMemory(device.device, block.memory, nullptr);
  return mapped.error();
}

void free_source(Device& device, const coppice_memory_block& source) {
  const coppice_device_memory& hook = device.memory.hook;
  if (hook.free != nullptr)
    hook.free(hook.user, &source);
  else
    device.vk.vkFreeMemory(device.device, source.memory, nullptr);
}

Result<coppice_memory_block> allocate_by_hook(Device& device, const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties) {
  const coppice_device_memory& hook = device.memory.hook;
  coppice_memory_block block{.struct_size = sizeof(coppice_memory_block)};
  COPPICE_CHECK(check(device, hook.allocate(hook.user, &requirements, properties, &block), "device_memory.allocate"));
  block.struct_size = sizeof block;  // the engine may have overwritten the whole struct
  const char* problem = nullptr;
  if (block.memory == VK_NULL_HANDLE)
    problem = "memory is null";
  else if (block.memory_type >= device.memory.properties.memoryTypeCount || !(requirements.memoryTypeBits >> block.memory_type & 1u))
    problem = "memory_type is none of memoryTypeBits";
  else if (block.offset % requirements.alignment != 0)
    problem = "offset is not aligned";
  else if ((properties & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) && block.mapped == nullptr)
    problem = "mapped is null";
  if (problem == nullptr) return block;
  if (block.memory != VK_NULL_HANDLE) hook.free(hook.user, &block);
  return Error{Status::internal, "device_memory.allocate", Error::kNoOffset, problem};
}

Result<std::uint32_t> add_block(Device& device, const MemoryRequest& request, const Plan& plan) {
  DeviceMemory& memory = device.memory;
  const VkMemoryPropertyFlags properties =
      request.kind == MemoryKind::host ? VkMemoryPropertyFlags{VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT}
                                       : VkMemoryPropertyFlags{VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT};
  const VkMemoryRequirements requirements{.size = plan.block_bytes,
                                          .alignment = std::max<std::uint64_t>(request.requirements.alignment, memory.granule),
                                          .memoryTypeBits = request.requirements.memoryTypeBits};
  COPPICE_TRY(source, memory.hook.allocate != nullptr ? allocate_by_hook(device, requirements, properties)
                                                      : allocate_by_vulkan(device, requirements, properties));
  const auto hole = std::ranges::find_if_not(memory.blocks, is_there);
  const auto index = static_cast<std::uint32_t>(hole - memory.blocks.begin());
  if (hole == memory.blocks.end()) memory.blocks.emplace_back();
  memory.blocks[index] = {.source = source,
                          .bytes = plan.block_bytes,
                          .kind = plan.kind,
                          .images = request.image && memory.images_apart,
                          .evictable = request.kind == MemoryKind::device,
                          .free = {}};
  memory.allocated_bytes += plan.block_bytes;
  ++memory.block_count;
  if (plan.kind == MemoryKind::alone) return index;
  memory.blocks[index].free.push_back({0, plan.block_bytes});
  memory.free_bytes += counted(memory, plan.kind, plan.block_bytes);
  return index;
}

void free_block(Device& device, std::uint32_t index) {
  DeviceMemory& memory = device.memory;
  MemoryBlock& block = memory.blocks[index];
  free_source(device, block.source);
  memory.allocated_bytes -= block.bytes;
  for (const FreeRun& run : block.free) memory.free_bytes -= counted(memory, block.kind, run.bytes);
  --memory.block_count;
  block = {};
}

void free_empty_blocks(Device& device, std::uint64_t kept_block_bytes) {
  for (std::uint32_t index = 0; index < device.memory.blocks.size(); ++index)
    if (is_empty(device.memory.blocks[index]) && device.memory.blocks[index].bytes != kept_block_bytes) free_block(device, index);
}

void reserve_run(DeviceMemory& memory, const Plan& plan) {
  const MemoryKind kind = memory.blocks[plan.block].kind;
  std::vector<FreeRun>& free = memory.blocks[plan.block].free;
  const auto at = free.begin() + static_cast<std::ptrdiff_t>(plan.run);
  const FreeRun run = *at;
  const FreeRun before{run.offset, plan.offset - run.offset};
  const FreeRun after{plan.offset + plan.bytes, run.bytes - before.bytes - plan.bytes};
  memory.free_bytes -= counted(memory, kind, run.bytes) - counted(memory, kind, before.bytes) - counted(memory, kind, after.bytes);
  if (before.bytes > 0 && after.bytes > 0) {
    *at = after;
    free.insert(at, before);
  } else if (before.bytes + after.bytes > 0) {
    *at = before.bytes > 0 ? before : after;
  } else {
    free.erase(at);
  }
}

void release_run(DeviceMemory& memory, MemoryBlock& block, FreeRun run) {
  std::vector<FreeRun>& free = block.free;
  auto next = std::ranges::upper_bound(free, run.offset, {}, &FreeRun::offset);
  if (next != free.end() && run.offset + run.bytes == next->offset) {
    memory.free_bytes -= counted(memory, block.kind, next->bytes);
    run.bytes += next->bytes;
    next = free.erase(next);
  }
  if (next != free.begin() && (next - 1)->offset + (next - 1)->bytes == run.offset) {
    FreeRun& before = *(next - 1);
    memory.free_bytes += counted(memory, block.kind, before.bytes + run.bytes) - counted(memory, block.kind, before.bytes);
    before.bytes += run.bytes;
    return;
  }
  memory.free_bytes += counted(memory, block.kind, run.bytes);
  free.insert(next, run);
}

}  // namespace

void set_granularity(DeviceMemory& memory, std::uint64_t buffer_image_granularity) {
  constexpr std::uint64_t kMaxGranule = 1024;
  memory.images_apart = buffer_image_granularity > kMaxGranule;
  if (!memory.images_apart) memory.granule = std::max(memory.granule, buffer_image_granularity);
}

void set_block_bytes(Device& device, std::uint64_t block_bytes, std::uint64_t unit_bytes) {
  DeviceMemory& memory = device.memory;
  memory.unit_bytes = round_up(unit_bytes, memory.granule);
  memory.block_bytes = whole_units(memory, block_bytes);
  free_empty_blocks(device, memory.block_bytes);
  memory.free_bytes = 0;
  for (const MemoryBlock& block : memory.blocks)
    for (const FreeRun& run : block.free) memory.free_bytes += counted(memory, block.kind, run.bytes);
  settle(memory, committed_bytes(memory));
}

std::uint64_t whole_units(const DeviceMemory& memory, std::uint64_t block_bytes) {
  return std::max(in_units(memory, block_bytes), memory.unit_bytes);
}

std::uint64_t lasting_bytes(const DeviceMemory& memory, std::uint64_t block_bytes) {
  std::uint64_t bytes = whole_units(memory, block_bytes);
  for (const MemoryBlock& block : memory.blocks)
    if (is_there(block) && !block.evictable) bytes += block.bytes;
  return bytes;
}

std::uint64_t committed_bytes(const DeviceMemory& memory) {
  return committed(memory, memory.allocated_bytes, memory.free_bytes);
}

Result<MemoryRange> reserve_memory(Device& device, const MemoryRequest& request) {
  DeviceMemory& memory = device.memory;
  Plan plan = plan_for(memory, request);
  // A block that is kept for others may be what exceeds the limit.
  if (committed_after(memory, plan) > limit_bytes(memory) && plan.block == MemoryRange::kNone) {
    free_empty_blocks(device, 0);
    settle(memory, committed_bytes(memory));
  }
  const std::uint64_t now = committed_bytes(memory), after = std::max(now, committed_after(memory, plan));
  if (memory.ledger != nullptr && after > now && !memory.ledger->fits(after - now))
    return Error{Status::out_of_memory, "memory budget: no room for device memory now"};
  if (plan.block == MemoryRange::kNone) {
    COPPICE_TRY(added, add_block(device, request, plan));
    plan.block = added;
  }
  if (memory.blocks[plan.block].kind != MemoryKind::alone) reserve_run(memory, plan);
  settle(memory, committed_bytes(memory));
  return MemoryRange{plan.block, plan.offset, plan.bytes};
}

void release_memory(Device& device, MemoryRange& range) {
  if (range.block == MemoryRange::kNone) return;
  DeviceMemory& memory = device.memory;
  const MemoryRange released = std::exchange(range, {});
  MemoryBlock& block = memory.blocks[released.block];
  if (block.kind != MemoryKind::alone) release_run(memory, block, {released.offset, released.bytes});
  // One empty block is kept, because committed bytes include it in any case.
  const bool spare = block.kind == MemoryKind::device && block.bytes == memory.block_bytes;
  const auto is_other = [&](const MemoryBlock& other) { return &other != &block && is_empty(other); };
  if (block.kind == MemoryKind::alone || (is_empty(block) && (!spare || std::ranges::any_of(memory.blocks, is_other))))
    free_block(device, released.block);
  settle(memory, committed_bytes(memory));
}

std::uint64_t own_bytes(const DeviceMemory& memory, const MemoryRange& range) {
  return range.block != MemoryRange::kNone && memory.blocks[range.block].kind == MemoryKind::alone ? range.bytes : 0;
}

void close_memory(Device& device) {
  free_empty_blocks(device, 0);
  settle(device.memory, 0);
}

}  // namespace coppice::gpu
