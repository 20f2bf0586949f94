#include "thread_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "results.h"

namespace coppice::thread_pool_test {

TEST(ThreadPool, RunsEverythingBeforeItGoes) {
  std::atomic<int> ran = 0;
  {
    auto pool = test::must(ThreadPool::create(3));
    for (int i = 0; i < 100; ++i) pool->submit([](void* argument) { ++*static_cast<std::atomic<int>*>(argument); }, &ran);
  }
  EXPECT_EQ(ran, 100);
}

/// A job that says that it ran.
struct Step {
  std::vector<int>* order;
  int number;

  static void run(void* argument) {
    const auto* step = static_cast<Step*>(argument);
    step->order->push_back(step->number);
  }
};

TEST(ThreadPool, OneThreadKeepsTheOrder) {
  std::vector<int> order, expected(50);
  std::iota(expected.begin(), expected.end(), 0);
  std::vector<Step> steps;
  for (const int number : expected) steps.push_back({&order, number});
  {
    auto pool = test::must(ThreadPool::create(1));
    for (Step& step : steps) pool->submit(Step::run, &step);
  }
  EXPECT_EQ(order, expected);
}

TEST(ThreadPool, WhatMayTakeLongStartsWhenNothingElseWaits) {
  std::vector<int> order;
  std::mutex started;
  started.lock();
  Step steps[] = {{&order, 0}, {&order, 1}, {&order, 2}, {&order, 3}};
  {
    auto pool = test::must(ThreadPool::create(1));
    pool->submit([](void* argument) { std::lock_guard(*static_cast<std::mutex*>(argument)); }, &started);  // holds the thread
    pool->submit_long(Step::run, &steps[2]);
    pool->submit_long(Step::run, &steps[3]);
    pool->submit(Step::run, &steps[0]);
    pool->submit(Step::run, &steps[1]);
    started.unlock();
  }
  EXPECT_EQ(order, (std::vector{0, 1, 2, 3}));
}

struct Gate {
  std::mutex mutex;
  std::condition_variable changed;
  bool open = false;
  std::atomic<int> ran = 0;
  std::atomic<int> ran_inline = 0;
  std::thread::id submitter = std::this_thread::get_id();

  void release() {
    const std::lock_guard lock(mutex);
    open = true;
    changed.notify_all();
  }
  static void wait(void* argument) {
    auto* gate = static_cast<Gate*>(argument);
    std::unique_lock lock(gate->mutex);
    gate->changed.wait(lock, [gate] { return gate->open; });
  }
  static void count(void* argument) {
    auto* gate = static_cast<Gate*>(argument);
    ++gate->ran;
    if (std::this_thread::get_id() == gate->submitter) ++gate->ran_inline;
  }
};

TEST(ThreadPool, RunsInlineWhatNoLongerFitsTheQueue) {
  Gate gate;
  {
    auto pool = test::must(ThreadPool::create(1));
    pool->submit(Gate::wait, &gate);
    for (std::uint32_t i = 0; i < ThreadPool::kQueueLength + 10; ++i) pool->submit(Gate::count, &gate);
    EXPECT_GE(gate.ran_inline, 10);
    EXPECT_LE(gate.ran_inline, 11);  // the gate itself may still be queued
    gate.release();
  }
  EXPECT_EQ(gate.ran, static_cast<int>(ThreadPool::kQueueLength + 10));
}

}  // namespace coppice::thread_pool_test
