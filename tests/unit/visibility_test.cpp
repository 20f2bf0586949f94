// Where leaves are seen from, and which pixels they cover.

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "item_areas.h"
#include "results.h"
#include "test_foliage.h"
#include "viewpoints.h"
#include "visibility.h"

namespace coppice::bake::visibility_test {

TEST(Viewpoints, TwentyAreTheVerticesOfADodecahedron) {
  const auto views = test::must(viewpoints(20));
  ASSERT_EQ(views.size(), 20u);
  // Neighbours of a vertex on the unit sphere are at the angle whose cosine is sqrt(5) / 3.
  const float edge_cosine = std::sqrt(5.0f) / 3.0f;
  for (const Viewpoint& view : views) {
    std::vector<float> cosines;
    for (const Viewpoint& other : views) cosines.push_back(glm::dot(view.direction, other.direction));
    std::sort(cosines.begin(), cosines.end(), std::greater<>());
    EXPECT_NEAR(cosines[0], 1.0f, 1e-6f);
    for (std::size_t i = 1; i <= 3; ++i) EXPECT_NEAR(cosines[i], edge_cosine, 1e-6f);
    EXPECT_NEAR(cosines[4], 1.0f / 3.0f, 1e-6f);
    EXPECT_NEAR(cosines[19], -1.0f, 1e-6f);
  }
}

TEST(Viewpoints, AxesAreOrthonormalAndRightHandedForAnyCount) {
  for (const std::uint32_t count : {1u, 2u, 6u, 20u, 100u, 1024u}) {
    const auto views = test::must(viewpoints(count));
    ASSERT_EQ(views.size(), count);
    for (const Viewpoint& view : views) {
      EXPECT_NEAR(glm::length(view.direction), 1.0f, 1e-5f);
      EXPECT_NEAR(glm::length(view.right), 1.0f, 1e-5f);
      EXPECT_NEAR(glm::length(view.up), 1.0f, 1e-5f);
      EXPECT_NEAR(glm::distance(glm::cross(view.right, view.up), view.direction), 0.0f, 1e-5f);
    }
  }
}

TEST(Viewpoints, FibonacciSphereHasNoTwinsAndNoGaps) {
  const auto views = test::must(viewpoints(100));
  glm::vec3 sum(0.0f);
  for (std::size_t i = 0; i < views.size(); ++i) {
    sum += views[i].direction;
    float nearest = -1.0f;
    for (std::size_t j = 0; j < views.size(); ++j)
      if (j != i) nearest = std::max(nearest, glm::dot(views[i].direction, views[j].direction));
    EXPECT_LT(nearest, std::cos(0.2f)) << i;
    EXPECT_GT(nearest, std::cos(0.6f)) << i;
  }
  EXPECT_LT(glm::length(sum) / 100.0f, 0.02f);
}

TEST(Viewpoints, ViewsFromThePolesHaveAxes) {
  for (const float y : {-1.0f, 1.0f}) {
    const Viewpoint view = viewpoint_towards({0.0f, y, 0.0f});
    EXPECT_NEAR(glm::distance(view.up, glm::vec3(0, 0, 1)), 0.0f, 1e-6f);
    EXPECT_NEAR(glm::distance(glm::cross(view.right, view.up), view.direction), 0.0f, 1e-6f);
  }
}

TEST(Viewpoints, CountsOutOfRangeAreRejected) {
  for (const std::uint32_t count : {0u, 1025u, 0xffffffffu}) EXPECT_EQ(viewpoints(count).error().status, Status::invalid_argument);
}

TEST(BoundingSphere, IsAboutTheBoxCentreAndReachesTheFarthestVertex) {
  const Foliage foliage =
      test::plain_foliage({test::rectangle({0, 0, 0}, {4, 0, 0}, {0, 2, 0}), test::rectangle({1, 1, 4}, {1, 0, 0}, {0, 1, 0})});
  const Sphere sphere = bounding_sphere(foliage);
  EXPECT_EQ(sphere.center, glm::vec3(2, 1, 2));
  EXPECT_FLOAT_EQ(sphere.radius, 3.0f);  // to (0, 0, 0): sqrt(4 + 1 + 4)
  EXPECT_EQ(bounding_sphere(Foliage{}).radius, 0.0f);
}

using Pixel = std::pair<std::int32_t, std::int32_t>;

/// Looks along -Z at the square [-1, 1]^2: px_per_metre is resolution / 2 when the bounding sphere has radius 1.
Projection front_view(std::uint32_t resolution_px) {
  return make_projection(viewpoint_towards({0, 0, 1}), Sphere{glm::vec3(0), 1.0f}, resolution_px);
}

std::map<Pixel, int> coverage(const ProjectedQuad& quad, std::int32_t resolution_px) {
  std::map<Pixel, int> count;
  rasterise_quad(
      quad, resolution_px, [](const auto&, auto, auto, auto) { return true; },
      [&](const QuadFragment& f) {
        ++count[{f.x, f.y}];
      });
  return count;
}

/// The fill rule once more, the slow way: a centre on an edge is inside if it would be after a nudge by less than any grid step to the
/// right, and by much less still downwards. Coordinates below 4096.
bool inside(const ProjectedPoint& a, const ProjectedPoint& b, const ProjectedPoint& c, Pixel pixel) {
  constexpr std::int64_t kSubpixel = std::int64_t{1} << 26, kNudgeRight = 1 << 13, kNudgeDown = 1;
  const std::int64_t px = (pixel.first * 256 + 128) * kSubpixel + kNudgeRight, py = (pixel.second * 256 + 128) * kSubpixel + kNudgeDown;
  const auto side = [&](const ProjectedPoint& from, const ProjectedPoint& to) {
    const std::int64_t value = (to.x - from.x) * (py - from.y * kSubpixel) - (to.y - from.y) * (px - from.x * kSubpixel);
    return value > 0 ? 1 : value < 0 ? -1 : 0;
  };
  const int ab = side(a, b), bc = side(b, c), ca = side(c, a);
  return ab != 0 && ab == bc && bc == ca;
}

TEST(Raster, CoverageFollowsTheFillRuleExactly) {
  std::mt19937 random(1);
  for (int round = 0; round < 3000; ++round) {
    // Multiples of 64 subpixels put many vertices and edges exactly on pixel centres.
    const std::int32_t grid = round % 2 == 0 ? 64 : 1;
    ProjectedQuad quad;
    for (ProjectedPoint& p : quad)
      p = {static_cast<std::int32_t>(random() % (4096u / static_cast<unsigned>(grid))) * grid,
           static_cast<std::int32_t>(random() % (4096u / static_cast<unsigned>(grid))) * grid, 0.0};
    const auto covered = coverage(quad, 16);
    for (std::int32_t y = 0; y < 16; ++y) {
      for (std::int32_t x = 0; x < 16; ++x) {
        const bool expected = inside(quad[0], quad[1], quad[2], {x, y}) || inside(quad[0], quad[2], quad[3], {x, y});
        const auto found = covered.find({x, y});
        ASSERT_EQ(found == covered.end() ? 0 : found->second, expected ? 1 : 0) << "round " << round << " pixel " << x << ", " << y;
      }
    }
  }
}

/// Each pixel of each row in one run, never an empty one; folded where each triangle alone covers it too.
TEST(Raster, RunsAreThePixelsOfBothTriangles) {
  const auto pixels_of = [](const ProjectedQuad& quad) { return coverage(quad, 16); };
  std::mt19937 random(2);
  for (int round = 0; round < 2000; ++round) {
    ProjectedQuad quad;
    for (ProjectedPoint& p : quad)
      p = {static_cast<std::int32_t>(random() % 6000) - 1000, static_cast<std::int32_t>(random() % 6000) - 1000, 0.0};
    const auto first = pixels_of({quad[0], quad[1], quad[2], quad[0]}), second = pixels_of({quad[0], quad[0], quad[2], quad[3]});
    std::map<Pixel, int> runs;
    for_each_run(RasterQuad(quad), 16, [&](const PixelRun& run) {
      ASSERT_LE(run.first, run.last);
      for (std::int32_t x = run.first; x <= run.last; ++x) {
        const bool in_first = first.count({x, run.y}) > 0, in_second = second.count({x, run.y}) > 0;
        ASSERT_EQ(run.folded, in_first && in_second) << "round " << round << " pixel " << x << ", " << run.y;
        ASSERT_TRUE(run.folded || (run.triangle == 0 ? in_first : in_second)) << "round " << round << " pixel " << x << ", " << run.y;
        ++runs[{x, run.y}];
      }
    });
    ASSERT_EQ(runs, pixels_of(quad)) << "round " << round;
    for (const auto& [pixel, count] : first) ASSERT_EQ(runs.count(pixel), 1u);
    for (const auto& [pixel, count] : second) ASSERT_EQ(runs.count(pixel), 1u);
  }
}

TEST(Raster, NearerIsASmallerDepth) {
  std::mt19937 random(3);
  for (int round = 0; round < 500; ++round) {
    std::array<ProjectedPoint, 3> corners;
    for (ProjectedPoint& p : corners)
      p = {static_cast<std::int32_t>(random() % 4096), static_cast<std::int32_t>(random() % 4096),
           static_cast<double>(random()) * (kDepthSteps / 4294967296.0)};
    const RasterTriangle triangle(corners[0], corners[1], corners[2]);
    for (std::int32_t y = triangle.first_row(); y <= triangle.last_row(); ++y) {
      const DepthRow depths = triangle.depths(y);
      const Span span = triangle.row(y, 16);
      for (std::int32_t x = span.first; x <= span.last; ++x) {
        const std::uint32_t depth = triangle.depth(x, y);
        EXPECT_FALSE(depths.is_nearer(x, depth));
        EXPECT_TRUE(depths.is_nearer(x, depth + 1));
        EXPECT_TRUE(depths.is_nearer(x, 0xffffffffu));
      }
    }
  }
}

TEST(Raster, APixelCentreOnASharedEdgeBelongsToOneOfTwoQuads) {
  // 8 x 8 pixels; the shared edge is column 2.5, through the centres of pixels (2, y).
  const auto quad = [](std::int32_t left, std::int32_t right) {
    return ProjectedQuad{ProjectedPoint{left, 0, 0}, {right, 0, 0}, {right, 2048, 0}, {left, 2048, 0}};
  };
  const auto left = coverage(quad(0, 640), 8), right = coverage(quad(640, 2048), 8);
  EXPECT_EQ(left.size(), 2u * 8u);
  EXPECT_EQ(right.size(), 6u * 8u);
  for (const auto& [pixel, count] : left) EXPECT_EQ(right.count(pixel), 0u);
}

TEST(Raster, ProjectionPutsRowZeroAtTheTop) {
  const Projection projection = front_view(4);
  // The upper right quarter of the image.
  const auto covered = coverage(project(projection, test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})), 4);
  ASSERT_EQ(covered.size(), 4u);
  for (const auto& [pixel, count] : covered) {
    EXPECT_GE(pixel.first, 2);
    EXPECT_LE(pixel.second, 1);
  }
}

