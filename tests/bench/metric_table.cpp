// Image errors of the cuts that each way of ordering collapses gives, as a table: metric_table METHOD,... PLANT...
// A row: seconds, then rmse_256 rmse_64 rmse_16 coverage at .8 .6 .4 .2 .1 .05 .025 of the leaves.
// METHOD is default, mi or stochastic; PLANT a species of `coppice plant`, or FILE.glb[:leaf material]. The viewpoints are not the
// baker's: a Fibonacci sphere turned away from its axes, another light, no box filter of the baker's.

#include <cmath>
#include <cstdio>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bake.h"
#include "collapse_image.h"
#include "collapse_information.h"
#include "generate_plant.h"
#include "held_out_error.h"
#include "import_gltf.h"
#include "leaf_cards.h"
#include "stopwatch.h"
#include "tree_order.h"

namespace coppice::bake {
namespace {

std::vector<std::string> split_at_commas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

/// "3:1,5:4": blocks of 8 px a side count once, of 32 px four times.
std::vector<BlockScale> parse_scales(const std::string& text) {
  std::vector<BlockScale> scales;
  for (const std::string& part : split_at_commas(text)) {
    const std::size_t colon = part.find(':');
    if (colon == std::string::npos) throw std::invalid_argument(part);
    scales.push_back({static_cast<std::uint32_t>(std::stoul(part.substr(0, colon))), std::stol(part.substr(colon + 1))});
  }
  return scales;
}

Result<Plant> load(const std::string& name) {
  if (name.find(".glb") == std::string::npos) return generate_plant(name, 1);
  ImportOptions options;
  const std::size_t colon = name.find(':');
  if (colon != std::string::npos) options.leaf_material = name.substr(colon + 1);
  return import_gltf(name.substr(0, colon), options);
}

/// Cook et al. 2007: a random order; the leaves that stay grow about their centres so that the area does.
Foliage stochastic_cut(const Foliage& source, std::uint32_t leaf_count) {
  std::vector<std::uint32_t> order(source.leaf_count());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937 random(1);
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
  const float scale = std::sqrt(static_cast<float>(source.leaf_count()) / static_cast<float>(leaf_count));
  Foliage cut;
  cut.card_table = source.card_table;
  for (std::uint32_t i = 0; i < leaf_count; ++i) {
    Quad quad = source.quads[order[i]];
    const glm::vec3 center = (quad[0] + quad[1] + quad[2] + quad[3]) * 0.25f;
    for (glm::vec3& corner : quad) corner = center + (corner - center) * scale;
    cut.quads.push_back(quad);
    cut.cards.push_back(source.cards[order[i]]);
  }
  return cut;
}

int print_plant(const std::string& name, const std::vector<std::string>& methods, const ImageErrorOptions& image_options) {
  auto plant = load(name);
  if (!plant) return std::fprintf(stderr, "%s\n", plant.error().message().c_str()), 1;
  const auto foliage = card_foliage(*plant);
  if (!foliage) return std::fprintf(stderr, "%s\n", foliage.error().message().c_str()), 1;
  const test::HeldOutViews reference(*foliage, *plant);
  for (const std::string& method : methods) {
    const test::Stopwatch watch;
    Tree tree;
    if (method != "stochastic") {
      const Metric metric = method == "mi" ? Metric::mi : Metric::default_metric;
      const std::vector<Viewpoint> views = *viewpoints(metric_view_count(metric, foliage->leaf_count()));
      const auto result =
          metric == Metric::mi
              ? collapse_by_mutual_information({*foliage, plant->materials, plant->images}, views, CollapseOptions{}, {})
              : collapse_by_image_error({*foliage, plant->materials, plant->images}, views, CollapseOptions{}, image_options, {});
      if (!result) return std::fprintf(stderr, "%s\n", result.error().message().c_str()), 1;
      std::fprintf(stderr, "%s %s: %llu evaluations\n", name.c_str(), method.c_str(),
                   static_cast<unsigned long long>(result->sequence.evaluations));
      tree = build_tree(*foliage, result->sequence);
    }
    const double seconds = watch.seconds();
    std::printf("%-28s %-10s %6.1f s", name.substr(name.rfind('/') + 1).c_str(), method.c_str(), seconds);
    for (const std::uint32_t leaf_count : level_leaf_counts(foliage->leaf_count())) {
      const Foliage cut =
          method == "stochastic" ? stochastic_cut(*foliage, leaf_count) : cut_foliage(tree, foliage->card_table, leaf_count);
      const test::HeldOutErrors errors = reference.errors_of(cut);
      std::printf(" | %.1f %.1f %.1f %.2f", errors.rmse_256, errors.rmse_64, errors.rmse_16, errors.coverage);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace coppice::bake

int main(int argument_count, char** arguments) {
  std::vector<std::string> words(arguments + 1, arguments + argument_count);
  coppice::bake::ImageErrorOptions options;
  if (words.size() >= 2 && words[0] == "--scales") {
    options.scales = coppice::bake::parse_scales(words[1]);
    words.erase(words.begin(), words.begin() + 2);
  }
  if (words.size() < 2) {
    std::fprintf(stderr, "usage: metric_table [--scales SHIFT:WEIGHT,...] default,mi,stochastic PLANT...\n");
    return 2;
  }
  for (std::size_t i = 1; i < words.size(); ++i)
    if (const int failed = coppice::bake::print_plant(words[i], coppice::bake::split_at_commas(words[0]), options); failed != 0)
      return failed;
  return 0;
}
