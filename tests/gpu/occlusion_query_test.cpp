// Areas by occlusion queries against item buffers: the paper's own measurement and the baker's, each a check of the other.
//
// Both rasterisers sample pixel centres, break ties by the top-left rule and round corners to 1/256 px (Vulkan's subPixelPrecisionBits is
// at least 4; lavapipe's is 8). They differ where float rounding moves a corner by 1/256 px, which can only matter for pixel centres that
// close to an edge or that close to the edge of a masked texel, and where two leaves are at the same depth to within the depth buffer's
// resolution. So a leaf's two areas may differ by a small share of the pixels along its outline and kSlackPx, and a view's
// foliage area by kTotalShare and kTotalSlackPx. The bounds are under twice what was measured; a test shows that a wrong camera is
// outside them.

#include "occlusion_areas.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "area_device.h"
#include "bounds.h"
#include "collapse_information.h"
#include "generate_plant.h"
#include "item_areas.h"
#include "leaf_cards.h"
#include "leaf_quads.h"
#include "test_foliage.h"
#include "viewpoints.h"
#include "visibility.h"
#include "vulkan_device.h"

namespace coppice::bake {
namespace occlusion_query_test {

constexpr std::uint32_t kSidePx = 256;
constexpr double kOutlineShare = 0.02;        // where a leaf is opaque
constexpr double kMaskedOutlineShare = 0.05;  // its mask has an outline of its own, in texels: longer than the quad's
constexpr double kGridOutlineShare = 0.1;     // holes all over it
constexpr double kSlackPx = 1.0;
constexpr double kTotalShare = 0.001;
constexpr double kTotalSlackPx = 3.0;

/// Leaves, what they show, and where they are looked at from.
struct Case {
  Foliage foliage;
  std::vector<Material> materials{Material{}};
  std::vector<Image> images;
  std::vector<Viewpoint> views = *viewpoints(20);
  std::uint32_t side_px = kSidePx;
  double outline_share = kOutlineShare;

  [[nodiscard]] ShownFoliage shown() const { return {foliage, materials, images}; }
};

/// [(leaf_count + 1) * view_count] row per leaf, the background's last, px.
using Areas = std::vector<std::uint32_t>;

Areas item_buffer_areas(const Case& c) {
  const auto buffers = render_item_buffers(c.shown(), c.views, c.side_px);
  if (!buffers) throw std::runtime_error(buffers.error().message());
  const std::vector<std::uint32_t> fronts = leaf_areas_px(*buffers), behind = background_areas_px(*buffers);
  Areas areas;
  for (std::size_t leaf = 0; leaf <= c.foliage.quads.size(); ++leaf)
    for (std::size_t v = 0; v < c.views.size(); ++v)
      areas.push_back(leaf < c.foliage.quads.size() ? fronts[v * c.foliage.quads.size() + leaf] : behind[v]);
  return areas;
}

/// Length of the projected outline in pixels.
double outline_px(const Quad& quad, const Projection& projection) {
  const ProjectedQuad corners = project(projection, quad);
  double length = 0.0;
  for (std::size_t i = 0; i < 4; ++i)
    length += std::hypot(corners[(i + 1) % 4].x - corners[i].x, corners[(i + 1) % 4].y - corners[i].y) / kSubpixels;
  return length;
}

/// How far two measurements of one view's areas are apart.
struct Disagreement {
  std::uint32_t leaves_out_of_bounds = 0;
  std::uint64_t total_px = 0;  ///< what the item buffer has
  bool total_in_bounds = false;
  double background_px = 0.0;  ///< |difference|
  double ties_px = 0.0;        ///< leaves that the queries have in front of a pixel above one. Below 0: depths of two draws differ
};

Disagreement compare(const Case& c, std::size_t view, const Areas& buffers, const Areas& queries) {
  Disagreement result;
  const Projection projection = make_projection(c.views[view], bounding_sphere(c.foliage), c.side_px);
  double total = 0.0, query_total = 0.0;
  for (std::size_t leaf = 0; leaf < c.foliage.quads.size(); ++leaf) {
    const double a = buffers[leaf * c.views.size() + view], b = queries[leaf * c.views.size() + view];
    const double bound = c.outline_share * outline_px(c.foliage.quads[leaf], projection) + kSlackPx;
    result.leaves_out_of_bounds += std::abs(a - b) > bound ? 1u : 0u;
    total += a;
    query_total += b;
  }
  const std::size_t background = c.foliage.quads.size() * c.views.size() + view;
  result.background_px = std::abs(static_cast<double>(buffers[background]) - static_cast<double>(queries[background]));
  result.ties_px = query_total + queries[background] - static_cast<double>(c.side_px) * c.side_px;
  result.total_px = static_cast<std::uint64_t>(total);
  result.total_in_bounds = std::abs(total - query_total) <= kTotalShare * total + kTotalSlackPx;
  return result;
}

bool agrees(const Disagreement& d) {
  return d.leaves_out_of_bounds == 0 && d.total_in_bounds;
}

enum class Leaves { plain, cards };

/// cards: as it is baked, each leaf shows a card of an atlas, with its outline as holes
Case corylus(Leaves leaves) {
  auto plant = generate_plant("corylus", 1);
  if (!plant) throw std::runtime_error(plant.error().message());
  auto foliage = leaves == Leaves::cards ? card_foliage(*plant) : fit_leaf_quads(*plant);
  if (!foliage) throw std::runtime_error(foliage.error().message());
  Case c{*std::move(foliage), std::move(plant->materials), std::move(plant->images)};
  c.outline_share = kMaskedOutlineShare;
  return c;
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
  return {std::move(foliage)};
}

class OcclusionQueryTest : public test::VulkanTest {
 protected:
  /// On the test's device, under validation.
  static std::unique_ptr<OcclusionAreas> queries_of(const Case& c, const std::vector<Viewpoint>& views) {
    auto device = borrow_area_device({gpu().instance, gpu().physical_device, gpu().device, gpu().queue, gpu().queue_family});
    auto queries = OcclusionAreas::create({c.shown(), views, c.side_px}, std::move(device));
    if (!queries) throw std::runtime_error(queries.error().message());
    return *std::move(queries);
  }

