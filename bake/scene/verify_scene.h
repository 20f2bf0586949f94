#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "asset_path.h"
#include "result.h"

namespace coppice::bake {

/// What verify_scene() went through, and all that is wrong.
struct SceneVerifyReport {
  std::uint64_t bytes_checked = 0;
  std::uint64_t plants_checked = 0;  ///< instances
  std::uint32_t tiles_checked = 0;
  std::uint32_t species_checked = 0;
  std::vector<Error> errors;  ///< species first, then tiles, each in the file's order
};

/// Whether the bytes start as a .forest file does.
bool is_scene(std::span<const std::uint8_t> file);

/// Every checksum, every tile decoded, every invariant of SCENE.md; and each species: that it is there, that verify() passes it, that its
/// name is printable, and that its bounding sphere is, to a hundredth of its radius, the one by which the scene's tiles are chosen.
/// folder  the scene's, from which it names its species
/// A front that is wrong is the only error: nothing behind it can be found.
SceneVerifyReport verify_scene(std::span<const std::uint8_t> file, const std::filesystem::path& folder, OutsideFiles outside);

}  // namespace coppice::bake
