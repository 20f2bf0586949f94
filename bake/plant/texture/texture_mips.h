#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"

namespace coppice::bake {

/// An image and its mip levels down to 1 x 1, largest first. A side halves and rounds down, as in Vulkan.
///
/// A texel of a level is the mean, in linear light, of the texels that it stands for, weighted by how much of the plant shows each
/// (Image::shown). Texels that the alpha test discards weigh nothing. So the plant's mean colour stays. A texel that the plant does not
/// show takes its colour from the coarser level, which is that of the nearest shown texels: filtering at an edge never fetches the colour
/// of a hole, of paper or of another leaf. A texel that nothing shows takes its alpha from there, too.
///
/// With alpha_cutoff > 0 each level's alpha is scaled so that, of what is shown, the share with alpha >= alpha_cutoff is as near to level
/// 0's as whole texels allow, but not 0 (Castano 2010): foliage neither thins nor swells with distance. With 0 alpha means nothing.
///
/// An image wider or higher than COPPICE_MAX_TEXTURE_SIDE starts at its first level that is not. Levels carry their `shown`.
std::vector<Image> mip_levels(const Image& image, float alpha_cutoff);

/// Texels [first, last) of a level `size` wide or high under texel `index` of the next; three where a side is odd, so that none is lost.
struct MipFootprint {
  std::uint32_t first = 0, last = 0;
};
MipFootprint mip_footprint(std::uint32_t index, std::uint32_t size);

/// Share of the shown surface that has alpha >= alpha_cutoff, in [0, 1].
double alpha_coverage(const Image& image, float alpha_cutoff);

/// Whether the alpha test keeps a texel; with alpha_cutoff 0 it keeps all.
bool is_solid(std::uint8_t alpha, float alpha_cutoff);

}  // namespace coppice::bake
