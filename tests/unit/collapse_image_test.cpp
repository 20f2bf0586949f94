#include "collapse_image.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "alpha_mask.h"
#include "bounds.h"
#include "collapse_information.h"
#include "generate_plant.h"
#include "held_out_error.h"
#include "leaf_cards.h"
#include "leaf_shade.h"
#include "mentions.h"
#include "results.h"
#include "test_foliage.h"
#include "tree_order.h"

namespace coppice::bake::collapse_image_test {

/// What a collapse starts from.
struct Scene {
  Foliage foliage;
  std::vector<Material> materials = test::plain_materials();
  std::vector<Image> images;
  std::vector<Viewpoint> views = *viewpoints(20);
  CollapseOptions options;
  ImageErrorOptions image_options;
};

Scene scene_of(Foliage foliage, std::uint32_t resolution_px = 48) {
  Scene scene;
  scene.foliage = std::move(foliage);
  scene.options.resolution_px = resolution_px;
  return scene;
}

/// Every other texel is a hole.
void punch_holes(Scene& scene) {
  Image image{8, 8, std::vector<std::uint8_t>(8 * 8 * 4, 128)};
  for (std::size_t i = 0; i < 64; ++i) image.rgba[i * 4 + 3] = (i + i / 8) % 2 == 0 ? 255 : 0;
  scene.images = {image};
  scene.materials[0].image = 0;
  scene.materials[0].alpha_cutoff = 0.5f;
}

CollapseResult collapse(const Scene& scene) {
  return test::must(
      collapse_by_image_error({scene.foliage, scene.materials, scene.images}, scene.views, scene.options, scene.image_options, {}));
}

IncrementalImage incremental_image(const Scene& scene) {
  const auto buffers =
      test::must(render_item_buffers({scene.foliage, scene.materials, scene.images}, scene.views, scene.options.resolution_px));
  return {{scene.foliage, scene.materials, scene.images},
          *alpha_masks(scene.materials, scene.images),
          scene.views,
          buffers,
          scene.image_options};
}

std::string text(const CollapseSequence& sequence) {
  std::string lines;
  for (const Merge& merge : sequence.merges) {
    lines += std::to_string(merge.first) + " " + std::to_string(merge.second) + ":";
    for (const std::uint8_t corner : merge.corners) lines += " " + std::to_string(corner);
    lines += " " + std::to_string(merge.opacity) + "\n";
  }
  return lines;
}

// Two black squares of 4 x 4 px, 8 columns apart, in the middle four rows of a picture of 16 x 16: columns 0..3 and 12..15, rows 6..9.
Scene two_squares() {
  Scene scene = scene_of(test::plain_foliage({test::rectangle({-1, -0.25f, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}),
                                              test::rectangle({0.5f, -0.25f, 0}, {0.5f, 0, 0}, {0, 0.5f, 0})}),
                         16);
  scene.materials[0].base_color = glm::vec4(0, 0, 0, 1);
  scene.views = {viewpoint_towards({0, 0, 1})};
  return scene;
}

/// The merged leaf of the left square alone, and the one that bridges the gap: outer corners of both.
constexpr PairCorners kLeftSquare{0, 1, 2, 3}, kBridge{0, 5, 6, 3};

MergeCost cost_of(const IncrementalImage& image, IncrementalImage::Scratch& scratch, const Merge& merge, const ViewSubset& views = {}) {
  MergeCost cost;
  image.costs_of({merge.first, merge.second, {&merge.corners, 1}, views}, scratch, {&cost, 1});
  return cost;
}

TEST(IncrementalImage, CostsOfTwoSquares) {
  // What a pixel of leaf differs from the ground, squared, over all channels.
  constexpr auto kLeaf = static_cast<std::int64_t>(3 * kGround * kGround + 255 * 255);
  // A block of 8 x 8 px counts 16 times (units of 1/1024 px^2). The bridge has four blocks of 8 new px each; if only the left square stays,
  // two blocks lose 8 px each.
  constexpr std::int64_t kBlocks = std::int64_t{16} * 8 * 8 * kLeaf;
  // 32 px more, or 16 less, each 1024 units, three times.
  constexpr std::int64_t kPixel = std::int64_t{3 * 1024} * kLeaf;
  // The view of 256 px is a block of its own, 32 px too much or 16 too little, in one channel.
  constexpr std::int64_t kCoverage = std::int64_t{5} * 255 * 255 * 1024 / 256;
  struct Case {
    std::int64_t pixel_weight, coverage_weight, bridge, left;
  };
  for (const Case& each : {Case{0, 0, 4 * kBlocks, 2 * kBlocks}, Case{3, 0, 4 * kBlocks + 32 * kPixel, 2 * kBlocks + 16 * kPixel},
                           Case{0, 5, 4 * kBlocks + 32 * 32 * kCoverage, 2 * kBlocks + 16 * 16 * kCoverage}}) {
    Scene scene = two_squares();
    scene.image_options = {.pixel_weight = each.pixel_weight, .scales = {{3, 1}}, .coverage_weight = each.coverage_weight};
    IncrementalImage image = incremental_image(scene);
    ASSERT_EQ(image.areas(0)[0], 16u);
    ASSERT_EQ(image.areas(1)[0], 16u);
    const std::array<PairCorners, 2> shapes{kBridge, kLeftSquare};
    std::array<MergeCost, 2> costs{};
    IncrementalImage::Scratch scratch;
    image.costs_of({0, 1, shapes}, scratch, costs);
    EXPECT_EQ(image.error(), 0.0);
    image.apply({0, 1, 2, image.merged(0, 1, kBridge, kOpaque)});
    EXPECT_DOUBLE_EQ(image.error(), costs[0].at(kOpaque));
    EXPECT_DOUBLE_EQ(costs[0].at(kOpaque), static_cast<double>(each.bridge));
    EXPECT_DOUBLE_EQ(costs[1].at(kOpaque), static_cast<double>(each.left));
    EXPECT_EQ(image.areas(2)[0], 64u);
    EXPECT_EQ(image.areas(image.background())[0], 256u - 64u);
  }
}

// The squares cover 32 px.
TEST(IncrementalImage, LostCoverageOfTwoSquares) {
  const auto lost_coverage = [](const PairCorners& corners, std::uint8_t opacity) {
    IncrementalImage image = incremental_image(two_squares());
    EXPECT_EQ(image.lost_coverage(), 0.0);
    image.apply({0, 1, 2, image.merged(0, 1, corners, opacity)});
    return image.lost_coverage();
  };
  EXPECT_DOUBLE_EQ(lost_coverage(kLeftSquare, kOpaque), 0.5);
  EXPECT_DOUBLE_EQ(lost_coverage(kBridge, kOpaque), -1.0);
  EXPECT_DOUBLE_EQ(lost_coverage(kBridge, kOpaque / 2), 0.0);
}

// The bridge is 64 px where the squares were 32: pixels alone want the opacity that errs least on 32 px that are black and 32 that are not.
TEST(IncrementalImage, OpacityOfTwoSquares) {
  Scene scene = two_squares();
  scene.image_options = {.pixel_weight = 1, .scales = {{5, 1}}, .coverage_weight = 0};
  IncrementalImage image = incremental_image(scene);
  IncrementalImage::Scratch scratch;
  const MergeCost cost = cost_of(image, scratch, {0, 1, kBridge});
  EXPECT_EQ(cost.best_opacity(), kOpaque / 2);
  image.apply({0, 1, 2, image.merged(0, 1, kBridge, kOpaque / 2)});
  // Every pixel of the bridge errs by half of the ground in three channels and half of 255 in one; the one block of 16 x 16 px is as dark
  // as before. In sixteenths, 127.5 is whole.
  EXPECT_DOUBLE_EQ(image.error(), 1024.0 * 64 * (3 * 0.25 * double{kGround} * double{kGround} + 127.5 * 127.5));
  EXPECT_DOUBLE_EQ(cost.at(kOpaque / 2), image.error());
  EXPECT_EQ(image.areas(2)[0], 64u);
}

TEST(IncrementalImage, BehindAnOpaqueLeafNothingCounts) {
  Scene scene = two_squares();
  scene.foliage.quads.push_back(test::rectangle({-2, -2, 1}, {4, 0, 0}, {0, 4, 0}));
  scene.foliage.cards.push_back(0);
  IncrementalImage image = incremental_image(scene);
  IncrementalImage::Scratch scratch;
  const MergeCost cost = cost_of(image, scratch, {0, 1, kBridge});
  EXPECT_FALSE(cost.is_seen());
  EXPECT_EQ(cost.at(kOpaque), 0.0);
}

TEST(IncrementalImage, AHalvedPictureErrsAsTheWholeDoes) {
  Scene scene = scene_of(test::ball_crown(60, 21), 64);
  scene.image_options.pixel_weight = 0;  // what differs within a pixel is no error any more
  IncrementalImage image = incremental_image(scene);
  IncrementalImage::Scratch scratch;
  std::vector<std::uint32_t> live;
  for (std::uint32_t id = 2; id <= 60; ++id) live.push_back(id);
  image.apply({0, 1, 60, image.merged(0, 1, kBridge, 11)});
  const double whole = image.error(), lost_coverage = image.lost_coverage();
  EXPECT_GT(whole, 0.0);
  for (const std::uint32_t side_px : {32u, 16u, 8u}) {
    ASSERT_TRUE(image.can_halve());
    image.halve(live);
    EXPECT_EQ(image.pixels_per_view(), side_px * side_px);
    EXPECT_EQ(image.pixel_area(), 64.0 * 64.0 / (side_px * side_px));
    EXPECT_NEAR(image.error(), whole, 0.02 * whole) << "differences are rounded to sixteenths";
    EXPECT_NEAR(image.lost_coverage(), lost_coverage, 0.002);
    EXPECT_TRUE(std::isfinite(cost_of(image, scratch, {2, 3, kLeftSquare}).at(kOpaque))) << "scratches follow";
  }
  EXPECT_FALSE(image.can_halve()) << "blocks of 8 px are one pixel now";
}

TEST(LeafShade, IsThatOfTheSideTheViewerSees) {
  const auto shade_of = [](const ShadingNormals& normals, const glm::vec3& to_viewer) { return leaf_shade(normals, 0.2f, to_viewer); };
  const ShadingNormals flat{{0.0f, 1.0f, 0.0f}, 1.0f, false};
  // All lights are above it; from below only the first one shines through.
  const Shade above = shade_of(flat, {0, 1, 0}), below = shade_of(flat, {0, -1, 0});
  const auto ambient = static_cast<std::uint8_t>(std::lround(lambert_luminance(0.2f, 0.0f)));
  for (std::size_t light = 0; light < 3; ++light) EXPECT_GT(above[light], ambient);
  EXPECT_GT(below[0], ambient);
  EXPECT_LT(below[0], above[0]);
  EXPECT_EQ(below[1], ambient);
  EXPECT_EQ(below[2], ambient);
  EXPECT_EQ(shade_of(flat, glm::normalize(glm::vec3(0.9f, 0.1f, 0))), above)
      << "a flat leaf's light does not depend on where it is seen from";
  const ShadingNormals sided{{0.0f, 1.0f, 0.0f}, 1.0f, true};
  EXPECT_EQ(shade_of(sided, {0, -1, 0}), above) << "an artist's normal keeps its side";
  // Leaves of all directions show the viewer those that turn to it.
  const ShadingNormals round{{0.0f, 1.0f, 0.0f}, 1.0f / 3.0f, false};
  EXPECT_GT(shade_of(round, {0, 1, 0})[1], shade_of(round, {0, -1, 0})[1]);
}

using FixedShade = std::array<std::int64_t, kImageChannels>;  ///< in sixteenths, as IncrementalImage has them

/// Block sums of every view and channel, rendered from scratch: every pixel's leaves sorted and laid over each other. shift 0: pixels
std::vector<FixedShade> naive_blocks(const Scene& scene, const std::vector<LiveLeaf>& leaves, std::uint32_t shift) {
  const auto masks = *alpha_masks(scene.materials, scene.images);
  const std::uint32_t size = scene.options.resolution_px, row = (size + (1u << shift) - 1) >> shift;
  std::vector<FixedShade> blocks;
  for (const Viewpoint& view : scene.views) {
    std::vector<std::vector<LeafFragment>> pixels(std::size_t{size} * size);
    const Projection projection = make_projection(view, bounding_sphere(scene.foliage), size);
    for (std::uint32_t i = 0; i < leaves.size(); ++i) {
      const Card& card = scene.foliage.card_table[leaves[i].card];
      rasterise_leaf(project(projection, leaves[i].quad), card, masks[card.material], static_cast<std::int32_t>(size),
                     [&](const QuadFragment& f) {
                       pixels[static_cast<std::size_t>(f.y) * size + static_cast<std::size_t>(f.x)].push_back(make_fragment(f.depth, i));
                     });
    }
    const std::size_t first = blocks.size();
    blocks.resize(first + std::size_t{row} * row, FixedShade{});
    for (std::uint32_t pixel = 0; pixel < pixels.size(); ++pixel) {
      std::sort(pixels[pixel].begin(), pixels[pixel].end());
      std::array<double, kImageChannels> shown{};
      double share = 1.0;
      for (const LeafFragment fragment : pixels[pixel]) {
        const LiveLeaf& leaf = leaves[fragment_leaf(fragment)];
        const std::uint32_t material = scene.foliage.card_table[leaf.card].material;
        const Shade shade = leaf_shade(shading_normals(leaf.normals, leaf.quad),
                                       mean_texel_luminance(scene.materials[material], scene.images, masks[material]), view.direction);
        const double opacity = static_cast<double>(leaf.opacity) / kOpaque;
        for (std::size_t c = 0; c < kImageChannels; ++c) shown[c] += share * opacity * shade[c];
        share *= 1.0 - opacity;
      }
      for (std::size_t c = 0; c < kImageChannels; ++c)
        blocks[first + ((pixel / size) >> shift) * row + ((pixel % size) >> shift)][c] +=
            static_cast<std::int64_t>(16.0 * (shown[c] + (c < 3 ? share * double{kGround} : 0.0)) + 0.5);
    }
  }
  return blocks;
}

double naive_error(const Scene& scene, const std::vector<LiveLeaf>& source, const std::vector<LiveLeaf>& leaves) {
  std::vector<BlockScale> scales = scene.image_options.scales;
  scales.push_back({0, scene.image_options.pixel_weight});
  double error = 0.0;
  for (const BlockScale& scale : scales) {
    const std::vector<FixedShade> before = naive_blocks(scene, source, scale.shift), after = naive_blocks(scene, leaves, scale.shift);
    for (std::size_t i = 0; i < before.size(); ++i)
      for (std::size_t c = 0; c < kImageChannels; ++c) {
        const double difference = static_cast<double>(after[i][c] - before[i][c]) / 16.0;
        error += static_cast<double>(scale.weight << (2 * (5 - scale.shift))) * difference * difference;
      }
  }
  const std::vector<FixedShade> before = naive_blocks(scene, source, 0), after = naive_blocks(scene, leaves, 0);
  const std::size_t pixels = std::max<std::size_t>(before.size() / scene.views.size(), 1);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    double excess = 0.0;
    for (std::size_t i = v * pixels; i < (v + 1) * pixels; ++i) excess += static_cast<double>(after[i][3] - before[i][3]) / 16.0;
    error += static_cast<double>(scene.image_options.coverage_weight) * 1024.0 / static_cast<double>(pixels) * excess * excess;
  }
  return error;
}

