// The compute rasteriser against the hardware's picture of the same scene.

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>

#include "convert.h"
#include "golden.h"
#include "leaf_entry.h"
#include "random_tree.h"
#include "renderer_scene.h"

namespace coppice::test::leaf_raster_test {

constexpr std::uint32_t kSidePx = 256;

coppice_placement at(float x, float z, float scale = 1.0f) {
  coppice_placement placement = placement_at({x, 0.0f, z}, scale);
  std::ranges::copy(std::array{0.0f, 0.3894f, 0.0f, 0.9211f}, placement.rotation);
  return placement;
}

/// Every leaf, but as a cut: the rasteriser leaves COPPICE_LOD_FULL to the hardware.
Shot front_view(float distance_m, std::uint32_t width_px = kSidePx) {
  return make_view({.eye_m = {0.0f, 0.3f, distance_m}, .width_px = width_px, .height_px = kSidePx, .error_px = 1e-4f});
}

/// How far away the mean leaf is this wide.
float distance_for(const DecodedPlant& plant, float leaf_px) {
  const gpu::LeafBox box = gpu::leaf_box(gpu::gpu_plant(plant.file.plant));
  float area_m2 = 0;
  for (const PageNode& node : plant.nodes) {
    if (node.split != kNeverReplaced) continue;
    std::array<vec3, 4> c{};
    for (std::size_t i = 0; i < 4; ++i) c[i] = box.at({node.corners[i][0], node.corners[i][1], node.corners[i][2]});
    area_m2 += gpu::quad_area(c);
  }
  const float leaf_m = std::sqrt(area_m2 / static_cast<float>(plant.file.plant.leaf_count));
  const Shot view = front_view(1.0f);
  return leaf_m * 0.5f * static_cast<float>(kSidePx) * std::abs(view.clip_from_view[5]) / leaf_px;
}

coppice_placement tinted(coppice_placement placement, float r, float g, float b) {
  std::ranges::copy(std::array{r, g, b}, placement.tint);
  return placement;
}

DecodedPlant plain_plant(std::uint32_t leaf_count, std::uint32_t seed) {
  return decoded_plant(random_plant({.leaf_count = leaf_count, .seed = seed, .texture_side = 0}));
}

struct Placed {
  DecodedPlant plant;
  std::vector<coppice_placement> placements;
};

RendererScene::Frame draw_scene(const VulkanDevice& gpu, const std::vector<Placed>& plants, const Shot& view, const SceneOptions& options) {
  RendererScene scene(gpu, 4096, options);
  for (const Placed& placed : plants) scene.place(scene.add_plant(placed.plant), placed.placements);
  scene.draw(view);  // lists are built over some frames
  return scene.draw(view);
}

std::vector<coppice_placement> slanting_row() {
  std::vector<coppice_placement> row;
  for (int i = -6; i <= 6; ++i) row.push_back(at(2.2f * static_cast<float>(i), -0.5f * static_cast<float>(i)));
  return row;
}

/// Eight in a row before the eye, some rows deep; step_m: from row to row
std::vector<coppice_placement> thicket(int count, float step_m) {
  std::vector<coppice_placement> all;
  for (int i = 0; i < count; ++i) all.push_back(at(0.15f * static_cast<float>(i % 8) - 0.5f, step_m * static_cast<float>(i / 8)));
  return all;
}

/// A row of plants far behind that.
std::vector<coppice_placement> row_behind() {
  std::vector<coppice_placement> all;
  for (int i = 0; i < 32; ++i) all.push_back(at(0.05f * static_cast<float>(i) - 0.8f, -60.0f));
  return all;
}

struct Likeness {
  double differing_share = 0;  ///< pixels of which a channel is off by more than 40
  double coverage = 0;         ///< pixels drawn on, over the hardware's
  double brightness = 0;       ///< mean over the drawn pixels, over the hardware's
};

/// Not by a step or two below white: that is how leaves in the sun look.
bool drawn(const Picture& picture, std::size_t i) {
  return picture.rgba[i] < 250 || picture.rgba[i + 1] < 250 || picture.rgba[i + 2] < 250;
}

Likeness compare(const Picture& actual, const Picture& expected) {
  std::array<double, 2> pixels{}, sums{};
  for (std::size_t i = 0; i < actual.rgba.size(); i += 4)
    for (const auto& [picture, side] : {std::pair{&actual, 0u}, std::pair{&expected, 1u}})
      if (drawn(*picture, i)) {
        ++pixels[side];
        sums[side] += picture->rgba[i] + picture->rgba[i + 1] + picture->rgba[i + 2];
      }
  return {.differing_share = compare_pictures(expected, actual, 40).differing_share,
          .coverage = pixels[0] / pixels[1],
          .brightness = sums[0] / pixels[0] / (sums[1] / pixels[1])};
}

class LeafRasterTest : public VulkanTest {
 protected:
  static RendererScene::Frame with_raster(const std::vector<Placed>& plants, const Shot& view) {
    return draw_scene(gpu(), plants, view, {.compute_raster = true});
  }
  static RendererScene::Frame without(const std::vector<Placed>& plants, const Shot& view) { return draw_scene(gpu(), plants, view, {}); }
};

TEST_F(LeafRasterTest, LeavesOfEightPixelsAreTheHardwares) {
  const std::vector<Placed> plants{{plain_plant(400, 3), {at(0.0f, 0.0f)}}};
  const Shot view = front_view(distance_for(plants[0].plant, 8.0f));
  const RendererScene::Frame raster = with_raster(plants, view), hardware = without(plants, view);
  EXPECT_LE(raster.counts.leaves, 400u) << "clusters outside the view are dropped";
  // One light for a leaf instead of four corners', and a root's rounding in the packed colour.
  EXPECT_FALSE(raster.picture.rgba == hardware.picture.rgba) << "the rasteriser has not drawn it";
  const Likeness likeness = compare(raster.picture, hardware.picture);
  EXPECT_LT(likeness.differing_share, 0.005);
  EXPECT_NEAR(likeness.coverage, 1.0, 0.005);
  EXPECT_NEAR(likeness.brightness, 1.0, 0.02);
}

TEST_F(LeafRasterTest, OutlinesOfCardsAreKept) {
  const std::vector<Placed> plants{{decoded_plant(random_plant({.leaf_count = 400, .seed = 5})), {at(0.0f, 0.0f)}}};
  const Shot view = front_view(distance_for(plants[0].plant, 10.0f));
  const Likeness likeness = compare(with_raster(plants, view).picture, without(plants, view).picture);
  EXPECT_NEAR(likeness.coverage, 1.0, 0.03);
  EXPECT_NEAR(likeness.brightness, 1.0, 0.03);
}

TEST_F(LeafRasterTest, SplatsOfDistantLeavesCoverAndShineAlike) {
  const std::vector<Placed> plants{{plain_plant(3000, 3), slanting_row()}};
  const Shot view = front_view(30.0f);
  const Likeness likeness = compare(with_raster(plants, view).picture, without(plants, view).picture);
  EXPECT_NEAR(likeness.coverage, 1.0, 0.03);
  EXPECT_NEAR(likeness.brightness, 1.0, 0.05);
}

// The last leaf of a plant has one face, which the crown it stands for has not: it is lit by where the eye is.
TEST_F(LeafRasterTest, ALeafForAWholeCrownIsBrightFromTheSunsSide) {
  DecodedPlant plant = plain_plant(3000, 3);
  constexpr std::array<std::array<std::uint16_t, 2>, 4> kRing{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  const auto largest = static_cast<std::uint16_t>(quantised_max(plant.file.plant));
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const std::array<std::uint16_t, 3> place{static_cast<std::uint16_t>(kRing[corner][0] * largest),
                                             static_cast<std::uint16_t>(kRing[corner][1] * largest),
                                             static_cast<std::uint16_t>(largest / 2)};
    std::ranges::copy(place, plant.file.plant.root_quad[corner]);
  }
  const std::vector<Placed> plants{{plant, {tinted(at(0.0f, 0.0f), 0.25f, 0.25f, 0.25f)}}};  // the scene's light is near white
  const auto from = [&](float angle) {
    return make_view({.eye_m = {12.0f * std::sin(angle), 2.0f, 12.0f * std::cos(angle)}, .width_px = kSidePx, .error_px = 1000.0f});
  };
  const float sun = std::atan2(0.5f, 0.6f);  // make_view's
  const Shot lit = from(sun), dark = from(sun + 3.1416f);
  const RendererScene::Frame raster = with_raster(plants, lit), hardware = without(plants, lit);
  EXPECT_EQ(raster.counts.leaves, 1u);
  EXPECT_NEAR(compare(raster.picture, hardware.picture).brightness, 1.0, 0.08);
  // Both sides of a crown word of 8 bits, in the dark: a step is 5 % of the light.
  EXPECT_NEAR(compare(with_raster(plants, dark).picture, without(plants, dark).picture).brightness, 1.0, 0.12);
  const double contrast = compare(hardware.picture, without(plants, dark).picture).brightness;
  EXPECT_GT(contrast, 1.3);
  EXPECT_LT(contrast, 4.0);
}

TEST_F(LeafRasterTest, LeafMeshesOfFewPixelsAreRasterised) {
  // In chunks, in another colour than the quads, so that the picture tells which was drawn.
  bake::BakedPlant baked = random_plant({.leaf_count = 300, .seed = 4, .wood_lod_count = 0, .texture_side = 0, .leaf_mesh_count = 3});
  baked.materials[0].base_color = {0.0f, 0.5f, 0.0f, 1.0f};
  baked.materials.back().base_color = {0.5f, 0.0f, 0.0f, 1.0f};
  const DecodedPlant plant = decoded_plant(baked);
  const std::vector<Placed> plants{{plant, {at(0.0f, 0.0f)}}};
  for (const float leaf_px : {3.0f, 7.0f}) {
    const Shot view = front_view(distance_for(plant, leaf_px));
    const RendererScene::Frame raster = with_raster(plants, view), hardware = without(plants, view);
    EXPECT_EQ(raster.counts.leaf_mesh_instances, 1u);
    EXPECT_EQ(raster.counts.leaves, 300u);
    EXPECT_EQ(raster.counts.leaf_mesh_triangles, hardware.counts.leaf_mesh_triangles);
    EXPECT_EQ(raster.counts.hardware_triangles, 0u) << "all of it by compute shaders";
    const Likeness likeness = compare(raster.picture, hardware.picture);
    EXPECT_NEAR(likeness.coverage, 1.0, 0.05) << leaf_px;
    EXPECT_NEAR(likeness.brightness, 1.0, 0.1) << leaf_px;
    EXPECT_LT(likeness.differing_share, 0.1) << leaf_px;
  }
}

TEST_F(LeafRasterTest, WhatFindsNoDrawCommandIsRasterised) {
  // All at one place, so that the picture is one plant's: more clusters of large leaves than a plant has commands.
  const DecodedPlant plant = decoded_plant(random_plant({.leaf_count = 2000, .seed = 6, .wood_lod_count = 0, .texture_side = 0}));
  const coppice_placement dark = tinted(at(0.0f, 0.0f), 0.25f, 0.25f, 0.25f);  // the scene's light is near white
  const std::vector<Placed> one{{plant, {dark}}}, many{{plant, std::vector<coppice_placement>(120, dark)}};
  const Shot view = front_view(distance_for(plant, 16.0f));
  const SceneOptions few_commands{.memory_budget_bytes = 2ull << 20, .compute_raster = true};
  const RendererScene::Frame alone = with_raster(one, view), crowd = draw_scene(gpu(), many, view, few_commands),
                             hardware = without(one, view);
  EXPECT_GT(alone.counts.hardware_triangles, alone.counts.leaves) << "most of it large";
  EXPECT_EQ(crowd.counts.leaves, 120 * alone.counts.leaves);
  EXPECT_LT(crowd.counts.hardware_triangles, 60 * alone.counts.hardware_triangles) << "commands run out";
  EXPECT_NEAR(compare(alone.picture, hardware.picture).coverage, 1.0, 0.02);
  EXPECT_NEAR(compare(crowd.picture, hardware.picture).coverage, 1.0, 0.02);
}

TEST_F(LeafRasterTest, WithoutWideAtomicsThePictureIsTheSame) {
  const std::vector<Placed> plants{{decoded_plant(random_plant({.leaf_count = 3000, .seed = 3})), {at(0.0f, 0.0f), at(1.0f, -8.0f)}}};
  for (const float distance_m : {4.0f, 30.0f}) {
    const Shot view = front_view(distance_m);
    const RendererScene::Frame wide = with_raster(plants, view);
    const RendererScene::Frame narrow = draw_scene(gpu(), plants, view, {.compute_raster = true, .int64_atomics = false});
    EXPECT_EQ(wide.counts.leaves, narrow.counts.leaves);
    // Leaves at one depth to the last bit may come out in another order.
    EXPECT_LT(compare_pictures(wide.picture, narrow.picture, 4).differing_share, 0.001) << distance_m;
  }
}

/// However many lanes the device has, both ways to spread the work are seen. Nearest: leaves of 11 px, some of more pixels than an
/// invocation takes; farthest: splats.
TEST_F(LeafRasterTest, FewLanesAndManyDrawTheSame) {
  const DecodedPlant plant = decoded_plant(random_plant({.leaf_count = 3000, .seed = 3}));
  const std::vector<Placed> plants{{plant, {at(0.0f, 0.0f), at(1.0f, -8.0f)}}};
  for (const bool int64_atomics : {true, false})
    for (const float distance_m : {distance_for(plant, 11.0f), 30.0f}) {
      const Shot view = front_view(distance_m);
      SceneOptions options{.compute_raster = true, .int64_atomics = int64_atomics, .many_lanes = false};
      const RendererScene::Frame few = draw_scene(gpu(), plants, view, options);
      options.many_lanes = true;
      const RendererScene::Frame many = draw_scene(gpu(), plants, view, options);
      EXPECT_GT(few.counts.leaves, 0u);
      EXPECT_LT(few.counts.hardware_triangles, few.counts.leaves) << "mostly rasterised";
      EXPECT_EQ(few.counts.leaves, many.counts.leaves);
      EXPECT_EQ(few.counts.hardware_triangles, many.counts.hardware_triangles);
      EXPECT_LT(compare_pictures(few.picture, many.picture, 4).differing_share, 0.001) << distance_m;
    }
}

TEST_F(LeafRasterTest, WhatIsHiddenIsNotRasterised) {
  const DecodedPlant plant = plain_plant(2000, 3);
  const std::vector<Placed> behind{{plant, row_behind()}}, both{{plant, thicket(32, 0.15f)}, {plant, row_behind()}};
  const Shot view = front_view(4.0f);
  const RendererScene::Frame together = with_raster(both, view), alone = with_raster(behind, view);
  EXPECT_EQ(alone.counts.visible_instances, 32u);
  EXPECT_EQ(together.counts.visible_instances, 32u) << "only the thicket";
  EXPECT_EQ(alone.counts.occluded_instances, 0u);
  EXPECT_EQ(together.counts.occluded_instances, 32u);
  EXPECT_NEAR(compare(together.picture, without(both, view).picture).coverage, 1.0, 0.04);
}

TEST_F(LeafRasterTest, OnlyWhatIsHiddenFromBothEyesIsNotRasterised) {
  const DecodedPlant plant = plain_plant(2000, 3);
  const std::vector<Placed> both{{plant, thicket(32, 0.15f)}, {plant, row_behind()}};
  struct Other {
    double right_m, turn_rad;
    std::uint32_t occluded;
  };
  constexpr double kHalfTurn = 3.14159265358979;
  // Beside the first eye; past the thicket; turned away from all of it.
  for (const Other& other : {Other{0.06, 0.0, 32}, Other{3.0, 0.0, 0}, Other{3.0, kHalfTurn, 32}}) {
    Shot view = front_view(4.0f);
    const coppice_eye second = eye_beside(view, other.right_m, other.turn_rad);
    view.second_eye = &second;
    const RendererScene::Frame drawn = with_raster(both, view);
    EXPECT_EQ(drawn.counts.occluded_instances, other.occluded) << other.right_m << " m to the right, turned by " << other.turn_rad;
    EXPECT_EQ(drawn.counts.visible_instances, 64 - other.occluded);
  }
}

/// Leaves that are drawn of a plant whose clusters are all in view: the number asked for, at every number.
TEST_F(LeafRasterTest, WhatIsDrawnComesAndGoesWithPages) {
  const DecodedPlant plant = plain_plant(3000, 3);
  RendererScene scene(gpu(), 64, {.compute_raster = true});
  const std::uint32_t index = scene.add_plant(plant, 2);  // it has six pages
  scene.place(index, {at(0.0f, 0.0f)});
  const Shot view = front_view(20.0f);
  EXPECT_EQ(scene.draw(view).counts.leaves, 1025u);
  scene.renderer().plants().drop_page(index, 1);
  for (const std::uint32_t leaves : {513u, 64u, 32u, 1u}) {
    scene.set_resident_leaves(index, leaves);
    EXPECT_EQ(scene.draw(view).counts.leaves, leaves);
  }
}

/// Leaves of a page that a cut has not borne yet are nowhere, whoever draws.
TEST_F(LeafRasterTest, CutsInTheMiddleOfAPageAreDrawn) {
  const DecodedPlant plant = plain_plant(3000, 3);
  const auto draw = [&](bool compute_raster, std::uint32_t leaves, float distance_m) {
    RendererScene scene(gpu(), 64, {.compute_raster = compute_raster});
    const std::uint32_t index = scene.add_plant(plant);
    scene.place(index, {at(0.0f, 0.0f)});
    scene.draw(front_view(distance_m));
    scene.set_resident_leaves(index, leaves);
    return scene.draw(front_view(distance_m));
  };
  for (const std::uint32_t leaves : {130u, 300u, 700u, 1100u}) {
    const RendererScene::Frame raster = draw(true, leaves, 5.0f), hardware = draw(false, leaves, 5.0f);
    EXPECT_EQ(hardware.counts.leaves, leaves);
    EXPECT_NEAR(static_cast<double>(raster.counts.leaves), leaves, 0.1 * leaves);
    const Likeness likeness = compare(raster.picture, hardware.picture);
    EXPECT_NEAR(likeness.coverage, 1.0, 0.03) << leaves;
    EXPECT_NEAR(likeness.brightness, 1.0, 0.08) << leaves;
  }
  // As splats: two leaves more of a cut that was ready, and of a page that was whole.
  for (const std::uint32_t leaves : {64u, 513u, 1025u})
    EXPECT_NEAR(compare(draw(true, leaves + 2, 12.0f).picture, draw(true, leaves, 12.0f).picture).coverage, 1.0, 0.02) << leaves;
}

TEST_F(LeafRasterTest, AViewMayGrow) {
  RendererScene scene(gpu(), 64, {.compute_raster = true});
  const DecodedPlant plant = plain_plant(500, 3);
  scene.place(scene.add_plant(plant), {at(0.0f, 0.0f)});
  scene.draw(front_view(6.0f, 200));
  const Picture small = scene.draw(front_view(6.0f, 200)).picture;
  scene.draw(front_view(6.0f, 300));
  EXPECT_TRUE(scene.draw(front_view(6.0f, 200)).picture.rgba == small.rgba);
}

// ---- projections

/// Projections of front_view, and whether depth grows away from the eye.
struct Projection {
  const char* name;
  bool parallel = false, oblique = false, forward = false;
};

void PrintTo(const Projection& each, std::ostream* out) {
  *out << each.name;
}

constexpr float kNear_m = 0.05f, kFar_m = 200.0f;
/// An oblique projection's mirror, in view space of front_view(6): it lies aslant in the plants, and what is behind it is seen.
constexpr std::array<float, 4> kMirror{0.3f, 0.2f, -0.932738f, -5.4f};

Shot projected_view(const Projection& projection, float distance_m) {
  Shot view = front_view(distance_m);
  float* m = view.clip_from_view;
  if (projection.parallel) {
    // As large as the perspective shows what is as far away as the plants.
    m[0] /= distance_m;
    m[5] /= distance_m;
    m[10] = (projection.forward ? -1.0f : 1.0f) / (kFar_m - kNear_m);
    m[11] = 0.0f;
    m[14] = projection.forward ? -kNear_m / (kFar_m - kNear_m) : kFar_m / (kFar_m - kNear_m);
    m[15] = 1.0f;
  } else {
    const float scale = kNear_m / (kFar_m - kNear_m);
    m[10] = projection.forward ? -(1.0f + scale) : scale;
    m[14] = (projection.forward ? -1.0f : 1.0f) * kFar_m * scale;
  }
  if (projection.oblique) {
    // Forward depth is the distance behind the mirror over w, in parts of what that is at most; reversed is what is left to 1.
    constexpr float kMost = 1.5f;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t column = 4 * i;
      const float forward = kMirror[i] / kMost;
      m[column + 2] = projection.forward ? forward : m[column + 3] - forward;
    }
  }
  return view;
}

