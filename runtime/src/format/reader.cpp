// Parses the front of a .coppice file. It checks everything before it uses it: the header by its checksum and the file's real size, the
// table by its checksum and by the layout, which leaves no freedom (FORMAT.md: chunks tile the file in one order), and each parsed chunk by
// its checksum and by the range of every field. Structs are copied out byte by byte, never cast.

#include "reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>

#include "block_texture.h"
#include "file_fields.h"
#include "layout.h"
#include "tree.h"
#include "utf8.h"
#include "wind_field.h"

namespace coppice {

static_assert(std::endian::native == std::endian::little, "the file is copied into structs as it is");
static_assert(sizeof(coppice_file_header) == 64 && sizeof(coppice_file_chunk) == 32 && sizeof(coppice_file_plant) == 236 &&
              sizeof(coppice_file_material) == 32 && sizeof(coppice_file_card) == 48 && sizeof(coppice_file_texture) == 16 &&
              sizeof(coppice_file_leaf_mesh) == 8 && sizeof(coppice_file_wind) == 56 && sizeof(coppice_file_wind_node) == 4);

namespace {

using Bytes = std::span<const std::uint8_t>;

/// The caller has checked the length.
template <class T>
Result<void> copy_into(HookArray<T>& array, const coppice_allocator& allocator, Bytes bytes, std::size_t offset, std::size_t count) {
  COPPICE_CHECK(allocate_into(array, allocator, count));
  if (count > 0) std::memcpy(array.data(), bytes.data() + offset, array.bytes());
  return {};
}

bool in_unit_range(float value) {
  return value >= 0.0f && value <= 1.0f;
}  // also false for NaN

bool all_finite(std::span<const float> values) {
  for (float value : values)
    if (!std::isfinite(value)) return false;
  return true;
}

/// True for text up to a zero, then only zeros.
bool is_terminated_utf8(Bytes field) {
  std::size_t at = 0;
  while (at < field.size() && field[at] != 0) {
    const std::size_t length = utf8_sequence_length(field.subspan(at));
    if (length == 0) return false;
    at += length;
  }
  if (at == field.size()) return false;
  for (; at < field.size(); ++at)
    if (field[at] != 0) return false;
  return true;
}

Result<void> check_plant_counts(const coppice_file_plant& plant, std::uint64_t at) {
  const CountField fields[] = {
      {"plant leaf_count", plant.leaf_count, 1, COPPICE_MAX_LEAVES, offsetof(coppice_file_plant, leaf_count)},
      {"plant material_count", plant.material_count, 1, COPPICE_MAX_MATERIALS, offsetof(coppice_file_plant, material_count)},
      {"plant card_count", plant.card_count, 1, COPPICE_MAX_CARDS, offsetof(coppice_file_plant, card_count)},
      {"plant texture_count", plant.texture_count, 0, COPPICE_MAX_TEXTURES, offsetof(coppice_file_plant, texture_count)},
      {"plant wood_lod_count", plant.wood_lod_count, 0, COPPICE_MAX_WOOD_LODS, offsetof(coppice_file_plant, wood_lod_count)},
      {"plant error_level_count", plant.error_level_count, 1, COPPICE_MAX_ERROR_LEVELS, offsetof(coppice_file_plant, error_level_count)},
      {"plant error_size_count", plant.error_size_count, 1, COPPICE_MAX_ERROR_SIZES, offsetof(coppice_file_plant, error_size_count)},
      {"plant leaf_mesh_count", plant.leaf_mesh_count, 0, COPPICE_MAX_LEAF_MESHES, offsetof(coppice_file_plant, leaf_mesh_count)},
  };
  COPPICE_CHECK(check_count_fields(fields, at));
  const std::uint32_t page_count = (plant.leaf_count - 1 + COPPICE_PAGE_SPLITS - 1) / COPPICE_PAGE_SPLITS;
  if (plant.page_count != page_count)
    return bad_field("plant page_count", at + offsetof(coppice_file_plant, page_count),
                     std::to_string(plant.page_count) + ", but leaf_count asks for " + std::to_string(page_count));
  return {};
}

Result<void> check_wood_counts(const coppice_file_plant& plant, std::uint64_t at) {
  for (std::uint32_t lod = 0; lod < COPPICE_MAX_WOOD_LODS; ++lod) {
    const std::uint32_t triangles = plant.wood_triangle_counts[lod], vertices = plant.wood_vertex_counts[lod];
    const std::uint64_t triangles_at = at + offsetof(coppice_file_plant, wood_triangle_counts) + lod * 4;
    const bool present = lod < plant.wood_lod_count;
    if (present != (triangles > 0))
      return bad_field("plant wood_triangle_counts", triangles_at, "a LoD has triangles, a missing one has none");
    if (triangles > (lod == 0 ? COPPICE_MAX_WOOD_TRIANGLES : plant.wood_triangle_counts[lod - 1]))
      return bad_field("plant wood_triangle_counts", triangles_at, "over the limit or over the finer LoD's");
    if (vertices > 3 * triangles || (present && vertices < 3))
      return bad_field("plant wood_vertex_counts", at + offsetof(coppice_file_plant, wood_vertex_counts) + lod * 4,
                       std::to_string(vertices));
  }
  return {};
}

Result<void> check_plant_values(const coppice_file_plant& plant, std::uint64_t at) {
  for (int axis = 0; axis < 3; ++axis) {
    const float low = plant.leaf_box_min[axis], high = plant.leaf_box_max[axis];
    if (!std::isfinite(low) || !std::isfinite(high) || !std::isfinite(high - low) || !(high >= low))
      return bad_field("plant leaf_box", at + offsetof(coppice_file_plant, leaf_box_min), "not a finite box");
  }
  if (!all_finite(plant.sphere_center) || !std::isfinite(plant.sphere_radius) || !(plant.sphere_radius >= 0.0f))
    return bad_field("plant sphere", at + offsetof(coppice_file_plant, sphere_center), "not a finite sphere");
  for (const auto& corner : plant.root_quad)
    for (std::uint16_t coordinate : corner)
      if (coordinate > quantised_max(plant))
        return bad_field("plant root_quad", at + offsetof(coppice_file_plant, root_quad), "outside the leaf box");
  if (plant.root_card >= plant.card_count)
    return bad_field("plant root_card", at + offsetof(coppice_file_plant, root_card), "no such card");
  if (plant.root_opacity < 1 || plant.root_opacity > kOpaque)
    return bad_field("plant root_opacity", at + offsetof(coppice_file_plant, root_opacity), "not in 1..16");
  if (plant.leaf_count == 1 && plant.root_opacity != kOpaque)
    return bad_field("plant root_opacity", at + offsetof(coppice_file_plant, root_opacity), "of a source leaf");
  if (!are_normals(plant.root_normals))
    return bad_field("plant root_normals", at + offsetof(coppice_file_plant, root_normals),
                     "the quad's own, with other bits, or an axis finer than its along allows");
  COPPICE_CHECK(check_wood_counts(plant, at));
  if (plant.fine_positions > (plant.leaf_mesh_count > 0 ? 0 : 1))
    return bad_field("plant fine_positions", at + offsetof(coppice_file_plant, fine_positions), std::to_string(plant.fine_positions));
  if (plant.metric < COPPICE_METRIC_MI || plant.metric > COPPICE_METRIC_IMAGE)
    return bad_field("plant metric", at + offsetof(coppice_file_plant, metric), std::to_string(plant.metric) + " is no metric");
  std::uint8_t name[sizeof plant.name];
  std::memcpy(name, plant.name, sizeof name);
  if (!is_terminated_utf8(name)) return bad_field("plant name", at + offsetof(coppice_file_plant, name), "not zero-terminated UTF-8");
  return {};
}

/// Entries tile the file from the end of the table to its last byte, which excludes overlaps, gaps and sums that wrap.
Result<void> check_tiling(std::span<const coppice_file_chunk> chunks, std::uint64_t file_bytes) {
  std::uint64_t at = sizeof(coppice_file_header) + chunks.size() * sizeof(coppice_file_chunk);
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const std::uint64_t entry = sizeof(coppice_file_header) + i * sizeof(coppice_file_chunk);
    if (chunks[i].offset != at)
      return bad_field("chunk table offset", entry + offsetof(coppice_file_chunk, offset),
                       std::to_string(chunks[i].offset) + " where the chunk before ends at " + std::to_string(at));
    if (chunks[i].bytes == 0 || chunks[i].bytes > file_bytes - at)
      return bad_field("chunk table bytes", entry + offsetof(coppice_file_chunk, bytes),
                       std::to_string(chunks[i].bytes) + " with " + std::to_string(file_bytes - at) + " left in the file");
    at += chunks[i].bytes;
  }
  if (at != file_bytes) return bad_field("chunk table", sizeof(coppice_file_header), "bytes after the last chunk");
  return {};
}

Result<void> check_order(const PlantFile& file) {
  const std::uint32_t count = chunk_count(file.plant);
  if (count != file.chunks.size())
    return bad_field("header chunk_count", offsetof(coppice_file_header, chunk_count),
                     std::to_string(file.chunks.size()) + ", but PLANT asks for " + std::to_string(count));
  for (std::uint32_t i = 0; i < count; ++i) {
    const coppice_file_chunk& chunk = file.chunks[i];
    const ChunkKey key = chunk_at(file.plant, i);
    const std::uint64_t entry = sizeof(coppice_file_header) + i * sizeof(coppice_file_chunk);
    const auto expected = [&] { return std::string(chunk_kind_name(key.kind)) + " " + std::to_string(key.index) + " expected"; };
    if (chunk.kind != static_cast<std::uint32_t>(key.kind)) return bad_field("chunk table kind", entry, expected());
    if (chunk.index != key.index) return bad_field("chunk table index", entry + offsetof(coppice_file_chunk, index), expected());
    if (key.kind == COPPICE_CHUNK_WOOD && file.plant.wood_triangle_counts[key.index] > COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE * chunk.bytes)
      return bad_field("plant wood_triangle_counts",
                       file.chunks[0].offset + offsetof(coppice_file_plant, wood_triangle_counts) + key.index * 4,
                       "more than the WOOD chunk's length can hold");
    if (key.kind == COPPICE_CHUNK_PAGE && chunk.bytes > COPPICE_MAX_PAGE_BYTES)
      return bad_field("chunk table bytes", entry + offsetof(coppice_file_chunk, bytes), "a PAGE is longer than COPPICE_MAX_PAGE_BYTES");
  }
  const coppice_file_chunk& last = file.chunks[first_read_chunk_count(file.plant) - 1];
  if (file.header.first_read_bytes != last.offset + last.bytes)
    return bad_field("header first_read_bytes", offsetof(coppice_file_header, first_read_bytes),
                     "not the end of the first picture's chunks");
  return {};
}

/// Checks the table's bytes against the header, then the entries.
Result<HookArray<coppice_file_chunk>> read_table(const coppice_file_header& header, Bytes bytes, const coppice_allocator& allocator) {
  const std::uint64_t table_bytes = std::uint64_t{header.chunk_count} * sizeof(coppice_file_chunk);
  const Bytes table = bytes.subspan(sizeof(coppice_file_header), static_cast<std::size_t>(table_bytes));
  if (checksum(table) != header.table_checksum)
    return bad_field("chunk table checksum", offsetof(coppice_file_header, table_checksum), "the table's bytes do not match");
  HookArray<coppice_file_chunk> chunks;
  COPPICE_CHECK(copy_into(chunks, allocator, table, 0, header.chunk_count));
  COPPICE_CHECK(check_tiling(chunks.span(), header.file_bytes));
  return chunks;
}

/// Returns the checked bytes of chunk `position` of the front.
Result<Bytes> front_chunk(const PlantFile& file, Bytes bytes, std::size_t position, std::uint64_t expected_bytes) {
  const coppice_file_chunk& chunk = file.chunks[position];
  if (chunk.bytes != expected_bytes)
    return bad_field("chunk table bytes",
                     sizeof(coppice_file_header) + position * sizeof(coppice_file_chunk) + offsetof(coppice_file_chunk, bytes),
                     std::string(chunk_kind_name(chunk.kind)) + " has " + std::to_string(chunk.bytes) + " bytes, needs " +
                         std::to_string(expected_bytes));
  if (chunk.offset > bytes.size() || chunk.bytes > bytes.size() - chunk.offset)
    return bad_field("first read", bytes.size(), std::string(chunk_kind_name(chunk.kind)) + " is cut off");
  const Bytes content = bytes.subspan(static_cast<std::size_t>(chunk.offset), static_cast<std::size_t>(chunk.bytes));
  COPPICE_CHECK(check_chunk(chunk, content));
  return content;
}

Result<void> read_materials(PlantFile& file, Bytes bytes, const coppice_allocator& allocator) {
  COPPICE_TRY(content, front_chunk(file, bytes, 1, std::uint64_t{file.plant.material_count} * sizeof(coppice_file_material)));
  COPPICE_CHECK(copy_into(file.materials, allocator, content, 0, file.plant.material_count));
  for (std::size_t i = 0; i < file.materials.size(); ++i) {
    const coppice_file_material& material = file.materials[i];
    const std::uint64_t at = file.chunks[1].offset + i * sizeof(coppice_file_material);
    for (float channel : material.base_color)
      if (!in_unit_range(channel)) return bad_field("material base_color", at, "outside 0..1");
    if (!in_unit_range(material.alpha_cutoff))
      return bad_field("material alpha_cutoff", at + offsetof(coppice_file_material, alpha_cutoff), "outside 0..1");
    if (!in_unit_range(material.roughness))
      return bad_field("material roughness", at + offsetof(coppice_file_material, roughness), "outside 0..1");
    for (const std::uint32_t texture : {material_texture(material), material_normal_map(material)})
      if (texture != COPPICE_NO_TEXTURE && texture >= file.plant.texture_count)
        return bad_field("material texture", at + offsetof(coppice_file_material, texture_or_none), "no such texture");
    constexpr std::uint32_t kKnown = COPPICE_MATERIAL_DOUBLE_SIDED | COPPICE_MATERIAL_LEAF_MESH_ONLY | COPPICE_MATERIAL_SIDED_NORMALS;
    if ((material.flags & ~kKnown) != 0)
      return bad_field("material flags", at + offsetof(coppice_file_material, flags), "an unknown flag is set");
    if ((material.flags & COPPICE_MATERIAL_LEAF_MESH_ONLY) != 0 && file.plant.leaf_mesh_count == 0)
      return bad_field("material flags", at + offsetof(coppice_file_material, flags), "for leaf meshes, and there are none");
  }
  return {};
}

Result<void> read_cards(PlantFile& file, Bytes bytes, const coppice_allocator& allocator) {
  COPPICE_TRY(content, front_chunk(file, bytes, 2, std::uint64_t{file.plant.card_count} * sizeof(coppice_file_card)));
  COPPICE_CHECK(copy_into(file.cards, allocator, content, 0, file.plant.card_count));
  for (std::size_t i = 0; i < file.cards.size(); ++i) {
    const std::uint64_t at = file.chunks[2].offset + i * sizeof(coppice_file_card);
    if (file.cards[i].material >= file.plant.material_count) return bad_field("card material", at, "no such material");
    if ((file.materials[file.cards[i].material].flags & COPPICE_MATERIAL_LEAF_MESH_ONLY) != 0)
      return bad_field("card material", at, "one for leaf meshes only");
    for (const auto& uv : file.cards[i].uv)
      if (!all_finite(uv)) return bad_field("card uv", at + offsetof(coppice_file_card, uv), "not a finite number");
    if (file.cards[i].reserved != 0) return bad_field("card reserved", at + offsetof(coppice_file_card, reserved), "must be zero");
    if ((file.cards[i].mask[0] | file.cards[i].mask[1]) == 0)
      return bad_field("card mask", at + offsetof(coppice_file_card, mask), "shows nothing");
  }
  return {};
}

Result<void> check_errors(const PlantFile& file) {
  const std::uint64_t at = file.chunks[3].offset;
  const std::span<const std::uint32_t> counts = file.error_leaf_counts;
  for (std::size_t i = 1; i < counts.size(); ++i)
    if (counts[i] <= counts[i - 1]) return bad_field("error table leaf_counts", at + i * 4, "not ascending");
  if (counts.front() != 1 || counts.back() != file.plant.leaf_count)
    return bad_field("error table leaf_counts", at, "must run from 1 to leaf_count");
  const std::uint64_t sizes_at = at + counts.size() * 4;
  for (std::size_t i = 0; i < file.error_sizes_px.size(); ++i) {
    const float before = i == 0 ? 0.0f : file.error_sizes_px[i - 1];
    if (!std::isfinite(file.error_sizes_px[i]) || !(file.error_sizes_px[i] > before))
      return bad_field("error table sizes_px", sizes_at + i * 4, "not ascending from above 0");
  }
  const std::size_t columns = file.error_sizes_px.size();
  const std::uint64_t errors_at = sizes_at + columns * 4;
  for (std::size_t i = 0; i < file.error_px.size(); ++i) {
    if (!std::isfinite(file.error_px[i]) || !(file.error_px[i] >= 0.0f))
      return bad_field("error table error_px", errors_at + i * 4, "not a finite number from 0 up");
    if (i >= columns && !(file.error_px[i] <= file.error_px[i - columns]))
      return bad_field("error table error_px", errors_at + i * 4, "grows with the number of leaves");
  }
  const std::uint64_t wood_at = errors_at + file.error_px.size() * 4;
  for (std::size_t i = 0; i < file.wood_error_px.size(); ++i) {
    const float finer = i < columns ? 0.0f : file.wood_error_px[i - columns];
    if (!std::isfinite(file.wood_error_px[i]) || !(file.wood_error_px[i] >= finer))
      return bad_field("error table wood_error_px", wood_at + i * 4, "not a finite number from the finer LoD's up");
  }
  return {};
}

Result<void> read_errors(PlantFile& file, Bytes bytes, const coppice_allocator& allocator) {
  const std::size_t levels = file.plant.error_level_count, sizes = file.plant.error_size_count;
  const std::size_t wood_rows = file.plant.wood_lod_count;
  COPPICE_TRY(content, front_chunk(file, bytes, 3, (levels + (1 + levels + wood_rows) * sizes) * 4));
  COPPICE_CHECK(copy_into(file.error_leaf_counts, allocator, content, 0, levels));
  COPPICE_CHECK(copy_into(file.error_sizes_px, allocator, content, levels * 4, sizes));
  COPPICE_CHECK(copy_into(file.error_px, allocator, content, (levels + sizes) * 4, levels * sizes));
  COPPICE_CHECK(copy_into(file.wood_error_px, allocator, content, (levels + (1 + levels) * sizes) * 4, wood_rows * sizes));
  return check_errors(file);
}

Result<void> read_wind(PlantFile& file, Bytes bytes, const coppice_allocator& allocator) {
  const coppice_file_chunk& chunk = file.chunks[4];
  COPPICE_TRY(content, front_chunk(file, bytes, 4, chunk.bytes));
  const auto wrong_length = [&](std::uint64_t expected_bytes) {
    return bad_field("wind length", chunk.offset,
                     std::to_string(chunk.bytes) + " bytes, its fields and nodes need " + std::to_string(expected_bytes));
  };
  if (content.size() < sizeof(coppice_file_wind)) return wrong_length(sizeof(coppice_file_wind));
  file.wind = copy_at<coppice_file_wind>(content, 0);
  COPPICE_CHECK(check_wind_head(file.wind, chunk.offset));
  const std::size_t node_count = wind_node_count(file.wind.node_side);
  const std::size_t expected_bytes = sizeof(coppice_file_wind) + node_count * sizeof(coppice_file_wind_node);
  if (content.size() != expected_bytes) return wrong_length(expected_bytes);
  COPPICE_CHECK(copy_into(file.wind_nodes, allocator, content, sizeof(coppice_file_wind), node_count));
  return check_wind_field(wind_field(file), double{file.plant.sphere_radius}, chunk.offset);
}

Result<void> read_leaf_meshes(PlantFile& file, Bytes bytes, const coppice_allocator& allocator) {
  const std::size_t count = file.plant.leaf_mesh_count, sizes = file.plant.error_size_count;
  if (count == 0) return {};
  COPPICE_TRY(content, front_chunk(file, bytes, 5, count * sizeof(coppice_file_leaf_mesh) + sizes * 4));
  COPPICE_CHECK(copy_into(file.leaf_meshes, allocator, content, 0, count));
  COPPICE_CHECK(copy_into(file.leaf_mesh_error_px, allocator, content, count * sizeof(coppice_file_leaf_mesh), sizes));
  for (std::size_t i = 0; i < count; ++i) {
    const auto [vertices, triangles] = file.leaf_meshes[i];
    const std::uint64_t at = file.chunks[5].offset + i * sizeof(coppice_file_leaf_mesh);
    const std::uint64_t stored_bytes = file.chunks[file.chunks.size() - count + i].bytes;
    if (triangles == 0 || triangles > COPPICE_MAX_LEAF_MESH_TRIANGLES || triangles > COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE * stored_bytes)
      return bad_field("leaf mesh triangle_count", at + offsetof(coppice_file_leaf_mesh, triangle_count), std::to_string(triangles));
    if (vertices < 3 || vertices > 3 * triangles)
      return bad_field("leaf mesh vertex_count", at + offsetof(coppice_file_leaf_mesh, vertex_count), std::to_string(vertices));
  }
  const std::uint64_t errors_at = file.chunks[5].offset + count * sizeof(coppice_file_leaf_mesh);
  for (std::size_t i = 0; i < sizes; ++i) {
    const float before = i == 0 ? 0.0f : file.leaf_mesh_error_px[i - 1];
    if (!std::isfinite(file.leaf_mesh_error_px[i]) || !(file.leaf_mesh_error_px[i] >= before))
      return bad_field("leaf mesh error_px", errors_at + i * 4, "not a finite number from 0 up, or falling");
  }
  return {};
}

/// Adds `at` to the offset of an error.
Error placed_at(Error error, std::uint64_t at) {
  error.offset += at;
  return error;
}

Result<void> read_textures(PlantFile& file, Bytes bytes, const coppice_allocator& allocator) {
  const std::uint32_t count = file.plant.texture_count;
  if (count == 0) return {};
  const coppice_file_chunk& chunk = *find_chunk(file, COPPICE_CHUNK_TEXTURES, 0);
  COPPICE_TRY(content, front_chunk(file, bytes, static_cast<std::size_t>(&chunk - file.chunks.data()), chunk.bytes));
  const auto cut_off = [&] { return bad_field("textures", chunk.offset + chunk.bytes, "TEXTURES is cut off"); };
  std::size_t at = count * sizeof(coppice_file_texture);
  if (content.size() < at) return cut_off();
  COPPICE_CHECK(copy_into(file.textures, allocator, content, 0, count));
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t header_at = chunk.offset + i * sizeof(coppice_file_texture);
    const auto layout = texture_layout(file.textures[i]);
    if (!layout) return placed_at(layout.error(), header_at);
    const std::uint64_t stored_bytes = find_chunk(file, COPPICE_CHUNK_TEXTURE, i)->bytes;
    if (layout->bytes != stored_bytes)
      return bad_field("textures header", header_at,
                       "a TEXTURE of " + std::to_string(layout->bytes) + " bytes, but it has " + std::to_string(stored_bytes));
  }
  COPPICE_CHECK(allocate_into(file.small_textures, allocator, count));
  for (std::uint32_t i = 0; i < count; ++i) {
    if (std::ranges::find(file.materials, i, material_texture) == file.materials.end()) continue;
    if (content.size() - at < sizeof(coppice_file_texture)) return cut_off();
    const auto header = copy_at<coppice_file_texture>(content, at);
    const auto layout = texture_layout(header);
    if (!layout) return placed_at(layout.error(), chunk.offset + at);
    if (std::max(header.width, header.height) > COPPICE_MAX_SMALL_TEXTURE_SIDE || header.mip_count != 1)
      return bad_field("textures small texture", chunk.offset + at, "over COPPICE_MAX_SMALL_TEXTURE_SIDE, or several mip levels");
    if (content.size() - at < layout->bytes) return cut_off();
    COPPICE_CHECK(copy_into(file.small_textures[i], allocator, content, at, static_cast<std::size_t>(layout->bytes)));
    at += static_cast<std::size_t>(layout->bytes);
  }
  if (at != content.size()) return bad_field("textures", chunk.offset + at, "bytes after the last small texture");
  return {};
}

}  // namespace

