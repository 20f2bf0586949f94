// What does not come from the allocator hook has the same size whatever a file holds: this program counts what new gives.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "fake_gpu.h"
#include "packed_plant.h"
#include "reader.h"
#include "scene_file.h"
#include "scene_stream.h"
#include "streamer.h"
#include "wood_codec.h"

namespace {

std::atomic<std::size_t> new_bytes = 0;  ///< since the program began

}  // namespace

void* operator new(std::size_t bytes) {
  new_bytes += bytes;
  if (void* memory = std::malloc(bytes)) return memory;
  std::abort();
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {  // AddressSanitizer has its own, which frees otherwise
  return operator new(bytes);
}
// g++ 12 at -O1 takes in the one without the other, and warns of a free without a malloc.
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace coppice {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int kFrames = 60;
const std::string kLongName(300, 'a');

/// One file in memory; reads and jobs run inline.
Hooks inline_hooks(std::span<const std::uint8_t>& file) {
  const auto open = [](void* user, const char*, std::uint64_t* file_bytes) -> std::int64_t {
    *file_bytes = static_cast<std::span<const std::uint8_t>*>(user)->size();
    return 0;
  };
  const auto read = [](void* user, std::int64_t, std::uint64_t offset, void* destination, std::size_t bytes,
                       void (*done)(void* argument, std::int64_t bytes_read), void* argument) {
    const auto taken = static_cast<std::span<const std::uint8_t>*>(user)->subspan(offset, bytes);
    std::ranges::copy(taken, static_cast<std::uint8_t*>(destination));
    done(argument, static_cast<std::int64_t>(bytes));
  };
  const auto submit = [](void*, const coppice_job* job) { job->function(job->argument); };
  return {.allocator = default_allocator(),
          .jobs = {sizeof(coppice_jobs), nullptr, submit},
          .io = {sizeof(coppice_io), &file, open, [](void*, std::int64_t) {}, read, nullptr}};
}

/// What new gives while a plant is opened, all of it is streamed, and it is closed.
std::size_t new_bytes_of_plant(std::span<const std::uint8_t> file, const char* name) {
  const std::vector<PlantDemand> demands = {test::demand_of(5000.0f)};
  LodView view;
  view.full = true;
  Ledger ledger;
  PlantState state;
  bool settled = false;
  const std::size_t before = new_bytes;
  {
    const auto streamer = *Streamer::create(inline_hooks(file), ledger, {});
    const auto plant = streamer->open_plant(name);
    for (std::uint64_t frame = 1; plant && frame <= kFrames; ++frame) {
      static_cast<void>(streamer->release(frame - 1));
      streamer->begin_frame({.frame_number = frame, .view_groups = {ViewGroup{view, demands}}});
      for (const DecodedChunk& chunk : streamer->take_decoded(UINT64_MAX))
        if (streamer->begin_upload(chunk.id)) streamer->uploaded(chunk.id);
    }
    settled = plant && streamer->is_settled(*plant);
    if (plant) state = streamer->state(*plant);
  }
  const std::size_t after = new_bytes;
  EXPECT_TRUE(settled);
  const auto front = read_front(file, file.size());
  EXPECT_EQ(state.resident_leaf_count, front->plant.leaf_count);
  EXPECT_EQ(state.resident_texture_count, front->plant.texture_count);
  EXPECT_EQ(state.leaf_meshes_resident, front->plant.leaf_mesh_count > 0);
  return after - before;
}

TEST(HookedMemory, WhatNewGivesForAPlantDoesNotDependOnIt) {
  const Bytes small = test::packed_plant({.leaf_count = 600, .wood_lod_count = 0, .texture_side = 2});
  const Bytes large = test::packed_plant({.leaf_count = 6000, .card_count = 200, .wood_lod_count = 0, .texture_side = 256});
  new_bytes_of_plant(small, "a");  // the first has what is made once
  EXPECT_EQ(new_bytes_of_plant(small, "a"), new_bytes_of_plant(large, kLongName.c_str()));
}

TEST(HookedMemory, MeshesTakeWhatDracoTakesBesides) {
  const Bytes bare = test::packed_plant({.leaf_count = 600, .wood_lod_count = 0}),
              meshed = test::packed_plant({.leaf_count = 600, .leaf_mesh_count = 3});
  const auto front = read_front(meshed, meshed.size());
  std::size_t draco_bytes = 0;
  for (const coppice_file_chunk& chunk : front->chunks) {
    const bool wood = chunk.kind == COPPICE_CHUNK_WOOD;
    if (!wood && chunk.kind != COPPICE_CHUNK_LEAF_MESH) continue;
    WoodShape shape{front->plant.wood_vertex_counts[chunk.index % COPPICE_MAX_WOOD_LODS],
                    front->plant.wood_triangle_counts[chunk.index % COPPICE_MAX_WOOD_LODS], front->materials};
    if (!wood)
      shape = {front->leaf_meshes[chunk.index].vertex_count, front->leaf_meshes[chunk.index].triangle_count, front->materials, true};
    const std::size_t before = new_bytes;
    ASSERT_TRUE(decode_wood(std::span(meshed).subspan(chunk.offset, chunk.bytes), shape));
    draco_bytes += new_bytes - before;
  }
  EXPECT_GT(draco_bytes, 0u);
  new_bytes_of_plant(bare, "a");
  EXPECT_EQ(new_bytes_of_plant(meshed, "a"), new_bytes_of_plant(bare, "a") + draco_bytes);
}

TEST(HookedMemory, WhatNewGivesForASceneDoesNotDependOnIt) {
  const auto new_bytes_of_scene = [](const Bytes& bytes, const char* name) {
    std::span<const std::uint8_t> file = bytes;
    Ledger ledger;
    std::uint32_t missing = 1;
    const std::size_t before = new_bytes;
    {
      const auto scene = *SceneStream::open(inline_hooks(file), ledger, name, {.plants = {.allow_outside = true}});
      for (int frame = 0; frame < kFrames; ++frame) {
        scene->begin_frame(std::array{SceneEye{{0.0f, 2.0f, 0.0f}, 600.0f, 0.1f}}, 1u << 20);
        while (const auto species = scene->next_species()) scene->species_opened(species->species, true);
        while (const auto ready = scene->next_ready()) scene->placed(ready->tile);
      }
      missing = scene->stats().missing_tiles;
    }
    const std::size_t after = new_bytes;
    EXPECT_EQ(missing, 0u);
    return after - before;
  };
  const Bytes small = test::random_scene(50, 100.0f, 1), large = test::random_scene(20000, 2000.0f, 2);
  EXPECT_EQ(new_bytes_of_scene(small, "a"), new_bytes_of_scene(large, kLongName.c_str()));
}

}  // namespace
}  // namespace coppice
