#include "handle.h"

#include <random>

#include <gtest/gtest.h>

namespace coppice {
namespace handle_test {

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

}  // namespace handle_test
}  // namespace coppice