Result<coppice_file_header> read_header(Bytes bytes, std::uint64_t file_bytes) {
  const Bytes magic = bytes.first(std::min(bytes.size(), sizeof coppice_file_header::magic));
  if (!std::equal(magic.begin(), magic.end(), COPPICE_FORMAT_MAGIC,
                  [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); }))
    return bad_field("magic", 0, "not a .coppice file");
  if (bytes.size() < sizeof(coppice_file_header)) return bad_field("header", bytes.size(), "the file is cut off");
  const auto header = copy_at<coppice_file_header>(bytes, 0);
  // The version is checked first, because another version may put its checksum elsewhere.
  if (header.version != COPPICE_FORMAT_VERSION)
    return bad_field(
        "version", offsetof(coppice_file_header, version),
        std::to_string(header.version) + "; this build reads " + std::to_string(COPPICE_FORMAT_VERSION) + ": bake the plant again");
  if (checksum(bytes.first(offsetof(coppice_file_header, header_checksum))) != header.header_checksum)
    return bad_field("header checksum", offsetof(coppice_file_header, header_checksum), "the header's bytes do not match");
  if (header.file_bytes != file_bytes)
    return bad_field("header file_bytes", offsetof(coppice_file_header, file_bytes),
                     std::to_string(header.file_bytes) + ", but the file has " + std::to_string(file_bytes));
  if (header.reserved[0] != 0 || header.reserved[1] != 0)
    return bad_field("header reserved", offsetof(coppice_file_header, reserved), "must be zero");
  if (header.first_read_bytes > file_bytes)
    return bad_field("header first_read_bytes", offsetof(coppice_file_header, first_read_bytes), "longer than the file");
  if (header.first_read_bytes < sizeof header ||
      header.chunk_count > (header.first_read_bytes - sizeof header) / sizeof(coppice_file_chunk))
    return bad_field("header chunk_count", offsetof(coppice_file_header, chunk_count), "the chunk table does not fit in the first read");
  return header;
}

