// libFuzzer: any bytes as a camera file are refused with the file's name, or are a path whose every pose is finite and can be drawn from.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "camera.h"
#include "check.h"
#include "failure.h"
#include "scratch_file.h"

namespace {

void check_pose(const forest::Pose& pose) {
  for (int axis = 0; axis < 3; ++axis) COPPICE_ASSERT(std::isfinite(pose.position[axis]));
  COPPICE_ASSERT(std::isfinite(pose.yaw_rad) && std::isfinite(pose.pitch_rad));
  COPPICE_ASSERT(pose.fov_y_rad > 0.017f && pose.fov_y_rad < 2.97f);  // 1 to 170 degrees
  const glm::mat4 clip = forest::clip_from_view(pose, 1.5f) * forest::view_from_world(pose);
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) COPPICE_ASSERT(std::isfinite(clip[column][row]));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const forest::Terrain terrain = forest::make_flat_terrain(20.0f, 1.0f);
  const std::string file = coppice::test::scratch_file("camera.txt", {data, size}).string();
  try {
    const forest::CameraPath path = forest::path_from_file(file, terrain);
    COPPICE_ASSERT(path.duration_s >= 0.0 && std::isfinite(path.duration_s));
    constexpr int kSteps = 12;
    for (int i = 0; i <= kSteps; ++i) check_pose(path.pose(path.duration_s * i / kSteps));
  } catch (const forest::Failure& failure) {
    COPPICE_ASSERT(std::string(failure.what()).find(file) != std::string::npos);
  }
  return 0;
}
