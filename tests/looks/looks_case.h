#pragma once

// Plants made to look at. A family of them is a file of its own, named in looks_families of tests/CMakeLists.txt:
//
//     GltfBuilder reed(bool with_stems) { ... }
//
//     INSTANTIATE_TEST_SUITE_P(Reeds, LooksTest,
//                              testing::Values(LooksCase{.name = "thin_stems",
//                                                        .plant = [] { return reed(true); },
//                                                        .defect = [] { return reed(false); }}),
//                              looks_name);

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bake.h"
#include "gltf_builder.h"
#include "looks_stage.h"
#include "plant_shapes.h"

namespace coppice::test {

struct LooksCase {
  const char* name = "";  ///< letters, digits and _
  std::function<GltfBuilder()> plant;
  /// The plant without what is hard about its file, baked without options: what is seen of either must be the same. None: the plant.
  std::function<GltfBuilder()> reference = {};
  /// The plant as the fault would show it. Its full detail must not pass for the plant.
  std::function<GltfBuilder()> defect;
  bake::BakeOptions bake = {};
  glm::vec3 from{0.6f, 0.25f, 1.0f};                   ///< where the camera is, seen from the plant
  std::vector<float> sizes_px{480, 240, 120, 60, 30};  ///< how wide the plant's bounding sphere is: five distances
  float defect_size_px = 120;                          ///< the one of them at which the defect is compared
};

/// Bakes a .glb; prints the warnings. returns  the .coppice file, which lies beside it
std::filesystem::path bake_file(const std::filesystem::path& glb, const bake::BakeOptions& options);

/// The same for a plant that is written to `folder` first.
std::filesystem::path bake_plant(const std::filesystem::path& folder, const std::string& name, const GltfBuilder& plant,
                                 const bake::BakeOptions& options);

/// Draws a case's plant at every size on both paths and compares with its reference's full detail on the hardware path.
class LooksTest : public VulkanTest, public testing::WithParamInterface<LooksCase> {};

inline std::string looks_name(const testing::TestParamInfo<LooksCase>& info) {
  return info.param.name;
}
inline void PrintTo(const LooksCase& each, std::ostream* out) {
  *out << each.name;
}

}  // namespace coppice::test
