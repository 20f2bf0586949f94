#pragma once

#include <cstddef>

namespace coppice::bake {

/// Runs the indices [first, last) of a loop. `body` is what the caller of run_parallel passed.
using RunIndices = void (*)(const void* body, std::size_t first, std::size_t last);

/// Passes every index of [0, count) to `run` once, in runs of at least `grain` where there are as many, on TBB's threads. Returns when all
/// are done.
void run_parallel(std::size_t count, std::size_t grain, RunIndices run, const void* body);

/// Calls body(i) for each i of [0, count), in no order and on any of TBB's threads; returns when all are done. Bodies must not share what
/// they write.
/// grain  minimum number of indices a task; more than 1 where a body is shorter than the cost of a task
template <class Index, class Body>
void parallel_for(Index count, const Body& body, std::size_t grain = 1) {
  const RunIndices run = [](const void* erased_body, std::size_t first, std::size_t last) {
    const Body& typed_body = *static_cast<const Body*>(erased_body);
    for (std::size_t i = first; i < last; ++i) typed_body(static_cast<Index>(i));
  };
  run_parallel(count, grain, run, &body);
}

}  // namespace coppice::bake
