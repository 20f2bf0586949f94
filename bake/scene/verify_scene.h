#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "asset_path.h"
#include "result.h"

namespace coppice::bake {

/// How much verify_scene() checked, and all that is wrong.
struct SceneVerifyReport {
  std::uint64_t bytes_checked = 0;
  std::uint64_t plants_checked = 0;  ///< instances
  std::uint32_t tiles_checked = 0;
  std::uint32_t species_checked = 0;
  std::vector<Error> errors;  ///< species first, then tiles, each in the file's order
};

/// Whether the bytes start as a .forest file does.
bool is_scene(std::span<const std::uint8_t> file);

/// Checks every checksum, decodes every tile and checks every invariant of SCENE.md. Checks of each species that its file exists, verify()
/// accepts it, its name is printable, and its bounding sphere is, to a hundredth of its radius, the one by which the scene's tiles are
/// chosen. If the front is wrong that is the only error, since nothing behind it can be found.
/// folder  the scene's folder, to which the paths of species are relative
SceneVerifyReport verify_scene(std::span<const std::uint8_t> file, const std::filesystem::path& folder, OutsideFiles outside);

}  // namespace coppice::bake
