#include "select.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "check.h"

namespace coppice {

std::array<vec4, 5> frustum_planes(const mat4& clip_from_world, const vec4& key_row) {
  const mat4 rows = transpose(clip_from_world);
  const vec4 &x = rows.column[0], &y = rows.column[1], &w = rows.column[3];
  std::array<vec4, 5> planes{w + x, w - x, w + y, w - y, w - key_row};
  for (vec4& plane : planes) plane = plane * (1.0f / length(plane.xyz()));
  return planes;
}

Result<HookArray<std::uint32_t>> pack_lod_table(const PlantFile& file, const coppice_allocator& allocator) {
  const std::size_t sizes = file.error_sizes_px.size(), missing = file.leaf_mesh_error_px.empty() ? sizes : 0;
  COPPICE_TRY(words,
              HookArray<std::uint32_t>::allocate(allocator, file.error_leaf_counts.size() + sizes + file.error_px.size() +
                                                                file.leaf_mesh_error_px.size() + missing + file.wood_error_px.size()));
  std::uint32_t* next = std::ranges::copy(file.error_leaf_counts, words.data()).out;
  const auto append = [&](const HookArray<float>& values) {
    next = std::ranges::transform(values, next, [](float value) { return std::bit_cast<std::uint32_t>(value); }).out;
  };
  append(file.error_sizes_px);
  append(file.error_px);
  append(file.leaf_mesh_error_px);
  next += missing;
  append(file.wood_error_px);
  return words;
}

lod::CoppiceTable lod_table(const PlantFile& file, std::span<const std::uint32_t> words) {
  lod::CoppiceTable table{};
  table.words = words.data();
  table.level_count = static_cast<std::uint32_t>(file.error_leaf_counts.size());
  table.size_count = static_cast<std::uint32_t>(file.error_sizes_px.size());
  table.wood_lod_count = file.plant.wood_lod_count;
  return table;
}

InstanceLod select_lod(const InstanceSphere& instance, std::uint32_t seed, const LodPlant& plant, const LodView& view) {
  const float size_px =
      lod::coppice_projected_size_px(size_distance_m(view, instance.center_m), instance.radius_m, view.near_m, view.focal_px);
  const float threshold_px = lod::coppice_instance_threshold_px(view.error_px * instance.threshold_share, seed);
  const auto finest = static_cast<float>(plant.resident_leaf_count);
  const lod::CoppiceColumn column = lod::coppice_column(plant.table, size_px);
  InstanceLod result;
  result.leaf_meshes = plant.leaf_meshes_resident && (view.full || lod::coppice_needs_leaf_meshes(plant.table, column, threshold_px));
  const bool between = plant.leaf_meshes_resident && !result.leaf_meshes;
  const float cut_px = between ? lod::coppice_cut_threshold_px(plant.table, column, threshold_px) : threshold_px;
  float cut = lod::coppice_drawn_leaf_count(plant.table, column, cut_px);
  if (view.discrete) cut = lod::coppice_discrete_leaf_count(cut, lod::coppice_table_leaf_count(plant.table, plant.table.level_count - 1));
  result.leaf_count = view.full ? finest : std::min(cut, finest);
  if (plant.table.wood_lod_count == 0) return result;
  const std::uint32_t chosen = view.full ? 0 : lod::coppice_wood_lod(plant.table, column, threshold_px);
  result.wood_lod = lod::coppice_resident_wood_lod(plant.resident_wood_mask, chosen, plant.table.wood_lod_count);
  return result;
}

void select_lods(std::span<const InstanceSphere> instances, std::span<const LodPlant> plants, const LodView& view,
                 std::span<InstanceLod> out) {
  COPPICE_ASSERT(out.size() == instances.size());
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (instances[i].plant == InstanceSphere::kNoPlant) {
      out[i] = {.leaf_count = 0.0f};
      continue;
    }
    COPPICE_ASSERT(instances[i].plant < plants.size());
    out[i] = select_lod(instances[i], static_cast<std::uint32_t>(i), plants[instances[i].plant], view);
  }
}

std::size_t select_cut(std::span<const std::uint32_t> node_split, std::uint32_t leaf_count, std::span<std::uint32_t> out) {
  COPPICE_ASSERT(leaf_count > 0 && node_split.size() >= 2 * std::size_t{leaf_count} - 1);
  std::size_t count = 0;
  for (std::uint32_t node = 0; node < 2 * leaf_count - 1; ++node)
    if (lod::coppice_node_alive(node, node_split[node], leaf_count) && count < out.size()) out[count++] = node;
  return count;
}

float error_px_at(const lod::CoppiceTable& table, float leaf_count, float size_px) {
  return lod::coppice_error_px(table, leaf_count, lod::coppice_column(table, size_px));
}

}  // namespace coppice
