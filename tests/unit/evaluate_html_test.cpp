#include <cstdint>
#include <limits>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "evaluate.h"
#include "image_decode.h"
#include "mentions.h"
#include "report.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake::evaluate_html_test {

LevelMeasures level(double fraction, double rmse_256, double rmse_16, double hausdorff) {
  LevelMeasures made;
  made.fraction = fraction;
  made.leaves = static_cast<std::uint32_t>(1000 * fraction);
  made.rmse_full = rmse_256;
  made.rmse_sixteenth = rmse_16;
  made.hausdorff = hausdorff;
  made.coverage = 1.0 - fraction / 10;
  made.lightings.fill({rmse_256, rmse_16, 1.0});
  return made;
}

/// `default` wins rmse_16 everywhere, rmse_256 at one of two levels, and the surface nowhere. Before a ground on which it is worst it wins
/// nothing close up, and its leaves are too bright.
EvaluationReport small_report(const std::string& plant = "pear") {
  EvaluationReport report;
  report.plant = plant;
  report.source_leaves = 1000;
  report.methods = {{"geometric", 0.25, {level(0.5, 10, 4, 0.1), level(0.025, 30, 20, 0.2)}},
                    {"default", 12.6, {level(0.5, 20, 3, 0.2), level(0.025, 15, 5, 0.8)}}};
  report.methods[1].levels[1].lightings[4] = {40, 2, 1.25};
  return report;
}

