#include "chunk_value.h"

#include <algorithm>

namespace coppice {

namespace {

/// Value of a chunk in demand whose gain in the table is 0, px an instance: small beside any measured gain, so that it comes last.
constexpr float kMinGainPx = 1e-4f;
/// Share of a plant's size that counts as wrong while a texture is missing.
constexpr float kMissingTextureError = 0.25f;
/// Leaf meshes are requested when their quads' error is at this share of the threshold, so that they have arrived when it reaches the
/// threshold.
constexpr float kLeafMeshHeadStart = 0.5f;

/// The smallest threshold any instance may have.
float min_threshold_px(const LodView& view) {
  return view.full ? 0.0f : view.error_px * (1.0f - lod::kCoppiceThresholdSpread);
}

/// The size, px, that represents a bin's instances.
float bin_size_px(const PlantDemand& demand, std::uint32_t bin) {
  return bin + 1 < kSizeBinCount ? std::min(size_bin_px(bin), demand.max_size_px) : demand.max_size_px;
}

/// Sums over instances how much the visible error falls. error_before/after: px, as a function of size in px
template <class Before, class After>
float summed_gain_px(const PlantDemand& demand, float threshold_px, Before error_before, After error_after) {
  float gain = 0.0f;
  for (std::uint32_t bin = 0; bin < kSizeBinCount; ++bin) {
    const float weight = demand.instances[bin];
    if (weight == 0.0f) continue;
    const float size_px = bin_size_px(demand, bin);
    const float fall = std::max(error_before(size_px), threshold_px) - std::max(error_after(size_px), threshold_px);
    gain += weight * std::max(fall, kMinGainPx);
  }
  return gain;
}

float first_leaf_count(const ValuedPlant& plant, std::uint32_t page) {
  return static_cast<float>(std::min(std::uint64_t{page} * COPPICE_PAGE_SPLITS + 1, std::uint64_t{plant.leaf_count}));
}

lod::CoppiceColumn column_of(const ValuedPlant& plant, float size_px) {
  return lod::coppice_column(plant.table, size_px);
}

/// Number of leaves in the finest cut that any instance demands. Instances drawn with leaf meshes demand what they would show without.
std::uint32_t demanded_leaf_count(const ValuedPlant& plant, const PlantDemand& demand, float threshold_px, bool leaf_meshes) {
  float finest = lod::coppice_leaf_count(plant.table, column_of(plant, demand.max_size_px), threshold_px);
  for (std::uint32_t bin = 0; leaf_meshes && bin < kSizeBinCount; ++bin) {
    const lod::CoppiceColumn column = column_of(plant, bin_size_px(demand, bin));
    if (demand.instances[bin] == 0.0f || lod::coppice_needs_leaf_meshes(plant.table, column, threshold_px)) continue;
    const float cut_px = lod::coppice_cut_threshold_px(plant.table, column, threshold_px);
    finest = std::max(finest, lod::coppice_leaf_count(plant.table, column, cut_px));
  }
  return lod::coppice_whole_leaf_count(finest);
}

}  // namespace

bool demands_leaf_meshes(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view) {
  if (!(demand.max_size_px > 0.0f) || plant.leaf_mesh_bytes == 0) return false;
  const float threshold_px = kLeafMeshHeadStart * min_threshold_px(view);
  return view.full || lod::coppice_needs_leaf_meshes(plant.table, column_of(plant, demand.max_size_px), threshold_px);
}

DemandedDetail demanded_detail(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view, bool for_others) {
  DemandedDetail demanded;
  demanded.finest_wood = plant.table.wood_lod_count;
  if (!(demand.max_size_px > 0.0f)) return demanded;
  const float threshold_px = min_threshold_px(view);
  demanded.leaf_meshes = for_others || demands_leaf_meshes(plant, demand, view);
  const std::uint32_t leaves =
      view.full ? plant.leaf_count : std::min(demanded_leaf_count(plant, demand, threshold_px, demanded.leaf_meshes), plant.leaf_count);
  demanded.page_count = (leaves - 1 + COPPICE_PAGE_SPLITS - 1) / COPPICE_PAGE_SPLITS;
  demanded.finest_wood = demanded_wood(plant, demand, view);
  demanded.max_texture_bytes = UINT64_MAX;
  return demanded;
}

std::uint32_t demanded_wood(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view) {
  if (plant.table.wood_lod_count == 0 || view.full) return 0;
  return lod::coppice_wood_lod(plant.table, column_of(plant, demand.max_size_px), min_threshold_px(view));
}

bool needs_textures(const PlantDemand& demand, const LodView& view) {
  return kMissingTextureError * demand.max_size_px > view.error_px;
}

DemandedDetail merged(const DemandedDetail& a, const DemandedDetail& b) {
  return {.page_count = std::max(a.page_count, b.page_count),
          .finest_wood = std::min(a.finest_wood, b.finest_wood),
          .max_texture_bytes = std::max(a.max_texture_bytes, b.max_texture_bytes),
          .leaf_meshes = a.leaf_meshes || b.leaf_meshes};
}

float page_value(const ValuedPlant& plant, const DemandedDetail& demanded, const PlantDemand& demand, const LodView& view,
                 std::uint32_t page) {
  if (page >= demanded.page_count) return 0.0f;
  float best = 0.0f;
  for (std::uint32_t run = 1; run <= 64; run *= 4) {
    const std::uint32_t end = std::min(page + run, demanded.page_count);
    const float before = first_leaf_count(plant, page), after = first_leaf_count(plant, end);
    const float gain = summed_gain_px(
        demand, min_threshold_px(view), [&](float size_px) { return error_px_at(plant.table, before, size_px); },
        [&](float size_px) { return error_px_at(plant.table, after, size_px); });
    best = std::max(best, gain / (static_cast<float>(end - page) * static_cast<float>(plant.page_bytes)));
    if (end == demanded.page_count) break;
  }
  return best;
}

float wood_value(const ValuedPlant& plant, const DemandedDetail& demanded, const PlantDemand& demand, const LodView& view,
                 std::uint32_t lod, std::uint64_t bytes) {
  if (lod < demanded.finest_wood || lod >= plant.table.wood_lod_count) return 0.0f;
  const bool coarsest = lod + 1 == plant.table.wood_lod_count;
  const float gain = summed_gain_px(
      demand, min_threshold_px(view),
      [&](float size_px) { return coarsest ? size_px : lod::coppice_wood_error_px(plant.table, lod + 1, column_of(plant, size_px)); },
      [&](float size_px) { return lod::coppice_wood_error_px(plant.table, lod, column_of(plant, size_px)); });
  return gain / static_cast<float>(std::max<std::uint64_t>(bytes, 1));
}

float texture_value(const DemandedDetail& demanded, const PlantDemand& demand, std::uint64_t bytes) {
  if (demanded.max_texture_bytes == 0) return 0.0f;
  const float gain = summed_gain_px(
      demand, 0.0f, [](float size_px) { return kMissingTextureError * size_px; }, [](float) { return 0.0f; });
  return gain / static_cast<float>(std::max<std::uint64_t>(bytes, 1));
}

float leaf_mesh_value(const ValuedPlant& plant, const DemandedDetail& demanded, const PlantDemand& demand, const LodView& view) {
  if (!demanded.leaf_meshes) return 0.0f;
  const float gain = summed_gain_px(
      demand, min_threshold_px(view),
      [&](float size_px) { return lod::coppice_leaf_mesh_error_px(plant.table, column_of(plant, size_px)); }, [](float) { return 0.0f; });
  return gain / static_cast<float>(std::max<std::uint64_t>(plant.leaf_mesh_bytes, 1));
}

}  // namespace coppice
