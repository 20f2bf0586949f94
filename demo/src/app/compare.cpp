#include "compare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "output.h"
#include "session.h"

namespace forest {
namespace {

using Clock = std::chrono::steady_clock;
using Luminance = std::vector<float>;  // [width * height], 0..255

constexpr std::uint32_t kPoses = 3;
// At each pose: at least so many frames, and so long, one after the other as a game draws them.
constexpr std::uint32_t kTimedFrames = 4;
constexpr float kTimed_ms = 250;
constexpr std::uint32_t kSubsamples = 4;  // along each axis
constexpr int kDollyFrames = 4;
constexpr float kDollyStep_m = 0.05f, kDollyStep_s = 1.0f / 30;
constexpr float kWindFrom_s = 10;  // a time within a gust
// Only to the side can the eye of the cuts be moved and the picture stay (`view_of`). There distances change half as much, in the mean over
// the picture, as on the way ahead.
constexpr float kAside_m = 2 * kDollyStep_m;

template <class T>
T median(std::vector<T> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

Luminance luminance_of(const std::vector<float>& rgba) {
  Luminance result(rgba.size() / 4);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = 0.2126f * rgba[4 * i] + 0.7152f * rgba[4 * i + 1] + 0.0722f * rgba[4 * i + 2];
  }
  return result;
}

Luminance supersampled(Session& session, const Pose& pose) {
  return luminance_of(supersampled_picture(session, {pose}, kSubsamples));
}

double squared_difference(const Luminance& a, const Luminance& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<double>(a[i] - b[i]) * static_cast<double>(a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

/// The largest difference of an 8 x 8 block's mean.
float largest_block_difference(const Luminance& a, const Luminance& b, std::size_t width_px) {
  constexpr std::size_t kSide = 8;
  float largest = 0;
  for (std::size_t top = 0; top + kSide * width_px <= a.size(); top += kSide * width_px)
    for (std::size_t x = 0; x + kSide <= width_px; x += kSide) {
      float sum = 0;
      for (std::size_t y = 0; y < kSide; ++y)
        for (std::size_t i = top + y * width_px + x, end = i + kSide; i < end; ++i) sum += a[i] - b[i];
      largest = std::max(largest, std::abs(sum) / (kSide * kSide));
    }
  return largest;
}

/// Full detail's pictures, which the others are compared with; supersampled.
struct Reference {
  std::vector<Luminance> pictures;  ///< one for each pose
  std::vector<Luminance> dolly;     ///< its frames
  std::vector<Luminance> windy;     ///< its frames in wind
};

Pose moved(Pose pose, int frame) {
  pose.position += forward(pose) * (kDollyStep_m * static_cast<float>(frame));
  return pose;
}

/// What a pose shows and costs once all it wants is there.
struct Samples {
  std::vector<float> times_ms;  ///< a frame, at each pose
  std::vector<std::uint64_t> leaves, wood_triangles, leaf_mesh_triangles;
  std::vector<Luminance> pictures, switched;  ///< with the pose's cuts, and with those of an eye beside it
};

void visit(Session& session, const Pose& pose, std::uint32_t min_frames, Samples& samples) {
  settle(session, pose, 0);
  if (min_frames > 1) warm_up(session, pose, 0);
  const auto start = Clock::now();
  std::uint32_t frames = 0;
  do {
    render_frame(session, pose, 0, 0);
    ++frames;
  } while (frames < min_frames || ms_since(start) < kTimed_ms);
  wait_for_frames(session.device, session.ring);
  samples.times_ms.push_back(ms_since(start) / static_cast<float>(frames));
  samples.leaves.push_back(session.statistics.last_view.drawn_leaf_count);
  samples.wood_triangles.push_back(session.statistics.last_view.drawn_wood_triangle_count);
  samples.leaf_mesh_triangles.push_back(session.statistics.last_view.drawn_leaf_mesh_triangle_count);
  samples.pictures.push_back(supersampled(session, pose));
  if (session.controls.lod == LodMode::full) return;
  session.cuts_aside_m = kAside_m;
  samples.switched.push_back(supersampled(session, pose));
  session.cuts_aside_m = 0;
}

void measure_error(const std::vector<Luminance>& pictures, const Reference& reference, ComparedMode& mode) {
  double sum = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) sum += squared_difference(pictures[i], reference.pictures[i]);
  mode.rmse = static_cast<float>(std::sqrt(sum / static_cast<double>(pictures.size())));
}

void measure_switching(const Samples& samples, std::size_t width_px, ComparedMode& mode) {
  double sum = 0;
  for (std::size_t i = 0; i < samples.pictures.size(); ++i) {
    sum += squared_difference(samples.pictures[i], samples.switched[i]);
    mode.switching_block_max =
        std::max(mode.switching_block_max, largest_block_difference(samples.pictures[i], samples.switched[i], width_px));
  }
  mode.switching_rmse = static_cast<float>(std::sqrt(sum / static_cast<double>(samples.pictures.size())));
}

struct Popping {
  float mean = 0, most = 0;
};

Popping measure_popping(const std::vector<Luminance>& dolly, const std::vector<Luminance>& reference) {
  Popping result;
  double sum = 0;
  for (std::size_t frame = 1; frame < dolly.size(); ++frame) {
    Luminance change(dolly[frame].size()), expected(change.size());
    for (std::size_t i = 0; i < change.size(); ++i) {
      change[i] = dolly[frame][i] - dolly[frame - 1][i];
      expected[i] = reference[frame][i] - reference[frame - 1][i];
    }
    const double popping = std::sqrt(squared_difference(change, expected));
    sum += popping;
    result.most = std::max(result.most, static_cast<float>(popping));
  }
  result.mean = static_cast<float>(sum / static_cast<double>(dolly.size() - 1));
  return result;
}

std::vector<Luminance> dolly_pictures(Session& session, const Pose& start, float wind_mps) {
  session.controls.wind_mps = wind_mps;
  std::vector<Luminance> pictures;
  for (int frame = 0; frame < kDollyFrames; ++frame) {
    const Pose pose = moved(start, frame);
    const float time_s = kWindFrom_s + kDollyStep_s * static_cast<float>(frame);
    settle(session, pose, time_s);
    pictures.push_back(luminance_of(supersampled_picture(session, {pose, time_s}, kSubsamples)));
  }
  session.controls.wind_mps = 0;
  return pictures;
}

void measure(Session& session, const std::vector<Pose>& poses, float wind_mps, Reference& reference, ComparedMode& mode) {
  session.controls.lod = mode.lod;
  session.controls.frame_ms = 0;
  session.pace.budget = 0;
  if (mode.error_px > 0) session.controls.error_px = mode.error_px;
  Samples samples;
  for (const Pose& pose : poses) {
    visit(session, pose, mode.lod == LodMode::full ? 1 : kTimedFrames, samples);
    mode.memory_bytes = std::max(mode.memory_bytes, session.statistics.last.memory_bytes);
  }
  mode.frame_ms = median(samples.times_ms);
  mode.leaves = median(samples.leaves);
  mode.wood_triangles = median(samples.wood_triangles);
  mode.leaf_mesh_triangles = median(samples.leaf_mesh_triangles);
  const Pose& start = poses[poses.size() / 2];
  std::vector<Luminance> dolly = dolly_pictures(session, start, 0), windy;
  if (wind_mps > 0) windy = dolly_pictures(session, start, wind_mps);
  if (mode.lod == LodMode::full) {
    reference = {std::move(samples.pictures), std::move(dolly), std::move(windy)};
    return;
  }
  measure_error(samples.pictures, reference, mode);
  measure_switching(samples, session.renderer.picture.extent.width, mode);
  const Popping still = measure_popping(dolly, reference.dolly);
  const Popping in_wind = windy.empty() ? Popping{} : measure_popping(windy, reference.windy);
  mode.popping_mean = still.mean;
  mode.popping_max = still.most;
  mode.wind_popping_mean = in_wind.mean;
  mode.wind_popping_max = in_wind.most;
}

}  // namespace

const char* mode_name(LodMode lod) {
  return lod == LodMode::full ? "full" : lod == LodMode::discrete ? "discrete" : "cut";
}

void compare_lods(Session& session, const CameraPath& path, const Options& options) {
  const std::uint32_t pose_count = options.frames.value_or(kPoses);
  std::vector<Pose> poses;
  for (std::uint32_t i = 0; i < pose_count; ++i) poses.push_back(path.pose(path.duration_s * (i + 0.5) / pose_count));
  Comparison comparison{.device = session.device.name,
                        .plants = static_cast<std::uint32_t>(session.world.planting.plants.size()),
                        .width_px = session.renderer.picture.extent.width,
                        .height_px = session.renderer.picture.extent.height,
                        .poses = pose_count,
                        .wind_mps = options.wind_mps.value_or(0),
                        .modes = {}};
  session.controls.wind_mps = 0;
  Reference reference;
  ComparedMode full{.lod = LodMode::full};
  measure(session, poses, comparison.wind_mps, reference, full);
  for (const LodMode lod : {LodMode::cut, LodMode::discrete})
    for (const float factor : {1.0f, 2.0f, 4.0f}) {
      ComparedMode mode{.lod = lod, .error_px = factor * options.error_px};
      measure(session, poses, comparison.wind_mps, reference, mode);
      comparison.modes.push_back(mode);
    }
  comparison.modes.push_back(full);
  std::printf("%s", comparison_table(comparison).c_str());
  const std::string stem = options.compare.ends_with(".json") ? options.compare.substr(0, options.compare.size() - 5) : options.compare;
  write_output(options.compare, comparison_json(comparison));
  write_output(stem + ".svg", comparison_svg(comparison));
}

}  // namespace forest
