// Only this file calls tbb::parallel_for, and only this file is compiled without ThreadSanitizer where the rest has it. Distributions build
// TBB without the sanitizer. It therefore sees neither that a loop starts after what its caller did before, nor that it ends before what
// its caller does next, and would report both as data races; it would report what TBB's headers do between threads, too. The annotations
// here tell the sanitizer both orders. They say nothing about two bodies of one loop, so it still finds a race between those.
#include "parallel_for.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#ifdef COPPICE_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace coppice::bake {
namespace {

#ifdef COPPICE_THREAD_SANITIZER
void release(void* address) {
  __tsan_release(address);
}
void acquire(void* address) {
  __tsan_acquire(address);
}
#else
void release(void*) {}
void acquire(void*) {}
#endif

}  // namespace

void run_parallel(std::size_t count, std::size_t grain, RunIndices run, const void* body) {
  using Range = tbb::blocked_range<std::size_t>;
  char forked = 0, joined = 0;  // two variables: with one, what a body did would seem to come before the next body that starts
  release(&forked);
  tbb::parallel_for(Range(0, count, grain), [&forked, &joined, run, body](const Range& range) {
    acquire(&forked);
    run(body, range.begin(), range.end());
    release(&joined);
  });
  acquire(&joined);
}

}  // namespace coppice::bake
