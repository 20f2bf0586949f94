#pragma once

// What cards, materials and triangles of meshes show from afar, for the compute rasteriser.

#include <array>
#include <cstdint>
#include <span>

#include "coppice_light.h"
#include "crown_light.h"
#include "reader.h"
#include "texels.h"

namespace coppice::gpu {

/// A plant's cards and materials and what they look like.
struct PlantLooks {
  HookArray<coppice_file_material> materials;
  HookArray<CardLook> looks;  ///< those of the cards, then those of the materials (no holes: for meshes)
  HookArray<Texels> small;    ///< [textures] PlantFile::small_textures; none where no triangle_look needs them
  /// Of a textured material the means of its texture's parts, 32 x 32 of them, then 16 x 16, and so on to one, rows of u, from v = 0 on; of
  /// others its base colour. As pack_albedo.
  HookArray<std::uint32_t> wood_colors;
  HookArray<std::uint32_t> first_wood_color;  ///< [materials]

  /// Where in `looks` those of the materials begin.
  [[nodiscard]] std::uint32_t first_material() const { return static_cast<std::uint32_t>(looks.size() - materials.size()); }
  [[nodiscard]] std::span<const CardLook> cards() const { return looks.span().first(first_material()); }
  /// From the allocator hook.
  [[nodiscard]] std::size_t bytes() const;
};

/// What a plant's leaves and wood look like, and what light reaches them.
struct PlantAppearance {
  const PlantLooks& looks;
  const CrownLight& light;
};

/// What a triangle of a leaf mesh or of wood shows.
struct TriangleLook {
  vec3 albedo{};
  float coverage = 1;  ///< share of it that is no hole
};

/// Texture coordinates of a triangle's corners.
using TriangleUvs = std::array<std::array<float, 2>, 3>;

/// Looked at in the middles of side * side equal parts.
TriangleLook triangle_look(const PlantLooks& plant, std::uint32_t material, const TriangleUvs& uvs, std::uint32_t side);
/// Of a triangle of wood, as pack_albedo: of the part of the texture that holds its middle and is about as large as it.
std::uint32_t wood_color_of(const PlantLooks& plant, std::uint32_t material, const TriangleUvs& uvs);
/// Whether its texture may have holes.
bool is_masked(const coppice_file_material& material);

/// What the front of a file says of them. errors  out_of_memory
Result<PlantLooks> plant_looks(const PlantFile& file, const coppice_allocator& allocator);

}  // namespace coppice::gpu
