#include "camera.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <system_error>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>

#include "failure.h"

namespace forest {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kEyeHeight_m = 1.7f;
constexpr float kWalkingPace_mps = 1.4f;
constexpr float kNear_m = 0.1f;
constexpr float kMostValue = 1e6f;  // of a keyframe, metres or degrees: what is interpolated between such values stays finite
constexpr double kMostTime_s = 1e9;
constexpr float kLeastFov_deg = 1, kMostFov_deg = 170;
constexpr float kFar_m = 40000;  // a scene is tens of kilometres wide; reversed depth does not mind

struct Keyframe {
  double time_s = 0;
  float values[6] = {};  // x, height above ground, z, yaw, pitch, field of view; metres and degrees
};

float catmull_rom(float before, float from, float to, float after, float t) {
  const float slope_from = 0.5f * (to - before);
  const float slope_to = 0.5f * (after - from);
  const float t2 = t * t;
  const float t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * from + (t3 - 2 * t2 + t) * slope_from + (3 * t2 - 2 * t3) * to + (t3 - t2) * slope_to;
}

Keyframe interpolate(const std::vector<Keyframe>& keys, double time_s) {
  std::size_t next = 0;
  while (next < keys.size() && keys[next].time_s <= time_s) ++next;
  if (next == 0) return keys.front();
  if (next == keys.size()) return keys.back();
  const Keyframe& from = keys[next - 1];
  const Keyframe& to = keys[next];
  const Keyframe& before = keys[next >= 2 ? next - 2 : 0];
  const Keyframe& after = keys[std::min(next + 1, keys.size() - 1)];
  const auto t = static_cast<float>((time_s - from.time_s) / (to.time_s - from.time_s));
  Keyframe key;
  for (std::size_t i = 0; i < std::size(key.values); ++i)
    key.values[i] = catmull_rom(before.values[i], from.values[i], to.values[i], after.values[i], t);
  key.values[5] = std::clamp(key.values[5], kLeastFov_deg, kMostFov_deg);  // the curve goes beyond what it joins
  return key;
}

Pose pose_of(const Keyframe& key, const Terrain& terrain) {
  Pose pose;
  pose.position = {key.values[0], height_at(terrain, key.values[0], key.values[2]) + key.values[1], key.values[2]};
  pose.yaw_rad = glm::radians(key.values[3]);
  pose.pitch_rad = glm::radians(key.values[4]);
  pose.fov_y_rad = glm::radians(key.values[5]);
  return pose;
}

Keyframe parse_keyframe(const std::string& line, const std::string& place) {
  std::istringstream words(line);
  Keyframe key;
  key.values[5] = glm::degrees(Pose{}.fov_y_rad);
  words >> key.time_s;
  for (int i = 0; i < 5; ++i) words >> key.values[i];
  if (!words) throw Failure(place + ": expected time_s x_m height_m z_m yaw_deg pitch_deg [fov_y_deg]");
  std::string rest;
  if (words >> rest) {
    std::size_t used = 0;
    try {
      key.values[5] = std::stof(rest, &used);
    } catch (const std::logic_error&) {
      used = 0;
    }
    if (used != rest.size() || words >> rest) throw Failure(place + ": unexpected '" + rest + "'");
  }
  if (!std::all_of(std::begin(key.values), std::end(key.values), [](float value) { return std::abs(value) <= kMostValue; }) ||
      !(std::abs(key.time_s) <= kMostTime_s))
    throw Failure(place + ": a value is not finite or over 1e6, a time over 1e9");
  if (key.values[5] < kLeastFov_deg || key.values[5] > kMostFov_deg) throw Failure(place + ": fov_y_deg must be 1 to 170");
  return key;
}

}  // namespace

CameraPath walk_path(const Trail& trail, const Terrain& terrain) {
  CameraPath path;
  path.loops = true;
  path.duration_s = length_m(trail) / kWalkingPace_mps;
  path.pose = [trail, &terrain, total_s = path.duration_s](double time_s) {
    const float distance_m = static_cast<float>(time_s) * kWalkingPace_mps;
    // The mean over a few steps: the polyline's corners must not turn the head.
    glm::vec2 here(0);
    for (int step = -2; step <= 2; ++step) here += 0.2f * point_on(trail, distance_m + 0.5f * static_cast<float>(step));
    const glm::vec2 ahead = point_on(trail, distance_m + 8);
    const glm::vec2 towards = ahead - here;
    const auto turns = static_cast<float>(time_s / total_s);
    Pose pose;
    pose.position = {here.x, height_at(terrain, here.x, here.y) + kEyeHeight_m, here.y};
    pose.yaw_rad = std::atan2(-towards.x, -towards.y) + 0.35f * std::sin(2 * kPi * 5 * turns);
    pose.pitch_rad = 0.06f + 0.05f * std::sin(2 * kPi * 3 * turns);
    return pose;
  };
  return path;
}

