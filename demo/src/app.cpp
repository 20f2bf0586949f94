#include "app.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include "camera.h"
#include "device.h"
#include "failure.h"
#include "frames.h"
#include "overlay.h"
#include "placement.h"
#include "png.h"
#include "renderer.h"
#include "swapchain.h"
#include "window.h"

namespace forest {
namespace {

Weather make_weather(float half_extent_m) {
  Weather weather;
  weather.sun_direction = glm::normalize(glm::vec3(0.55f, 0.62f, -0.45f));
  weather.sun_color = glm::vec3(4.6f, 4.1f, 3.3f);
  weather.sky_color = glm::vec3(0.62f, 0.78f, 1.0f);
  weather.ground_color = glm::vec3(0.22f, 0.21f, 0.12f);
  weather.fog_color = glm::vec3(0.62f, 0.72f, 0.80f);
  weather.fog_density = 0.95f / (1.5f * half_extent_m);
  weather.exposure = 0.8f;
  return weather;
}

CameraPath make_path(const Options& options, const Planting& planting, const Terrain& terrain) {
  if (options.camera == "walk") return walk_path(planting.trail, terrain);
  if (options.camera == "orbit") return orbit_path(planting.half_extent_m, terrain);
  return path_from_file(options.camera, terrain);
}

}  // namespace

int run(const Options& options) {
  Device device(DeviceOptions{options.validation, {}, false});
  std::printf("device: %s\n", device.name.c_str());
  Planting planting;
  planting.half_extent_m = 80;
  planting.trail = make_trail(planting.half_extent_m, options.seed);
  const Weather weather = make_weather(planting.half_extent_m);
  const Terrain terrain = make_terrain(planting.half_extent_m, options.seed);
  const GroundMap map = make_ground_map(planting, weather.sun_direction, options.seed);
  Renderer renderer(device, terrain, map, weather, {options.width_px, options.height_px});
  FrameRing ring = create_frame_ring(device);
  const CameraPath path = make_path(options, planting, terrain);
  const std::uint32_t frames = options.frames.value_or(120);
  const auto start = std::chrono::steady_clock::now();
  for (std::uint32_t i = 0; i < frames; ++i) {
    FrameSlot& slot = begin_frame(device, ring);
    const double time_s = frames > 1 ? path.duration_s * i / (frames - 1) : path.duration_s;
    const Pose pose = path.pose(time_s);
    FrameView view{view_from_world(pose),
                   clip_from_view(pose, static_cast<float>(options.width_px) / static_cast<float>(options.height_px)), pose.position,
                   static_cast<float>(time_s)};
    record_scene(renderer, slot.commands, ring.slot_index(), view, [] {});
    record_tone_map(renderer, slot.commands, ring.slot_index(), [] {});
    submit_frame(device, ring, VK_NULL_HANDLE, VK_NULL_HANDLE);
  }
  wait_for_frames(device, ring);
  std::printf("%.1f ms a frame\n", std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count() / frames);
  if (!options.screenshot.empty()) {
    write_png(options.screenshot, options.width_px, options.height_px, read_picture(renderer));
    std::printf("%s\n", options.screenshot.c_str());
  }
  std::printf("validation messages %u\n", device.messages.load());
  return 0;
}

}  // namespace forest
