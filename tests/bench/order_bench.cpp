// 100,000 instances of three plants, added in the order of a Morton curve and in random order: CPU time of coppice_instances_add, and of
// coppice_frame_begin with three views before, while and after the library has sorted them. Both contexts take turns in one run, so their
// ratio says more than their times. What is drawn is checked: a fast wrong answer fails, and so does an order that is never mended.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "coppice/coppice.h"
#include "places.h"

namespace {

constexpr std::uint32_t kInstances = 100'000, kPlants = 3, kViews = 3;
constexpr int kSide_m = 2000;
/// More frames than sorting takes, then those that are measured.
constexpr int kSortFrames = 600, kFrames = 200;

template <class T>
T defaults(void (*init)(T*)) {
  T value;
  init(&value);
  return value;
}

using Clock = std::chrono::steady_clock;
double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}
double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// Whole metres, so that both orders have the same places.
struct Place {
  std::uint32_t x = 0, z = 0;
  std::uint32_t plant = 0;
};

std::uint64_t morton(const Place& place) {
  std::uint64_t code = 0;
  for (std::uint32_t bit = 0; bit < 16; ++bit) {
    code |= std::uint64_t{place.x >> bit & 1u} << (2 * bit + 1);
    code |= std::uint64_t{place.z >> bit & 1u} << 2 * bit;
  }
  return code;
}

class Forest {
 public:
  /// places: in the order in which they are added, a hundred of one plant at a time
  explicit Forest(const std::vector<Place>& places) {
    const auto desc = defaults(coppice_context_desc_init);
    check(coppice_context_create(&desc, &context_));
    for (coppice_plant& plant : plants_)
      check(coppice_plant_open(context_, (std::string(coppice::test::kTestData) + "/plants/two_pages.coppice").c_str(), &plant));
    for (std::size_t i = 0; i < kViews; ++i) {
      auto of = defaults(coppice_view_desc_init);
      if (i == 2) of.output = COPPICE_OUTPUT_DEPTH;
      coppice_view view = 0;
      check(coppice_view_create(context_, &of, &view));
      cameras_[i] = looking(view, i == 1);
    }
    std::array<std::vector<coppice_placement>, kPlants> of_plant;
    const auto add = [&](std::size_t plant) {
      const auto start = Clock::now();
      check(coppice_instances_add(context_, plants_[plant], of_plant[plant].data(), sizeof(coppice_placement),
                                  static_cast<std::uint32_t>(of_plant[plant].size()), nullptr));
      add_ms += ms_since(start);
      of_plant[plant].clear();
    };
    for (const Place& place : places) {
      auto placement = defaults(coppice_placement_init);
      placement.position[0] = static_cast<double>(place.x) - kSide_m / 2;
      placement.position[2] = static_cast<double>(place.z) - kSide_m / 2;
      of_plant[place.plant].push_back(placement);
      if (of_plant[place.plant].size() == 100) add(place.plant);
    }
    for (std::size_t plant = 0; plant < kPlants; ++plant) add(plant);
  }
  ~Forest() { coppice_context_destroy(context_); }
  Forest(const Forest&) = delete;
  Forest& operator=(const Forest&) = delete;

  /// Returns the time of coppice_frame_begin, ms.
  double frame() {
    auto frame = defaults(coppice_frame_init);
    frame.frame_number = ++number_;
    frame.completed_number = number_ - 1;
    frame.cameras = cameras_.data();
    frame.camera_count = kViews;
    const auto start = Clock::now();
    check(coppice_frame_begin(context_, &frame));
    const double ms = ms_since(start);
    auto change = defaults(coppice_change_init);
    while (coppice_next_change(context_, &change) == COPPICE_OK && change.kind != COPPICE_CHANGE_NONE)
      if (change.kind == COPPICE_CHANGE_CHUNK_ADDED) coppice_confirm(context_, &change, COPPICE_OUTCOME_TAKEN);
    return ms;
  }
  /// Number of instances that a view shows, and of their leaves.
  std::array<double, 2> shown() {
    std::vector<coppice_draw> draws(kInstances);
    std::uint32_t count = 0;
    check(coppice_get_draws(context_, cameras_[0].view, draws.data(), kInstances, sizeof(coppice_draw), &count));
    double leaves = 0;
    for (std::uint32_t i = 0; i < count; ++i) leaves += static_cast<double>(draws[i].leaf_count);
    return {static_cast<double>(count), leaves};
  }

  double add_ms = 0;
  std::string error;

 private:
  void check(coppice_status status) {
    if (status != COPPICE_OK && error.empty()) error = coppice_last_error(context_);
  }
  static coppice_camera looking(coppice_view view, bool back) {
    auto camera = defaults(coppice_camera_init);
    camera.view = view;
    camera.width_px = 1920;
    camera.height_px = 1080;
    if (back) camera.view_from_world[0] = camera.view_from_world[10] = -1.0;
    camera.view_from_world[13] = -2.0;
    camera.clip_from_view[5] = -16.0f / 9.0f;
    camera.clip_from_view[10] = camera.clip_from_view[15] = 0.0f;
    camera.clip_from_view[11] = -1.0f;
    camera.clip_from_view[14] = 0.1f;
    return camera;
  }

  coppice_context* context_ = nullptr;
  std::array<coppice_plant, kPlants> plants_{};
  std::array<coppice_camera, kViews> cameras_{};
  std::uint64_t number_ = 0;
};

void frame_begin(benchmark::State& state) {
  std::mt19937 random(1);
  std::vector<Place> places(kInstances);
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] = {static_cast<std::uint32_t>(random() % kSide_m), static_cast<std::uint32_t>(random() % kSide_m),
                 static_cast<std::uint32_t>(i % kPlants)};
  Forest shuffled(places);
  std::ranges::sort(places, {}, morton);
  Forest ordered(places);
  std::vector<double> unsorted_ms, sorting_ms, shuffled_ms, ordered_ms;
  unsorted_ms.push_back(shuffled.frame());
  ordered.frame();
  for (int i = 0; i < kSortFrames; ++i) {
    sorting_ms.push_back(shuffled.frame());
    ordered.frame();
  }
  for (auto _ : state)
    for (int i = 0; i < kFrames; ++i) {
      shuffled_ms.push_back(shuffled.frame());
      ordered_ms.push_back(ordered.frame());
    }
  const auto shown = shuffled.shown(), expected = ordered.shown();
  if (!shuffled.error.empty() || !ordered.error.empty()) state.SkipWithError((shuffled.error + ordered.error).c_str());
  // An instance's threshold follows from its handle, so single instances have other cuts.
  if (shown[0] != expected[0] || std::abs(shown[1] / expected[1] - 1.0) > 0.02 || shown[0] < kInstances / 8 || shown[0] > kInstances / 2)
    state.SkipWithError("the draws differ");
  const double ratio = median(shuffled_ms) / median(ordered_ms);
  if (ratio > 1.5) state.SkipWithError("the order of adding still matters");
  state.counters["add_us"] = 1e3 * shuffled.add_ms / kInstances;
  state.counters["unsorted_ms"] = unsorted_ms[0];
  state.counters["sorting_max_ms"] = std::ranges::max(sorting_ms);
  state.counters["random_ms"] = median(shuffled_ms);
  state.counters["morton_ms"] = median(ordered_ms);
  state.counters["ratio"] = ratio;
}
BENCHMARK(frame_begin)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
