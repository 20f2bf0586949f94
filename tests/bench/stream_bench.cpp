// A flight through a forest whose plants do not fit the memory budget, with every byte counted from outside: by the allocator hook and by
// wrapped vkAllocateMemory and vkFreeMemory. Ends with 1 where the budget is exceeded in any frame, where a plant in view cannot be drawn
// from the third frame on or others are in view than with everything resident, or where a validation message comes; times are reported and
// never judged.
//   stream_bench [options] A.coppice B.coppice ...     opened again and again until there are --species
//   stream_bench [options] --bake FOLDER               built-in plants with different seeds; what is in the folder is not baked again
//   stream_bench [options]                             random trees, made in a second or two

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "bake.h"
#include "context_desc.h"
#include "coppice/vulkan.h"
#include "counted_memory.h"
#include "generate_plant.h"
#include "gltf_write.h"
#include "hooks.h"
#include "pack.h"
#include "random_tree.h"
#include "renderer_scene.h"
#include "stopwatch.h"
#include "vulkan_device.h"

namespace {

using namespace coppice;

struct Options {
  std::vector<std::string> files;
  std::string bake_folder, json;
  std::uint32_t species = 42, leaves = 65000, instances = 4000, frames = 2000, width_px = 640, height_px = 360, pictures = 10;
  std::uint64_t budget_bytes = 0;  ///< 0: a twentieth of what everything takes
  float error_px = 2.0f, speed_m = 0.2f;
  bool validation = false, raster = false, compare = false;
};

/// How a run streams.
struct Streaming {
  const char* name = "streamed";
  Reading reading = Reading::automatic;
  float prefetch_frames = 20.0f;
};

void expect(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().message());
}

template <class T>
T expect(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return *std::move(result);
}

std::vector<std::string> baked_plants(const std::filesystem::path& folder, std::uint32_t count) {
  constexpr std::array kSpecies = {"willow", "corylus", "juniper"};
  std::filesystem::create_directories(folder);
  std::vector<std::string> files;
  for (std::uint32_t i = 0; i < count; ++i) {
    const char* species = kSpecies[i % kSpecies.size()];
    const std::string stem = (folder / species).string() + "_" + std::to_string(i);
    files.push_back(stem + ".coppice");
    if (std::filesystem::exists(files.back())) continue;
    const bake::Plant plant = expect(bake::generate_plant(species, i + 1));
    expect(bake::write_glb(stem + ".glb", {{"leaves", &plant.foliage}, {"wood", &plant.wood}}, plant.materials, plant.images));
    bake::BakeReport report;
    const auto bytes = expect(bake::bake(
        stem + ".glb", {}, [](const char*, double) {}, report));
    expect(bake::write_file_atomically(files.back(), bytes));
    std::filesystem::remove(stem + ".glb");
    std::printf("baked %s in %.1f s\n", files.back().c_str(), report.seconds.total);
  }
  return files;
}

std::vector<std::string> random_plants(const std::filesystem::path& folder, std::uint32_t count, std::uint32_t leaves) {
  std::vector<std::string> files;
  for (std::uint32_t i = 0; i < count; ++i) {
    bake::BakedPlant plant = test::random_plant({.leaf_count = leaves / 2 + leaves / 16 * (i % 17), .seed = i + 1, .texture_side = 64});
    plant.sphere = {glm::vec3(0.0f), 1.6f};
    bake::PackSizes sizes;
    files.push_back((folder / (std::to_string(i) + ".coppice")).string());
    expect(bake::write_file_atomically(files.back(), expect(bake::pack(plant, sizes))));
  }
  return files;
}

constexpr float kSpacing_m = 5.0f;

