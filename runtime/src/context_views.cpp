// The views of a context: what they ask of streaming, and what of them is recorded.

#include <algorithm>
#include <utility>

#include "context.h"
#include "handle.h"
#include "trace_scope.h"

namespace coppice {
namespace {

/// Views of depth alone share the last lens, the others have the rest.
constexpr std::size_t kDepthLens = kMostLenses - 1;

gpu::AttachmentDesc attachments_of(const coppice_vulkan_view_desc& desc) {
  return {
      .color_format = desc.color_format, .depth_format = desc.depth_format, .depth_compare = desc.depth_compare, .samples = desc.samples};
}

/// Of two views that streaming takes as one: what is enough for both.
void merge_threshold(LodView& of, const LodView& other) {
  of.error_px = std::min(of.error_px, other.error_px);
  of.full = of.full || other.full;
}

}  // namespace

Result<coppice_view> Context::create_view(const coppice_view_desc& desc, const coppice_vulkan_view_desc& vulkan) {
  const gpu::AttachmentDesc attachments = attachments_of(vulkan);
  COPPICE_CHECK(gpu::check_attachments(renderer_->device(), attachments));
  const auto free = std::ranges::find(views_, false, &ViewEntry::open);
  const auto index = static_cast<std::uint32_t>(free - views_.begin());
  if (free == views_.end()) views_.emplace_back();
  ViewEntry& view = views_[index];
  COPPICE_CHECK(make_room(view.ahead, hooks_.hooks.allocator, ledger_, static_cast<std::uint32_t>(slots_.items.size())));
  COPPICE_TRY(recorder, renderer_->add_view(attachments));
  if (const auto alive = device_state(); !alive) {  // a pipeline may have found out
    renderer_->remove_view(recorder);
    return alive.error();
  }
  view.lens = desc.output == COPPICE_OUTPUT_DEPTH ? kDepthLens : free_lens();
  view.recorder = recorder;
  view.open = true;
  return pack_handle({HandleKind::view, tag_, view.generation, index});
}

/// That the fewest lit views share.
std::size_t Context::free_lens() const {
  std::array<std::size_t, kDepthLens> shares{};
  for (const ViewEntry& view : views_)
    if (view.open && view.lens != kDepthLens) ++shares[view.lens];
  return static_cast<std::size_t>(std::ranges::min_element(shares) - shares.begin());
}

void Context::destroy_view(coppice_view view) {
  ViewEntry& gone = entry_of_view(view);
  renderer_->remove_view(gone.recorder);
  ledger_.give(gone.ahead.measured.bytes() + gone.ahead.finished.bytes());
  const std::uint32_t generation = gone.generation + 1;
  gone = {};
  gone.generation = generation;
}

bool Context::is_view(coppice_view view) const {
  const std::uint32_t index = unpack_handle(view).index;
  return index < views_.size() && views_[index].open && view == pack_handle({HandleKind::view, tag_, views_[index].generation, index});
}

Context::ViewEntry& Context::entry_of_view(coppice_view view) {
  return views_[unpack_handle(view).index];
}

const Context::ViewEntry& Context::entry_of_view(coppice_view view) const {
  return views_[unpack_handle(view).index];
}

gpu::ViewRecorder& Context::recorder(coppice_view view) {
  return renderer_->view(entry_of_view(view).recorder);
}

bool Context::has_reversed_depth(coppice_view view) const {
  return gpu::is_reversed(std::as_const(*renderer_).view(entry_of_view(view).recorder).attachments().depth_compare);
}

void Context::show_view(const coppice_camera& camera, LodView& lod) {
  ViewEntry& view = entry_of_view(camera.view);
  gpu::ViewRecorder& shown = renderer_->view(view.recorder);
  const gpu::FrameCounts& counts = shown.counts();
  view.budget.observe({counts.frame, counts.leaves, counts.wood_triangles, counts.hardware_triangles});
  lod.error_px = view.budget.threshold_px(frame_number_, lod.error_px, camera.lod == COPPICE_LOD_CUT ? camera.leaf_budget : 0);
  lod.looks_around = view.lens != kDepthLens;
  shown.show({camera, lod});
  // A discrete level has up to four times the leaves of the cut; the error falls about as their root.
  if (lod.discrete) lod.error_px *= 0.5f;
}

void Context::measure_views(std::span<const coppice_camera> cameras, std::span<const LodView> lods) {
  lenses_ = {};
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    ViewEntry& view = entry_of_view(cameras[i].view);
    const std::span<PlantDemand> demands = demands_[view.lens].span();
    if (std::optional<LodView>& lens = lenses_[view.lens]) {
      merge_threshold(*lens, lods[i]);
      add_demand(instances_.blocks(), 0, instances_.blocks().bounds.size(), lods[i], demands);
    } else {
      lens = lods[i];
      measure_demand(instances_.blocks(), lods[i], demands);
    }
    if (lods[i].looks_around) add_demand_ahead(view.ahead, instances_.blocks(), lods[i], prefetch_frames_, demands);
  }
  for (BoundedList<PlantDemand>& demands : demands_)
    for (const PlantEntry& plant : plants_.span())
      if (plant.open && plant.next_slot != kNoSlot) demands[plant.next_slot] = demands[plant.slot];
}

