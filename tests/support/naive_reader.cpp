// Sections 1 to 8 and 11 to 13 of FORMAT.md.

#include "naive_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <xxhash.h>

namespace coppice::test {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kPlant = 1, kMaterials = 2, kCards = 3, kErrors = 4, kWood = 5, kPage = 6, kTexture = 7, kLeafMeshes = 8,
                        kTextures = 10, kLeafMesh = 9, kWind = 11;
constexpr std::uint64_t kHeaderBytes = 64, kEntryBytes = 32;
constexpr std::uint32_t kPageSplits = 512;

/// Section 2, but for what the chunks say, section 3, and the checksums of all chunks.
void read_header_and_table(Bytes file, NaivePlant& plant) {
  naive_must(file.size() >= kHeaderBytes, "shorter than a header");
  NaiveBytes bytes(file);
  constexpr std::array<std::uint8_t, 8> kMagic = {0x43, 0x4f, 0x50, 0x50, 0x49, 0x43, 0x45, 0x1a};
  naive_must(std::ranges::equal(bytes.take(8), kMagic), "magic");
  naive_must(bytes.u32() == 9, "version");
  const std::uint32_t chunk_count = bytes.u32();
  const std::uint64_t file_bytes = bytes.u64();
  plant.first_read_bytes = bytes.u64();
  const std::uint64_t table_checksum = bytes.u64();
  naive_must(bytes.u64() == 0 && bytes.u64() == 0, "reserved");
  naive_must(bytes.u64() == XXH3_64bits(file.data(), 56), "header_checksum");
  naive_must(file_bytes == file.size(), "file_bytes");
  naive_must(plant.first_read_bytes <= file_bytes, "first_read_bytes beyond the file");
  naive_must(kHeaderBytes + kEntryBytes * chunk_count <= plant.first_read_bytes, "chunk_count");
  const Bytes table = file.subspan(kHeaderBytes, kEntryBytes * chunk_count);
  naive_must(table_checksum == XXH3_64bits(table.data(), table.size()), "table_checksum");
  std::uint64_t next = kHeaderBytes + table.size();
  for (NaiveBytes entries(table); entries.left() > 0;) {
    NaiveChunk chunk;
    chunk.kind = entries.u32();
    chunk.index = entries.u32();
    chunk.offset = entries.u64();
    chunk.bytes = entries.u64();
    naive_must(chunk.offset == next, "a chunk does not start where the one before ends");
    naive_must(chunk.bytes > 0 && chunk.bytes <= file.size() - next, "a chunk is empty or runs past the end");
    naive_must(chunk.kind != kPage || chunk.bytes <= 65536, "a page is too long");
    naive_must(entries.u64() == XXH3_64bits(file.data() + chunk.offset, chunk.bytes), "a chunk's checksum");
    next += chunk.bytes;
    plant.chunks.push_back(chunk);
  }
  naive_must(next == file.size(), "the last chunk does not end with the file");
}

NaiveBytes chunk_of(Bytes file, const NaivePlant& plant, std::uint32_t kind, std::uint32_t index) {
  for (const NaiveChunk& chunk : plant.chunks)
    if (chunk.kind == kind && chunk.index == index) return NaiveBytes(file.subspan(chunk.offset, chunk.bytes));
  throw NaiveRefusal("a chunk is missing");
}

bool is_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

void read_floats(NaiveBytes& bytes, std::span<float> values) {
  for (float& value : values) value = bytes.f32();
}

std::vector<float> floats(NaiveBytes& bytes, std::size_t count) {
  std::vector<float> values(count);
  read_floats(bytes, values);
  return values;
}

/// Well-formed as Unicode has it: no surrogates, nothing longer than it need be.
bool is_utf8(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t more = lead < 0x80 ? 0 : lead >> 5 == 6 ? 1 : lead >> 4 == 14 ? 2 : lead >> 3 == 30 ? 3 : 4;
    if (more == 4 || i + more >= text.size()) return false;
    std::uint32_t code = more == 0 ? lead : lead & (0x3fu >> more);
    for (std::size_t k = 1; k <= more; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if (next >> 6 != 2) return false;
      code = code << 6 | (next & 0x3fu);
    }
    constexpr std::array<std::uint32_t, 4> kLeast = {0, 0x80, 0x800, 0x10000};
    if (code < kLeast[more] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) return false;
    i += more + 1;
  }
  return true;
}