TEST(Raster, DepthRunsFromTheNearToTheFarEndOfTheSphere) {
  const Projection projection = front_view(4);
  EXPECT_EQ(project(projection, glm::vec3(0, 0, 1)).depth, 0.0);
  EXPECT_EQ(project(projection, glm::vec3(0, 0, -1)).depth, kDepthSteps);
  // A quad that leans back to the right: at pixel column x its depth is that of world x = (x + 0.5) / 2 - 1.
  const ProjectedQuad leaning = project(projection, Quad{glm::vec3(-1, -1, 1), {-1, 1, 1}, {1, 1, -1}, {1, -1, -1}});
  rasterise_quad(
      leaning, 4, [](const auto&, auto, auto, auto) { return true; },
      [&](const QuadFragment& f) { EXPECT_EQ(f.depth, (f.x + 0.5) / 4 * kDepthSteps) << f.x << ", " << f.y; });
}

TEST(Raster, APerspectiveViewHoldsTheSphereExactly) {
  Viewpoint view = viewpoint_towards({0, 0, 1});
  view.distance_radii = 3.0f;
  const Projection projection = make_projection(view, Sphere{glm::vec3(0), 1.0f}, 256);
  // The sight line that touches the sphere does so 1/3 from the middle towards the eye, sqrt(8)/3 off its axis.
  const ProjectedPoint touched = project(projection, glm::vec3(std::sqrt(8.0f) / 3, 0, 1.0f / 3));
  EXPECT_NEAR(touched.x, 256 * 256, 1);
  EXPECT_EQ(touched.y, 128 * 256);
  // In the plane through the middle a metre is sqrt(8) * 128 / 3 px, and nearer by a metre sqrt(8) * 128 / 2.
  EXPECT_NEAR(project(projection, glm::vec3(0, 0.5f, 0)).y, (128 - 0.5 * std::sqrt(8.0) * 128 / 3) * 256, 1);
  EXPECT_NEAR(project(projection, glm::vec3(0, 0.5f, 1)).y, (128 - 0.5 * std::sqrt(8.0) * 128 / 2) * 256, 1);
  EXPECT_NEAR(project(projection, glm::vec3(0, 0, 1)).depth, 0.0, 1e-3);
  EXPECT_NEAR(project(projection, glm::vec3(0, 0, -1)).depth, kDepthSteps, 1e-3);
  // Depth is a line in the picture: halfway between a near and a far corner's images it is halfway between theirs.
  const ProjectedPoint near = project(projection, glm::vec3(-0.5f, 0, 0.5f)), far = project(projection, glm::vec3(0.7f, 0, -0.5f));
  const glm::dvec2 from(-0.5 / 2.5, 1 / 2.5), to(0.7 / 3.5, 1 / 3.5), middle = 0.5 * (from + to);
  const glm::vec3 between(static_cast<float>(middle.x / middle.y), 0, static_cast<float>(3 - 1 / middle.y));
  EXPECT_NEAR(project(projection, between).depth, 0.5 * (near.depth + far.depth), 1000.0);
}

