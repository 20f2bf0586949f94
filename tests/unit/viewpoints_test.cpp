#include "viewpoints.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake {
namespace viewpoints_test {

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

}  // namespace viewpoints_test
}  // namespace coppice::bake
