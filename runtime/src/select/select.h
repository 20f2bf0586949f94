#pragma once

// Selects the cut of an instance: the CPU reference of the selection shader, on plain spans. coppice_lod.h has the arithmetic.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "coppice_lod.h"
#include "coppice_shared.h"
#include "reader.h"

namespace coppice {

/// Half-spaces around the visible space, for places p relative to the eye: dot(xyz, p) + w >= 0, xyz unit. The order is left, right, the
/// two others, then the near plane. There is no far plane, because fog hides far things. key_row: LodEye's
std::array<vec4, 5> frustum_planes(const mat4& clip_from_world, const vec4& key_row);

/// The properties in which a view's eyes differ.
struct LodEye {
  mat4 clip_from_world{};        ///< for places relative to LodView::eye_m; w is the depth along the axis, m, and 1 in a parallel view
  vec4 key_row{};                ///< dot(key_row, place) / w is 1 at the near plane and 0 at the far one, in either direction of depth
  std::array<vec4, 5> planes{};  ///< frustum_planes of these
  vec3 place_m{0, 0, 0};         ///< relative to LodView::eye_m
  std::int32_t x_px = 0, y_px = 0;
};

inline constexpr std::size_t kMaxEyes = 2;

/// The camera for selection.
struct LodView {
  dvec3 eye_m{0, 0, 0};     ///< world space; the middle of two eyes
  dvec3 origin_m{0, 0, 0};  ///< the origin of the engine's coordinates
  std::uint32_t layer_mask = 0xffffffffu;
  float focal_px = 1.0f;        ///< half the image height times |clip_from_view[1][1]|; in a parallel view px a metre
  float near_m = 0.1f;          ///< > 0; smaller distances count as this; 1 in a parallel view
  float error_px = 2.0f;        ///< threshold, > 0
  float reach_share = 0.0f;     ///< maximum motion of a place by wind, relative to the plant's radius
  bool looks_around = true;     ///< the view may turn: plants out of view are in demand too, at half their size
  bool discrete = false;        ///< COPPICE_LOD_DISCRETE: uses cuts of discrete levels
  bool full = false;            ///< COPPICE_LOD_FULL: every resident leaf, or its leaf meshes if they are resident, and the finest wood
  bool parallel = false;        ///< orthographic: sizes do not depend on distance
  vec3 toward_viewer{0, 0, 1};  ///< unit: the axis of a perspective, for two eyes the first's; against the rays of a parallel view
  std::array<LodEye, kMaxEyes> eyes{};
  std::uint32_t eye_count = 1;
};

/// Distance of a place from the nearest plane, m, in the eye that has it deepest inside; negative outside.
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

/// Enlargement by wind of the sphere of a plant with this radius, or of a sphere around it, m.
inline float wind_reach_m(const LodView& view, float plant_radius_m) {
  return view.reach_share * plant_radius_m;
}

/// The distance that determines sizes, m; the caller limits it to near_m from below.
inline float size_distance_m(const LodView& view, const dvec3& place_m) {
  return view.parallel ? 0.0f : length((place_m - view.eye_m).rounded());
}

/// One instance's bounding sphere in world space.
struct InstanceSphere {
  dvec3 center_m{0, 0, 0};
  float radius_m = 0.0f;
  std::uint32_t plant = kNoPlant;          ///< index of its plant, of 17 bits; kNoPlant: an empty slot, skipped
  std::uint32_t layer_mask = 0xffffffffu;  ///< not drawn if it shares no bit with the view's
  float threshold_share = 1.0f;            ///< its error threshold divided by the view's

  static constexpr std::uint32_t kNoPlant = 0x1ffffu;
};

/// A plant for selection.
struct LodPlant {
  lod::CoppiceTable table{};
  std::uint32_t resident_leaf_count = 1;                   ///< cuts are clamped to it
  std::uint32_t resident_wood_mask = 0;                    ///< bit i: wood LoD i can be drawn
  bool leaf_meshes_resident = false;                       ///< true if all of them are
  std::optional<gpu::MaterialOverride> material_override;  ///< for our renderer
};

/// What to draw an instance with.
struct InstanceLod {
  float leaf_count = 1.0f;                         ///< fractional m in [1, resident_leaf_count]; not drawn if leaf_meshes is set
  bool leaf_meshes = false;                        ///< drawn instead of quads
  std::uint32_t wood_lod = COPPICE_MAX_WOOD_LODS;  ///< table.wood_lod_count or more means no wood
};

/// Packs a plant's table for coppice_lod.h, on CPU and GPU: leaf counts | sizes | errors | wood triangles | leaf mesh errors, in 32-bit
/// words. errors  out_of_memory
Result<HookArray<std::uint32_t>> pack_lod_table(const PlantFile& file, const coppice_allocator& allocator);

/// Makes a view of the table for C++. words must stay alive; first_word is 0.
lod::CoppiceTable lod_table(const PlantFile& file, std::span<const std::uint32_t> words);

/// Selects for one instance. seed: offsets the threshold, see coppice_instance_threshold_px.
InstanceLod select_lod(const InstanceSphere& instance, std::uint32_t seed, const LodPlant& plant, const LodView& view);

/// Selects for all instances; their indices are their seeds. out: [instances.size()]; empty slots get leaf_count 0. plants is indexed by
/// InstanceSphere::plant (asserted).
void select_lods(std::span<const InstanceSphere> instances, std::span<const LodPlant> plants, const LodView& view,
                 std::span<InstanceLod> out);

/// Writes the nodes of cut(leaf_count), ascending.
/// node_split  [>= 2 * leaf_count - 1] split that replaces each node, lod::kCoppiceNoSplit if none
/// out         [>= leaf_count]
/// returns     number of ids written: leaf_count for a valid tree
std::size_t select_cut(std::span<const std::uint32_t> node_split, std::uint32_t leaf_count, std::span<std::uint32_t> out);

/// coppice_error_px for a size.
float error_px_at(const lod::CoppiceTable& table, float leaf_count, float size_px);

}  // namespace coppice