CameraPath orbit_path(float half_extent_m, const Terrain& terrain) {
  CameraPath path;
  path.loops = true;
  path.duration_s = 60;
  path.pose = [half_extent_m, &terrain, total_s = path.duration_s](double time_s) {
    const auto angle = static_cast<float>(2 * kPi * time_s / total_s);
    const float radius_m = 0.85f * half_extent_m;
    Pose pose;
    pose.position = {radius_m * std::sin(angle), 0, radius_m * std::cos(angle)};
    pose.position.y = height_at(terrain, 0, 0) + 12 + 0.12f * half_extent_m;
    pose.yaw_rad = angle;
    pose.pitch_rad = -0.27f;
    return pose;
  };
  return path;
}

CameraPath path_from_file(const std::string& file, const Terrain& terrain) {
  std::error_code absent;
  if (std::filesystem::exists(file, absent) && !std::filesystem::is_regular_file(file, absent))
    throw Failure("--camera: " + file + " is not a plain file");
  std::ifstream stream(file);
  if (!stream) throw Failure("--camera: cannot read " + file + ": " + std::strerror(errno));
  std::vector<Keyframe> keys;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string place = file + ":" + std::to_string(number);
    keys.push_back(parse_keyframe(line, place));
    if (keys.size() > 1 && keys.back().time_s <= keys[keys.size() - 2].time_s) throw Failure(place + ": times must ascend");
  }
  if (keys.empty()) throw Failure("--camera: no keyframe in " + file);
  CameraPath path;
  path.duration_s = keys.back().time_s - keys.front().time_s;
  path.pose = [keys, &terrain](double time_s) { return pose_of(interpolate(keys, keys.front().time_s + time_s), terrain); };
  return path;
}

PathRecorder start_recording(const std::string& file) {
  PathRecorder recorder;
  recorder.file = file;
  recorder.stream.open(file);
  recorder.stream << "# time_s x_m height_m z_m yaw_deg pitch_deg fov_y_deg\n";
  if (!recorder.stream) throw Failure("cannot write " + file);
  return recorder;
}

void record_pose(PathRecorder& recorder, double time_s, const Pose& pose, const Terrain& terrain) {
  constexpr double kBetween_s = 0.25;
  if (time_s < recorder.next_s) return;
  recorder.next_s = time_s + kBetween_s;
  const float yaw_deg = glm::degrees(pose.yaw_rad);
  recorder.yaw_deg = yaw_deg - 360 * std::round((yaw_deg - recorder.yaw_deg) / 360);
  const glm::vec3& at = pose.position;
  recorder.stream << time_s << ' ' << at.x << ' ' << at.y - height_at(terrain, at.x, at.z) << ' ' << at.z << ' ' << recorder.yaw_deg << ' '
                  << glm::degrees(pose.pitch_rad) << ' ' << glm::degrees(pose.fov_y_rad) << '\n';
  if (!recorder.stream.flush()) throw Failure("cannot write " + recorder.file);
}

glm::vec3 forward(const Pose& pose) {
  const float flat = std::cos(pose.pitch_rad);
  return {-std::sin(pose.yaw_rad) * flat, std::sin(pose.pitch_rad), -std::cos(pose.yaw_rad) * flat};
}

glm::mat4 view_from_world(const Pose& pose) {
  // Turned first, then moved: far from the origin the eye plus a step rounds to straight up, which has no side.
  return glm::translate(glm::lookAt(glm::vec3(0), forward(pose), glm::vec3(0, 1, 0)), -pose.position);
}

glm::mat4 clip_from_view(const Pose& pose, float aspect) {
  const float scale = 1 / std::tan(0.5f * pose.fov_y_rad);
  glm::mat4 clip(0);
  clip[0][0] = scale / aspect;
  clip[1][1] = -scale;
  clip[2][2] = kNear_m / (kFar_m - kNear_m);
  clip[2][3] = -1;
  clip[3][2] = kNear_m * kFar_m / (kFar_m - kNear_m);
  return clip;
}

}  // namespace forest
