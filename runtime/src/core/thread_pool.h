#pragma once

#include <cstdint>
#include <memory>

#include "result.h"

namespace coppice {

/// A few threads that run submitted functions in order, long ones after all others: the default behind the jobs and io hooks.
class ThreadPool {
 public:
  /// thread_count  0: one fewer than the processor's threads, at least 1, at most 4, so that the engine keeps its cores
  /// errors  out_of_memory: no thread can be started, with the system's reason
  static Result<std::unique_ptr<ThreadPool>> create(std::uint32_t thread_count);

  /// Runs all queued functions, then joins.
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// Submits a function without waiting. If kQueueLength functions are queued already, it runs the function inline. Any thread.
  void submit(void (*function)(void* argument), void* argument);
  /// Submits a function that may take long: it starts when no other waits.
  void submit_long(void (*function)(void* argument), void* argument);

  static constexpr std::uint32_t kQueueLength = 256;

 private:
  struct State;
  void enqueue(bool long_one, void (*function)(void* argument), void* argument);
  explicit ThreadPool(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace coppice
