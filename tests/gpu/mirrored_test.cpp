// Plants with a scale below 0: the mirror image of the plant, on all paths, near and far.

#include <algorithm>

#include "path_fixture.h"

namespace coppice::test::mirrored_test {

constexpr std::uint32_t kSidePx = 160;

Picture flipped(const Picture& picture) {
  Picture result = picture;
  for (std::uint32_t y = 0; y < picture.height_px; ++y)
    for (std::uint32_t x = 0; x < picture.width_px; ++x)
      std::copy_n(picture.at(picture.width_px - 1 - x, y), 4, result.rgba.data() + (std::size_t{y} * picture.width_px + x) * 4);
  return result;
}

class MirroredTest : public PathTest<ContextTest> {
 protected:
  /// A single plant in the middle, lit from before and above.
  Picture picture_of(const coppice_placement& placement, float distance_m) {
    const coppice_instance instance = add(plant_, placement);
    Shot shot = make_view({.eye_m = {0, 0, distance_m}, .width_px = kSidePx});
    const glm::vec3 sun = glm::normalize(glm::vec3(0, 1, 1.5f));
    std::copy_n(&sun.x, 3, shot.light.sun_direction);
    pump_until_settled(shot);
    Picture picture = frame(shot);
    remove({&instance, 1});
    return picture;
  }
};

TEST_P(MirroredTest, IsTheMirrorImage) {
  const coppice_placement as_modelled = placement_at();
  coppice_placement mirrored = placement_at({}, -1.0f);
  mirrored.rotation[0] = 1;
  mirrored.rotation[3] = 0;
  for (const float distance_m : {2.5f, 6.0f, 12.0f, 30.0f}) {
    const Picture first = picture_of(as_modelled, distance_m), second = picture_of(mirrored, distance_m);
    const double off = rmse(first, second);
    EXPECT_GT(off, 2.0) << "the plant is symmetrical: this shows nothing";
    EXPECT_LT(rmse(first, flipped(second)), 0.2 * off) << distance_m << " m";
  }
}

INSTANTIATE_TEST_SUITE_P(Path, MirroredTest, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);

}  // namespace coppice::test::mirrored_test
