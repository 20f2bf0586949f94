// What an engine changes about the surfaces of plants: coppice_set_material_override, and its own function.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include <glm/glm.hpp>

#include "path_fixture.h"
#include "render_pass.h"

namespace coppice::test::material_test {

constexpr std::uint32_t kSidePx = 160;
constexpr std::array kSurface{
    Color{VK_FORMAT_R32G32B32A32_SFLOAT, COPPICE_CONTENT_ALBEDO}, Color{VK_FORMAT_R32G32B32A32_SFLOAT, COPPICE_CONTENT_NORMAL},
    Color{VK_FORMAT_R32G32B32A32_SFLOAT, COPPICE_CONTENT_LIGHT}, Color{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_USER}};

/// What a view's attachments hold of its pixels.
struct Surfaces {
  std::vector<glm::vec4> albedo, normal, light;
  std::vector<std::uint32_t> user;
  [[nodiscard]] bool shows(std::size_t i) const { return light[i].w == 0.0f; }  // cleared to white
  [[nodiscard]] bool is_wood(std::size_t i) const { return light[i].x == 0.0f; }
  [[nodiscard]] bool is_changed(std::size_t i) const { return user[i] % 2 != 0; }
  bool operator==(const Surfaces&) const = default;
};

class MaterialTest : public PathTest<ContextTest> {
 protected:
  /// Every other plant is of a second file, whose overrides are set.
  void place() {
    changed_ = open(path_);
    view_ = create_view(view_formats(kSurface), COPPICE_OUTPUT_SURFACE);
    std::vector<coppice_placement> placements = rows();
    for (std::size_t i = 0; i < placements.size(); ++i) {
      placements[i].user_data = i % 2;
      placements[i].tint[1] = 0.5f;
      add(i % 2 == 0 ? plant_ : changed_, placements[i]);
    }
  }

  Surfaces draw(const coppice_material_override* material_override, float distance_m) {
    EXPECT_EQ(coppice_set_material_override(context_, changed_, material_override), COPPICE_OK) << log_;
    const Shot shot = make_view({.eye_m = {0.5f, 1.0f, distance_m}, .width_px = kSidePx});
    const PassTarget target(gpu(), kSidePx, formats_of(kSurface));
    pump_until_settled(shot);
    frame_with(shot, [&](VkCommandBuffer cmd) {
      target.begin_cleared(cmd);
      record_draw(cmd, shot);
      vkCmdEndRendering(cmd);
    });
    const auto texels = [&](std::size_t i) { return read_texels<glm::vec4>(gpu(), *target.colors[i]); };
    return {texels(0), texels(1), texels(2), read_texels<std::uint32_t>(gpu(), *target.colors[3])};
  }

