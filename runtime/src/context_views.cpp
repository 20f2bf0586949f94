// The views of a context: their demand, and their statistics.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "abi.h"
#include "context.h"
#include "handle.h"
#include "vectors.h"

namespace coppice {
namespace {

/// Views of only depth share the last view group, the others have the rest.
constexpr std::size_t kDepthGroup = kMaxViewGroups - 1;

/// Lowers the threshold so that it suffices for two views of a group.
void merge_threshold(LodView& of, const LodView& other) {
  of.error_px = std::min(of.error_px, other.error_px);
  of.full = of.full || other.full;
}

}  // namespace

Result<coppice_view> Context::create_view(const coppice_view_desc& desc, std::uint32_t backend_view) {
  const auto free = std::ranges::find(views_, false, &ViewEntry::open);
  const auto index = static_cast<std::uint32_t>(free - views_.begin());
  if (free == views_.end()) views_.emplace_back();
  ViewEntry& view = views_[index];
  COPPICE_CHECK(make_room(view.ahead, hooks_.hooks.allocator, ledger_, static_cast<std::uint32_t>(slots_.items.size())));
  view.group = desc.output == COPPICE_OUTPUT_DEPTH ? kDepthGroup : smallest_group();
  view.backend_view = backend_view;
  view.open = true;
  return pack_handle({HandleKind::view, tag_, view.generation, index});
}

/// The group with the fewest views with colours.
std::size_t Context::smallest_group() const {
  std::array<std::size_t, kDepthGroup> shares{};
  for (const ViewEntry& view : views_)
    if (view.open && view.group != kDepthGroup) ++shares[view.group];
  return static_cast<std::size_t>(std::ranges::min_element(shares) - shares.begin());
}

void Context::destroy_view(coppice_view view) {
  ViewEntry& gone = entry_of_view(view);
  backend_->remove_view(gone.backend_view);
  ledger_.release(gone.ahead.measured.bytes() + gone.ahead.finished.bytes());
  const std::uint32_t generation = gone.generation + 1;
  gone = {};
  gone.generation = generation;
}

bool Context::is_view(coppice_view view) const {
  const std::uint32_t index = unpack_handle(view).index;
  return index < views_.size() && views_[index].open && view == pack_handle({HandleKind::view, tag_, views_[index].generation, index});
}

// An orthographic view from the sun that just holds the sphere, with depth from three radii before its surface to one behind. The picture's
// axes depend on the sun alone.
coppice_camera Context::sun_camera(coppice_view handle, const coppice_sun_desc& desc) const {
  const bool reversed_depth = backend_->has_reversed_depth(backend_view(handle));
  auto view = struct_defaults<coppice_camera>();
  view.view = handle;
  view.width_px = view.height_px = desc.size_px;
  constexpr float kRadiiBefore = 4.0f, kRadiiBehind = 2.0f;
  const vec3 sun = normalize(vec3(desc.sun_direction));
  const vec3 right = normalize(cross(std::abs(sun.y) < 0.99f ? vec3(0, 1, 0) : vec3(1, 0, 0), sun));
  const vec3 up = cross(sun, right);
  const std::array<vec3, 3> axes{right, up, sun};
  std::fill_n(view.view_from_world, 16, 0.0);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) view.view_from_world[4 * column + row] = axes[row][column];
    for (std::size_t i = 0; i < 3; ++i) view.view_from_world[12 + row] -= double{axes[row][i]} * desc.center[i];
  }
  view.view_from_world[14] -= double{kRadiiBefore} * double{desc.radius_m};
  view.view_from_world[15] = 1.0;

  // The near plane contains the eye.
  const float depth_per_m = 1.0f / ((kRadiiBefore + kRadiiBehind) * desc.radius_m);
  std::fill_n(view.clip_from_view, 16, 0.0f);
  view.clip_from_view[0] = 1.0f / desc.radius_m;
  view.clip_from_view[5] = -1.0f / desc.radius_m;
  view.clip_from_view[10] = reversed_depth ? depth_per_m : -depth_per_m;
  view.clip_from_view[14] = reversed_depth ? 1.0f : 0.0f;
  view.clip_from_view[15] = 1.0f;
  return view;
}

