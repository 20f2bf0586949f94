// What names of materials say, and the patterns and rules by which they are chosen.

#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "class_rules.h"
#include "material_words.h"
#include "name_pattern.h"
#include "results.h"

namespace coppice::bake::material_names_test {

TEST(ClassRules, ReadsAllKeys) {
  const auto rules = test::must(parse_class_rules(R"({"classes": [
    {"material": "^Leaves$", "class": "leaf", "min_triangles": 2, "max_triangles": 64},
    {"material": "snow", "class": "drop"}, {"material": ".", "class": "wood"}]})",
                                                  "oak.json"));
  ASSERT_EQ(rules.size(), 3u);
  EXPECT_EQ(rules[0].material, "^Leaves$");
  EXPECT_EQ(rules[0].part, PlantPart::leaf);
  EXPECT_EQ(rules[0].min_triangles, 2u);
  EXPECT_EQ(rules[0].max_triangles, 64u);
  EXPECT_EQ(rules[1].part, PlantPart::dropped);
  EXPECT_EQ(rules[1].min_triangles, 0u);
  EXPECT_EQ(rules[1].max_triangles, 0xffffffffu);
  EXPECT_EQ(rules[2].part, PlantPart::wood);
  EXPECT_EQ(rules[2].source, "oak.json: classes[2]");
}

TEST(ClassRules, AnErrorNamesFileKeyAndPlace) {
  const std::vector<std::pair<std::string, std::string>> bad{
      {"", "byte 1"},
      {R"({"classes": [}})", "byte 14"},
      {"[]", "classes"},
      {"{}", "classes"},
      {R"({"classes": {}})", "classes"},
      {R"({"classes": [], "klass": 1})", "klass"},
      {R"({"classes": [1]})", "classes[0]"},
      {R"({"classes": [{"class": "leaf"}]})", "classes[0].material"},
      {R"({"classes": [{"material": 1, "class": "leaf"}]})", "classes[0].material"},
      {R"({"classes": [{"material": "a"}]})", "classes[0].class"},
      {R"({"classes": [{"material": "a", "class": "twig"}]})", "'twig'"},
      {R"({"classes": [{"material": "a", "class": "leaf", "max": 1}]})", "classes[0].max"},
      {R"({"classes": [{"material": "a", "class": "leaf", "max_triangles": -1}]})", "classes[0].max_triangles"},
      {R"({"classes": [{"material": "a", "class": "leaf", "max_triangles": 4294967296}]})", "max_triangles"},
      {R"({"classes": [{"material": "a", "class": "leaf", "min_triangles": 3, "max_triangles": 2}]})", "classes[0]"}};
  for (const auto& [text, place] : bad) {
    SCOPED_TRACE(text);
    test::expect_error(parse_class_rules(text, "oak.json"), Status::bad_file, {"oak.json", place});
  }
}

std::vector<Material> materials_of(const std::vector<std::string>& names) {
  std::vector<Material> materials(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) materials[i].name = names[i];
  return materials;
}

TEST(ClassRules, ApplyInOrderToTheMaterialsTheyFind) {
  const std::vector<ClassRule> rules{{.material = "leaf", .part = PlantPart::leaf, .source = "first"},
                                     {.material = "^old", .part = PlantPart::dropped, .source = "second"},
                                     {.material = "moss", .part = PlantPart::wood, .source = "third"}};
  std::vector<std::string> warnings;
  const auto applied = test::must(apply_class_rules(rules, materials_of({"old leaf", "bark", "young leaf"}), warnings));
  ASSERT_EQ(applied.size(), 3u);
  ASSERT_EQ(applied[0].size(), 2u);
  EXPECT_EQ(applied[0][0].source, "first");
  EXPECT_EQ(applied[0][1].part, PlantPart::dropped);
  EXPECT_TRUE(applied[1].empty());
  EXPECT_EQ(applied[2].size(), 1u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(test::mentions(warnings[0], {"third", "'moss'"}));
}

TEST(ClassRules, WhatIsNoRegularExpressionIsAnError) {
  std::vector<std::string> warnings;
  test::expect_error(apply_class_rules(std::vector<ClassRule>{{.material = "((", .source = "oak.json: classes[4]"}}, {}, warnings),
                     Status::invalid_argument, {"oak.json: classes[4]", "(("});
}

TEST(MaterialWords, EachKindCountsOnceAndShortWordsAreWholeWords) {
  const std::vector<std::pair<const char*, double>> names{{"Leaves", 3},         {"leaf_leaves_foliage", 3},
                                                          {"petals", 1},         {"branch1", -1},
                                                          {"bark", -3},          {"LeafyBranch", 2},
                                                          {"Coconut Leaves", 0}, {"Bush_02", 1},
                                                          {"plant_pot", -3},     {"plant leaf", 3},
                                                          {"transplant", 0},     {"", 0},
                                                          {"Material.001", 0},   {"potato", 0},
                                                          {"clay_pot", -3},      {"ClayPot2", -3},
                                                          {"plastic", 0},        {"Ast", -1},
                                                          {"silicone", 0}};
  for (const auto& [name, evidence] : names) EXPECT_EQ(name_evidence(name), evidence) << name;
}

TEST(MaterialWords, InAnyCaseAndManyLanguages) {
  for (const char* name : {"OAK_LEAF_01", "Blattwerk",    "BLÄTTER", "Blätter",      "feuilles", "HOJAS",     "Folhagem", "foglie", "blad",
                           "Nadeln",      "pine needles", "yaprak",  "Grass_Blades", "GRÄSER",   "Farnwedel", "Fougères", "Трава",  "草",
                           "シダ",        "Листья",       "ХВОЯ",    "ΦΥΛΛΑ",        "葉っぱ",   "树叶",      "나뭇잎"})
    EXPECT_EQ(name_evidence(name), 3.0) << name;
  for (const char* name :
       {"Trunk", "Rinde", "ÉCORCE", "tronco", "Corteza", "Ствол", "КОРА", "树皮", "flowerpot pot soil", "Topf", "SNOW_01"})
    EXPECT_LT(name_evidence(name), 0.0) << name;
}

TEST(MaterialWords, NoWordTwiceAndAllLowerCase) {
  std::set<std::string_view> seen;
  for (const MaterialWords& group : material_words())
    for (const std::string_view text : group.texts) {
      EXPECT_TRUE(seen.insert(text).second) << text;
      EXPECT_NE(name_evidence(text), 0.0) << text;
    }
}

TEST(MaterialWords, LongNamesAreCut) {
  EXPECT_EQ(name_evidence(std::string(300, ' ') + "leaf"), 0.0);
  EXPECT_EQ(name_evidence("leaf" + std::string(1000000, ' ')), 3.0);
}

bool matches(const std::string& pattern, const std::string& name) {
  return test::must(NamePattern::compile(pattern, "--leaf-material")).is_in(name);
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
  const auto appended = test::must(NamePattern::compile("([._ -]?(lod)?[0-9]+)+$", ""));
  EXPECT_EQ(appended.without("oak_lod0.012"), "oak");
  EXPECT_EQ(appended.without("oak" + std::string(1'000'000, '1')), "oak");
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

}  // namespace coppice::bake::material_names_test
