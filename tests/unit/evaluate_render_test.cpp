#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "evaluation_render.h"
#include "gltf_write.h"
#include "normal_sum.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake::evaluate_render_test {

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
  EXPECT_NEAR(front.luminance[128 * 256 + 128], 255.0 * 0.74738, 0.03);
  // From behind 45 % of it shines through: 0.35 + 0.65 * 0.45 * 0.25916 = 0.42580, as sRGB 0.68419.
  const EvaluationImage back = draw({upright(-1, -1, 1, 1, 0)}, camera_from({0, 0, -1}));
  EXPECT_NEAR(back.luminance[128 * 256 + 128], 255.0 * 0.68419, 0.03);
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
  const ShadingNormals facing = flat_normals({0, 0, 1});
  const float cosine = leaf_cosine(facing, glm::vec3(evaluation_sun()), {0, 0, 1}, kTranslucency);
  const float white = lambert_luminance(1.0f, cosine), black = lambert_luminance(0.0f, cosine);
  for (std::size_t pixel = 0; pixel < near.luminance.size(); ++pixel)
    ASSERT_NEAR(near.luminance[pixel], pixel % 48 < 16 ? white : pixel % 48 < 32 ? kEvaluationWhite : black, 1e-3) << pixel;

  // A board of 64 x 64 squares, each a texel, drawn 16 px wide: level 2, and a level 2 texel holds as many white as black ones.
  Image board{64, 64, {}};
  for (std::size_t i = 0; i < 64 * 64; ++i) {
    const auto value = static_cast<std::uint8_t>((i + i / 64) % 2 * 255);
    board.rgba.insert(board.rgba.end(), {value, value, value, 255});
  }
  const auto looks = surface_looks(materials, {board}, SurfaceColour::textured);
  const EvaluationImage far = render_evaluation(foliage_mesh(foliage), *looks, camera_from({0, 0, 1}), 16);
  for (const float value : far.luminance) ASSERT_NEAR(value, lambert_luminance(0.5f, cosine), 1e-3);
  const EvaluationImage full = render_evaluation(foliage_mesh(foliage), *looks, camera_from({0, 0, 1}), 64);
  EXPECT_NEAR(full.luminance[0], black, 1e-3);
  EXPECT_NEAR(full.luminance[1], white, 1e-3);
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

Level translucent(const std::vector<Quad>& quads, std::uint8_t opacity) {
  Foliage foliage = test::plain_foliage(quads);
  foliage.opacities.assign(quads.size(), opacity);
  return level_of(foliage_mesh(foliage));
}

/// One leaf in the middle of the image that faces +Z, with these normals.
Level with_normals(std::uint16_t normals) {
  Foliage foliage = test::plain_foliage({upright(-0.3f, -0.3f, 0.3f, 0.3f, 0)});
  foliage.normals = {normals};
  return level_of(foliage_mesh(foliage));
}

TEST(EvaluationRender, OpacityIsAShareOfSamples) {
  const Level level = translucent({upright(-9, -9, 9, 9, 0)}, 4);
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
  const Level two = translucent({upright(-9, -9, 9, 9, 0), upright(-9, -9, 9, 9, 0.2f)}, 8);
  EXPECT_NEAR(covered(render_evaluation(two, looks, camera, 64)) / (64.0 * 64.0), 0.75, 0.02);
}

/// Luminance in the middle of an image of a white level, from +Z, of a sun.
float middle_of(const Level& level, const glm::dvec3& direction, const glm::dvec3& sun, float translucency) {
  const auto looks = *surface_looks(test::plain_materials(), {});
  return leaf_luminances(render_unlit(level, looks, camera_from(direction), 16), sun, translucency, 1.0, 0.0f)[8 * 16 + 8];
}

TEST(EvaluationRender, ALeafIsLitByHowItsNormalsLie) {
  const auto shown = [](double cosine) { return 255.0 * (0.2 + 0.6 * cosine); };
  const std::uint16_t sideways = node_normals(normal_sum({1, 0, 0}, 1.0));
  EXPECT_NEAR(middle_of(with_normals(kFlatNormals), {0, 0, 1}, {0, 0, 1}, 0.0f), shown(1.0), 0.2);
  EXPECT_NEAR(middle_of(with_normals(kFlatNormals), {0, 0, 1}, {1, 0, 0}, 0.0f), shown(0.0), 0.2);
  EXPECT_NEAR(middle_of(with_normals(sideways), {0.6, 0, 0.8}, {0, 0, 1}, 0.0f), shown(0.0), 2.0) << "its axis, not its quad, is lit";
  EXPECT_NEAR(middle_of(with_normals(sideways), {0.6, 0, 0.8}, {1, 0, 0}, 0.0f), shown(1.0), 2.0);
  EXPECT_NEAR(middle_of(with_normals(sideways), {-0.6, 0, 0.8}, {1, 0, 0}, 0.0f), shown(0.0), 2.0) << "seen from the other side";
  EXPECT_NEAR(middle_of(with_normals(sideways), {-0.6, 0, 0.8}, {1, 0, 0}, 0.45f), shown(0.45), 2.0) << "and it shines through";
  const std::uint16_t sided = node_normals(normal_sum({1, 0, 0}, 1.0, true));
  EXPECT_NEAR(middle_of(with_normals(sided), {-0.6, 0, 0.8}, {1, 0, 0}, 0.0f), shown(1.0), 2.0) << "lit whoever looks";
  EXPECT_NEAR(middle_of(with_normals(sided), {0.6, 0, 0.8}, {-1, 0, 0}, 0.0f), shown(0.0), 2.0);
  // Leaves of all directions before the sun show Lambert's sphere from the front, 2/3, and half of their light from the side.
  const NormalSum all = normal_sum({1, 0, 0}, 1.0) + normal_sum({0, 1, 0}, 1.0) + normal_sum({0, 0, 1}, 1.0);
  const Level ball = with_normals(node_normals(all));
  EXPECT_NEAR(middle_of(ball, {0, 0, 1}, {0, 0, 1}, 0.0f), shown(2.0 / 3.0), 4.0);
  const float front = middle_of(ball, {0, 0, 1}, {0, 0, 1}, 0.0f), side = middle_of(ball, {0, 0, 1}, {1, 0, 0}, 0.0f),
              back = middle_of(ball, {0, 0, 1}, {0, 0, -1}, 0.0f);
  EXPECT_GT(front, side);
  EXPECT_GT(side, back);
  EXPECT_NEAR(back, shown(0.0), 4.0);
}

