#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// An image and its mip levels down to 1 x 1, largest first. A side halves and rounds down, as in Vulkan.
///
/// Colours are averaged in linear light, weighted by alpha; texels of alpha 0 take the colour of the coarser level, so that filtering at an
/// edge never fetches the colour of a hole. With alpha_cutoff > 0 each level's alpha is scaled so that the share of texels
/// >= alpha_cutoff is as near to level 0's as whole texels allow, but not 0 (Castano 2010): foliage neither thins nor swells with distance.
/// An image wider or higher than COPPICE_MAX_TEXTURE_SIDE starts at its first level that is not.
std::vector<Image> mip_levels(const Image& image, float alpha_cutoff);

/// Texels [first, last) of a level `size` wide or high under texel `index` of the next; three where a side is odd, so that none is lost.
struct MipFootprint {
  std::uint32_t first = 0, last = 0;
};
MipFootprint mip_footprint(std::uint32_t index, std::uint32_t size);

/// Share of texels with alpha >= alpha_cutoff, in [0, 1].
double alpha_coverage(const Image& image, float alpha_cutoff);

/// Whether the alpha test keeps a texel.
bool is_solid(std::uint8_t alpha, float alpha_cutoff);

}  // namespace coppice::bake
