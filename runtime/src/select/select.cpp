#include "select.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "check.h"

namespace coppice {

namespace {

float distance_m(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

}  // namespace

std::vector<std::uint32_t> pack_lod_table(const PlantFile& file) {
  std::vector<std::uint32_t> words(file.error_leaf_counts);
  for (float size : file.error_sizes_px) words.push_back(std::bit_cast<std::uint32_t>(size));
  for (float error : file.error_px) words.push_back(std::bit_cast<std::uint32_t>(error));
  for (float error : file.leaf_mesh_error_px) words.push_back(std::bit_cast<std::uint32_t>(error));
  if (file.leaf_mesh_error_px.empty()) words.resize(words.size() + file.error_sizes_px.size(), 0);
  for (float error : file.wood_error_px) words.push_back(std::bit_cast<std::uint32_t>(error));
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

InstanceLod select_lod(const InstanceSphere& instance, std::uint32_t instance_index, const LodPlant& plant, const LodView& view) {
  const float size_px =
      lod::coppice_projected_size_px(distance_m(instance.center_m, view.eye_m), instance.radius_m, view.near_m, view.focal_px);
  const float threshold_px = lod::coppice_instance_threshold_px(view.error_px, instance_index);
  const auto finest = static_cast<float>(plant.resident_leaf_count);
  const lod::CoppiceColumn column = lod::coppice_column(plant.table, size_px);
  InstanceLod result;
  result.leaf_meshes = plant.leaf_meshes_resident && (view.full || lod::coppice_wants_leaf_meshes(plant.table, column, threshold_px));
  const bool between = plant.leaf_meshes_resident && !result.leaf_meshes;
  const float cut_px = between ? lod::coppice_cut_threshold_px(plant.table, column, threshold_px) : threshold_px;
  float cut = lod::coppice_drawn_leaf_count(plant.table, column, cut_px);
  if (view.discrete) cut = lod::coppice_discrete_leaf_count(cut, lod::coppice_table_leaf_count(plant.table, plant.table.level_count - 1));
  result.leaf_count = view.full ? finest : std::min(cut, finest);
  if (plant.table.wood_lod_count == 0) return result;
  const std::uint32_t wanted = view.full ? 0 : lod::coppice_wood_lod(plant.table, column, threshold_px);
  result.wood_lod = lod::coppice_resident_wood_lod(plant.resident_wood_mask, wanted, plant.table.wood_lod_count);
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
  const lod::CoppiceColumn column = lod::coppice_column(table, size_px);
  std::uint32_t level = 0;
  while (level + 1 < table.level_count && static_cast<float>(lod::coppice_table_leaf_count(table, level + 1)) <= leaf_count) ++level;
  const float error_px = lod::coppice_level_error_px(table, level, column);
  const auto below = static_cast<float>(lod::coppice_table_leaf_count(table, level));
  if (level + 1 == table.level_count || leaf_count <= below) return error_px;
  const auto above = static_cast<float>(lod::coppice_table_leaf_count(table, level + 1));
  const float share = std::log2(leaf_count / below) / std::log2(above / below);
  return error_px + (lod::coppice_level_error_px(table, level + 1, column) - error_px) * share;
}

}  // namespace coppice