std::string read_name(NaiveBytes& bytes) {
  const Bytes stored = bytes.take(64);
  const auto end = std::ranges::find(stored, std::uint8_t{0});
  naive_must(end != stored.end(), "name: no zero");
  naive_must(std::all_of(end, stored.end(), [](std::uint8_t byte) { return byte == 0; }), "name: bytes after the zero");
  std::string name(stored.begin(), end);
  naive_must(is_utf8(name), "name: not UTF-8");
  return name;
}

struct Counts {
  std::uint32_t materials = 0, cards = 0, levels = 0, sizes = 0;
};

void read_box_and_sphere(NaiveBytes& bytes, NaivePlant& plant) {
  read_floats(bytes, plant.leaf_box_min);
  read_floats(bytes, plant.leaf_box_max);
  naive_must(is_finite(plant.leaf_box_min) && is_finite(plant.leaf_box_max), "leaf_box");
  for (std::size_t a = 0; a < 3; ++a)
    naive_must(plant.leaf_box_max[a] >= plant.leaf_box_min[a] && std::isfinite(plant.leaf_box_max[a] - plant.leaf_box_min[a]), "leaf_box");
  read_floats(bytes, plant.sphere_center);
  plant.sphere_radius = bytes.f32();
  naive_must(is_finite(plant.sphere_center) && std::isfinite(plant.sphere_radius) && plant.sphere_radius >= 0, "sphere");
}

/// Section 4 by itself.
Counts read_plant(NaiveBytes bytes, NaivePlant& plant) {
  naive_must(bytes.left() == 236, "PLANT's length");
  Counts counts;
  plant.leaf_count = bytes.u32();
  naive_must(plant.leaf_count >= 1 && plant.leaf_count <= 1u << 26, "leaf_count");
  plant.page_count = bytes.u32();
  naive_must(plant.page_count == (plant.leaf_count - 1 + kPageSplits - 1) / kPageSplits, "page_count");
  counts.materials = bytes.u32();
  counts.cards = bytes.u32();
  plant.texture_count = bytes.u32();
  plant.wood_lod_count = bytes.u32();
  counts.levels = bytes.u32();
  counts.sizes = bytes.u32();
  naive_must(counts.materials >= 1 && counts.materials <= 256 && counts.cards >= 1 && counts.cards <= 256, "material_count, card_count");
  naive_must(plant.texture_count <= 256 && plant.wood_lod_count <= 8, "texture_count, wood_lod_count");
  naive_must(counts.levels >= 1 && counts.levels <= 32 && counts.sizes >= 1 && counts.sizes <= 16, "error table's counts");
  read_box_and_sphere(bytes, plant);
  NaiveNode root;
  for (NaivePoint& corner : root.corners)
    for (std::int64_t& coordinate : corner) coordinate = bytes.u16();
  root.card = bytes.u8();
  naive_must(root.card < counts.cards, "root_card");
  root.opacity = bytes.u8();
  naive_must(root.opacity >= (plant.leaf_count > 1 ? 1 : 16) && root.opacity <= 16, "root_opacity");
  const std::uint32_t normals = bytes.u16();
  root.axis = {normals % 32, normals / 32 % 32};
  root.along = normals / 1024 % 16;
  root.side = normals / 16384;
  const std::uint32_t bits = naive_axis_bits(root.along);
  for (const std::uint32_t step : root.axis) naive_must(step == naive_axis_step(step >> (5 - bits), bits), "root_normals");
  naive_must(root.side < 3 || normals % 16384 == 0, "root_normals");
  for (std::uint32_t& count : plant.wood_vertex_counts) count = bytes.u32();
  for (std::uint32_t& count : plant.wood_triangle_counts) count = bytes.u32();
  plant.metric = bytes.u32();
  naive_must(plant.metric >= 1 && plant.metric <= 3, "metric");
  plant.leaf_mesh_count = bytes.u16();
  naive_must(plant.leaf_mesh_count <= 16, "leaf_mesh_count");
  const std::uint32_t fine = bytes.u16();
  naive_must(fine <= 1 && !(fine == 1 && plant.leaf_mesh_count > 0), "fine_positions");
  plant.largest = fine == 1 ? 32767 : 16383;
  for (const NaivePoint& corner : root.corners)
    for (const std::int64_t coordinate : corner) naive_must(coordinate <= plant.largest, "root_quad");
  plant.name = read_name(bytes);
  plant.nodes.push_back(root);
  return counts;
}