std::uint32_t hashed(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

/// Species stand in groves: eight kinds in each square of eight by eight plants.
std::uint32_t species_at(std::uint32_t row, std::uint32_t column, std::uint32_t species_count) {
  const std::uint32_t grove = hashed(row / 8 * 4099 + column / 8);
  return (grove + hashed(row * 65537 + column) % 8) % species_count;
}

struct Forest {
  std::uint32_t side = 0;
  std::vector<coppice_plant> plants;
  [[nodiscard]] float half_m() const { return 0.5f * kSpacing_m * static_cast<float>(side); }
};

/// The eye at a distance along a circle round the middle, so that about as much forest lies before it everywhere: what frames then differ
/// by is streaming. For the same reason it flies above the crowns, along a ride in which no plant stands.
glm::vec3 eye_at(const Forest& forest, float along_m) {
  const float radius_m = 0.5f * forest.half_m(), turn = along_m / radius_m;
  return {radius_m * std::sin(turn), 6.0f + 0.5f * std::sin(3.0f * turn), radius_m * std::cos(turn)};
}

bool in_ride(const Forest& forest, const coppice_placement& placement) {
  constexpr float kHalfWidth_m = 3.0f;
  return std::abs(std::hypot(placement.position[0], placement.position[2]) - 0.5f * forest.half_m()) < kHalfWidth_m;
}

test::Shot view_at(const Options& options, const Forest& forest, std::uint32_t frame) {
  const float along_m = options.speed_m * static_cast<float>(frame);
  test::Shot view = test::make_view({.eye_m = eye_at(forest, along_m),
                                     .target_m = eye_at(forest, along_m + 3.0f),
                                     .vertical_fov_radians = 1.05f,
                                     .width_px = options.width_px,
                                     .height_px = options.height_px});
  view.error_px = options.error_px;
  return view;
}

struct Percentiles {
  double p50 = 0, p99 = 0, max = 0;
};

Percentiles percentiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto rank = [&](double share) { return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]; };
  return {rank(0.5), rank(0.99), values.back()};
}

struct Sample {
  std::uint32_t frame = 0;
  float threshold_px = 0;
  std::uint32_t wanted = 0, in_flight = 0;
  std::uint64_t memory_bytes = 0;
};

/// What is timed in each frame: its key in the report, and how it is printed.
struct Timed {
  const char* key;
  const char* label;
  int decimals;
};
enum TimedIndex : std::size_t { kBegin, kUpload, kRecord, kFrame, kTimedCount };
constexpr std::array<Timed, kTimedCount> kTimed{
    {{"begin_ms", "coppice_frame_begin", 3}, {"upload_ms", "upload", 3}, {"record_ms", "upload and cull", 3}, {"frame_ms", "frame", 2}}};

struct RunResult {
  std::array<std::vector<double>, kTimedCount> ms;  ///< [TimedIndex][frame]
  std::vector<Sample> samples;
  std::vector<test::Picture> pictures;
  coppice_stats stats{};
  double seconds = 0;
  std::uint64_t counted_peak_bytes = 0, full_bytes = 0;
  std::uint64_t max_device_allocations = 0, device_calls = 0;  ///< calls of the frames
  std::uint32_t frames_over_budget = 0, frames_with_missing_plants = 0;
  std::uint32_t frames_waiting = 0;  ///< frames in which something that the view wants is not there
  double threshold_sum_px = 0;
  std::vector<std::uint32_t> visible;  ///< [frame] instances in view, as the GPU has counted them; the last is not known
  std::optional<std::uint32_t> first_complete_frame, settled_frame;
};

