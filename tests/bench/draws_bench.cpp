// coppice_get_draws of one view, on one core: a forest that the view sees all of, and one that stands around the eye; and coppice_pick in
// the latter. What comes out is checked: a fast wrong answer fails.

#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "coppice/coppice.h"
#include "places.h"

namespace {

constexpr std::uint32_t kInstances = 100'000;

template <class T>
T defaults(void (*init)(T*)) {
  T value;
  init(&value);
  return value;
}

struct Forest {
  coppice_context* context = nullptr;
  coppice_view view = 0;
};

/// Frames until all that the view wants is there.
bool settle(const Forest& forest, const coppice_camera& camera) {
  std::uint32_t settled = 0;
  for (std::uint64_t number = 1; number < 100'000 && settled == COPPICE_FALSE; ++number) {
    auto frame = defaults(coppice_frame_init);
    frame.frame_number = number;
    frame.completed_number = number - 1;
    frame.cameras = &camera;
    frame.camera_count = 1;
    if (coppice_frame_begin(forest.context, &frame) != COPPICE_OK) return false;
    auto change = defaults(coppice_change_init);
    while (coppice_next_change(forest.context, &change) == COPPICE_OK && change.kind != COPPICE_CHANGE_NONE)
      if (change.kind == COPPICE_CHANGE_CHUNK_ADDED) coppice_confirm(forest.context, &change, COPPICE_OUTCOME_TAKEN);
    coppice_is_settled(forest.context, forest.view, &settled);
  }
  return settled == COPPICE_TRUE;
}

coppice_camera camera_of(coppice_view view) {
  auto camera = defaults(coppice_camera_init);
  camera.view = view;
  camera.width_px = 1920;
  camera.height_px = 1080;
  camera.clip_from_view[0] = 1.0f;
  camera.clip_from_view[5] = -16.0f / 9.0f;
  camera.clip_from_view[10] = camera.clip_from_view[15] = 0.0f;
  camera.clip_from_view[11] = -1.0f;
  camera.clip_from_view[14] = 0.1f;
  return camera;
}

/// Rows of a wedge, all in front of the eye, or of a square around it; a hundred neighbours are added together.
std::vector<coppice_placement> placements(bool all_in_view) {
  std::vector<coppice_placement> placed;
  for (std::uint32_t i = 0; i < kInstances; ++i) {
    const auto block = static_cast<float>(i / 100), inside = static_cast<float>(i % 100);
    const float across = std::fmod(block, 32.0f) - 15.5f, along = std::floor(block / 32.0f);
    auto placement = defaults(coppice_placement_init);
    placement.position[0] = 30.0f * across + 3.0f * std::fmod(inside, 10.0f);
    placement.position[2] = 30.0f * (15.5f - along) + 3.0f * std::floor(inside / 10.0f) - (all_in_view ? 1100.0f : 0.0f);
    placed.push_back(placement);
  }
  return placed;
}

/// False: `state` has the error. forest.context: to be destroyed
bool open(benchmark::State& state, bool all_in_view, Forest& forest) {
  const auto desc = defaults(coppice_context_desc_init);
  const auto view_desc = defaults(coppice_view_desc_init);
  coppice_plant plant = 0;
  const std::vector<coppice_placement> placed = placements(all_in_view);
  if (coppice_context_create(&desc, &forest.context) != COPPICE_OK ||
      coppice_view_create(forest.context, &view_desc, &forest.view) != COPPICE_OK ||
      coppice_plant_open(forest.context, (std::string(coppice::test::kTestData) + "/plants/two_pages.coppice").c_str(), &plant) !=
          COPPICE_OK ||
      coppice_instances_add(forest.context, plant, placed.data(), sizeof(coppice_placement), kInstances, nullptr) != COPPICE_OK) {
    state.SkipWithError(coppice_last_error(forest.context));
    return false;
  }
  if (settle(forest, camera_of(forest.view))) return true;
  state.SkipWithError("does not settle");
  return false;
}

void get_draws(benchmark::State& state) {
  Forest forest;
  if (!open(state, state.range(0) != 0, forest)) return;
  std::vector<coppice_draw> draws(kInstances);
  std::uint32_t count = 0;
  for (auto _ : state) {
    coppice_get_draws(forest.context, forest.view, draws.data(), kInstances, sizeof(coppice_draw), &count);
    benchmark::DoNotOptimize(draws.data());
    benchmark::ClobberMemory();
  }
  double leaves = 0;
  for (std::uint32_t i = 0; i < count; ++i) leaves += static_cast<double>(draws[i].leaf_count);
  const bool right = state.range(0) != 0 ? count == kInstances : count > kInstances / 8 && count < kInstances / 2;
  if (!right || leaves < count) state.SkipWithError("the draws are not those expected");
  state.counters["draws"] = count;
  state.counters["leaves"] = leaves;
  coppice_context_destroy(forest.context);
}
BENCHMARK(get_draws)->ArgName("all_in_view")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

/// From the middle of the forest all round, level with the crowns: what is nearest is a few plants away.
void pick(benchmark::State& state) {
  Forest forest;
  if (!open(state, false, forest)) return;
  auto ray = defaults(coppice_ray_init);
  ray.boxes = state.range(0) != 0 ? COPPICE_TRUE : COPPICE_FALSE;
  ray.origin[0] = 1.5;
  ray.origin[1] = 0.5;
  auto hit = defaults(coppice_hit_init);
  std::uint64_t rays = 0, hits = 0;
  for (auto _ : state) {
    const auto turn = 2.4f * static_cast<float>(rays++);
    ray.direction[0] = std::cos(turn);
    ray.direction[2] = std::sin(turn);
    coppice_pick(forest.context, &ray, &hit);
    hits += hit.kind != COPPICE_HIT_NOTHING;
    benchmark::DoNotOptimize(hit);
  }
  if (2 * hits < rays && rays > 100) state.SkipWithError("few rays hit anything");
  state.counters["hits"] = static_cast<double>(hits) / static_cast<double>(rays);
  coppice_context_destroy(forest.context);
}
BENCHMARK(pick)->ArgName("boxes")->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

}  // namespace