/// Sections 1 and 2: the order of the chunks, and where the first read ends.
void check_order(const NaivePlant& plant) {
  std::vector<std::array<std::uint32_t, 2>> order = {{kPlant, 0}, {kMaterials, 0}, {kCards, 0}, {kErrors, 0}, {kWind, 0}};
  if (plant.leaf_mesh_count > 0) order.push_back({kLeafMeshes, 0});
  if (plant.texture_count > 0) order.push_back({kTextures, 0});
  if (plant.wood_lod_count > 0) order.push_back({kWood, plant.wood_lod_count - 1});
  if (plant.page_count > 0) order.push_back({kPage, 0});
  const std::size_t first_read = order.size();
  for (std::uint32_t t = 0; t < plant.texture_count; ++t) order.push_back({kTexture, t});
  for (std::uint32_t i = plant.wood_lod_count; i-- > 0;)
    if (i + 1 < plant.wood_lod_count) order.push_back({kWood, i});
  for (std::uint32_t k = 1; k < plant.page_count; ++k) order.push_back({kPage, k});
  for (std::uint32_t i = 0; i < plant.leaf_mesh_count; ++i) order.push_back({kLeafMesh, i});
  naive_must(order.size() == plant.chunks.size(), "chunk_count");
  for (std::size_t i = 0; i < order.size(); ++i)
    naive_must(plant.chunks[i].kind == order[i][0] && plant.chunks[i].index == order[i][1], "a chunk's kind or index");
  const NaiveChunk& last = plant.chunks[first_read - 1];
  naive_must(last.offset + last.bytes == plant.first_read_bytes, "first_read_bytes");
}

void check_wood_counts(Bytes file, const NaivePlant& plant) {
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint64_t vertices = plant.wood_vertex_counts[i], triangles = plant.wood_triangle_counts[i];
    if (i >= plant.wood_lod_count) {
      naive_must(vertices == 0 && triangles == 0, "wood counts beyond the last LoD");
      continue;
    }
    naive_must(triangles >= 1 && triangles <= 1u << 24 && triangles <= 8 * chunk_of(file, plant, kWood, i).left(), "wood_triangle_counts");
    naive_must(i == 0 || triangles <= plant.wood_triangle_counts[i - 1], "wood_triangle_counts: more than the finer LoD's");
    naive_must(vertices >= 3 && vertices <= 3 * triangles, "wood_vertex_counts");
  }
}

bool is_share(float value) {
  return value >= 0.0f && value <= 1.0f;
}

void read_materials(NaiveBytes bytes, std::size_t count, NaivePlant& plant) {
  naive_must(bytes.left() == 32 * count, "MATERIALS' length");
  for (std::size_t i = 0; i < count; ++i) {
    NaiveMaterial material;
    read_floats(bytes, material.base_color);
    material.alpha_cutoff = bytes.f32();
    material.roughness = bytes.f32();
    material.texture = bytes.u16();
    material.normal_map = bytes.u16();
    material.flags = bytes.u32();
    naive_must(std::ranges::all_of(material.base_color, is_share), "base_color");
    naive_must(is_share(material.alpha_cutoff) && is_share(material.roughness), "alpha_cutoff, roughness");
    naive_must(material.texture < plant.texture_count || material.texture == 0xffff, "material texture");
    naive_must(material.normal_map <= plant.texture_count, "normal_map");
    naive_must((material.flags & ~7u) == 0, "flags");
    naive_must((material.flags & 2) == 0 || plant.leaf_mesh_count > 0, "flags: leaf meshes alone, of which there is none");
    plant.materials.push_back(material);
  }
}

