#pragma once

// What a card shows from afar, for the compute rasteriser: a mean colour, and an outline of 8 x 8 cells instead of a texture.

#include <cstdint>
#include <span>
#include <vector>

#include "raster_shared.h"
#include "reader.h"

namespace coppice::gpu {

/// A plant's cards and what they look like. looks: those of the cards, then those of the materials (whole texture, no holes: for wood).
struct PlantLooks {
  std::vector<coppice_file_card> cards;
  std::vector<coppice_file_material> materials;
  std::vector<RasterCard> looks;
};

/// While no texture is there: base colours, no holes but the coverage the file states.
PlantLooks plain_looks(const PlantFile& file);

/// Takes over a texture into the looks of every card and material that shows it. chunk: a TEXTURE chunk that read_texture takes
/// returns  whether a card does
bool take_texture(PlantLooks& plant, std::uint32_t texture, std::span<const std::uint8_t> chunk);

}  // namespace coppice::gpu
