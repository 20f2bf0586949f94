#include "thread_pool.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>

namespace coppice {

namespace {

constexpr std::uint32_t kMaxThreads = 16;

struct Job {
  void (*function)(void* argument) = nullptr;
  void* argument = nullptr;
};

}  // namespace

// pthread_create instead of std::thread: the latter reports a missing resource by throwing, which here would end the process.
struct ThreadPool::State {
  std::mutex mutex;
  std::condition_variable changed;
  std::array<Job, kQueueLength> queue{};  ///< ring
  std::uint32_t first = 0, count = 0;
  bool stopping = false;
  std::array<pthread_t, kMaxThreads> threads{};
  std::uint32_t thread_count = 0;

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [this] { return count > 0 || stopping; });
      if (count == 0) return;
      const Job job = queue[first];
      first = (first + 1) % kQueueLength;
      --count;
      lock.unlock();
      job.function(job.argument);
      lock.lock();
    }
  }
};

ThreadPool::ThreadPool(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<ThreadPool>> ThreadPool::create(std::uint32_t thread_count) {
  if (thread_count == 0) {
    const std::uint32_t machine = std::thread::hardware_concurrency();
    thread_count = std::clamp(machine > 0 ? machine - 1 : 1u, 1u, 4u);
  }
  std::unique_ptr<State> state(new (std::nothrow) State);
  if (!state) return Error{Status::out_of_memory, "thread pool"};
  std::unique_ptr<ThreadPool> pool(new (std::nothrow) ThreadPool(std::move(state)));
  if (!pool) return Error{Status::out_of_memory, "thread pool"};
  State& shared = *pool->state_;
  int error = 0;
  while (shared.thread_count < std::min(thread_count, kMaxThreads)) {
    const auto entry = [](void* argument) -> void* {
      // Woken, it does not push the thread that submits off its core.
      const sched_param param{};
      pthread_setschedparam(pthread_self(), SCHED_BATCH, &param);
      static_cast<State*>(argument)->run();
      return nullptr;
    };
    error = pthread_create(&shared.threads[shared.thread_count], nullptr, entry, &shared);
    if (error != 0) break;
    ++shared.thread_count;
  }
  if (shared.thread_count == 0)
    return Error{Status::out_of_memory, "thread pool: no thread could be started", Error::kNoOffset,
                 std::generic_category().message(error) + "; allow more (ulimit -u), or set the jobs and io hooks"};
  return pool;
}

ThreadPool::~ThreadPool() {
  if (!state_) return;
  {
    const std::lock_guard lock(state_->mutex);
    state_->stopping = true;
  }
  state_->changed.notify_all();
  for (std::uint32_t i = 0; i < state_->thread_count; ++i) pthread_join(state_->threads[i], nullptr);
}

void ThreadPool::submit(void (*function)(void* argument), void* argument) {
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->count < kQueueLength) {
      state_->queue[(state_->first + state_->count++) % kQueueLength] = {function, argument};
      function = nullptr;
    }
  }
  if (function != nullptr)
    function(argument);
  else
    state_->changed.notify_one();
}

}  // namespace coppice
