#include "coppice_file.h"

#include <bit>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <functional>

#include "decoded_pages.h"
#include "layout.h"
#include "page_encode.h"
#include "reader.h"
#include "unpack.h"
#include "writer.h"

namespace coppice::test {

namespace {

constexpr std::size_t kEntryBytes = sizeof(coppice_file_chunk);
constexpr std::size_t kTable = sizeof(coppice_file_header);

template <class T>
T get(const Bytes& file, std::size_t at) {
  T value{};
  if (at <= file.size() && sizeof(T) <= file.size() - at) std::memcpy(&value, file.data() + at, sizeof(T));
  return value;
}

template <class T>
void put(Bytes& file, std::size_t at, T value) {
  if (at <= file.size() && sizeof(T) <= file.size() - at) std::memcpy(file.data() + at, &value, sizeof(T));
}

PlantFile front_of(const Bytes& file) {
  auto front = read_front(file, file.size());
  if (!front) std::abort();
  return *std::move(front);
}

}  // namespace

void fix_checksums(Bytes& file) {
  const std::uint64_t count = get<std::uint32_t>(file, offsetof(coppice_file_header, chunk_count));
  if (file.size() < kTable) return;
  const std::span<const std::uint8_t> all(file);
  for (std::uint64_t i = 0; i < count && kTable + (i + 1) * kEntryBytes <= file.size(); ++i) {
    const std::size_t entry = kTable + static_cast<std::size_t>(i) * kEntryBytes;
    const auto chunk = get<coppice_file_chunk>(file, entry);
    if (chunk.offset > file.size() || chunk.bytes > file.size() - chunk.offset) continue;
    put(file, entry + offsetof(coppice_file_chunk, checksum),
        checksum(all.subspan(static_cast<std::size_t>(chunk.offset), static_cast<std::size_t>(chunk.bytes))));
  }
  if (count <= (file.size() - kTable) / kEntryBytes)
    put(file, offsetof(coppice_file_header, table_checksum), checksum(all.subspan(kTable, static_cast<std::size_t>(count) * kEntryBytes)));
  put(file, offsetof(coppice_file_header, header_checksum), checksum(all.first(offsetof(coppice_file_header, header_checksum))));
}

std::size_t entry_offset(const Bytes& file, coppice_chunk_kind kind, std::uint32_t index) {
  const PlantFile front = front_of(file);
  const coppice_file_chunk* chunk = find_chunk(front, kind, index);
  if (chunk == nullptr) std::abort();
  return kTable + static_cast<std::size_t>(chunk - front.chunks.data()) * kEntryBytes;
}

std::size_t chunk_offset(const Bytes& file, coppice_chunk_kind kind, std::uint32_t index) {
  return static_cast<std::size_t>(get<std::uint64_t>(file, entry_offset(file, kind, index) + offsetof(coppice_file_chunk, offset)));
}

namespace {

enum class Checksums { fixed, stale };

/// Collects variants of one good file.
class Damage {
 public:
  explicit Damage(const Bytes& good) : good_(good) {}

  /// Overwrites one value.
  template <class T>
  void set(const char* name, const char* reason, std::size_t at, T value) {
    set(name, reason, at, value, at);
  }

  /// The same for an error that is reported elsewhere than where the damage is.
  template <class T>
  void set(const char* name, const char* reason, std::size_t at, T value, std::size_t reported_at, Checksums checksums = Checksums::fixed) {
    Bytes file = good_;
    put(file, at, value);
    if (checksums == Checksums::fixed) fix_checksums(file);
    files.push_back({name, std::move(file), reason, reported_at});
  }

  void truncate(const char* name, const char* reason, std::size_t length, std::size_t reported_at) {
    files.push_back({name, Bytes(good_.begin(), good_.begin() + static_cast<std::ptrdiff_t>(length)), reason, reported_at});
  }

  std::vector<BadFile> files;

