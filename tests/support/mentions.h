#pragma once

// What a message has to name: the file, the field, the option, the number. Its words are free.

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace coppice::test {

/// Whether a token stands in the text as a whole: "5" is not in "15" or "5.2", "count" not in "counts", "--metric" not in "--metrics".
inline bool stands_in(std::string_view text, std::string_view token) {
  const auto at = [&](std::size_t place) { return place < text.size() ? text[place] : '\0'; };
  const auto is_letter = [](char letter) { return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_'; };
  const auto is_digit = [](char letter) { return std::isdigit(static_cast<unsigned char>(letter)) != 0; };
  if (token.empty()) return false;
  for (std::size_t begin = text.find(token); begin != std::string_view::npos; begin = text.find(token, begin + 1)) {
    const std::size_t end = begin + token.size();
    const bool began_before = is_letter(token.front()) && begin > 0 && is_letter(text[begin - 1]);
    const bool goes_on = (is_letter(token.back()) && is_letter(at(end))) || (token.starts_with("--") && at(end) == '-');
    const bool is_fraction = (is_digit(token.back()) && at(end) == '.' && is_digit(at(end + 1))) ||
                             (is_digit(token.front()) && begin > 1 && text[begin - 1] == '.' && is_digit(text[begin - 2]));
    if (!began_before && !goes_on && !is_fraction) return true;
  }
  return false;
}

/// For EXPECT_TRUE: a failure says which token is missing from what.
inline testing::AssertionResult mentions(std::string_view text, std::initializer_list<std::string_view> tokens) {
  const auto* const missing = std::ranges::find_if(tokens, [&](std::string_view token) { return !stands_in(text, token); });
  if (missing == tokens.end()) return testing::AssertionSuccess() << "named in: " << text;
  return testing::AssertionFailure() << "'" << *missing << "' is not named in: " << text;
}

/// Whether a message has an offset in a file, as Error::message() writes it.
inline bool names_an_offset(const std::string& message) {
  static const std::regex offset("byte [0-9]+");
  return std::regex_search(message, offset);
}

/// The lines that name a token: what has to be said once.
inline std::size_t lines_that_name(const std::string& text, std::string_view token) {
  std::istringstream lines(text);
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line);) count += stands_in(line, token) ? 1u : 0u;
  return count;
}

}  // namespace coppice::test
