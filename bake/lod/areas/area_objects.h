#pragma once

// What measuring areas needs on a device: buffers, the depth image, the pipelines that draw leaves. Functions that fail leave in their last
// argument what they created; destroy it in any case, after the device has finished with it.

#include <array>
#include <cstdint>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "area_device.h"
#include "result.h"

namespace coppice::bake {

// These structs have the layouts of shaders/areas/leaf_area.glsl.

struct AreaLeaf {
  std::array<glm::vec3, 4> corners{};  ///< from the centre of the bounding sphere, relative to its radius
  std::array<glm::vec2, 4> uvs{};
  std::uint32_t mask = 0;
};
static_assert(sizeof(AreaLeaf) == 84);

struct AreaMask {
  std::uint32_t width = 0, height = 0;  ///< 0: no holes
  std::uint32_t first_word = 0;
};
static_assert(sizeof(AreaMask) == 12);

struct AreaPush {
  glm::mat4 clip_from_sphere{1.0f};
  VkDeviceAddress leaves = 0, masks = 0, holes = 0;
};
static_assert(sizeof(AreaPush) == 88);
inline constexpr VkShaderStageFlags kAreaPushStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

/// A storage buffer in mapped, coherent memory.
struct AreaBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  void* mapped = nullptr;
  VkDeviceAddress address = 0;
  VkDeviceSize bytes = 0;
};

/// A square depth attachment.
struct AreaDepth {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
};

struct AreaPipelines {
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline fill_depth = VK_NULL_HANDLE;        ///< draws leaves and keeps the nearest depth
  VkPipeline count_leaf = VK_NULL_HANDLE;        ///< draws leaves and counts samples of equal depth
  VkPipeline count_background = VK_NULL_HANDLE;  ///< draws three vertices and counts samples of depth 1, the cleared value
};

/// bytes   > 0
/// errors  those of check_vulkan; unsupported
Result<void> create_area_buffer(const AreaDevice& gpu, VkDeviceSize bytes, AreaBuffer& buffer);
Result<void> create_area_depth(const AreaDevice& gpu, std::uint32_t side_px, AreaDepth& depth);
/// masked  whether any leaf has holes; without holes there is no fragment shader
/// errors  those of check_vulkan
Result<void> create_area_pipelines(const AreaDevice& gpu, bool masked, AreaPipelines& pipelines);

void destroy_area_buffer(const AreaDevice& gpu, AreaBuffer& buffer);
void destroy_area_depth(const AreaDevice& gpu, const AreaDepth& depth);
void destroy_area_pipelines(const AreaDevice& gpu, const AreaPipelines& pipelines);

}  // namespace coppice::bake