TEST(Raster, AFoldedQuadShowsItsNearerTriangleOnce) {
  // Triangle (0, 1, 2) is at depth 100, and (0, 2, 3) folds back over it, nearer towards corner 3.
  const ProjectedQuad folded{ProjectedPoint{0, 0, 100}, {2048, 0, 100}, {2048, 2048, 100}, {2048, 512, 20}};
  std::map<Pixel, QuadFragment> seen;
  rasterise_quad(
      folded, 8, [](const auto&, auto, auto, auto) { return true; },
      [&](const QuadFragment& f) {
        EXPECT_TRUE(seen.insert({{f.x, f.y}, f}).second);
      });
  EXPECT_EQ(seen.at({7, 3}).triangle, 1u);
  EXPECT_LT(seen.at({7, 3}).depth, 100u);
  EXPECT_EQ(seen.at({7, 0}).triangle, 0u);  // above the fold
}

TEST(Raster, EdgeOnAndPointQuadsCoverNothing) {
  const Projection projection = front_view(64);
  EXPECT_TRUE(coverage(project(projection, test::rectangle({-1, 0, -1}, {2, 0, 0}, {0, 0, 2})), 64).empty());
  EXPECT_TRUE(coverage(project(projection, test::rectangle({0.1f, 0.1f, 0}, {0, 0, 0}, {0, 0, 0})), 64).empty());
}