void read_cards(NaiveBytes bytes, std::size_t count, NaivePlant& plant) {
  naive_must(bytes.left() == 48 * count, "CARDS' length");
  for (std::size_t i = 0; i < count; ++i) {
    NaiveCard card;
    card.material = bytes.u32();
    read_floats(bytes, card.uv);
    for (std::uint32_t& channel : card.albedo) channel = bytes.u8();
    naive_must(bytes.u8() == 0, "card reserved");
    for (std::uint32_t& word : card.mask) word = bytes.u32();
    naive_must(card.mask[0] != 0 || card.mask[1] != 0, "card mask");
    naive_must(card.material < plant.materials.size() && (plant.materials[card.material].flags & 2) == 0, "card material");
    naive_must(is_finite(card.uv), "card uv");
    plant.cards.push_back(card);
  }
}

/// Rows of errors; down a column they do not grow (falling) or do not fall.
void check_errors(const std::vector<float>& rows, std::size_t sizes, bool falling) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    naive_must(std::isfinite(rows[i]) && rows[i] >= 0, "an error is negative or not finite");
    if (i < sizes) continue;
    naive_must(falling ? rows[i] <= rows[i - sizes] : rows[i] >= rows[i - sizes], "the order of errors in a column");
  }
}

void read_errors(NaiveBytes bytes, const Counts& counts, NaivePlant& plant) {
  const std::size_t levels = counts.levels, sizes = counts.sizes, wood = plant.wood_lod_count;
  naive_must(bytes.left() == 4 * (levels + sizes + levels * sizes + wood * sizes), "ERRORS' length");
  for (std::size_t i = 0; i < levels; ++i) {
    plant.error_leaf_counts.push_back(bytes.u32());
    naive_must(i == 0 || plant.error_leaf_counts[i] > plant.error_leaf_counts[i - 1], "leaf_counts");
  }
  naive_must(plant.error_leaf_counts.front() == 1 && plant.error_leaf_counts.back() == plant.leaf_count, "leaf_counts");
  plant.error_sizes_px = floats(bytes, sizes);
  for (std::size_t i = 0; i < sizes; ++i) {
    const float size = plant.error_sizes_px[i];
    naive_must(std::isfinite(size) && size > (i == 0 ? 0.0f : plant.error_sizes_px[i - 1]), "sizes_px");
  }
  plant.error_px = floats(bytes, levels * sizes);
  check_errors(plant.error_px, sizes, true);
  plant.wood_error_px = floats(bytes, wood * sizes);
  check_errors(plant.wood_error_px, sizes, false);
}

/// Section 13, its formulas as they stand there.
double wind_growth(const NaiveWind& wind) {
  if (wind.side == 0) return 0.0;
  const std::size_t n = wind.side;
  const auto node = [&](std::size_t x, std::size_t y, std::size_t z) { return wind.nodes[x + n * y + n * n * z]; };
  double most = 0;
  for (std::size_t z = 0; z + 1 < n; ++z)
    for (std::size_t y = 0; y + 1 < n; ++y)
      for (std::size_t x = 0; x + 1 < n; ++x) {
        std::array<double, 3> lean{}, sway{};
        const auto edge = [&](std::size_t axis, const NaiveWindNode& from, const NaiveWindNode& to) {
          const double length = (double{wind.box_max[axis]} - wind.box_min[axis]) / static_cast<double>(n - 1);
          lean[axis] = std::max(lean[axis], std::abs(to.lean - from.lean) / length);
          sway[axis] = std::max(sway[axis], std::hypot(to.sway_cos - from.sway_cos, to.sway_sin - from.sway_sin) / length);
        };
        for (std::size_t i = 0; i < 2; ++i)
          for (std::size_t k = 0; k < 2; ++k) {
            edge(0, node(x, y + i, z + k), node(x + 1, y + i, z + k));
            edge(1, node(x + i, y, z + k), node(x + i, y + 1, z + k));
            edge(2, node(x + i, y + k, z), node(x + i, y + k, z + 1));
          }
        most = std::max(most, wind.lean_m * std::hypot(lean[0], lean[1], lean[2]) + wind.sway_m * std::hypot(sway[0], sway[1], sway[2]));
      }
  return most;
}

