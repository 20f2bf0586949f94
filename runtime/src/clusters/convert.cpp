#include "convert.h"

#include <algorithm>

#include "reader.h"
#include "select.h"

namespace coppice::gpu {

static_assert(kPageSplits == COPPICE_PAGE_SPLITS && kPageNodes == 2 * COPPICE_PAGE_SPLITS);
static_assert(kMaxErrorLevels == COPPICE_MAX_ERROR_LEVELS && kMaxErrorSizes == COPPICE_MAX_ERROR_SIZES);
static_assert(kMaxWoodLods == COPPICE_MAX_WOOD_LODS && kMaxLeafMeshes == COPPICE_MAX_LEAF_MESHES);

Card gpu_card(const coppice_file_card& card) {
  Card converted{.material = card.material};
  for (std::size_t i = 0; i < 4; ++i) converted.uv[i] = {card.uv[i][0], card.uv[i][1]};
  return converted;
}

Material gpu_material(const coppice_file_material& material) {
  const std::uint32_t texture = material_texture(material), normal_map = material_normal_map(material);
  return {.base_color = {material.base_color[0], material.base_color[1], material.base_color[2], material.base_color[3]},
          .alpha_cutoff = material.alpha_cutoff,
          .texture = texture == COPPICE_NO_TEXTURE ? kNoTexture : texture,
          .sided_normals = (material.flags & COPPICE_MATERIAL_SIDED_NORMALS) != 0 ? 1.0f : 0.0f,
          .normal_map = normal_map == COPPICE_NO_TEXTURE ? kNoTexture : normal_map,
          .roughness = material.roughness};
}

WoodVertex gpu_wood_vertex(const coppice::WoodVertex& vertex) {
  return {.position = vec3(vertex.position),
          .normal = packSnorm2x16(octahedral(vec3(vertex.normal))),
          .uv = {vertex.uv[0], vertex.uv[1]},
          .material = vertex.material};
}

LeafMeshVertex gpu_leaf_mesh_vertex(const coppice::WoodVertex& vertex) {
  return {.position = vec3(vertex.position),
          .normal = packSnorm2x16(octahedral(vec3(vertex.normal))),
          .uv = {vertex.uv[0], vertex.uv[1]},
          .stalk_xy = vertex.stalk[0] | std::uint32_t{vertex.stalk[1]} << 16,
          .stalk_z_material = vertex.stalk[2] | vertex.material << 16};
}

LeafBox leaf_box(const Plant& plant) {
  return {plant.box_min, plant.box_step, plant.quantised_max};
}

Plant gpu_plant(const coppice_file_plant& plant) {
  Plant converted{};
  converted.sphere_center = vec3(plant.sphere_center);
  converted.sphere_radius = plant.sphere_radius;
  converted.box_min = vec3(plant.leaf_box_min);
  converted.box_step = (vec3(plant.leaf_box_max) - converted.box_min) / vec3(static_cast<float>(quantised_max(plant)));
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
