// The scene's part of a context: tiles that come become instances, plants are opened for them.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <utility>

#include "context.h"
#include "handle.h"

namespace coppice {

Result<coppice_scene> Context::open_scene(const char* path) {
  std::unique_ptr<Scene> scene(new (std::nothrow) Scene);
  if (!scene) return Error{Status::out_of_memory, "scene"};
  COPPICE_TRY(stream, SceneStream::open(hooks_.hooks, ledger_, path, {.plants = scene_plants_}));
  scene->stream = std::move(stream);
  const auto allocated = [&]() -> Result<void> {
    const coppice_allocator& allocator = hooks_.hooks.allocator;
    COPPICE_CHECK(allocate_into(scene->tiles, allocator, scene->stream->file().tiles.size()));
    COPPICE_CHECK(allocate_into(scene->plants, allocator, scene->stream->file().species.size()));
    return check_fits(scene->array_bytes());
  }();
  if (!allocated) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: %s", path, allocated.error().message().c_str());
    return allocated.error();
  }
  scene->handle = pack_handle({HandleKind::scene, tag_, ++scene_generation_, 0});
  scene_ = std::move(scene);
  ledger_.take(scene_->array_bytes());
  return scene_->handle;
}

void Context::close_scene() {
  for (std::uint32_t tile = 0; tile < scene_->tiles.size(); ++tile) remove_tile(tile);
  for (const Scene::Opening& opening : scene_->opening) close_plant(opening.plant);
  for (const coppice_plant plant : scene_->plants)
    if (is_open(plant)) close_plant(plant);
  ledger_.give(scene_->array_bytes());
  scene_.reset();
}

void Context::fill_info(coppice_scene_info& info) const {
  const SceneFile& file = scene_->stream->file();
  info.species_count = file.header.species_count;
  info.tile_count = file.header.tile_count;
  info.instance_count = file.header.instance_count;
  info.file_bytes = file.header.file_bytes;
  std::copy_n(file.header.square_min, 2, info.square_min);
  info.square_side = file.header.square_side;
  info.height_min = file.height_min_m;
  info.height_max = file.height_max_m;
}

bool Context::fill_info(std::uint32_t species, coppice_scene_plant_info& info) const {
  if (species >= scene_->plants.size()) return false;
  info.path = scene_->stream->species_path(species);
  info.plant = is_open(scene_->plants[species]) ? scene_->plants[species] : 0;
  return true;
}

namespace {

/// A tile that is larger than this when it comes grows up in so many frames, if no more than so many others do.
constexpr float kGrowFrom_px = 3.0f;
constexpr std::uint32_t kGrowFrames = 16, kMostGrowing = 16;
/// A plant that finds max_plants open is tried again so often, after so many frames each: others may be closing.
constexpr std::uint32_t kSpeciesTries = 8;
constexpr std::uint64_t kSpeciesRetryFrames = 30;
/// What an instance takes: its slot (156 bytes), draw commands, places in the lists of wood.
constexpr std::uint64_t kInstanceBytes = 224;

coppice_placement placement_of(const SceneInstance& instance) {
  coppice_placement placement{};
  std::ranges::copy(instance.position_m, placement.position);
  placement.scale = instance.scale;
  placement.rotation[1] = std::sin(0.5f * instance.yaw_rad);
  placement.rotation[3] = std::cos(0.5f * instance.yaw_rad);
  std::ranges::copy(instance.tint, placement.tint);
  return placement;
}

}  // namespace

void Context::stream_scene(const LodView& view) {
  static_assert(kTileBlockInstances == gpu::kDirtyBlockSlots);
  const std::uint64_t affordable = ledger_.budget() / 4 / (kInstanceBytes * kTileBlockInstances);
  const std::uint32_t block_count = instances_.free_block_count() + scene_->block_count;
  scene_->stream->begin_frame({view.eye_m, view.focal_px, view.near_m},
                              static_cast<std::uint32_t>(std::min<std::uint64_t>(block_count, affordable)));
  for (const std::uint32_t tile : scene_->stream->dropped()) remove_tile(tile);
  grow_tiles();
  open_species();
  // One at least; more while there is time. What is over waits for the next frame.
  const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(streaming_ns_);
  for (auto ready = scene_->stream->next_ready(); ready; ready = scene_->stream->next_ready()) {
    if (!place_tile(*ready)) break;
    if (std::chrono::steady_clock::now() >= end) break;
  }
}

void Context::open_species() {
  SceneStream& stream = *scene_->stream;
  while (scene_->opening.size() < Streamer::kMostOpening && frame_number_ >= scene_->species_frame) {
    const auto wanted = stream.next_species();
    if (!wanted) break;
    const auto started = start_open(wanted->path);
    if (!started && ++scene_->species_tries < kSpeciesTries) {
      scene_->species_frame = frame_number_ + kSpeciesRetryFrames;
      break;
    }
    scene_->species_tries = 0;
    stream.species_opening(wanted->species);
    if (started) {
      scene_->opening.push_back({wanted->species, *started});
    } else {
      log_line(log(), COPPICE_LOG_ERROR, "%s: %s", wanted->path, started.error().message().c_str());
      stream.species_opened(wanted->species, false);
    }
  }
  std::erase_if(scene_->opening, [&](const Scene::Opening& opening) {
    const coppice_plant_state state = plant_state(opening.plant);
    if (state == COPPICE_PLANT_OPENING) return false;
    if (state == COPPICE_PLANT_READY)
      scene_->plants[opening.species] = opening.plant;
    else
      close_plant(opening.plant);
    stream.species_opened(opening.species, state == COPPICE_PLANT_READY);
    return true;
  });
}

bool Context::place_tile(const ReadyTile& ready) {
  scene_->placed.clear();
  for (const SceneInstance& instance : ready.instances)
    if (is_open(scene_->plants[instance.species]))
      scene_->placed.push_back({placement_of(instance), entry(scene_->plants[instance.species]).slot});
  const std::size_t count = scene_->placed.size();
  const auto needed = instances_.slots_for_tile(count);
  if (!needed) {
    scene_->stream->refused(ready.tile);
    return true;
  }
  // What holds and draws them all grows with them: room is made for that, and the tile waits.
  if (!grow_slots(*needed)) return false;
  gpu::InstanceTile& tile = scene_->tiles[ready.tile];
  tile = *instances_.add_tile(scene_->placed);
  scene_->block_count += tile.block_count;
  if (ready.size_px > kGrowFrom_px && scene_->growing.size() < kMostGrowing) {
    instances_.scale_tile(tile, 1.0f / static_cast<float>(kGrowFrames));
    scene_->growing.push_back({ready.tile, 1});
  }
  scene_->stream->placed(ready.tile);
  return true;
}

// Where the threshold is above some pixels, plants would pop up.
void Context::grow_tiles() {
  for (Scene::Growing& growing : scene_->growing) {
    const auto share = static_cast<float>(growing.share);
    instances_.scale_tile(scene_->tiles[growing.tile], (share + 1.0f) / share);
    ++growing.share;
  }
  std::erase_if(scene_->growing, [](const Scene::Growing& growing) { return growing.share == kGrowFrames; });
}

void Context::remove_tile(std::uint32_t tile) {
  std::erase_if(scene_->growing, [tile](const Scene::Growing& growing) { return growing.tile == tile; });
  const gpu::InstanceTile removed = std::exchange(scene_->tiles[tile], {});
  instances_.remove_tile(removed);
  scene_->block_count -= removed.block_count;
}

}  // namespace coppice
