#include "inspect.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/gtc/type_ptr.hpp>

#include "block_texture.h"
#include "bounds.h"
#include "layout.h"
#include "leaf_mesh_parts.h"
#include "printable.h"
#include "reader.h"
#include "unpack.h"

namespace coppice::bake {
namespace {

const char* coded_by_draco(std::uint32_t kind) {
  if (kind == COPPICE_CHUNK_PAGE) return "symbols";
  return kind == COPPICE_CHUNK_WOOD || kind == COPPICE_CHUNK_LEAF_MESH ? "mesh" : "";
}

std::vector<ChunkSummary> summarise_chunks(const PlantFile& file) {
  std::vector<ChunkSummary> result;
  for (std::uint32_t kind = COPPICE_CHUNK_PLANT; kind <= COPPICE_CHUNK_WIND; ++kind) {
    ChunkSummary summary{chunk_kind_name(kind), 0, 0, coded_by_draco(kind)};
    for (const coppice_file_chunk& chunk : file.chunks)
      if (chunk.kind == kind) {
        ++summary.count;
        summary.bytes += chunk.bytes;
      }
    if (summary.count > 0) result.push_back(summary);
  }
  return result;
}

bool is_all_wood(const coppice_file_plant& plant) {
  const auto is_first_corner = [&](const auto& corner) { return std::ranges::equal(corner, plant.root_quad[0]); };
  return plant.leaf_count == 1 && plant.wood_lod_count > 0 && std::ranges::all_of(plant.root_quad, is_first_corner);
}

WindSummary wind_summary(const WindField& field) {
  WindSummary summary{field.head, 0.0f, 0.0f, max_wind_move_m(field), max_wind_growth(field)};
  for (const coppice_file_wind_node& node : field.nodes) {
    const float sway_cos = static_cast<float>(node.sway_cos) / 127.0f, sway_sin = static_cast<float>(node.sway_sin) / 127.0f;
    summary.max_lean_m = std::max(summary.max_lean_m, field.head.lean_m * static_cast<float>(node.lean) / 255.0f);
    summary.max_sway_m = std::max(summary.max_sway_m, field.head.sway_m * std::sqrt(sway_cos * sway_cos + sway_sin * sway_sin));
  }
  return summary;
}

/// Size of the leaves, if there are any, and the finest wood.
Result<std::array<double, 3>> measure(const PlantFile& file, std::span<const std::uint8_t> bytes) {
  PointBox<glm::dvec3> box;
  box.add(glm::make_vec3(file.plant.leaf_box_min));
  box.add(glm::make_vec3(file.plant.leaf_box_max));
  if (file.plant.wood_lod_count > 0) {
    COPPICE_TRY(wood, unpack_wood(file, bytes, 0));
    for (const glm::vec3& position : wood.positions) box.add(position);
  }
  const glm::dvec3 size_m = box.extent();
  return std::array<double, 3>{size_m.x, size_m.y, size_m.z};
}

}  // namespace

Result<FileSummary> inspect(std::span<const std::uint8_t> bytes) {
  COPPICE_TRY(file, read_front(bytes, bytes.size()));
  FileSummary summary;
  summary.version = file.header.version;
  summary.name = file.plant.name;
  summary.metric = file.plant.metric;
  summary.file_bytes = file.header.file_bytes;
  summary.first_read_bytes = file.header.first_read_bytes;
  summary.leaf_count = is_all_wood(file.plant) ? 0 : file.plant.leaf_count;
  summary.page_count = file.plant.page_count;
  summary.material_count = file.plant.material_count;
  summary.card_count = file.plant.card_count;
  summary.chunks = summarise_chunks(file);
  for (std::uint32_t lod = 0; lod < file.plant.wood_lod_count; ++lod)
    summary.wood.push_back(
        {file.plant.wood_vertex_counts[lod], file.plant.wood_triangle_counts[lod], find_chunk(file, COPPICE_CHUNK_WOOD, lod)->bytes});
  for (std::uint32_t texture = 0; texture < file.plant.texture_count; ++texture) {
    const coppice_file_texture& header = file.textures[texture];
    summary.textures.push_back({texture_format_name(header.format), header.width, header.height, header.mip_count,
                                find_chunk(file, COPPICE_CHUNK_TEXTURE, texture)->bytes});
  }
  for (std::uint32_t mesh = 0; mesh < file.plant.leaf_mesh_count; ++mesh)
    summary.leaf_meshes.push_back({file.leaf_meshes[mesh].vertex_count, file.leaf_meshes[mesh].triangle_count,
                                   find_chunk(file, COPPICE_CHUNK_LEAF_MESH, mesh)->bytes});
  COPPICE_CHECK(move_into(summary.size_m, measure(file, bytes)));
  summary.wind = wind_summary(wind_field(file));
  summary.leaf_mesh_error_px = to_vector(file.leaf_mesh_error_px);
  std::uint64_t page_bytes = 0;
  for (std::uint32_t page = 0; page < file.plant.page_count; ++page) page_bytes += find_chunk(file, COPPICE_CHUNK_PAGE, page)->bytes;
  summary.bytes_per_leaf = summary.leaf_count > 0 ? static_cast<double>(page_bytes) / summary.leaf_count : 0.0;
  summary.error_leaf_counts = to_vector(file.error_leaf_counts);
  summary.error_sizes_px = to_vector(file.error_sizes_px);
  summary.error_px = to_vector(file.error_px);
  summary.wood_error_px = to_vector(file.wood_error_px);
  return summary;
}

Result<VerifyReport> verify(std::span<const std::uint8_t> bytes) {
  COPPICE_TRY(plant, unpack(bytes));
  COPPICE_TRY(file, read_front(bytes, bytes.size()));
  if (!is_printable(plant.name))
    return Error{Status::bad_file, "plant name: control characters",
                 find_chunk(file, COPPICE_CHUNK_PLANT, 0)->offset + offsetof(coppice_file_plant, name), plant.name};
  VerifyReport report;
  report.bytes_checked = bytes.size();
  report.chunks_checked = static_cast<std::uint32_t>(file.chunks.size());
  report.splits_decoded = static_cast<std::uint32_t>(plant.tree.split_parent.size());
  for (const Mesh& lod : plant.wood.lods) report.wood_triangles_decoded += static_cast<std::uint32_t>(lod.triangle_materials.size());
  report.leaf_mesh_triangles_decoded = triangle_count(plant.leaf_meshes);
  return report;
}

}  // namespace coppice::bake
