#pragma once

// What a card shows from afar, for the compute rasteriser: a mean colour, and an outline of 8 x 8 cells instead of a texture.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "raster_shared.h"
#include "reader.h"

namespace coppice::gpu {

/// A mip level of a texture.
struct Texels {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  ///< sRGB
};

/// A plant's cards and what they look like. looks: those of the cards, then those of the materials (no holes: for meshes).
struct PlantLooks {
  std::vector<coppice_file_card> cards;
  std::vector<coppice_file_material> materials;
  std::vector<RasterCard> looks;
  std::vector<Texels> small;  ///< [textures] about 64 px, of those that were taken over; none where no triangle_look needs them
  std::vector<std::uint32_t> wood_colors;       ///< RasterPlant's
  std::vector<std::uint32_t> first_wood_color;  ///< [materials] of kWoodColors; of one where there is no texture
};

/// What a triangle of a leaf mesh or of wood shows.
struct TriangleLook {
  std::array<float, 3> albedo{};
  float coverage = 1;  ///< share of it that is no hole
};

/// Texture coordinates of a triangle's corners.
using TriangleUvs = std::array<std::array<float, 2>, 3>;

/// Looked at in the middles of side * side equal parts. The material's texture has been taken over, or there is none
TriangleLook triangle_look(const PlantLooks& plant, std::uint32_t material, const TriangleUvs& uvs, std::uint32_t side);
/// The wood color of a triangle: of the part of the texture that holds its middle and is about as large as it.
std::uint32_t wood_color_of(const PlantLooks& plant, std::uint32_t material, const TriangleUvs& uvs);
/// RasterSplat::look's, without what is above it.
std::uint32_t packed_albedo(const std::array<float, 3>& albedo);
/// Whether what triangle_look needs of the material is there.
bool has_texels(const PlantLooks& plant, std::uint32_t material);
/// Whether its texture may have holes.
bool is_masked(const coppice_file_material& material);

/// While no texture is there: base colours, no holes but the coverage the file states.
PlantLooks plain_looks(const PlantFile& file);

/// Takes over a texture into the looks of every card and material that shows it. chunk: a TEXTURE chunk that read_texture takes
/// returns  whether a card does
bool take_texture(PlantLooks& plant, std::uint32_t texture, std::span<const std::uint8_t> chunk);

}  // namespace coppice::gpu
