#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "gltf_write.h"
#include "measures.h"
#include "normal_sum.h"
#include "surface_distance.h"
#include "test_foliage.h"

namespace coppice::bake::evaluate_measures_test {

EvaluationImage white_image(std::uint32_t size_px) {
  const std::size_t pixel_count = std::size_t{size_px} * size_px;
  return {size_px, std::vector<float>(pixel_count, 255.0f), std::vector<std::uint8_t>(pixel_count, 0)};
}

Mesh mesh_of(const std::vector<Quad>& quads) {
  return foliage_mesh(test::plain_foliage(quads));
}

Quad square_at(const glm::vec3& corner, float side_m) {
  return test::rectangle(corner, {side_m, 0, 0}, {0, side_m, 0});
}

TEST(BoxFilter, IsTheMeanOfEachBlock) {
  const std::vector<float> values = {1,  2,  3, 4,  //
                                     5,  6,  7, 8,  //
                                     9,  10, 0, 0,  //
                                     11, 12, 0, 4};
  EXPECT_EQ(box_filtered(values, 4, 2), (std::vector<float>{3.5f, 5.5f, 10.5f, 1.0f}));
  EXPECT_EQ(box_filtered(values, 4, 1), values);
  EXPECT_EQ(box_filtered(values, 4, 4), (std::vector<float>{5.125f}));
}

TEST(ImageSums, RmseOfOneWrongPixel) {
  const EvaluationImage reference = white_image(16);
  EvaluationImage image = reference;
  image.luminance[5 * 16 + 7] = 255.0f - 32.0f;
  ImageSums sums = compare_images(image, reference);
  EXPECT_DOUBLE_EQ(sums.rmse(0), 2.0);    // sqrt(32^2 / 256)
  EXPECT_DOUBLE_EQ(sums.rmse(1), 0.5);    // one of 16 blocks is off by 2
  EXPECT_DOUBLE_EQ(sums.rmse(2), 0.125);  // 32 / 256
  // A second pair without error halves the mean square.
  sums.add(compare_images(reference, reference));
  EXPECT_DOUBLE_EQ(sums.rmse(0), std::sqrt(2.0));
}

TEST(ImageSums, OppositeErrorsInOneBlockCancelOnlyWhenFiltered) {
  EvaluationImage reference = white_image(16);
  std::ranges::fill(reference.luminance, 100.0f);
  EvaluationImage image = reference;
  image.luminance[0] += 16.0f;
  image.luminance[1] -= 16.0f;
  const ImageSums sums = compare_images(image, reference);
  EXPECT_DOUBLE_EQ(sums.rmse(0), std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(sums.rmse(1), 0.0);
}

TEST(ImageSums, CoverageAndSoftIou) {
  EvaluationImage reference = white_image(16), image = reference;
  for (const std::size_t pixel : {0u, 1u, 2u, 3u}) reference.coverage[pixel] = 1;        // 4/16 of block 0
  for (const std::size_t pixel : {16u, 17u, 4u, 5u, 6u, 7u}) image.coverage[pixel] = 1;  // 2/16 of block 0, 4/16 of block 1
  const ImageSums sums = compare_images(image, reference);
  EXPECT_DOUBLE_EQ(sums.coverage_ratio(), 1.5);
  EXPECT_DOUBLE_EQ(sums.soft_iou(), 2.0 / 8.0);  // (2 + 0) / (4 + 4) sixteenths
  ImageSums of_two_views = sums;
  of_two_views.add(compare_images(reference, reference));
  EXPECT_DOUBLE_EQ(of_two_views.coverage_ratio(), 10.0 / 8.0);
  EXPECT_DOUBLE_EQ(of_two_views.soft_iou(), 6.0 / 12.0);
  EXPECT_DOUBLE_EQ(compare_images(white_image(16), white_image(16)).soft_iou(), 1.0);
  EXPECT_DOUBLE_EQ(compare_images(white_image(16), white_image(16)).coverage_ratio(), 1.0);
}

TEST(Lightings, TheWorstIsTheLargestErrorAndTheLuminanceFarthestFromOne) {
  LevelMeasures level;
  for (std::size_t i = 0; i < kLightingCount; ++i) level.lightings[i] = {1.0 + static_cast<double>(i), 9.0 - static_cast<double>(i), 1.0};
  level.lightings[1].luminance = 1.1;
  level.lightings[4].luminance = 0.8;
  const LevelMeasures::Lighting worst = worst_lighting(level), mean = mean_lighting(level);
  EXPECT_EQ(worst.rmse_full, 6.0);
  EXPECT_EQ(worst.rmse_sixteenth, 9.0);
  EXPECT_EQ(worst.luminance, 0.8);
  EXPECT_NEAR(mean.rmse_full, 3.5, 1e-12);
  EXPECT_NEAR(mean.rmse_sixteenth, 6.5, 1e-12);
  EXPECT_NEAR(mean.luminance, (4.0 + 1.1 + 0.8) / 6.0, 1e-12);
}

/// A wall of squares that faces +Z, 2 m wide, of one colour.
Level wall(std::uint16_t normals, std::uint8_t opacity = kOpaque) {
  Foliage foliage =
      test::plain_foliage({square_at({-1, -1, 0}, 1), square_at({0, -1, 0}, 1), square_at({-1, 0, 0}, 1), square_at({0, 0, 0}, 1)});
  foliage.normals.assign(4, normals);
  foliage.opacities.assign(4, opacity);
  return level_of(foliage_mesh(foliage));
}

/// Luminance, 0..1, of leaves with a front under each of evaluation_light_suns().
std::array<double, 2> lit_by(const ShadingNormals& normals) {
  const glm::dvec3 front(normals.axis[0], normals.axis[1], normals.axis[2]);
  const auto suns = evaluation_light_suns();
  return {0.2 + 0.6 * glm::dot(front, suns[0]), 0.2 + 0.6 * glm::dot(front, suns[1])};
}

TEST(Lightings, GroundsCountWhereCoverageDiffersAndLuminanceIsOfLeavesAlone) {
  const std::vector<Material> materials = test::plain_materials();
  const Level source = wall(node_normals(normal_sum({0, 1, 0}, 1.0, true)));
  const auto looks = *surface_looks(materials, {});
  EvaluateOptions options{.suns_and_frames = false};
  const auto reference = make_reference({source, materials, {}}, options);
  ASSERT_TRUE(reference);
  EXPECT_NEAR(reference->mean_tone, 1.0, 1e-6);
  const auto measured = [&](const Level& level) {
    return measure_level(level, looks, *reference, measure_images(level, looks, *reference));
  };

  // Half of the leaves' pixels show the ground. Leaves show the same luminance on whichever side.
  const LevelMeasures half = measured(wall(node_normals(normal_sum({0, 1, 0}, 1.0, true)), 8));
  EXPECT_NEAR(half.coverage, 0.5, 0.02);
  const auto [high, low] = lit_by(source.normals[0]);
  const auto expected = [high = high, low = low](double ground) {
    return std::sqrt(0.5 * ((high - ground) * (high - ground) + (low - ground) * (low - ground)));
  };
  for (std::size_t i = 0; i < kLightingCount; ++i) {
    EXPECT_NEAR(half.lightings[i].luminance, 1.0, 1e-4);
    EXPECT_NEAR(half.lightings[i].rmse_full / half.lightings[0].rmse_full, expected(kEvaluationGrounds[i % 3]) / expected(0.0), 0.005) << i;
  }
  // Leaves about the vertical that are lit from below: the sun shines through them, or not at all.
  const LevelMeasures turned = measured(wall(node_normals(normal_sum({0, -1, 0}, 1.0, true))));
  EXPECT_NEAR(turned.coverage, 1.0, 1e-9);
  EXPECT_NEAR(turned.lightings[0].luminance, 0.4 / (high + low), 0.002);
  EXPECT_NEAR(turned.lightings[3].luminance, (0.4 + double{kTranslucency} * (high + low - 0.4)) / (high + low), 0.002);
  EXPECT_EQ(turned.lightings[0].rmse_full, turned.lightings[2].rmse_full) << "the ground is hidden as much as it was";
}

TEST(TriangleDistance, FaceEdgeAndCorner) {
  const std::array<glm::dvec3, 3> triangle{glm::dvec3(0, 0, 0), {4, 0, 0}, {0, 4, 0}};
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle({1, 1, 3}, triangle), 9.0);
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle({1, 1, -3}, triangle), 9.0);
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle({2, -3, 4}, triangle), 25.0);
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle({7, -4, 0}, triangle), 25.0);
  EXPECT_NEAR(squared_distance_to_triangle({4, 4, 0}, triangle), 8.0, 1e-12);
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle({3, 4, 0}, {glm::dvec3(0), glm::dvec3(0), glm::dvec3(0)}), 25.0) << "a point";
  EXPECT_DOUBLE_EQ(squared_distance_to_triangle({3, 4, 0}, {glm::dvec3(0), {1, 0, 0}, {9, 0, 0}}), 16.0) << "a line";
}

