#include "class_rules.h"

#include <gtest/gtest.h>

#include "expect_error.h"

namespace coppice::bake {
namespace class_rules_test {

TEST(ClassRules, ReadsAllKeys) {
  const auto rules = parse_class_rules(R"({"classes": [
    {"material": "^Leaves$", "class": "leaf", "min_triangles": 2, "max_triangles": 64},
    {"material": "snow", "class": "drop"}, {"material": ".", "class": "wood"}]})",
                                       "oak.json");
  ASSERT_TRUE(rules) << rules.error().message();
  ASSERT_EQ(rules->size(), 3u);
  EXPECT_EQ((*rules)[0].material, "^Leaves$");
  EXPECT_EQ((*rules)[0].part, PlantPart::leaf);
  EXPECT_EQ((*rules)[0].min_triangles, 2u);
  EXPECT_EQ((*rules)[0].max_triangles, 64u);
  EXPECT_EQ((*rules)[1].part, PlantPart::dropped);
  EXPECT_EQ((*rules)[1].min_triangles, 0u);
  EXPECT_EQ((*rules)[1].max_triangles, 0xffffffffu);
  EXPECT_EQ((*rules)[2].part, PlantPart::wood);
  EXPECT_EQ((*rules)[2].source, "oak.json: classes[2]");
}

struct BadRules {
  const char* name;
  const char* text;
  const char* place;
};

// For GoogleTest. NOLINTNEXTLINE(readability-identifier-naming)
void PrintTo(const BadRules& rules, std::ostream* out) {
  *out << "'" << rules.text << "'";
}

class BadRulesTest : public testing::TestWithParam<BadRules> {};

TEST_P(BadRulesTest, NamesFileKeyAndPlace) {
  test::expect_error(parse_class_rules(GetParam().text, "oak.json"), Status::bad_file, {"oak.json", GetParam().place});
}

INSTANTIATE_TEST_SUITE_P(
    ClassRules, BadRulesTest,
    testing::Values(
        BadRules{"NoBytes", "", "byte 1"}, BadRules{"NoEnd", R"({"classes": [}})", "byte 14"}, BadRules{"AnArray", "[]", "classes"},
        BadRules{"NoClasses", "{}", "classes"}, BadRules{"ClassesIsAnObject", R"({"classes": {}})", "classes"},
        BadRules{"UnknownKey", R"({"classes": [], "klass": 1})", "klass"}, BadRules{"ARuleIsANumber", R"({"classes": [1]})", "classes[0]"},
        BadRules{"NoMaterial", R"({"classes": [{"class": "leaf"}]})", "classes[0].material"},
        BadRules{"MaterialIsANumber", R"({"classes": [{"material": 1, "class": "leaf"}]})", "classes[0].material"},
        BadRules{"NoClass", R"({"classes": [{"material": "a"}]})", "classes[0].class"},
        BadRules{"UnknownClass", R"({"classes": [{"material": "a", "class": "twig"}]})", "'twig'"},
        BadRules{"UnknownKeyOfARule", R"({"classes": [{"material": "a", "class": "leaf", "max": 1}]})", "classes[0].max"},
        BadRules{"NegativeCount", R"({"classes": [{"material": "a", "class": "leaf", "max_triangles": -1}]})", "classes[0].max_triangles"},
        BadRules{"CountTooLarge", R"({"classes": [{"material": "a", "class": "leaf", "max_triangles": 4294967296}]})", "max_triangles"},
        BadRules{"MinAboveMax", R"({"classes": [{"material": "a", "class": "leaf", "min_triangles": 3, "max_triangles": 2}]})",
                 "classes[0]"}),
    [](const auto& bad) { return std::string(bad.param.name); });

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
  const auto applied = apply_class_rules(rules, materials_of({"old leaf", "bark", "young leaf"}), warnings);
  ASSERT_TRUE(applied) << applied.error().message();
  ASSERT_EQ(applied->size(), 3u);
  ASSERT_EQ((*applied)[0].size(), 2u);
  EXPECT_EQ((*applied)[0][0].source, "first");
  EXPECT_EQ((*applied)[0][1].part, PlantPart::dropped);
  EXPECT_TRUE((*applied)[1].empty());
  EXPECT_EQ((*applied)[2].size(), 1u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(test::mentions(warnings[0], {"third", "'moss'"}));
}

TEST(ClassRules, WhatIsNoRegularExpressionIsAnError) {
  std::vector<std::string> warnings;
  test::expect_error(apply_class_rules(std::vector<ClassRule>{{.material = "((", .source = "oak.json: classes[4]"}}, {}, warnings),
                     Status::invalid_argument, {"oak.json: classes[4]", "(("});
}

}  // namespace class_rules_test
}  // namespace coppice::bake
