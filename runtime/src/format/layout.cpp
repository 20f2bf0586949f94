#include "layout.h"

#include <xxhash.h>

namespace coppice {

std::vector<ChunkKey> chunk_order(const coppice_file_plant& plant) {
  std::vector<ChunkKey> order = {
      {COPPICE_CHUNK_PLANT, 0}, {COPPICE_CHUNK_MATERIALS, 0}, {COPPICE_CHUNK_CARDS, 0}, {COPPICE_CHUNK_ERRORS, 0}};
  if (plant.leaf_mesh_count > 0) order.push_back({COPPICE_CHUNK_LEAF_MESHES, 0});
  if (plant.wood_lod_count > 0) order.push_back({COPPICE_CHUNK_WOOD, plant.wood_lod_count - 1});
  if (plant.page_count > 0) order.push_back({COPPICE_CHUNK_PAGE, 0});
  for (std::uint32_t texture = 0; texture < plant.texture_count; ++texture) order.push_back({COPPICE_CHUNK_TEXTURE, texture});
  for (std::uint32_t lod = plant.wood_lod_count; lod-- > 1;) order.push_back({COPPICE_CHUNK_WOOD, lod - 1});
  for (std::uint32_t page = 1; page < plant.page_count; ++page) order.push_back({COPPICE_CHUNK_PAGE, page});
  for (std::uint32_t mesh = 0; mesh < plant.leaf_mesh_count; ++mesh) order.push_back({COPPICE_CHUNK_LEAF_MESH, mesh});
  return order;
}

std::uint32_t first_read_chunk_count(const coppice_file_plant& plant) {
  return 4u + (plant.leaf_mesh_count > 0 ? 1u : 0u) + (plant.wood_lod_count > 0 ? 1u : 0u) + (plant.page_count > 0 ? 1u : 0u);
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
    default:
      return "unknown";
  }
}

std::uint64_t checksum(std::span<const std::uint8_t> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace coppice