class Run {
 public:
  Run(const Options& options, const Streaming& streaming, std::uint64_t budget_bytes) : options_(options), budget_bytes_(budget_bytes) {
    const test::VulkanDevice& gpu = device();
    test::ContextDesc desc = test::context_desc(gpu);
    desc.memory_budget_bytes = budget_bytes;
    test::count_memory(desc);
    hooks_ = expect(complete_hooks({.allocator = desc.hooks.allocator}, streaming.reading));
    desc.hooks.jobs = hooks_.hooks.jobs;
    desc.hooks.io = hooks_.hooks.io;
    desc.prefetch_frames = streaming.prefetch_frames;
    desc.texture_compression_bc = gpu.texture_compression_bc ? VK_TRUE : VK_FALSE;
    desc.compute_raster = options.raster ? VK_TRUE : VK_FALSE;
    desc.shader_int64_atomics = gpu.int64_atomics ? VK_TRUE : VK_FALSE;
    desc.hooks.log.write = [](void*, coppice_log_level level, const char* line) {
      if (level != COPPICE_LOG_INFO) std::fprintf(stderr, "coppice: %s\n", line);
    };
    check(test::create_context(desc, &context_), "coppice_vulkan_context_create");
    check(test::create_view(context_, &view_), "coppice_vulkan_view_create");
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
  ~Run() { coppice_context_destroy(context_); }

  void plant(const std::vector<std::string>& files) {
    forest_.side = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(options_.instances))));
    for (std::uint32_t i = 0; i < options_.species; ++i) {
      coppice_plant plant = 0;
      check(coppice_plant_open(context_, files[i % files.size()].c_str(), &plant), "coppice_plant_open");
      forest_.plants.push_back(plant);
    }
    std::vector<std::vector<coppice_placement>> placements(options_.species);
    for (std::uint32_t i = 0; i < options_.instances; ++i) {
      const std::uint32_t row = i / forest_.side, column = i % forest_.side, random = hashed(i);
      const auto offset = [&](std::uint32_t cell, std::uint32_t bits) {
        return (static_cast<float>(cell) + 0.8f * static_cast<float>(bits & 0xffffu) / 65536.0f) * kSpacing_m - forest_.half_m();
      };
      const float yaw = static_cast<float>(random % 6283u) * 0.0005f;
      coppice_placement placement = test::placement_at({offset(column, random), 0.0f, offset(row, random >> 16)},
                                                       0.8f + 0.4f * static_cast<float>(random % 97u) / 97.0f);
      placement.rotation[1] = std::sin(yaw);
      placement.rotation[3] = std::cos(yaw);
      if (!in_ride(forest_, placement)) placements[species_at(row, column, options_.species)].push_back(placement);
    }
    for (std::uint32_t i = 0; i < options_.species; ++i)
      check(coppice_instances_add(context_, forest_.plants[i], placements[i].data(), sizeof(coppice_placement),
                                  static_cast<std::uint32_t>(placements[i].size()), nullptr),
            "coppice_instances_add");
  }

  /// Everything resident: what the plants take when nothing is left out.
  void load_all() {
    test::Shot view = view_at(options_, forest_, 0);
    view.lod = COPPICE_LOD_FULL;
    frame(view, false, nullptr);
    const std::uint64_t empty = stats().memory_bytes;
    for (int i = 0; i < 20000; ++i) {
      frame(view, false, nullptr);
      const coppice_stats now = stats();
      const auto& all = now.streamed[COPPICE_STREAMED_ALL];
      if (i > 3 && all.wanted == 0 && all.in_flight == 0) break;
      if (all.in_flight > 0) ::usleep(500);
    }
    result.full_bytes = stats().memory_bytes - empty;
  }

  void fly() {
    const test::Stopwatch watch;
    const std::uint64_t calls = test::counted_device_calls().calls;
    const std::uint32_t step = std::max(options_.frames / std::max(options_.pictures, 1u), 1u);
    for (std::uint32_t i = 0; i < options_.frames; ++i) {
      const bool picture = options_.pictures > 0 && i % step == step - 1;
      frame(view_at(options_, forest_, i), true, picture ? &result.pictures.emplace_back() : nullptr);
      account(i);
    }
    result.seconds = watch.seconds();
    result.device_calls = test::counted_device_calls().calls - calls;
    result.stats = stats();
  }

  RunResult result;

 private:
  const test::VulkanDevice& device() const {
    return test::vulkan_device(options_.validation ? test::Validation::on : test::Validation::off);
  }
  static void check(coppice_status status, const char* call) {
    if (status != COPPICE_OK) throw std::runtime_error(std::string(call) + ": " + coppice_status_text(status));
  }
  [[nodiscard]] coppice_stats stats() const {
    auto stats = test::defaults(coppice_stats_init);
    check(coppice_get_stats(context_, &stats), "coppice_get_stats");
    return stats;
  }

  /// How many plants cannot be drawn at all.
  [[nodiscard]] std::uint32_t missing_plants() const {
    std::uint32_t missing = 0;
    for (const coppice_plant plant : forest_.plants) {
      auto info = test::defaults(coppice_plant_info_init);
      check(coppice_plant_get_info(context_, plant, &info), "coppice_plant_get_info");
      missing += info.page_count > 0 && info.resident_page_count == 0;
    }
    return missing;
  }

  void account(std::uint32_t index) {
    const std::uint64_t counted = test::counted_bytes();
    result.counted_peak_bytes = std::max(result.counted_peak_bytes, counted);
    result.frames_over_budget += counted > budget_bytes_;
    result.max_device_allocations = std::max(result.max_device_allocations, test::counted_device_calls().live);
    const bool complete = missing_plants() == 0;
    if (complete && !result.first_complete_frame) result.first_complete_frame = index + 1;
    result.frames_with_missing_plants += !complete;
    const coppice_stats now = stats();
    const auto& all = now.streamed[COPPICE_STREAMED_ALL];
    auto drawn = test::defaults(coppice_view_stats_init);
    check(coppice_get_view_stats(context_, view_, &drawn), "coppice_get_view_stats");
    if (all.wanted == 0 && !result.settled_frame && complete) result.settled_frame = index + 1;
    result.frames_waiting += all.wanted > 0;
    result.threshold_sum_px += static_cast<double>(drawn.threshold_px);
    if (index > 0) result.visible.push_back(drawn.visible_instance_count);
    if (index % std::max(options_.frames / 100, 1u) == 0)
      result.samples.push_back({index, drawn.threshold_px, all.wanted, all.in_flight, now.memory_bytes});
  }

  void record(VkCommandBuffer cmd, const test::Shot& view) {
    const test::Stopwatch watch;
    check(coppice_record_upload(context_, cmd), "coppice_record_upload");
    upload_ms_ = watch.ms();
    check(coppice_record_cull(context_, cmd, view_, &view.light), "coppice_record_cull");
  }

  void frame(const test::Shot& view, bool draw, test::Picture* picture) {
    auto begun = test::defaults(coppice_frame_init);
    begun.frame_number = ++frame_number_;
    begun.completed_number = frame_number_ - 1;
    coppice_camera camera = view;
    camera.view = view_;
    begun.cameras = &camera;
    begun.camera_count = 1;
    const test::Stopwatch watch;
    check(coppice_frame_begin(context_, &begun), "coppice_frame_begin");
    const double begin_ms = watch.ms();
    if (!draw) {
      test::submit(device(), [&](VkCommandBuffer cmd) { record(cmd, view); });
      return;
    }
    double record_ms = 0;
    test::Picture drawn = test::draw_on_white(
        device(), view,
        [&](VkCommandBuffer cmd) {
          const test::Stopwatch recording;
          record(cmd, view);
          record_ms = recording.ms();
        },
        [&](VkCommandBuffer cmd) { check(coppice_record_draw(context_, cmd, view_, 0), "coppice_record_draw"); });
    for (const auto& [index, ms] : {std::pair{kBegin, begin_ms}, {kUpload, upload_ms_}, {kRecord, record_ms}, {kFrame, watch.ms()}})
      result.ms[index].push_back(ms);
    if (picture != nullptr) *picture = std::move(drawn);
  }

  const Options& options_;
  HookSet hooks_;
  std::uint64_t budget_bytes_;
  coppice_context* context_ = nullptr;
  coppice_view view_ = 0;
  Forest forest_;
  std::uint64_t frame_number_ = 0;
  double upload_ms_ = 0;  ///< what the last frame took
};

