// Masked cards that are seen nearly edge-on cover what their angle leaves of them. A mip level that fits a pixel's long footprint blurs
// their mask into one value, and they become poles or vanish.

#include <cmath>

#include "looks_case.h"
#include "process.h"

namespace coppice::test::edge_on {

constexpr std::uint32_t kCards = 6;

/// Cards above each other in the plane z = 0. Stalks cover a quarter of them.
GltfBuilder comb() {
  GltfBuilder builder;
  const auto stalks = [](float u, float) {
    return Rgba{60, 120, 30, std::fmod(2.0f * u, 1.0f) < 0.25f ? std::uint8_t{255} : std::uint8_t{0}};
  };
  const int leaves = add_surface(builder, {.name = "leaves", .image = painted_png(256, 256, stalks), .alpha_cutoff = 0.5f});
  Shape cards;
  for (std::uint32_t i = 0; i < kCards; ++i) add_card(cards, {-0.5f, static_cast<float>(i), 0}, {1, 0, 0}, {0, 0.9f, 0});
  add_shape(builder, cards, leaves, "cards");
  return builder;
}

float covered_px(const MeanPicture& picture) {
  float sum = 0;
  for (const glm::vec4& texel : picture.texels) sum += texel.a;
  return sum;
}

class EdgeOn : public VulkanTest {};

TEST_F(EdgeOn, CardsCoverWhatTheirAngleLeaves) {
  const TemporaryFolder folder;
  const std::filesystem::path file = bake_plant(folder.path(), "comb", comb(), {});
  LooksStage hardware(gpu(), file, LooksPath::hardware), compute(gpu(), file, LooksPath::compute);
  constexpr float kSine = 0.0872f;  // 5 degrees
  const glm::vec3 front(0, 0, 1), edge(std::sqrt(1.0f - kSine * kSine), 0, kSine);
  for (LooksStage* stage : {&hardware, &compute})
    for (const float size_px : {480.0f, 240.0f}) {
      const float whole_px = covered_px(stage->draw({.sphere = stage->sphere(), .size_px = size_px, .from = front}));
      const float seen_px = covered_px(stage->draw({.sphere = stage->sphere(), .size_px = size_px, .from = edge}));
      std::printf("%g px: %.1f px from the front, %.1f px edge-on\n", static_cast<double>(size_px), static_cast<double>(whole_px),
                  static_cast<double>(seen_px));
      EXPECT_NEAR(seen_px / (kSine * whole_px), 1.0f, 0.3f) << size_px;
    }
}

}  // namespace coppice::test::edge_on
