#pragma once

// The pipelines that draw leaves to measure areas.

#include <array>
#include <cstdint>

#include <glm/mat4x4.hpp>

#include "area_device.h"
#include "result.h"

namespace coppice::bake {

inline constexpr VkFormat kAreaDepthFormat = VK_FORMAT_D32_SFLOAT;
inline constexpr VkShaderStageFlags kAreaPushStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

// These structs have the layouts of shaders/areas/leaf_area.glsl.

struct AreaLeaf {
  std::array<float, 12> corners{};  ///< x, y, z of four corners, from the centre of the bounding sphere, relative to its radius
  std::array<float, 8> uvs{};
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

/// Members that were not created are null.
struct AreaPipelines {
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline fill_depth = VK_NULL_HANDLE;        ///< draws leaves and keeps the nearest depth
  VkPipeline count_leaf = VK_NULL_HANDLE;        ///< draws leaves and counts samples of equal depth
  VkPipeline count_background = VK_NULL_HANDLE;  ///< draws three vertices and counts samples of depth 1, the cleared value
};

/// masked  whether any leaf has holes; without holes there is no fragment shader
/// errors  those of check_vulkan. On an error `pipelines` still holds what was created.
Result<void> create_area_pipelines(const AreaDevice& gpu, bool masked, AreaPipelines& pipelines);

void destroy_area_pipelines(const AreaDevice& gpu, const AreaPipelines& pipelines);

}  // namespace coppice::bake
