// coppice-engine-host PLANT.coppice...: draws a wood 50 km from the origin, in which plants come, go and move, and prints what Coppice
// took.
#include <CLI/CLI.hpp>
#include <ctime>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <random>

#include "plants.h"

namespace engine {
namespace {

struct Options {
  std::vector<std::string> plants;
  std::uint32_t instances = 300, frames = 60, views = 2, width = 640, threads = 2;
  std::string picture;
};

/// Of each call, and of all calls of a frame: microseconds of this thread's CPU time. Of memory: KiB.
std::map<std::string, std::vector<double>> figures;

template <class Call>
double timed(const char* name, const Call& call) {
  timespec begin{}, end{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
  check(call(), name);
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
  return figures[name].emplace_back(1e6 * double(end.tv_sec - begin.tv_sec) + 1e-3 * double(end.tv_nsec - begin.tv_nsec));
}

struct World {
  coppice_context* context = nullptr;
  std::vector<coppice_plant> plants;
  std::vector<coppice_placement> placements;
  std::vector<coppice_instance> instances;
  glm::dvec3 origin{0, 0, 0};           ///< coppice_set_origin
  glm::dvec3 middle{40000, 0, -30000};  ///< of the wood, counted from the origin, as all positions are
  double radius_m = 0;
  glm::vec3 sun_direction = glm::normalize(glm::vec3(0.5f, 0.7f, 0.3f));
};

void add(World& world, std::size_t first, std::uint32_t count) {
  check(coppice_instances_add(world.context, world.plants[first / 32 % world.plants.size()], &world.placements[first],
                              sizeof world.placements[0], count, &world.instances[first]),
        "coppice_instances_add");
}

/// Adds neighbours together: the 32 plants of a square of 20 m.
void plant_wood(World& world, std::uint32_t count) {
  std::mt19937 random(7);
  const auto share = [&random] { return double(random()) / 4294967296.0; };
  const double side_m = 20;
  const std::uint32_t wide = std::max(1u, std::uint32_t(std::sqrt(count / 32.0)));
  world.radius_m = wide * side_m / 2;
  for (std::uint32_t i = 0; i < count; ++i) {
    auto& placement = world.placements.emplace_back(made(coppice_placement_init));
    placement.position[0] = world.middle.x + (i / 32 % wide + share()) * side_m - world.radius_m;
    placement.position[2] = world.middle.z + (i / 32 / wide + share()) * side_m - world.radius_m;
    placement.scale = float(0.7 + 0.5 * share());
    const double half_angle = 3.1416 * share();
    placement.rotation[1] = float(std::sin(half_angle));
    placement.rotation[3] = float(std::cos(half_angle));
  }
  world.instances.resize(count);
  for (std::uint32_t i = 0; i < count; i += 32) add(world, i, std::min(32u, count - i));
}

/// In each frame some plants go, others come in their places, and some move.
void churn(World& world, std::uint64_t frame) {
  const auto count = std::uint32_t(world.instances.size() / 1000 + 1);
  const std::size_t groups = world.instances.size() / count;
  const std::size_t changed = frame * 7919 % groups * count, moved = frame * 104729 % groups * count;
  check(coppice_instances_remove(world.context, &world.instances[changed], count), "coppice_instances_remove");
  add(world, changed, count);
  for (std::size_t i = moved; i < moved + count; ++i) world.placements[i].position[0] += 0.01;
  check(coppice_instances_move(world.context, &world.instances[moved], &world.placements[moved], sizeof world.placements[0], count),
        "coppice_instances_move");
}

/// As a game does whose player has walked far: all positions count from the middle of the wood from now on.
void move_origin(World& world) {
  world.origin += world.middle;
  check(coppice_set_origin(world.context, &world.origin[0]), "coppice_set_origin");
  for (coppice_placement& placement : world.placements)
    for (int i = 0; i < 3; ++i) placement.position[i] -= world.middle[i];
  world.middle = {0, 0, 0};
}

/// By how much a frame is moved: points that fill the pixel evenly.
glm::dvec2 jitter_px(std::uint64_t frame) {
  return glm::fract(double(frame % 16) * glm::dvec2(0.7548776662, 0.5698402910)) - 0.5;
}

/// The first view walks through the wood, the others look down at it.
coppice_camera camera_of(const World& world, const View& view, bool walks, std::uint64_t frame) {
  auto camera = made(coppice_camera_init);
  const double angle = 0.4 + 0.004 * double(frame), away_m = 0.35 * std::min(world.radius_m, 60.0) + 4.0;
  const glm::dvec3 eye = world.middle + glm::dvec3(away_m * std::cos(angle), walks ? 2.2 : 14.0, away_m * std::sin(angle));
  const glm::dmat4 view_from_world = glm::lookAt(eye, world.middle + glm::dvec3(0, 1.5, 0), glm::dvec3(0, 1, 0));
  // Reversed depth without a far plane; Vulkan's y points down.
  const glm::dvec2 size(view.size.width, view.size.height), moved = -2.0 * jitter_px(frame) / size;
  const double zoom = 1.2, near_m = 0.1;
  const glm::mat4 clip_from_view(zoom * size.y / size.x, 0, 0, 0, 0, -zoom, 0, 0, moved.x, moved.y, 0, -1, 0, 0, near_m, 0);
  std::copy_n(glm::value_ptr(view_from_world), 16, camera.view_from_world);
  std::copy_n(glm::value_ptr(clip_from_view), 16, camera.clip_from_view);
  camera.view = view.plants;
  camera.width_px = view.size.width;
  camera.height_px = view.size.height;
  camera.temporal_frame = std::uint32_t(frame % 16 + 1);
  return camera;
}

glm::dmat4 clip_from_world(const coppice_camera& camera) {
  return glm::dmat4(glm::make_mat4(camera.clip_from_view)) * glm::make_mat4(camera.view_from_world);
}

LightConstants light_constants(const World& world, const View& view, const coppice_camera& camera, const coppice_camera& sun,
                               std::uint64_t frame) {
  const glm::dmat4 world_from_eye = glm::translate(glm::dmat4(1), glm::dvec3(glm::inverse(glm::make_mat4(camera.view_from_world))[3]));
  const glm::dmat4x3 ray(glm::inverse(clip_from_world(camera) * world_from_eye)), shadow(clip_from_world(sun) * world_from_eye);
  const glm::mat3 ray_from_clip(ray[0], ray[1], ray[2] + ray[3]);
  const glm::vec2 jitter = jitter_px(frame) - jitter_px(frame - 1);
  return {ray_from_clip, shadow, world.sun_direction, float(world_from_eye[3].y), jitter, frame == 1 ? 1.0f : 0.1f, view.picture.address};
}

/// The sun's view comes first: its depth is the other views' shadow map. kind: of frame, for the figures
void draw_frame(const Gpu& gpu, const LightPass& pass, World& world, std::vector<View>& views, std::uint64_t number, const char* kind) {
  std::vector<coppice_camera> cameras = {made(coppice_camera_init)};
  auto sun = made(coppice_sun_desc_init);
  std::copy_n(&world.sun_direction[0], 3, sun.sun_direction);
  std::copy_n(&world.middle[0], 3, sun.center);
  sun.radius_m = 40;
  sun.size_px = views[0].size.width;
  check(coppice_sun_camera(world.context, views[0].plants, &sun, &cameras[0]), "coppice_sun_camera");
  for (std::size_t i = 1; i < views.size(); ++i) cameras.push_back(camera_of(world, views[i], i == 1, number));
  auto wind = made(coppice_wind_init);
  wind.speed = 6;
  wind.time_s = double(number) / 60;
  wind.time_before_s = double(number - 1) / 60;
  auto frame = made(coppice_frame_init);
  frame.frame_number = number;
  frame.completed_number = number - std::min<std::uint64_t>(number, kFramesInFlight);  // begin_commands waits for it
  frame.cameras = cameras.data();
  frame.camera_count = std::uint32_t(cameras.size());
  frame.wind = &wind;
  const Image& shadow_map = views[0].images[0];
  coppice_shadow_map map{*shadow_map.view, {}};
  std::copy_n(glm::value_ptr(clip_from_world(cameras[0])), 16, map.clip_from_world);
  auto sunlight = made(coppice_light_init);
  std::copy_n(&world.sun_direction[0], 3, sunlight.sun_direction);
  sunlight.shadow_maps = &map;
  sunlight.shadow_map_count = 1;

  const vk::raii::CommandBuffer& cmd = begin_commands(gpu, number);
  double us = timed("frame_begin", [&] { return coppice_frame_begin(world.context, &frame); });
  us += timed("record_upload", [&] { return coppice_record_upload(world.context, *cmd); });
  for (std::size_t i = 0; i < views.size(); ++i) {
    View& view = views[i];
    us += timed("record_cull", [&] { return coppice_record_cull(world.context, *cmd, view.plants, i == 0 ? nullptr : &sunlight); });
    render(cmd, view, [&] {  // the engine draws everything else in here too
      us += timed("record_draw", [&] { return coppice_record_draw(world.context, *cmd, view.plants, 0); });
    });
    if (i > 0) light(pass, cmd, view, shadow_map, light_constants(world, view, cameras[i], cameras[0], number), number);
  }
  submit_commands(gpu, cmd, number);
  figures[kind].push_back(us);
}

void write_pictures(const std::string& path, const std::vector<View>& views) {
  std::ofstream out(path, std::ios::binary);
  const vk::Extent2D size = views[1].size;
  out << "P6\n" << size.width * (views.size() - 1) << ' ' << size.height << "\n255\n";
  for (std::size_t y = 0; y < size.height; ++y)
    for (std::size_t i = 1; i < views.size(); ++i)
      for (std::size_t x = 0; x < size.width; ++x) out.write(views[i].picture.mapped + 4 * (y * size.width + x), 3);
  if (!out.flush()) throw std::runtime_error("cannot write " + path);
}

void print_figures(const Options& options) {
  std::printf("figure,instances,views,samples,median,p99,p99.9,max\n");
  for (auto& [name, values] : figures) {
    std::sort(values.begin(), values.end());
    std::printf("%s,%u,%u,%zu", name.c_str(), options.instances, options.views, values.size());
    for (const double share : {0.5, 0.99, 0.999, 1.0}) std::printf(",%.0f", values[std::size_t(share * double(values.size() - 1))]);
    std::printf("\n");
  }
}

void run(const Options& options) {
  Gpu gpu;
  JobPool pool(options.threads);
  Archive archive(options.plants, options.threads > 0);
  std::vector<View> views;
  const LightPass pass(gpu.device);
  const Context context = create_context(gpu, pool, archive);
  World world{.context = context.get()};
  views.push_back(create_view(gpu, world.context, COPPICE_OUTPUT_DEPTH, {1024, 1024}));
  for (std::uint32_t i = 0; i < options.views; ++i)
    views.push_back(create_view(gpu, world.context, COPPICE_OUTPUT_SURFACE, {options.width, options.width * 9 / 16}));
  for (const std::string& path : options.plants)
    check(coppice_plant_open_async(world.context, path.c_str(), &world.plants.emplace_back()), "coppice_plant_open_async");
  plant_wood(world, options.instances);
  for (std::uint64_t frame = 1, played = 0; played < options.frames; ++frame) {
    if (frame > 10'000) throw std::runtime_error("after 10,000 frames not everything in demand has arrived");
    if (played > 0 && played == options.frames / 2) move_origin(world);
    if (played > 0) churn(world, frame);
    draw_frame(gpu, pass, world, views, frame, played > 0 ? "a frame of play" : "a frame while loading");
    std::uint32_t is_settled = COPPICE_FALSE;
    auto stats = made(coppice_stats_init);
    check(coppice_get_stats(world.context, &stats), "coppice_get_stats");
    check(coppice_is_settled(world.context, views[1].plants, &is_settled), "coppice_is_settled");
    figures["memory, KiB"].push_back(double(stats.memory_bytes >> 10));
    played += played > 0 || (is_settled && stats.pipelines_built == stats.pipelines_wanted);
  }
  gpu.device.waitIdle();
  if (!options.picture.empty()) write_pictures(options.picture, views);
  print_figures(options);
}

}  // namespace
}  // namespace engine

int main(int argc, char** argv) try {
  engine::Options options;
  CLI::App app("Draws a wood of baked plants as an engine would, and prints the microseconds of CPU time that Coppice took");
  app.add_option("plants", options.plants, "PLANT.coppice...")->required();
  app.add_option("--picture", options.picture, "PPM file for the last frame of each view, side by side");
  app.add_option("--instances", options.instances)->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--frames", options.frames, "after everything has been loaded")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--views", options.views)->check(CLI::Range(1, 8))->capture_default_str();
  app.add_option("--width", options.width, "px of each view")->check(CLI::Range(16, 4096))->capture_default_str();
  app.add_option("--threads", options.threads, "for jobs; 0: the picture is the same in every run")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  engine::run(options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "coppice-engine-host: %s\n", error.what());
  return 1;
}