/// What the page's script reads.
nlohmann::json page_data(const std::string& page) {
  const std::string start = "id=\"data\">";
  const std::size_t from = page.find(start) + start.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

using Facts = std::vector<std::string>;

/// Methods and shares, in the order of the sentence.
Facts facts_of(const std::string& sentence) {
  static const std::regex fact("default|geometric|prune|[0-9.]+%");
  Facts facts;
  for (std::sregex_iterator found(sentence.begin(), sentence.end(), fact), end; found != end; ++found) facts.push_back(found->str());
  return facts;
}

TEST(EvaluationHeadline, SaysWhereTheDefaultWinsAndWhereItLoses) {
  const std::vector<std::string> sentences = evaluation_headline(small_report());
  ASSERT_EQ(sentences.size(), 8u);
  EXPECT_TRUE(test::mentions(sentences[0], {"rmse_256"}));
  EXPECT_EQ(facts_of(sentences[0]), (Facts{"default", "2.5%", "50%", "geometric", "50%", "50%"}));
  EXPECT_TRUE(test::mentions(sentences[1], {"rmse_16"}));
  EXPECT_EQ(facts_of(sentences[1]), (Facts{"default", "25%", "75%"}));
  EXPECT_TRUE(test::mentions(sentences[2], {"rmse_256_worst"}));
  EXPECT_EQ(facts_of(sentences[2]), (Facts{"default", "geometric", "50%", "50%", "2.5%", "25%"}));
  EXPECT_TRUE(test::mentions(sentences[3], {"rmse_16_worst"}));
  EXPECT_EQ(facts_of(sentences[3]), (Facts{"default", "25%", "75%"}));
  EXPECT_TRUE(test::mentions(sentences[4], {"Hausdorff"}));
  EXPECT_EQ(facts_of(sentences[4]), (Facts{"default", "geometric", "50%", "50%", "2.5%", "75%"}));
  EXPECT_EQ(facts_of(sentences[5]), (Facts{"default", "95%", "100%"}));
  EXPECT_EQ(facts_of(sentences[6]), (Facts{"default", "100%", "125%"}));
  EXPECT_TRUE(test::mentions(sentences[7], {"13", "0.2"}));
  EXPECT_EQ(facts_of(sentences[7]), (Facts{"default", "geometric"}));
}

TEST(EvaluationHeadline, IsAboutTheFirstMethodWithoutDefaultAndComparesNothingAlone) {
  EvaluationReport report = small_report();
  report.methods[1].name = "prune";
  const std::string first = evaluation_headline(report)[0];
  EXPECT_TRUE(test::mentions(first, {"rmse_256"}));
  EXPECT_EQ(facts_of(first).at(0), "geometric") << first;
  EXPECT_EQ(facts_of(first).at(1), "50%") << first;
  report.methods.pop_back();
  EXPECT_EQ(evaluation_headline(report).size(), 3u);
  report.methods.clear();
  EXPECT_TRUE(evaluation_headline(report).empty());
}

TEST(EvaluationHeadline, AMeshWithoutTrianglesLosesByEverything) {
  EvaluationReport report = small_report();
  for (LevelMeasures& measures : report.methods[0].levels) measures.hausdorff = std::numeric_limits<double>::infinity();
  EXPECT_EQ(facts_of(evaluation_headline(report)[4]), (Facts{"default", "100%"}));
}

TEST(EvaluationHtml, HoldsTheFiguresAndThePictures) {
  EvaluationReport report = small_report();
  report.methods[0].levels[1].hausdorff = std::numeric_limits<double>::infinity();
  report.source_picture_png = {'M', 'a', 'n'};
  report.methods[0].levels[0].picture_png = {'M', 'a'};
  report.methods[0].levels[1].picture_png = {'M'};
  const nlohmann::json data = page_data(evaluation_html(report));
  EXPECT_EQ(data["plant"], "pear");
  EXPECT_EQ(data["source_picture"], "data:image/png;base64,TWFu");
  ASSERT_EQ(data["methods"].size(), 2u);
  EXPECT_EQ(data["methods"][0]["levels"][0]["picture"], "data:image/png;base64,TWE=");
  EXPECT_EQ(data["methods"][0]["levels"][1]["picture"], "data:image/png;base64,TQ==");
  EXPECT_TRUE(data["methods"][0]["levels"][1]["hausdorff"].is_null());
  EXPECT_TRUE(data["methods"][1]["levels"][0]["picture"].is_null());
  EXPECT_EQ(data["methods"][1]["name"], "default");
  EXPECT_EQ(data["methods"][1]["seconds"], 12.6);
  EXPECT_EQ(data["methods"][1]["levels"][1]["rmse_256"], 15.0);
  EXPECT_EQ(data["methods"][1]["levels"][1]["rmse_256_worst"], 40.0);
  EXPECT_EQ(data["lightings"], (std::vector<std::string>{"rmse_256_mean", "rmse_16_mean", "rmse_256_worst", "rmse_16_worst"}));
  EXPECT_EQ(data["headline"].size(), 8u);
}

TEST(EvaluationHtml, TextFromOutsideStaysText) {
  const std::string plain = evaluation_html(small_report());
  for (const std::string name : {"</script><b>", "<!--<script>", "{{script}}", "\xff\xfe", "a\"b\\c\n"}) {
    EvaluationReport report = small_report(name);
    report.warnings = {name};
    const std::string page = evaluation_html(report);
    for (const std::string part : {"<script", "</script", "<!--", "<b>"})
      EXPECT_EQ(count_of(page, part), count_of(plain, part)) << name << part;
    const std::string expected = name[0] == '\xff' ? "\ufffd\ufffd" : name;  // bytes that are no UTF-8 are replaced
    EXPECT_EQ(page_data(page)["plant"], expected);
  }
}

TEST(EvaluationHtml, LoadsNothing) {
  const std::string page = evaluation_html(small_report());
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  for (const std::string part :
       {" src=", "href=", "<link", "<iframe", "@import", "import(", "fetch(", "XMLHttpRequest", "WebSocket", "sendBeacon", "{{", "}}</"})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
  EXPECT_NE(page.find("Permission is hereby granted"), std::string::npos) << "the library's licence";
}

TEST(EvaluationPictures, ShowTheMaterialsColourOnWhiteAndOnlyWhenAskedFor) {
  std::vector<Material> materials = test::plain_materials();
  materials[0].base_color = {0.2f, 0.6f, 0.1f, 1.0f};
  EvaluateOptions options{.methods = {Method::stochastic}, .fractions = {1.0, 0.1}};
  const Foliage crown = test::ball_crown(60, 2);
  const auto without = evaluate_foliage("crown", {crown, materials, {}}, options, {});
  options.keep_pictures = true;
  const auto with = evaluate_foliage("crown", {crown, materials, {}}, options, {});
  ASSERT_TRUE(without && with);
  EXPECT_TRUE(without->source_picture_png.empty());
  EXPECT_TRUE(without->methods[0].levels[0].picture_png.empty());
  EXPECT_EQ(with->source_picture_png, with->methods[0].levels[0].picture_png) << "all leaves are the source";
  EXPECT_NE(with->source_picture_png, with->methods[0].levels[1].picture_png);

  const Image image = test::must(decode_image(with->source_picture_png, 4096));
  ASSERT_EQ(image.width, 256u);
  ASSERT_EQ(image.height, 256u);
  EXPECT_EQ((std::vector<std::uint8_t>(image.rgba.begin(), image.rgba.begin() + 4)), (std::vector<std::uint8_t>{255, 255, 255, 255}));
  std::size_t green = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    if (image.rgba[i + 1] > image.rgba[i] && image.rgba[i] > image.rgba[i + 2]) ++green;
  EXPECT_GT(green, image.rgba.size() / 4 / 10);
}

}  // namespace coppice::bake::evaluate_html_test