  static Areas query_areas(const Case& c, const std::vector<Viewpoint>& views) {
    Areas areas((c.foliage.quads.size() + 1) * views.size(), 12345);  // whatever is there is overwritten
    const auto queries = queries_of(c, views);
    if (const auto done = queries->measure({c.foliage.quads, c.foliage.cards, {}}, areas, {}); !done)
      throw std::runtime_error(done.error().message());
    return areas;
  }

  static void expect_agreement_in_every_view(const Case& c) {
    const Areas buffers = item_buffer_areas(c), queries = query_areas(c, c.views);
    for (std::size_t view = 0; view < c.views.size(); ++view) {
      const Disagreement d = compare(c, view, buffers, queries);
      EXPECT_EQ(d.leaves_out_of_bounds, 0u) << "view " << view;
      EXPECT_TRUE(d.total_in_bounds) << "view " << view << " of " << d.total_px << " px";
      EXPECT_LE(d.background_px, kTotalShare * static_cast<double>(d.total_px) + kTotalSlackPx) << "view " << view;
      EXPECT_GE(d.ties_px, 0.0) << "view " << view << " has pixels that are neither a leaf's nor the background's";
      EXPECT_LE(d.ties_px, 1.0) << "view " << view;
      EXPECT_GT(d.total_px, 100u) << "view " << view << " shows no leaves: nothing was compared";
    }
  }
};

TEST_F(OcclusionQueryTest, CorylusAreasAgreeInAllViews) {
  expect_agreement_in_every_view(corylus(Leaves::plain));
}

TEST_F(OcclusionQueryTest, CorylusWithCardsAgreesInAllViews) {
  const Case c = corylus(Leaves::cards);
  ASSERT_FALSE(c.images.empty());
  expect_agreement_in_every_view(c);
}

TEST_F(OcclusionQueryTest, CrossingRectanglesAgreeInAllViews) {
  expect_agreement_in_every_view(random_rectangles(300));
}

TEST_F(OcclusionQueryTest, PerspectiveAgrees) {
  for (Case c : {corylus(Leaves::cards), random_rectangles(300)}) {
    for (Viewpoint& view : c.views) view.distance_radii = 2.5f;
    expect_agreement_in_every_view(c);
  }
}

/// Two materials with holes, of odd sizes, and one without; coordinates that repeat the image.
TEST_F(OcclusionQueryTest, EachLeafHasTheHolesOfItsMaterial) {
  Case c = random_rectangles(200);
  c.outline_share = kGridOutlineShare;
  c.materials.resize(3);
  for (std::uint32_t i = 0; i < 2; ++i) {
    Image image{7 + 6 * i, 5 + 4 * i, {}};
    for (std::uint32_t texel = 0; texel < image.width * image.height; ++texel)
      image.rgba.insert(image.rgba.end(), {255, 255, 255, static_cast<std::uint8_t>((texel * 7 + i) % 3 == 0 ? 0 : 255)});
    c.images.push_back(std::move(image));
    c.materials[1 + i].image = i;
    c.materials[1 + i].alpha_cutoff = 0.5f;
    c.foliage.card_table.push_back({1 + i, {glm::vec2(-0.3f, 0.1f), {1.7f, 0.1f}, {1.7f, 2.2f}, {-0.3f, 2.2f}}});
  }
  for (std::uint32_t leaf = 0; leaf < 200; ++leaf) c.foliage.cards[leaf] = leaf % 3;
  expect_agreement_in_every_view(c);
}

/// More than the device is asked in one go.
TEST_F(OcclusionQueryTest, ManyLeavesAreAskedInParts) {
  Case c = random_rectangles(9000);
  c.views = *viewpoints(2);
  c.side_px = 128;
  expect_agreement_in_every_view(c);
}

TEST_F(OcclusionQueryTest, AWrongCameraIsOutOfBounds) {
  const Case c = corylus(Leaves::plain);
  const Areas buffers = item_buffer_areas(c);
  std::vector<Viewpoint> from_behind = c.views, next = c.views, near = c.views, turned = c.views;
  std::rotate(next.begin(), next.begin() + 1, next.end());
  for (Viewpoint& view : from_behind) view.direction = -view.direction;
  for (Viewpoint& view : near) view.distance_radii = 100.0f;
  for (Viewpoint& view : turned) view = viewpoint_towards(glm::normalize(view.direction + 0.01f * view.right));
  for (const std::vector<Viewpoint>& wrong : {from_behind, next, near, turned}) {
    const Areas queries = query_areas(c, wrong);
    for (std::size_t view = 0; view < c.views.size(); ++view) EXPECT_FALSE(agrees(compare(c, view, buffers, queries))) << "view " << view;
  }
}

/// Where two leaves are equally deep an item buffer gives the pixel to the first; queries count both.
TEST_F(OcclusionQueryTest, TiesCountForEveryLeaf) {
  Case c{test::plain_foliage(std::vector<Quad>(2, test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})))};
  c.views = {viewpoint_towards({0, 0, 1})};
  const Areas buffers = item_buffer_areas(c), queries = query_areas(c, c.views);
  EXPECT_GT(buffers[0], 1000u);
  EXPECT_EQ(buffers[1], 0u);
  EXPECT_EQ(queries[0], buffers[0]);
  EXPECT_EQ(queries[1], buffers[0]);
  EXPECT_EQ(queries[2], buffers[2]);
}

