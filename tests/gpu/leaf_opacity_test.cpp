// Merged leaves on both paths, in every size: over frames and over pixels gaps let through what lies behind; normals decide the light.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>

#include "convert.h"
#include "golden.h"
#include "leaf_shade.h"
#include "random_tree.h"
#include "renderer_scene.h"
#include "srgb.h"

namespace coppice::test::leaf_opacity_test {

constexpr std::uint32_t kSidePx = 192, kRow = 20;
constexpr std::uint8_t kHalf = kOpaque / 2;

struct Path {
  const char* name;
  bool compute_raster, int64_atomics;
};

void PrintTo(const Path& each, std::ostream* out) {
  *out << each.name;
}

/// Squares that do not overlap, in a plane before the eye, all of them in the finest cut.
DecodedPlant sheet(std::uint8_t opacity, std::uint32_t texture_side = 0, std::uint16_t normals = kFlatNormals) {
  DecodedPlant plant =
      decoded_plant(random_plant({.leaf_count = kRow * kRow, .seed = 3, .wood_lod_count = 0, .texture_side = texture_side}));
  for (coppice_file_card& card : plant.file.cards) card.mask[0] = card.mask[1] = 0xffffffffu;
  const std::uint32_t cell = COPPICE_QUANTISED_MAX / kRow;
  std::uint32_t at = 0;
  for (PageNode& node : plant.nodes) {
    if (node.split != kNeverReplaced) continue;
    const std::uint32_t x = at % kRow * cell, y = at / kRow * cell, wide = cell * 3 / 4, z = COPPICE_QUANTISED_MAX / 2;
    const auto corner = [&](std::uint32_t right, std::uint32_t up) {
      return QuantisedPoint{static_cast<std::uint16_t>(x + right), static_cast<std::uint16_t>(y + up), static_cast<std::uint16_t>(z)};
    };
    node.corners = {corner(0, 0), corner(wide, 0), corner(wide, wide), corner(0, wide)};
    node.opacity = opacity;
    node.normals = normals;
    ++at;
  }
  return plant;
}

coppice_placement at(float z, float brightness) {
  coppice_placement placement = placement_at({0.0f, 0.0f, z});
  std::ranges::fill(placement.tint, brightness);
  return placement;
}

struct Placed {
  DecodedPlant plant;
  coppice_placement placement;
};

using Light = std::vector<double>;  ///< linear, a number a pixel

class LeafOpacityTest : public VulkanTest, public testing::WithParamInterface<Path> {
 protected:
  static SceneOptions options() { return {.compute_raster = GetParam().compute_raster, .int64_atomics = GetParam().int64_atomics}; }

  /// Leaves of the sheet at z = 0 are this wide.
  static Shot view_for(float leaf_px) {
    const gpu::Plant plant = gpu::gpu_plant(sheet(kOpaque).file.plant);
    const float leaf_m = plant.box_step.x * (COPPICE_QUANTISED_MAX / kRow * 3 / 4), focal_px = 0.5f * kSidePx / std::tan(0.4f);
    const vec3 middle = plant.box_min + plant.box_step * (0.5f * COPPICE_QUANTISED_MAX);
    return make_view({.eye_m = {middle.x, middle.y, middle.z + leaf_m * focal_px / leaf_px},
                      .target_m = {middle.x, middle.y, middle.z},
                      .width_px = kSidePx,
                      .error_px = 1e-4f});
  }

  /// After a frame: lists are built over some of them.
  static std::unique_ptr<RendererScene> drawn_scene(const std::vector<Placed>& plants, const Shot& view, const SceneOptions& with) {
    auto scene = std::make_unique<RendererScene>(gpu(), 64, with);
    for (const Placed& placed : plants) scene->place(scene->add_plant(placed.plant), {placed.placement});
    scene->draw(view);
    return scene;
  }

  /// Mean over 16 frames, moved by parts of a pixel as temporal antialiasing moves them.
  static Light over_frames(const std::vector<Placed>& plants, const Shot& still) {
    const auto scene = drawn_scene(plants, still, options());
    Light mean(std::size_t{kSidePx} * kSidePx);
    for (std::uint32_t frame = 0; frame < 16; ++frame) {
      Shot view = still;
      view.temporal_frame = frame + 1;
      view.clip_from_view[8] += (static_cast<float>(frame % 4) - 1.5f) / 4 * 2 / kSidePx;
      view.clip_from_view[9] += (static_cast<float>(frame / 4) - 1.5f) / 4 * 2 / kSidePx;
      const Picture picture = scene->draw(view).picture;
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += linear_from_srgb8(picture.rgba[4 * i + 1]) / 16.0;
    }
    return mean;
  }