/// Two unit squares stacked along Z over a bounding sphere that they share; the view from +Z sees the upper one only.
TEST(ItemBuffers, TheNearerLeafIsInFrontAndTheOtherStaysInTheList) {
  const Foliage foliage =
      test::plain_foliage({test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), test::rectangle({0, 0, 1}, {1, 0, 0}, {0, 1, 0})});
  const std::vector<Viewpoint> views{viewpoint_towards({0, 0, 1}), viewpoint_towards({0, 0, -1}), viewpoint_towards({1, 0, 0})};
  const auto buffers = test::must(render_item_buffers({foliage, test::plain_materials(), {}}, views, 64));
  const std::vector<std::uint32_t> areas = leaf_areas_px(buffers);
  // The sphere about the unit cube has radius sqrt(3) / 2, so a unit is 64 / sqrt(3) = 36.95 px, from 13.52 to 50.48: centres 14 .. 49.
  EXPECT_EQ(areas, (std::vector<std::uint32_t>{0, 36 * 36, 36 * 36, 0, 0, 0}));
  EXPECT_EQ(background_areas_px(buffers), (std::vector<std::uint32_t>{64 * 64 - 36 * 36, 64 * 64 - 36 * 36, 64 * 64}));
  const auto middle = buffers.at(0, 32 * 64 + 32);
  ASSERT_EQ(middle.size(), 2u);
  EXPECT_EQ(fragment_leaf(middle[0]), 1u);
  EXPECT_EQ(fragment_leaf(middle[1]), 0u);
}

