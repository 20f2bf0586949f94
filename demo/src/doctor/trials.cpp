#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <vector>

#include <glm/gtc/constants.hpp>

#include "failure.h"
#include "machine.h"
#include "stage.h"
#include "trial.h"

namespace forest {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void say(const std::string& line) {
  std::printf("say %s\n", line.c_str());
  std::fflush(stdout);
}

struct Outcome {
  bool right = false;
  bool software = false;  ///< a processor does the GPU's work
  double ready_ms = 0;    ///< until the first right frame: device, pipelines and streaming
  double frame_ms = 0;    ///< median of frames then; 0: none
  std::string note;
};

/// The parent ends a trial that takes too long, and does not want it to give up by itself before.
constexpr float kPatience_s = 1e6f;

void describe_machine(VkPhysicalDevice physical) {
  say(describe(physical));
  for (const Need& need : needs_of(physical)) {
    const char* state = need.there ? "yes" : need.needed ? "MISSING" : "no";
    say(std::string("  ") + (need.needed ? "needed  " : "wanted  ") + need.name + ": " + state +
        (need.there ? "" : std::string(": ") + need.without));
  }
}

/// chosen  hears of the device before anything is asked of it; may be null
Device make_device(void (*chosen)(VkPhysicalDevice)) {
  at("making the device");
  DeviceOptions options;
  options.patience_s = kPatience_s;
  options.chosen = chosen;
  return Device(options);
}

// ---- what is looked at ----

coppice_placement standing_at(float x, float z, float turn_rad) {
  coppice_placement placement;
  coppice_placement_init(&placement);
  placement.position[0] = double{x};
  placement.position[2] = double{z};
  placement.rotation[1] = std::sin(0.5f * turn_rad);
  placement.rotation[3] = std::cos(0.5f * turn_rad);
  return placement;
}

/// Looks along -z from where a person's eyes are. The picture is as high as its distance.
coppice_camera camera_with(float error_px) {
  constexpr float kEye_m = 1.7f, kFocal = 2;
  coppice_camera camera;
  coppice_camera_init(&camera);
  camera.view_from_world[13] = double{-kEye_m};
  std::fill(std::begin(camera.clip_from_view), std::end(camera.clip_from_view), 0.0f);
  camera.clip_from_view[0] = kFocal;
  camera.clip_from_view[5] = -kFocal;  // y down in the picture
  camera.clip_from_view[11] = -1;
  camera.clip_from_view[14] = kNear_m;
  camera.width_px = camera.height_px = kPictureSide_px;
  camera.error_px = error_px;
  return camera;
}

/// One that fills the picture, in leaves of some pixels.
Stand near_stand() {
  return {{standing_at(0, -5, 0.3f)}, camera_with(25)};
}

/// Rows of six, whose leaves are a pixel or less.
Stand far_stand() {
  Stand stand{{}, camera_with(2)};
  for (int i = 0; i < 36; ++i)
    stand.plants.push_back(
        standing_at(-15 + 6.0f * static_cast<float>(i % 6), -40 - 6.0f * static_cast<float>(i / 6), static_cast<float>(i)));
  return stand;
}

/// From 5 m, as it was modelled, to 80 m.
Stand deep_stand() {
  return {{standing_at(-0.9f, -6, 0), standing_at(2, -10, 1), standing_at(-4, -20, 2), standing_at(6, -40, 3), standing_at(-4, -80, 4)},
          camera_with(2)};
}

/// All round the eye: a fourth is in view.
Stand ring_stand() {
  Stand stand{{}, camera_with(2)};
  for (int i = 0; i < 36; ++i) {
    const float angle = (static_cast<float>(i) + 0.5f) / 36 * glm::two_pi<float>(), radius_m = 8 + 4 * static_cast<float>(i % 5);
    stand.plants.push_back(standing_at(radius_m * std::sin(angle), -radius_m * std::cos(angle), angle));
  }
  return stand;
}

// ---- trials ----

std::string percent(float share) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f %%", 100 * static_cast<double>(share));
  return text.data();
}

/// What the library said of what it goes on without.
std::string warnings_of(Stage& stage) {
  const std::lock_guard lock(stage.notes.mutex);
  if (!stage.notes.errors.empty()) throw Failure(stage.notes.errors.front());
  return stage.notes.warnings.empty() ? "" : "; " + stage.notes.warnings.front();
}

double median_frame_ms(Stage& stage, Until until) {
  std::array<double, 5> times{};
  for (double& ms : times) {
    const auto start = Clock::now();
    draw_frame(stage, until);
    ms = ms_since(start);
  }
  std::ranges::sort(times);
  return times[times.size() / 2];
}

