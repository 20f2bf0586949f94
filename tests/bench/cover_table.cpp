// Whether crowns keep their cover and their picture when they are made of crossed cards: pairs of square cards that share their middle and
// their axis, each a pinnate leaf with holes between its leaflets, as trees of many generators and packs have them.
//   cover_table LEAVES...   bakes the same crown (4 x 6 x 4 m, 60 m^2 of leaf surface) of so many cards. It prints rmse_256 and rmse_16 in
//                           single frames and in means of 16 frames, and cover, of `default` and of meshoptimizer, level by level.

#include <cstdio>
#include <cstdlib>
#include <vector>

#include "evaluate.h"
#include "test_foliage.h"

namespace coppice::bake {
namespace {

constexpr float kLeafArea_m2 = 60.0f;
constexpr std::uint32_t kImagePx = 64;

/// Seven pairs of leaflets on a stalk.
Image pinnate_leaf() {
  Image image{kImagePx, kImagePx, {}};
  for (std::uint32_t y = 0; y < kImagePx; ++y)
    for (std::uint32_t x = 0; x < kImagePx; ++x) {
      const float across = std::abs((static_cast<float>(x) + 0.5f) / kImagePx - 0.5f) * 2.0f;
      const float along = (static_cast<float>(y) + 0.5f) / kImagePx;
      const float leaflet = std::abs(std::fmod(along * 7.0f + across, 1.0f) - 0.5f);  // 0 in its middle
      const float length = 0.9f - 0.6f * std::abs(along - 0.4f);
      const bool is_leaf = across < 0.04f || (across < length && leaflet < 0.36f * (1.0f - across / length) + 0.1f);
      image.rgba.insert(image.rgba.end(), {70, 110, 40, static_cast<std::uint8_t>(is_leaf ? 255 : 0)});
    }
  return image;
}

double leaf_share(const Image& image) {
  double texels = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) texels += image.rgba[i] / 255.0;
  return texels / (kImagePx * kImagePx);
}

/// Pairs; an odd last one is alone.
Foliage crossed_cards(std::uint32_t leaf_count, double leaf_share) {
  std::mt19937 random(1);
  const float side_m = std::sqrt(kLeafArea_m2 / static_cast<float>(leaf_share) / static_cast<float>(leaf_count));
  std::vector<Quad> quads;
  while (quads.size() < leaf_count) {
    const glm::vec3 root = test::in_ball(random) * glm::vec3(2, 3, 2), along = side_m * glm::normalize(test::in_ball(random));
    const glm::vec3 across = side_m * glm::normalize(glm::cross(along, test::in_ball(random)));
    const glm::vec3 crossed = side_m * glm::normalize(glm::cross(along, across));
    quads.push_back(test::rectangle(root - 0.5f * across, along, across));
    if (quads.size() < leaf_count) quads.push_back(test::rectangle(root - 0.5f * crossed, along, crossed));
  }
  return test::plain_foliage(std::move(quads));
}

int print_table(std::uint32_t leaf_count) {
  const std::vector<Image> images{pinnate_leaf()};
  std::vector<Material> materials(1);
  materials[0].image = 0;
  materials[0].alpha_cutoff = 0.5f;
  EvaluateOptions options;
  options.methods = {Method::default_metric, Method::meshopt, Method::meshopt_sloppy};
  const Foliage foliage = crossed_cards(leaf_count, leaf_share(images[0]));
  const auto report = evaluate_foliage("crossed", {foliage, materials, images}, options, {});
  if (!report) return std::fprintf(stderr, "%u leaves: %s\n", leaf_count, report.error().message().c_str()), 1;
  std::printf(
      "\n%u leaves\n\n| level | method | rmse_256 | rmse_16 | frames 256 | frames 16 | cover |\n| --- | --- | --- | --- | --- | --- | --- "
      "|\n",
      leaf_count);
  for (std::size_t level = 0; level < options.fractions.size(); ++level)
    for (const MethodMeasures& method : report->methods) {
      const LevelMeasures& l = method.levels[level];
      std::printf("| %g | %s | %.2f | %.2f | %.2f | %.2f | %.3f |\n", l.fraction, method.name.c_str(), l.rmse_full, l.rmse_sixteenth,
                  l.lit->frames_full, l.lit->frames_sixteenth, l.coverage);
    }
  std::fflush(stdout);
  return 0;
}

}  // namespace
}  // namespace coppice::bake

int main(int argument_count, char** arguments) {
  if (argument_count < 2) return std::fprintf(stderr, "usage: cover_table LEAVES...\n"), 2;
  for (int i = 1; i < argument_count; ++i) {
    const auto leaf_count = static_cast<std::uint32_t>(std::strtoul(arguments[i], nullptr, 10));
    if (leaf_count < 2) return std::fprintf(stderr, "cover_table: %s is no number of leaves\n", arguments[i]), 2;
    if (coppice::bake::print_table(leaf_count) != 0) return 1;
  }
}