void expect_incremental_error_is_that_of_rendering_anew(const Scene& scene) {
  const CollapseResult result = collapse(scene);
  IncrementalImage image = incremental_image(scene);
  IncrementalImage::Scratch scratch;
  std::vector<std::uint32_t> ids;
  std::vector<LiveLeaf> source;
  for (std::uint32_t i = 0; i < scene.foliage.leaf_count(); ++i) {
    ids.push_back(i);
    source.push_back(image.leaf(i));
  }
  std::uint32_t next = scene.foliage.leaf_count(), translucent = 0;
  for (const Merge& merge : result.sequence.merges) {
    const double before = image.error(), cost = cost_of(image, scratch, merge).at(merge.opacity);
    double sum = 0.0;
    for (std::uint32_t first = 0; first < 3; ++first) sum += cost_of(image, scratch, merge, {first, 3}).at(merge.opacity);
    translucent += merge.opacity < kOpaque ? 1u : 0u;
    EXPECT_NEAR(sum, cost, 1e-9 * (before + std::abs(sum) + 1.0));
    image.apply({merge.first, merge.second, next, image.merged(merge.first, merge.second, merge.corners, merge.opacity)});
    std::erase_if(ids, [&](std::uint32_t id) { return id == merge.first || id == merge.second; });
    ids.push_back(next++);
    std::vector<LiveLeaf> leaves;
    for (const std::uint32_t id : ids) leaves.push_back(image.leaf(id));
    // Costs do not round what pixels show to sixteenths.
    ASSERT_NEAR(image.error(), before + cost, 0.002 * image.error() + 1.0) << ids.size() << " leaves left";
    const double anew = naive_error(scene, source, leaves);
    ASSERT_NEAR(image.error(), anew, 1e-4 * anew) << ids.size() << " leaves left";
  }
  EXPECT_GT(translucent, 20u);
}