 private:
  const Bytes& good_;
};

constexpr std::size_t kFileBytes = offsetof(coppice_file_header, file_bytes), kFirstRead = offsetof(coppice_file_header, first_read_bytes),
                      kChunkCount = offsetof(coppice_file_header, chunk_count);
constexpr std::uint32_t kNan = 0x7fc00000, kInfinity = 0x7f800000;

void damage_header(Damage& damage, const Bytes& good) {
  damage.truncate("empty", "header", 0, 0);
  damage.truncate("header_cut", "header", 63, 63);
  damage.truncate("front_cut", "header file_bytes", 100, kFileBytes);
  damage.truncate("last_byte_missing", "header file_bytes", good.size() - 1, kFileBytes);
  damage.set("magic", "magic", 0, std::uint8_t{'c'});
  damage.set("version", "version", offsetof(coppice_file_header, version), std::uint32_t{COPPICE_FORMAT_VERSION + 1});
  damage.set("version_zero", "version", offsetof(coppice_file_header, version), std::uint32_t{0});
  damage.set("header_checksum", "header checksum", offsetof(coppice_file_header, reserved), std::uint8_t{1},
             offsetof(coppice_file_header, header_checksum), Checksums::stale);
  damage.set("file_bytes", "header file_bytes", kFileBytes, ~std::uint64_t{0});
  damage.set("header_reserved", "header reserved", offsetof(coppice_file_header, reserved), std::uint8_t{1});
  damage.set("first_read_long", "header first_read_bytes", kFirstRead, ~std::uint64_t{0});
  damage.set("first_read_short", "header chunk_count", kFirstRead, std::uint64_t{64}, kChunkCount);
  damage.set("first_read_no_page", "header first_read_bytes", kFirstRead, std::uint64_t{chunk_offset(good, COPPICE_CHUNK_PAGE, 0)},
             kFirstRead);
  damage.set("chunk_count", "header chunk_count", kChunkCount, ~std::uint32_t{0});
}

void damage_table(Damage& damage, const Bytes& good) {
  const std::size_t cards = entry_offset(good, COPPICE_CHUNK_CARDS), page = entry_offset(good, COPPICE_CHUNK_PAGE, 0);
  damage.set("table_checksum", "chunk table checksum", cards, std::uint8_t{99}, offsetof(coppice_file_header, table_checksum),
             Checksums::stale);
  damage.set("chunk_kind", "chunk table kind", cards, std::uint32_t{99});
  damage.set("chunk_index", "chunk table index", page + offsetof(coppice_file_chunk, index), std::uint32_t{1});
  damage.set("chunk_overlap", "chunk table offset", cards + offsetof(coppice_file_chunk, offset), std::uint64_t{64});
  damage.set("chunk_offset_wraps", "chunk table offset", cards + offsetof(coppice_file_chunk, offset), ~std::uint64_t{7});
  damage.set("chunk_empty", "chunk table bytes", cards + offsetof(coppice_file_chunk, bytes), std::uint64_t{0});
  damage.set("chunk_long", "chunk table bytes", cards + offsetof(coppice_file_chunk, bytes), ~std::uint64_t{0});
  for (const auto& [name, kind] : {std::pair{"plant_checksum", COPPICE_CHUNK_PLANT}, {"page_checksum", COPPICE_CHUNK_PAGE}})
    damage.set(name, "chunk checksum", chunk_offset(good, kind), std::uint8_t{1}, chunk_offset(good, kind), Checksums::stale);
}

void damage_plant(Damage& damage, const Bytes& good) {
  const std::size_t plant = chunk_offset(good, COPPICE_CHUNK_PLANT);
  const auto field = [&](const char* name, const char* reason, std::size_t offset, auto value) {
    damage.set(name, reason, plant + offset, value);
  };
  const std::size_t sphere = plant + offsetof(coppice_file_plant, sphere_center),
                    radius = plant + offsetof(coppice_file_plant, sphere_radius);
  field("leaf_count_zero", "plant leaf_count", offsetof(coppice_file_plant, leaf_count), std::uint32_t{0});
  field("leaf_count_huge", "plant leaf_count", offsetof(coppice_file_plant, leaf_count), ~std::uint32_t{0});
  field("page_count", "plant page_count", offsetof(coppice_file_plant, page_count), std::uint32_t{2});
  field("material_count", "plant material_count", offsetof(coppice_file_plant, material_count), std::uint32_t{257});
  field("card_count", "plant card_count", offsetof(coppice_file_plant, card_count), std::uint32_t{0});
  field("texture_count", "plant texture_count", offsetof(coppice_file_plant, texture_count), std::uint32_t{257});
  field("wood_lod_count", "plant wood_lod_count", offsetof(coppice_file_plant, wood_lod_count), std::uint32_t{9});
  field("error_level_count", "plant error_level_count", offsetof(coppice_file_plant, error_level_count), std::uint32_t{33});
  field("error_size_count", "plant error_size_count", offsetof(coppice_file_plant, error_size_count), std::uint32_t{0});
  field("leaf_box_nan", "plant leaf_box", offsetof(coppice_file_plant, leaf_box_min), kNan);
  damage.set("sphere_infinite", "plant sphere", radius, kInfinity, sphere);
  damage.set("sphere_small", "plant sphere", radius, 1.0f, sphere);
  field("root_quad", "plant root_quad", offsetof(coppice_file_plant, root_quad), std::uint16_t{32768});
  field("fine_positions", "plant fine_positions", offsetof(coppice_file_plant, fine_positions), std::uint16_t{2});
  field("root_card", "plant root_card", offsetof(coppice_file_plant, root_card), std::uint8_t{2});
  field("root_opacity", "plant root_opacity", offsetof(coppice_file_plant, root_opacity), std::uint8_t{17});
  field("root_opacity_zero", "plant root_opacity", offsetof(coppice_file_plant, root_opacity), std::uint8_t{0});
  field("root_normals", "plant root_normals", offsetof(coppice_file_plant, root_normals), std::uint16_t{0xc001});
  field("root_axis", "plant root_normals", offsetof(coppice_file_plant, root_normals), std::uint16_t{0x2401});
  field("wood_vertex_count", "plant wood_vertex_counts", offsetof(coppice_file_plant, wood_vertex_counts), ~std::uint32_t{0});
  const std::size_t triangles = offsetof(coppice_file_plant, wood_triangle_counts);
  field("wood_triangle_count", "plant wood_triangle_counts", triangles, COPPICE_MAX_WOOD_TRIANGLES + 1);
  field("wood_triangles_per_byte", "plant wood_triangle_counts", triangles, COPPICE_MAX_WOOD_TRIANGLES);
  field("metric", "plant metric", offsetof(coppice_file_plant, metric), std::uint32_t{0});
  field("leaf_mesh_count_huge", "plant leaf_mesh_count", offsetof(coppice_file_plant, leaf_mesh_count), std::uint16_t{17});
  field("name_not_utf8", "plant name", offsetof(coppice_file_plant, name), std::uint8_t{0xff});
  damage.set("name_not_terminated", "plant name", plant + offsetof(coppice_file_plant, name) + 63, std::uint8_t{'x'},
             plant + offsetof(coppice_file_plant, name));
}

void damage_tables(Damage& damage, const Bytes& good) {
  const std::size_t materials = chunk_offset(good, COPPICE_CHUNK_MATERIALS), cards = chunk_offset(good, COPPICE_CHUNK_CARDS);
  damage.set("base_color", "material base_color", materials, -1.0f);
  damage.set("alpha_cutoff", "material alpha_cutoff", materials + offsetof(coppice_file_material, alpha_cutoff), 1.5f);
  damage.set("roughness", "material roughness", materials + offsetof(coppice_file_material, roughness), kNan);
  damage.set("material_texture", "material texture", materials + offsetof(coppice_file_material, texture_or_none), std::uint32_t{1});
  damage.set("material_flags", "material flags", materials + offsetof(coppice_file_material, flags), std::uint32_t{8});
  damage.set("material_of_no_leaf_mesh", "material flags", materials + offsetof(coppice_file_material, flags),
             std::uint32_t{COPPICE_MATERIAL_LEAF_MESH_ONLY});
  damage.set("card_material", "card material", cards, std::uint32_t{2});
  damage.set("card_uv", "card uv", cards + offsetof(coppice_file_card, uv), kInfinity);
  damage.set("card_reserved", "card reserved", cards + offsetof(coppice_file_card, reserved), std::uint8_t{1});
  damage.set("card_mask", "card mask", cards + offsetof(coppice_file_card, mask), std::uint64_t{0});
  const PlantFile front = front_of(good);
  const std::size_t errors = chunk_offset(good, COPPICE_CHUNK_ERRORS), sizes = errors + 4 * front.error_leaf_counts.size();
  const std::size_t values = sizes + 4 * front.error_sizes_px.size();
  damage.set("error_first_level", "error table leaf_counts", errors, std::uint32_t{0});
  damage.set("error_levels_order", "error table leaf_counts", errors + 4, std::uint32_t{1});
  damage.set("error_sizes", "error table sizes_px", sizes, -1.0f);
  damage.set("error_negative", "error table error_px", values, -1.0f);
  damage.set("error_grows", "error table error_px", values + 4 * front.error_sizes_px.size(), 1e9f);
  const std::size_t wood_values = values + 4 * front.error_px.size();
  damage.set("wood_error_nan", "error table wood_error_px", wood_values, kNan);
  damage.set("wood_error_falls", "error table wood_error_px", wood_values + 4 * front.error_sizes_px.size(), -1.0f);
}

/// Where the page's first block of symbols states its length: behind header and tables.
std::size_t first_block(const Bytes& file, std::size_t page) {
  std::size_t at = page + 11 + 4 * std::size_t{file[page + 2]};
  int tables = 0;
  for (std::size_t i = 0; i < page_model::kStoredBytes; ++i) tables += std::popcount(file[at++]);
  for (; tables > 0; --tables) at += 1 + (file[at] + std::size_t{2}) / 2;
  return at;
}

void damage_wind(Damage& damage, const Bytes& good) {
  const std::size_t wind = chunk_offset(good, COPPICE_CHUNK_WIND), node = wind + sizeof(coppice_file_wind);
  const auto field = [&](const char* name, const char* reason, std::size_t offset, auto value) {
    damage.set(name, reason, wind + offset, value);
  };
  field("wind_base", "wind base_y_m", offsetof(coppice_file_wind, base_y_m), kInfinity);
  field("wind_height", "wind height_m", offsetof(coppice_file_wind, height_m), 0.0f);
  field("wind_bend", "wind bend_m", offsetof(coppice_file_wind, bend_m), -0.001f);
  field("wind_lean", "wind lean_m", offsetof(coppice_file_wind, lean_m), kNan);
  field("wind_sway", "wind sway_m", offsetof(coppice_file_wind, sway_m), kInfinity);
  field("wind_stem_period", "wind stem_period_s", offsetof(coppice_file_wind, stem_period_s), 0.0f);
  field("wind_branch_period", "wind branch_period_s", offsetof(coppice_file_wind, branch_period_s), 61.0f);
  field("wind_box_nan", "wind box", offsetof(coppice_file_wind, box_min), kNan);
  const std::size_t box = wind + offsetof(coppice_file_wind, box_min), top = wind + offsetof(coppice_file_wind, box_max) + 4;
  const std::size_t bend = wind + offsetof(coppice_file_wind, bend_m), side = wind + offsetof(coppice_file_wind, node_side);
  damage.set("wind_box_flat", "wind box", top, -1e6f, box);
  field("wind_node_side", "wind node_side", offsetof(coppice_file_wind, node_side), std::uint32_t{3});
  damage.set("wind_length", "wind length", side, std::uint32_t{8}, wind);
  damage.set("wind_no_grid", "wind lean_m", side, std::uint32_t{0}, wind + offsetof(coppice_file_wind, lean_m));
  damage.set("wind_node_cos", "wind node sway", node + 1, std::int8_t{-128});
  damage.set("wind_node_sin", "wind node sway", node + 2, std::int8_t{-128}, node + 1);
  damage.set("wind_node_reserved", "wind node reserved", node + 3, std::uint8_t{1});
  damage.set("wind_move", "wind move", wind + offsetof(coppice_file_wind, sway_m), 1e3f, bend);
  damage.set("wind_bent", "wind bend", wind + offsetof(coppice_file_wind, height_m), 1e-3f, bend);
  damage.set("wind_growth", "wind growth", box + 4, get<float>(good, top) - 1e-3f, bend);
}

void damage_chunks(Damage& damage, const Bytes& good) {
  const std::size_t page = chunk_offset(good, COPPICE_CHUNK_PAGE, 0), wood = chunk_offset(good, COPPICE_CHUNK_WOOD, 1);
  const std::size_t texture = chunk_offset(good, COPPICE_CHUNK_TEXTURE, 0);
  damage.set("page_split_count", "page split_count", page, std::uint16_t{0xffff}, page);
  damage.set("page_shape_count", "page shape_count", page + 2, std::uint8_t{4}, page);
  damage.set("page_rules", "page rules", page + 4, std::uint8_t{0x08}, page);
  // A table of five digits for a context of four symbols.
  damage.set("page_tables", "page tables", page + 11, std::uint64_t{4} << 48 | std::uint64_t{1} << page_model::kCorners1, page);
  damage.set("page_symbols", "page symbols", first_block(good, page), std::uint16_t{0xffff}, page);
  const std::size_t last_word = page + find_chunk(front_of(good), COPPICE_CHUNK_PAGE, 0)->bytes - 4;  // its lowest bit is never used
  damage.set("page_plain_bits", "page plain bits", last_word, static_cast<std::uint8_t>(good[last_word] | 1), page);
  damage.set("wood_header", "wood Draco header", wood, std::uint8_t{'d'}, wood);
  damage.set("wood_traversal", "wood traversal", wood + 11, std::uint8_t{2}, wood);
  damage.set("wood_triangles", "wood triangle count", wood + 13, std::uint8_t{1}, wood);
  damage.set("texture_header", "texture header", texture + 4, std::uint32_t{4097}, texture);
  const std::size_t textures = chunk_offset(good, COPPICE_CHUNK_TEXTURES, 0), small = textures + sizeof(coppice_file_texture);
  damage.set("texture_width", "texture width", textures, std::uint32_t{0});
  damage.set("texture_height", "texture height", textures + 4, std::uint32_t{4097});
  damage.set("texture_mips", "texture mip_count", textures + 8, std::uint32_t{32});
  damage.set("texture_format", "texture format", textures + 12, std::uint32_t{COPPICE_TEXTURE_BC1 + 1});
  damage.set("texture_format_zero", "texture format", textures + 12, std::uint32_t{0});
  damage.set("texture_length", "textures header", textures, std::uint32_t{5});
  damage.set("texture_too_many_blocks", "textures header", textures + 8, std::uint32_t{2}, textures);
  damage.set("texture_bc1_of_bc3_length", "textures header", textures + 12, std::uint32_t{COPPICE_TEXTURE_BC1}, textures);
  damage.set("texture_rgba8_of_bc3_length", "textures header", textures + 12, std::uint32_t{COPPICE_TEXTURE_RGBA8}, textures);
  damage.set("small_texture_width", "textures small texture", small, COPPICE_MAX_SMALL_TEXTURE_SIDE + 1);
  damage.set("small_texture_mips", "textures small texture", small + 8, std::uint32_t{2}, small);
  damage.set("small_texture_cut_off", "textures", small, COPPICE_MAX_SMALL_TEXTURE_SIDE,
             textures + find_chunk(front_of(good), COPPICE_CHUNK_TEXTURES, 0)->bytes);
}

/// What the file's only page holds.
struct PageContent {
  std::vector<Split> splits;
  std::vector<PageNode> nodes;  ///< by id
};

/// The file with its only page changed and coded again: what no flipped bit makes.
Bytes with_page(const Bytes& good, const std::function<void(PageContent&)>& change) {
  FileContents contents;
  const PlantFile front = front_of(good);
  contents.plant = front.plant;
  contents.materials = bake::to_vector(front.materials);
  contents.cards = bake::to_vector(front.cards);
  contents.error_leaf_counts = bake::to_vector(front.error_leaf_counts);
  contents.error_sizes_px = bake::to_vector(front.error_sizes_px);
  contents.error_px = bake::to_vector(front.error_px);
  contents.wood_error_px = bake::to_vector(front.wood_error_px);
  contents.wind = front.wind;
  contents.wind_nodes = bake::to_vector(front.wind_nodes);
  const auto chunk_bytes = [&](coppice_chunk_kind kind, std::uint32_t index) {
    const coppice_file_chunk& chunk = *find_chunk(front, kind, index);
    const auto first = good.begin() + static_cast<std::ptrdiff_t>(chunk.offset);
    return Bytes(first, first + static_cast<std::ptrdiff_t>(chunk.bytes));
  };
  for (std::uint32_t i = 0; i < front.plant.wood_lod_count; ++i) contents.wood.push_back(chunk_bytes(COPPICE_CHUNK_WOOD, i));
  for (std::uint32_t i = 0; i < front.plant.texture_count; ++i) contents.textures.push_back(chunk_bytes(COPPICE_CHUNK_TEXTURE, i));

  const std::uint32_t largest = quantised_max(front.plant);
  bake::DecodedPages pages(root_node(front.plant), front.plant.leaf_count, front.plant.card_count, largest);
  auto splits = pages.add(chunk_bytes(COPPICE_CHUNK_PAGE, 0));
  if (!splits) std::abort();
  PageContent page{*std::move(splits), pages.nodes()};
  change(page);
  contents.pages.push_back(*bake::encode_page({page.splits, 0, page.nodes, glm::vec3(1.0f), largest}));
  return *write_file(contents);
}

void damage_splits(Damage& damage, const Bytes& good) {
  const auto add = [&](const char* name, const char* reason, const std::function<void(PageContent&)>& change) {
    Bytes file = with_page(good, change);
    const std::size_t page = chunk_offset(file, COPPICE_CHUNK_PAGE, 0);
    damage.files.push_back({name, std::move(file), reason, page});
  };
  add("split_of_two_nodes", "page death", [&](PageContent& page) {
    std::size_t first = 1;
    while (page.nodes[first].split == kNeverReplaced || page.nodes[first + 1].split == kNeverReplaced) first += 2;
    page.nodes[first].split = page.nodes[first + 1].split;
  });
  add("split_of_no_node", "page parent", [&](PageContent& page) {
    std::ranges::find_if(page.nodes.begin() + 1, page.nodes.end(), [](const PageNode& node) {
      return node.split != kNeverReplaced;
    })->split = kNeverReplaced;
  });
  add("death_after_the_last_split", "page death",
      [](PageContent& page) { page.nodes.back().split = static_cast<std::uint32_t>(page.splits.size()); });
  add("card_not_there", "page tables", [](PageContent& page) { page.splits[1].cards[1] = 7; });
  add("vertex_outside", "page vertex", [](PageContent& page) { page.splits[1].new_vertices[3][2] = COPPICE_FINE_QUANTISED_MAX + 1; });
}

}  // namespace

std::vector<BadFile> bad_files(const Bytes& good) {
  Damage damage(good);
  damage_header(damage, good);
  damage_table(damage, good);
  damage_plant(damage, good);
  damage_tables(damage, good);
  damage_wind(damage, good);
  damage_chunks(damage, good);
  damage_splits(damage, good);
  return std::move(damage.files);
}

std::vector<BadFile> bad_leaf_mesh_files(const Bytes& good) {
  Damage damage(good);
  const std::size_t counts = chunk_offset(good, COPPICE_CHUNK_LEAF_MESHES), mesh = chunk_offset(good, COPPICE_CHUNK_LEAF_MESH, 1);
  const std::size_t second = counts + sizeof(coppice_file_leaf_mesh), errors = second + sizeof(coppice_file_leaf_mesh);
  const std::size_t vertices = second + offsetof(coppice_file_leaf_mesh, vertex_count),
                    triangles = second + offsetof(coppice_file_leaf_mesh, triangle_count);
  const std::size_t plant = chunk_offset(good, COPPICE_CHUNK_PLANT);
  damage.set("leaf_mesh_count", "header chunk_count", plant + offsetof(coppice_file_plant, leaf_mesh_count), std::uint16_t{1}, kChunkCount);
  damage.set("fine_positions_with_meshes", "plant fine_positions", plant + offsetof(coppice_file_plant, fine_positions), std::uint16_t{1});
  damage.set("leaf_mesh_vertices", "leaf mesh vertex_count", vertices, ~std::uint32_t{0});
  damage.set("leaf_mesh_no_vertices", "leaf mesh vertex_count", vertices, std::uint32_t{2});
  damage.set("leaf_mesh_triangles", "leaf mesh triangle_count", triangles, COPPICE_MAX_LEAF_MESH_TRIANGLES + 1);
  damage.set("leaf_mesh_triangles_per_byte", "leaf mesh triangle_count", triangles, COPPICE_MAX_LEAF_MESH_TRIANGLES);
  damage.set("leaf_mesh_no_triangles", "leaf mesh triangle_count", triangles, std::uint32_t{0});
  damage.set("leaf_mesh_error_nan", "leaf mesh error_px", errors, kNan);
  damage.set("leaf_mesh_error_falls", "leaf mesh error_px", errors + 4, 0.0f);
  damage.set("leaf_mesh_checksum", "chunk checksum", mesh, std::uint8_t{1}, mesh, Checksums::stale);
  damage.set("leaf_mesh_header", "wood Draco header", mesh, std::uint8_t{'d'}, mesh);
  damage.set("leaf_mesh_other_count", "wood triangle count", triangles, std::uint32_t{11}, mesh);
  const std::size_t flags = chunk_offset(good, COPPICE_CHUNK_MATERIALS) + offsetof(coppice_file_material, flags);
  damage.set("card_of_leaf_mesh_material", "card material", flags, std::uint32_t{COPPICE_MATERIAL_LEAF_MESH_ONLY},
             chunk_offset(good, COPPICE_CHUNK_CARDS));
  damage.set("wood_of_leaf_mesh_material", "wood material", flags + sizeof(coppice_file_material),
             std::uint32_t{COPPICE_MATERIAL_LEAF_MESH_ONLY}, chunk_offset(good, COPPICE_CHUNK_WOOD));
  return std::move(damage.files);
}

}  // namespace coppice::test
