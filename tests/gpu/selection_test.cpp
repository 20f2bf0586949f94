// The shader's cut and the CPU's are the same text; here they meet on the same instances.

#include <cmath>
#include <random>

#include "demand.h"
#include "random_tree.h"
#include "renderer_scene.h"

namespace coppice::test::selection_test {

class SelectionTest : public VulkanTest {};

std::vector<coppice_placement> scattered(std::uint32_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](float low, float high) { return low + (high - low) * static_cast<float>(random()) / 4294967296.0f; };
  std::vector<coppice_placement> placements;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float yaw = uniform(0.0f, 6.28f);
    // Distances from inside the crown to a pixel or so.
    const float distance = std::exp(uniform(-2.0f, 6.0f));
    const float bearing = uniform(0.0f, 6.28f);
    const float height = uniform(-1.0f, 1.0f), scale = uniform(0.5f, 2.0f);
    placements.push_back(placement_at({distance * std::cos(bearing), height, distance * std::sin(bearing)}, scale));
    placements.back().rotation[1] = std::sin(0.5f * yaw);
    placements.back().rotation[3] = std::cos(0.5f * yaw);
  }
  return placements;
}

/// At some thresholds, in a view of any kind.
void expect_same_cuts(RendererScene& scene, const std::vector<DecodedPlant>& plants, Shot view) {
  std::uint32_t distinct = 0;
  for (const float error_px : {0.05f, 0.5f, 2.0f, 20.0f}) {
    view.error_px = error_px;
    view.lod = error_px == 0.5f ? COPPICE_LOD_DISCRETE : COPPICE_LOD_CUT;
    const std::vector<float> cuts = scene.select(view);
    const LodView lod = [&] {
      auto demand = demand_view(view);
      EXPECT_TRUE(demand);
      return *demand;
    }();
    for (std::uint32_t slot = 0; slot < cuts.size(); ++slot) {
      const InstanceSphere& sphere = scene.instances().spheres()[slot];
      const DecodedPlant& plant = plants[sphere.plant];
      const LodPlant lod_plant{.table = lod_table(plant.file, plant.lod_words),
                               .resident_leaf_count = plant.file.plant.leaf_count,
                               .leaf_meshes_resident = !plant.leaf_meshes.empty()};
      const float expected = select_lod(sphere, seed_of(scene.instances().slots()[slot]), lod_plant, lod).leaf_count;
      ASSERT_NEAR(cuts[slot], expected, 1e-3f * expected) << "slot " << slot << ", error_px " << error_px;
      distinct += expected > 1.5f && expected < static_cast<float>(plant.file.plant.leaf_count) - 0.5f;
    }
  }
  EXPECT_GT(distinct, 2000u) << "too few cuts lie between the ends for the test to mean anything";
}

TEST_F(SelectionTest, CutsEqualTheCpuReference) {
  const std::uint32_t leaf_counts[] = {1, 700, 5000};
  RendererScene scene(gpu(), 8192);
  std::vector<DecodedPlant> plants;
  for (std::uint32_t i = 0; i < 3; ++i) {
    plants.push_back(decoded_plant(random_plant({.leaf_count = leaf_counts[i], .seed = i + 1, .leaf_mesh_count = i})));
    scene.place(scene.add_plant(plants[i]), scattered(2000, i));
  }
  Shot view = make_view({.eye_m = {0.0f, 0.5f, 0.0f}, .target_m = {1.0f, 0.5f, 1.0f}, .width_px = 64});
  Shot parallel = view;  // 8 m high
  parallel.clip_from_view[0] = 0.25f;
  parallel.clip_from_view[5] = -0.25f;
  parallel.clip_from_view[10] = 1e-3f;
  parallel.clip_from_view[11] = 0.0f;
  parallel.clip_from_view[14] = parallel.clip_from_view[15] = 1.0f;
  expect_same_cuts(scene, plants, view);
  expect_same_cuts(scene, plants, parallel);
}

}  // namespace coppice::test::selection_test