StreamFrame Context::stream_frame() const {
  StreamFrame frame{.frame_number = frame_number_, .lenses = {}};
  for (std::size_t lens = 0; lens < kMostLenses; ++lens)
    if (lenses_[lens]) frame.lenses[lens] = StreamLens{*lenses_[lens], demands_[lens].span()};
  return frame;
}

bool Context::is_settled(coppice_view view) const {
  const auto opening = [](const PlantEntry& plant) { return plant.open && plant.state == COPPICE_PLANT_OPENING; };
  if (std::ranges::any_of(plants_.span(), opening)) return false;
  for (const SceneEntry& entry : scenes_)
    if (entry.scene && entry.scene->stats().missing_tiles > 0) return false;
  return streamer_->is_lens_settled(entry_of_view(view).lens);
}

Result<void> Context::record_cull(VkCommandBuffer cmd, coppice_view view, const coppice_light& light) {
  const TraceScope trace(hooks_.hooks.trace, COPPICE_TRACE_RECORD_CULL);
  if (renderer_->can_cull())
    recorder(view).record_cull(cmd, light);
  else
    recorder(view).leave_out();
  return device_state();
}

void Context::record_draw(VkCommandBuffer cmd, coppice_view view) {
  const TraceScope trace(hooks_.hooks.trace, COPPICE_TRACE_RECORD_DRAW);
  recorder(view).record_draw(cmd);
}

void Context::fill_stats(coppice_view view, coppice_view_stats& stats) const {
  const ViewEntry& of = entry_of_view(view);
  const gpu::ViewRecorder& recorder = std::as_const(*renderer_).view(of.recorder);
  const gpu::FrameCounts& counts = recorder.counts();
  stats.gpu_frame_number = counts.frame;
  stats.visible_instance_count = counts.visible_instances;
  stats.occluded_instance_count = counts.occluded_instances;
  stats.drawn_leaf_count = counts.leaves;
  stats.drawn_wood_triangle_count = counts.wood_triangles;
  stats.leaf_mesh_instance_count = counts.leaf_mesh_instances;
  stats.drawn_leaf_mesh_triangle_count = counts.leaf_mesh_triangles;
  stats.threshold_px = streamer_->threshold_px(of.lens);
  static_assert(COPPICE_PASS_COUNT == static_cast<std::uint32_t>(gpu::Pass::count));
  std::ranges::copy(recorder.timer().pass_ms(), stats.pass_ms);
  stats.pass_ms[COPPICE_PASS_UPLOAD] = renderer_->timer().pass_ms()[COPPICE_PASS_UPLOAD];
}

}  // namespace coppice