void read_wind_nodes(NaiveBytes& bytes, NaiveWind& wind) {
  naive_must(bytes.left() == std::size_t{4} * wind.side * wind.side * wind.side, "WIND's length");
  const auto i8 = [&] { return int{static_cast<std::int8_t>(bytes.u8())}; };
  while (bytes.left() > 0) {
    NaiveWindNode node;
    node.lean = bytes.u8() / 255.0;
    const int sway_cos = i8(), sway_sin = i8();
    naive_must(sway_cos >= -127 && sway_sin >= -127, "a node's sway");
    node.sway_cos = sway_cos / 127.0;
    node.sway_sin = sway_sin / 127.0;
    naive_must(bytes.u8() == 0, "a node's reserved");
    wind.nodes.push_back(node);
  }
}

void read_wind(NaiveBytes bytes, NaivePlant& plant) {
  naive_must(bytes.left() >= 56, "WIND's length");
  NaiveWind& wind = plant.wind_field;
  for (float* field :
       {&wind.base_y_m, &wind.height_m, &wind.bend_m, &wind.lean_m, &wind.sway_m, &wind.stem_period_s, &wind.branch_period_s}) {
    *field = bytes.f32();
    naive_must(std::isfinite(*field), "a field of WIND is not finite");
  }
  naive_must(wind.height_m >= 1e-30f && wind.bend_m >= 0 && wind.lean_m >= 0 && wind.sway_m >= 0, "wind height_m, bend_m, lean_m, sway_m");
  for (const float period : {wind.stem_period_s, wind.branch_period_s}) naive_must(period >= 0.1f && period <= 60.0f, "wind periods");
  read_floats(bytes, wind.box_min);
  read_floats(bytes, wind.box_max);
  naive_must(is_finite(wind.box_min) && is_finite(wind.box_max), "wind box");
  for (std::size_t a = 0; a < 3; ++a) {
    const float extent = wind.box_max[a] - wind.box_min[a];
    naive_must(std::isfinite(extent) && extent >= 1e-30f, "wind box");
  }
  wind.side = bytes.u32();
  naive_must(wind.side == 0 || wind.side == 2 || wind.side == 4 || wind.side == 8, "wind node_side");
  naive_must(wind.side > 0 || (wind.lean_m == 0 && wind.sway_m == 0), "wind lean_m, sway_m without a grid");
  read_wind_nodes(bytes, wind);
  double most = 0;
  for (const NaiveWindNode& node : wind.nodes)
    most = std::max(most, wind.lean_m * node.lean + wind.sway_m * std::hypot(node.sway_cos, node.sway_sin));
  naive_must(wind.bend_m <= 0.4 * wind.height_m, "wind bend");
  const double fall = 2.0 / 3.0 * wind.bend_m * wind.bend_m / wind.height_m;
  naive_must(wind.bend_m + fall + most <= 0.8 * plant.sphere_radius, "wind move");
  naive_must(wind_growth(wind) <= 0.08, "wind growth");
}