Result<PlantFile> read_front(Bytes bytes, std::uint64_t file_bytes, const coppice_allocator& allocator) {
  PlantFile file;
  COPPICE_CHECK(move_into(file.header, read_header(bytes, file_bytes)));
  if (bytes.size() < file.header.first_read_bytes) return bad_field("first read", bytes.size(), "the file is cut off");
  bytes = bytes.first(static_cast<std::size_t>(file.header.first_read_bytes));
  COPPICE_CHECK(move_into(file.chunks, read_table(file.header, bytes, allocator)));
  if (file.chunks.size() < 5 || file.chunks[0].kind != COPPICE_CHUNK_PLANT)
    return bad_field("chunk table kind", sizeof(coppice_file_header), "PLANT 0 expected");
  COPPICE_TRY(content, front_chunk(file, bytes, 0, sizeof(coppice_file_plant)));
  file.plant = copy_at<coppice_file_plant>(content, 0);
  COPPICE_CHECK(check_plant_counts(file.plant, file.chunks[0].offset));
  COPPICE_CHECK(check_plant_values(file.plant, file.chunks[0].offset));
  COPPICE_CHECK(check_order(file));
  COPPICE_CHECK(read_materials(file, bytes, allocator));
  COPPICE_CHECK(read_cards(file, bytes, allocator));
  COPPICE_CHECK(read_errors(file, bytes, allocator));
  COPPICE_CHECK(read_wind(file, bytes, allocator));
  COPPICE_CHECK(read_leaf_meshes(file, bytes, allocator));
  COPPICE_CHECK(read_textures(file, bytes, allocator));
  return file;
}

