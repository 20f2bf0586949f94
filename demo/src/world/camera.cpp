#include "camera.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <system_error>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>

#include "failure.h"
#include "output.h"

namespace forest {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kEyeHeight_m = 1.7f;
constexpr float kWalkingPace_mps = 1.4f;
constexpr float kNear_m = 0.1f;
constexpr float kMaxValue = 1e6f;  // limit of a keyframe's values, metres or degrees, so that interpolated values stay finite
constexpr double kMaxTime_s = 1e9;
constexpr float kMinFov_deg = 1, kMaxFov_deg = 170;
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
  key.values[5] = std::clamp(key.values[5], kMinFov_deg, kMaxFov_deg);  // the curve goes beyond what it joins
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
  if (!std::all_of(std::begin(key.values), std::end(key.values), [](float value) { return std::abs(value) <= kMaxValue; }) ||
      !(std::abs(key.time_s) <= kMaxTime_s))
    throw Failure(place + ": a value is not finite or over 1e6, a time over 1e9");
  if (key.values[5] < kMinFov_deg || key.values[5] > kMaxFov_deg) throw Failure(place + ": fov_y_deg must be 1 to 170");
  return key;
}

/// How far from the box's middle the camera must be to see all of it, with some room round it.
float framing_distance_m(const Box& box, const Pose& pose, float aspect) {
  constexpr float kFilled = 0.95f;  // share of the picture's width or height
  const float up_share = kFilled * std::tan(0.5f * pose.fov_y_rad), right_share = up_share * aspect;
  const glm::vec3 ahead = forward(pose), side = right(pose), up = glm::cross(side, ahead);
  const glm::vec3 half = 0.5f * (box.max - box.min);
  float distance_m = 2 * kNear_m;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 at = half * glm::vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const float farther_m = std::max(std::abs(glm::dot(at, side)) / right_share, std::abs(glm::dot(at, up)) / up_share);
    distance_m = std::max(distance_m, farther_m - glm::dot(at, ahead));
  }
  return distance_m;
}

/// Looks at the box's middle from so far; from higher up where that would be in the ground.
Pose facing(const Box& box, Pose pose, float distance_m, const Terrain& terrain) {
  constexpr float kAboveGround_m = 0.3f;
  const glm::vec3 middle = 0.5f * (box.min + box.max);
  pose.position = middle - distance_m * forward(pose);
  const float least_m = height_at(terrain, pose.position.x, pose.position.z) + kAboveGround_m;
  if (pose.position.y >= least_m) return pose;
  pose.position.y = least_m;
  pose.pitch_rad =
      std::atan2(middle.y - least_m, glm::distance(glm::vec2(middle.x, middle.z), glm::vec2(pose.position.x, pose.position.z)));
  return pose;
}

Pose turned(float yaw_rad, float pitch_rad) {
  Pose pose;
  pose.yaw_rad = yaw_rad;
  pose.pitch_rad = pitch_rad;
  pose.fov_y_rad = 0.6f;  // narrower than a walker's: what is near does not grow out of proportion
  return pose;
}

CameraPath still_path(const Box& box, const Pose& direction, float aspect, const Terrain& terrain) {
  CameraPath path;
  path.pose = [pose = facing(box, direction, framing_distance_m(box, direction, aspect), terrain)](double) { return pose; };
  return path;
}

}  // namespace

double frame_time_s(const CameraPath& path, std::uint32_t frame, std::uint32_t frames, float frames_per_s) {
  if (frames_per_s == 0) return frames > 1 ? path.duration_s * frame / (frames - 1) : path.duration_s;
  const double time_s = frame / double{frames_per_s};
  return path.loops ? std::fmod(time_s, path.duration_s) : std::min(time_s, path.duration_s);
}

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

CameraPath turntable_path(const Box& box, float aspect, const Terrain& terrain) {
  constexpr float kPitch_rad = -0.15f;
  constexpr int kSteps = 64;
  float distance_m = 0;
  for (int step = 0; step < kSteps; ++step)
    distance_m = std::max(distance_m, framing_distance_m(box, turned(2 * kPi * static_cast<float>(step) / kSteps, kPitch_rad), aspect));
  CameraPath path;
  path.loops = true;
  path.duration_s = 20;
  path.pose = [box, distance_m, &terrain, total_s = path.duration_s](double time_s) {
    return facing(box, turned(static_cast<float>(2 * kPi * time_s / total_s), kPitch_rad), distance_m, terrain);
  };
  return path;
}

CameraPath front_path(const Box& box, float aspect, const Terrain& terrain) {
  return still_path(box, turned(0, 0), aspect, terrain);
}

CameraPath top_path(const Box& box, float aspect, const Terrain& terrain) {
  return still_path(box, turned(0, -0.5f * kPi), aspect, terrain);
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
  return {start_output(file, "# time_s x_m height_m z_m yaw_deg pitch_deg fov_y_deg\n")};
}

void record_pose(PathRecorder& recorder, double time_s, const Pose& pose, const Terrain& terrain) {
  constexpr double kBetween_s = 0.25;
  if (time_s < recorder.next_s) return;
  recorder.next_s = time_s + kBetween_s;
  const float yaw_deg = glm::degrees(pose.yaw_rad);
  recorder.yaw_deg = yaw_deg - 360 * std::round((yaw_deg - recorder.yaw_deg) / 360);
  const glm::vec3& at = pose.position;
  std::ostringstream line;
  line << time_s << ' ' << at.x << ' ' << at.y - height_at(terrain, at.x, at.z) << ' ' << at.z << ' ' << recorder.yaw_deg << ' '
       << glm::degrees(pose.pitch_rad) << ' ' << glm::degrees(pose.fov_y_rad) << '\n';
  add(recorder.output, line.str());
}

glm::vec3 forward(const Pose& pose) {
  const float flat = std::cos(pose.pitch_rad);
  return {-std::sin(pose.yaw_rad) * flat, std::sin(pose.pitch_rad), -std::cos(pose.yaw_rad) * flat};
}

glm::vec3 right(const Pose& pose) {
  return {std::cos(pose.yaw_rad), 0, -std::sin(pose.yaw_rad)};
}

glm::mat4 view_from_world(const Pose& pose) {
  // By angles and not by a point to look at: straight down has a right side too.
  const glm::mat4 pitched = glm::rotate(glm::mat4(1), -pose.pitch_rad, glm::vec3(1, 0, 0));
  return glm::translate(glm::rotate(pitched, -pose.yaw_rad, glm::vec3(0, 1, 0)), -pose.position);
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
