#include "completion_queue.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace coppice {
namespace completion_queue_test {

struct Item {
  int id = 0;
  Item* next = nullptr;
};

TEST(CompletionQueue, GivesBackInOrderOfCompletion) {
  std::array<Item, 3> items{{{1}, {2}, {3}}};
  CompletionQueue<Item> queue;
  EXPECT_TRUE(queue.all_back());
  EXPECT_EQ(queue.take(), nullptr);
  queue.expect(3);
  queue.push(&items[2]);
  queue.push(&items[0]);
  EXPECT_FALSE(queue.all_back());
  EXPECT_EQ(queue.take(), &items[2]);
  queue.push(&items[1]);
  EXPECT_TRUE(queue.all_back());
  EXPECT_EQ(queue.take(), &items[0]);
  EXPECT_EQ(queue.take(), &items[1]);
  EXPECT_EQ(queue.take(), nullptr);
  queue.expect();
  queue.push(&items[1]);
  EXPECT_EQ(queue.take(), &items[1]) << "one that comes again";
}

/// A waiter may destroy the queue as soon as everything is back (thread sanitizer).
TEST(CompletionQueue, WaitsForAll) {
  for (int round = 0; round < 200; ++round) {
    std::array<Item, 4> items{};
    std::array<std::thread, 4> threads;
    {
      CompletionQueue<Item> queue;
      queue.expect(4);
      for (std::size_t i = 0; i < 4; ++i) threads[i] = std::thread([&queue, &item = items[i]] { queue.push(&item); });
      queue.wait_for_all();
      for (int i = 0; i < 4; ++i) EXPECT_NE(queue.take(), nullptr);
    }
    for (std::thread& thread : threads) thread.join();
  }
}

}  // namespace completion_queue_test
}  // namespace coppice
