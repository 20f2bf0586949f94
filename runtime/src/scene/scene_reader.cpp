// Everything in the file is checked before it is used. The header is checked by its checksum and the file's real size, which its counts
// must add up to, so no allocation is larger than the file. The tree is checked by its order, which leaves no freedom: each tile but the
// root is the child of exactly one earlier tile. Tiles are checked by their checksums and the range of every field. A comparison of floats
// states what is allowed and is negated, so that NaN is refused. Ratios of values are checked as well. Structs are copied out, never cast.

#include "scene_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>

#include "file_fields.h"
#include "layout.h"
#include "utf8.h"

namespace coppice {

static_assert(std::endian::native == std::endian::little, "the file is copied into structs as it is");
static_assert(sizeof(coppice_scene_header) == 72 && sizeof(coppice_scene_species) == 24 && sizeof(coppice_scene_tile) == 56 &&
              sizeof(coppice_scene_instance) == 12);

namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr float kMaxCoordinate_m = 1e7f;  // beyond it a step of a float is a metre

bool in_range(float value, float minimum, float maximum) {
  return value >= minimum && value <= maximum;  // false for NaN
}

Result<void> check_counts(const coppice_scene_header& header) {
  const std::uint64_t species = header.species_count;
  const CountField fields[] = {
      {"species_count", species, 1, COPPICE_MAX_SCENE_SPECIES, offsetof(coppice_scene_header, species_count)},
      {"tile_count", header.tile_count, 1, COPPICE_MAX_SCENE_TILES, offsetof(coppice_scene_header, tile_count)},
      {"path_bytes", header.path_bytes, species, species * COPPICE_MAX_SCENE_PATH_BYTES, offsetof(coppice_scene_header, path_bytes)},
      {"instance_count", header.instance_count, header.tile_count, std::uint64_t{header.tile_count} * COPPICE_MAX_TILE_INSTANCES,
       offsetof(coppice_scene_header, instance_count)},
  };
  return check_count_fields(fields, 0);
}

Result<void> read_species(Bytes bytes, const coppice_allocator& allocator, SceneFile& scene) {
  COPPICE_CHECK(allocate_into(scene.species, allocator, scene.header.species_count));
  COPPICE_CHECK(allocate_into(scene.paths, allocator, scene.header.path_bytes));
  const std::uint64_t paths_at = kSceneHeaderBytes + std::uint64_t{scene.header.species_count} * sizeof(coppice_scene_species);
  std::uint32_t next_path = 0;
  for (std::uint32_t i = 0; i < scene.header.species_count; ++i) {
    const std::uint64_t at = kSceneHeaderBytes + i * sizeof(coppice_scene_species);
    const auto entry = copy_at<coppice_scene_species>(bytes, at);
    if (entry.path_offset != next_path) return bad_field("species path_offset", at, std::to_string(entry.path_offset));
    if (entry.path_bytes == 0 || entry.path_bytes > COPPICE_MAX_SCENE_PATH_BYTES || entry.path_bytes > scene.header.path_bytes - next_path)
      return bad_field("species path_bytes", at + offsetof(coppice_scene_species, path_bytes), std::to_string(entry.path_bytes));
    const Bytes path = bytes.subspan(static_cast<std::size_t>(paths_at + next_path), entry.path_bytes);
    for (std::size_t byte = 0; byte < path.size();) {
      const std::size_t length = path[byte] == 0 ? 0 : utf8_sequence_length(path.subspan(byte));
      if (length == 0) return bad_field("species path: not UTF-8", paths_at + next_path + byte);
      byte += length;
    }
    if (path[0] == '/') return bad_field("species path: not relative", paths_at + next_path);
    for (const float center : entry.sphere_center)
      if (!in_range(center, -kMaxCoordinate_m, kMaxCoordinate_m))
        return bad_field("species sphere_center", at + offsetof(coppice_scene_species, sphere_center));
    if (!(entry.sphere_radius > 0.0f && entry.sphere_radius <= kMaxCoordinate_m))
      return bad_field("species sphere_radius", at + offsetof(coppice_scene_species, sphere_radius));
    char* const text = scene.paths.data() + next_path;
    std::memcpy(text, path.data(), path.size());
    SceneFileSpecies& species = scene.species[i];
    species.path = {text, path.size()};
    std::ranges::copy(entry.sphere_center, species.sphere_center.begin());
    species.sphere_radius_m = entry.sphere_radius;
    next_path += entry.path_bytes;
  }
  if (next_path != scene.header.path_bytes)
    return bad_field("path_bytes", offsetof(coppice_scene_header, path_bytes), "more than the species'");
  return {};
}

/// Checks the values of one entry alone.
Result<void> check_tile(const SceneTile& tile, std::uint64_t at) {
  const coppice_scene_tile& entry = tile.entry;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!in_range(entry.box_min[axis], -kMaxCoordinate_m, kMaxCoordinate_m) ||
        !in_range(entry.box_max[axis], entry.box_min[axis], kMaxCoordinate_m))
      return bad_field("tile box", at, "not a finite box");
  // Squares are halved in floats, level after level.
  const float slack_m = 1e-4f * tile.square_side_m + 1e-6f * (std::abs(tile.square_min_m[0]) + std::abs(tile.square_min_m[1]));
  for (std::size_t i = 0; i < 2; ++i)
    if (!(entry.box_min[2 * i] >= tile.square_min_m[i] - slack_m &&
          entry.box_max[2 * i] <= tile.square_min_m[i] + tile.square_side_m + slack_m))
      return bad_field("tile box", at, "outside the tile's square");
  if (!(entry.scale_min > 0.0f) || !in_range(entry.scale_max, entry.scale_min, COPPICE_MAX_SCENE_SCALE))
    return bad_field("tile scale_min, scale_max", at + offsetof(coppice_scene_tile, scale_min));
  if (!(entry.scale_max / entry.scale_min <= COPPICE_MAX_SCENE_SCALE_RATIO))
    return bad_field("tile scale_min, scale_max: too far apart", at + offsetof(coppice_scene_tile, scale_min));
  if (!(entry.max_radius > 0.0f) || !std::isfinite(entry.max_radius))
    return bad_field("tile max_radius", at + offsetof(coppice_scene_tile, max_radius));
  if (entry.instance_count == 0 || entry.instance_count > COPPICE_MAX_TILE_INSTANCES)
    return bad_field("tile instance_count", at + offsetof(coppice_scene_tile, instance_count), std::to_string(entry.instance_count));
  return {};
}

