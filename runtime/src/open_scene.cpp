#include "open_scene.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <new>
#include <utility>

#include "context.h"
#include "coppice_light.h"
#include "handle.h"

namespace coppice {
namespace {

/// A tile that is larger than this when it arrives grows up: at a threshold above some pixels plants would pop up.
constexpr float kGrowFrom_px = 3.0f;
constexpr std::uint32_t kGrowFrames = 16;
/// Memory of an instance: its slot (about 190 bytes), draw commands, places in the lists of wood.
constexpr std::uint64_t kInstanceBytes = 224;

coppice_placement placement_of(const SceneInstance& instance) {
  coppice_placement placement = gpu::default_placement();
  std::ranges::copy(instance.position_m, placement.position);
  const float s = std::sin(0.5f * instance.yaw_rad), c = std::cos(0.5f * instance.yaw_rad);
  const std::array<float, 4> turned{0, s, 0, c}, mirrored{c, 0, -s, 0};  // the same after half a turn about x
  placement.scale = instance.mirrored ? -instance.scale : instance.scale;
  std::ranges::copy(instance.mirrored ? mirrored : turned, placement.rotation);
  std::ranges::copy(instance.tint, placement.tint);
  return placement;
}

/// Half the diagonal of a parallel view's picture.
float half_diagonal_m(const LodView& view) {
  const mat4 rows = transpose(view.eyes[0].clip_from_world);
  const vec3 x = rows.column[0].xyz(), y = rows.column[1].xyz();
  return std::sqrt(1.0f / dot(x, x) + 1.0f / dot(y, y));
}

/// The view's eye in the scene's space.
SceneEye scene_eye(const LodView& view, const gpu::Pose& pose) {
  const gpu::Pose back = inverse(pose);
  coppice_placement eye = gpu::default_placement();
  for (std::size_t axis = 0; axis < 3; ++axis) eye.position[axis] = view.eye_m[axis];
  const vec3 toward_viewer = gpu::rotate(back.rotation, view.toward_viewer);
  return {.position_m = dvec3(placed_in(back, eye).position).rounded(),
          .focal_px = view.focal_px,
          .near_m = view.near_m,
          .parallel = view.parallel,
          .toward_viewer = toward_viewer,
          .half_diagonal_m = view.parallel ? half_diagonal_m(view) : 0.0f};
}

}  // namespace

Result<std::unique_ptr<OpenScene>> OpenScene::open(Context& context, std::uint32_t index, const char* path, const gpu::Pose& pose) {
  static_assert(std::uint64_t{COPPICE_MAX_SCENES} * COPPICE_MAX_SCENE_TILES < gpu::TileMember::kNoTile);
  std::unique_ptr<OpenScene> scene(new (std::nothrow) OpenScene(context, index, pose));
  if (!scene) return Error{Status::out_of_memory, "scene"};
  COPPICE_CHECK(move_into(scene->stream_, SceneStream::open(context.hooks(), context.ledger(), path, {.plants = context.scene_plants()})));
  if (auto allocated = scene->allocate(); !allocated) {
    log_line(context.log(), COPPICE_LOG_ERROR, "%s: %s", path, allocated.error().message().c_str());
    return allocated.error();
  }
  return scene;
}

Result<void> OpenScene::allocate() {
  const SceneFile& file = stream_->file();
  const coppice_allocator& allocator = context_.hooks().allocator;
  std::uint32_t max_placed = 0;
  for (const SceneTile& tile : file.tiles) max_placed = std::max(max_placed, tile.entry.instance_count);
  COPPICE_CHECK(allocate_into(tiles_, allocator, file.tiles.size()));
  COPPICE_CHECK(allocate_into(plants_, allocator, file.species.size()));
  COPPICE_CHECK(placed_.make_room(allocator, max_placed));
  COPPICE_CHECK(opening_.make_room(allocator, Streamer::kMaxOpening));
  const std::uint64_t bytes = tiles_.bytes() + plants_.bytes() + placed_.items.bytes() + opening_.items.bytes();
  COPPICE_CHECK(context_.check_fits(bytes));
  context_.ledger().reserve(bytes);
  reserved_bytes_ = bytes;
  return {};
}

void OpenScene::close() {
  for (std::uint32_t tile = 0; tile < tiles_.size(); ++tile) remove_tile(tile);
  for (const Opening& opening : opening_.span()) context_.close_plant(opening.plant);
  for (const coppice_plant plant : plants_)
    if (context_.is_open(plant)) context_.close_plant(plant);
  context_.ledger().release(std::exchange(reserved_bytes_, 0) + changes_.bytes());
}

void OpenScene::fill_info(coppice_scene_info& info) const {
  const SceneFile& file = stream_->file();
  info.species_count = file.header.species_count;
  info.tile_count = file.header.tile_count;
  info.instance_count = file.header.instance_count;
  info.file_bytes = file.header.file_bytes;
  std::copy_n(file.header.square_min, 2, info.square_min);
  info.square_side = file.header.square_side;
  info.height_min = file.height_min_m;
  info.height_max = file.height_max_m;
}

bool OpenScene::fill_info(std::uint32_t species, coppice_scene_plant_info& info) const {
  if (species >= plants_.size()) return false;
  info.path = stream_->species_path(species);
  info.plant = context_.is_open(plants_[species]) ? plants_[species] : 0;
  return true;
}

void OpenScene::move(const gpu::Pose& pose) {
  const gpu::Pose back = inverse(pose_);
  for (const gpu::InstanceTile& tile : tiles_) context_.instances().move_tile(tile, back, pose);
  pose_ = pose;
}

void OpenScene::begin_frame(std::span<const LodView> views, std::uint64_t frame_number, std::uint64_t streaming_ns,
                            std::uint32_t scene_count) {
  static_assert(kTileBlockInstances == gpu::kDirtyBlockSlots);
  const std::uint64_t affordable = context_.ledger().budget() / 4 / scene_count / (kInstanceBytes * kTileBlockInstances);
  const std::uint32_t block_count = context_.instances().free_block_count() / scene_count + block_count_;
  // A shadow map shows what cameras have loaded: its picture is as fine everywhere, and would load everything along it.
  const bool only_depth = std::ranges::none_of(views, &LodView::looks_around);
  eyes_.clear();
  for (const LodView& view : views)
    if (view.looks_around || only_depth) eyes_.push_back(scene_eye(view, pose_));
  begun_ = true;
  stream_->begin_frame(eyes_, static_cast<std::uint32_t>(std::min<std::uint64_t>(block_count, affordable)));
  for (const std::uint32_t tile : stream_->dropped()) remove_tile(tile);
  open_species(frame_number);
  // At least one; more while there is time. The rest waits for the next frame.
  const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(streaming_ns);
  for (auto ready = stream_->next_ready(); ready; ready = stream_->next_ready()) {
    if (!place_tile(*ready)) break;
    if (std::chrono::steady_clock::now() >= end) break;
  }
}

void OpenScene::open_species(std::uint64_t frame_number) {
  while (opening_.count < opening_.items.size() && frame_number >= species_frame_) {
    const auto wanted = stream_->next_species();
    if (!wanted) break;
    const auto started = context_.start_open(wanted->path);
    // If max_plants are open, others may be closing: it is retried like an opening that finds no memory.
    if (!started && ++species_attempts_ < Streamer::kOpenAttempts) {
      species_frame_ = frame_number + Streamer::kOpenRetryFrames;
      break;
    }
    species_attempts_ = 0;
    stream_->species_opening(wanted->species);
    if (started) {
      opening_.push_back({wanted->species, *started});
    } else {
      log_line(context_.log(), COPPICE_LOG_ERROR, "%s: %s", wanted->path, started.error().message().c_str());
      stream_->species_opened(wanted->species, false);
    }
  }
  opening_.erase_if([&](const Opening& opening) {
    const coppice_plant_state state = context_.plant_state(opening.plant);
    if (state == COPPICE_PLANT_OPENING) return false;
    if (state == COPPICE_PLANT_READY)
      plants_[opening.species] = opening.plant;
    else
      context_.close_plant(opening.plant);
    stream_->species_opened(opening.species, state == COPPICE_PLANT_READY);
    return true;
  });
}

bool OpenScene::place_tile(const ReadyTile& ready) {
  placed_.clear();
  for (const SceneInstance& instance : ready.instances)
    placed_.push_back({placed_in(pose_, placement_of(instance)), context_.usable_slot(plants_[instance.species])});
  for (TreeChange& change : changes_.of_tile(ready.tile)) {
    const SceneInstance& own = ready.instances[change.number];
    change.own_plant = plants_[own.species];
    change.own_placement = placement_of(own);
    placed_[change.number] = shown(change);
  }
  gpu::InstanceTable& instances = context_.instances();
  const auto needed = instances.slots_for_tile(placed_.count);
  if (!needed) {
    stream_->refused(ready.tile);
    return true;
  }
  // Everything that stores and draws them grows with them: the slots are grown, and the tile waits.
  if (!context_.grow_slots(*needed)) return false;
  gpu::InstanceTile& tile = tiles_[ready.tile];
  tile = *instances.add_tile(index_ * COPPICE_MAX_SCENE_TILES + ready.tile, placed_.span());
  block_count_ += tile.block_count;
  if (ready.size_px > kGrowFrom_px) instances.grow_tile(tile, kGrowFrames);
  stream_->placed(ready.tile);
  return true;
}

void OpenScene::remove_tile(std::uint32_t tile) {
  const gpu::InstanceTile removed = std::exchange(tiles_[tile], {});
  context_.instances().remove_tile(removed);
  block_count_ -= removed.block_count;
}

std::string OpenScene::tree_problem(const coppice_scene_tree& tree) const {
  const HookArray<SceneTile>& tiles = stream_->file().tiles;
  if (tree.tile >= tiles.size()) return "tile is " + std::to_string(tree.tile) + ": the scene has " + std::to_string(tiles.size());
  const std::uint32_t count = tiles[tree.tile].entry.instance_count;
  return tree.number < count ? "" : "number is " + std::to_string(tree.number) + ": the tile has " + std::to_string(count);
}

Result<void> OpenScene::reserve_changes(std::size_t count) {
  const std::uint64_t bytes = changes_.growth_bytes(count);
  COPPICE_CHECK(context_.check_fits(bytes));
  COPPICE_CHECK(changes_.reserve(context_.hooks().allocator, count));
  context_.ledger().reserve(bytes);
  return {};
}

std::uint32_t OpenScene::member_slot(std::uint32_t tile, std::uint32_t number) const {
  return std::as_const(context_).instances().member_slot(tiles_[tile], number);
}

gpu::PlacedInstance OpenScene::shown(const TreeChange& change) const {
  const bool replaced = change.state == COPPICE_TREE_REPLACED;
  gpu::PlacedInstance placed{placed_in(pose_, replaced ? change.placement : change.own_placement),
                             context_.usable_slot(replaced && change.plant != 0 ? change.plant : change.own_plant)};
  if (change.state == COPPICE_TREE_HIDDEN) placed.placement.layer_mask = 0;
  return placed;
}

void OpenScene::change_trees(coppice_scene scene, std::span<const coppice_scene_tree> trees, const TreeEdit& edit) {
  gpu::InstanceTable& instances = context_.instances();
  if (edit.state != COPPICE_TREE_AS_IN_FILE) changes_.add(trees, scene);
  const gpu::Pose back = inverse(pose_);
  for (std::size_t i = 0; i < trees.size(); ++i) {
    TreeChange* change = trees[i].scene == scene ? changes_.find(trees[i].tile, trees[i].number) : nullptr;
    if (change == nullptr) continue;
    const bool resident = is_resident(change->tile);
    const std::uint32_t slot = resident ? member_slot(change->tile, change->number) : 0;
    if (resident && change->state == COPPICE_TREE_AS_IN_FILE) {
      const gpu::PlacedInstance own = instances.placed_at(slot);
      change->own_plant = context_.plant_at(own.plant);
      change->own_placement = placed_in(back, own.placement);
    }
    change->state = edit.state;
    if (edit.state == COPPICE_TREE_REPLACED) {
      change->plant = edit.plant;
      coppice_placement placement = edit.placements[i];
      const dvec3 place = dvec3(placement.position) + context_.origin();
      for (std::size_t axis = 0; axis < 3; ++axis) placement.position[axis] = place[axis];
      change->placement = placed_in(back, placement);
    }
    if (resident) instances.set_member(slot, shown(*change));
  }
  if (edit.state == COPPICE_TREE_AS_IN_FILE) changes_.tidy();
}

WorldBox OpenScene::world_box(const vec3& low, const vec3& high) const {
  constexpr double kRounded_m = 1e-3;  // positions are more precise than this
  WorldBox box{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    coppice_placement placement = gpu::default_placement();
    for (std::size_t axis = 0; axis < 3; ++axis) placement.position[axis] = ((corner >> axis & 1u) != 0 ? high : low)[axis];
    const dvec3 place(placed_in(pose_, placement).position);
    box.low = min(box.low, place - dvec3{kRounded_m, kRounded_m, kRounded_m});
    box.high = max(box.high, place + dvec3{kRounded_m, kRounded_m, kRounded_m});
  }
  return box;
}

namespace {

bool overlap(const WorldBox& a, const WorldBox& b) {
  return a.low.x <= b.high.x && a.low.y <= b.high.y && a.low.z <= b.high.z && b.low.x <= a.high.x && b.low.y <= a.high.y &&
         b.low.z <= a.high.z;
}

}  // namespace

void OpenScene::query(const WorldBox& box, TreeOutput& out) const {
  query_tile(0, box, out);
  for (const TreeChange& change : changes_.all())
    if (change.state == COPPICE_TREE_REPLACED && is_resident(change.tile)) query_member(change.tile, change.number, box, out);
}

void OpenScene::query_tile(std::uint32_t index, const WorldBox& box, TreeOutput& out) const {
  const SceneFile& file = stream_->file();
  const SceneTile& tile = file.tiles[index];
  // Rounding may move a tile's plants out of its square.
  const float slack_m = 1e-3f * tile.square_side_m + 1e-5f * (std::abs(tile.square_min_m[0]) + std::abs(tile.square_min_m[1]));
  const float side_m = tile.square_side_m + 2.0f * slack_m;
  const vec3 low(tile.square_min_m[0] - slack_m, file.height_min_m, tile.square_min_m[1] - slack_m);
  if (!overlap(world_box(low, {low.x + side_m, file.height_max_m, low.z + side_m}), box)) return;
  if (overlap(world_box(vec3(tile.entry.box_min), vec3(tile.entry.box_max)), box)) {
    if (!is_resident(index)) ++out.missing_tiles;
    const std::span<const TreeChange> changes = changes_.of_tile(index);
    auto change = changes.begin();
    for (std::uint32_t number = 0; is_resident(index) && number < tile.entry.instance_count; ++number) {
      while (change != changes.end() && change->number < number) ++change;
      const bool replaced = change != changes.end() && change->number == number && change->state == COPPICE_TREE_REPLACED;
      if (!replaced) query_member(index, number, box, out);  // replaced ones may stand anywhere
    }
  }
  const auto child_count = static_cast<std::uint32_t>(std::popcount(tile.entry.child_mask));
  for (std::uint32_t i = 0; i < child_count; ++i) query_tile(tile.entry.first_child + i, box, out);
}

void OpenScene::query_member(std::uint32_t tile, std::uint32_t number, const WorldBox& box, TreeOutput& out) const {
  const gpu::PlacedInstance placed = std::as_const(context_).instances().placed_at(member_slot(tile, number));
  const dvec3 place(placed.placement.position);
  if (placed.plant == gpu::kNoPlant || !overlap({place, place}, box)) return;
  if (out.count < out.trees.size()) out.trees[out.count] = {out.scene, tile, number};
  ++out.count;
}

coppice_tree_info OpenScene::tree_info(std::uint32_t tile, std::uint32_t number) const {
  auto info = coppice_tree_info{.struct_size = sizeof(coppice_tree_info)};
  const TreeChange* change = changes_.find(tile, number);
  if (change != nullptr) info.state = change->state;
  if (!is_resident(tile)) return info;
  info.resident = COPPICE_TRUE;
  const gpu::PlacedInstance placed = std::as_const(context_).instances().placed_at(member_slot(tile, number));
  if (placed.plant == gpu::kNoPlant) return info;
  info.plant = context_.plant_at(placed.plant);
  info.placement = placed.placement;
  if (info.state == COPPICE_TREE_HIDDEN) info.placement.layer_mask = change->own_placement.layer_mask;
  return info;
}

}  // namespace coppice
