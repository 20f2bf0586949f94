#include "printable.h"

#include <gtest/gtest.h>

namespace coppice {
namespace printable_test {

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

}  // namespace printable_test
}  // namespace coppice
