#include "layout.h"

#include <xxhash.h>

#include <array>

namespace coppice {

namespace {

/// Consecutive chunks of one kind.
struct Run {
  coppice_chunk_kind kind;
  std::uint32_t count, first;
  bool falling = false;  ///< indices go down
};

constexpr std::size_t kRuns = 13;

std::array<Run, kRuns> chunk_runs(const coppice_file_plant& plant) {
  const std::uint32_t lods = plant.wood_lod_count, pages = plant.page_count;
  const auto one = [](std::uint32_t count) { return count > 0 ? 1u : 0u; };
  const auto rest = [](std::uint32_t count) { return count > 0 ? count - 1 : 0u; };
  return {{{COPPICE_CHUNK_PLANT, 1, 0},
           {COPPICE_CHUNK_MATERIALS, 1, 0},
           {COPPICE_CHUNK_CARDS, 1, 0},
           {COPPICE_CHUNK_ERRORS, 1, 0},
           {COPPICE_CHUNK_WIND, 1, 0},
           {COPPICE_CHUNK_LEAF_MESHES, one(plant.leaf_mesh_count), 0},
           {COPPICE_CHUNK_TEXTURES, one(plant.texture_count), 0},
           {COPPICE_CHUNK_WOOD, one(lods), rest(lods)},
           {COPPICE_CHUNK_PAGE, one(pages), 0},
           {COPPICE_CHUNK_TEXTURE, plant.texture_count, 0},
           {COPPICE_CHUNK_WOOD, rest(lods), rest(rest(lods)), true},
           {COPPICE_CHUNK_PAGE, rest(pages), 1},
           {COPPICE_CHUNK_LEAF_MESH, plant.leaf_mesh_count, 0}}};
}

}  // namespace

std::uint32_t chunk_count(const coppice_file_plant& plant) {
  std::uint32_t count = 0;
  for (const Run& run : chunk_runs(plant)) count += run.count;
  return count;
}

ChunkKey chunk_at(const coppice_file_plant& plant, std::uint32_t position) {
  const std::array<Run, kRuns> runs = chunk_runs(plant);
  const Run* run = runs.data();
  for (; position >= run->count; ++run) position -= run->count;
  return {run->kind, run->falling ? run->first - position : run->first + position};
}

std::uint32_t first_read_chunk_count(const coppice_file_plant& plant) {
  const auto one = [](std::uint32_t count) { return count > 0 ? 1u : 0u; };
  return 5 + one(plant.leaf_mesh_count) + one(plant.texture_count) + one(plant.wood_lod_count) + one(plant.page_count);
}

const char* chunk_kind_name(std::uint32_t kind) {
  switch (kind) {
    case COPPICE_CHUNK_PLANT:
      return "PLANT";
    case COPPICE_CHUNK_MATERIALS:
      return "MATERIALS";
    case COPPICE_CHUNK_CARDS:
      return "CARDS";
    case COPPICE_CHUNK_ERRORS:
      return "ERRORS";
    case COPPICE_CHUNK_WOOD:
      return "WOOD";
    case COPPICE_CHUNK_PAGE:
      return "PAGE";
    case COPPICE_CHUNK_TEXTURE:
      return "TEXTURE";
    case COPPICE_CHUNK_LEAF_MESHES:
      return "LEAF_MESHES";
    case COPPICE_CHUNK_LEAF_MESH:
      return "LEAF_MESH";
    case COPPICE_CHUNK_TEXTURES:
      return "TEXTURES";
    case COPPICE_CHUNK_WIND:
      return "WIND";
    default:
      return "unknown";
  }
}

std::uint64_t checksum(std::span<const std::uint8_t> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace coppice
