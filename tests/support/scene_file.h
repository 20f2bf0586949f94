#pragma once

// .forest files for tests: random scenes, and damage whose checksums are right.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scene_write.h"

namespace coppice::test {

/// Two species of spheres of 1 m and 4 m.
std::vector<SceneSpecies> scene_species();

/// Plants on a square of this side round the origin, every fourth of them of the large species. Same seed, same plants.
std::vector<bake::ScenePlant> random_scene_plants(std::size_t count, float side_m, std::uint32_t seed);

/// The scene of random_scene_plants.
std::vector<std::uint8_t> random_scene(std::size_t count, float side_m, std::uint32_t seed);

/// Makes every checksum that can be located right again, so that damage reaches the code behind them. Any bytes may be passed.
void fix_scene_checksums(std::vector<std::uint8_t>& file);

}  // namespace coppice::test
