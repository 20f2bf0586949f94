#include "needle_lines.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "card_coverage.h"
#include "greedy_union.h"
#include "quad_merge.h"
#include "stochastic_prune.h"

namespace coppice::bake {
namespace {

constexpr std::uint64_t kSampleSeed = 1;

glm::dvec3 middle_of(const Needle& needle) {
  return 0.5 * (glm::dvec3(needle.from) + glm::dvec3(needle.to));
}

double length_of(const Needle& needle) {
  return glm::distance(glm::dvec3(needle.from), glm::dvec3(needle.to));
}

double area_of(const Needle& needle) {
  return length_of(needle) * double{needle.width_m};
}

glm::dvec3 direction_of(const Needle& needle) {
  const double length = length_of(needle);
  return length > 0.0 ? (glm::dvec3(needle.to) - glm::dvec3(needle.from)) / length : glm::dvec3(0.0);
}

double mean_length_m(const std::vector<Needle>& needles) {
  double sum = 0.0;
  for (const Needle& needle : needles) sum += length_of(needle);
  return needles.empty() ? 0.0 : sum / static_cast<double>(needles.size());
}

UnionRules<Needle> merge_rules(NeedleLength length, double mean_m) {
  UnionRules<Needle> rules;
  rules.cost = [mean_m](const Needle& a, const Needle& b) {
    const double near = mean_m > 0.0 ? glm::distance(middle_of(a), middle_of(b)) / mean_m : 0.0;
    return near + 1.0 - std::min(1.0, std::abs(glm::dot(direction_of(a), direction_of(b))));
  };
  rules.unite = [length](const Needle& a, const Needle& b) { return united_needle(a, b, length); };
  rules.middle = middle_of;
  return rules;
}

Variant sampled(const std::vector<Needle>& needles, const std::vector<std::uint32_t>& counts) {
  Variant variant{"sampled", {}};
  const auto all = static_cast<std::uint32_t>(needles.size());
  const std::vector<std::uint32_t> order = stochastic_order(all, kSampleSeed);
  for (const std::uint32_t count : counts) {
    Level level;
    for (std::uint32_t i = 0; i < count; ++i) {
      level.needles.push_back(needles[order[i]]);
      level.needles.back().width_m *= static_cast<float>(all) / static_cast<float>(count);
    }
    variant.levels.push_back(std::move(level));
  }
  return variant;
}

}  // namespace

Needle needle_of(const Quad& quad, std::uint32_t material, double coverage) {
  const auto half = [](const glm::vec3& a, const glm::vec3& b) { return 0.5f * (a + b); };
  Needle along{half(quad[0], quad[3]), half(quad[1], quad[2]), 0.0f, material};
  const Needle across{half(quad[0], quad[1]), half(quad[2], quad[3]), 0.0f, material};
  if (length_of(across) > length_of(along)) along = across;
  const double length = length_of(along);
  if (length > 0.0) along.width_m = static_cast<float>(coverage * quad_area(quad) / length);
  return along;
}

Needle united_needle(const Needle& first, const Needle& second, NeedleLength length) {
  const double first_area = area_of(first), second_area = area_of(second), area = first_area + second_area;
  if (!(area > 0.0)) return first;
  const glm::dvec3 a = direction_of(first), b = direction_of(second);
  glm::dvec3 direction = first_area * a + (glm::dot(a, b) < 0.0 ? -second_area : second_area) * b;
  if (!(glm::length(direction) > 0.0)) direction = first_area < second_area ? b : a;
  direction = glm::normalize(direction);
  double long_m = std::max(length_of(first), length_of(second));
  if (length == NeedleLength::both) {
    const auto [low, high] = std::minmax({glm::dot(glm::dvec3(first.from), direction), glm::dot(glm::dvec3(first.to), direction),
                                          glm::dot(glm::dvec3(second.from), direction), glm::dot(glm::dvec3(second.to), direction)});
    long_m = high - low;
  }
  const glm::dvec3 middle = (first_area * middle_of(first) + second_area * middle_of(second)) / area, half = 0.5 * long_m * direction;
  return {glm::vec3(middle - half), glm::vec3(middle + half), static_cast<float>(area / long_m),
          first_area < second_area ? second.material : first.material};
}

Result<std::vector<Variant>> needle_lines(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                          const std::vector<std::uint32_t>& leaf_counts) {
  COPPICE_TRY(coverage, card_coverage(foliage.card_table, materials, images));
  std::vector<Needle> needles;
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) {
    const std::uint32_t card = foliage.cards[leaf];
    needles.push_back(needle_of(foliage.quads[leaf], foliage.card_table[card].material, coverage[card]));
  }
  std::vector<std::uint32_t> counts;
  counts.reserve(leaf_counts.size());
  for (const std::uint32_t count : leaf_counts) counts.push_back(std::min(2 * count, foliage.leaf_count()));

  std::vector<Variant> variants{sampled(needles, counts)};
  for (const NeedleLength length : {NeedleLength::longer, NeedleLength::both}) {
    Variant variant{length == NeedleLength::longer ? "merged, longer" : "merged, both", {}};
    const GreedyUnion<Needle> united(foliage, needles, merge_rules(length, mean_length_m(needles)));
    for (auto& merged : unite_to(united, counts)) variant.levels.push_back(Level{{}, {}, std::move(merged), {}});
    variants.push_back(std::move(variant));
  }
  return variants;
}

}  // namespace coppice::bake
