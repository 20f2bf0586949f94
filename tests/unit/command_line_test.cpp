// What command lines have in common: help that fits a terminal, slips of the keyboard, and what completion knows.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <map>
#include <set>
#include <sstream>

#include "command_line.h"
#include "completion.h"
#include "mentions.h"

namespace coppice::command_line::command_line_test {

TEST(Wrapped, BreaksAtSpacesAndKeepsIndentsAndLines) {
  EXPECT_EQ(wrapped("one two three", 8), "one two\nthree");
  EXPECT_EQ(wrapped("  one two three\nfour", 8), "  one\n  two\n  three\nfour");
  EXPECT_EQ(wrapped("a\n\nb\n", 8), "a\n\nb\n");
  EXPECT_EQ(wrapped("incomprehensible word", 8), "incomprehensible\nword") << "a word is never cut";
  EXPECT_EQ(wrapped("12345678", 8), "12345678");
  EXPECT_EQ(wrapped("", 8), "");
}

TEST(Meant, IsTheNearestWordOrNone) {
  const std::vector<std::string> words{"bake", "bake-all", "plant", "inspect"};
  EXPECT_EQ(meant("bakee", words), "bake");
  EXPECT_EQ(meant("bkae", words), "bake") << "swapped";
  EXPECT_EQ(meant("insect", words), "inspect");
  EXPECT_EQ(meant("bakeall", words), "bake-all");
  EXPECT_EQ(meant("grow", words), "");
  EXPECT_EQ(meant("", words), "");
}

struct Commands {
  CLI::App app{"", "tool"};
  float share = 0;
  unsigned count = 7;
  bool quiet = false;
  std::string input, out;
  Commands() {
    app.formatter(help_format());
    CLI::App* bake = app.add_subcommand("bake", "Bakes");
    bake->add_option("input", input)->required();
    bake->add_option("--share", share, "How much")->check(CLI::Range(1e-9, 1.0))->type_name("S");
    bake->add_option("-n,--count", count, "How many, of which nobody knows why it is told at such a length that it takes several lines")
        ->check(CLI::Range(1u, 2000000u))
        ->capture_default_str();
    bake->add_flag("--quiet,!--loud", quiet, "Say nothing");
  }
  [[nodiscard]] std::string help() { return app.get_subcommand("bake")->help(); }
};

TEST(Help, FitsTheColumnsAndHasRangesInWords) {
  const std::string help = Commands().help();
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), kColumns) << line;
  EXPECT_TRUE(test::mentions(help, {"--share", "0.000000001", "--count", "1", "2000000", "[7]"}));
  EXPECT_EQ(help.find(" in ["), std::string::npos) << help;
}

TEST(FirstClause, EndsWhereOnePauses) {
  EXPECT_EQ(first_clause("Worker threads; 0 for all. The result is the same"), "Worker threads");
  EXPECT_EQ(first_clause("Writes F.json. Nothing else"), "Writes F.json");
  EXPECT_EQ(first_clause("How leaves are lit: 0 or 1"), "How leaves are lit");
  EXPECT_EQ(first_clause("cut: by size. full: all"), "cut: by size") << "a word and a colon begin a list";
  EXPECT_EQ(first_clause("Memory budget [256; or more]"), "Memory budget");
  EXPECT_EQ(first_clause("Quick"), "Quick");
  EXPECT_EQ(first_clause(""), "");
}

/// The lines of an answer, in any order: words without their descriptions.
std::multiset<std::string> answer(const CLI::App& app, const std::vector<std::string>& words) {
  std::multiset<std::string> lines;
  std::istringstream stream(completions(app, words));
  for (std::string line; std::getline(stream, line);) lines.insert(line.starts_with(':') ? line : line.substr(0, line.find('\t')));
  return lines;
}

