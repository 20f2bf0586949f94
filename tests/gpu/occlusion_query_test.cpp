// The baker's item-buffer areas against the paper's own measurement: Vulkan occlusion queries, N_l + 1 passes per view.
//
// Both rasterisers sample pixel centres, break ties by the top-left rule and round corners to 1/256 px (Vulkan's subPixelPrecisionBits is
// at least 4; lavapipe's is 8). They differ where float rounding moves a corner by 1/256 px, which can only matter for pixel centres that
// close to an edge or that close to the edge of a masked texel, and where two leaves are at the same depth to within the depth buffer's
// resolution. So a leaf's two areas may differ by a small share of the pixels along its outline and kSlackPx, and a view's
// foliage area by kTotalShare and kTotalSlackPx. The bounds are under twice what was measured; the last test shows that a wrong
// camera is outside them.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "generate_plant.h"
#include "leaf_quads.h"
#include "occlusion_areas.h"
#include "viewpoints.h"
#include "visibility.h"

namespace {

using coppice::bake::Foliage;
using coppice::bake::ItemBuffers;
using coppice::bake::Sphere;
using coppice::bake::Viewpoint;

constexpr std::uint32_t kSidePx = 256;
constexpr double kOutlineShare = 0.02;        // of an opaque leaf
constexpr double kMaskedOutlineShare = 0.05;  // its mask has an outline of its own, in texels: longer than the quad's
constexpr double kSlackPx = 1.0;
constexpr double kTotalShare = 0.001;
constexpr double kTotalSlackPx = 3.0;  // where a rectangle shows little of the plant

constexpr VkRect2D kWholeImage{{0, 0}, {kSidePx, kSidePx}};
/// Neither symmetric about the middle column, nor the middle row, nor the diagonals: a mirrored or turned image does not fit.
constexpr VkRect2D kOneCorner{{0, 0}, {kSidePx / 2, kSidePx / 3}};

/// The camera of Viewpoint's contract, written down a second time from the prose of viewpoints.h: orthographic, the sphere touches all four
/// sides, rows go down.
glm::mat4 clip_from_object(const Viewpoint& view, const Sphere& sphere) {
  const glm::vec3 x = view.right / sphere.radius;
  const glm::vec3 y = -view.up / sphere.radius;
  const glm::vec3 z = -0.5f * view.direction / sphere.radius;
  glm::mat4 clip(1.0f);
  for (int axis = 0; axis < 3; ++axis) clip[axis] = glm::vec4(x[axis], y[axis], z[axis], 0.0f);
  clip[3] = glm::vec4(-glm::dot(x, sphere.center), -glm::dot(y, sphere.center), 0.5f - glm::dot(z, sphere.center), 1.0f);
  return clip;
}

/// The leaves as the GPU is to draw them. Leaves of one material: its mask is worked out here a second time.
coppice::test::MaskedQuads masked_quads(const Foliage& foliage, const std::vector<coppice::bake::Material>& materials,
                                        const std::vector<coppice::bake::Image>& images) {
  coppice::test::MaskedQuads quads;
  for (std::size_t leaf = 0; leaf < foliage.quads.size(); ++leaf) {
    const coppice::bake::Card& card = foliage.card_table[foliage.cards[leaf]];
    if (card.material != foliage.card_table[0].material) throw std::runtime_error("leaves of one material wanted");
    quads.corners.insert(quads.corners.end(), foliage.quads[leaf].begin(), foliage.quads[leaf].end());
    quads.uvs.insert(quads.uvs.end(), card.uv.begin(), card.uv.end());
  }
  const coppice::bake::Material& material = materials[foliage.card_table[0].material];
  if (material.alpha_cutoff == 0.0f || material.image == coppice::bake::kNone) return quads;
  const coppice::bake::Image& image = images[material.image];
  quads.mask_width = image.width;
  quads.mask_height = image.height;
  for (std::size_t texel = 0; texel < image.rgba.size() / 4; ++texel) {
    const float alpha = material.base_color.a * static_cast<float>(image.rgba[4 * texel + 3]) / 255.0f;
    quads.holes.push_back(alpha < material.alpha_cutoff ? 1 : 0);
  }
  return quads;
}

/// Pixels of `counted` in which each leaf is in front, from the baker's item buffer of one view.
std::vector<std::uint32_t> item_buffer_areas(const ItemBuffers& buffers, std::uint32_t view, const VkRect2D& counted) {
  std::vector<std::uint32_t> areas(buffers.leaf_count);
  for (std::uint32_t y = 0; y < counted.extent.height; ++y) {
    for (std::uint32_t x = 0; x < counted.extent.width; ++x) {
      const auto fragments = buffers.at(view, y * buffers.resolution_px + x);
      if (!fragments.empty()) ++areas[coppice::bake::fragment_leaf(fragments.front())];
    }
  }
  return areas;
}

/// Length of the projected outline in pixels.
double outline_px(const coppice::bake::Quad& quad, const Viewpoint& view, const Sphere& sphere) {
  double length = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::vec3 edge = quad[(i + 1) % 4] - quad[i];
    length += std::hypot(glm::dot(edge, view.right), glm::dot(edge, view.up));
  }
  return length * kSidePx / (2.0 * sphere.radius);
}