/// The error of luminance, 0..255, over all pixels.
double luminance_rmse(const test::Picture& a, const test::Picture& b) {
  const auto luminance = [](const std::uint8_t* rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; };
  double sum = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) sum += std::pow(luminance(&a.rgba[i]) - luminance(&b.rgba[i]), 2.0);
  return std::sqrt(sum / (static_cast<double>(a.rgba.size()) / 4.0));
}

nlohmann::ordered_json json_of(const RunResult& run) {
  nlohmann::ordered_json json;
  for (std::size_t i = 0; i < kTimedCount; ++i) {
    const Percentiles p = percentiles(run.ms[i]);
    json[kTimed[i].key] = {{"p50", p.p50}, {"p99", p.p99}, {"max", p.max}};
  }
  const auto& all = run.stats.streamed[COPPICE_STREAMED_ALL];
  json.update({{"seconds", run.seconds},
               {"counted_peak_bytes", run.counted_peak_bytes},
               {"memory_peak_bytes", run.stats.memory_peak_bytes},
               {"most_device_allocations", run.max_device_allocations},
               {"device_allocation_calls", run.device_calls},
               {"pages_loaded", all.loaded},
               {"pages_evicted", all.evicted},
               {"pages_cancelled", all.cancelled},
               {"bytes_read", run.stats.bytes_read},
               {"bytes_per_s", static_cast<double>(run.stats.bytes_read) / run.seconds},
               {"decode_ms", run.stats.decode_ms}});
  if (run.first_complete_frame) json["first_complete_frame"] = *run.first_complete_frame;
  if (run.settled_frame) json["settled_frame"] = *run.settled_frame;
  json["frames_over_budget"] = run.frames_over_budget;
  json["frames_waiting"] = run.frames_waiting;
  json["threshold_px_mean"] = run.threshold_sum_px / static_cast<double>(run.ms[kFrame].size());
  json["frames_with_missing_plants"] = run.frames_with_missing_plants;
  for (const Sample& sample : run.samples)
    json["samples"].push_back({{"frame", sample.frame},
                               {"threshold_px", sample.threshold_px},
                               {"pages_wanted", sample.wanted},
                               {"pages_in_flight", sample.in_flight},
                               {"memory_bytes", sample.memory_bytes}});
  return json;
}

