#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// An image and its mip levels down to 1 x 1, largest first. A side halves and rounds down, as in Vulkan.
///
/// A texel of each level is the mean, in linear light, of what the plant shows of those that it stands for: they weigh as much as
/// Image::shown says, and where the alpha test discards them nothing. So the plant's mean colour stays. What it does not show takes the
/// colour (and what nothing shows the alpha too) of the coarser level, which is that of the nearest texels that it does show: filtering at
/// an edge never fetches the colour of a hole, of paper or of another leaf. With alpha_cutoff > 0 each level's alpha is scaled so that the
/// share of what is shown that is >= alpha_cutoff is as near to level 0's as whole texels allow, but not 0 (Castano 2010): foliage neither
/// thins nor swells with distance. With 0 alpha means nothing.
/// An image wider or higher than COPPICE_MAX_TEXTURE_SIDE starts at its first level that is not. Levels carry their `shown`.
std::vector<Image> mip_levels(const Image& image, float alpha_cutoff);

/// Texels [first, last) of a level `size` wide or high under texel `index` of the next; three where a side is odd, so that none is lost.
struct MipFootprint {
  std::uint32_t first = 0, last = 0;
};
MipFootprint mip_footprint(std::uint32_t index, std::uint32_t size);

/// Share of what is shown that has alpha >= alpha_cutoff, in [0, 1].
double alpha_coverage(const Image& image, float alpha_cutoff);

/// Whether the alpha test keeps a texel; with alpha_cutoff 0 it keeps all.
bool is_solid(std::uint8_t alpha, float alpha_cutoff);

}  // namespace coppice::bake
