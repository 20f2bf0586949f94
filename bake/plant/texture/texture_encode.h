#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// How textures are stored.
enum class TextureCoding : std::uint8_t {
  bc,     ///< BC3 for what is alpha-tested and has holes, BC1 for everything else
  rgba8,  ///< as they are: four to eight times the bytes
};

/// Encodes a TEXTURE chunk: mip_levels(image, alpha_cutoff), coded. A normal map becomes normal_map_levels in the form of
/// stored_normal_map. Same input, same bytes.
///
/// With BC3 a texel stays on its side of alpha_cutoff, so that coverage is that of the mip levels, to the texel. An image that is not
/// alpha-tested loses its alpha, which nothing reads.
/// errors  invalid_argument: the image is empty or its bytes are not width * height * 4
Result<std::vector<std::uint8_t>> encode_texture(const Image& image, float alpha_cutoff, TextureCoding coding);

}  // namespace coppice::bake