  static Picture one_frame(const std::vector<Placed>& plants, const Shot& view, const SceneOptions& with) {
    return drawn_scene(plants, view, with)->draw(view).picture;
  }
};

/// Share of pixels that are drawn on; the ground is white.
double covered(const Picture& picture) {
  const std::size_t count = count_pixels(picture, [](const std::uint8_t* rgb) { return rgb[1] < 250; });
  return static_cast<double>(count) / static_cast<double>(picture.rgba.size() / 4);
}

/// Root of the mean square difference of means over tiles.
double difference(const Light& a, const Light& b, std::uint32_t tile) {
  double squares = 0;
  for (std::uint32_t y = 0; y < kSidePx; y += tile)
    for (std::uint32_t x = 0; x < kSidePx; x += tile) {
      double sum = 0;
      for (std::uint32_t i = 0; i < tile * tile; ++i) {
        const std::size_t pixel = std::size_t{y + i / tile} * kSidePx + x + i % tile;
        sum += (a[pixel] - b[pixel]) / (tile * tile);
      }
      squares += sum * sum;
    }
  return std::sqrt(squares * tile * tile / (kSidePx * kSidePx));
}

Light mixed(const Light& front, double share, const Light& behind) {
  Light sum(front.size());
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = share * front[i] + (1 - share) * behind[i];
  return sum;
}

constexpr float kHardware_px = 24, kLeaf_px = 8, kSplat_px = 1.5f;

// Black leaves of opacity c before grey ones before white: in the mean c * black + (1 - c) * what is seen without them.
TEST_P(LeafOpacityTest, FramesAverageToTheComposite) {
  const Placed behind{sheet(kOpaque), at(-0.7f, 0.2f)};
  for (const float leaf_px : {kHardware_px, kLeaf_px, kSplat_px}) {
    const Shot view = view_for(leaf_px);
    const Light without = over_frames({behind}, view), opaque = over_frames({{sheet(kOpaque), at(0.0f, 0.0f)}, behind}, view);
    ASSERT_GT(difference(without, opaque, 8), 0.03) << leaf_px << ": something stands before it";
    for (const std::uint32_t opacity : {2u, 8u, 13u}) {
      const Light actual = over_frames({{sheet(static_cast<std::uint8_t>(opacity)), at(0.0f, 0.0f)}, behind}, view);
      const Light expected = mixed(opaque, opacity / 16.0, without);
      EXPECT_LT(difference(actual, expected, 8), 0.02) << leaf_px << " px, " << opacity;
      if (leaf_px == kSplat_px) continue;
      EXPECT_LT(difference(actual, expected, 1), 0.06) << leaf_px << " px, " << opacity << ": pixel by pixel";
    }
  }
}

// Two sheets of half opacity: behind both a quarter is seen, not a half or nothing.
TEST_P(LeafOpacityTest, LeavesBehindEachOtherLetThroughTheProduct) {
  const Placed front{sheet(kHalf), at(0.0f, 0.0f)}, back{sheet(kHalf), at(-0.02f, 0.2f)};
  const Placed whole_front{sheet(kOpaque), at(0.0f, 0.0f)}, whole_back{sheet(kOpaque), at(-0.02f, 0.2f)};
  for (const float leaf_px : {kHardware_px, kLeaf_px}) {
    const Shot view = view_for(leaf_px);
    const Light white(std::size_t{kSidePx} * kSidePx, 1.0), both = over_frames({whole_front, whole_back}, view);
    const Light expected = mixed(both, 0.5, mixed(over_frames({whole_back}, view), 0.5, white));
    const Light actual = over_frames({front, back}, view);
    // A pair in 32 has the same lattice and step, and here are 36 and 300 of them; were all alike, it would be 0.14.
    EXPECT_LT(difference(actual, expected, 8), leaf_px == kHardware_px ? 0.05 : 0.03) << leaf_px;
    EXPECT_LT(difference(actual, expected, 1), 0.1) << leaf_px;
  }
}

TEST_P(LeafOpacityTest, WithoutFramesThePatternIsFixed) {
  for (const float leaf_px : {kHardware_px, kLeaf_px, kSplat_px})
    for (const std::uint32_t texture_side : {0u, 8u}) {
      Shot view = view_for(leaf_px);
      const std::vector<Placed> half{{sheet(kHalf, texture_side), at(0.0f, 0.0f)}};
      const std::vector<Placed> opaque{{sheet(kOpaque, texture_side), at(0.0f, 0.0f)}};
      const auto scene = drawn_scene(half, view, options());
      const Picture first = scene->draw(view).picture, second = scene->draw(view).picture;
      EXPECT_TRUE(first.rgba == second.rgba) << leaf_px << ": a still picture stands still";
      EXPECT_NEAR(covered(first) / covered(one_frame(opaque, view, options())), 0.5, leaf_px == kSplat_px ? 0.08 : 0.02) << leaf_px;
      view.temporal_frame = 2;
      const Picture other = scene->draw(view).picture;
      EXPECT_NEAR(covered(other) / covered(first), 1.0, leaf_px == kSplat_px ? 0.08 : 0.03) << leaf_px;  // some hundred pixels
      if (leaf_px == kSplat_px && GetParam().compute_raster) continue;                                   // smaller discs, always
      EXPECT_FALSE(first.rgba == other.rgba) << leaf_px << ": other pixels";
    }
}

TEST_P(LeafOpacityTest, FramesChangeNothingOfOpaqueLeaves) {
  for (const float leaf_px : {kHardware_px, kLeaf_px, kSplat_px}) {
    Shot view = view_for(leaf_px);
    const std::vector<Placed> plants{{decoded_plant(random_plant({.leaf_count = 400, .seed = 3})), at(0.0f, 0.4f)}};
    const Picture fixed = one_frame(plants, view, options());
    view.temporal_frame = 7;
    EXPECT_TRUE(fixed.rgba == one_frame(plants, view, options()).rgba) << leaf_px;
  }
}

// One text: leaves that the compute shaders draw lack the pixels that the hardware would have left out.
TEST_P(LeafOpacityTest, BothPathsLeaveOutTheSamePixels) {
  if (!GetParam().compute_raster) return;
  Shot view = view_for(kLeaf_px);
  const std::vector<Placed> half{{sheet(kHalf), at(0.0f, 0.0f)}};
  for (const std::uint32_t frame : {0u, 5u}) {
    view.temporal_frame = frame;
    const Picture raster = one_frame(half, view, options()), hardware = one_frame(half, view, {});
    double differing = 0;
    for (std::size_t i = 0; i < raster.rgba.size(); i += 4) differing += (raster.rgba[i + 1] < 250) != (hardware.rgba[i + 1] < 250);
    EXPECT_LT(differing / (kSidePx * kSidePx), 0.01) << frame;
    EXPECT_GT(covered(raster), 0.1);
  }
}

/// Mean linear green of the pixels that are drawn on, under a sun without a sky.
double sunlight(const Picture& picture) {
  double sum = 0.0, pixels = 0.0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) {
    if (picture.rgba[i] >= 250 && picture.rgba[i + 2] >= 250) continue;  // the ground
    sum += static_cast<double>(linear_from_srgb8(picture.rgba[i + 1]));
    ++pixels;
  }
  return sum / pixels;
}

