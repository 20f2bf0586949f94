// Wood is lit on the side that is seen, whichever way round its triangles are and the picture is.

#include "looks_case.h"
#include "process.h"

namespace coppice::test::two_sided {

/// A sheet of wood before the origin. It looks along +z; or each triangle the other way round, but not its normals.
GltfBuilder sheet(bool is_turned) {
  GltfBuilder builder;
  Shape card;
  add_card(card, {-1, 0, 0}, {2, 0, 0}, {0, 2, 0});
  if (is_turned)
    for (std::size_t i = 0; i < card.indices.size(); i += 3) std::swap(card.indices[i], card.indices[i + 1]);
  add_shape(builder, card, add_surface(builder, {.name = "bark", .base_color = {0.4f, 0.4f, 0.4f, 1}}), "trunk");
  return builder;
}

/// The mean over the pixels that it covers, 0..255.
float mean_red(const MeanPicture& picture) {
  float sum = 0, count = 0;
  for (const glm::vec4& texel : picture.texels)
    if (texel.a > 0.99f) sum += texel.r, ++count;
  return sum / count;
}

class TwoSided : public VulkanTest, public testing::WithParamInterface<bool> {};

TEST_P(TwoSided, WoodIsLitOnTheSideThatIsSeen) {
  const TemporaryFolder folder;
  const std::filesystem::path file = bake_plant(folder.path(), "sheet", sheet(GetParam()), {});
  LooksStage hardware(gpu(), file, LooksPath::hardware), compute(gpu(), file, LooksPath::compute);
  const glm::vec3 front(0.3f, 0.2f, 1), back(0.3f, 0.2f, -1);  // the sun is before it
  for (const float size_px : {240.0f, 14.0f}) {
    const LooksView view{hardware.sphere(), size_px, front};
    const float lit = mean_red(hardware.draw(view));
    LooksView behind = view;
    behind.from = back;
    const float unlit = mean_red(hardware.draw(behind));
    EXPECT_GT(lit, unlit + 20.0f) << size_px;
    EXPECT_NEAR(mean_red(compute.draw(view)), lit, 3.0f) << size_px;
    EXPECT_NEAR(mean_red(compute.draw(behind)), unlit, 3.0f) << size_px;
    LooksView upside_down = view;
    upside_down.y_up = true;
    EXPECT_NEAR(mean_red(hardware.draw(upside_down)), lit, 3.0f) << size_px;
  }
}

std::string sheet_name(const testing::TestParamInfo<bool>& info) {
  return info.param ? "turned" : "as_its_normals";
}

INSTANTIATE_TEST_SUITE_P(Sheets, TwoSided, testing::Bool(), sheet_name);

}  // namespace coppice::test::two_sided
