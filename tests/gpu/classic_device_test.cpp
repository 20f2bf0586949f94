// A device without the feature dynamicRendering: where each view has a render pass nothing asks for it.

#include <algorithm>
#include <array>
#include <memory>

#include "path_fixture.h"
#include "render_pass.h"

namespace coppice::test::classic_device_test {

constexpr std::uint32_t kSidePx = 128;

/// A context with a plant, and no view but those with a pass.
class ClassicDeviceTest : public ContextTest, public testing::WithParamInterface<Path> {
 protected:
  static void SetUpTestSuite() { vulkan_device(Validation::on, Rendering::classic); }
  void SetUp() override {
    ContextTest::SetUp();
    ContextDesc with = desc();
    with.compute_raster = GetParam().compute_raster;
    ASSERT_EQ(create_context(with, &context_), COPPICE_OK) << log_;
    add(open_random({.leaf_count = 3000, .seed = 5}), placement_at());
  }
  void TearDown() override {
    destroy();  // before the passes
    passes_.clear();
    ContextTest::TearDown();
  }

  coppice_view create_pass_view(coppice_output output, ClassicPass& pass) {
    auto formats = defaults(coppice_vulkan_view_desc_init);
    if (output == COPPICE_OUTPUT_LIT) formats.color_formats[0] = VK_FORMAT_R8G8B8A8_SRGB;
    formats.depth_format = VK_FORMAT_D32_SFLOAT;
    formats.render_pass = pass.handle();
    return create_view(formats, output);
  }

  /// Pixels with depth.
  std::ptrdiff_t covered(const Shot& shot, ClassicPass& pass, std::span<const VkFormat> formats) {
    pump_until_settled(shot);
    const PassTarget target(gpu(), kSidePx, formats);
    frame_with(shot, [&](VkCommandBuffer cmd) {
      pass.begin(cmd, target);
      record_draw(cmd, shot);
      ClassicPass::end(cmd);
    });
    const auto depth = read_floats(gpu(), target.depth);
    return std::ranges::count_if(depth, [](float at) { return at > 0.0f; });
  }

  std::vector<std::unique_ptr<ClassicPass>> passes_;
};

TEST_P(ClassicDeviceTest, DrawsColourAndDepthAlone) {
  const std::array formats{VK_FORMAT_R8G8B8A8_SRGB};
  ClassicPass& lit = *passes_.emplace_back(std::make_unique<ClassicPass>(gpu(), ClassicPassDesc{.colors = {formats[0]}}));
  ClassicPass& alone = *passes_.emplace_back(std::make_unique<ClassicPass>(gpu(), ClassicPassDesc{}));
  Shot shot = make_view({.width_px = kSidePx, .view = create_pass_view(COPPICE_OUTPUT_LIT, lit)});
  EXPECT_GT(covered(shot, lit, formats), 500);
  shot.view = create_pass_view(COPPICE_OUTPUT_DEPTH, alone);
  EXPECT_GT(covered(shot, alone, {}), 500);
}

INSTANTIATE_TEST_SUITE_P(Paths, ClassicDeviceTest, testing::Values(kHardwarePath, kComputePath), path_name);

}  // namespace coppice::test::classic_device_test