void print(const char* name, const RunResult& run) {
  std::printf("%s\n", name);
  for (std::size_t i = 0; i < kTimedCount; ++i) {
    const Percentiles p = percentiles(run.ms[i]);
    const int decimals = kTimed[i].decimals;
    std::printf("  %-20s p50 %.*f ms, p99 %.*f, max %.*f\n", kTimed[i].label, decimals, p.p50, decimals, p.p99, decimals, p.max);
  }
  const auto& all = run.stats.streamed[COPPICE_STREAMED_ALL];
  std::printf("  counted memory       peak %.2f MiB\n", static_cast<double>(run.counted_peak_bytes) / (1 << 20));
  std::printf("  device allocations   %llu at most; %llu calls in the frames\n",
              static_cast<unsigned long long>(run.max_device_allocations), static_cast<unsigned long long>(run.device_calls));
  std::printf("  threshold            mean %.2f px; %u of %zu frames wait for something\n",
              run.threshold_sum_px / static_cast<double>(run.ms[kFrame].size()), run.frames_waiting, run.ms[kFrame].size());
  std::printf("  pages                %llu loaded, %llu evicted, %llu cancelled; %.1f MB/s read\n",
              static_cast<unsigned long long>(all.loaded), static_cast<unsigned long long>(all.evicted),
              static_cast<unsigned long long>(all.cancelled), 1e-6 * static_cast<double>(run.stats.bytes_read) / run.seconds);
}

bool require(bool holds, const char* what) {
  if (!holds) std::printf("FAILED: %s\n", what);
  return holds;
}

/// Whether what streaming promises holds, with a line on it.
bool judge(const Options& options, std::uint64_t budget_bytes, const RunResult& all, const RunResult& streamed) {
  const std::uint32_t complete = streamed.first_complete_frame.value_or(options.frames + 1);
  const auto highest = std::ranges::max_element(streamed.samples, {}, &Sample::threshold_px);
  std::printf("  budget %.2f MiB of %.2f: a %.1fth; threshold %.2f px, at most %.2f; every plant there from frame %u on\n",
              static_cast<double>(budget_bytes) / (1 << 20), static_cast<double>(all.full_bytes) / (1 << 20),
              static_cast<double>(all.full_bytes) / static_cast<double>(budget_bytes), static_cast<double>(options.error_px),
              static_cast<double>(highest->threshold_px), complete);
  bool good = require(streamed.frames_over_budget == 0, "the budget is exceeded");
  good = require(complete <= 3, "a plant is not there by the third frame") && good;
  good = require(streamed.frames_with_missing_plants + 1 <= complete, "a plant is gone again") && good;
  // With the rasteriser what hides what depends on how fine it is.
  good = require(options.raster || streamed.visible == all.visible, "other plants are in view than with everything resident") && good;
  return require(highest->threshold_px > options.error_px, "the budget is not tight: nothing was tested") && good;
}