/// Where leaves moved and went, only what that can have changed is asked again, and the result is the same.
TEST_F(OcclusionQueryTest, ChangedBoxesGiveWhatAllOfItGives) {
  Case c = corylus(Leaves::cards);
  const auto queries = queries_of(c, c.views);
  Areas areas((c.foliage.quads.size() + 1) * c.views.size());
  ASSERT_TRUE(queries->measure({c.foliage.quads, c.foliage.cards, {}}, areas, {}));
  const Sphere sphere = bounding_sphere(c.foliage);
  for (std::size_t step = 0; step < 10; ++step) {
    const std::size_t moved = step * 17;
    std::vector<Quad> after = c.foliage.quads;
    for (glm::vec3& corner : after[moved]) corner = 0.5f * (corner + sphere.center);
    std::vector<PixelBox> changed;
    for (const Viewpoint& view : c.views) {
      const Projection projection = make_projection(view, sphere, c.side_px);
      const auto box = [&](const Quad& quad) { return pixel_box(project(projection, quad), projection.resolution_px); };
      changed.push_back(united(box(c.foliage.quads[moved]), box(after[moved])));
    }
    Areas whole(areas.size());
    ASSERT_TRUE(queries->measure({after, c.foliage.cards, changed}, areas, {}));
    ASSERT_TRUE(queries->measure({after, c.foliage.cards, {}}, whole, {}));
    EXPECT_EQ(areas, whole) << "step " << step;
    c.foliage.quads = after;
  }
}

/// Algorithm 1 all the way down by queries alone, and from areas that they gave before the first step.
TEST_F(OcclusionQueryTest, ACollapseByQueriesKeepsAsMuchInformation) {
  Case c{test::ball_crown(60, 3)};
  c.materials = test::plain_materials();
  c.views = *viewpoints(6);
  c.side_px = 64;
  const CollapseOptions options{c.side_px, true, 4};
  const auto expected = collapse_by_mutual_information(c.shown(), c.views, options, {});
  ASSERT_TRUE(expected);
  const auto queries = queries_of(c, c.views);
  AreaSource source;
  source.measure = [&](const AreaRequest& request, std::span<std::uint32_t> areas_px) { return queries->measure(request, areas_px, {}); };
  for (const bool every_step : {true, false}) {
    source.every_step = every_step;
    const auto result = collapse_by_mutual_information(c.shown(), c.views, options, {}, source);
    ASSERT_TRUE(result) << result.error().message();
    EXPECT_EQ(result->sequence.merges.size(), 59u);
    EXPECT_NEAR(result->source.bits, expected->source.bits, 0.002 * expected->source.bits);
  }
}

}  // namespace occlusion_query_test
}  // namespace coppice::bake
