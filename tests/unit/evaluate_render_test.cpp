#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "evaluation_render.h"
#include "gltf_write.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake {
namespace evaluate_render_test {

// Seen from 3 m with tan(half field of view) = 1 / sqrt(8), the plane through the middle of the unit sphere is this wide from the middle
// of the image to its side.
const float kHalfImage_m = 3.0f / std::sqrt(8.0f);

EvaluationCamera camera_from(const glm::dvec3& direction) {
  return evaluation_camera(direction, Sphere{glm::vec3(0.0f), 1.0f});
}

/// In the plane z, from (x0, y0) to (x1, y1).
Quad upright(float x0, float y0, float x1, float y1, float z) {
  return test::rectangle({x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0});
}

EvaluationImage draw(const std::vector<Quad>& quads, const EvaluationCamera& camera, std::uint32_t size_px = 256) {
  return render_evaluation(foliage_mesh(test::plain_foliage(quads)), *surface_looks(test::plain_materials(), {}), camera, size_px);
}

std::uint32_t covered(const EvaluationImage& image) {
  return std::accumulate(image.coverage.begin(), image.coverage.end(), 0u);
}

TEST(EvaluationRender, ASquareFillsTheShareOfThePixelsItSubtends) {
  const float half = 0.5f * kHalfImage_m;
  const EvaluationCamera camera = camera_from({0, 0, 1});
  EXPECT_EQ(covered(draw({upright(-half, -half, half, half, 0)}, camera)), 128u * 128u);
  // At two thirds of the distance it is 1.5 times as wide.
  EXPECT_EQ(covered(draw({upright(-half, -half, half, half, 1)}, camera)), 192u * 192u);
  EXPECT_EQ(covered(draw({upright(-9, -9, 9, 9, 0)}, camera)), 256u * 256u);
  EXPECT_EQ(covered(draw({upright(-half, -half, half, half, 4)}, camera)), 0u) << "it is behind the camera";
  EXPECT_EQ(covered(draw({test::rectangle({0, -half, -half}, {0, 0, 1}, {0, 1, 0})}, camera)), 0u) << "it is seen edge-on";
}

TEST(EvaluationRender, RightIsRightAndRowZeroIsTheTop) {
  const EvaluationImage image = draw({upright(0, 0, kHalfImage_m, kHalfImage_m, 0)}, camera_from({0, 0, 1}), 16);
  for (std::size_t y = 0; y < 16; ++y)
    for (std::size_t x = 0; x < 16; ++x) EXPECT_EQ(image.coverage[y * 16 + x], x >= 8 && y < 8 ? 1 : 0) << x << ", " << y;
}

TEST(EvaluationRender, TheSphereJustFits) {
  // The image's side touches the unit sphere where the sight line's distance from the middle is 1.
  for (const glm::dvec3& direction : evaluation_directions(8)) {
    const EvaluationCamera camera = camera_from(direction);
    EXPECT_NEAR(glm::length(camera.position), 3.0, 1e-12);
    const glm::dvec3 side = glm::normalize(camera.forward + camera.tan_half_view * camera.right);
    EXPECT_NEAR(glm::length(glm::cross(camera.position, side)), 1.0, 1e-12);
    EXPECT_NEAR(glm::dot(glm::cross(camera.right, camera.up), camera.forward), -1.0, 1e-12);
  }
  EXPECT_NEAR(glm::length(camera_from({0, 1, 0}).right), 1.0, 1e-12) << "straight down";
}

TEST(EvaluationRender, LambertIsThatOfTheSideThatIsSeen) {
  // sun = (0.5, 1, 0.3) / 1.15758; towards +Z n . sun = 0.25916, light 0.35 + 0.65 * 0.25916 = 0.51846, as sRGB 0.74738.
  const EvaluationImage front = draw({upright(-1, -1, 1, 1, 0)}, camera_from({0, 0, 1}));
  EXPECT_NEAR(front.luminance[128 * 256 + 128], 255.0 * 0.74738, 0.02);
  // From behind only the ambient light is left: 0.35, as sRGB 0.62620.
  const EvaluationImage back = draw({upright(-1, -1, 1, 1, 0)}, camera_from({0, 0, -1}));
  EXPECT_NEAR(back.luminance[128 * 256 + 128], 255.0 * 0.62620, 0.02);
  EXPECT_EQ(back.luminance[0], 255.0f) << "the background is white";

  const Quad quad = upright(-1, -1, 1, 1, 0);
  const EvaluationImage reversed = draw({Quad{quad[3], quad[2], quad[1], quad[0]}}, camera_from({0, 0, 1}));
  EXPECT_EQ(reversed.luminance, front.luminance) << "winding does not matter";
}

TEST(EvaluationRender, TheNearerOfTwoIsSeenInEitherOrder) {
  const Quad near = upright(-1, -1, 0, 1, 0.5f), far = test::rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, -0.5f});
  const EvaluationCamera camera = camera_from({0, 0, 1});
  const EvaluationImage image = draw({near, far}, camera);
  EXPECT_EQ(draw({far, near}, camera).luminance, image.luminance);
  const std::size_t left = 128 * 256 + 100, right = 128 * 256 + 156;
  EXPECT_EQ(image.luminance[left], draw({near}, camera).luminance[left]);
  EXPECT_EQ(image.luminance[right], draw({far}, camera).luminance[right]);
  EXPECT_NE(image.luminance[left], image.luminance[right]);
}

