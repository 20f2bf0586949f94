#include "session.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "failure.h"
#include "output.h"

namespace forest {
namespace {

using Clock = std::chrono::steady_clock;

Weather make_weather(const Forest& forest, float half_extent_m, float fog) {
  Weather weather;
  weather.leaf_color = forest.leaf_color;
  weather.sun_direction = glm::normalize(glm::vec3(0.55f, 0.62f, -0.45f));
  weather.sun_color = glm::vec3(3.5f, 3.05f, 2.35f);
  weather.sky_color = glm::vec3(0.42f, 0.55f, 0.74f);
  weather.ground_color = glm::vec3(0.14f, 0.135f, 0.08f);
  weather.fog_color = glm::vec3(0.50f, 0.62f, 0.72f);
  // The far edge of the planting, seen from the near one, is nearly gone.
  weather.fog_density = fog * 0.52f / half_extent_m;
  weather.exposure = 0.8f;
  return weather;
}

/// Flat ground under a scene, whose plants say where they stand, and a short walk in its middle.
World make_scene_world(const Forest& forest, const Options& options) {
  constexpr float kWalk_m = 150;
  const coppice_scene_info& info = forest.scene_info;
  World world;
  float half_extent_m = 0;
  for (const float corner : info.square_min)
    half_extent_m = std::max({half_extent_m, std::abs(corner), std::abs(corner + info.square_side)});
  world.planting.half_extent_m = std::max(half_extent_m, 30.0f);
  world.planting.trail = make_trail(std::min(world.planting.half_extent_m, kWalk_m), options.seed);
  world.weather = make_weather(forest, world.planting.half_extent_m, options.fog);
  world.terrain = make_flat_terrain(world.planting.half_extent_m, info.height_min);
  world.ground_map = make_ground_map(world.planting, world.weather.sun_direction, options.seed);
  return world;
}

World make_world(const Forest& forest, const Options& options) {
  if (forest.scene != 0) return make_scene_world(forest, options);
  World world;
  world.planting = plant_forest(forest.species, options.count, options.seed);
  world.weather = make_weather(forest, world.planting.half_extent_m, options.fog);
  world.terrain = make_terrain(world.planting.half_extent_m, options.seed);
  world.ground_map = make_ground_map(world.planting, world.weather.sun_direction, options.seed);
  return world;
}

DeviceOptions device_options(const Options& options, const Window* window) {
  DeviceOptions result;
  result.validation = options.validation;
  result.patience_s = options.gpu_wait_s.value_or(0.0f);
  if (window) result.instance_extensions = window->instance_extensions;
  result.swapchain = window != nullptr;
  return result;
}

VkExtent2D picture_extent(const Options& options, const Screen* screen) {
  return screen ? screen->swapchain.extent : VkExtent2D{options.width_px, options.height_px};
}

Panes panes_of(const Options& options) {
  if (options.stereo) return Panes::stereo;
  return options.split ? Panes::split : Panes::one;
}

bool blends_frames(const Options& options) {
  return options.temporal.value_or(options.supersample == 1 && options.compare.empty() && panes_of(options) == Panes::one);
}

/// In a window antialiasing and wind may come later. In still air depth and cameras say as well where surfaces were, for less.
PlantTargets plant_targets(const Options& options, bool in_window) {
  const bool in_wind = options.wind_mps.value_or(0.0f) > 0;
  return {.deferred = options.lighting == Lighting::deferred, .velocity = in_window || (in_wind && blends_frames(options))};
}

FramePace first_pace(const Options& options, const Device& device, bool in_window) {
  const bool software = device.software;
  FramePace pace;
  pace.aim_ms = options.frame_ms.value_or(software && in_window ? kSoftwareFrame_ms : 0.0f);
  pace.scale = options.render_scale.value_or(software && blends_frames(options) ? kSoftwareRenderScale : 1.0f);
  pace.scales = !options.render_scale;
  pace.budget = static_cast<float>(options.leaf_budget.value_or(software ? kSoftwareLeafBudget : 0));
  return pace;
}

void recreate_swapchain(Session& session) {
  wait_for_frames(session.device, session.ring);
  Screen& screen = *session.screen;
  screen.window_size = framebuffer_size(*session.window);
  screen.swapchain = create_swapchain(session.device, screen.surface, screen.window_size, std::move(screen.swapchain));
  resize_renderer(session.renderer, screen.swapchain.extent);
}

// Resizes until an image fits the window. Not every driver says when one does not: some scale it. Where the window is not to be seen there
// may be none for as long.
std::uint32_t acquire(Session& session, const FrameSlot& slot) {
  if (!same_size(framebuffer_size(*session.window), session.screen->window_size)) recreate_swapchain(session);
  for (;;) {
    std::uint32_t index = 0;
    const VkResult result = acquire_image(session.device, session.screen->swapchain, slot.acquired, index);
    if (result == VK_ERROR_OUT_OF_DATE_KHR)
      recreate_swapchain(session);
    else if (result == VK_TIMEOUT)
      wait_for_frames(session.device, session.ring);
    else
      return index;
  }
}

// Figures arrive when the GPU has finished a frame, so a sample is of an earlier frame than the one being recorded.
void sample_statistics(Session& session) {
  Statistics& statistics = session.statistics;
  statistics.last = statistics_of(session.forest);
  statistics.last_view = view_statistics_of(session.forest);
  const coppice_stats& all = statistics.last;
  const coppice_view_stats& stats = statistics.last_view;
  statistics.seconds = std::chrono::duration<double>(Clock::now() - session.start).count();
  statistics.max_threshold_px = std::max(statistics.max_threshold_px, stats.threshold_px);
  statistics.max_chunks_in_flight = std::max(statistics.max_chunks_in_flight, all.streamed[COPPICE_STREAMED_ALL].in_flight);
  statistics.max_chunks_queued = std::max(statistics.max_chunks_queued, all.streamed[COPPICE_STREAMED_ALL].queued);
  if (stats.gpu_frame_number == session.sampled_frame) return;
  session.sampled_frame = stats.gpu_frame_number;
  if (session.sampled_frame < session.first_measured || session.sampled_frame > session.last_measured) return;
  session.statistics.visible_instances.push_back(stats.visible_instance_count);
  session.statistics.occluded_instances.push_back(stats.occluded_instance_count);
  session.statistics.culled_instances.push_back(all.instance_count -
                                                std::min(all.instance_count, stats.visible_instance_count + stats.occluded_instance_count));
  session.statistics.drawn_leaves.push_back(stats.drawn_leaf_count);
  session.statistics.leaf_mesh_instances.push_back(stats.leaf_mesh_instance_count);
  session.statistics.leaf_mesh_triangles.push_back(stats.drawn_leaf_mesh_triangle_count);
  session.statistics.drawn_wood_triangles.push_back(stats.drawn_wood_triangle_count);
  session.statistics.threshold_px.push_back(stats.threshold_px);
  if (!session.renderer.timer) return;
  auto times = std::begin(session.statistics.pass_ms);
  for (const float ms : std::span(stats.pass_ms).first<COPPICE_PASS_COUNT>()) (times++)->push_back(ms);
  for (const float ms : session.renderer.timer->times) (times++)->push_back(ms);
}

/// Frames without the overlay, for as long as it lives.
struct Unveiled {
  Overlay* overlay;
  explicit Unveiled(Overlay* overlay_in) : overlay(overlay_in) {
    if (overlay) overlay->hidden = true;
  }
  Unveiled(const Unveiled&) = delete;
  Unveiled& operator=(const Unveiled&) = delete;
  ~Unveiled() {
    if (overlay) overlay->hidden = false;
  }
};

void write_picture(Session& session, const Shot& shot, const std::string& file) {
  const VkExtent2D extent = session.renderer.picture.extent;
  wait_for_frames(session.device, session.ring);
  std::vector<std::uint8_t> pixels;
  if (session.supersample > 1)
    for (const float value : supersampled_picture(session, shot, session.supersample))
      pixels.push_back(static_cast<std::uint8_t>(std::lround(value)));
  else
    pixels = read_picture(session.renderer);
  write_png(file, extent.width, extent.height, pixels);
}

// Half a second or so between looks, so that a file that is being written is left alone until it is whole.
void reload_changed(Session& session) {
  constexpr std::uint64_t kFramesBetweenLooks = 30;
  if (!session.watch || session.ring.number % kFramesBetweenLooks != 0) return;
  for (const std::size_t plant : changed_files(*session.watch)) reload(session.forest, plant);
}

/// Changes with whatever comes into the picture or leaves it.
std::uint64_t arrivals_of(const coppice_stats& stats) {
  return stats.streamed[COPPICE_STREAMED_ALL].loaded + stats.streamed[COPPICE_STREAMED_ALL].evicted + stats.scene_tiles_resident;
}

/// How far the wind moves the largest plants to and fro, about: trees by a twentieth of their radius in a gale, and less in less.
/// load: coppice_gusts'
float sway_m(const Session& session, float load) {
  constexpr float kUnknownRadius_m = 5;  // assumed radius of a scene's plant
  float radius_m = session.forest.species.empty() ? kUnknownRadius_m : 0;
  for (const Species& species : session.forest.species) radius_m = std::max(radius_m, species.radius_m);
  return 0.05f * load * radius_m;
}

/// The shadow maps that the frame draws.
std::vector<DueMap> due_maps(Session& session, const FrameView& view) {
  if (!session.renderer.shadows) return {};
  const glm::vec3 forward = -glm::vec3(glm::transpose(view.view_from_world)[2]);
  return due_maps(*session.renderer.shadows, {.context = session.forest.context.get(),
                                              .views = session.forest.sun_views,
                                              .terrain = &session.world.terrain,
                                              .sun_direction = session.world.weather.sun_direction,
                                              .eye = view.eye,
                                              .forward = forward,
                                              .number = session.ring.number,
                                              .arrivals = arrivals_of(session.statistics.last),
                                              .time_s = view.time_s,
                                              .sway_m = sway_m(session, view.gusts[0].z)});
}

/// What draws a pane: the second eye of a pair has no view of its own.
struct PaneView {
  coppice_view view = 0;
  std::uint32_t eye = 0;
};

PaneView pane_view(const Session& session, std::size_t pane) {
  if (session.panes == Panes::stereo) return {session.forest.views[0], static_cast<std::uint32_t>(pane)};
  return {session.forest.views[pane], 0};
}

coppice_wind make_wind(const Session& session, float time_s) {
  coppice_wind wind;
  coppice_wind_init(&wind);
  const glm::vec3 direction = glm::normalize(glm::vec3(1, 0, 0.4f));
  std::copy_n(&direction.x, 3, wind.direction);
  wind.speed = session.controls.wind_mps;
  wind.time_s = double{time_s};
  wind.time_before_s = double{session.renderer.time_before_s};
  if (session.window) wind.gusts_m = session.gusts_m;
  return wind;
}

/// What moves grass.
std::array<glm::vec4, 4> gusts_of(const Session& session, float time_s) {
  const coppice_wind wind = make_wind(session, time_s);
  const double origin[3] = {0, 0, 0};
  coppice_gusts gusts;
  coppice_gusts_init(&gusts);
  check(session.forest, coppice_wind_gusts(session.forest.context.get(), &wind, origin, &gusts), "coppice_wind_gusts");
  std::array<glm::vec4, 1 + COPPICE_GUST_WAVES> result = {{{gusts.direction[0], gusts.direction[2], gusts.load, gusts.gustiness}}};
  std::ranges::transform(gusts.waves, result.begin() + 1,
                         [](const coppice_gust_wave& wave) { return glm::vec4(wave.x, wave.z, wave.phase, wave.share); });
  return result;
}

void begin_plants(Session& session, std::span<const FrameView> views, std::span<const DueMap> maps) {
  const float budget = session.pace.budget / static_cast<float>(views.size());
  const CutSettings settings{session.controls.error_px, static_cast<std::uint32_t>(budget), session.controls.lod, session.controls.view};
  std::vector<coppice_camera> cameras;
  coppice_eye second_eye;
  for (std::size_t pane = 0; pane < views.size(); ++pane) {
    if (pane_view(session, pane).eye == 0) {
      cameras.push_back(make_camera(session.forest, pane, views[pane], settings));
    } else {
      second_eye = make_eye(views[pane]);
      cameras.back().second_eye = &second_eye;
    }
  }
  for (const DueMap& map : maps) cameras.push_back(map.camera);
  coppice_frame frame;
  coppice_frame_init(&frame);
  frame.frame_number = session.ring.number;
  frame.completed_number = completed_frame(session.device, session.ring);
  frame.cameras = cameras.data();
  frame.camera_count = static_cast<std::uint32_t>(cameras.size());
  const coppice_wind wind = make_wind(session, views.front().time_s);
  frame.wind = &wind;
  check(session.forest, coppice_frame_begin(session.forest.context.get(), &frame), "coppice_frame_begin");
}

void record_frame(Session& session, VkCommandBuffer commands, std::span<const FrameView> views, std::span<const DueMap> maps) {
  coppice_context* context = session.forest.context.get();
  coppice_light light = make_light(session.world.weather);
  const auto cull = [&](coppice_view of) {
    check(session.forest, coppice_record_cull(context, commands, of, &light), "coppice_record_cull");
  };
  const auto draw = [&](coppice_view of, std::uint32_t eye) {
    check(session.forest, coppice_record_draw(context, commands, of, eye), "coppice_record_draw");
  };
  check(session.forest, coppice_record_upload(context, commands), "coppice_record_upload");
  const std::size_t slot = session.ring.slot_index();
  start_timer(session.renderer.timer.get(), commands, slot);
  std::array<coppice_shadow_map, Shadows::kCascades> shadows{};
  if (session.renderer.shadows) {
    record_shadows(*session.renderer.shadows, commands, maps, cull, [&](coppice_view of) { draw(of, 0); });
    shadows = shadow_maps(*session.renderer.shadows);
    light.shadow_maps = shadows.data();
    light.shadow_map_count = Shadows::kCascades;
  }
  stamp_pass(session.renderer.timer.get(), commands, slot, ScenePass::shadows);
  for (std::size_t pane = 0; pane < views.size(); ++pane)
    if (const PaneView of = pane_view(session, pane); of.eye == 0) cull(of.view);
  record_scene(session.renderer, commands, slot, views, [&] {
    for (std::size_t pane = 0; pane < views.size(); ++pane) {
      const PaneView of = pane_view(session, pane);
      draw(of.view, of.eye);
    }
  });
  std::function<void()> draw_overlay;
  if (session.overlay) draw_overlay = [&] { record_overlay(*session.overlay, commands, slot, session.renderer.picture.extent); };
  record_tone_map(session.renderer, commands, slot, views.front(), draw_overlay);
}

FrameView view_of(const Session& session, const Pose& pose, float time_s, const VkRect2D& pane) {
  const glm::vec2 picture_px = size_px(session.renderer.picture.extent) * glm::vec2(session.panes == Panes::one ? 1.0f : 0.5f, 1.0f);
  const glm::vec2 drawn_px = size_px(pane.extent);
  Pose cuts = pose;
  cuts.position += session.cuts_aside_m * right(pose);
  FrameView view;
  view.pane = pane;
  view.view_from_world = view_from_world(cuts);
  view.clip_from_view = clip_from_view(pose, picture_px.x / picture_px.y);
  view.clip_from_view[3] += session.cuts_aside_m * view.clip_from_view[0];
  view.unmoved_clip_from_world = view.clip_from_view * view.view_from_world;
  view.jitter_px = session.jitter_px + (session.renderer.temporal ? temporal_jitter_px(*session.renderer.temporal) : glm::vec2(0));
  view.clip_from_view[2] -= glm::vec4(2.0f * view.jitter_px / drawn_px, 0, 0);
  view.temporal_frame = session.renderer.temporal ? session.renderer.temporal->frame + 1 : session.sample;
  view.eye = pose.position;
  view.time_s = time_s;
  view.gusts = gusts_of(session, time_s);
  view.debug_view = session.controls.view != DebugView::none;
  return view;
}

/// The picture's cameras, from left to right; those of a stereo pair are of one size.
std::vector<FrameView> views_of(const Session& session, const Pose& pose, float time_s) {
  const VkExtent2D drawn = session.renderer.drawn;
  if (session.panes == Panes::one) return {view_of(session, pose, time_s, {{0, 0}, drawn})};
  constexpr float kBetweenEyes_m = 0.064f;
  const std::uint32_t left_px = std::max(drawn.width / 2, 1u);
  std::uint32_t right_px = std::max(drawn.width - left_px, 1u);
  Pose left_pose = pose, right_pose = pose;
  if (session.panes == Panes::split) {
    right_pose.yaw_rad += std::numbers::pi_v<float>;
  } else {
    left_pose.position -= 0.5f * kBetweenEyes_m * right(pose);
    right_pose.position += 0.5f * kBetweenEyes_m * right(pose);
    right_px = left_px;
  }
  return {view_of(session, left_pose, time_s, {{0, 0}, {left_px, drawn.height}}),
          view_of(session, right_pose, time_s, {{static_cast<std::int32_t>(left_px), 0}, {right_px, drawn.height}})};
}

void pace_frame(Session& session, float frame_ms) {
  Controls& controls = session.controls;
  // Less than the display's time of a frame cannot be had.
  const float min_ms = session.window && controls.frame_ms > 0 ? session.window->display_frame_ms : 0;
  session.pace.aim_ms = std::max(controls.frame_ms, min_ms);
  const bool limited = session.statistics.last_view.threshold_px > 1.001f * controls.error_px;
  keep_pace(session.pace, frame_ms, limited);
  set_scale(session.renderer, stepped_scale(session.pace));
}

void layout_controls(Session& session, float frame_ms) {
  const int memory_before_mb = session.controls.memory_mb;
  const SceneTimes* times = session.renderer.timer ? &session.renderer.timer->times : nullptr;
  layout_overlay(*session.overlay, *session.window,
                 {session.statistics.last, session.statistics.last_view, times, frame_ms, session.renderer.drawn, session.pace.budget},
                 session.controls);
  if (session.controls.memory_mb == memory_before_mb) return;
  const auto budget_bytes = static_cast<std::uint64_t>(session.controls.memory_mb) << 20;
  // Less than the context takes at least is refused: the slider goes back.
  if (coppice_set_memory_budget(session.forest.context.get(), budget_bytes) != COPPICE_OK) session.controls.memory_mb = memory_before_mb;
}

}  // namespace

Screen::Screen(const Device& device_in, const Window& window)
    : device(device_in), surface(create_surface(window, device.instance)), window_size(framebuffer_size(window)) {
  try {
    swapchain = create_swapchain(device, surface, window_size, {});
  } catch (const Failure&) {
    vkDestroySurfaceKHR(device.instance, surface, nullptr);
    throw;
  }
}

Screen::~Screen() {
  swapchain = {};
  vkDestroySurfaceKHR(device.instance, surface, nullptr);
}

Session::Session(const Options& options, std::unique_ptr<Window> window_in)
    : window(std::move(window_in)),
      device(device_options(options, window.get())),
      screen(window ? std::make_unique<Screen>(device, *window) : nullptr),
      targets(plant_targets(options, window != nullptr)),
      forest(options.scene.empty() ? open_forest(device, options.plants, options, targets) : open_scene(device, options, targets)),
      world(make_world(forest, options)),
      renderer(device, world.terrain, world.ground_map, world.weather, targets, picture_extent(options, screen.get())),
      ring(create_frame_ring(device)),
      overlay(window ? std::make_unique<Overlay>(device, *window, Renderer::kPictureFormat) : nullptr) {
  device.say_state = [this] {
    const coppice_stats stats = statistics_of(forest);
    const std::string first = stats.missing_pipeline != nullptr ? std::string("; the first that is not: ") + stats.missing_pipeline : "";
    return "  pipelines: " + std::to_string(stats.pipelines_built) + " of " + std::to_string(stats.pipelines_wanted) + " are built" +
           first + "\n";
  };
  if (forest.scene == 0) add_instances(forest, world.planting, world.terrain);
  pace = first_pace(options, device, window != nullptr);
  controls = {.error_px = options.error_px,
              .wind_mps = options.wind_mps.value_or(window != nullptr ? kWindowWind_mps : 0.0f),
              .frame_ms = pace.aim_ms,
              .memory_mb = static_cast<int>(options.memory_mb),
              .lod = options.lod,
              .view = options.view};
  statistics.device = device.name;
  statistics.driver = device.driver;
  statistics.software_device = device.software;
  if (options.watch) watch = watch_files(forest.files);
  supersample = options.supersample;
  panes = panes_of(options);
  if (options.shadows) set_shadows(renderer, static_cast<std::uint32_t>(std::lround(pace.scale * static_cast<float>(Shadows::kSize_px))));
  set_temporal(renderer, blends_frames(options));
  if (options.pass_times) renderer.timer = std::make_unique<PassTimer>(device);
}

Session::~Session() {
  finish_frames(device, ring);
}

void render_frame(Session& session, const Pose& pose, float time_s, float frame_ms) {
  say_waiting(*session.forest.log);
  FrameSlot& slot = begin_frame(session.device, session.ring);
  std::optional<std::uint32_t> image;
  if (session.screen) image = acquire(session, slot);
  const VkExtent2D extent = session.renderer.picture.extent;
  pace_frame(session, frame_ms);
  const float wind_mps = session.controls.wind_mps;
  session.gusts_m += double{wind_mps} * std::max(time_s - session.renderer.time_before_s, 0.0f);
  const bool still = std::exchange(session.wind_before_mps, wind_mps) == 0 && wind_mps == 0;
  std::vector<FrameView> views = views_of(session, pose, time_s);
  FrameView& view = views.front();
  reload_changed(session);
  const std::vector<DueMap> maps = due_maps(session, view);
  begin_plants(session, views, maps);
  const std::uint64_t arrivals = arrivals_of(session.statistics.last);
  const float threshold_px = session.statistics.last_view.threshold_px;
  sample_statistics(session);
  view.unchanged = maps.empty() && still && arrivals == arrivals_of(session.statistics.last) &&
                   threshold_px == session.statistics.last_view.threshold_px;
  if (session.overlay) layout_controls(session, frame_ms);
  record_frame(session, slot.commands, views, maps);
  if (!image) {
    submit_frame(session.device, session.ring, VK_NULL_HANDLE, VK_NULL_HANDLE);
    return;
  }
  record_blit_to_image(slot.commands, session.screen->swapchain, *image, session.renderer.picture.image, extent);
  submit_frame(session.device, session.ring, slot.acquired, session.screen->swapchain.rendered[*image]);
  if (!present_image(session.device, session.screen->swapchain, *image)) recreate_swapchain(session);
}

float ms_since(Clock::time_point start) {
  return std::chrono::duration<float, std::milli>(Clock::now() - start).count();
}

void warm_up(Session& session, const Pose& pose, float time_s) {
  constexpr std::uint32_t kFrames = 4;
  constexpr float kGpuWakes_ms = 1000;
  const auto start = Clock::now();
  const float min_ms = session.device.software ? 0 : kGpuWakes_ms;
  for (std::uint32_t i = 0; i < kFrames || ms_since(start) < min_ms; ++i) render_frame(session, pose, time_s, 0);
}

void settle(Session& session, const Pose& pose, float time_s) {
  constexpr auto kPatience = std::chrono::seconds(2);
  const int max_quiet_frames = session.renderer.temporal ? 16 : 4;
  auto last_progress = Clock::now();
  std::uint64_t loaded = 0;
  float threshold_px = 0;
  for (int quiet_frames = 0; quiet_frames < max_quiet_frames;) {
    render_frame(session, pose, time_s, 0);
    wait_for_frames(session.device, session.ring);
    const coppice_stats& stats = session.statistics.last;
    if (const std::uint64_t now = stats.streamed[COPPICE_STREAMED_ALL].loaded + stats.scene_tiles_resident; now != loaded) {
      last_progress = Clock::now();
      loaded = now;
    }
    const bool done = stats.streamed[COPPICE_STREAMED_ALL].wanted == 0 && stats.streamed[COPPICE_STREAMED_ALL].in_flight == 0 &&
                      stats.scene_tiles_missing == 0 && session.statistics.last_view.threshold_px == threshold_px;
    threshold_px = session.statistics.last_view.threshold_px;
    quiet_frames = done || Clock::now() - last_progress > kPatience ? quiet_frames + 1 : 0;
    if (quiet_frames == 1 && session.renderer.shadows) outdate(*session.renderer.shadows);
  }
}

std::vector<float> supersampled_picture(Session& session, const Shot& shot, std::uint32_t side) {
  std::vector<float> mean;
  const auto samples = static_cast<float>(side * side);
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      session.jitter_px = (glm::vec2(x, y) + 0.5f) / static_cast<float>(side) - 0.5f;
      session.sample = side == 1 ? 0 : y * side + x + 1;
      render_frame(session, shot.pose, shot.time_s, 0);
      wait_for_frames(session.device, session.ring);
      const std::vector<std::uint8_t> sample = read_picture(session.renderer);
      mean.resize(sample.size());
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += static_cast<float>(sample[i]) / samples;
    }
  session.jitter_px = {0, 0};
  session.sample = 0;
  return mean;
}

void save_picture(Session& session, const Shot& shot, const std::string& file) {
  const Unveiled unveiled(session.overlay.get());
  if (session.overlay) render_frame(session, shot.pose, shot.time_s, 0);
  write_picture(session, shot, file);
  std::printf("picture              %s\n", file.c_str());
}

void record_picture(Session& session, const Shot& shot, const std::string& folder, std::uint32_t number) {
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "/%05u.png", number);
  write_picture(session, shot, folder + name.data());
}

}  // namespace forest