TEST(IncrementalImage, IncrementalErrorIsThatOfRenderingAnew) {
  expect_incremental_error_is_that_of_rendering_anew(scene_of(test::random_quads(60, 1), 45));
}

TEST(IncrementalImage, IncrementalErrorIsThatOfRenderingAnewWithHolesAndScales) {
  Scene scene = scene_of(test::ball_crown(60, 2), 45);
  punch_holes(scene);
  scene.image_options.scales = {{1, 1}, {3, 2}, {5, 4}};
  scene.image_options.pixel_weight = 7;
  expect_incremental_error_is_that_of_rendering_anew(scene);
}

TEST(CollapseImage, SequenceDoesNotDependOnThreads) {
  Scene scene = scene_of(test::ball_crown(300, 3));
  punch_holes(scene);
  std::vector<std::string> sequences;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    sequences.push_back(text(collapse(scene).sequence));
  }
  EXPECT_EQ(sequences[0], sequences[1]);
  EXPECT_EQ(sequences[0], sequences[2]);
}

TEST(CollapseImage, EveryCutIsAPlant) {
  for (const Foliage& foliage : {test::ball_crown(90, 4), test::random_quads(75, 5), test::duplicated_leaves(60, 6),
                                 test::plain_foliage(std::vector<Quad>(12, test::rectangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0.2f}))),
                                 test::plain_foliage(std::vector<Quad>(7, test::rectangle({1, 2, 3}, {0, 0, 0}, {0, 0, 0})))}) {
    const CollapseResult result = collapse(scene_of(foliage));
    ASSERT_EQ(result.sequence.merges.size(), foliage.quads.size() - 1);
    for (const Merge& merge : result.sequence.merges) {
      const std::set<std::uint8_t> corners(merge.corners.begin(), merge.corners.end());
      EXPECT_EQ(corners.size(), 4u) << "a vertex twice";
      EXPECT_LT(*corners.rbegin(), 8);
    }
    const Tree tree = build_tree(foliage, result.sequence);  // asserts that every node is used once
    for (std::uint32_t m = 1; m <= foliage.leaf_count(); ++m) EXPECT_EQ(cut_nodes(tree, m).size(), m);
  }
}

