#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "vulkan_device.h"

namespace coppice::test {

/// Leaf quads with one alpha mask for all.
struct MaskedQuads {
  std::vector<glm::vec3> corners;  ///< [quad_count * 4] object space, triangles (0, 1, 2) and (0, 2, 3)
  std::vector<glm::vec2> uvs;      ///< [quad_count * 4] of the corners
  std::uint32_t mask_width = 0;    ///< texels; 0 for quads without holes
  std::uint32_t mask_height = 0;
  std::vector<std::uint8_t> holes;  ///< [mask_height * mask_width] rows top to bottom, not 0 for a hole. Nearest texel, repeating
};

/// Visible pixels of each quad, measured as the paper does, with the graphics pipeline: a depth pass of all quads, then one pass per quad
/// that counts its samples of equal depth in an occlusion query (N_l + 1 passes). Holes do not count; where depths tie every quad counts.
/// clip_from_object  to Vulkan's clip space, depth 0 near
/// side_px          of the square image
/// counted          only pixels of this rectangle are counted
/// result           [quad_count] px
std::vector<std::uint32_t> occlusion_areas(const VulkanDevice& gpu, const MaskedQuads& quads, const glm::mat4& clip_from_object,
                                           std::uint32_t side_px, const VkRect2D& counted);

}  // namespace coppice::test
