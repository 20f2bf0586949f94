#include "app.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "camera.h"
#include "compare.h"
#include "failure.h"
#include "output.h"
#include "session.h"
#include "window.h"

namespace forest {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kHeadlessFrames = 120;
constexpr float kWidestOrbit_m = 1000;

float elapsed_ms(Clock::time_point& since) {
  const auto now = Clock::now();
  const float ms = std::chrono::duration<float, std::milli>(now - since).count();
  since = now;
  return ms;
}

CameraPath make_path(const Options& options, const Session& session) {
  const World& world = session.world;
  if (options.camera == "walk") return walk_path(world.planting.trail, world.terrain);
  if (options.camera == "orbit") return orbit_path(std::min(world.planting.half_extent_m, kWidestOrbit_m), world.terrain);
  const VkExtent2D extent = session.renderer.picture.extent;
  const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
  const Box box = box_of(session.forest, world.planting, world.terrain);
  if (options.camera == "turntable") return turntable_path(box, aspect, world.terrain);
  if (options.camera == "front") return front_path(box, aspect, world.terrain);
  if (options.camera == "top") return top_path(box, aspect, world.terrain);
  return path_from_file(options.camera, world.terrain);
}

/// Sizes are the file's, but for plants too small or too large to stand in one forest: of those it is said.
void describe_scaled(const Session& session) {
  for (std::size_t i = 0; i < session.forest.species.size(); ++i) {
    const Species& species = session.forest.species[i];
    const float scale = fitting_scale(species.radius_m);
    if (scale == 1) continue;
    const double height_m = double{species.box_max.y} - double{species.box_min.y};
    std::printf("scaled               %s: %.*f m high in the file, here %s%.1f m\n", session.forest.files[i].c_str(), height_m < 1 ? 4 : 1,
                height_m, session.world.planting.plants.size() > 1 ? "about " : "", height_m * double{scale});
  }
}

void describe(const Session& session) {
  if (session.forest.scene != 0) {
    const coppice_scene_info& info = session.forest.scene_info;
    std::printf("scene                %llu plants of %u species in %u tiles on %.0f x %.0f m\n",
                static_cast<unsigned long long>(info.instance_count), info.species_count, info.tile_count, double{info.square_side},
                double{info.square_side});
    return;
  }
  std::printf("forest               %zu plants of %zu species on %.0f x %.0f m\n", session.world.planting.plants.size(),
              session.forest.plants.size(), 2 * static_cast<double>(session.world.planting.half_extent_m),
              2 * static_cast<double>(session.world.planting.half_extent_m));
  describe_scaled(session);
}

void report(Session& session, const Options& options) {
  session.statistics.validation_messages = session.device.messages;
  session.statistics.errors = session.forest.log->error_count;
  const Renderer& renderer = session.renderer;
  session.statistics.picture_px = {renderer.picture.extent.width, renderer.picture.extent.height};
  session.statistics.drawn_px = {renderer.drawn.width, renderer.drawn.height};
  session.statistics.shadow_maps = renderer.shadows != nullptr;
  session.statistics.temporal = renderer.temporal != nullptr;
  std::printf("%s", table(session.statistics).c_str());
  if (!options.stats.empty()) write_json(options.stats, session.statistics);
  if (session.forest.trace) session.forest.trace->write(options.trace);
}

/// Until the GPU had drawn the first frame that shows a plant, ms; 0 if none of the first frames does.
float first_picture_ms(Session& session, const Pose& pose, float time_s, Clock::time_point started) {
  const int max_frames = session.forest.scene != 0 ? 200 : 4;  // the first tiles of a scene may show nothing
  float last_ms = 0;
  for (int i = 0; i < max_frames; ++i) {
    render_frame(session, pose, time_s, 0);
    wait_for_frames(session.device, session.ring);
    // Its figures are of the frame before, which was finished when the last one was waited for.
    if (session.statistics.last_view.visible_instance_count > 0) return last_ms;
    last_ms = ms_since(started);
  }
  return 0;
}

void run_headless(Session& session, const Options& options, Clock::time_point started) {
  const CameraPath path = make_path(options, session);
  const std::uint32_t frames = options.frames.value_or(kHeadlessFrames);
  const auto time_of = [&](std::uint32_t frame) { return frame_time_s(path, frame, frames, options.frames_per_s); };
  session.first_measured = session.last_measured;
  const Pose start = path.pose(time_of(0));
  const auto start_s = static_cast<float>(time_of(0));
  session.statistics.first_picture_ms = first_picture_ms(session, start, start_s, started);
  if (session.forest.scene != 0) {
    settle(session, start, start_s);
    session.statistics.settled_ms = ms_since(started);
  }
  warm_up(session, start, start_s);
  session.first_measured = session.ring.number + 1;
  session.last_measured = session.ring.number + frames;
  auto last = Clock::now();
  float frame_ms = 0;
  for (std::uint32_t i = 0; i < frames; ++i) {
    render_frame(session, path.pose(time_of(i)), static_cast<float>(time_of(i)), frame_ms);
    if (!options.record.empty()) record_picture(session, {path.pose(time_of(i)), static_cast<float>(time_of(i))}, options.record, i);
    frame_ms = elapsed_ms(last);
    session.statistics.frame_ms.push_back(frame_ms);
  }
  wait_for_frames(session.device, session.ring);
  const auto end_s = static_cast<float>(time_of(frames - 1));
  const Pose end = path.pose(time_of(frames - 1));
  settle(session, end, end_s);
  if (!options.screenshot.empty()) save_picture(session, {end, end_s}, options.screenshot);
}

/// The camera's way, being written.
struct Recording {
  PathRecorder recorder;
  float start_s = 0;
};

void obey_keys(Session& session, const Options& options, std::optional<Recording>& recording, float time_s) {
  Window& window = *session.window;
  if (std::exchange(window.wants_next_view, false)) {
    const auto next = static_cast<std::uint32_t>(session.controls.view) + 1;
    session.controls.view = static_cast<DebugView>(next % static_cast<std::uint32_t>(DebugView::count));
  }
  if (std::exchange(window.wants_wind, false)) session.controls.wind_mps = session.controls.wind_mps > 0 ? 0 : kWindowWind_mps;
  if (std::exchange(window.wants_temporal, false) && session.supersample == 1) {
    wait_for_frames(session.device, session.ring);
    set_temporal(session.renderer, !session.renderer.temporal);
  }
  if (!std::exchange(window.wants_recording, false)) return;
  if (recording) {
    std::printf("camera               %s\n", recording->recorder.output.file.c_str());
    show_message(*session.overlay, "the camera's way is in " + recording->recorder.output.file);
    recording.reset();
  } else {
    recording.emplace(Recording{start_recording(options.camera_out), time_s});
    show_message(*session.overlay, "writing the camera's way to " + options.camera_out + " until C is pressed again");
  }
}

/// A full disk is no reason to close the window.
void save_picture_or_say(Session& session, const Shot& shot, const std::string& file) {
  try {
    save_picture(session, shot, file);
    std::fflush(stdout);
    show_message(*session.overlay, "picture: " + file);
  } catch (const Failure& failure) {
    std::fprintf(stderr, "coppice-forest: %s\n", failure.what());
    show_message(*session.overlay, failure.what());
  }
}

void run_in_window(Session& session, const Options& options) {
  CameraPath path = make_path(options, session);
  VkExtent2D extent = session.renderer.picture.extent;
  const std::string picture = std::filesystem::absolute(options.screenshot.empty() ? "forest.png" : options.screenshot).string();
  Window& window = *session.window;
  Pose pose = path.pose(0);
  double path_time_s = 0;
  float time_s = 0;
  std::optional<Recording> recording;
  auto last = Clock::now();
  for (std::uint32_t frame = 0; next_frame(window) && (!options.frames || frame < *options.frames); ++frame) {
    if (std::exchange(window.was_hidden, false)) last = Clock::now();
    const float frame_ms = elapsed_ms(last);
    const float dt_s = std::min(0.001f * frame_ms, 0.25f);
    time_s += dt_s;
    steer(window, pose, dt_s, !overlay_uses_mouse());
    if (!window.steering) {
      path_time_s = std::min(path_time_s + static_cast<double>(dt_s), path.duration_s);
      pose = path.pose(path_time_s);
      if (path.loops && path_time_s >= path.duration_s) path_time_s = 0;
    }
    obey_keys(session, options, recording, time_s);
    if (recording) record_pose(recording->recorder, static_cast<double>(time_s - recording->start_s), pose, session.world.terrain);
    render_frame(session, pose, time_s, frame_ms);
    if (!same_size(extent, session.renderer.picture.extent)) {
      extent = session.renderer.picture.extent;
      path = make_path(options, session);
    }
    if (!options.record.empty()) record_picture(session, {pose, time_s}, options.record, frame);
    if (frame > 0) session.statistics.frame_ms.push_back(frame_ms);
    if (std::exchange(window.wants_picture, false)) save_picture_or_say(session, {pose, time_s}, picture);
  }
  if (options.screenshot.empty()) return;
  settle(session, pose, time_s);
  save_picture(session, {pose, time_s}, options.screenshot);
}

void check_files(const Options& options) {
  std::vector<std::string> inputs = options.plants;
  inputs.insert(inputs.end(), {options.scene, options.camera});
  const NamedOutput outputs[] = {{"--screenshot", options.screenshot},
                                 {"--stats", options.stats},
                                 {"--compare", options.compare},
                                 {"--trace", options.trace},
                                 {"--record", options.record.empty() ? "" : options.record + "/00000.png"}};
  check_outputs(outputs, inputs);
}

/// A picture that lacks something is no success, unless the user says so.
int exit_code_of(Session& session, const Options& options) {
  say_waiting(*session.forest.log);
  if (session.window || session.forest.log->error_count == 0 || options.ignore_errors) return 0;
  std::fprintf(stderr, "coppice-forest: what the lines above name is missing or coarse (--ignore-errors: exit with 0 all the same)\n");
  return 1;
}

}  // namespace

int run(const Options& requested) {
  Options options = requested;
  if (options.scene.empty()) options.plants = find_plants(options);
  check_files(options);
  std::unique_ptr<Window> window;
  if (!options.headless && options.compare.empty()) {
    std::string reason;
    window = open_window(options.width_px, options.height_px, reason);
    if (!window) {
      std::printf("no window (%s): rendering headless\n", reason.c_str());
      if (options.screenshot.empty()) options.screenshot = "forest.png";
    }
  }
  const auto started = Clock::now();
  Session session(options, std::move(window));
  describe(session);
  if (!options.compare.empty()) {
    compare_lods(session, make_path(options, session), options);
    return exit_code_of(session, options);
  }
  if (session.window)
    run_in_window(session, options);
  else
    run_headless(session, options, started);
  report(session, options);
  return exit_code_of(session, options);
}

}  // namespace forest