TEST(EvaluationRender, LeavesAsTheyWereModelledAreLitAsTheyLieUnlessAnArtistSaysOtherwise) {
  Mesh mesh = foliage_mesh(test::plain_foliage({upright(-9, -9, 9, 9, 0)}));
  mesh.normals.assign(4, glm::vec3(1, 0, 0));
  std::vector<Material> materials = test::plain_materials();
  const Level plain = modelled_level(mesh, materials);
  EXPECT_NEAR(middle_of(plain, {0, 0, 1}, {0, 0, 1}, 0.0f), 255.0 * 0.8, 0.2);
  materials[0].sided_normals = true;
  const Level sided = modelled_level(mesh, materials);
  ASSERT_EQ(sided.normals.size(), 2u);
  EXPECT_NEAR(middle_of(sided, {0, 0, 1}, {0, 0, 1}, 0.0f), 255.0 * 0.2, 0.2);
  EXPECT_NEAR(middle_of(sided, {-0.6, 0, 0.8}, {1, 0, 0}, 0.0f), 255.0 * 0.8, 0.2);
}

TEST(EvaluationRender, LeavesOfTheMeanColourAreAsBrightAsTheGroundIsMeantToBe) {
  std::vector<Material> materials(2);
  materials[0].base_color = {0.2f, 0.2f, 0.2f, 1.0f};
  materials[1].base_color = {0.05f, 0.05f, 0.05f, 1.0f};
  Foliage foliage = test::plain_foliage({upright(-kHalfImage_m, -9, 0, 9, 0), upright(0, -9, 0.5f * kHalfImage_m, 9, 0)});
  foliage.card_table.push_back({1, foliage.card_table[0].uv});
  foliage.cards = {0, 1};
  const UnlitImage unlit = render_unlit(level_of(foliage_mesh(foliage)), *surface_looks(materials, {}), camera_from({0, 0, 1}), 16);
  const ToneSum tones = tone_sum(unlit);
  EXPECT_EQ(tones.pixel_count, 16u * 12u);
  // sRGB of 0.2 is 0.48453, of 0.05 it is 0.24780; the first has two thirds of the pixels.
  const double mean = (2.0 * 0.48453 + 0.24780) / 3.0;
  EXPECT_NEAR(tones.sum / static_cast<double>(tones.pixel_count), mean, 1e-4);
  const std::vector<float> lit = leaf_luminances(unlit, {0, 0, 1}, 0.0f, mean, 77.0f);
  EXPECT_NEAR(lit[0], 255.0 * 0.8 * 0.48453 / mean, 0.1);
  EXPECT_NEAR(lit[9], 255.0 * 0.8 * 0.24780 / mean, 0.1);
  EXPECT_EQ(lit[15], 77.0f) << "the ground";
  EXPECT_EQ(leaf_luminances(unlit, {0, 0, 1}, 0.0f, 0.1, 77.0f)[0], 255.0f) << "nothing is whiter than white";
}

TEST(EvaluationRender, TheTwoSunsOfALightAreHighAndLow) {
  const auto [high, low] = evaluation_light_suns();
  EXPECT_NEAR(glm::length(high), 1.0, 1e-12);
  EXPECT_NEAR(glm::length(low), 1.0, 1e-12);
  EXPECT_NEAR(glm::degrees(std::asin(high.y)), 60.0, 0.6);
  EXPECT_NEAR(glm::degrees(std::asin(low.y)), 17.0, 0.6);
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
  EXPECT_NEAR(lit_image(unlit, {0, 0, 1}).luminance[0], 255.0f, 0.02) << "a white leaf that faces the sun";
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
  EXPECT_NEAR(mean[7], leaf, 0.03);
  EXPECT_NEAR(mean[8], (9 * leaf + 7 * 255.0) / 16, 0.03);
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

}  // namespace coppice::bake::evaluate_render_test