ViewCounts Context::counts_of(const ViewEntry& view) const {
  return backend_->view_counts(view.backend_view).value_or(view.counts);
}

void Context::show_view(const coppice_camera& camera, LodView& lod) {
  ViewEntry& view = entry_of_view(camera.view);
  const ViewCounts counts = counts_of(view);
  view.budget.observe({counts.frame, counts.leaves, counts.wood_triangles, counts.hardware_triangles});
  lod.error_px = view.budget.threshold_px(frame_number_, lod.error_px, camera.lod == COPPICE_LOD_CUT ? camera.leaf_budget : 0);
  lod.looks_around = view.group != kDepthGroup;
  backend_->show_view(view.backend_view, camera, lod);
  view.shown = lod;
  view.shown_frame = frame_number_;
  // A discrete level has up to four times the leaves of the cut, and the error falls about with the square root of their number.
  if (lod.discrete) lod.error_px *= 0.5f;
}

void Context::measure_views(std::span<const coppice_camera> cameras, std::span<const LodView> lods) {
  group_views_ = {};
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    ViewEntry& view = entry_of_view(cameras[i].view);
    const std::span<PlantDemand> demands = demands_[view.group].span();
    if (std::optional<LodView>& group = group_views_[view.group]) {
      merge_threshold(*group, lods[i]);
      add_demand(instances_.blocks(), 0, instances_.blocks().bounds.size(), lods[i], demands);
    } else {
      group = lods[i];
      measure_demand(instances_.blocks(), lods[i], demands);
    }
    if (lods[i].looks_around) add_demand_ahead(view.ahead, instances_.blocks(), lods[i], prefetch_frames_, demands);
  }
  for (BoundedList<PlantDemand>& demands : demands_)
    for (const PlantEntry& plant : plants_.span())
      if (plant.open && plant.next_slot != kNoSlot) demands[plant.next_slot] = demands[plant.slot];
}

StreamFrame Context::stream_frame() const {
  StreamFrame frame{.frame_number = frame_number_, .view_groups = {}};
  for (std::size_t group = 0; group < kMaxViewGroups; ++group)
    if (group_views_[group]) frame.view_groups[group] = ViewGroup{*group_views_[group], demands_[group].span()};
  return frame;
}

bool Context::is_settled(coppice_view view) const {
  if (!is_shown(view)) return false;
  const auto opening = [](const PlantEntry& plant) { return plant.open && plant.state == COPPICE_PLANT_OPENING; };
  if (std::ranges::any_of(plants_.span(), opening)) return false;
  for (const SceneEntry& entry : scenes_)
    if (entry.scene && !entry.scene->is_settled()) return false;
  if (instances_.is_growing()) return false;
  return streamer_->is_group_settled(entry_of_view(view).group);
}

void Context::fill_stats(coppice_view view, coppice_view_stats& stats) const {
  const ViewEntry& of = entry_of_view(view);
  const ViewCounts counts = counts_of(of);
  stats.gpu_frame_number = counts.frame;
  stats.visible_instance_count = counts.visible_instances;
  stats.occluded_instance_count = counts.occluded_instances;
  stats.drawn_leaf_count = counts.leaves;
  stats.drawn_wood_triangle_count = counts.wood_triangles;
  stats.leaf_mesh_instance_count = counts.leaf_mesh_instances;
  stats.drawn_leaf_mesh_triangle_count = counts.leaf_mesh_triangles;
  stats.threshold_px = streamer_->threshold_px(of.group);
  std::ranges::copy(counts.pass_ms, stats.pass_ms);
}

}  // namespace coppice