struct Case {
  Foliage foliage;
  coppice::test::MaskedQuads quads;  ///< the same for the GPU
  std::vector<coppice::bake::Material> materials;
  std::vector<coppice::bake::Image> images;
  std::vector<Viewpoint> views;
  Sphere sphere;
  ItemBuffers buffers;
};

/// How far two measurements of one view's areas are apart.
struct Disagreement {
  std::uint32_t leaves_out_of_bounds = 0;
  std::uint64_t total_px = 0;  ///< of the item buffer
  bool total_in_bounds = false;
  double total_share = 0.0;               ///< |difference of the totals| / total
  double sum_of_differences_share = 0.0;  ///< sum over leaves of |difference| / total
  double largest_over_bound = 0.0;        ///< largest |difference| as a multiple of its bound
};

Disagreement compare(const Case& c, const Viewpoint& view, const std::vector<std::uint32_t>& baker,
                     const std::vector<std::uint32_t>& queries) {
  Disagreement result;
  double differences = 0.0;
  const double outline_share = c.quads.holes.empty() ? kOutlineShare : kMaskedOutlineShare;
  for (std::size_t leaf = 0; leaf < c.foliage.quads.size(); ++leaf) {
    const double difference = std::abs(static_cast<double>(baker[leaf]) - static_cast<double>(queries[leaf]));
    const double bound = outline_share * outline_px(c.foliage.quads[leaf], view, c.sphere) + kSlackPx;
    result.leaves_out_of_bounds += difference > bound ? 1u : 0u;
    result.largest_over_bound = std::max(result.largest_over_bound, difference / bound);
    differences += difference;
  }
  result.total_px = std::accumulate(baker.begin(), baker.end(), std::uint64_t{0});
  const auto total = static_cast<double>(result.total_px);
  result.total_share = std::abs(total - std::accumulate(queries.begin(), queries.end(), 0.0)) / total;
  result.total_in_bounds = result.total_share * total <= kTotalShare * total + kTotalSlackPx;
  result.sum_of_differences_share = differences / total;
  return result;
}

bool agrees(const Disagreement& d) {
  return d.leaves_out_of_bounds == 0 && d.total_in_bounds;
}

Case make_case(Foliage foliage, std::vector<coppice::bake::Material> materials, std::vector<coppice::bake::Image> images) {
  Case c{std::move(foliage), {}, std::move(materials), std::move(images), *coppice::bake::viewpoints(20), {}, {}};
  c.quads = masked_quads(c.foliage, c.materials, c.images);
  c.sphere = coppice::bake::bounding_sphere(c.foliage);
  auto buffers = coppice::bake::render_item_buffers({c.foliage, c.materials, c.images}, c.views, kSidePx);
  if (!buffers) throw std::runtime_error(buffers.error().message());
  c.buffers = *std::move(buffers);
  return c;
}

Case corylus() {
  const auto plant = coppice::bake::generate_plant("corylus", 1);
  if (!plant) throw std::runtime_error(plant.error().message());
  auto foliage = coppice::bake::fit_leaf_quads(*plant);
  if (!foliage) throw std::runtime_error(foliage.error().message());
  return make_case(*std::move(foliage), plant->materials, plant->images);
}

