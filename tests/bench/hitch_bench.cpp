// How long coppice_frame_begin and coppice_record_upload hold up a frame while plants stream: CPU time of the calling thread, so that other
// programs on the machine do not count. A camera walks along a row of plants whose leaf meshes do not all fit the budget; what it comes to
// is loaded, what it leaves is evicted. Times are reported and never judged.
//   hitch_bench [options] A.coppice B.coppice ...     each plant is opened as often as --species says
//   hitch_bench [options]                             random trees, made in some seconds

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

#include <CLI/CLI.hpp>

#include "atomic_file.h"
#include "context_desc.h"
#include "pack.h"
#include "random_tree.h"
#include "renderer_scene.h"

namespace {

using namespace coppice;

struct Options {
  std::vector<std::string> files;
  std::uint32_t species = 20, leaves = 40000, parts = 4, frames = 4000, texture_side = 1024;
  std::uint64_t budget_bytes = 128ull << 20;
  float streaming_ms = 1.0f, speed_m = 0.05f, error_px = 0.5f;
};

void check(coppice_status status, const char* call) {
  if (status != COPPICE_OK) throw std::runtime_error(std::string(call) + ": " + coppice_status_text(status));
}

double cpu_ms() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

std::vector<std::string> random_plants(const std::filesystem::path& folder, const Options& options) {
  std::vector<std::string> files;
  for (std::uint32_t i = 0; i < options.species; ++i) {
    bake::BakedPlant plant = test::random_plant(
        {.leaf_count = options.leaves, .seed = i + 1, .texture_side = options.texture_side, .leaf_mesh_count = options.parts});
    plant.sphere = {glm::vec3(0.0f), 1.6f};
    bake::PackSizes sizes;
    files.push_back((folder / (std::to_string(i) + ".coppice")).string());
    auto packed = bake::pack(plant, sizes);
    if (!packed || !bake::write_file_atomically(files.back(), *packed)) throw std::runtime_error("cannot write " + files.back());
  }
  return files;
}

constexpr float kSpacing_m = 6.0f;

struct Times {
  std::array<std::vector<double>, 3> ms;  ///< begin, upload, both
  std::map<std::string, double> longest;  ///< upload spans by kind of chunk: wall time, ms
};

void print(const char* name, std::vector<double>& values) {
  std::ranges::sort(values);
  const auto rank = [&](double share) { return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]; };
  std::printf("  %-24s p50 %.3f, p99 %.3f, p99.9 %.3f, max %.3f ms\n", name, rank(0.5), rank(0.99), rank(0.999), values.back());
}