std::size_t PlantFile::bytes() const {
  std::size_t sum = chunks.bytes() + materials.bytes() + cards.bytes() + error_leaf_counts.bytes() + error_sizes_px.bytes() +
                    error_px.bytes() + wind_nodes.bytes() + leaf_meshes.bytes() + wood_error_px.bytes() + textures.bytes() +
                    small_textures.bytes() + leaf_mesh_error_px.bytes();
  for (const HookBuffer& texture : small_textures) sum += texture.bytes();
  return sum;
}

WindField wind_field(const PlantFile& file) {
  return {file.wind, file.wind_nodes};
}

const coppice_file_chunk* find_chunk(const PlantFile& file, coppice_chunk_kind kind, std::uint32_t index) {
  const coppice_file_plant& plant = file.plant;
  const std::uint32_t textures = plant.leaf_mesh_count > 0 ? 6 : 5, first_wood = textures + (plant.texture_count > 0 ? 1u : 0u);
  const std::uint32_t first_page = first_wood + (plant.wood_lod_count > 0 ? 1u : 0u);
  const std::uint32_t first_texture = first_read_chunk_count(plant), finer_wood = first_texture + plant.texture_count;
  const std::uint32_t later_pages = finer_wood + (plant.wood_lod_count > 0 ? plant.wood_lod_count - 1 : 0);
  const std::uint32_t leaf_meshes = later_pages + (plant.page_count > 0 ? plant.page_count - 1 : 0);
  std::optional<std::uint32_t> position;
  if (kind >= COPPICE_CHUNK_PLANT && kind <= COPPICE_CHUNK_ERRORS && index == 0) position = static_cast<std::uint32_t>(kind) - 1;
  if (kind == COPPICE_CHUNK_WOOD && index < plant.wood_lod_count)
    position = index + 1 == plant.wood_lod_count ? first_wood : finer_wood + (plant.wood_lod_count - 2 - index);
  if (kind == COPPICE_CHUNK_PAGE && index < plant.page_count) position = index == 0 ? first_page : later_pages + index - 1;
  if (kind == COPPICE_CHUNK_TEXTURE && index < plant.texture_count) position = first_texture + index;
  if (kind == COPPICE_CHUNK_LEAF_MESHES && plant.leaf_mesh_count > 0 && index == 0) position = 5;
  if (kind == COPPICE_CHUNK_WIND && index == 0) position = 4;
  if (kind == COPPICE_CHUNK_TEXTURES && plant.texture_count > 0 && index == 0) position = textures;
  if (kind == COPPICE_CHUNK_LEAF_MESH && index < plant.leaf_mesh_count) position = leaf_meshes + index;
  return position && *position < file.chunks.size() ? &file.chunks[*position] : nullptr;
}

