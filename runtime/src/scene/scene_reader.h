#pragma once

// Reads .forest files, which say where plants stand. See SCENE.md.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "coppice/scene_format.h"
#include "hooks.h"
#include "result.h"

namespace coppice {

/// A species, for the writer.
struct SceneSpecies {
  std::string path;  ///< relative to the scene's folder
  std::array<float, 3> sphere_center{};
  float sphere_radius_m = 1.0f;
};

/// A species, as read.
struct SceneFileSpecies {
  std::string_view path;  ///< points into SceneFile::paths
  std::array<float, 3> sphere_center{};
  float sphere_radius_m = 1.0f;
};

struct SceneTile {
  coppice_scene_tile entry{};
  std::array<float, 2> square_min_m{};  ///< x, z
  float square_side_m = 0.0f;
  std::uint64_t offset = 0;  ///< offset of its instances in the file
  std::uint32_t bytes = 0;   ///< length of its instances
  std::uint32_t level = 0;   ///< 0: the root
};

/// The front of a .forest file, parsed and checked: everything but the instances.
struct SceneFile {
  coppice_scene_header header{};
  HookArray<char> paths;  ///< all of them, one after the other
  HookArray<SceneFileSpecies> species;
  float height_min_m = 0.0f, height_max_m = 0.0f;  ///< heights of the plants' feet
  HookArray<SceneTile> tiles;  ///< breadth first: a tile's children are [first_child, first_child + popcount(child_mask))
};

struct SceneInstance {
  std::array<float, 3> position_m{};
  float scale = 1.0f;
  float yaw_rad = 0.0f;
  std::array<float, 3> tint{};
  std::uint32_t species = 0;
  bool mirrored = false;  ///< left and right are exchanged before it is turned
};

inline constexpr std::size_t kSceneHeaderBytes = sizeof(coppice_scene_header);

/// Reads and checks the header: magic, version, checksum, limits, sizes.
/// bytes       at least kSceneHeaderBytes long
/// file_bytes  size of the file on disk; must equal the header's
/// errors  bad_file, with the field and its byte offset
Result<coppice_scene_header> read_scene_header(std::span<const std::uint8_t> bytes, std::uint64_t file_bytes);

/// Length of the front.
std::uint64_t scene_front_bytes(const coppice_scene_header& header);

/// Parses the front. bytes: at least scene_front_bytes long. errors  bad_file, with the field and its byte offset; out_of_memory
Result<SceneFile> read_scene_front(std::span<const std::uint8_t> bytes, std::uint64_t file_bytes,
                                   const coppice_allocator& allocator = default_allocator());

/// Parses a tile's instances.
/// bytes  [tile.bytes] from the file at tile.offset. out: [tile.entry.instance_count]
/// errors  bad_file: wrong length or checksum, an unknown species, a plant larger than the tile's largest
/// thread  any
Result<void> read_scene_tile(const SceneFile& scene, const SceneTile& tile, std::span<const std::uint8_t> bytes,
                             std::span<SceneInstance> out);

}  // namespace coppice