Outcome try_device() {
  const auto start = Clock::now();
  const Device device = make_device(describe_machine);
  at("copying to the GPU and back");
  std::vector<std::byte> sent(1 << 20);
  for (std::size_t i = 0; i < sent.size(); ++i) sent[i] = static_cast<std::byte>(i * 2654435761u >> 13);
  const Buffer there = create_device_buffer(device, sent, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  const Buffer back = create_host_buffer(device, sent.size(), VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  submit_and_wait(device, [&](VkCommandBuffer commands) {
    const VkBufferCopy region{0, 0, sent.size()};
    vkCmdCopyBuffer(commands, there.buffer, back.buffer, 1, &region);
    record_to_host(commands);
  });
  const bool right = std::equal(sent.begin(), sent.end(), back.mapped);
  return {right, device.software, ms_since(start), 0, right ? "" : "what came back is not what was sent"};
}

Outcome try_uploads() {
  const auto start = Clock::now();
  const Device device = make_device(nullptr);
  Stage stage(device, deep_stand(), {});
  draw_until_settled(stage, Until::uploaded);
  const double ready_ms = ms_since(start);
  coppice_stats stats;
  coppice_stats_init(&stats);
  check(stage.context.get(), coppice_get_stats(stage.context.get(), &stats), "coppice_get_stats");
  const auto& all = stats.streamed[COPPICE_STREAMED_ALL];
  return {all.loaded > 0 && all.wanted == 0 && all.failed == 0, device.software, ready_ms, median_frame_ms(stage, Until::uploaded),
          std::to_string(all.loaded) + " chunks" + warnings_of(stage)};
}

Outcome try_selection() {
  const auto start = Clock::now();
  const Stand stand = ring_stand();
  const Device device = make_device(nullptr);
  Stage stage(device, stand, {});
  draw_until_settled(stage, Until::culled);
  const double ready_ms = ms_since(start), frame_ms = median_frame_ms(stage, Until::culled);
  coppice_view_stats stats;
  coppice_view_stats_init(&stats);
  check(stage.context.get(), coppice_get_view_stats(stage.context.get(), stage.camera.view, &stats), "coppice_get_view_stats");
  at("selecting on the processor");
  const Reference reference = draw_on_processor(stand);
  const auto leaves = static_cast<double>(stats.drawn_leaf_count);
  // Sums of floats may round a leaf up or down.
  const bool right = stats.visible_instance_count == reference.instances && std::abs(leaves - reference.leaves) <= 0.01 * reference.leaves;
  std::array<char, 160> note{};
  std::snprintf(note.data(), note.size(), "%u plants in view, %.0f leaves; the processor's: %u, %.0f", stats.visible_instance_count, leaves,
                reference.instances, reference.leaves);
  return {right, device.software, ready_ms, frame_ms, note.data() + warnings_of(stage)};
}

/// Share of what is covered that has no colour.
float black_share(const Picture& picture) {
  std::size_t covered = 0, black = 0;
  for (std::size_t i = 0; i < picture.depth.size(); ++i) {
    covered += picture.depth[i] > 0;
    black += picture.depth[i] > 0 && picture.color[i] == glm::vec3(0);
  }
  return covered > 0 ? static_cast<float>(black) / static_cast<float>(covered) : 1;
}

/// What the pictures of right drivers stay well below: textures are filtered, and single pixels of coarse leaves left out, in ways of their
/// own.
constexpr Difference kMost{.coverage = 0.1f, .depth = 0.04f, .color = 0.02f};
constexpr float kMaxBlack = 0.02f;

Outcome try_picture(const Stand& stand, const StageDesc& desc) {
  const auto start = Clock::now();
  const Device device = make_device(nullptr);
  Stage stage(device, stand, desc);
  draw_until_settled(stage, Until::drawn);
  const double ready_ms = ms_since(start), frame_ms = median_frame_ms(stage, Until::drawn);
  at("copying the picture from the GPU");
  const Picture picture = read_picture(stage);
  at("drawing on the processor");
  const Reference reference = draw_on_processor(stand);
  const Difference difference = difference_of(picture, reference.picture);
  const float black = stage.colors.empty() ? 0 : black_share(picture);
  std::string note = "differs by " + percent(difference.coverage) + " of coverage, " + percent(difference.depth) + " of depth";
  bool right = difference.coverage < kMost.coverage && difference.depth < kMost.depth && black < kMaxBlack;
  if (desc.output == COPPICE_OUTPUT_SURFACE) {
    note += ", " + percent(difference.color) + " of colour";
    right = right && difference.color < kMost.color;
  }
  if (black > 0) note += "; " + percent(black) + " black";
  return {right, device.software, ready_ms, frame_ms, note + warnings_of(stage)};
}

Outcome try_one(std::string_view name) {
  if (name == "device") return try_device();
  if (name == "uploads") return try_uploads();
  if (name == "selection") return try_selection();
  if (name == "hardware") return try_picture(deep_stand(), {});
  if (name == "leaves") return try_picture(near_stand(), {.compute = true});
  if (name == "splats") return try_picture(far_stand(), {.compute = true});
  if (name == "surfaces") return try_picture(deep_stand(), {.output = COPPICE_OUTPUT_SURFACE, .compute = true});
  if (name == "shadow_map") return try_picture(deep_stand(), {.output = COPPICE_OUTPUT_DEPTH, .compute = true});
  throw Failure("no trial " + std::string(name));
}

}  // namespace

void at(const std::string& step) {
  std::printf("at %s\n", step.c_str());
  std::fflush(stdout);
}

void run_trial(const std::string& name, double limit_s) {
  constexpr double kLonger_s = 5;
  ::alarm(static_cast<unsigned>(limit_s + kLonger_s));
  const Outcome outcome = try_one(name);
  const bool slow = is_slow(outcome.ready_ms, outcome.frame_ms, outcome.software);
  std::printf("result %s %.3f %.3f %s\n",
              !outcome.right ? "wrong"
              : slow         ? "slow"
                             : "ok",
              outcome.ready_ms, outcome.frame_ms, outcome.note.c_str());
}

}  // namespace forest
