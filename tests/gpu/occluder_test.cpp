// What the engine has drawn before plants hides them where they are culled, and the picture stays what it is without.

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <vector>

#include "path_fixture.h"

namespace coppice::test::occluder_test {

constexpr std::uint32_t kSidePx = 192;
constexpr float kNear_m = 0.05f;  // make_view's

/// Something of the engine's: a rectangle of its depth attachment, so far away.
struct Wall {
  VkRect2D px;
  float distance_m;
};

/// How a view's depth is kept.
struct Depth {
  const char* name;
  VkFormat format;
  VkCompareOp compare;
  std::size_t pixel_bytes;

  [[nodiscard]] bool is_reversed() const { return compare == VK_COMPARE_OP_GREATER || compare == VK_COMPARE_OP_GREATER_OR_EQUAL; }
  [[nodiscard]] float of(float distance_m) const { return is_reversed() ? kNear_m / distance_m : 1.0f - kNear_m / distance_m; }
  [[nodiscard]] float farthest() const { return is_reversed() ? 0.0f : 1.0f; }
};
constexpr std::array kDepths{Depth{"reversed floats", VK_FORMAT_D32_SFLOAT, VK_COMPARE_OP_GREATER_OR_EQUAL, 4},
                             Depth{"reversed floats, nearer alone", VK_FORMAT_D32_SFLOAT, VK_COMPARE_OP_GREATER, 4},
                             Depth{"forward floats", VK_FORMAT_D32_SFLOAT, VK_COMPARE_OP_LESS_OR_EQUAL, 4},
                             Depth{"reversed 16 bits", VK_FORMAT_D16_UNORM, VK_COMPARE_OP_GREATER_OR_EQUAL, 2},
                             Depth{"forward 16 bits", VK_FORMAT_D16_UNORM, VK_COMPARE_OP_LESS, 2}};

struct Drawn {
  std::vector<std::uint8_t> color, depth;
  coppice_view_stats stats;
};

class OccluderTest : public PathTest<ContextTest> {
 protected:
  /// Rows from 3 to 40 m away, from pots to trees.
  void place_rows() {
    std::vector<coppice_placement> all;
    for (int row = 0; row < 12; ++row)
      for (int i = 0; i < 14; ++i) {
        const float scale = 0.3f + 0.35f * static_cast<float>((i * 7 + row * 3) % 4);
        all.push_back(placement_at({1.9 * (i - 6.5) + 0.3 * (row % 3), 0.0, 5.0 - 3.3 * row}, scale));
      }
    add(plant_, all);
  }

  coppice_view create_depth_view(const Depth& depth) {
    auto formats = defaults(coppice_vulkan_view_desc_init);
    formats.color_formats[0] = VK_FORMAT_R8G8B8A8_SRGB;
    formats.depth_format = depth.format;
    formats.depth_compare = depth.compare;
    return create_view(formats);
  }

  static Shot shot_of(coppice_view view, const Depth& depth, float vertical_fov_radians = 0.8f) {
    Shot shot = make_view({.eye_m = {0.0f, 1.0f, 8.0f},
                           .target_m = {0.0f, 0.5f, 0.0f},
                           .vertical_fov_radians = vertical_fov_radians,
                           .width_px = kSidePx,
                           .error_px = 0.3f,
                           .view = view});
    // z of clip space becomes w - z.
    for (std::size_t i = 0; i < 16 && !depth.is_reversed(); i += 4)
      shot.clip_from_view[i + 2] = shot.clip_from_view[i + 3] - shot.clip_from_view[i + 2];
    return shot;
  }

