#include "open_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <utility>

#include "context.h"
#include "coppice_light.h"
#include "handle.h"

namespace coppice {
namespace {

/// A tile that is larger than this when it comes grows up in so many frames, if no more than so many others do.
constexpr float kGrowFrom_px = 3.0f;
constexpr std::uint32_t kGrowFrames = 16, kMostGrowing = 16;
/// What an instance takes: its slot (about 190 bytes), draw commands, places in the lists of wood.
constexpr std::uint64_t kInstanceBytes = 224;

coppice_placement placement_of(const SceneInstance& instance) {
  coppice_placement placement = gpu::default_placement();
  std::ranges::copy(instance.position_m, placement.position);
  placement.scale = instance.scale;
  placement.rotation[1] = std::sin(0.5f * instance.yaw_rad);
  placement.rotation[3] = std::cos(0.5f * instance.yaw_rad);
  std::ranges::copy(instance.tint, placement.tint);
  return placement;
}

/// Of the picture of a parallel view.
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

Result<std::unique_ptr<OpenScene>> OpenScene::open(Context& context, const char* path, const gpu::Pose& pose) {
  std::unique_ptr<OpenScene> scene(new (std::nothrow) OpenScene(context, pose));
  if (!scene) return Error{Status::out_of_memory, "scene"};
  COPPICE_TRY(stream, SceneStream::open(context.hooks(), context.ledger(), path, {.plants = context.scene_plants()}));
  scene->stream_ = std::move(stream);
  if (auto allocated = scene->allocate(); !allocated) {
    log_line(context.log(), COPPICE_LOG_ERROR, "%s: %s", path, allocated.error().message().c_str());
    return allocated.error();
  }
  return scene;
}

Result<void> OpenScene::allocate() {
  const SceneFile& file = stream_->file();
  const coppice_allocator& allocator = context_.hooks().allocator;
  std::uint32_t most_placed = 0;
  for (const SceneTile& tile : file.tiles) most_placed = std::max(most_placed, tile.entry.instance_count);
  COPPICE_CHECK(allocate_into(tiles_, allocator, file.tiles.size()));
  COPPICE_CHECK(allocate_into(plants_, allocator, file.species.size()));
  COPPICE_CHECK(placed_.make_room(allocator, most_placed));
  COPPICE_CHECK(opening_.make_room(allocator, Streamer::kMostOpening));
  COPPICE_CHECK(growing_.make_room(allocator, kMostGrowing));
  const std::uint64_t bytes = tiles_.bytes() + plants_.bytes() + placed_.items.bytes() + opening_.items.bytes() + growing_.items.bytes();
  COPPICE_CHECK(context_.check_fits(bytes));
  context_.ledger().take(bytes);
  taken_bytes_ = bytes;
  return {};
}

void OpenScene::close() {
  for (std::uint32_t tile = 0; tile < tiles_.size(); ++tile) remove_tile(tile);
  for (const Opening& opening : opening_.span()) context_.close_plant(opening.plant);
  for (const coppice_plant plant : plants_)
    if (context_.is_open(plant)) context_.close_plant(plant);
  context_.ledger().give(std::exchange(taken_bytes_, 0));
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
  // A shadow map shows what cameras have loaded: its picture is as fine everywhere, and would want all that lies along it.
  const bool only_depth = std::ranges::none_of(views, &LodView::looks_around);
  eyes_.clear();
  for (const LodView& view : views)
    if (view.looks_around || only_depth) eyes_.push_back(scene_eye(view, pose_));
  stream_->begin_frame(eyes_, static_cast<std::uint32_t>(std::min<std::uint64_t>(block_count, affordable)));
  for (const std::uint32_t tile : stream_->dropped()) remove_tile(tile);
  grow_tiles();
  open_species(frame_number);
  // One at least; more while there is time. What is over waits for the next frame.
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
    // Where max_plants are open others may be closing: it is tried again as an opening that finds no memory is.
    if (!started && ++species_tries_ < Streamer::kOpenTries) {
      species_frame_ = frame_number + Streamer::kOpenRetryFrames;
      break;
    }
    species_tries_ = 0;
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
    if (const coppice_plant plant = plants_[instance.species]; context_.is_open(plant))
      placed_.push_back({placed_in(pose_, placement_of(instance)), context_.plant_slot(plant)});
  gpu::InstanceTable& instances = context_.instances();
  const auto needed = instances.slots_for_tile(placed_.count);
  if (!needed) {
    stream_->refused(ready.tile);
    return true;
  }
  // What holds and draws them all grows with them: room is made for that, and the tile waits.
  if (!context_.grow_slots(*needed)) return false;
  gpu::InstanceTile& tile = tiles_[ready.tile];
  tile = *instances.add_tile(placed_.span());
  block_count_ += tile.block_count;
  if (ready.size_px > kGrowFrom_px && growing_.count < growing_.items.size()) {
    instances.scale_tile(tile, 1.0f / static_cast<float>(kGrowFrames));
    growing_.push_back({ready.tile, 1});
  }
  stream_->placed(ready.tile);
  return true;
}

// Where the threshold is above some pixels, plants would pop up.
void OpenScene::grow_tiles() {
  for (Growing& growing : growing_.span()) {
    const auto share = static_cast<float>(growing.share);
    context_.instances().scale_tile(tiles_[growing.tile], (share + 1.0f) / share);
    ++growing.share;
  }
  growing_.erase_if([](const Growing& growing) { return growing.share == kGrowFrames; });
}

void OpenScene::remove_tile(std::uint32_t tile) {
  growing_.erase_if([tile](const Growing& growing) { return growing.tile == tile; });
  const gpu::InstanceTile removed = std::exchange(tiles_[tile], {});
  context_.instances().remove_tile(removed);
  block_count_ -= removed.block_count;
}

}  // namespace coppice