TEST(ItemBuffers, EqualDepthsGoToTheSmallerId) {
  const Quad square = test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const auto buffers = test::must(
      render_item_buffers({test::plain_foliage({square, square}), test::plain_materials(), {}}, {viewpoint_towards({0, 0, 1})}, 32));
  const std::vector<std::uint32_t> areas = leaf_areas_px(buffers);
  EXPECT_GT(areas[0], 0u);
  EXPECT_EQ(areas[1], 0u);
}

/// The left half of the image is transparent; the uvs run over two repeats, so holes alternate with leaf four times.
TEST(ItemBuffers, MaskedTexelsAreHoles) {
  Foliage foliage = test::plain_foliage({test::rectangle({-1, -1, 0}, {0, 2, 0}, {2, 0, 0})});
  foliage.card_table[0].uv = {glm::vec2(0, 1), glm::vec2(0, 0), glm::vec2(2, 0), glm::vec2(2, 1)};
  const Image image{2, 1, {255, 255, 255, 0, 255, 255, 255, 255}};
  std::vector<Material> materials = test::plain_materials();
  materials[0].image = 0;
  const std::vector<Viewpoint> views{viewpoint_towards({0, 0, 1})};
  const auto opaque = render_item_buffers({foliage, materials, {image}}, views, 64);
  materials[0].alpha_cutoff = 0.5f;
  const auto masked = render_item_buffers({foliage, materials, {image}}, views, 64);
  ASSERT_TRUE(opaque);
  ASSERT_TRUE(masked);
  // The square is 64 / sqrt(2) = 45.25 px wide, from 9.37 to 54.63: centres 9 .. 54 and a repeat of 22.63 px.
  EXPECT_EQ(leaf_areas_px(*opaque)[0], 46u * 46u);
  for (std::uint32_t x = 0; x < 64; ++x) {
    const double u = (x + 0.5 - (32 - 22.627417)) / 22.627417;
    const bool expected = u >= 0 && u < 2 && u - std::floor(u) >= 0.5;
    EXPECT_EQ(!masked->at(0, 32 * 64 + x).empty(), expected) << x;
  }
}

TEST(ItemBuffers, BadInputIsRejected) {
  const Foliage good = test::plain_foliage({test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})});
  const std::vector<Viewpoint> views{viewpoint_towards({0, 0, 1})};
  const auto status = [&](const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Viewpoint>& v,
                          std::uint32_t px) {
    const auto buffers = render_item_buffers({foliage, materials, {}}, v, px);
    return buffers ? Status::ok : buffers.error().status;
  };
  EXPECT_EQ(status(good, test::plain_materials(), views, 16), Status::ok);
  EXPECT_EQ(status(Foliage{}, test::plain_materials(), views, 16), Status::invalid_argument);
  EXPECT_EQ(status(good, {}, views, 16), Status::invalid_argument);
  EXPECT_EQ(status(good, test::plain_materials(), {}, 16), Status::invalid_argument);
  EXPECT_EQ(status(good, test::plain_materials(), views, 0), Status::invalid_argument);
  EXPECT_EQ(status(good, test::plain_materials(), views, 2049), Status::invalid_argument);
  Foliage bad = good;
  bad.cards[0] = 1;
  EXPECT_EQ(status(bad, test::plain_materials(), views, 16), Status::invalid_argument);
  bad = good;
  bad.quads[0][2].y = std::nanf("");
  EXPECT_EQ(status(bad, test::plain_materials(), views, 16), Status::invalid_argument);
  std::vector<Material> masked = test::plain_materials();
  masked[0].alpha_cutoff = 0.5f;
  masked[0].image = 3;
  EXPECT_EQ(status(good, masked, views, 16), Status::invalid_argument);
}

}  // namespace coppice::bake::visibility_test