SceneOptions options_of(const Projection& projection, bool compute_raster) {
  return {.compute_raster = compute_raster,
          .depth_compare = projection.forward ? VK_COMPARE_OP_LESS_OR_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL};
}

class ProjectionTest : public VulkanTest, public testing::WithParamInterface<Projection> {
 protected:
  static RendererScene::Frame draw(const std::vector<Placed>& plants, const Shot& view, bool compute_raster) {
    return draw_scene(gpu(), plants, view, options_of(GetParam(), compute_raster));
  }
};

/// Large leaves, which the hardware draws, before and behind small ones.
TEST_P(ProjectionTest, BothPathsDrawTheSame) {
  const DecodedPlant coarse = decoded_plant(random_plant({.leaf_count = 12, .seed = 8, .wood_lod_count = 0, .texture_side = 0}));
  const DecodedPlant fine = decoded_plant(random_plant({.leaf_count = 900, .seed = 9, .wood_lod_count = 0, .texture_side = 0}));
  for (const float coarse_z : {-1.5f, 1.5f}) {
    const std::vector<Placed> plants{{coarse, {tinted(at(0.0f, coarse_z), 1.0f, 0.1f, 0.1f)}},
                                     {fine, {tinted(at(0.2f, 0.0f), 0.1f, 0.1f, 1.0f)}}};
    const Shot view = projected_view(GetParam(), 6.0f);
    const RendererScene::Frame raster = draw(plants, view, true), hardware = draw(plants, view, false);
    EXPECT_LT(raster.counts.hardware_triangles, 100u) << "the fine plant is rasterised";
    const Likeness likeness = compare(raster.picture, hardware.picture);
    // A leaf that the mirror crosses is whole to the hardware, and to the rasteriser it is not there.
    EXPECT_LT(likeness.differing_share, GetParam().oblique ? 0.04 : 0.015) << coarse_z;
    EXPECT_NEAR(likeness.coverage, 1.0, GetParam().oblique ? 0.08 : 0.03) << coarse_z;
    EXPECT_NEAR(likeness.brightness, 1.0, 0.03) << coarse_z;
  }
}