/// Gives a tile's children their squares and levels, and the parent's max_radius until they are read themselves.
Result<void> place_children(SceneFile& scene, std::uint32_t parent_index, std::uint32_t& next_child, std::uint64_t at) {
  const SceneTile& parent = scene.tiles[parent_index];
  const coppice_scene_tile& entry = parent.entry;
  const auto child_count = static_cast<std::uint32_t>(std::popcount(entry.child_mask));
  if (entry.child_mask > 0xf) return bad_field("tile child_mask", at + offsetof(coppice_scene_tile, child_mask));
  if (entry.first_child != (child_count == 0 ? 0 : next_child) || child_count > scene.header.tile_count - next_child)
    return bad_field("tile first_child", at + offsetof(coppice_scene_tile, first_child), std::to_string(entry.first_child));
  if (child_count > 0 && parent.level + 1 >= COPPICE_MAX_SCENE_LEVELS)
    return bad_field("tile child_mask: too many levels", at + offsetof(coppice_scene_tile, child_mask));
  const float side_m = 0.5f * parent.square_side_m;
  for (std::uint32_t quadrant = 0; quadrant < 4; ++quadrant) {
    if ((entry.child_mask >> quadrant & 1u) == 0) continue;
    SceneTile& child = scene.tiles[next_child++];
    child.level = parent.level + 1;
    child.entry.max_radius = entry.max_radius;
    child.square_side_m = side_m;
    child.square_min_m = {parent.square_min_m[0] + ((quadrant & 1u) != 0 ? side_m : 0.0f),
                          parent.square_min_m[1] + ((quadrant & 2u) != 0 ? side_m : 0.0f)};
  }
  return {};
}

