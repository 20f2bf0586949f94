#pragma once

// What cards, materials and triangles of meshes show from afar, for the compute rasteriser.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "coppice_shared.h"
#include "reader.h"
#include "texels.h"

namespace coppice::gpu {

/// A plant's cards and materials and what they look like. looks: those of the cards, then those of the materials (no holes: for meshes).
struct PlantLooks {
  std::vector<coppice_file_material> materials;
  std::vector<CardLook> looks;
  std::vector<Texels> small;  ///< [textures] about 64 px, of those that were taken over; none where no triangle_look needs them
  std::vector<std::uint32_t> wood_colors;       ///< Plant's
  std::vector<std::uint32_t> first_wood_color;  ///< [materials] of kWoodColors; of one where there is no texture

  /// Where in `looks` those of the materials begin.
  [[nodiscard]] std::uint32_t first_material() const { return static_cast<std::uint32_t>(looks.size() - materials.size()); }
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
/// Splat::look's, without what is above it.
std::uint32_t packed_albedo(const std::array<float, 3>& albedo);
/// Whether what triangle_look needs of the material is there.
bool has_texels(const PlantLooks& plant, std::uint32_t material);
/// Whether its texture may have holes.
bool is_masked(const coppice_file_material& material);

/// Of the cards, as the file says.
std::vector<CardLook> card_looks(const PlantFile& file);
/// While no texture is there: cards as the file says, meshes in base colours and without holes.
PlantLooks plain_looks(const PlantFile& file);

/// Takes over a texture into the looks of every material that shows it. chunk: a TEXTURE chunk that read_texture takes
void take_texture(PlantLooks& plant, std::uint32_t texture, std::span<const std::uint8_t> chunk);

}  // namespace coppice::gpu
