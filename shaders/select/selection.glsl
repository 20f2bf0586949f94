// Selects what an instance is drawn with, by its error table. Only show_debug_color writes anything.
// After bindings.glsl with COPPICE_CULL_ACCESS.

#include "coppice_light.h"
#include "wind.glsl"
#include "debug_view.glsl"

layout(constant_id = 0) const uint kDebugged = 0;  // 1: also computes colours for view.debug_view

// An instance as seen in the view.
struct Candidate {
  uint slot;
  Instance instance;
  Plant plant;
  CoppiceTable table;
  vec3 center;  // centre of its sphere, world space
  float radius_m;
  float reach_m;     // maximum motion by wind
  float distance_m;  // size_distance_m of the centre
  float size_px;
  float error_px;  // the view's, with the instance's bias
  float threshold_px;
};

bool is_candidate(Instance instance) { return plant_of(instance) != kNoPlant && (instance.layer_mask & view.layer_mask) != 0; }

Candidate candidate_of(uint slot, Instance instance) {
  Plant plant = plants[plant_of(instance)];
  // Loops run through the table, so counts from memory are limited.
  CoppiceTable table = CoppiceTable(plant_of(instance) * kTableStride, min(plant.error_level_count, kMaxErrorLevels),
                                    min(plant.error_size_count, kMaxErrorSizes), min(plant.wood_lod_count, kMaxWoodLods));
  vec3 center = world_from_object(instance, plant.sphere_center);
  float radius_m = instance.scale * plant.sphere_radius;
  float distance_m = size_distance_m(center);
  float size_px = coppice_projected_size_px(distance_m, radius_m, view.near_m, view.focal_px);
  float error_px = view.error_px * exp2(lod_bias_of(instance));
  float reach_m = radius_m + wind_reach_m(instance);
  float threshold_px = coppice_instance_threshold_px(error_px, seed_of(instance));
  return Candidate(slot, instance, plant, table, center, radius_m, reach_m, distance_m, size_px, error_px, threshold_px);
}

bool has_leaves(Plant plant) { return plant.resident_leaf_count > 0; }
bool shows_leaves(Candidate candidate) { return has_leaves(candidate.plant) && leaf_share_of(candidate.instance) > 0.0; }
// Shadow casters are drawn with quads.
bool has_leaf_meshes(Plant plant) { return view.is_shadow == 0 && plant.leaf_mesh_count > 0; }

float finest_cut(Plant plant) { return max(float(plant.resident_leaf_count), 1.0); }

struct Selection {
  float cut;
  bool meshes;  // leaf meshes instead of the cut
};

// cut: coppice_drawn_leaf_count of the threshold; meshes: leaf meshes may be drawn
Selection selection_of(Candidate candidate, CoppiceColumn column, float cut, bool meshes) {
  CoppiceTable table = candidate.table;
  float threshold_px = candidate.threshold_px, finest = finest_cut(candidate.plant);
  bool needs_meshes = meshes && (view.lod_full != 0 || coppice_needs_leaf_meshes(table, column, threshold_px));
  if (meshes && !needs_meshes) cut = coppice_drawn_leaf_count(table, column, coppice_cut_threshold_px(table, column, threshold_px));
  if (view.lod_discrete != 0) cut = coppice_discrete_leaf_count(cut, candidate.plant.leaf_count);
  return Selection(view.lod_full != 0 ? finest : min(cut, finest), needs_meshes);
}

// kMaxWoodLods if there is none to draw.
uint wood_lod_of(Candidate candidate, CoppiceColumn column) {
  if (candidate.plant.wood_resident_mask == 0) return kMaxWoodLods;
  uint chosen = view.lod_full != 0 ? 0 : coppice_wood_lod(candidate.table, column, candidate.threshold_px);
  return coppice_resident_wood_lod(candidate.plant.wood_resident_mask, chosen, candidate.plant.wood_lod_count);
}

// How an instance's leaves are drawn.
struct Shown {
  bool rasterised, meshes;
  float leaf_count;
  float pass_share;  // share of the rasterised instances: 0 in the first culling pass, 1 in the last
};

void show_debug_color(Candidate candidate, CoppiceColumn column, Shown shown) {
  if (kDebugged == 0) return;
  vec3 color = kNotCounted;
  float doublings = max(log2(float(candidate.plant.leaf_count)), 1e-6);
  if (view.debug_view == kDebugLod) color = shown.meshes ? vec3(1.0) : ramp(log2(shown.leaf_count) / doublings);
  if (view.debug_view == kDebugPath)
    color = shown.rasterised ? vec3(0.1, 0.8, 0.1) : shown.meshes ? vec3(0.9, 0.1, 0.7) : kHardwareLeaves;
  if (view.debug_view == kDebugOcclusion && shown.rasterised) color = ramp(shown.pass_share);
  if (view.debug_view == kDebugError) {
    float error_px = shown.meshes ? 0.0 : coppice_error_px(candidate.table, shown.leaf_count, column);
    color = ramp(log2(max(2.0 * error_px, 1.0)) / 6.0);
  }
  if (view.debug_view == kDebugResidency) color = ramp(1.0 - log2(float(candidate.plant.resident_leaf_count)) / doublings);
  DebugColorArray(view.debug_colors).at[candidate.slot] = packUnorm4x8(vec4(color, 1.0));
}