  coppice_plant changed_ = 0;
};

/// What one path says for all.
class MaterialCallsTest : public MaterialTest {};

/// Near, where the hardware draws, and far.
TEST_P(MaterialTest, AnOverrideChangesThePlantsSurfacesAndNoOthers) {
  place();
  auto wanted = defaults(coppice_material_override_init);
  const glm::vec3 leaf_tint(0.5f, 2.0f, 0.25f), wood_tint(1.5f, 0.75f, 1.0f);
  std::ranges::copy(std::array{leaf_tint.x, leaf_tint.y, leaf_tint.z}, wanted.leaf_tint);
  std::ranges::copy(std::array{wood_tint.x, wood_tint.y, wood_tint.z}, wanted.wood_tint);
  wanted.leaf_roughness = 0.125f;
  wanted.wood_roughness = 0.375f;
  wanted.translucency = 0.75f;
  for (const float distance_m : {3.0f, 30.0f}) {
    const Surfaces own = draw(nullptr, distance_m), changed = draw(&wanted, distance_m);
    std::size_t leaves = 0, wood = 0, others = 0;
    for (std::size_t i = 0; i < own.light.size(); ++i) {
      if (!own.shows(i)) continue;
      ASSERT_EQ(changed.user[i], own.user[i]);
      const bool is_ours = own.is_changed(i), is_wood = own.is_wood(i);
      ++(!is_ours ? others : is_wood ? wood : leaves);
      const glm::vec3 tint = !is_ours ? glm::vec3(1) : is_wood ? wood_tint : leaf_tint;
      ASSERT_LT(glm::length(glm::vec3(changed.albedo[i]) - tint * glm::vec3(own.albedo[i])), 1e-5f) << i;
      ASSERT_EQ(changed.normal[i].z, !is_ours ? own.normal[i].z : is_wood ? 0.375f : 0.125f) << i;
      ASSERT_EQ(changed.light[i].x, is_ours && !is_wood ? 0.75f : own.light[i].x) << i;
      ASSERT_EQ(changed.albedo[i].w, own.albedo[i].w) << "occlusion is the plant's own, " << i;
    }
    EXPECT_GT(leaves, 200u);
    EXPECT_GT(others, 200u);
    EXPECT_GT(wood, 10u);
    EXPECT_TRUE(draw(nullptr, distance_m) == own) << "it is removed";
  }
}

TEST_P(MaterialCallsTest, AnOverrideStaysOverAReload) {
  place();
  auto wanted = defaults(coppice_material_override_init);
  wanted.leaf_roughness = 0.125f;
  const Surfaces before = draw(&wanted, 5.0f);
  ASSERT_EQ(coppice_plant_reload(context_, changed_, nullptr), COPPICE_OK) << log_;
  const Surfaces after = draw(&wanted, 5.0f);
  const auto count = [](const Surfaces& all) {
    return std::ranges::count_if(all.normal, [](const glm::vec4& normal) { return normal.z == 0.125f; });
  };
  EXPECT_GT(count(before), 200);
  EXPECT_EQ(count(after), count(before));
}

#ifdef COPPICE_HAS_ENGINE_SURFACE
/// The preset dev builds all with snow.glsl, in which snow lies on what faces the sky, as deep as the first parameter says.
TEST_P(MaterialTest, AnEnginesFunctionChangesSurfaces) {
  place();
  auto wanted = defaults(coppice_material_override_init);
  for (const float distance_m : {3.0f, 30.0f}) {
    const Surfaces own = draw(nullptr, distance_m);
    wanted.parameters[0] = 1.0f;
    const Surfaces snow = draw(&wanted, distance_m);
    std::size_t white = 0;
    for (std::size_t i = 0; i < own.light.size(); ++i) {
      if (!own.shows(i)) continue;
      if (own.is_changed(i) && snow.albedo[i].x > 0.5f) ++white;
      if (!own.is_changed(i)) {
        ASSERT_EQ(snow.albedo[i], own.albedo[i]);
      }
    }
    EXPECT_GT(white, 100u) << distance_m;
    wanted.parameters[0] = 0.0f;
    EXPECT_TRUE(draw(&wanted, distance_m) == own);
  }
}
#endif

TEST_P(MaterialCallsTest, WhatCannotBeIsRefused) {
  const auto expect_refused = [&](const char* field, auto&& change) {
    auto wrong = defaults(coppice_material_override_init);
    change(wrong);
    EXPECT_EQ(coppice_set_material_override(context_, plant_, &wrong), COPPICE_ERROR_INVALID_ARGUMENT) << field;
    EXPECT_NE(std::string(coppice_last_error(context_)).find(std::string("material_override.") + field), std::string::npos)
        << coppice_last_error(context_);
  };
  using Override = coppice_material_override;
  expect_refused("struct_size", [](Override& wrong) { wrong.struct_size = 0; });
  expect_refused("leaf_tint", [](Override& wrong) { wrong.leaf_tint[2] = -0.1f; });
  expect_refused("wood_tint", [](Override& wrong) { wrong.wood_tint[0] = std::numeric_limits<float>::infinity(); });
  expect_refused("leaf_roughness", [](Override& wrong) { wrong.leaf_roughness = 1.1f; });
  expect_refused("wood_roughness", [](Override& wrong) { wrong.wood_roughness = -0.5f; });
  expect_refused("translucency", [](Override& wrong) { wrong.translucency = std::nanf(""); });
  expect_refused("parameters", [](Override& wrong) { wrong.parameters[3] = 2e9f; });
  EXPECT_EQ(coppice_set_material_override(context_, plant_ + 1, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);
}

INSTANTIATE_TEST_SUITE_P(Paths, MaterialTest, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);
INSTANTIATE_TEST_SUITE_P(Path, MaterialCallsTest, testing::Values(kHardwarePath), path_name);

}  // namespace coppice::test::material_test