Result<void> read_tiles(Bytes bytes, const coppice_allocator& allocator, SceneFile& scene) {
  const std::uint32_t tile_count = scene.header.tile_count;
  const std::uint64_t front_bytes = scene_front_bytes(scene.header);
  const std::uint64_t tiles_at = front_bytes - tile_count * sizeof(coppice_scene_tile);
  COPPICE_CHECK(allocate_into(scene.tiles, allocator, tile_count));
  scene.tiles[0].square_min_m = {scene.header.square_min[0], scene.header.square_min[1]};
  scene.tiles[0].square_side_m = scene.header.square_side;
  scene.tiles[0].entry.max_radius = INFINITY;
  std::uint32_t next_child = 1;
  std::uint64_t offset = front_bytes;
  for (std::uint32_t i = 0; i < tile_count; ++i) {
    if (i >= next_child) return bad_field("tile_count: more tiles than the tree has", offsetof(coppice_scene_header, tile_count));
    const std::uint64_t at = tiles_at + i * sizeof(coppice_scene_tile);
    SceneTile& tile = scene.tiles[i];
    const float parent_radius_m = tile.entry.max_radius;
    tile.entry = copy_at<coppice_scene_tile>(bytes, at);
    COPPICE_CHECK(check_tile(tile, at));
    if (!(tile.entry.max_radius <= parent_radius_m))
      return bad_field("tile max_radius: larger than its parent's", at + offsetof(coppice_scene_tile, max_radius));
    tile.offset = offset;
    tile.bytes = tile.entry.instance_count * static_cast<std::uint32_t>(sizeof(coppice_scene_instance));
    offset += tile.bytes;
    COPPICE_CHECK(place_children(scene, i, next_child, at));
  }
  if (offset != scene.header.file_bytes)
    return bad_field("instance_count: not the sum of the tiles'", offsetof(coppice_scene_header, instance_count));
  return {};
}

}  // namespace

Result<coppice_scene_header> read_scene_header(Bytes bytes, std::uint64_t file_bytes) {
  if (bytes.size() < kSceneHeaderBytes || file_bytes < kSceneHeaderBytes)
    return bad_field("header: the file is shorter than one", 0,
                     std::to_string(std::min<std::uint64_t>(bytes.size(), file_bytes)) + " bytes");
  const auto header = copy_at<coppice_scene_header>(bytes, 0);
  if (std::memcmp(header.magic, COPPICE_SCENE_MAGIC, sizeof header.magic) != 0) return bad_field("magic: not a .forest file", 0);
  if (header.version != COPPICE_SCENE_VERSION)
    return bad_field("version", offsetof(coppice_scene_header, version),
                     std::to_string(header.version) + ", this build reads " + std::to_string(COPPICE_SCENE_VERSION));
  if (header.header_checksum != checksum(bytes.first(offsetof(coppice_scene_header, header_checksum))))
    return bad_field("header_checksum", offsetof(coppice_scene_header, header_checksum));
  COPPICE_CHECK(check_counts(header));
  if (header.file_bytes != file_bytes)
    return bad_field("file_bytes", offsetof(coppice_scene_header, file_bytes),
                     std::to_string(header.file_bytes) + ", but the file has " + std::to_string(file_bytes));
  if (scene_front_bytes(header) + header.instance_count * sizeof(coppice_scene_instance) != file_bytes)
    return bad_field("file_bytes: the counts do not add up to it", offsetof(coppice_scene_header, file_bytes));
  for (const float min : header.square_min)
    if (!in_range(min, -kMaxCoordinate_m, kMaxCoordinate_m)) return bad_field("square_min", offsetof(coppice_scene_header, square_min));
  if (!(header.square_side > 0.0f && header.square_side <= 2 * kMaxCoordinate_m))
    return bad_field("square_side", offsetof(coppice_scene_header, square_side));
  if (header.reserved != 0) return bad_field("reserved", offsetof(coppice_scene_header, reserved));
  return header;
}