TEST(CollapseImage, AnyNumberOfViewsWillDoAndOneLeafIsLeftAlone) {
  for (const std::uint32_t count : {1u, 2u, 9u}) {
    Scene scene = scene_of(test::ball_crown(40, 9));
    scene.views = *viewpoints(count);
    EXPECT_EQ(collapse(scene).sequence.merges.size(), 39u) << count;
  }
  const CollapseResult result = collapse(scene_of(test::random_quads(1, 7)));
  EXPECT_TRUE(result.sequence.merges.empty());
  EXPECT_EQ(result.levels.size(), 7u);
}

TEST(CollapseImage, LeavesThatNobodySeesGoFirst) {
  // A box of six big leaves round six small ones: five collapses can be free. Whichever leaf takes in the last hidden one gets its normals,
  // a twenty-fifth of its own: a little light.
  std::vector<Quad> quads;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 corner(-1.0f), along(0.0f), across(0.0f);
      corner[axis] = side, along[(axis + 1) % 3] = 2.0f, across[(axis + 2) % 3] = 2.0f;
      quads.push_back(test::rectangle(corner, along, across));
      quads.push_back(test::rectangle(corner * 0.3f, along * 0.2f, across * 0.2f));
    }
  }
  const Scene scene = scene_of(test::plain_foliage(quads));
  const CollapseResult result = collapse(scene);
  IncrementalImage image = incremental_image(scene);
  std::vector<double> errors;
  for (std::uint32_t i = 0; i < 7; ++i) {
    const Merge& merge = result.sequence.merges[i];
    image.apply({merge.first, merge.second, 12 + i, image.merged(merge.first, merge.second, merge.corners, merge.opacity)});
    errors.push_back(image.error());
  }
  EXPECT_EQ(std::vector(errors.begin(), errors.begin() + 5), std::vector<double>(5, 0.0));
  EXPECT_LT(errors[5], 0.01 * errors[6]);
}