TEST(TriangleTree, FindsWhatAskingEveryTriangleFinds) {
  const Mesh mesh = foliage_mesh(test::random_quads(300, 7));
  const TriangleTree tree(mesh);
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 point(test::uniform(random, -2, 2), test::uniform(random, -2, 2), test::uniform(random, -2, 2));
    double expected = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.indices.size(); t += 3)
      expected =
          std::min(expected, squared_distance_to_triangle(point, {mesh.positions[mesh.indices[t]], mesh.positions[mesh.indices[t + 1]],
                                                                  mesh.positions[mesh.indices[t + 2]]}));
    ASSERT_EQ(tree.squared_distance(point), expected) << i;
  }
  EXPECT_TRUE(std::isinf(TriangleTree(Mesh{}).squared_distance({0, 0, 0})));
}

TEST(SurfaceDistance, ParallelSquaresAreAsFarApartAsTheirPlanes) {
  const Mesh a = mesh_of({square_at({0, 0, 0}, 1)}), b = mesh_of({square_at({0, 0, 2}, 1)});
  const SurfaceDistance distance = symmetric_distance(distance_to_surface(sample_surface(a, 1000), TriangleTree(b)),
                                                      distance_to_surface(sample_surface(b, 1000), TriangleTree(a)));
  EXPECT_DOUBLE_EQ(distance.max_m, 2.0);
  EXPECT_DOUBLE_EQ(distance.mean_m, 2.0);
}