void run(const Options& options, const std::vector<std::string>& files) {
  const test::VulkanDevice& gpu = test::vulkan_device(test::Validation::off);
  Times times;
  test::ContextDesc desc = test::context_desc(gpu);
  desc.memory_budget_bytes = options.budget_bytes;
  desc.streaming_ms = options.streaming_ms;
  desc.texture_compression_bc = gpu.texture_compression_bc ? VK_TRUE : VK_FALSE;
  desc.hooks.trace.user = &times;
  desc.hooks.trace.span = [](void* user, const coppice_trace_span* span) {
    if (span->kind != COPPICE_TRACE_UPLOAD) return;
    double& longest = static_cast<Times*>(user)->longest[span->chunk];
    longest = std::max(longest, 1e-6 * static_cast<double>(span->end_ns - span->start_ns));
  };
  coppice_context* context = nullptr;
  coppice_view view = 0;
  check(test::create_context(desc, &context), "coppice_vulkan_context_create");
  check(test::create_view(context, &view), "coppice_vulkan_view_create");
  for (std::uint32_t i = 0; i < options.species; ++i) {
    coppice_plant plant = 0;
    check(coppice_plant_open_async(context, files[i % files.size()].c_str(), &plant), "coppice_plant_open_async");
    std::vector<coppice_placement> placements;
    for (int copy = 0; copy < 15; ++copy)
      placements.push_back(test::placement_at({kSpacing_m * static_cast<float>(i), 0.0f, -kSpacing_m * static_cast<float>(copy)}));
    check(coppice_instances_add(context, plant, placements.data(), sizeof placements[0], static_cast<std::uint32_t>(placements.size()),
                                nullptr),
          "coppice_instances_add");
  }
  const float length_m = kSpacing_m * static_cast<float>(options.species);
  for (std::uint32_t i = 1; i <= options.frames; ++i) {
    const float turns = options.speed_m * static_cast<float>(i) / length_m;
    const float along = turns - std::floor(turns), x_m = length_m * (along < 0.5f ? 2.0f * along : 2.0f - 2.0f * along);
    test::Shot shot = test::make_view({.eye_m = {x_m, 0.5f, 4.0f}, .target_m = {x_m, 0.5f, 0.0f}, .width_px = 1280, .height_px = 720});
    shot.error_px = options.error_px;
    coppice_camera camera = shot;
    camera.view = view;
    auto frame = test::defaults(coppice_frame_init);
    frame.frame_number = i;
    frame.completed_number = i - 1;
    frame.cameras = &camera;
    frame.camera_count = 1;
    const double start_ms = cpu_ms();
    check(coppice_frame_begin(context, &frame), "coppice_frame_begin");
    const double begin_ms = cpu_ms() - start_ms;
    double upload_ms = 0;
    test::submit(gpu, [&](VkCommandBuffer cmd) {
      const double upload_start_ms = cpu_ms();
      check(coppice_record_upload(context, cmd), "coppice_record_upload");
      upload_ms = cpu_ms() - upload_start_ms;
    });
    times.ms[0].push_back(begin_ms);
    times.ms[1].push_back(upload_ms);
    times.ms[2].push_back(begin_ms + upload_ms);
    ::usleep(1000);
  }
  auto stats = test::defaults(coppice_stats_init);
  check(coppice_get_stats(context, &stats), "coppice_get_stats");
  coppice_context_destroy(context);
  const coppice_streamed_stats& all = stats.streamed[COPPICE_STREAMED_ALL];
  std::printf("streaming_ms %.2f: %llu chunks loaded, %llu evicted, %.1f MB read in %u frames\n", static_cast<double>(options.streaming_ms),
              static_cast<unsigned long long>(all.loaded), static_cast<unsigned long long>(all.evicted),
              1e-6 * static_cast<double>(stats.bytes_read), options.frames);
  constexpr std::array kNames{"coppice_frame_begin", "coppice_record_upload", "both"};
  for (std::size_t k = 0; k < times.ms.size(); ++k) print(kNames[k], times.ms[k]);
  for (const auto& [chunk, ms] : times.longest) std::printf("  longest upload of a %s: %.2f ms of wall time\n", chunk.c_str(), ms);
}

}  // namespace

// What is thrown before the try block is CLI11's word that we use it wrongly.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char** argv) {
  Options options;
  CLI::App app("Hitches of frames while plants stream", "hitch_bench");
  app.add_option("files", options.files, ".coppice files; default: random trees");
  app.add_option("--species", options.species)->check(CLI::Range(1u, 4096u))->capture_default_str();
  app.add_option("--leaves", options.leaves, "Of a random tree")->check(CLI::Range(100u, 200000u))->capture_default_str();
  app.add_option("--parts", options.parts, "Of a random tree's leaf meshes")->check(CLI::Range(0u, 16u))->capture_default_str();
  app.add_option("--texture-side", options.texture_side)->check(CLI::Range(1u, 4096u))->capture_default_str();
  app.add_option("--frames", options.frames)->check(CLI::Range(100u, 1000000u))->capture_default_str();
  app.add_option("--budget", options.budget_bytes, "Bytes")->capture_default_str();
  app.add_option("--streaming-ms", options.streaming_ms)->capture_default_str();
  app.add_option("--speed", options.speed_m, "Metres a frame")->capture_default_str();
  app.add_option("--error-px", options.error_px)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("hitch_bench_" + std::to_string(::getpid()));
  try {
    std::filesystem::create_directories(folder);
    run(options, options.files.empty() ? random_plants(folder, options) : options.files);
    std::filesystem::remove_all(folder);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hitch_bench: %s\n", error.what());
    return 1;
  }
}
