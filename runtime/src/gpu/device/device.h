#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "coppice/format.h"
#include "coppice/vulkan.h"
#include "device_memory.h"
#include "functions.h"
#include "result.h"

namespace coppice::gpu {

/// The engine's device, its limits and features that we use, and the memory that we took from it.
struct Device {
  Functions vk;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  std::uint64_t max_storage_bytes = 0;  ///< limit of one storage buffer binding
  std::uint32_t max_draw_count = 0;     ///< limit of one indirect draw
  bool draw_counts = false;             ///< drawIndirectCount is enabled; the caller must say so, because only the engine knows
  std::uint32_t max_group_count = 0;    ///< limit of one dispatch, in x
  std::uint32_t max_stage_buffers = 0;  ///< limit of storage buffers in a stage
  std::uint64_t max_texel_count = 0;    ///< limit of one texel buffer view
  bool reads_texels = true;             ///< kReadsTexels of bindings.glsl
  std::uint32_t max_colors = 0;         ///< limit of attachments in a pass
  bool block_textures = false;          ///< textureCompressionBC is enabled; the caller must say so, because only the engine knows
  std::uint32_t max_view_width = 0, max_view_height = 0;  ///< limits of a viewport
  VkSampleCountFlags sample_counts = 0;                   ///< those that attachments for colour and depth allow
  std::vector<std::uint32_t> queue_families;              ///< families that share buffers and images; empty: one family uses all
  coppice_log log{};                                      ///< gets a line for each failure that a frame works around
  const char* lost_call = nullptr;                        ///< the call that returned VK_ERROR_DEVICE_LOST; null while the device lives
  std::vector<std::string_view> warned_calls;             ///< calls that a line has been written about
  DeviceMemory memory;
};

/// Loads the functions and checks that the physical device has the features of coppice_vulkan_desc.device.
/// errors  unsupported, naming every feature that is missing
Result<Device> open_device(VkInstance instance, VkPhysicalDevice physical_device, VkDevice device,
                           PFN_vkGetInstanceProcAddr get_instance_proc_addr);

/// Features that may be enabled.
struct OptionalFeatures {
  bool block_textures = false;  ///< textureCompressionBC
  bool draw_counts = false;     ///< drawIndirectCount
  bool int64_atomics = false;   ///< shaderInt64 and shaderBufferInt64Atomics
  bool independent_blend = false;
};
OptionalFeatures optional_features(const Device& device);

struct Buffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  MemoryRange memory;
  std::uint64_t size_bytes = 0;    ///< the requested size
  VkDeviceAddress address = 0;     ///< 0 unless created with SHADER_DEVICE_ADDRESS
  std::uint8_t* mapped = nullptr;  ///< MemoryKind::host only
  /// A view of the whole buffer; without Device::reads_texels of as much as the device binds. Null unless created with
  /// UNIFORM_TEXEL_BUFFER.
  VkBufferView texels = VK_NULL_HANDLE;
};

/// Usage of a buffer that shaders write or read and that copies fill.
inline constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;

/// Number of bits in a device address.
inline constexpr std::uint32_t kAddressBits = 57;

/// Minimum of texels in a buffer of devices whose shaders read them: enough for the picture of two eyes of 7,680 x 4,320 px. Nearly all
/// devices have as many; some phones, and SwiftShader, have 65,536.
inline constexpr std::uint64_t kManyTexels = std::uint64_t{1} << 27;

struct BufferDesc {
  const char* name = "";  ///< shown by graphics debuggers
  std::uint64_t size_bytes = 0;
  VkBufferUsageFlags usage = 0;
  MemoryKind kind = MemoryKind::lasting;
  VkFormat texels = VK_FORMAT_R32_UINT;  ///< for UNIFORM_TEXEL_BUFFER: R32, R32G32 or R32G32B32A32
};

/// errors  out_of_memory; device_lost; unsupported: a storage or texel buffer larger than the device binds
Result<Buffer> create_buffer(Device& device, const BufferDesc& desc);
/// buffer: may be empty
void destroy_buffer(Device& device, Buffer& buffer);
/// True if the bytes for a buffer are free; otherwise notes a refusal, as Ledger::fits does.
bool fits_buffer(Device& device, std::uint64_t bytes);

/// A sampled 2D image with colours in sRGB.
struct Texture {
  VkImage image = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  MemoryRange memory;
  std::uint32_t width = 0, height = 0, mip_count = 0;
  std::uint32_t format = COPPICE_TEXTURE_RGBA8;  ///< coppice_texture_format
};

/// desc: gives its sides, mip_count and format; with a block format device.block_textures must be set
/// errors  out_of_memory, device_lost
Result<Texture> create_texture(Device& device, const coppice_file_texture& desc, MemoryKind kind);
/// texture: may be empty
void destroy_texture(Device& device, Texture& texture);

/// Turns a VkResult other than VK_SUCCESS into an error. No other function does. call: its name, in static storage
[[nodiscard]] Error vulkan_error(VkResult result, const char* call);

/// Turns the result of a Vulkan call into a Result. Notes a loss in device.lost_call.
/// errors  out_of_memory, device_lost, unsupported; internal: all other failures
[[nodiscard]] Result<void> check(Device& device, VkResult result, const char* call);

/// Does the same for a call that creates `handle`, which becomes null on failure, because Vulkan leaves it undefined.
template <class Handle>
[[nodiscard]] Result<void> check_created(Device& device, VkResult result, const char* call, Handle& handle) {
  if (result != VK_SUCCESS) handle = VK_NULL_HANDLE;
  return check(device, result, call);
}

/// errors  device_lost: a call said so, now or earlier
[[nodiscard]] Result<void> check_alive(const Device& device);

/// Logs that a frame goes on without something, once for each call that fails. The caller returns a lost device.
/// instead  what happens: "drawn without shadows and occluder"
void go_on_without(Device& device, const Error& error, const char* instead);

/// Sharing of a device's buffers and images, for their create infos.
VkSharingMode sharing_mode(const Device& device);
/// The stages of a barrier, or ALL_COMMANDS if queues of several families use it.
VkPipelineStageFlags2 stages_of_queue(const Device& device, VkPipelineStageFlags2 stages);

/// Records a global memory barrier.
void memory_barrier(const Device& device, VkCommandBuffer cmd, VkPipelineStageFlags2 source_stages, VkAccessFlags2 source_access,
                    VkPipelineStageFlags2 target_stages, VkAccessFlags2 target_access);

}  // namespace coppice::gpu
