// Pictures of one plant through the C API, at three distances, with the cut that the error table asks for and with every leaf.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "generate_plant.h"
#include "gltf_write.h"
#include "golden.h"
#include "looks_case.h"
#include "process.h"

namespace coppice::test::plant_golden_test {

constexpr std::uint32_t kSidePx = 256;
constexpr VkClearColorValue kSky{{0.6f, 0.75f, 0.9f, 1.0f}};

/// Generates and bakes a plant; the file lies in `folder`.
std::filesystem::path bake_corylus(const TemporaryFolder& folder) {
  const auto plant = bake::generate_plant("corylus", 1);
  if (!plant) throw std::runtime_error(plant.error().message());
  const std::filesystem::path glb = folder / "plant.glb";
  const auto written = bake::write_glb(glb, {{"leaves", &plant->foliage}, {"wood", &plant->wood}}, plant->materials, plant->images);
  if (!written) throw std::runtime_error(written.error().message());
  return bake_file(glb, {});
}

/// distance  from the sphere's centre, in radii of the sphere
Shot make_view(const LooksSphere& sphere, float distance, coppice_lod_mode lod) {
  const glm::vec3 eye = sphere.center + glm::normalize(glm::vec3(0.6f, 0.25f, 1.0f)) * (distance * sphere.radius);
  const glm::mat4 view_from_world = glm::lookAt(eye, sphere.center, glm::vec3(0, 1, 0));
  // Depth is 1 near by and 0 far away, and Vulkan's y points down.
  glm::mat4 clip_from_view = glm::perspectiveRH_ZO(0.6f, 1.0f, 1000.0f * sphere.radius, 0.01f * sphere.radius);
  clip_from_view[1][1] *= -1.0f;
  Shot view;
  init_shot(&view);
  std::copy_n(&view_from_world[0][0], 16, view.view_from_world);
  std::copy_n(&clip_from_view[0][0], 16, view.clip_from_view);
  view.width_px = view.height_px = kSidePx;
  view.lod = lod;
  const glm::vec3 sun = glm::normalize(glm::vec3(0.5f, 0.8f, 0.4f));
  std::copy_n(&sun[0], 3, view.light.sun_direction);
  return view;
}

struct Case {
  const char* name;
  float distance;  ///< radii; 3.4 just holds the sphere
};
constexpr std::array<Case, 3> kCases{{{"near", 3.5f}, {"middle", 10.0f}, {"far", 40.0f}}};

class PlantGolden : public VulkanTest {
 protected:
  /// Draws the plant and compares with the golden picture of that name. Returns what was drawn.
  static coppice_view_stats expect_picture(LooksStage& stage, const std::string& name, const Case& c, coppice_lod_mode lod) {
    const Picture picture = stage.draw_still(make_view(stage.sphere(), c.distance, lod), kSky);
    expect_golden(name + c.name, picture, {}, gpu().driver_name);
    return stage.stats();
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = bake_corylus(folder_);
};

TEST_F(PlantGolden, Full) {
  LooksStage stage(gpu(), file_, LooksPath::hardware);
  for (const Case& c : kCases) EXPECT_EQ(expect_picture(stage, "corylus_full_", c, COPPICE_LOD_FULL).drawn_leaf_count, 386u) << c.name;
}

TEST_F(PlantGolden, Cut) {
  LooksStage stage(gpu(), file_, LooksPath::hardware);
  std::uint64_t leaves = 387;
  for (const Case& c : kCases) {
    const coppice_view_stats stats = expect_picture(stage, "corylus_cut_", c, COPPICE_LOD_CUT);
    const std::uint64_t drawn = stats.drawn_leaf_count;
    if (stats.leaf_mesh_instance_count > 0) {
      EXPECT_EQ(drawn, 386u) << c.name << ": leaf meshes are all leaves";
    } else {
      EXPECT_LT(drawn, leaves) << c.name << ": no fewer leaves than nearer by";
    }
    leaves = drawn;
    std::printf("%s: %u leaves\n", c.name, static_cast<unsigned>(drawn));
  }
  EXPECT_GE(leaves, 1u);
  EXPECT_LT(leaves, 386u) << "far away, not all of them";
}

TEST_F(PlantGolden, ComputeRaster) {
  LooksStage stage(gpu(), file_, LooksPath::compute);
  for (const Case& c : kCases) expect_picture(stage, "corylus_raster_", c, COPPICE_LOD_CUT);
}

}  // namespace coppice::test::plant_golden_test
