// Small parts of the core: the completion queue, handles, the ledger, names for a terminal.

#include <array>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "completion_queue.h"
#include "handle.h"
#include "ledger.h"
#include "printable.h"

namespace coppice::core_test {

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

TEST(Handle, SaysWhatItWasMadeOf) {
  const Handle handle{HandleKind::instance, 4095, (1u << 21) - 1, kMaxHandleIndex};
  EXPECT_EQ(unpack_handle(pack_handle(handle)), handle);
  EXPECT_EQ(pack_handle({HandleKind::plant, 1, 0, 0}), 0x2002000000000000u) << "the layout that coppice.h describes";
  EXPECT_NE(pack_handle({HandleKind::plant, 0, 0, 0}), 0u);
}

TEST(Handle, AnyBitsAreAHandleAndBack) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t bits = random();
    EXPECT_EQ(pack_handle(unpack_handle(bits)), bits);
  }
}

TEST(Handle, WhatDoesNotFitWrapsAndTouchesNothingElse) {
  const Handle wrapped = unpack_handle(pack_handle({HandleKind::plant, 4097, (1u << 21) + 5, 3}));
  EXPECT_EQ(wrapped, (Handle{HandleKind::plant, 1, 5, 3}));
}

TEST(Ledger, GrantsWhatIsFreeAndNoMore) {
  Ledger ledger(100);
  EXPECT_TRUE(ledger.fits(100));
  ledger.reserve(60);
  EXPECT_EQ(ledger.free(), 40u);
  EXPECT_TRUE(ledger.fits(40));
  EXPECT_FALSE(ledger.fits(41));
  ledger.release(10);
  EXPECT_TRUE(ledger.fits(50));
  EXPECT_EQ(ledger.reserved(), 50u);
  EXPECT_EQ(ledger.max_reserved(), 60u);
  ledger.set_budget(40);  // leaves what is taken
  EXPECT_EQ(ledger.free(), 0u);
  EXPECT_EQ(ledger.reserved(), 50u);
  EXPECT_FALSE(ledger.fits(1));
  EXPECT_TRUE(ledger.fits(0));
}

TEST(Ledger, WantsTheMostThatItRefusedUntilThatIsGranted) {
  Ledger ledger(100);
  ledger.reserve(90);
  EXPECT_FALSE(ledger.fits(30));
  EXPECT_FALSE(ledger.fits(20));
  EXPECT_EQ(ledger.refused(), 30u);
  ledger.release(60);
  EXPECT_TRUE(ledger.fits(20));
  EXPECT_EQ(ledger.refused(), 30u) << "somebody else's";
  EXPECT_TRUE(ledger.fits(30));
  EXPECT_EQ(ledger.refused(), 0u);
}

TEST(Ledger, ForgetsARefusalThatIsNotRepeated) {
  Ledger ledger(10);
  ledger.begin_frame(1);
  EXPECT_FALSE(ledger.fits(30));
  for (std::uint64_t frame = 2; frame <= 40; ++frame) ledger.begin_frame(frame);
  EXPECT_FALSE(ledger.fits(30));
  ledger.begin_frame(40 + Ledger::kRefusalFrames);
  EXPECT_EQ(ledger.refused(), 30u);
  ledger.begin_frame(41 + Ledger::kRefusalFrames);
  EXPECT_EQ(ledger.refused(), 0u);
}

TEST(Printable, LeavesTextAlone) {
  for (const char* text : {"", "oak", "Fr\xc3\xbchlings-Eiche \xe6\xa8\xb9 \xf0\x9f\x8c\xb3", "a\\x1b"}) {
    EXPECT_EQ(printable(text), text);
    EXPECT_TRUE(is_printable(text)) << text;
  }
}

TEST(Printable, HidesWhatATerminalObeys) {
  const std::pair<std::string_view, const char*> cases[] = {
      {"a\x1b[31mb", "a\\x1b[31mb"},
      {"two\nlines\r\t", "two\\x0alines\\x0d\\x09"},
      {std::string_view("nul\0here", 8), "nul\\x00here"},
      {"del\x7f", "del\\x7f"},
      {"csi \xc2\x9b", "csi \\xc2\\x9b"},
      {"turned \xe2\x80\xae", "turned \\xe2\\x80\\xae"},
      {"line \xe2\x80\xa8", "line \\xe2\\x80\\xa8"},
      {"not UTF-8: \xff\xc3", "not UTF-8: \\xff\\xc3"},
      {"overlong \xc0\x9b", "overlong \\xc0\\x9b"},
  };
  for (const auto& [text, shown] : cases) {
    EXPECT_EQ(printable(text), shown);
    EXPECT_FALSE(is_printable(text)) << shown;
    EXPECT_TRUE(is_printable(printable(text))) << shown;
  }
}

}  // namespace coppice::core_test