std::uint32_t quantised_max(const coppice_file_plant& plant) {
  return plant.fine_positions != 0 ? COPPICE_FINE_QUANTISED_MAX : COPPICE_QUANTISED_MAX;
}

std::uint32_t material_texture(const coppice_file_material& material) {
  return material.texture_or_none == COPPICE_FILE_NO_TEXTURE ? COPPICE_NO_TEXTURE : material.texture_or_none;
}

std::uint32_t material_normal_map(const coppice_file_material& material) {
  return material.normal_map_plus_one == 0 ? COPPICE_NO_TEXTURE : std::uint32_t{material.normal_map_plus_one} - 1;
}

void set_material_textures(coppice_file_material& material, std::uint32_t texture, std::uint32_t normal_map) {
  material.texture_or_none = static_cast<std::uint16_t>(texture);
  material.normal_map_plus_one = static_cast<std::uint16_t>(normal_map + 1);
}

Result<void> check_chunk(const coppice_file_chunk& chunk, Bytes bytes) {
  const auto name = [&] { return std::string(chunk_kind_name(chunk.kind)) + " " + std::to_string(chunk.index); };
  if (bytes.size() != chunk.bytes) return bad_field("chunk length", chunk.offset, name() + " is cut off");
  if (checksum(bytes) != chunk.checksum) return bad_field("chunk checksum", chunk.offset, name() + " is damaged");
  return {};
}