  /// All of it far away, but for walls. Leaves it readable.
  static void draw_walls(VkCommandBuffer cmd, const Image& image, const Depth& depth, std::span<const Wall> walls) {
    begin_rendering(cmd, {.depth = &image, .farthest = {depth.farthest(), 0}});
    for (const Wall& wall : walls) {
      const VkClearAttachment clear{VK_IMAGE_ASPECT_DEPTH_BIT, 0, {.depthStencil = {depth.of(wall.distance_m), 0}}};
      const VkClearRect rect{wall.px, 0, 1};
      vkCmdClearAttachments(cmd, 1, &clear, 1, &rect);
    }
    vkCmdEndRendering(cmd);
    change_layout(cmd, image, image.attachment_layout(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
  }

  /// Plants after the walls, in attachments that both eyes are in. occluder: as coppice_light has it, but for the image, which is `image`
  /// or else the attachment; null: none
  Drawn draw(Shot shot, const Depth& depth, std::span<const Wall> walls, coppice_occluder* occluder, const Image* image = nullptr) {
    const std::uint32_t eyes = shot.second_eye == nullptr ? 1 : 2;
    const std::uint32_t width_px = eyes * kSidePx + static_cast<std::uint32_t>(shot.x_px),
                        height_px = kSidePx + static_cast<std::uint32_t>(shot.y_px);
    const Image color(gpu(), color_attachment(width_px, height_px)), attachment(gpu(), depth_attachment(width_px, height_px, depth.format));
    if (occluder != nullptr) occluder->image = (image != nullptr ? *image : attachment).view();
    shot.light.occluder = occluder;
    begin(shot);
    submit(gpu(), [&](VkCommandBuffer cmd) {
      record_upload(cmd);
      draw_walls(cmd, attachment, depth, walls);
      record_cull(cmd, shot);
      begin_rendering(cmd, {.colors = {&color}, .depth = &attachment, .depth_from = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
      for (std::uint32_t eye = 0; eye < eyes; ++eye) record_draw(cmd, shot, eye);
      vkCmdEndRendering(cmd);
    });
    Drawn drawn{read_bytes(gpu(), color, 4), read_bytes(gpu(), attachment, depth.pixel_bytes), {}};
    shot.light.occluder = nullptr;
    pump(shot);  // by now the frame has been counted
    drawn.stats = view_stats(shot.view);
    return drawn;
  }

  /// With the occluder against without. Returns the two counts of leaves.
  std::pair<std::uint64_t, std::uint64_t> expect_same(const Shot& shot, const Depth& depth, std::span<const Wall> walls,
                                                      const std::string& what, coppice_occluder occluder = defaults(coppice_occluder_init),
                                                      const Image* image = nullptr) {
    draw(shot, depth, walls, &occluder, image);  // has its pipeline built
    const Drawn without = draw(shot, depth, walls, nullptr), with = draw(shot, depth, walls, &occluder, image);
    EXPECT_TRUE(with.color == without.color) << what << ", " << depth.name;
    EXPECT_TRUE(with.depth == without.depth) << what << ", " << depth.name;
    EXPECT_LE(with.stats.visible_instance_count, without.stats.visible_instance_count) << what;
    if (GetParam().compute_raster == VK_FALSE) {
      EXPECT_EQ(with.stats.drawn_leaf_count, without.stats.drawn_leaf_count) << "the hardware's path is as it was";
    }
    return {with.stats.drawn_leaf_count, without.stats.drawn_leaf_count};
  }

  [[nodiscard]] bool is_used() const { return GetParam().compute_raster == VK_TRUE; }

  /// Rectangles of all sizes, from in front of all plants to behind them.
  static std::vector<Wall> random_walls(std::uint32_t seed, std::uint32_t width_px) {
    std::mt19937 random(seed);
    std::vector<Wall> walls;
    for (int i = 0; i < 24; ++i) {
      const auto x = static_cast<std::int32_t>(random() % width_px), y = static_cast<std::int32_t>(random() % kSidePx);
      const auto size = static_cast<std::uint32_t>(16 + random() % 170);
      walls.push_back(
          {{{x, y}, {std::min(size, width_px - static_cast<std::uint32_t>(x)), std::min(size, kSidePx - static_cast<std::uint32_t>(y))}},
           2.5f + static_cast<float>(random() % 4000) / 100.0f});
    }
    return walls;
  }
};

constexpr VkRect2D kAll{{0, 0}, {kSidePx, kSidePx}}, kLeft{{0, 0}, {128, kSidePx}};  // a column of the largest tiles

TEST_P(OccluderTest, AWallBeforePlantsHidesThem) {
  place_rows();
  for (const Depth& depth : kDepths) {
    const Shot shot = shot_of(create_depth_view(depth), depth);
    pump_until_settled(shot);
    const Wall near_all{kAll, 1.5f}, near_left{kLeft, 1.5f}, behind{kAll, 100.0f};
    const auto [of_none, of_all] = expect_same(shot, depth, {&near_all, 1}, "a wall before everything");
    const auto [of_half, all] = expect_same(shot, depth, {&near_left, 1}, "a wall on the left");
    const auto [same, all_again] = expect_same(shot, depth, {&behind, 1}, "a wall behind everything");
    EXPECT_GT(all, 5000u);
    EXPECT_EQ(all, of_all);
    EXPECT_EQ(same, all_again);
    if (!is_used()) continue;
    // But for what is larger on the screen than the largest tile.
    EXPECT_LT(of_none, all / 5) << depth.name;
    EXPECT_LT(of_half, all * 3 / 4) << depth.name;
    EXPECT_GT(of_half, all / 4) << depth.name;
  }
}

/// Walls between plants, with edges through crowns.
TEST_P(OccluderTest, ThePictureIsTheOneWithout) {
  place_rows();
  for (const Depth& depth : kDepths) {
    const Shot shot = shot_of(create_depth_view(depth), depth);
    pump_until_settled(shot);
    for (std::uint32_t seed = 1; seed <= 4; ++seed) {
      const std::vector<Wall> walls = random_walls(seed, kSidePx);
      const auto [with, without] = expect_same(shot, depth, walls, "walls " + std::to_string(seed));
      if (is_used()) {
        EXPECT_LT(with, without);
      }
    }
  }
}

/// Fences with slits of a pixel, also in a wide view, towards whose edges a sphere is an ellipse.
TEST_P(OccluderTest, WhatASlitShowsIsDrawn) {
  place_rows();
  const Depth& depth = kDepths[0];
  const coppice_view view = create_depth_view(depth);
  // The last column or row of a tile is a slit.
  std::vector<Wall> upright, level;
  for (std::int32_t at = 0; at < static_cast<std::int32_t>(kSidePx); at += 16) {
    upright.push_back({{{at, 0}, {15, kSidePx}}, 2.0f});
    level.push_back({{{0, at}, {kSidePx, 15}}, 2.0f});
  }
  for (const float fov : {0.8f, 2.2f}) {
    const Shot shot = shot_of(view, depth, fov);
    pump_until_settled(shot);
    const auto [with, without] = expect_same(shot, depth, upright, "upright pickets");
    expect_same(shot, depth, level, "level pickets");
    if (is_used() && fov > 2.0f) {
      EXPECT_LT(with, without);
    }
  }
}

/// Towards the edges of a wide view a sphere is an ellipse. Plants of few leaves, which touch their spheres.
TEST_P(OccluderTest, InAWideViewTheOutermostLeavesAreSeen) {
  plant_ = open_random({.leaf_count = 3, .seed = 8, .wood_lod_count = 0});
  place_rows();
  const Shot shot = shot_of(create_depth_view(kDepths[0]), kDepths[0], 2.6f);
  pump_until_settled(shot);
  for (std::uint32_t seed = 1; seed <= 16; ++seed) {
    std::vector<Wall> walls = random_walls(seed, kSidePx);
    for (Wall& wall : walls) wall.distance_m = 1.5f;
    expect_same(shot, kDepths[0], walls, "walls " + std::to_string(seed));
  }
  // Walls that end where a tile does: a plant behind one reaches out by its outermost leaves alone.
  for (std::uint32_t end = 16; end < kSidePx; end += 16) {
    const auto at = static_cast<std::int32_t>(end);
    for (const VkRect2D& px : {VkRect2D{{0, 0}, {end, kSidePx}}, VkRect2D{{at, 0}, {kSidePx - end, kSidePx}},
                               VkRect2D{{0, 0}, {kSidePx, end}}, VkRect2D{{0, at}, {kSidePx, kSidePx - end}}}) {
      const Wall wall{px, 1.5f};
      expect_same(shot, kDepths[0], {&wall, 1}, "a wall to " + std::to_string(end));
    }
  }
}

TEST_P(OccluderTest, TheImageMayBeOfTheViewAlone) {
  place_rows();
  const Depth& depth = kDepths[0];
  Shot shot = shot_of(create_depth_view(depth), depth);
  shot.x_px = 37;
  shot.y_px = 11;
  pump_until_settled(shot);
  const std::vector<Wall> walls = random_walls(9, kSidePx);
  std::vector<Wall> in_attachments = walls;
  for (Wall& wall : in_attachments) wall.px.offset = {wall.px.offset.x + shot.x_px, wall.px.offset.y + shot.y_px};
  const auto [by_attachment, without] = expect_same(shot, depth, in_attachments, "the attachment");
  // As large as the picture; and as a part of that, beyond which nothing hides.
  for (const std::uint32_t width_px : {kSidePx, kSidePx / 2}) {
    const Image image(gpu(), depth_attachment(width_px, kSidePx, depth.format));
    std::vector<Wall> shown;
    for (Wall wall : walls) {
      if (wall.px.offset.x >= static_cast<std::int32_t>(width_px)) continue;
      wall.px.extent.width = std::min(wall.px.extent.width, width_px - static_cast<std::uint32_t>(wall.px.offset.x));
      shown.push_back(wall);
    }
    submit(gpu(), [&](VkCommandBuffer cmd) { draw_walls(cmd, image, depth, shown); });
    coppice_occluder occluder = defaults(coppice_occluder_init);
    occluder.x_px = -shot.x_px;
    occluder.y_px = -shot.y_px;
    const auto [with, again] = expect_same(shot, depth, in_attachments, "an image of its own", occluder, &image);
    EXPECT_EQ(again, without);
    if (!is_used()) continue;
    if (width_px == kSidePx) {
      EXPECT_EQ(with, by_attachment);
    } else {
      EXPECT_GT(with, by_attachment);
      EXPECT_LT(with, without);
    }
  }
}

TEST_P(OccluderTest, BothEyesOfAPairHaveTheirs) {
  place_rows();
  const Depth& depth = kDepths[0];
  Shot shot = shot_of(create_depth_view(depth), depth);
  coppice_eye second = eye_beside(shot, 0.065, 0.0);
  second.x_px = static_cast<std::int32_t>(kSidePx);
  shot.second_eye = &second;
  pump_until_settled(shot);
  const std::array walls{Wall{{{0, 0}, {2 * kSidePx, kSidePx}}, 1.5f}, Wall{kAll, 1.5f}};
  const auto [none, all] = expect_same(shot, depth, std::span(walls).first(1), "before both eyes");
  const auto [seen, again] = expect_same(shot, depth, std::span(walls).last(1), "before one eye");
  EXPECT_GT(all, 5000u);
  EXPECT_EQ(again, all);
  if (is_used()) {
    EXPECT_LT(none, all / 5);
    EXPECT_GT(seen, all * 3 / 4) << "the other eye sees them";
  }
  for (const std::uint32_t seed : {1u, 2u}) expect_same(shot, depth, random_walls(seed, 2 * kSidePx), "walls of both eyes");
}

INSTANTIATE_TEST_SUITE_P(Paths, OccluderTest, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);

}  // namespace coppice::test::occluder_test
