#pragma once

#include <initializer_list>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "mentions.h"
#include "result.h"

namespace coppice::test {

/// The value of a result. Throws std::runtime_error with the message of an error, which fails the test.
template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return *std::move(result);
}

/// The result is an error of this status, and its message names each of the tokens.
template <class T>
void expect_error(const Result<T>& result, Status status, std::initializer_list<std::string_view> tokens = {}) {
  ASSERT_FALSE(result);
  EXPECT_EQ(static_cast<int>(result.error().status), static_cast<int>(status)) << result.error().message();
  EXPECT_TRUE(mentions(result.error().message(), tokens));
}

}  // namespace coppice::test
