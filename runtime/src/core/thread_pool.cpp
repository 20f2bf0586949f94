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

/// A queue in order of submission.
struct JobQueue {
  std::array<Job, ThreadPool::kQueueLength> ring{};
  std::uint32_t first = 0, count = 0;

  /// False if it is full.
  bool push(const Job& job) {
    if (count == ring.size()) return false;
    ring[(first + count++) % ring.size()] = job;
    return true;
  }
  Job pop() {
    const Job job = ring[first];
    first = static_cast<std::uint32_t>((first + 1) % ring.size());
    --count;
    return job;
  }
};

}  // namespace

// pthread_create instead of std::thread: the latter throws if a resource is missing, which would end the process here.
struct ThreadPool::State {
  std::mutex mutex;
  std::condition_variable changed;
  JobQueue short_jobs, long_jobs;
  bool stopping = false;
  std::array<pthread_t, kMaxThreads> threads{};
  std::uint32_t thread_count = 0;

  void run() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [this] { return short_jobs.count + long_jobs.count > 0 || stopping; });
      if (short_jobs.count + long_jobs.count == 0) return;
      const Job job = (short_jobs.count > 0 ? short_jobs : long_jobs).pop();
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
      // With this policy a woken thread does not preempt the thread that submits.
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
  enqueue(false, function, argument);
}

void ThreadPool::submit_long(void (*function)(void* argument), void* argument) {
  enqueue(true, function, argument);
}

void ThreadPool::enqueue(bool long_one, void (*function)(void* argument), void* argument) {
  bool queued = false;
  {
    const std::lock_guard lock(state_->mutex);
    queued = (long_one ? state_->long_jobs : state_->short_jobs).push({function, argument});
  }
  if (queued)
    state_->changed.notify_one();
  else
    function(argument);
}

}  // namespace coppice
