#include "material_words.h"

#include <set>

#include <gtest/gtest.h>

namespace coppice::bake {
namespace material_words_test {

TEST(MaterialWords, EachKindCountsOnce) {
  EXPECT_EQ(name_evidence("Leaves"), 3.0);
  EXPECT_EQ(name_evidence("leaf_leaves_foliage"), 3.0);
  EXPECT_EQ(name_evidence("petals"), 1.0);
  EXPECT_EQ(name_evidence("branch1"), -1.0);
  EXPECT_EQ(name_evidence("bark"), -3.0);
  EXPECT_EQ(name_evidence("LeafyBranch"), 2.0);
  EXPECT_EQ(name_evidence("Coconut Leaves"), 0.0);
  EXPECT_EQ(name_evidence("Bush_02"), 1.0);
  EXPECT_EQ(name_evidence("plant_pot"), -3.0);
  EXPECT_EQ(name_evidence("plant leaf"), 3.0);
  EXPECT_EQ(name_evidence("transplant"), 0.0);
  EXPECT_EQ(name_evidence(""), 0.0);
  EXPECT_EQ(name_evidence("Material.001"), 0.0);
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

TEST(MaterialWords, ShortWordsAreWholeWords) {
  EXPECT_EQ(name_evidence("potato"), 0.0);
  EXPECT_EQ(name_evidence("clay_pot"), -3.0);
  EXPECT_EQ(name_evidence("ClayPot2"), -3.0);
  EXPECT_EQ(name_evidence("plastic"), 0.0) << "no Ast";
  EXPECT_EQ(name_evidence("Ast"), -1.0);
  EXPECT_EQ(name_evidence("silicone"), 0.0) << "no cone";
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

}  // namespace material_words_test
}  // namespace coppice::bake