TEST(EvaluationRender, ATriangleMayReachBehindTheCamera) {
  // The ground from far in front to far behind: everything below the horizon.
  const EvaluationImage image = draw({test::rectangle({-1000, -0.1f, -1000}, {2000, 0, 0}, {0, 0, 2000})}, camera_from({0, 0, 1}));
  for (std::size_t pixel = 0; pixel < image.coverage.size(); ++pixel) ASSERT_EQ(image.coverage[pixel], pixel / 256 >= 128 ? 1 : 0) << pixel;
}

TEST(EvaluationRender, HolesOfTheMaskShowWhatIsBehindAndDoNotColour) {
  // Left texel white, right texel black and a hole.
  std::vector<Material> materials(1);
  materials[0].image = 0;
  materials[0].alpha_cutoff = 0.5f;
  const std::vector<Image> images{{2, 1, {255, 255, 255, 255, 0, 0, 0, 0}}};
  const auto looks = test::must(surface_looks(materials, images));
  EXPECT_NEAR(looks[0].albedo, 1.0, 1e-12);
  EXPECT_EQ(looks[0].holes, (std::vector<std::uint8_t>{0, 1}));

  Foliage foliage = test::plain_foliage({upright(-kHalfImage_m, -kHalfImage_m, kHalfImage_m, kHalfImage_m, 0)});
  foliage.card_table[0].uv = {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)};
  const EvaluationImage image = render_evaluation(foliage_mesh(foliage), looks, camera_from({0, 0, 1}), 64);
  for (std::size_t pixel = 0; pixel < image.coverage.size(); ++pixel) {
    ASSERT_EQ(image.coverage[pixel], pixel % 64 < 32 ? 1 : 0) << pixel;
    ASSERT_EQ(image.luminance[pixel] == 255.0f, pixel % 64 >= 32) << pixel;
  }
  materials[0].image = kNone;
  materials[0].base_color.a = 0.4f;
  EXPECT_EQ(covered(render_evaluation(foliage_mesh(foliage), *surface_looks(materials, {}), camera_from({0, 0, 1}), 64)), 0u);
}

TEST(EvaluationRender, ColourIsTheMeanOfTheTexelsInLinearLight) {
  std::vector<Material> materials(1);
  materials[0].image = 0;
  materials[0].base_color = {0.5f, 0.5f, 0.5f, 1.0f};
  const auto looks = test::must(surface_looks(materials, {{2, 1, {255, 255, 255, 255, 0, 0, 0, 0}}}));
  EXPECT_NEAR(looks[0].albedo, 0.25, 1e-12);
  materials[0].image = 3;
  EXPECT_FALSE(surface_looks(materials, {}));
  materials[0].image = 0;
  EXPECT_FALSE(surface_looks(materials, {{2, 1, {255}}}));
}