void read_leaf_mesh_counts(Bytes file, const Counts& counts, NaivePlant& plant) {
  if (plant.leaf_mesh_count == 0) return;
  NaiveBytes bytes = chunk_of(file, plant, kLeafMeshes, 0);
  naive_must(bytes.left() == std::size_t{8} * plant.leaf_mesh_count + std::size_t{4} * counts.sizes, "LEAF_MESHES' length");
  for (std::uint32_t i = 0; i < plant.leaf_mesh_count; ++i) {
    const std::uint64_t vertices = bytes.u32(), triangles = bytes.u32();
    naive_must(triangles >= 1 && triangles <= 65536 && triangles <= 8 * chunk_of(file, plant, kLeafMesh, i).left(),
               "leaf mesh triangle_count");
    naive_must(vertices >= 3 && vertices <= 3 * triangles, "leaf mesh vertex_count");
    plant.leaf_mesh_vertex_counts.push_back(static_cast<std::uint32_t>(vertices));
    plant.leaf_mesh_triangle_counts.push_back(static_cast<std::uint32_t>(triangles));
  }
  plant.leaf_mesh_error_px = floats(bytes, counts.sizes);
  check_errors(plant.leaf_mesh_error_px, 1, false);
}

/// Section 11: what a texture begins with.
NaiveTexture read_texture_header(NaiveBytes& bytes) {
  NaiveTexture texture;
  texture.width = bytes.u32();
  texture.height = bytes.u32();
  texture.mip_count = bytes.u32();
  texture.format = bytes.u32();
  naive_must(texture.width >= 1 && texture.width <= 4096 && texture.height >= 1 && texture.height <= 4096, "texture width, height");
  std::uint32_t most = 1;
  for (std::uint32_t side = std::max(texture.width, texture.height); side > 1; side /= 2) ++most;
  naive_must(texture.mip_count >= 1 && texture.mip_count <= most, "texture mip_count");
  naive_must(texture.format >= 1 && texture.format <= 3, "texture format");
  return texture;
}

std::size_t level_bytes(const NaiveTexture& texture) {
  std::size_t expected = 0, width = texture.width, height = texture.height;
  for (std::uint32_t level = 0; level < texture.mip_count; ++level) {
    const std::size_t blocks = (width + 3) / 4 * ((height + 3) / 4);
    expected += texture.format == 1 ? 4 * width * height : texture.format == 2 ? 16 * blocks : 8 * blocks;
    width = std::max<std::size_t>(width / 2, 1);
    height = std::max<std::size_t>(height / 2, 1);
  }
  return expected;
}

void read_levels(NaiveBytes& bytes, NaiveTexture& texture) {
  const Bytes levels = bytes.take(level_bytes(texture));
  texture.levels.assign(levels.begin(), levels.end());
}

void read_textures(Bytes file, NaivePlant& plant) {
  if (plant.texture_count == 0) return;
  NaiveBytes bytes = chunk_of(file, plant, kTextures, 0);
  for (std::uint32_t t = 0; t < plant.texture_count; ++t) {
    NaiveTexture& texture = plant.textures.emplace_back(read_texture_header(bytes));
    NaiveBytes chunk = chunk_of(file, plant, kTexture, t);
    const NaiveTexture own = read_texture_header(chunk);
    naive_must(
        own.width == texture.width && own.height == texture.height && own.mip_count == texture.mip_count && own.format == texture.format,
        "a TEXTURE that is not what TEXTURES says");
    read_levels(chunk, texture);
    naive_must(chunk.left() == 0, "texture length");
  }
  for (std::uint32_t t = 0; t < plant.texture_count; ++t) {
    NaiveTexture& small = plant.small_textures.emplace_back();
    if (std::ranges::none_of(plant.materials, [&](const NaiveMaterial& material) { return material.texture == t; })) continue;
    small = read_texture_header(bytes);
    naive_must(small.width <= 64 && small.height <= 64 && small.mip_count == 1, "small texture");
    read_levels(bytes, small);
  }
  naive_must(bytes.left() == 0, "TEXTURES' length");
}

