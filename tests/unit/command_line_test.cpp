// What command lines have in common: help that fits a terminal, slips of the keyboard, and what completion knows.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <map>
#include <sstream>

#include "command_line.h"
#include "completion.h"
#include "mentions.h"

namespace coppice::command_line {
namespace command_line_test {

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

TEST(WordsOf, ComeFromChecksAndTypeNames) {
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
  const CommandWords words = words_of(app);
  EXPECT_EQ(words.name, "tool");
  EXPECT_EQ(words.about, "A tool");
  ASSERT_EQ(words.places.size(), 1u);
  EXPECT_EQ(words.places[0].value.endings, std::vector<std::string>{".glb"});
  EXPECT_TRUE(words.places[0].value.is_folder);
  using Strings = std::vector<std::string>;
  std::map<std::string, OptionWords> options;
  for (const OptionWords& each : words.options) options[each.names.back()] = each;
  EXPECT_EQ(options.at("--set").names, (Strings{"-s", "--set"}));
  EXPECT_EQ(options.at("--set").value.words, (Strings{"one", "two"}));
  EXPECT_EQ(options.at("--count").value.words, (Strings{"full", "none"}));
  EXPECT_EQ(options.at("--map").value.words, (Strings{"off", "on"}));
  EXPECT_EQ(options.at("--file").value.endings, Strings{""});
  EXPECT_EQ(options.at("--file").value.words, Strings{"top"});
  EXPECT_TRUE(options.at("--folder").value.is_folder);
  EXPECT_TRUE(options.at("--folder").value.endings.empty());
  EXPECT_TRUE(options.at("--number").takes_value);
  EXPECT_TRUE(options.at("--number").value.words.empty());
  EXPECT_TRUE(options.at("--list").value.is_named);
  EXPECT_EQ(options.at("--list").value.separator, ',');
  EXPECT_EQ(options.at("--list").value.endings, Strings{".png"});
  EXPECT_EQ(options.at("--no").names, (Strings{"--yes", "--no"}));
  EXPECT_FALSE(options.at("--no").takes_value);
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

}  // namespace command_line_test
}  // namespace coppice::command_line
