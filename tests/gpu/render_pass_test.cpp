// Views of engines with classic render passes: each attachment is what dynamic rendering draws, to the byte.

#include <array>
#include <memory>

#include "path_fixture.h"
#include "render_pass.h"

namespace coppice::test::render_pass_test {

constexpr std::uint32_t kSidePx = 128;

/// What a view draws to, and in which subpass.
struct Case {
  const char* name;
  coppice_output output;
  std::vector<Color> colors;
  std::uint32_t subpass = 0;
};

std::vector<Case> cases() {
  const Color lit{VK_FORMAT_R8G8B8A8_SRGB, COPPICE_CONTENT_LIT}, albedo{VK_FORMAT_R8G8B8A8_SRGB, COPPICE_CONTENT_ALBEDO},
      normal{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_NORMAL}, light{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_LIGHT},
      user{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_USER}, none{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_NONE},
      velocity{VK_FORMAT_R32G32B32A32_SFLOAT, COPPICE_CONTENT_VELOCITY, 16};
  return {{"lit", COPPICE_OUTPUT_LIT, {lit}},
          {"lit_in_subpass_2", COPPICE_OUTPUT_LIT, {lit}, 2},
          {"surface", COPPICE_OUTPUT_SURFACE, {albedo, normal, light, user, velocity}},
          {"two_of_three_in_subpass_1", COPPICE_OUTPUT_SURFACE, {albedo, none, user}, 1},
          {"depth", COPPICE_OUTPUT_DEPTH, {}}};
}

std::vector<VkFormat> drawn_formats(const Case& of) {
  std::vector<VkFormat> formats;
  for (const Color& color : of.colors)
    if (color.content != COPPICE_CONTENT_NONE) formats.push_back(color.format);
  return formats;
}

/// Where a content is drawn to; of COPPICE_CONTENT_NONE an unused reference.
ClassicPassDesc pass_desc(const Case& of, bool clears) {
  ClassicPassDesc desc{.colors = {}, .subpass = of.subpass, .clears = clears};
  for (const Color& color : of.colors) desc.colors.push_back(color.content == COPPICE_CONTENT_NONE ? VK_FORMAT_UNDEFINED : color.format);
  return desc;
}

class RenderPassTest : public PathTest<ContextTest> {
 protected:
  void TearDown() override {
    destroy();  // before the passes
    passes_.clear();
    PathTest::TearDown();
  }

  coppice_view create_case_view(const Case& of, VkRenderPass pass) {
    coppice_vulkan_view_desc formats = view_formats(of.colors);
    formats.render_pass = pass;
    formats.subpass = pass == VK_NULL_HANDLE ? 0 : of.subpass;
    return create_view(formats, of.output);
  }

  ClassicPass& add_pass(const ClassicPassDesc& desc) { return *passes_.emplace_back(std::make_unique<ClassicPass>(gpu(), desc)); }

  /// All attachments but those that nothing is drawn to, one behind the other.
  std::vector<std::uint8_t> bytes_of(const Case& of, const PassTarget& target) {
    std::vector<std::uint8_t> all;
    std::size_t next = 0;
    for (const Color& color : of.colors) {
      if (color.content == COPPICE_CONTENT_NONE) continue;
      const auto bytes = read_bytes(gpu(), *target.colors[next++], color.pixel_bytes);
      all.insert(all.end(), bytes.begin(), bytes.end());
    }
    const auto depth = read_bytes(gpu(), target.depth, sizeof(float));
    all.insert(all.end(), depth.begin(), depth.end());
    return all;
  }

  std::vector<std::uint8_t> draw_dynamic(const Case& of, const Shot& shot) {
    PassTarget target(gpu(), kSidePx, formats_of(of.colors));
    frame_with(shot, [&](VkCommandBuffer cmd) {
      target.begin_cleared(cmd);
      record_draw(cmd, shot);
      vkCmdEndRendering(cmd);
    });
    // Without the attachments that nothing is drawn to.
    for (std::size_t i = of.colors.size(); i-- > 0;)
      if (of.colors[i].content == COPPICE_CONTENT_NONE) target.colors.erase(target.colors.begin() + static_cast<std::ptrdiff_t>(i));
    return bytes_of(of, target);
  }

  std::vector<std::unique_ptr<ClassicPass>> passes_;
};

/// Near, where the hardware draws too, and far. The view is made for a pass that loads, and drawn in one that clears.
TEST_P(RenderPassTest, EachAttachmentIsWhatDynamicRenderingDraws) {
  add(plant_, rows());
  for (const Case& each : cases()) {
    const coppice_view dynamic = create_case_view(each, VK_NULL_HANDLE);
    const ClassicPass& wanted = add_pass(pass_desc(each, false));
    ClassicPass& drawn = add_pass(pass_desc(each, true));
    const coppice_view classic = create_case_view(each, wanted.handle());
    for (const float distance_m : {3.0f, 25.0f}) {
      Shot shot = make_view({.eye_m = {0.5f, 1.0f, distance_m}, .width_px = kSidePx});
      const std::array views{dynamic, classic};
      for (const coppice_view view : views) {
        shot.view = view;
        pump_until_settled(shot);
      }
      shot.view = dynamic;
      pump(shot);
      const std::vector<std::uint8_t> expected = draw_dynamic(each, shot);
      shot.view = classic;
      pump(shot);
      const PassTarget target(gpu(), kSidePx, drawn_formats(each));
      frame_with(shot, [&](VkCommandBuffer cmd) {
        drawn.begin(cmd, target);
        record_draw(cmd, shot);
        ClassicPass::end(cmd);
      });
      EXPECT_TRUE(bytes_of(each, target) == expected) << each.name << " from " << distance_m << " m";
      const auto depth = read_floats(gpu(), target.depth, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
      EXPECT_GT(std::ranges::count_if(depth, [](float at) { return at > 0.0f; }), 500) << each.name;
    }
    coppice_view_destroy(context_, dynamic);
    coppice_view_destroy(context_, classic);
  }
}

INSTANTIATE_TEST_SUITE_P(Paths, RenderPassTest, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);

}  // namespace coppice::test::render_pass_test