std::uint32_t page_split_count(std::uint32_t leaf_count, std::uint32_t page) {
  const std::uint64_t first = std::uint64_t{page} * COPPICE_PAGE_SPLITS, all = leaf_count - std::min(leaf_count, 1u);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(all - std::min(all, first), COPPICE_PAGE_SPLITS));
}

Result<TextureLayout> texture_layout(const coppice_file_texture& texture) {
  if (texture.width == 0 || texture.width > COPPICE_MAX_TEXTURE_SIDE) return bad_field("texture width", 0, std::to_string(texture.width));
  if (texture.height == 0 || texture.height > COPPICE_MAX_TEXTURE_SIDE)
    return bad_field("texture height", 4, std::to_string(texture.height));
  if (texture.mip_count == 0 || texture.mip_count > static_cast<std::uint32_t>(std::bit_width(std::max(texture.width, texture.height))))
    return bad_field("texture mip_count", 8, std::to_string(texture.mip_count));
  if (texture.format < COPPICE_TEXTURE_RGBA8 || texture.format > COPPICE_TEXTURE_BC1)
    return bad_field("texture format", 12, std::to_string(texture.format));
  TextureLayout layout{texture.format, sizeof(coppice_file_texture), texture.mip_count};
  for (std::uint32_t level = 0; level < texture.mip_count; ++level) {
    const std::uint32_t width = std::max(1u, texture.width >> level), height = std::max(1u, texture.height >> level);
    layout.all_levels[level] = {width, height, layout.bytes, texture_level_bytes(texture.format, width, height)};
    layout.bytes += layout.all_levels[level].bytes;
  }
  return layout;
}

Result<TextureLayout> read_texture(Bytes chunk) {
  if (chunk.size() < sizeof(coppice_file_texture)) return bad_field("texture header", chunk.size(), "cut off");
  COPPICE_TRY(layout, texture_layout(copy_at<coppice_file_texture>(chunk, 0)));
  if (layout.bytes != chunk.size())
    return bad_field("texture length", sizeof(coppice_file_texture),
                     std::to_string(chunk.size()) + " bytes, the header and the mip levels need " + std::to_string(layout.bytes));
  return layout;
}

Result<void> check_texture(const PlantFile& file, std::uint32_t index, Bytes chunk) {
  const coppice_file_texture& header = file.textures[index];
  if (chunk.size() >= sizeof header && std::memcmp(chunk.data(), &header, sizeof header) == 0) return {};
  return bad_field("texture header", find_chunk(file, COPPICE_CHUNK_TEXTURE, index)->offset, "not the one in TEXTURES");
}

}  // namespace coppice
