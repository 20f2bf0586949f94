#include "name_pattern.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "expect_error.h"

namespace coppice::bake {
namespace name_pattern_test {

bool matches(const std::string& pattern, const std::string& name) {
  const auto compiled = NamePattern::compile(pattern, "--leaf-material");
  EXPECT_TRUE(compiled) << compiled.error().message();
  return compiled && compiled->is_in(name);
}

TEST(NamePattern, IsSearchedNotAnchoredAndCaseMatters) {
  EXPECT_TRUE(matches("eav", "Leaves"));
  EXPECT_FALSE(matches("leav", "Leaves"));
  EXPECT_TRUE(matches("(?i)leav", "Leaves"));
  EXPECT_FALSE(matches("^eav", "Leaves"));
  EXPECT_TRUE(matches("^(Leaves|Needles)[0-9]*$", "Needles07"));
  EXPECT_TRUE(matches("\\bleaf\\b", "a leaf here"));
  EXPECT_TRUE(matches("bl.tter", "a bl\xc3\xa4tter"));
  EXPECT_TRUE(matches(".", "x"));
  EXPECT_FALSE(matches(".", ""));
  EXPECT_TRUE(matches("", ""));
}

TEST(NamePattern, ANameOfAnyLengthTakesNoStack) {
  EXPECT_FALSE(matches("(a|b)*c", std::string(1'000'000, 'a')));
  EXPECT_TRUE(matches("(a|b)*c", std::string(1'000'000, 'a') + "c"));
  const auto appended = NamePattern::compile("([._ -]?(lod)?[0-9]+)+$", "");
  ASSERT_TRUE(appended);
  EXPECT_EQ(appended->without("oak_lod0.012"), "oak");
  EXPECT_EQ(appended->without("oak" + std::string(1'000'000, '1')), "oak");
}

TEST(NamePattern, APatternOfManyBracketsIsAnErrorOrAPattern) {
  for (const std::string bracket : {"(", "[", "(?:", "(a|", "((a*)*"}) {
    std::string text;
    for (int i = 0; i < 20000; ++i) text += bracket;
    const auto pattern = NamePattern::compile(text, "--leaf-material");
    ASSERT_FALSE(pattern) << bracket;
    EXPECT_LT(pattern.error().message().size(), 300u) << bracket;
  }
  const auto nested = NamePattern::compile(std::string(20000, '(') + "a" + std::string(20000, ')'), "--leaf-material");
  EXPECT_TRUE(!nested || nested->is_in("a"));
  EXPECT_FALSE(NamePattern::compile("((a{1,900}){1,900}){1,900}", "--leaf-material"));
}

TEST(NamePattern, AnErrorNamesSourcePatternAndReason) {
  std::set<std::string> reasons;
  for (const std::string text : {"((", "a**", "(?=a)b", "(a)\\1"}) {
    const auto pattern = NamePattern::compile(text, "oak.json: classes[4]");
    test::expect_error(pattern, Status::invalid_argument, {"oak.json: classes[4]", text});
    const std::string message = pattern.error().message();
    const std::size_t reason = message.find(text) + text.size();
    EXPECT_GT(message.size(), reason) << message;
    EXPECT_TRUE(reasons.insert(message.substr(reason)).second) << message;
  }
}

}  // namespace name_pattern_test
}  // namespace coppice::bake