TEST(EvaluationRender, TexturesShowTheMeanOfWhatAPixelCovers) {
  std::vector<Material> materials(1);
  materials[0].image = 0;
  materials[0].alpha_cutoff = 0.5f;
  // White, a hole, black: a hole has no part in any mean.
  const auto row =
      test::must(surface_looks(materials, {{3, 1, {255, 255, 255, 255, 255, 255, 255, 0, 0, 0, 0, 255}}}, SurfaceColour::textured));
  ASSERT_EQ(row[0].mips.size(), 3u);
  const std::vector<float> none_is_halved{row[0].mips[0].albedo[0], row[0].mips[0].albedo[2]};
  EXPECT_EQ(none_is_halved, (std::vector<float>{1.0f, 0.0f}));
  EXPECT_EQ(row[0].mips[1].albedo, (std::vector<float>{1.0f, 0.0f}));
  EXPECT_EQ(row[0].mips[2].albedo, (std::vector<float>{0.5f}));

  Foliage foliage = test::plain_foliage({upright(-kHalfImage_m, -kHalfImage_m, kHalfImage_m, kHalfImage_m, 0)});
  foliage.card_table[0].uv = {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)};
  const EvaluationImage near = render_evaluation(foliage_mesh(foliage), row, camera_from({0, 0, 1}), 48);
  const float white = lambert_luminance(1.0, {0, 0, 1}), black = lambert_luminance(0.0, {0, 0, 1});
  for (std::size_t pixel = 0; pixel < near.luminance.size(); ++pixel)
    ASSERT_EQ(near.luminance[pixel], pixel % 48 < 16 ? white : pixel % 48 < 32 ? kEvaluationWhite : black) << pixel;

  // A board of 64 x 64 squares, each a texel, drawn 16 px wide: level 2, and a level 2 texel holds as many white as black ones.
  Image board{64, 64, {}};
  for (std::size_t i = 0; i < 64 * 64; ++i) {
    const auto value = static_cast<std::uint8_t>((i + i / 64) % 2 * 255);
    board.rgba.insert(board.rgba.end(), {value, value, value, 255});
  }
  const auto looks = surface_looks(materials, {board}, SurfaceColour::textured);
  const EvaluationImage far = render_evaluation(foliage_mesh(foliage), *looks, camera_from({0, 0, 1}), 16);
  for (const float value : far.luminance) ASSERT_EQ(value, lambert_luminance(0.5, {0, 0, 1}));
  const EvaluationImage full = render_evaluation(foliage_mesh(foliage), *looks, camera_from({0, 0, 1}), 64);
  EXPECT_EQ(full.luminance[0], black);
  EXPECT_EQ(full.luminance[1], white);
}

TEST(EvaluationDirections, AreUnitAndUniformAndAlwaysTheSame) {
  const std::vector<glm::dvec3> directions = evaluation_directions(8000);
  std::array<int, 8> octants{};
  for (const glm::dvec3& d : directions) {
    EXPECT_NEAR(glm::length(d), 1.0, 1e-12);
    ++octants[(d.x > 0 ? 1u : 0u) + (d.y > 0 ? 2u : 0u) + (d.z > 0 ? 4u : 0u)];
  }
  for (const int count : octants) EXPECT_NEAR(count, 1000, 100);
  EXPECT_EQ(evaluation_directions(24), std::vector<glm::dvec3>(directions.begin(), directions.begin() + 24));
}

TEST(EvaluationSphere, IsAboutTheBoxOfTheVertices) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 4, 0}};
  const Sphere sphere = evaluation_sphere(mesh);
  EXPECT_EQ(sphere.center, glm::vec3(1, 2, 0));
  EXPECT_NEAR(sphere.radius, std::sqrt(5.0), 1e-6);
}

Level level_of(const std::vector<Quad>& quads, const LeafShade& shade) {
  Level level{foliage_mesh(test::plain_foliage(quads))};
  level.shades.assign(quads.size(), shade);
  return level;
}

TEST(EvaluationRender, OpacityIsAShareOfSamples) {
  const Level level = level_of({upright(-9, -9, 9, 9, 0)}, {0.25f, 1.0f});
  const auto looks = *surface_looks(test::plain_materials(), {});
  const EvaluationCamera camera = camera_from({0, 0, 1});
  const EvaluationImage image = render_evaluation(level, looks, camera, 64);
  EXPECT_NEAR(covered(image) / (64.0 * 64.0), 0.25, 0.02);
  EXPECT_EQ(render_evaluation(level, looks, camera, 64).coverage, image.coverage) << "the same samples each time";
  for (std::uint32_t pixel = 0; pixel < 1000; ++pixel) {
    int count = 0;
    for (std::uint32_t frame = 0; frame < 16; ++frame) count += covers_sample(0.25f, 3, pixel, frame) ? 1 : 0;
    ASSERT_GE(count, 3) << pixel;
    ASSERT_LE(count, 5) << pixel;
  }
  // Two leaves on each other at one half: three quarters of the samples, not one half as if they were the same.
  const Level two = level_of({upright(-9, -9, 9, 9, 0), upright(-9, -9, 9, 9, 0.2f)}, {0.5f, 1.0f});
  EXPECT_NEAR(covered(render_evaluation(two, looks, camera, 64)) / (64.0 * 64.0), 0.75, 0.02);
}

