#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "vulkan_device.h"

namespace coppice::test {

/// Visible pixels of each quad, measured as the paper does, with the graphics pipeline: a depth pass of all quads, then one pass per quad
/// that counts its samples of equal depth in an occlusion query (N_l + 1 passes). Opaque; where depths tie every quad counts.
/// corners          [quad_count * 4] object space, triangles (0, 1, 2) and (0, 2, 3)
/// clip_from_object  to Vulkan's clip space, depth 0 near
/// side_px          of the square image
/// counted          only pixels of this rectangle are counted
/// result           [quad_count] px
std::vector<std::uint32_t> occlusion_areas(const VulkanDevice& gpu, std::span<const glm::vec3> corners, const glm::mat4& clip_from_object,
                                           std::uint32_t side_px, const VkRect2D& counted);

}  // namespace coppice::test
