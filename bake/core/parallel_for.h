#pragma once

#include <cstddef>

namespace coppice::bake {

/// Some of a loop's indices, [first, last), with what its caller keeps in `body`.
using RunIndices = void (*)(const void* body, std::size_t first, std::size_t last);

/// Every index of [0, count) once, in runs of at least `grain` where there are as many, on TBB's threads; back when all are done.
void run_parallel(std::size_t count, std::size_t grain, RunIndices run, const void* body);

/// body(i) for each i of [0, count), in no order and on any of TBB's threads; back when all are done. Bodies share nothing they write.
/// `grain`: how many indices a task takes at least; more than 1 where a body is shorter than the cost of a task.
template <class Index, class Body>
void parallel_for(Index count, const Body& body, std::size_t grain = 1) {
  const RunIndices run = [](const void* erased_body, std::size_t first, std::size_t last) {
    const Body& typed_body = *static_cast<const Body*>(erased_body);
    for (std::size_t i = first; i < last; ++i) typed_body(static_cast<Index>(i));
  };
  run_parallel(count, grain, run, &body);
}

}  // namespace coppice::bake
