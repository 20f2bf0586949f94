#pragma once

// The appearance of cards, materials and triangles of meshes at a distance, for the compute rasteriser.

#include <array>
#include <cstdint>
#include <span>

#include "coppice_light.h"
#include "crown_light.h"
#include "reader.h"
#include "texels.h"

namespace coppice::gpu {

/// A plant's cards and materials, and their appearance.
struct PlantLooks {
  HookArray<coppice_file_material> materials;
  HookArray<CardLook> looks;  ///< first of the cards, then of the materials (without holes: for meshes)
  HookArray<Texels> small;    ///< [textures] PlantFile::small_textures; empty if no triangle_look needs them
  /// For a textured material the mean colours of 32 x 32 parts of its texture, then of 16 x 16, and so on to one; rows run along u, from v
  /// = 0 on. For other materials the base colour. Packed by pack_albedo.
  HookArray<std::uint32_t> wood_colors;
  HookArray<std::uint32_t> first_wood_color;  ///< [materials]

  /// Index in `looks` of the first material.
  [[nodiscard]] std::uint32_t first_material() const { return static_cast<std::uint32_t>(looks.size() - materials.size()); }
  [[nodiscard]] std::span<const CardLook> cards() const { return looks.span().first(first_material()); }
  /// Bytes from the allocator hook.
  [[nodiscard]] std::size_t bytes() const;
};

/// The appearance of a plant's leaves and wood, and the light that reaches them.
struct PlantAppearance {
  const PlantLooks& looks;
  const CrownLight& light;
};

/// The appearance of a triangle of a leaf mesh or of wood.
struct TriangleLook {
  vec3 albedo{};
  float coverage = 1;  ///< share of it that is no hole
};

/// Texture coordinates of a triangle's corners.
using TriangleUvs = std::array<std::array<float, 2>, 3>;

/// Samples the middles of side * side equal parts.
TriangleLook triangle_look(const PlantLooks& plant, std::uint32_t material, const TriangleUvs& uvs, std::uint32_t side);
/// Mean colour of the part of the texture that contains the triangle's middle and is about as large as the triangle, packed by pack_albedo.
std::uint32_t wood_color_of(const PlantLooks& plant, std::uint32_t material, const TriangleUvs& uvs);
/// True if its texture may have holes.
bool is_masked(const coppice_file_material& material);

/// Reads them from the front of a file. errors  out_of_memory
Result<PlantLooks> plant_looks(const PlantFile& file, const coppice_allocator& allocator);

}  // namespace coppice::gpu