TEST(SurfaceDistance, APartIsNearTheWholeButNotTheWholeNearThePart) {
  const Mesh part = mesh_of({square_at({0, 0, 0}, 1)});
  const Mesh whole = mesh_of({test::rectangle({0, 0, 0}, {2, 0, 0}, {0, 1, 0})});
  const SurfaceDistance forward = distance_to_surface(sample_surface(part, 4000), TriangleTree(whole));
  const SurfaceDistance backward = distance_to_surface(sample_surface(whole, 4000), TriangleTree(part));
  EXPECT_NEAR(forward.max_m, 0.0, 1e-12);
  EXPECT_NEAR(forward.mean_m, 0.0, 1e-12);
  EXPECT_DOUBLE_EQ(backward.max_m, 1.0);
  EXPECT_NEAR(backward.mean_m, 0.25, 0.002);  // half of it at 0 to 1
  const SurfaceDistance both = symmetric_distance(forward, backward);
  EXPECT_DOUBLE_EQ(both.max_m, 1.0);
  EXPECT_DOUBLE_EQ(both.mean_m, backward.mean_m);
}

TEST(SurfaceDistance, NothingIsInfinitelyFar) {
  const Mesh mesh = mesh_of({square_at({0, 0, 0}, 1)});
  EXPECT_TRUE(std::isinf(distance_to_surface(sample_surface({}, 10), TriangleTree(mesh)).mean_m));
  EXPECT_TRUE(std::isinf(distance_to_surface(sample_surface(mesh, 10), TriangleTree({})).max_m));
}

TEST(SurfaceSamples, FallOnTrianglesByTheirArea) {
  // A square of 1 m^2 and one of 4 m^2 far away.
  const Mesh mesh = mesh_of({square_at({0, 0, 0}, 1), square_at({10, 0, 0}, 2)});
  EXPECT_DOUBLE_EQ(surface_area_m2(mesh), 5.0);
  const SurfaceSamples samples = sample_surface(mesh, 1000);
  EXPECT_EQ(samples.vertices.size(), 8u);
  ASSERT_EQ(samples.points.size(), 1000u);
  EXPECT_EQ(std::ranges::count_if(samples.points, [](const glm::dvec3& p) { return p.x <= 1.0; }), 200);
  const TriangleTree tree(mesh);
  for (const glm::dvec3& point : samples.points) EXPECT_NEAR(tree.squared_distance(point), 0.0, 1e-12);
}

}  // namespace coppice::bake::evaluate_measures_test
