#pragma once

// Takes device memory from the engine's hook in blocks, which buffers and images share. All decisions follow from the order of the calls:
// the same calls get the same places.

#include <cstdint>
#include <vector>

#include <vulkan/vulkan_core.h>

#include "coppice/vulkan.h"
#include "ledger.h"
#include "result.h"

namespace coppice::gpu {

struct Device;

enum class MemoryKind : std::uint8_t {
  device,   ///< the GPU's own memory, written by copies, for chunks that may be evicted
  lasting,  ///< the same for what stays, in small blocks of its own, so that evictions can empty all blocks of kind device
  alone,    ///< the same in a block of its own, which is freed with its content
  host,     ///< mapped and coherent memory: staging and read-back; small blocks too
};

/// A free part of a block.
struct FreeRun {
  std::uint64_t offset = 0, bytes = 0;
};

struct MemoryBlock {
  coppice_memory_block source{};  ///< without memory: the block does not exist, and its index is free
  std::uint64_t bytes = 0;
  MemoryKind kind = MemoryKind::alone;  ///< shared with requests of this kind; alone: not shared
  bool images = false;                  ///< holds images, if those must be kept apart
  bool evictable = false;               ///< was made for kind device, and is empty without chunks
  std::vector<FreeRun> free;            ///< by offset; no two are adjacent
};

/// Part of a block.
struct MemoryRange {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t block = kNone;
  std::uint64_t offset = 0, bytes = 0;
};

struct DeviceMemory {
  /// Limits of a block's size; the minimum is also the size while a context is created.
  static constexpr std::uint64_t kMinBlockBytes = 256ull << 10, kMaxBlockBytes = 32ull << 20;

  coppice_device_memory hook{};  ///< without functions: use vkAllocateMemory
  VkPhysicalDeviceMemoryProperties properties{};
  std::uint64_t granule = 256;  ///< offsets and sizes of ranges are multiples of it; a power of two
  bool images_apart = false;    ///< bufferImageGranularity is more than the granule
  std::uint64_t unit_bytes = 1;
  std::uint64_t block_bytes = kMinBlockBytes;
  Ledger* ledger = nullptr;           ///< committed_bytes are reserved from it; null: no budget
  std::uint64_t reserved_bytes = 0;   ///< bytes that are reserved from the ledger
  std::uint64_t allocated_bytes = 0;  ///< size of all blocks
  std::uint64_t free_bytes = 0;       ///< free bytes of blocks of kind device, in whole units
  std::uint32_t block_count = 0;
  std::vector<MemoryBlock> blocks;
};

/// Sets granule and images_apart for a device.
void set_granularity(DeviceMemory& memory, std::uint64_t buffer_image_granularity);

/// Sets the size of blocks from now on, and frees empty blocks of another size.
/// unit_bytes  the size of most requests, > 0; block_bytes is at least that, and is rounded down to a multiple
void set_block_bytes(Device& device, std::uint64_t block_bytes, std::uint64_t unit_bytes);

/// Rounds block_bytes as set_block_bytes does.
std::uint64_t whole_units(const DeviceMemory& memory, std::uint64_t block_bytes);

/// What committed_bytes would be without chunks that may be evicted, and with blocks of this size.
std::uint64_t lasting_bytes(const DeviceMemory& memory, std::uint64_t block_bytes);

/// All allocated bytes, plus the bytes missing to one block of free memory, so that the next block is reserved before it is needed. A
/// request that would raise this beyond the budget by more than its own size gets a block of its own, so a request that fits the ledger is
/// never refused.
std::uint64_t committed_bytes(const DeviceMemory& memory);

struct MemoryRequest {
  VkMemoryRequirements requirements{};
  MemoryKind kind = MemoryKind::device;
  bool image = false;
};

/// errors  out_of_memory: the ledger or the hook; device_lost; unsupported: no memory type fits; internal: the hook returned an invalid
/// block
Result<MemoryRange> reserve_memory(Device& device, const MemoryRequest& request);
/// The GPU must be done with it. range: may be empty, and is empty afterwards
void release_memory(Device& device, MemoryRange& range);

/// Frees the empty block that is kept. Nothing may be reserved after it.
void close_memory(Device& device);

/// Bytes that the range gives back at once: those of a block of its own.
std::uint64_t own_bytes(const DeviceMemory& memory, const MemoryRange& range);

/// Calls close_memory in its destructor.
struct OpenMemory {
  explicit OpenMemory(Device& of) : device(of) {}
  ~OpenMemory() { close_memory(device); }
  OpenMemory(const OpenMemory&) = delete;
  OpenMemory& operator=(const OpenMemory&) = delete;
  Device& device;
};

}  // namespace coppice::gpu
