#pragma once

// Device memory comes from the engine's hook in blocks, which buffers and images share. All decisions follow from the order of the calls:
// the same calls take the same places.

#include <cstdint>
#include <vector>

#include <vulkan/vulkan_core.h>

#include "coppice/vulkan.h"
#include "ledger.h"
#include "result.h"

namespace coppice::gpu {

struct Device;

enum class MemoryKind : std::uint8_t {
  device,  ///< the GPU's own, written by copies
  alone,   ///< the same in a block of its own, which goes back with it
  host,    ///< mapped and coherent: staging and read-back
};

/// A free part of a block.
struct FreeRun {
  std::uint64_t offset = 0, bytes = 0;
};

struct MemoryBlock {
  coppice_memory_block source{};  ///< without memory: not there, its index is free
  std::uint64_t bytes = 0;
  MemoryKind kind = MemoryKind::alone;  ///< shared with others of this kind; alone: with none
  bool images = false;                  ///< has images where those are kept apart
  std::vector<FreeRun> free;            ///< by offset; no two touch
};

/// Part of a block.
struct MemoryRange {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t block = kNone;
  std::uint64_t offset = 0, bytes = 0;
};

struct DeviceMemory {
  /// Of a block: as large as one may be, and while a context is created.
  static constexpr std::uint64_t kLeastBlockBytes = 256ull << 10, kMostBlockBytes = 32ull << 20;

  coppice_device_memory hook{};  ///< without functions: vkAllocateMemory
  VkPhysicalDeviceMemoryProperties properties{};
  std::uint64_t granule = 256;  ///< every range's offset and size are multiples; a power of two
  bool images_apart = false;    ///< bufferImageGranularity is more than the granule
  std::uint64_t unit_bytes = 1;
  std::uint64_t block_bytes = kLeastBlockBytes;
  Ledger* ledger = nullptr;           ///< committed_bytes are taken from it; none: without a budget
  std::uint64_t taken_bytes = 0;      ///< from the ledger
  std::uint64_t allocated_bytes = 0;  ///< of all blocks
  std::uint64_t free_bytes = 0;       ///< of blocks of kind device, in whole units
  std::uint32_t block_count = 0;
  std::vector<MemoryBlock> blocks;
};

/// Sets granule and images_apart for a device.
void set_granularity(DeviceMemory& memory, std::uint64_t buffer_image_granularity);

/// From now on blocks are so large; blocks that are empty and of another size go back.
/// unit_bytes  what most requests ask for, > 0; block_bytes is at least that and rounded down to a multiple
void set_block_bytes(Device& device, std::uint64_t block_bytes, std::uint64_t unit_bytes);

/// block_bytes as set_block_bytes rounds it.
std::uint64_t whole_units(const DeviceMemory& memory, std::uint64_t block_bytes);

/// What is allocated, and what is missing to a block's worth of free memory: the next block is spoken for before it is needed. A request
/// that would raise this beyond the budget by more than itself gets a block of its own: what fits the ledger is never refused.
std::uint64_t committed_bytes(const DeviceMemory& memory);

struct MemoryRequest {
  VkMemoryRequirements requirements{};
  MemoryKind kind = MemoryKind::device;
  bool image = false;
};

/// errors  out_of_memory: the ledger or the hook; device_lost; unsupported: no memory type fits; internal: what the hook returned is no
/// block
Result<MemoryRange> take_memory(Device& device, const MemoryRequest& request);
/// The GPU must be done with it. range: may be none, and is afterwards
void give_memory(Device& device, MemoryRange& range);

/// Gives back the empty block that is kept. Nothing may be taken any more.
void close_memory(Device& device);

/// Closes it in the end.
struct OpenMemory {
  explicit OpenMemory(Device& of) : device(of) {}
  ~OpenMemory() { close_memory(device); }
  OpenMemory(const OpenMemory&) = delete;
  OpenMemory& operator=(const OpenMemory&) = delete;
  Device& device;
};

}  // namespace coppice::gpu
