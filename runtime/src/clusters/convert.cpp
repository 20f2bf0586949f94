#include "convert.h"

#include <algorithm>
#include <cmath>

#include "reader.h"
#include "select.h"

namespace coppice::gpu {

static_assert(kPageSplits == COPPICE_PAGE_SPLITS && kPageNodes == 2 * COPPICE_PAGE_SPLITS);
static_assert(kMaxWoodLods == COPPICE_MAX_WOOD_LODS && kMaxLeafMeshes == COPPICE_MAX_LEAF_MESHES);

namespace {

std::uint32_t snorm16(float value) {
  return static_cast<std::uint32_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * 32767.0f)) & 0xffffu;
}

float sign(float value) {
  return value >= 0.0f ? 1.0f : -1.0f;
}

/// The octahedron's lower half is folded outwards into the corners of the square.
std::uint32_t octahedral(const std::array<float, 3>& normal) {
  const float sum = std::abs(normal[0]) + std::abs(normal[1]) + std::abs(normal[2]);
  if (!(sum > 0.0f)) return snorm16(0.0f) | snorm16(0.0f) << 16;
  float x = normal[0] / sum;
  float y = normal[1] / sum;
  if (normal[2] < 0.0f) {
    const float folded_x = (1.0f - std::abs(y)) * sign(x);
    y = (1.0f - std::abs(x)) * sign(y);
    x = folded_x;
  }
  return snorm16(x) | snorm16(y) << 16;
}

}  // namespace

Card gpu_card(const coppice_file_card& card) {
  Card converted{.material = card.material};
  for (std::size_t i = 0; i < 4; ++i) converted.uv[i] = {card.uv[i][0], card.uv[i][1]};
  return converted;
}

Material gpu_material(const coppice_file_material& material) {
  const std::uint32_t texture = material_texture(material), normal_map = material_normal_map(material);
  const std::uint32_t coverage = material.flags >> COPPICE_MATERIAL_COVERAGE_SHIFT & 0xffu;
  return {.base_color = {material.base_color[0], material.base_color[1], material.base_color[2], material.base_color[3]},
          .alpha_cutoff = material.alpha_cutoff,
          .texture = texture == COPPICE_NO_TEXTURE ? kNoTexture : texture,
          .coverage = coverage > 0 ? static_cast<float>(coverage) / 255.0f : 1.0f,
          .crown_normals = material_crown_normals(material),
          .normal_map = normal_map == COPPICE_NO_TEXTURE ? kNoTexture : normal_map};
}

WoodVertex gpu_wood_vertex(const coppice::WoodVertex& vertex) {
  return {.position = {vertex.position[0], vertex.position[1], vertex.position[2]},
          .normal = octahedral(vertex.normal),
          .uv = {vertex.uv[0], vertex.uv[1]},
          .material = vertex.material};
}

LeafMeshVertex gpu_leaf_mesh_vertex(const coppice::WoodVertex& vertex) {
  return {.position = {vertex.position[0], vertex.position[1], vertex.position[2]},
          .normal = octahedral(vertex.normal),
          .uv = {vertex.uv[0], vertex.uv[1]},
          .stalk_xy = vertex.stalk[0] | std::uint32_t{vertex.stalk[1]} << 16,
          .stalk_z_material = vertex.stalk[2] | vertex.material << 16};
}

LeafBox leaf_box(const Plant& plant) {
  return {plant.box_min, plant.box_step, plant.quantised_max};
}

Plant gpu_plant(const coppice_file_plant& plant) {
  Plant converted{};
  converted.sphere_center = {plant.sphere_center[0], plant.sphere_center[1], plant.sphere_center[2]};
  converted.sphere_radius = plant.sphere_radius;
  converted.box_min = {plant.leaf_box_min[0], plant.leaf_box_min[1], plant.leaf_box_min[2]};
  const auto steps = static_cast<float>(quantised_max(plant));
  converted.box_step = {(plant.leaf_box_max[0] - plant.leaf_box_min[0]) / steps, (plant.leaf_box_max[1] - plant.leaf_box_min[1]) / steps,
                        (plant.leaf_box_max[2] - plant.leaf_box_min[2]) / steps};
  converted.quantised_max = quantised_max(plant);
  converted.leaf_count = plant.leaf_count;
  converted.error_level_count = plant.error_level_count;
  converted.error_size_count = plant.error_size_count;
  converted.wood_lod_count = plant.wood_lod_count;
  return converted;
}

uvec2 gpu_address(std::uint64_t address) {
  return {static_cast<std::uint32_t>(address), static_cast<std::uint32_t>(address >> 32)};
}

}  // namespace coppice::gpu