TEST(Completions, ComeFromChecksAndTypeNames) {
  CLI::App app("A tool. Of ours", "tool");
  std::string text;
  std::vector<std::string> several;
  bool flag = false;
  const auto option = [&](const char* name, const char* type) { return app.add_option(name, text)->type_name(type); };
  option("place", "IN.glb|FOLDER");
  option("--set,-s", "KIND")->check(CLI::IsMember({"one", "two"}));
  option("--count", "M|full")->check(CLI::Range(1, 9) | CLI::IsMember({"full", "none"}));
  option("--map", "")->transform(CLI::CheckedTransformer(std::map<std::string, int>{{"off", 0}, {"on", 1}}));
  option("--file", "FILE|top");
  option("--folder", "OUT/");
  option("--number", "N");
  app.add_option("--list", several)->delimiter(',')->type_name("NAME=A.png,...");
  app.add_flag("--yes,!--no", flag);
  using Lines = std::multiset<std::string>;
  EXPECT_EQ(answer(app, {""}), (Lines{":file\t.glb", ":folder\t"}));
  EXPECT_EQ(answer(app, {"--yes", "-s", "one", ""}), (Lines{":file\t.glb", ":folder\t"}));
  EXPECT_EQ(answer(app, {"a.glb", ""}), Lines{}) << "there is one place";
  EXPECT_EQ(answer(app, {"--", "-"}), (Lines{":file\t.glb", ":folder\t"}));
  EXPECT_EQ(answer(app, {"-s", "o"}), (Lines{"one", "two"}));
  EXPECT_EQ(answer(app, {"--set=o"}), (Lines{":before\t--set=", "one", "two"}));
  EXPECT_EQ(answer(app, {"--count", ""}), (Lines{"full", "none"}));
  EXPECT_EQ(answer(app, {"--map", ""}), (Lines{"off", "on"}));
  EXPECT_EQ(answer(app, {"--file", ""}), (Lines{":file\t", ":folder\t", "top"}));
  EXPECT_EQ(answer(app, {"--folder", ""}), Lines{":folder\t"});
  EXPECT_EQ(answer(app, {"--number", ""}), Lines{});
  EXPECT_EQ(answer(app, {"--list", "oak"}), Lines{}) << "nobody knows names";
  EXPECT_EQ(answer(app, {"--list", "oak=a.png,b"}), (Lines{":before\toak=a.png,", ":file\t.png", ":folder\t", ":list\t"}));
  EXPECT_EQ(answer(app, {"--list=oak=b"}), (Lines{":before\t--list=oak=", ":file\t.png", ":folder\t", ":list\t"}));
  EXPECT_EQ(answer(app, {"--no=o"}), Lines{}) << "a flag";
  EXPECT_EQ(answer(app, {"-"}),
            (Lines{"-h", "--help", "--set", "-s", "--count", "--map", "--file", "--folder", "--number", "--list", "--yes", "--no"}));
}

TEST(Completions, KnowCommandsAndDescribeThem) {
  const Commands commands;
  EXPECT_EQ(completions(commands.app, {}), "bake\tBakes\n");
  EXPECT_EQ(completions(commands.app, {"bak"}), "bake\tBakes\n") << "the shell chooses those that begin so";
  EXPECT_EQ(completions(commands.app, {"grow", "-"}), "");
  const std::string options = completions(commands.app, {"bake", "-"});
  for (const std::string line : {"--share\tHow much\n", "-n\tHow many, of", "--quiet\tSay nothing\n"})
    EXPECT_NE(options.find(line), std::string::npos) << options;
}

TEST(UnknownWord, NamesTheFirstAndWhatWasMeant) {
  const Commands commands;
  EXPECT_TRUE(test::mentions(unknown_word(commands.app, {"bakee", "x.glb"}), {"tool", "bakee", "bake"}));
  EXPECT_TRUE(test::mentions(unknown_word(commands.app, {"grow"}), {"tool", "grow"}));
  EXPECT_FALSE(test::mentions(unknown_word(commands.app, {"grow"}), {"bake"}));
  EXPECT_TRUE(test::mentions(unknown_word(commands.app, {"bake", "x.glb", "--shares=2"}), {"tool bake", "--shares", "--share"}));
  EXPECT_TRUE(test::mentions(unknown_word(commands.app, {"bake", "--unheard-of"}), {"tool bake", "--unheard-of"}));
  for (const char* known : {"--share", "--count", "--quiet", "--loud"})
    EXPECT_FALSE(test::mentions(unknown_word(commands.app, {"bake", "--unheard-of"}), {known}));
  EXPECT_EQ(unknown_word(commands.app, {"bake", "bakee", "--share", "2", "--loud", "-n", "3", "--", "--shares"}), "");
  EXPECT_EQ(unknown_word(commands.app, {}), "");
}

}  // namespace coppice::command_line::command_line_test
