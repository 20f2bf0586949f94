#pragma once

// Normal maps: images of unit vectors in the frame of the texture (plant.h: Image::is_normal_map), and how a TEXTURE chunk holds them.

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// The vector that a texel holds: 0..255 stand for -1..1; not normalised.
glm::vec3 normal_of(std::span<const std::uint8_t, 4> texel);
/// Writes the unit vector along `normal`, (0, 0, 1) where it has no direction or looks into the surface; alpha 255.
void write_normal(const glm::vec3& normal, std::span<std::uint8_t, 4> texel);

/// Returns the map, or its first mip level that is no wider or higher than max_side_px, at least 1.
Image normal_map_within(Image map, std::uint32_t max_side_px);

/// Returns an image and its mip levels down to 1 x 1, with the sizes of mip_levels (texture_mips.h). A texel is the direction of the sum of
/// the normals that it stands for.
std::vector<Image> normal_map_levels(const Image& map);

/// Converts a normal map to what a TEXTURE chunk holds: x in alpha and y, as an sRGB value, in green, since BC3 codes these two channels on
/// their own. A reader takes (2 alpha - 1, 2 green - 1) of what a GPU samples, and z = sqrt(1 - x^2 - y^2).
Image stored_normal_map(const Image& map);
/// The inverse of stored_normal_map, but for rounding.
Image normal_map_from_stored(const Image& stored);

}  // namespace coppice::bake
