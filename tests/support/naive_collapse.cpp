#include "naive_collapse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include <glm/geometric.hpp>

#include "bounds.h"

namespace coppice::test {
namespace {

using bake::FixedBits;
using bake::Merge;
using bake::Quad;

double area_of(const Quad& quad) {
  const auto triangle = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) { return glm::length(glm::cross(b - a, c - a)); };
  return 0.5 * (triangle(quad[0], quad[1], quad[2]) + triangle(quad[0], quad[2], quad[3]));
}

glm::dvec3 centroid_of(const Quad& quad) {
  return (glm::dvec3(quad[0]) + glm::dvec3(quad[1]) + glm::dvec3(quad[2]) + glm::dvec3(quad[3])) * 0.25;
}

/// The octree's grid as its comment gives it.
struct Grid {
  glm::dvec3 low{0.0};
  double edge = 0.0;
  int depth = 1;

  explicit Grid(const bake::Foliage& source) {
    glm::dvec3 high = low = source.quads[0][0];
    for (const Quad& quad : source.quads) {
      for (const glm::dvec3 corner : quad) {
        low = glm::min(low, corner);
        high = glm::max(high, corner);
      }
    }
    edge = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    const double log2_of_count = std::log2(static_cast<double>(source.leaf_count()));
    depth = std::min(7, 2 + static_cast<int>(std::ceil(log2_of_count / 3.0)));
  }

  [[nodiscard]] std::array<int, 3> cell(const glm::dvec3& point, int level) const {
    const int last = (1 << depth) - 1;
    std::array<int, 3> cell{};
    for (int axis = 0; axis < 3; ++axis) {
      const double scaled = edge > 0.0 ? (point[axis] - low[axis]) * ((1 << depth) / edge) : 0.0;
      cell[static_cast<std::size_t>(axis)] = std::clamp(static_cast<int>(std::floor(scaled)), 0, last) >> (depth - level);
    }
    return cell;
  }
};

/// Every other leaf within so many cells of the chosen one's, at that level.
std::vector<std::uint32_t> others_within(const Grid& grid, const NaivePlant& plant, std::uint32_t chosen, int level, int rings) {
  const std::array<int, 3> own = grid.cell(centroid_of(plant.at(chosen).quad), level);
  std::vector<std::uint32_t> region;
  for (const auto& [id, leaf] : plant) {
    const std::array<int, 3> other = grid.cell(centroid_of(leaf.quad), level);
    bool near = id != chosen;
    for (std::size_t axis = 0; axis < 3; ++axis) near = near && std::abs(own[axis] - other[axis]) <= rings;
    if (near) region.push_back(id);
  }
  return region;
}

/// The leaf's cell, enlarged until it holds at least `count` others: rings 0 to 3 at the deepest level, 2 and 3 at each coarser one.
std::vector<std::uint32_t> candidates_of(const Grid& grid, const NaivePlant& plant, std::uint32_t chosen, std::size_t count) {
  for (int level = grid.depth; level > 0; --level)
    for (int rings = level == grid.depth ? 0 : 2; rings <= 3; ++rings) {
      std::vector<std::uint32_t> region = others_within(grid, plant, chosen, level, rings);
      if (region.size() >= count) return region;
    }
  return others_within(grid, plant, chosen, 0, 0);
}

/// Fig. 3 by trying every choice: the largest distance, then twice the largest summed distance, the first of equals.
std::array<std::uint8_t, 4> corners_of(const Quad& first, const Quad& second) {
  std::vector<glm::dvec3> p(first.begin(), first.end());
  p.insert(p.end(), second.begin(), second.end());
  std::vector<std::size_t> chosen;
  double longest = -1.0;
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = i + 1; j < 8; ++j)
      if (glm::distance(p[i], p[j]) > longest) {
        longest = glm::distance(p[i], p[j]);
        chosen = {i, j};
      }
  while (chosen.size() < 4) {
    std::size_t best = 8;
    double best_sum = -1.0;
    for (std::size_t i = 0; i < 8; ++i) {
      if (std::find(chosen.begin(), chosen.end(), i) != chosen.end()) continue;
      double sum = 0.0;
      for (const std::size_t c : chosen) sum += glm::distance(p[i], p[c]);
      if (sum > best_sum) std::tie(best, best_sum) = std::make_pair(i, sum);
    }
    chosen.push_back(best);
  }
  const auto small = [](std::size_t i) { return static_cast<std::uint8_t>(i); };
  return {small(chosen[0]), small(chosen[2]), small(chosen[1]), small(chosen[3])};
}

bake::ViewTotals totals_of(const NaiveScene& scene, const NaiveAreas& areas) {
  const std::uint32_t image_px = scene.options.resolution_px * scene.options.resolution_px;
  std::vector<std::uint32_t> totals_px;
  for (const std::uint32_t background_px : areas.background)
    totals_px.push_back(scene.options.count_background ? image_px : image_px - background_px);
  return bake::view_totals(totals_px);
}

}  // namespace

NaivePlant source_plant(const NaiveScene& scene) {
  NaivePlant plant;
  for (std::uint32_t i = 0; i < scene.source.leaf_count(); ++i) plant[i] = {scene.source.quads[i], scene.source.cards[i]};
  return plant;
}