std::uint64_t scene_front_bytes(const coppice_scene_header& header) {
  return kSceneHeaderBytes + std::uint64_t{header.species_count} * sizeof(coppice_scene_species) + header.path_bytes +
         std::uint64_t{header.tile_count} * sizeof(coppice_scene_tile);
}

Result<SceneFile> read_scene_front(Bytes bytes, std::uint64_t file_bytes, const coppice_allocator& allocator) {
  SceneFile scene;
  COPPICE_TRY(header, read_scene_header(bytes, file_bytes));
  scene.header = header;
  const std::uint64_t front_bytes = scene_front_bytes(header);
  if (bytes.size() < front_bytes) return bad_field("front: truncated", bytes.size());
  const Bytes front = bytes.first(static_cast<std::size_t>(front_bytes));
  if (header.front_checksum != checksum(front.subspan(kSceneHeaderBytes)))
    return bad_field("front_checksum", offsetof(coppice_scene_header, front_checksum));
  COPPICE_CHECK(read_species(front, allocator, scene));
  COPPICE_CHECK(read_tiles(front, allocator, scene));
  scene.height_min_m = scene.tiles[0].entry.box_min[1];
  scene.height_max_m = scene.tiles[0].entry.box_max[1];
  for (const SceneTile& tile : scene.tiles) {
    scene.height_min_m = std::min(scene.height_min_m, tile.entry.box_min[1]);
    scene.height_max_m = std::max(scene.height_max_m, tile.entry.box_max[1]);
  }
  return scene;
}

Result<void> read_scene_tile(const SceneFile& scene, const SceneTile& tile, Bytes bytes, std::span<SceneInstance> out) {
  if (bytes.size() != tile.bytes) return bad_field("tile: truncated", tile.offset + bytes.size());
  if (tile.entry.checksum != checksum(bytes)) return bad_field("tile checksum", tile.offset);
  const coppice_scene_tile& entry = tile.entry;
  const float log_scales = std::log(entry.scale_max / entry.scale_min);
  for (std::uint32_t i = 0; i < entry.instance_count; ++i) {
    const auto stored = copy_at<coppice_scene_instance>(bytes, i * sizeof(coppice_scene_instance));
    const std::uint64_t at = tile.offset + i * sizeof(coppice_scene_instance);
    SceneInstance& instance = out[i];
    instance.species = stored.species & ~COPPICE_SCENE_MIRRORED;
    instance.mirrored = (stored.species & COPPICE_SCENE_MIRRORED) != 0;
    if (instance.species >= scene.species.size())
      return bad_field("instance species", at + offsetof(coppice_scene_instance, species), std::to_string(instance.species));
    for (std::size_t axis = 0; axis < 3; ++axis)
      instance.position_m[axis] =
          entry.box_min[axis] + static_cast<float>(stored.position[axis]) / 65535.0f * (entry.box_max[axis] - entry.box_min[axis]);
    instance.scale =
        stored.scale == 255 ? entry.scale_max : entry.scale_min * std::exp(log_scales * static_cast<float>(stored.scale) / 255.0f);
    instance.yaw_rad = static_cast<float>(stored.yaw) * (2.0f * std::numbers::pi_v<float> / 256.0f);
    instance.tint = {static_cast<float>(stored.tint & 31) / 16.0f, static_cast<float>(stored.tint >> 5 & 63) / 32.0f,
                     static_cast<float>(stored.tint >> 11) / 16.0f};
    if (!(instance.scale * scene.species[instance.species].sphere_radius_m <= 1.001f * entry.max_radius))
      return bad_field("instance scale: larger than the tile's max_radius", at + offsetof(coppice_scene_instance, scale));
  }
  return {};
}

}  // namespace coppice