TEST(EvaluationRender, BrightnessMultipliesLight) {
  const auto looks = *surface_looks(test::plain_materials(), {});
  // 0.51846 of light (LambertIsThatOfTheSideThatIsSeen), a half of it is 0.25923, as sRGB 0.54611.
  const EvaluationImage image = render_evaluation(level_of({upright(-9, -9, 9, 9, 0)}, {1.0f, 0.5f}), looks, camera_from({0, 0, 1}), 16);
  EXPECT_NEAR(image.luminance[0], 255.0 * 0.54611, 0.05);
}

TEST(EvaluationRender, SunsGoRoundAndUp) {
  const std::vector<glm::dvec3> suns = evaluation_suns();
  ASSERT_EQ(suns.size(), 8u);
  for (std::size_t i = 0; i < suns.size(); ++i) {
    EXPECT_NEAR(glm::length(suns[i]), 1.0, 1e-12);
    EXPECT_NEAR(suns[i].y, (static_cast<double>(i) + 0.5) / 8.0, 1e-12);
  }
  const auto looks = *surface_looks(test::plain_materials(), {});
  const UnlitImage unlit =
      render_unlit(Level{foliage_mesh(test::plain_foliage({upright(-9, -9, 9, 9, 0)}))}, looks, camera_from({0, 0, 1}), 16);
  EXPECT_EQ(lit_image(unlit, {0, 0, 1}).luminance[0], 255.0f) << "a white leaf that faces the sun";
  EXPECT_NEAR(lit_image(unlit, {0, 1, 0}).luminance[0], 255.0 * 0.62620, 0.02) << "ambient light";
}

TEST(EvaluationRender, FramesSmoothAnEdge) {
  const std::vector<EvaluationFrame> frames = temporal_frames();
  ASSERT_EQ(frames.size(), 16u);
  EXPECT_EQ(frames[0].jitter_px, glm::dvec2(0.0, 1.0 / 3.0 - 0.5));
  EXPECT_EQ(frames[1].jitter_px.x, -0.25);
  EXPECT_EQ(frames[15].index, 15u);
  // The edge is 0.01 px right of the middle of column 8: 9 of the 16 jitters (eight negative ones and 0) are on the leaf's side of it.
  const float edge = kHalfImage_m * (2.0f * 8.51f / 16.0f - 1.0f);
  const Level level{foliage_mesh(test::plain_foliage({upright(-9, -9, edge, 9, 0)}))};
  const std::vector<float> mean = render_temporal_mean(level, *surface_looks(test::plain_materials(), {}), camera_from({0, 0, 1}), 16);
  const double leaf = 255.0 * 0.74738;
  EXPECT_NEAR(mean[7], leaf, 0.02);
  EXPECT_NEAR(mean[8], (9 * leaf + 7 * 255.0) / 16, 0.02);
  EXPECT_NEAR(mean[9], 255.0, 1e-3);
}

TEST(EvaluationRender, ANeedleTurnsToTheCamera) {
  Level level;
  level.needles = {{{0, -9, 0}, {0, 9, 0}, 0.5f * kHalfImage_m, 0}};
  const auto looks = *surface_looks(test::plain_materials(), {});
  for (const glm::dvec3& direction : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(0.6, 0, -0.8)})
    EXPECT_EQ(covered(render_evaluation(level, looks, camera_from(direction), 64)), 64u * 16u);
  EXPECT_EQ(covered(render_evaluation(level, looks, camera_from({0, 1, 0}), 64)), 0u) << "it points at the camera";
}

TEST(EvaluationRender, AVoxelIsAsOpaqueAsItsLeavesAreDense) {
  Voxel voxel{glm::vec3(0), 0.5f, 0, {}};
  voxel.area_m2[2] = std::log(2.0f);  // normals along z; 1 m of way through 1 m^3
  Level level;
  level.voxels = {voxel};
  const auto looks = *surface_looks(test::plain_materials(), {});
  const auto share = [&](const glm::dvec3& direction) {
    const EvaluationCamera camera = evaluation_camera(direction, Sphere{glm::vec3(0.0f), 0.5f}, 900.0);
    return covered(render_evaluation(level, looks, camera, 256)) / (256.0 * 256.0);
  };
  EXPECT_NEAR(share({0, 0, 1}), 0.5, 0.01);
  EXPECT_EQ(share({1, 0, 0}), 0.0) << "its leaves are seen edge-on";
  level.voxels[0].area_m2[2] = 1e6f;
  EXPECT_EQ(share({0, 0, 1}), 1.0);
}

}  // namespace evaluate_render_test
}  // namespace coppice::bake