TEST_P(ProjectionTest, SplatsCoverAndShineAlike) {
  const std::vector<Placed> plants{{plain_plant(3000, 3), slanting_row()}};
  const Shot view = projected_view(GetParam(), 30.0f);
  const RendererScene::Frame raster = draw(plants, view, true), hardware = draw(plants, view, false);
  EXPECT_EQ(raster.counts.hardware_triangles, 0u);
  const Likeness likeness = compare(raster.picture, hardware.picture);
  EXPECT_NEAR(likeness.coverage, 1.0, 0.03);
  EXPECT_NEAR(likeness.brightness, 1.0, 0.05);
}

TEST_P(ProjectionTest, WhatIsHiddenIsNotRasterised) {
  std::vector<coppice_placement> behind;
  // Smaller ones, which later rounds look at, and where no near plane lies in between.
  const float distance_m = GetParam().oblique ? 5.0f : 4.0f;
  for (int i = 0; i < 32; ++i) {
    behind.push_back(at(0.01f * static_cast<float>(i) - 0.16f, -60.0f, 0.1f));
    behind.back().position[1] = -60.0f * 0.3f / distance_m;  // on the view's axis
  }
  const DecodedPlant plant = plain_plant(2000, 3);
  const Shot view = projected_view(GetParam(), distance_m);
  const RendererScene::Frame together = draw({{plant, thicket(64, -0.15f)}, {plant, behind}}, view, true);
  const RendererScene::Frame alone = draw({{plant, behind}}, view, true);
  EXPECT_EQ(alone.counts.visible_instances, 32u);
  EXPECT_EQ(alone.counts.occluded_instances, 0u);
  EXPECT_GE(together.counts.occluded_instances, 32u);
  const RendererScene::Frame hardware = draw({{plant, thicket(64, -0.15f)}, {plant, behind}}, view, false);
  EXPECT_NEAR(compare(together.picture, hardware.picture).coverage, 1.0, 0.04);
}

TEST_P(ProjectionTest, DepthMayRunEitherWay) {
  const std::vector<Placed> plants{{decoded_plant(random_plant({.leaf_count = 900, .seed = 9})), {at(0.2f, 0.0f), at(-1.0f, -3.0f)}}};
  Projection other = GetParam();
  other.forward = !other.forward;
  const Picture one = draw(plants, projected_view(GetParam(), 6.0f), true).picture;
  const Picture turned = draw_scene(gpu(), plants, projected_view(other, 6.0f), options_of(other, true)).picture;
  EXPECT_LT(compare_pictures(one, turned, 8).differing_share, 0.001);
}

INSTANTIATE_TEST_SUITE_P(All, ProjectionTest,
                         testing::Values(Projection{"perspective"}, Projection{.name = "perspective_forward", .forward = true},
                                         Projection{.name = "orthographic", .parallel = true},
                                         Projection{.name = "orthographic_forward", .parallel = true, .forward = true},
                                         Projection{.name = "oblique", .oblique = true},
                                         Projection{.name = "oblique_forward", .oblique = true, .forward = true}),
                         [](const auto& projection) { return std::string(projection.param.name); });

}  // namespace coppice::test::leaf_raster_test
