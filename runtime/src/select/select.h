#pragma once

// Which cut an instance is drawn with: the CPU reference of the selection shader, on plain spans. The arithmetic is coppice_lod.h's.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "coppice_lod.h"
#include "reader.h"

namespace coppice {

/// Half-spaces that hold what a view sees, of places p relative to its eye: dot(xyz, p) + w >= 0, xyz unit. Left, right and the two others,
/// then the near plane; no far one, as fog hides what lies behind it. key_row: LodEye's
std::array<vec4, 5> frustum_planes(const mat4& clip_from_world, const vec4& key_row);

/// One of a view's eyes: what differs between them.
struct LodEye {
  mat4 clip_from_world{};        ///< of places relative to LodView::eye_m; w is the depth along the axis, m; of a parallel view 1
  vec4 key_row{};                ///< dot(key_row, place) / w is 1 at the near plane and 0 at the far one, whichever way depth runs
  std::array<vec4, 5> planes{};  ///< frustum_planes of these
  vec3 place_m{0, 0, 0};         ///< relative to LodView::eye_m
  std::int32_t x_px = 0, y_px = 0;
};

inline constexpr std::size_t kMostEyes = 2;

/// The camera as selection sees it.
struct LodView {
  dvec3 eye_m{0, 0, 0};     ///< world space; of two eyes the middle
  dvec3 origin_m{0, 0, 0};  ///< what the engine's coordinates count from
  std::uint32_t layer_mask = 0xffffffffu;
  float focal_px = 1.0f;        ///< half the image height times |clip_from_view[1][1]|; of a parallel view px a metre
  float near_m = 0.1f;          ///< > 0; nearer counts as this near; of a parallel view 1
  float error_px = 2.0f;        ///< threshold, > 0
  float reach_share = 0.0f;     ///< by how much wind can move a place of a plant, at most, in parts of the plant's radius
  bool looks_around = true;     ///< it may turn: what is out of view is wanted too, at half its size
  bool discrete = false;        ///< COPPICE_LOD_DISCRETE: cuts are the discrete levels'
  bool full = false;            ///< COPPICE_LOD_FULL: every resident leaf, as modelled where that is resident, and the finest wood
  bool parallel = false;        ///< an orthographic projection, whose sizes do not go by distance
  vec3 toward_viewer{0, 0, 1};  ///< unit: the axis of a perspective, the first eye's; against the rays of a parallel view
  std::array<LodEye, kMostEyes> eyes{};
  std::uint32_t eye_count = 1;
};

/// How far inside the view a place lies, m: from the nearest plane of the eye that has it farthest inside; negative outside.
inline float depth_in_view(const LodView& view, const dvec3& place_m) {
  const vec3 place = (place_m - view.eye_m).rounded();
  const auto depth_in = [&](const LodEye& eye) {
    float nearest_m = dot(eye.planes[0].xyz(), place) + eye.planes[0].w;
    for (std::size_t i = 1; i < eye.planes.size(); ++i) nearest_m = std::min(nearest_m, dot(eye.planes[i].xyz(), place) + eye.planes[i].w);
    return nearest_m;
  };
  const float first_m = depth_in(view.eyes[0]);
  return view.eye_count == 1 ? first_m : std::max(first_m, depth_in(view.eyes[1]));
}

/// By how much the sphere of a plant of this radius, or a sphere that holds it, is larger in the view's wind, m.
inline float wind_reach_m(const LodView& view, float plant_radius_m) {
  return view.reach_share * plant_radius_m;
}

/// The distance from the eye by which sizes go, m; to be taken as near_m where it is less.
inline float size_distance_m(const LodView& view, const dvec3& place_m) {
  return view.parallel ? 0.0f : length((place_m - view.eye_m).rounded());
}

/// One instance's bounding sphere in world space.
struct InstanceSphere {
  dvec3 center_m{0, 0, 0};
  float radius_m = 0.0f;
  std::uint32_t plant = kNoPlant;          ///< index of its plant; kNoPlant: a hole in the array, skipped
  std::uint32_t layer_mask = 0xffffffffu;  ///< not drawn where it shares no bit with the view's
  float threshold_share = 1.0f;            ///< its error threshold over the view's

  static constexpr std::uint32_t kNoPlant = 0xffffffffu;
};

/// A plant as selection sees it.
struct LodPlant {
  lod::CoppiceTable table{};
  std::uint32_t resident_leaf_count = 1;  ///< cuts are clamped to it
  std::uint32_t resident_wood_mask = 0;   ///< bit i: wood LoD i can be drawn
  bool leaf_meshes_resident = false;      ///< all of them
};

/// What an instance is drawn with.
struct InstanceLod {
  float leaf_count = 1.0f;                         ///< fractional m in [1, resident_leaf_count]; what is not drawn where meshes are
  bool leaf_meshes = false;                        ///< drawn instead of quads
  std::uint32_t wood_lod = COPPICE_MAX_WOOD_LODS;  ///< table.wood_lod_count or more: no wood
};

/// A plant's packed table, as CPU and GPU read it through coppice_lod.h: leaf counts | sizes | errors | wood triangles |
/// leaf mesh errors, in 32-bit words. errors  out_of_memory
Result<HookArray<std::uint32_t>> pack_lod_table(const PlantFile& file, const coppice_allocator& allocator);

/// The table's view for the C++ side. words must stay alive; first_word is 0.
lod::CoppiceTable lod_table(const PlantFile& file, std::span<const std::uint32_t> words);

/// One instance. instance_index: offsets the threshold, see coppice_instance_threshold_px.
InstanceLod select_lod(const InstanceSphere& instance, std::uint32_t instance_index, const LodPlant& plant, const LodView& view);

/// All instances. out: [instances.size()]; holes get leaf_count 0. plants is indexed by InstanceSphere::plant (asserted).
void select_lods(std::span<const InstanceSphere> instances, std::span<const LodPlant> plants, const LodView& view,
                 std::span<InstanceLod> out);

/// Nodes of cut(leaf_count), ascending.
/// node_split  [>= 2 * leaf_count - 1] split that replaces each node, lod::kCoppiceNoSplit if none
/// out         room for leaf_count ids
/// returns     ids written: leaf_count for a valid tree
std::size_t select_cut(std::span<const std::uint32_t> node_split, std::uint32_t leaf_count, std::span<std::uint32_t> out);

/// coppice_error_px of a size.
float error_px_at(const lod::CoppiceTable& table, float leaf_count, float size_px);

}  // namespace coppice