NaiveAreas render_areas(const NaiveScene& scene, const NaivePlant& plant) {
  constexpr bake::LeafFragment kEmpty = ~bake::LeafFragment{0};
  const bake::Sphere sphere = bake::bounding_sphere(scene.source);
  const std::uint32_t side = scene.options.resolution_px;
  NaiveAreas areas;
  areas.background.resize(scene.views.size());
  for (const auto& [id, leaf] : plant) areas.leaves[id].resize(scene.views.size());
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const bake::Projection projection = bake::make_projection(scene.views[v], sphere, side);
    std::vector<bake::LeafFragment> front(std::size_t{side} * side, kEmpty);
    for (const auto& [id, leaf] : plant) {
      const bake::Card& card = scene.source.card_table[leaf.card];
      const auto draw = [&, leaf_id = id](const bake::QuadFragment& f) {
        bake::LeafFragment& pixel = front[static_cast<std::size_t>(f.y) * side + static_cast<std::size_t>(f.x)];
        pixel = std::min(pixel, bake::make_fragment(f.depth, leaf_id));
      };
      bake::rasterise_leaf(bake::project(projection, leaf.quad), card, scene.masks[card.material], projection.resolution_px, draw);
    }
    for (const bake::LeafFragment f : front) ++(f == kEmpty ? areas.background[v] : areas.leaves.at(bake::fragment_leaf(f))[v]);
  }
  return areas;
}

NaiveInformation information_of(const NaiveScene& scene, const NaiveAreas& areas) {
  const bake::ViewTotals totals = totals_of(scene, areas);
  NaiveInformation information;
  for (const auto& [id, row] : areas.leaves) {
    information.leaves[id] = bake::outcome_information(row, totals);
    information.sum += information.leaves[id];
  }
  if (scene.options.count_background) information.sum += bake::outcome_information(areas.background, totals);
  return information;
}

double information_by_definition(const NaiveScene& scene, const NaiveAreas& areas) {
  const std::size_t view_count = scene.views.size();
  std::vector<std::vector<std::uint32_t>> outcomes;
  for (const auto& [id, row] : areas.leaves) outcomes.push_back(row);
  if (scene.options.count_background) outcomes.push_back(areas.background);
  std::vector<double> total(view_count, 0.0);
  for (const auto& row : outcomes)
    for (std::size_t v = 0; v < view_count; ++v) total[v] += row[v];
  double sum = 0.0;
  for (const auto& row : outcomes) {
    double p_of_leaf = 0.0;
    for (std::size_t v = 0; v < view_count; ++v)
      if (row[v] > 0) p_of_leaf += row[v] / total[v] / static_cast<double>(view_count);
    for (std::size_t v = 0; v < view_count; ++v)
      if (row[v] > 0) sum += row[v] / total[v] * std::log2(row[v] / total[v] / p_of_leaf) / static_cast<double>(view_count);
  }
  return sum;
}

NaivePlant merged_plant(const NaivePlant& plant, const Merge& merge, std::uint32_t result) {
  const NaiveLeaf& first = plant.at(merge.first);
  const NaiveLeaf& second = plant.at(merge.second);
  NaiveLeaf leaf;
  for (std::size_t i = 0; i < 4; ++i)
    leaf.quad[i] = merge.corners[i] < 4 ? first.quad[merge.corners[i]] : second.quad[merge.corners[i] - 4u];
  leaf.card = area_of(second.quad) > area_of(first.quad) ? second.card : first.card;
  NaivePlant merged = plant;
  merged.erase(merge.first);
  merged.erase(merge.second);
  merged[result] = leaf;
  return merged;
}

bake::CollapseSequence naive_collapse(const NaiveScene& scene) {
  const Grid grid(scene.source);
  bake::CollapseSequence sequence;
  NaivePlant plant = source_plant(scene);
  for (std::uint32_t result = scene.source.leaf_count(); plant.size() > 1; ++result) {
    const NaiveInformation before = information_of(scene, render_areas(scene, plant));
    std::uint32_t chosen = before.leaves.begin()->first;
    for (const auto& [id, visibility] : before.leaves)
      if (visibility < before.leaves.at(chosen)) chosen = id;

    std::tuple<FixedBits, std::uint32_t> best_cost;
    Merge best;
    bool found = false;
    for (const std::uint32_t partner : candidates_of(grid, plant, chosen, scene.options.candidate_count)) {
      Merge merge{std::min(chosen, partner), std::max(chosen, partner), {}};
      merge.corners = corners_of(plant.at(merge.first).quad, plant.at(merge.second).quad);
      const NaiveInformation after = information_of(scene, render_areas(scene, merged_plant(plant, merge, result)));
      const std::tuple cost{std::abs(before.sum - after.sum), partner};
      ++sequence.evaluations;
      if (found && best_cost < cost) continue;
      found = true;
      best_cost = cost;
      best = merge;
    }
    sequence.merges.push_back(best);
    plant = merged_plant(plant, best, result);
  }
  return sequence;
}

}  // namespace coppice::test
