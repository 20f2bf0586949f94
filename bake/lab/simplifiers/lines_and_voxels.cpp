#include "lines_and_voxels.h"
#include "leaf_shade.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "greedy_union.h"
#include "leaf_unions.h"
#include "pruning.h"
#include "quad_merge.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

constexpr int kCoverageSteps = 16;

template <class Point, class Corners>
Point bilinear(const Corners& corners, double s, double t) {
  return (1.0 - t) * ((1.0 - s) * Point(corners[0]) + s * Point(corners[1])) + t * ((1.0 - s) * Point(corners[3]) + s * Point(corners[2]));
}

glm::dvec2 card_point(const Card& card, double s, double t) {
  return bilinear<glm::dvec2>(card.uv, s, t);
}

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

constexpr int kFlakeSteps = 8;
constexpr std::uint32_t kMaxCells = 1024;  // ten bits

struct Flake {
  glm::dvec3 point{0.0};
  float area_m2 = 0.0f;
  std::uint32_t normal = 0, material = 0;
};

std::uint32_t nearest_normal(const glm::dvec3& normal) {
  std::uint32_t best = 0;
  for (std::uint32_t i = 1; i < kVoxelNormalCount; ++i)
    if (std::abs(glm::dot(voxel_normals()[i], normal)) > std::abs(glm::dot(voxel_normals()[best], normal))) best = i;
  return best;
}

Result<std::vector<Flake>> flakes_of(const ShownFoliage& shown) {
  COPPICE_TRY(masks, alpha_masks(shown.materials, shown.images));
  const Foliage& foliage = shown.foliage;
  std::vector<Flake> flakes;
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) {
    const Quad& quad = foliage.quads[leaf];
    const Card& card = foliage.card_table[foliage.cards[leaf]];
    Flake flake{{}, static_cast<float>(quad_area(quad) / (kFlakeSteps * kFlakeSteps)), nearest_normal(quad_normal(quad)), card.material};
    for (int y = 0; y < kFlakeSteps; ++y)
      for (int x = 0; x < kFlakeSteps; ++x) {
        const double s = (x + 0.5) / kFlakeSteps, t = (y + 0.5) / kFlakeSteps;
        if (masks[card.material].is_hole(card_point(card, s, t))) continue;
        flake.point = quad_point(quad, s, t);
        flakes.push_back(flake);
      }
  }
  return flakes;
}

struct Box {
  glm::dvec3 low{0.0};
  double side_m = 0.0;
};

Box box_of(const Foliage& foliage) {
  glm::dvec3 low(foliage.quads[0][0]), high = low;
  for (const Quad& quad : foliage.quads)
    for (const glm::vec3& corner : quad) {
      low = glm::min(low, glm::dvec3(corner));
      high = glm::max(high, glm::dvec3(corner));
    }
  const glm::dvec3 size = high - low;
  return {low, std::max({size.x, size.y, size.z})};
}

/// Makes voxels in the order of cells, whatever the order of flakes. A voxel shows the material with most of its area.
std::vector<Voxel> voxels_of(const std::vector<Flake>& flakes, const Box& box, std::uint32_t cells) {
  struct Cell {
    std::array<float, kVoxelNormalCount> area_m2{};
    std::map<std::uint32_t, float> by_material;
  };
  std::map<std::array<std::uint32_t, 3>, Cell> filled;
  for (const Flake& flake : flakes) {
    std::array<std::uint32_t, 3> place{};
    for (int axis = 0; axis < 3; ++axis)
      place[static_cast<std::size_t>(axis)] =
          std::min(cells - 1, static_cast<std::uint32_t>(std::max(0.0, (flake.point[axis] - box.low[axis]) / box.side_m * cells)));
    Cell& cell = filled[place];
    cell.area_m2[flake.normal] += flake.area_m2;
    cell.by_material[flake.material] += flake.area_m2;
  }
  const double side_m = box.side_m / cells;
  std::vector<Voxel> voxels;
  for (const auto& [place, cell] : filled) {
    Voxel voxel{glm::vec3(box.low + side_m * (glm::dvec3(place[0], place[1], place[2]) + 0.5)), static_cast<float>(0.5 * side_m), 0,
                cell.area_m2};
    const auto largest = std::ranges::max_element(cell.by_material, {}, [](const auto& item) { return item.second; });
    voxel.material = largest->first;
    voxels.push_back(voxel);
  }
  return voxels;
}

/// Fills the finest grid with at most `max_count` voxels; one voxel if there is none.
std::vector<Voxel> finest(const std::vector<Flake>& flakes, const Box& box, std::uint32_t max_count) {
  std::uint32_t low = 1, high = kMaxCells;
  std::vector<Voxel> best = voxels_of(flakes, box, 1);
  while (low < high) {
    const std::uint32_t middle = (low + high + 1) / 2;
    std::vector<Voxel> voxels = voxels_of(flakes, box, middle);
    if (voxels.size() > max_count) {
      high = middle - 1;
    } else {
      low = middle;
      best = std::move(voxels);
    }
  }
  return best;
}

}  // namespace

glm::dvec3 quad_point(const Quad& quad, double s, double t) {
  return bilinear<glm::dvec3>(quad, s, t);
}

Result<std::vector<double>> card_coverage(const std::vector<Card>& cards, const std::vector<Material>& materials,
                                          const std::vector<Image>& images) {
  COPPICE_TRY(masks, alpha_masks(materials, images));
  std::vector<double> coverage;
  for (const Card& card : cards) {
    int covered = 0;
    for (int y = 0; y < kCoverageSteps; ++y)
      for (int x = 0; x < kCoverageSteps; ++x)
        if (!masks[card.material].is_hole(card_point(card, (x + 0.5) / kCoverageSteps, (y + 0.5) / kCoverageSteps))) ++covered;
    coverage.push_back(static_cast<double>(covered) / (kCoverageSteps * kCoverageSteps));
  }
  return coverage;
}

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

Result<std::vector<Variant>> needle_lines(const ShownFoliage& shown, const std::vector<std::uint32_t>& leaf_counts) {
  const Foliage& foliage = shown.foliage;
  COPPICE_TRY(coverage, card_coverage(foliage.card_table, shown.materials, shown.images));
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

Result<std::vector<Voxel>> fill_voxels(const ShownFoliage& shown, std::uint32_t cells) {
  COPPICE_TRY(flakes, flakes_of(shown));
  return voxels_of(flakes, box_of(shown.foliage), cells);
}

Result<std::vector<Variant>> voxel_cloud(const ShownFoliage& shown, const std::vector<std::uint32_t>& leaf_counts) {
  COPPICE_TRY(flakes, flakes_of(shown));
  const Box box = box_of(shown.foliage);
  std::vector<std::vector<Voxel>> clouds;
  clouds.reserve(leaf_counts.size());
  for (const std::uint32_t count : leaf_counts)
    clouds.push_back(finest(flakes, box, static_cast<std::uint32_t>(std::uint64_t{count} * kLeafBytes / kVoxelBytes)));
  std::vector<Variant> variants;
  for (const float share : {0.25f, 0.35f, 0.5f, 0.7f, 0.85f, 1.0f, 1.25f}) {
    Variant variant{"area x " + std::to_string(share).substr(0, 4), {}};
    for (std::vector<Voxel> voxels : clouds) {
      for (Voxel& voxel : voxels)
        for (float& area : voxel.area_m2) area *= share;
      variant.levels.push_back(Level{{}, {}, {}, std::move(voxels)});
    }
    variants.push_back(std::move(variant));
  }
  return variants;
}

}  // namespace coppice::bake