/// Section 4: the sphere holds every vertex.
void check_sphere(const NaivePlant& plant) {
  double longest = 2.0 * plant.sphere_radius;
  for (std::size_t a = 0; a < 3; ++a) longest = std::max(longest, double{plant.leaf_box_max[a]} - plant.leaf_box_min[a]);
  const double most = plant.sphere_radius + 1e-4 * longest;
  const auto check = [&](const std::array<double, 3>& point) {
    double squared = 0;
    for (std::size_t a = 0; a < 3; ++a) squared += (point[a] - plant.sphere_center[a]) * (point[a] - plant.sphere_center[a]);
    naive_must(std::sqrt(squared) <= most, "sphere: a vertex is outside");
  };
  for (const NaiveNode& node : plant.nodes)
    for (const NaivePoint& corner : node.corners) {
      std::array<double, 3> point;
      for (std::size_t a = 0; a < 3; ++a)
        point[a] = plant.leaf_box_min[a] +
                   static_cast<double>(corner[a]) / plant.largest * (double{plant.leaf_box_max[a]} - plant.leaf_box_min[a]);
      check(point);
    }
  for (const auto* meshes : {&plant.wood, &plant.leaf_meshes})
    for (const NaiveMesh& mesh : *meshes)
      for (const NaiveVertex& vertex : mesh.corners) check({vertex.position[0], vertex.position[1], vertex.position[2]});
}

void read_meshes(Bytes file, NaivePlant& plant) {
  const std::size_t materials = plant.materials.size();
  for (std::uint32_t i = 0; i < plant.wood_lod_count; ++i) {
    const Bytes chunk = chunk_of(file, plant, kWood, i).rest();
    plant.wood.push_back(read_naive_mesh(chunk, plant.wood_vertex_counts[i], plant.wood_triangle_counts[i], false, materials));
    for (const NaiveVertex& vertex : plant.wood.back().corners)
      naive_must((plant.materials[vertex.material].flags & 2) == 0, "wood of a material that only leaf meshes show");
  }
  for (std::uint32_t i = 0; i < plant.leaf_mesh_count; ++i)
    plant.leaf_meshes.push_back(read_naive_mesh(chunk_of(file, plant, kLeafMesh, i).rest(), plant.leaf_mesh_vertex_counts[i],
                                                plant.leaf_mesh_triangle_counts[i], true, materials));
}

void read_file(Bytes file, NaivePlant& plant) {
  read_header_and_table(file, plant);
  const Counts counts = read_plant(chunk_of(file, plant, kPlant, 0), plant);
  check_order(plant);
  check_wood_counts(file, plant);
  read_materials(chunk_of(file, plant, kMaterials, 0), counts.materials, plant);
  read_cards(chunk_of(file, plant, kCards, 0), counts.cards, plant);
  read_errors(chunk_of(file, plant, kErrors, 0), counts, plant);
  read_wind(chunk_of(file, plant, kWind, 0), plant);
  read_leaf_mesh_counts(file, counts, plant);
  std::vector<std::uint32_t> parents(plant.leaf_count - 1, kNaiveNone);
  if (!parents.empty()) parents[0] = 0;
  for (std::uint32_t k = 0; k < plant.page_count; ++k) read_naive_page(chunk_of(file, plant, kPage, k).rest(), plant, parents);
  read_textures(file, plant);
  read_meshes(file, plant);
  check_sphere(plant);
}

}  // namespace

std::span<const std::uint8_t> NaiveBytes::take(std::size_t byte_count) {
  naive_must(byte_count <= left(), "it ends early");
  at_ += byte_count;
  return bytes_.subspan(at_ - byte_count, byte_count);
}

std::uint64_t NaiveBytes::number(std::size_t byte_count) {
  const auto bytes = take(byte_count);
  std::uint64_t value = 0;
  for (std::size_t i = byte_count; i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

std::int64_t NaiveBytes::i16() {
  return static_cast<std::int16_t>(u16());
}

float NaiveBytes::f32() {
  return std::bit_cast<float>(u32());
}

NaiveReading read_naively(std::span<const std::uint8_t> file) {
  NaiveReading reading;
  try {
    read_file(file, reading.plant);
  } catch (const NaiveRefusal& refusal) {
    reading.refusal = refusal.what();
  }
  return reading;
}

}  // namespace coppice::test
