#pragma once

#include <functional>
#include <string>

#include <glm/glm.hpp>

#include "output.h"
#include "terrain.h"
#include "trail.h"

namespace forest {

/// Where the camera is. yaw 0 looks along -Z and grows to the left (towards -X); pitch grows upwards.
struct Pose {
  glm::vec3 position = {0, 2, 0};
  float yaw_rad = 0;
  float pitch_rad = 0;
  float fov_y_rad = 1.05f;
};

/// What a camera is to show: world space, metres.
struct Box {
  glm::vec3 min, max;
};

struct CameraPath {
  double duration_s = 1;
  bool loops = false;                ///< the end joins the beginning
  std::function<Pose(double)> pose;  ///< pose at a time in [0, duration_s]
};

/// Time in the path of a frame, s: so many frames a second, or, with 0, `frames` frames spread evenly so that the last one is its end.
double frame_time_s(const CameraPath& path, std::uint32_t frame, std::uint32_t frames, float frames_per_s);

/// Along the trail at eye height and walking pace, looking ahead and slowly to the sides.
CameraPath walk_path(const Trail& trail, const Terrain& terrain);
/// Round the planted square, above the crowns, looking down into it.
CameraPath orbit_path(float half_extent_m, const Terrain& terrain);
/// Round the box, from a little above, with all of it in the picture at any time. aspect: of the picture, its width over its height.
CameraPath turntable_path(const Box& box, float aspect, const Terrain& terrain);
/// The camera stands still and sees all of the box: from its front, which in glTF is +Z, or from above, with -Z at the picture's top.
CameraPath front_path(const Box& box, float aspect, const Terrain& terrain);
CameraPath top_path(const Box& box, float aspect, const Terrain& terrain);
/// Keyframes from a text file, one a line, `#` starts a comment:
///
///     time_s  x_m  height_m  z_m  yaw_deg  pitch_deg  [fov_y_deg]
///
/// Times ascend. height_m is above the ground below (x, z). Between keyframes everything is interpolated smoothly (Catmull-Rom).
/// errors  Failure: unreadable, no keyframe, or a bad line (file:line and what is wrong)
CameraPath path_from_file(const std::string& file, const Terrain& terrain);

/// A camera's way on its way to a file that path_from_file reads.
struct PathRecorder {
  GrowingOutput output;
  double next_s = 0;  ///< earlier poses are left out
  float yaw_deg = 0;  ///< yaw of the latest keyframe: the next one turns the shorter way
};
/// errors  Failure: the file cannot be written
PathRecorder start_recording(const std::string& file);
/// Adds a keyframe every quarter of a second. time_s: since the start, ascending. errors  Failure: the file cannot be written
void record_pose(PathRecorder& recorder, double time_s, const Pose& pose, const Terrain& terrain);

glm::vec3 forward(const Pose& pose);
/// Unit and level, whatever the pitch.
glm::vec3 right(const Pose& pose);
glm::mat4 view_from_world(const Pose& pose);
/// Vulkan clip space, reversed depth: 1 at the near plane, 0 at the far plane.
glm::mat4 clip_from_view(const Pose& pose, float aspect);

}  // namespace forest