nlohmann::ordered_json errors_of(const RunResult& all, const RunResult& streamed) {
  nlohmann::ordered_json errors = nlohmann::ordered_json::array();
  double sum = 0;
  for (std::size_t i = 0; i < streamed.pictures.size(); ++i) {
    errors.push_back(luminance_rmse(all.pictures[i], streamed.pictures[i]));
    sum += errors.back().get<double>();
  }
  if (!errors.empty())
    std::printf("  rmse against everything resident: mean %.2f of %zu pictures, first %.2f, last %.2f\n",
                sum / static_cast<double>(errors.size()), errors.size(), errors.front().get<double>(), errors.back().get<double>());
  return errors;
}

/// For everything. What the library allocates at a time grows with its budget, so not more than that.
constexpr std::uint64_t kEnoughBytes = 2ull << 30;

int run(const Options& options) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("stream_bench_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::vector<std::string> files = options.files;
  if (files.empty())
    files = options.bake_folder.empty() ? random_plants(folder, options.species, options.leaves)
                                        : baked_plants(options.bake_folder, options.species);
  RunResult all;
  {
    Run resident(options, {}, kEnoughBytes);
    resident.plant(files);
    resident.load_all();
    resident.fly();
    all = std::move(resident.result);
  }
  const std::uint64_t budget_bytes = options.budget_bytes != 0 ? options.budget_bytes : all.full_bytes / 20;
  print("everything resident", all);
  nlohmann::ordered_json json{{"device", test::vulkan_device().device_name},
                              {"species", options.species},
                              {"instances", options.instances},
                              {"frames", options.frames},
                              {"error_px", options.error_px},
                              {"all_bytes", all.full_bytes},
                              {"budget_bytes", budget_bytes},
                              {"resident", json_of(all)}};
  std::vector<Streaming> ways{{}};
  if (options.compare) {
    ways.push_back({.name = "read by the pool", .reading = Reading::thread_pool});
    ways.push_back({.name = "without prefetch", .prefetch_frames = 0.0f});
  }
  bool good = true;
  for (const Streaming& way : ways) {
    Run tight(options, way, budget_bytes);
    tight.plant(files);
    tight.fly();
    print(way.name, tight.result);
    good = judge(options, budget_bytes, all, tight.result) && good;
    json[way.name] = json_of(tight.result);
    json[way.name]["rmse"] = errors_of(all, tight.result);
  }
  std::filesystem::remove_all(folder);
  if (!options.json.empty()) {
    std::ofstream stream(options.json);
    stream << json.dump(2) << '\n';
    if (!stream.flush()) throw std::runtime_error("cannot write " + options.json);
  }
  const auto messages = test::validation_messages();
  for (const std::string& message : messages) std::printf("%s\n", message.c_str());
  return require(messages.empty(), "validation messages") && good ? 0 : 1;
}

}  // namespace

// What is thrown before the try block is CLI11's word that we use it wrongly.
// NOLINTNEXTLINE(bugprone-exception-escape)
int main(int argc, char** argv) {
  Options options;
  CLI::App app("A flight through a forest that does not fit the memory budget", "stream_bench");
  app.add_option("files", options.files, ".coppice files; default: random trees");
  app.add_option("--bake", options.bake_folder, "Bake built-in plants into this folder, where they are not there yet");
  app.add_option("--species", options.species)->check(CLI::Range(1u, 4096u))->capture_default_str();
  app.add_option("--leaves", options.leaves, "Of a random tree, about")->check(CLI::Range(100u, 1000000u))->capture_default_str();
  app.add_option("--instances", options.instances)->check(CLI::Range(1u, 1000000u))->capture_default_str();
  app.add_option("--frames", options.frames)->check(CLI::Range(4u, 1000000u))->capture_default_str();
  app.add_option("--width", options.width_px)->capture_default_str();
  app.add_option("--height", options.height_px)->capture_default_str();
  app.add_option("--budget", options.budget_bytes, "Bytes; default: a twentieth of what everything takes");
  app.add_option("--error-px", options.error_px)->capture_default_str();
  app.add_option("--speed", options.speed_m, "Metres a frame")->capture_default_str();
  app.add_option("--pictures", options.pictures, "Pictures compared with everything resident")->capture_default_str();
  app.add_option("--json", options.json, "Write the figures");
  app.add_flag("--raster", options.raster, "Small leaves by compute shaders");
  app.add_flag("--compare", options.compare, "Also read by the pool of threads, and without prefetch");
  app.add_flag("--validation", options.validation);
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "stream_bench: %s\n", error.what());
    return 1;
  }
}