/// Rectangles of every size and direction that cut through each other: harder on depth than a plant.
Case random_rectangles(std::uint32_t count) {
  std::mt19937 random(7);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() & 0xffffffu) / static_cast<float>(0x1000000);
  };
  const auto direction = [&] {
    for (;;) {
      const glm::vec3 v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      if (glm::length(v) > 0.1f && glm::length(v) < 1.0f) return glm::normalize(v);
    }
  };
  Foliage foliage;
  foliage.card_table.emplace_back();
  for (std::uint32_t i = 0; i < count; ++i) {
    const glm::vec3 center(uniform(-3, 3), uniform(2, 6), uniform(-3, 3));
    const glm::vec3 along = direction() * uniform(0.02f, 0.5f);
    const glm::vec3 across = glm::normalize(glm::cross(along, direction())) * uniform(0.01f, 0.3f);
    foliage.quads.push_back({center - along - across, center + along - across, center + along + across, center - along + across});
    foliage.cards.push_back(0);
  }
  return make_case(std::move(foliage), {coppice::bake::Material{}}, {});
}

class OcclusionQueryTest : public coppice::test::VulkanTest {
 protected:
  static Disagreement measure(const Case& c, std::uint32_t view, const Viewpoint& camera, const Sphere& sphere, const VkRect2D& counted) {
    const auto queries = coppice::test::occlusion_areas(gpu(), masked_quads(c.foliage, c.materials, c.images),
                                                        clip_from_object(camera, sphere), kSidePx, counted);
    return compare(c, c.views[view], item_buffer_areas(c.buffers, view, counted), queries);
  }

  static void expect_agreement_in_every_view(const Case& c) {
    double worst = 0.0, worst_total = 0.0, worst_sum = 0.0;
    for (std::uint32_t view = 0; view < c.views.size(); ++view) {
      for (const VkRect2D& counted : {kWholeImage, kOneCorner}) {
        const Disagreement d = measure(c, view, c.views[view], c.sphere, counted);
        EXPECT_EQ(d.leaves_out_of_bounds, 0u) << "view " << view;
        EXPECT_TRUE(d.total_in_bounds) << "view " << view << ": " << 100.0 * d.total_share << "% of " << d.total_px << " px";
        EXPECT_GT(d.total_px, 100u) << "view " << view << " shows no leaves: nothing was compared";
        worst = std::max(worst, d.largest_over_bound);
        worst_total = std::max(worst_total, d.total_share);
        worst_sum = std::max(worst_sum, d.sum_of_differences_share);
      }
    }
    std::printf("largest difference of a leaf: %.3f of its bound; of a total: %.5f%%; sum of leaf differences: %.4f%% of the area\n", worst,
                100.0 * worst_total, 100.0 * worst_sum);
  }
};

TEST_F(OcclusionQueryTest, CorylusAreasAgreeInAllViews) {
  expect_agreement_in_every_view(corylus());
}

TEST_F(OcclusionQueryTest, CrossingRectanglesAgreeInAllViews) {
  expect_agreement_in_every_view(random_rectangles(300));
}

TEST_F(OcclusionQueryTest, AWrongCameraIsOutOfBounds) {
  const Case c = corylus();
  for (std::uint32_t view = 0; view < c.views.size(); view += 3) {
    const Viewpoint& right_camera = c.views[view];
    ASSERT_TRUE(agrees(measure(c, view, right_camera, c.sphere, kWholeImage)));

    Viewpoint from_behind = right_camera;
    from_behind.direction = -from_behind.direction;
    EXPECT_FALSE(agrees(measure(c, view, from_behind, c.sphere, kWholeImage))) << "view " << view;
    EXPECT_FALSE(agrees(measure(c, view, c.views[(view + 1) % c.views.size()], c.sphere, kWholeImage))) << "view " << view;
    Sphere larger = c.sphere;
    larger.radius *= 1.005f;
    EXPECT_FALSE(agrees(measure(c, view, right_camera, larger, kWholeImage))) << "view " << view;

    // A mirrored or turned image has the same areas: only a part of it tells.
    Viewpoint mirrored = right_camera;
    mirrored.right = -mirrored.right;
    EXPECT_FALSE(agrees(measure(c, view, mirrored, c.sphere, kOneCorner))) << "view " << view;
    Viewpoint upside_down = right_camera;
    upside_down.up = -upside_down.up;
    EXPECT_FALSE(agrees(measure(c, view, upside_down, c.sphere, kOneCorner))) << "view " << view;
  }
}

}  // namespace
