// Speed of the baker's inner stages on fixed plants. Every benchmark also checks a hash of what it computed, so that a fast wrong answer
// fails. A change of a hash below is a change of every baked file: explain it where it is made.

#include <benchmark/benchmark.h>
#include <xxhash.h>

#include "collapse_image.h"
#include "collapse_information.h"
#include "test_foliage.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

template <class T>
std::uint64_t hash_of(const std::vector<T>& values) {
  return XXH3_64bits(values.data(), values.size() * sizeof(T));
}

std::uint64_t hash_of(const CollapseSequence& sequence) {
  std::vector<std::uint32_t> words;
  for (const Merge& merge : sequence.merges) {
    words.insert(words.end(), {merge.first, merge.second});
    words.insert(words.end(), merge.corners.begin(), merge.corners.end());
  }
  return hash_of(words);
}

void check(benchmark::State& state, std::uint64_t hash, std::uint64_t expected) {
  if (hash == expected) return;
  const std::string message = "hash is " + std::to_string(hash) + ", expected " + std::to_string(expected);
  state.SkipWithError(message.c_str());
}

void item_buffers(benchmark::State& state) {
  const Foliage foliage = test::ball_crown(4456, 1);
  const std::vector<Viewpoint> views = *viewpoints(20);
  std::uint64_t hash = 0, fragment_count = 0;
  for ([[maybe_unused]] auto _ : state) {
    const auto buffers = render_item_buffers({foliage, test::plain_materials(), {}}, views, 256);
    fragment_count += buffers->fragments.size();
    hash = hash_of(buffers->fragments);
  }
  state.counters["fragments/s"] = benchmark::Counter(static_cast<double>(fragment_count), benchmark::Counter::kIsRate);
  check(state, hash, 1222557222082167546u);
}

void report_collapse(benchmark::State& state, const Result<CollapseResult>& result, std::uint64_t expected) {
  state.counters["evaluations/s"] =
      benchmark::Counter(static_cast<double>(result->sequence.evaluations), benchmark::Counter::kIsIterationInvariantRate);
  check(state, hash_of(result->sequence), expected);
}

void collapse(benchmark::State& state, bool count_background, std::uint64_t expected) {
  const Foliage foliage = test::ball_crown(1000, 1);
  const std::vector<Viewpoint> views = *viewpoints(20);
  CollapseOptions options;
  options.count_background = count_background;
  Result<CollapseResult> result = CollapseResult{};
  for ([[maybe_unused]] auto _ : state) result = collapse_by_mutual_information({foliage, test::plain_materials(), {}}, views, options, {});
  report_collapse(state, result, expected);
}

void collapse_image(benchmark::State& state) {
  const Foliage foliage = test::ball_crown(1000, 1);
  const std::vector<Viewpoint> views = *viewpoints(42);
  Result<CollapseResult> result = CollapseResult{};
  for ([[maybe_unused]] auto _ : state)
    result = collapse_by_image_error({foliage, test::plain_materials(), {}}, views, CollapseOptions{}, ImageErrorOptions{}, {});
  report_collapse(state, result, 3231043444549449110u);
}

BENCHMARK(item_buffers)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(collapse, background_counted, true, 3633819191876885765u)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(collapse, background_not_counted, false, 16291344070961098314u)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(collapse_image)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace coppice::bake