// Each path shows the light that the baker computes by the same text, relative to that of a flat leaf.
TEST_P(LeafOpacityTest, NormalsDecideTheLight) {
  const std::array<float, 3> own{0.0f, 0.0f, 1.0f};
  const glm::vec3 eye(0.0f, 0.0f, 1.0f), sun = glm::normalize(glm::vec3(0.5f, 0.6f, 0.7f));
  const auto expected = [&](std::uint16_t bits) {
    const glm::vec2 light = bake::leaf_light(unpack_normals(bits, own), sun, eye);
    return static_cast<double>(light.x + bake::kTranslucency * 1.15f * light.y);
  };
  const auto sizes_px = GetParam().compute_raster ? std::vector{kLeaf_px, kSplat_px} : std::vector{kHardware_px};
  for (const float leaf_px : sizes_px) {
    Shot view = view_for(leaf_px);
    std::copy_n(&sun.x, 3, view.light.sun_direction);
    std::ranges::fill(view.light.sky_color, 0.0f);
    std::ranges::fill(view.light.ground_color, 0.0f);
    const auto shown = [&](std::uint16_t bits) {
      return sunlight(one_frame({{sheet(kOpaque, 0, bits), at(0.0f, 0.4f)}}, view, options()));
    };
    const double flat = shown(kFlatNormals);
    ASSERT_GT(flat, 0.02);
    // Leaves of all directions, leaves about a twig, an artist's normals that turn away. The eye looks from up to 20 degrees off.
    for (const std::uint16_t bits : {pack_normals(13, 18, 5, NormalSide::either), pack_normals(31, 31, 0, NormalSide::either),
                                     pack_normals(31, 4, 15, NormalSide::against)})
      EXPECT_NEAR(shown(bits) / flat, expected(bits) / expected(kFlatNormals), 0.06) << leaf_px << " px, " << bits;
  }
}

TEST_P(LeafOpacityTest, ShadowMapsAreTransparentToo) {
  const auto depth_of = [&](std::uint8_t opacity, float leaf_px) {
    const Shot view = view_for(leaf_px);
    const auto scene = drawn_scene({{sheet(opacity), at(0.0f, 0.0f)}}, view, options());
    scene->draw_depth(view);
    return scene->draw_depth(view);
  };
  const auto share = [](const std::vector<float>& depth) {
    return static_cast<double>(std::ranges::count_if(depth, [](float value) { return value > 0.0f; })) / static_cast<double>(depth.size());
  };
  for (const float leaf_px : {kHardware_px, kLeaf_px, kSplat_px}) {
    const std::vector<float> half = depth_of(kHalf, leaf_px);
    EXPECT_GT(share(half), 0.005) << leaf_px;
    EXPECT_NEAR(share(half) / share(depth_of(kOpaque, leaf_px)), 0.5, leaf_px == kSplat_px ? 0.08 : 0.02) << leaf_px;
    EXPECT_TRUE(half == depth_of(kHalf, leaf_px)) << leaf_px;
  }
}

INSTANTIATE_TEST_SUITE_P(Paths, LeafOpacityTest,
                         testing::Values(Path{"hardware", false, false}, Path{"compute", true, true}, Path{"compute_twice", true, false}),
                         [](const auto& path) { return path.param.name; });

}  // namespace coppice::test::leaf_opacity_test
