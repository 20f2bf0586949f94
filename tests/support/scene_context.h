#pragma once

// A scene of two plants in a temporary folder, and the runtime that streams it.

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "context_fixture.h"
#include "scene_write.h"

namespace coppice::test {

inline constexpr std::uint32_t kPlants = 9000;
inline constexpr float kSide_m = 900.0f;

class SceneContextTest : public ContextTest {
 protected:
  void SetUp() override {
    ContextTest::SetUp();
    folder_ = std::filesystem::temp_directory_path() / ("scene_context_test" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    for (const std::uint32_t seed : {1u, 2u})
      write_plant(folder_ / ("plant" + std::to_string(seed) + ".coppice"), {.leaf_count = 600, .seed = seed});
    // A regular grid, the second plant in every other place.
    std::vector<bake::ScenePlant> plants(kPlants);
    constexpr std::uint32_t kRow = 95;
    for (std::uint32_t i = 0; i < kPlants; ++i) {
      const auto place = [](std::uint32_t step) { return kSide_m * ((static_cast<float>(step) + 0.5f) / kRow - 0.5f); };
      plants[i].position_m = {place(i % kRow), 0.0f, place(i / kRow)};
      plants[i].species = static_cast<std::uint16_t>(i % 2);
    }
    write_file(scene_path(), *bake::encode_scene(species({"plant1.coppice", "plant2.coppice"}), plants));
    write_file(folder_ / "lost.forest", *bake::encode_scene(species({"plant1.coppice", "lost.coppice"}), plants));
  }

  void TearDown() override {
    std::filesystem::remove_all(folder_);
    ContextTest::TearDown();
  }

  static std::vector<SceneSpecies> species(const std::vector<std::string>& paths) {
    std::vector<SceneSpecies> all;
    for (const std::string& path : paths) all.push_back({path, {0, 0, 0}, 1.6f});
    return all;
  }
  [[nodiscard]] std::filesystem::path scene_path() const { return folder_ / "wood.forest"; }

  void create(std::uint32_t max_instances, bool compute_raster) {
    ContextDesc with = desc();
    with.max_instances = max_instances;
    with.compute_raster = compute_raster ? VK_TRUE : VK_FALSE;
    ContextTest::create(with);
  }

  void open_scene() { ASSERT_EQ(coppice_scene_open(context_, scene_path().c_str(), nullptr, &scene_), COPPICE_OK) << log_; }

  coppice_stats frame(const Shot& view) {
    ContextTest::frame(view);
    return stats();
  }

  /// Frames until every tile wanted is there, and one more whose figures are of it.
  coppice_stats settle(const Shot& view) {
    ContextTest::settle(view);
    frame(view);
    return frame(view);
  }

  static Shot view_from(float x, float height, float z) {
    return make_view({.eye_m = {x, height, z}, .target_m = {x, height, z - 10.0f}, .width_px = 128});
  }

  coppice_scene scene_ = 0;
  std::filesystem::path folder_;
};

}  // namespace coppice::test