TEST(CollapseImage, OptionsOutOfRangeAreNamed) {
  Scene scene = scene_of(test::random_quads(3, 8));
  const auto error_of = [](const Scene& s) {
    const auto result = collapse_by_image_error({s.foliage, s.materials, s.images}, s.views, s.options, s.image_options, {});
    return result ? std::string() : result.error().message();
  };
  scene.options.candidate_count = 0;
  EXPECT_TRUE(test::mentions(error_of(scene), {"candidates"}));
  scene.options.candidate_count = 8;
  scene.image_options.coverage_weight = -1;
  EXPECT_TRUE(test::mentions(error_of(scene), {"weight"}));
  scene.image_options.coverage_weight = 1;
  for (const std::vector<BlockScale>& scales : {std::vector<BlockScale>{}, {{6, 1}}, {{0, 1}}, {{3, 1}, {3, 1}}, {{3, 0}}}) {
    scene.image_options.scales = scales;
    EXPECT_TRUE(test::mentions(error_of(scene), {"scales"}));
  }
}

// Measured on 2026-11-20: 46.5 35.3 17.1 against 52.1 42.5 26.2. The limits leave a quarter of the gain or more as room.
TEST(CollapseImage, BeatsMutualInformationOnCorylusFromViewsThatNeitherSaw) {
  auto plant = test::must(generate_plant("corylus", 1));
  const auto foliage = test::must(card_foliage(plant));
  Scene scene = scene_of(foliage, 128);
  scene.materials = plant.materials;
  scene.images = plant.images;
  const auto mi =
      test::must(collapse_by_mutual_information({scene.foliage, scene.materials, scene.images}, scene.views, scene.options, {}));

  const test::HeldOutViews views(foliage, plant);
  const auto errors_of = [&](const CollapseSequence& sequence) {
    return views.errors_of(cut_foliage(build_tree(foliage, sequence), foliage.card_table, 77));
  };
  const test::HeldOutErrors image_errors = errors_of(collapse(scene).sequence), mi_errors = errors_of(mi.sequence);
  std::printf("image %.1f %.1f %.1f, mi %.1f %.1f %.1f\n", image_errors.rmse_256, image_errors.rmse_64, image_errors.rmse_16,
              mi_errors.rmse_256, mi_errors.rmse_64, mi_errors.rmse_16);
  EXPECT_LT(image_errors.rmse_256, 0.92 * mi_errors.rmse_256);
  EXPECT_LT(image_errors.rmse_64, 0.9 * mi_errors.rmse_64);
  EXPECT_LT(image_errors.rmse_16, 0.85 * mi_errors.rmse_16);
}

}  // namespace coppice::bake::collapse_image_test
