// What command lines have in common: help that fits a terminal, and slips of the keyboard.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <sstream>

#include "command_line.h"

namespace coppice::command_line {
namespace {

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
  EXPECT_NE(help.find("How much; from 0.000000001 to 1"), std::string::npos) << help;
  EXPECT_NE(help.find("from 1 to 2000000 [7]"), std::string::npos) << help;
  EXPECT_EQ(help.find(" in ["), std::string::npos) << help;
}

TEST(UnknownWord, NamesTheFirstAndWhatWasMeant) {
  const Commands commands;
  EXPECT_EQ(unknown_word(commands.app, {"bakee", "x.glb"}), "tool: no command bakee: did you mean bake?");
  EXPECT_EQ(unknown_word(commands.app, {"grow"}), "tool: no command grow");
  EXPECT_EQ(unknown_word(commands.app, {"bake", "x.glb", "--shares=2"}), "tool bake: no option --shares: did you mean --share?");
  EXPECT_EQ(unknown_word(commands.app, {"bake", "--unheard-of"}), "tool bake: no option --unheard-of");
  EXPECT_EQ(unknown_word(commands.app, {"bake", "bakee", "--share", "2", "--loud", "-n", "3", "--", "--shares"}), "");
  EXPECT_EQ(unknown_word(commands.app, {}), "");
}

}  // namespace
}  // namespace coppice::command_line
