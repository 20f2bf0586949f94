#include "wood_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "bounds.h"
#include "union_find.h"
#include "weld.h"
#include "wood_skeleton.h"

namespace coppice::bake {
namespace {

using Corners = std::array<glm::dvec3, 3>;

Corners corners_of(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices, std::size_t first) {
  return {positions[indices[first]], positions[indices[first + 1]], positions[indices[first + 2]]};
}

glm::dvec3 area_vector(const Corners& corner) {
  return 0.5 * glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
}

void append_samples(const Corners& corner, double spacing_m, int depth, std::vector<AreaSample>& samples) {
  std::size_t longest = 0;
  std::array<double, 3> edge_m{};
  for (std::size_t k = 0; k < 3; ++k) {
    edge_m[k] = glm::distance(corner[k], corner[(k + 1) % 3]);
    if (edge_m[k] > edge_m[longest]) longest = k;
  }
  if (depth > 0 && edge_m[longest] > spacing_m) {
    const glm::dvec3& from = corner[longest];
    const glm::dvec3& to = corner[(longest + 1) % 3];
    const glm::dvec3& apex = corner[(longest + 2) % 3];
    const glm::dvec3 middle = 0.5 * (from + to);
    append_samples({from, middle, apex}, spacing_m, depth - 1, samples);
    append_samples({middle, to, apex}, spacing_m, depth - 1, samples);
    return;
  }
  const double area_m2 = glm::length(area_vector(corner)) / 3.0;
  for (std::size_t k = 0; k < 3; ++k) samples.push_back({0.5 * (corner[k] + corner[(k + 1) % 3]), area_m2});
}

/// The direction in which a symmetric matrix stretches most, by power iteration; `fallback` if it stretches nothing.
glm::dvec3 main_direction(const glm::dmat3& matrix, const glm::dvec3& fallback) {
  constexpr int kIterations = 60;
  // No axis of a plant is perpendicular to this one.
  glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, 1.0, 0.2));
  for (int i = 0; i < kIterations; ++i) {
    const glm::dvec3 next = matrix * direction;
    const double length = glm::length(next);
    if (!(length > std::numeric_limits<double>::min())) return fallback;
    direction = next / length;
  }
  return direction;
}

glm::dvec3 across(const glm::dvec3& direction) {
  const glm::dvec3 other = std::abs(direction.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
  return glm::normalize(glm::cross(direction, other));
}

void set_axes(WoodPiece& piece, const std::vector<AreaSample>& samples) {
  glm::dmat3 covariance(0.0);
  for (const AreaSample& sample : samples) {
    const glm::dvec3 arm = sample.at - piece.center;
    covariance += sample.area_m2 / piece.area_m2 * glm::outerProduct(arm, arm);
  }
  piece.axes[0] = main_direction(covariance, piece.axes[0]);
  const auto variance = [&](std::size_t k) { return std::max(glm::dot(piece.axes[k], covariance * piece.axes[k]), 0.0); };
  const glm::dmat3 rest = covariance - variance(0) * glm::outerProduct(piece.axes[0], piece.axes[0]);
  const glm::dvec3 second = main_direction(rest, across(piece.axes[0]));
  const glm::dvec3 level = second - glm::dot(second, piece.axes[0]) * piece.axes[0];
  piece.axes[1] = glm::length(level) > 1e-6 ? glm::normalize(level) : across(piece.axes[0]);
  piece.axes[2] = glm::cross(piece.axes[0], piece.axes[1]);
  for (std::size_t k = 0; k < 3; ++k) piece.spread_m[k] = std::sqrt(variance(k));
}

void measure(WoodPiece& piece) {
  const std::vector<AreaSample> samples = area_samples(piece, std::numeric_limits<double>::infinity());
  piece.center = glm::dvec3(0.0), piece.area_m2 = 0.0, piece.facing = glm::dvec3(0.0);
  for (const AreaSample& sample : samples) {
    piece.center += sample.area_m2 * sample.at;
    piece.area_m2 += sample.area_m2;
  }
  if (piece.area_m2 > 0.0) {
    piece.center /= piece.area_m2;
    for (std::size_t i = 0; i < piece.indices.size(); i += 3)
      piece.facing += area_vector(corners_of(piece.positions, piece.indices, i)) / piece.area_m2;
    set_axes(piece, samples);
  } else {
    piece.center = piece.positions.front();
  }
  double sixfold_m3 = 0.0;
  for (std::size_t i = 0; i < piece.indices.size(); i += 3) {
    const auto arm = [&](std::size_t k) { return glm::dvec3(piece.positions[piece.indices[i + k]]) - piece.center; };
    sixfold_m3 += glm::dot(arm(0), glm::cross(arm(1), arm(2)));
  }
  piece.volume_m3 = std::abs(sixfold_m3) / 6.0;
  piece.projected_m2 = projected_area_m2(piece.area_m2, piece.facing);
  piece.first_m = piece.last_m = 0.0;
  for (const glm::vec3& position : piece.positions) {
    const double at_m = glm::dot(glm::dvec3(position) - piece.center, piece.axes[0]);
    piece.first_m = std::min(piece.first_m, at_m);
    piece.last_m = std::max(piece.last_m, at_m);
  }
}

/// The triangles of each number, as a piece.
/// numbers  [triangles] from 0
std::vector<WoodPiece> split_triangles(const WoodPiece& whole, const std::vector<std::uint32_t>& numbers) {
  std::vector<std::vector<std::size_t>> triangles;
  for (std::size_t t = 0; t < numbers.size(); ++t) {
    if (numbers[t] >= triangles.size()) triangles.resize(numbers[t] + std::size_t{1});
    triangles[numbers[t]].push_back(t);
  }
  std::vector<WoodPiece> pieces(triangles.size());
  std::vector<std::uint32_t> local(whole.positions.size(), kNone), local_piece(whole.positions.size(), kNone);
  for (std::uint32_t number = 0; number < pieces.size(); ++number) {
    WoodPiece& piece = pieces[number];
    piece.material = whole.material;
    for (const std::size_t t : triangles[number])
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t vertex = whole.indices[3 * t + k];
        if (std::exchange(local_piece[vertex], number) != number) {
          local[vertex] = static_cast<std::uint32_t>(piece.vertices.size());
          piece.vertices.push_back(whole.vertices[vertex]);
          piece.positions.push_back(whole.positions[vertex]);
        }
        piece.indices.push_back(local[vertex]);
      }
    if (!piece.indices.empty()) measure(piece);
  }
  return pieces;
}

std::vector<WoodPiece> connected_pieces(const Mesh& wood) {
  WoodPiece whole{.vertices = std::vector<std::uint32_t>(wood.positions.size()), .positions = wood.positions, .indices = wood.indices};
  std::iota(whole.vertices.begin(), whole.vertices.end(), 0u);
  const std::vector<std::uint32_t> one_group(wood.positions.size(), 0);
  const std::vector<std::uint32_t> welded = weld(wood.positions, one_group);
  UnionFind sets(welded.size());
  for (std::size_t i = 0; i < wood.indices.size(); i += 3)
    for (std::size_t k = 1; k < 3; ++k) sets.join(welded[wood.indices[i]], welded[wood.indices[i + k]]);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> piece_of;  // by set and material
  std::vector<std::uint32_t> numbers, materials;
  for (std::size_t t = 0; t < wood.triangle_materials.size(); ++t) {
    const std::uint32_t material = wood.triangle_materials[t], set = sets.find(welded[wood.indices[3 * t]]);
    const auto [found, is_new] = piece_of.try_emplace({set, material}, static_cast<std::uint32_t>(materials.size()));
    if (is_new) materials.push_back(material);
    numbers.push_back(found->second);
  }
  std::vector<WoodPiece> pieces = split_triangles(whole, numbers);
  for (std::size_t i = 0; i < pieces.size(); ++i) pieces[i].material = materials[i];
  return pieces;
}

struct TubeEnd {
  glm::dvec3 at{0.0}, outward{0.0};
  double girth_m = 0.0;
  double reach_m = 0.0;  ///< how far the next tube's end may be
  std::size_t piece = 0;
};

/// The edges that only one triangle has, as welded vertices.
std::vector<std::pair<std::uint32_t, std::uint32_t>> border_of(const WoodPiece& piece, const std::vector<std::uint32_t>& welded) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges, border;
  for (std::size_t i = 0; i < piece.indices.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(welded[piece.indices[i + k]], welded[piece.indices[i + (k + 1) % 3]]);
      if (low != high) edges.emplace_back(low, high);
    }
  std::ranges::sort(edges);
  for (std::size_t i = 0, next = 0; i < edges.size(); i = next) {
    while (next < edges.size() && edges[next] == edges[i]) ++next;
    if (next - i == 1) border.push_back(edges[i]);
  }
  return border;
}

/// The two open ends of a short tube, such as a ring of a palm's trunk; none if the piece is not open in two places.
std::vector<TubeEnd> rims_of(const WoodPiece& piece) {
  constexpr double kMinLength = 0.1;  // relative to the rims' girth; else it is flat, and no way leads through it
  const std::vector<std::uint32_t> welded = weld(piece.positions, std::vector<std::uint32_t>(piece.positions.size(), 0));
  const auto border = border_of(piece, welded);
  UnionFind sets(piece.positions.size());
  for (const auto& [from, to] : border) sets.join(from, to);
  struct Rim {
    glm::dvec3 sum_m2{0.0};
    double length_m = 0.0;
  };
  std::map<std::uint32_t, Rim> rims;
  for (const auto& [from, to] : border) {
    Rim& rim = rims[sets.find(from)];
    if (rims.size() > 2) return {};
    const glm::dvec3 a(piece.positions[from]), b(piece.positions[to]);
    rim.sum_m2 += glm::distance(a, b) * 0.5 * (a + b);
    rim.length_m += glm::distance(a, b);
  }
  if (rims.size() != 2) return {};
  std::vector<TubeEnd> ends;
  for (const auto& [set, rim] : rims) {
    const double girth_m = rim.length_m / std::numbers::pi;
    ends.push_back({rim.sum_m2 / rim.length_m, {}, girth_m, 0.5 * girth_m, 0});
  }
  const glm::dvec3 way = ends[1].at - ends[0].at;
  if (!(glm::length(way) > kMinLength * std::max(ends[0].girth_m, ends[1].girth_m))) return {};
  ends[1].outward = glm::normalize(way);
  ends[0].outward = -ends[1].outward;
  return ends;
}

/// The ends of tubes, sorted by x: ends that may touch are near each other. Pieces a few times as long as thick are tubes, be they open or
/// closed; shorter ones are if they are open at two ends.
std::vector<TubeEnd> tube_ends(const std::vector<WoodPiece>& pieces) {
  constexpr double kMinSlenderness = 3.0;
  std::vector<TubeEnd> ends;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const WoodPiece& piece = pieces[i];
    const double girth_m = piece.girth_m();
    if (!(piece.projected_m2 > 0.0)) continue;
    if (piece.length_m() < kMinSlenderness * girth_m) {
      for (TubeEnd& rim : rims_of(piece)) rim.piece = i, ends.push_back(rim);
      continue;
    }
    ends.push_back({piece.center + piece.first_m * piece.axes[0], -piece.axes[0], girth_m, girth_m, i});
    ends.push_back({piece.center + piece.last_m * piece.axes[0], piece.axes[0], girth_m, girth_m, i});
  }
  std::ranges::stable_sort(ends, [](const TubeEnd& a, const TubeEnd& b) { return a.at.x < b.at.x; });
  return ends;
}

bool continues(const TubeEnd& a, const TubeEnd& b) {
  constexpr double kMinCosine = 0.8, kMaxGirths = 2.0;
  if (a.piece == b.piece || glm::dot(a.outward, b.outward) > -kMinCosine) return false;
  if (std::max(a.girth_m, b.girth_m) > kMaxGirths * std::min(a.girth_m, b.girth_m)) return false;
  return glm::distance(a.at, b.at) < std::max(a.reach_m, b.reach_m);
}

/// How much less of two tubes is seen since the end of one is inside the other, on average over all directions.
double hidden_m2(const TubeEnd& a, const TubeEnd& b) {
  const double girth_m = std::min(a.girth_m, b.girth_m);
  return 0.25 * std::numbers::pi * girth_m * std::clamp(glm::dot(a.at - b.at, a.outward), 0.0, girth_m);
}

void append(WoodPiece& piece, const WoodPiece& other) {
  const auto first = static_cast<std::uint32_t>(piece.vertices.size());
  piece.vertices.insert(piece.vertices.end(), other.vertices.begin(), other.vertices.end());
  piece.positions.insert(piece.positions.end(), other.positions.begin(), other.positions.end());
  for (const std::uint32_t index : other.indices) piece.indices.push_back(first + index);
  piece.part_count += other.part_count;
}

/// Joins tubes whose ends meet, the nearest first; an end is joined once.
std::vector<WoodPiece> join_tubes(std::vector<WoodPiece> pieces) {
  const std::vector<TubeEnd> ends = tube_ends(pieces);
  double max_girth_m = 0.0;
  for (const TubeEnd& end : ends) max_girth_m = std::max(max_girth_m, end.girth_m);
  constexpr std::size_t kMaxLookedAt = 512;  // enough, unless the wood is one pile of sticks
  std::vector<std::tuple<double, std::size_t, std::size_t>> meetings;
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (std::size_t k = i + 1; k < std::min(ends.size(), i + kMaxLookedAt) && ends[k].at.x - ends[i].at.x < max_girth_m; ++k)
      if (pieces[ends[i].piece].material == pieces[ends[k].piece].material && continues(ends[i], ends[k]))
        meetings.emplace_back(glm::distance(ends[i].at, ends[k].at), i, k);
  std::ranges::sort(meetings);
  UnionFind chains(pieces.size());
  std::vector<bool> taken(ends.size(), false);
  std::vector<double> hidden(pieces.size(), 0.0);  // m2
  for (const auto& [distance_m, i, k] : meetings) {
    const auto one = static_cast<std::uint32_t>(ends[i].piece), other = static_cast<std::uint32_t>(ends[k].piece);
    if (taken[i] || taken[k] || chains.find(one) == chains.find(other)) continue;
    taken[i] = taken[k] = true;
    chains.join(one, other);
    hidden[one] += hidden_m2(ends[i], ends[k]);
  }
  std::vector<WoodPiece> joined;
  std::vector<double> joined_hidden;
  std::vector<std::size_t> place(pieces.size());
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    const std::uint32_t first = chains.find(i);
    if (first == i) {
      place[i] = joined.size();
      joined.push_back(std::move(pieces[i]));
      joined_hidden.push_back(hidden[i]);
    } else {
      append(joined[place[first]], pieces[i]);
      joined_hidden[place[first]] += hidden[i];
    }
  }
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (joined[i].part_count == 1) continue;
    measure(joined[i]);
    // As of a closed surface: their ends close each other.
    const double closed_m2 = projected_area_m2(joined[i].area_m2, glm::dvec3(0.0));
    joined[i].projected_m2 = std::max(closed_m2 - joined_hidden[i], 0.5 * closed_m2);
  }
  return joined;
}

/// A number of 30 bits that is similar for near places.
std::uint32_t morton_code(const glm::dvec3& place) {
  std::uint32_t code = 0;
  for (int bit = 9; bit >= 0; --bit)
    for (int axis = 0; axis < 3; ++axis)
      code = code << 1 | (static_cast<std::uint32_t>(std::clamp(place[axis], 0.0, 1.0) * 1023.0) >> bit & 1u);
  return code;
}

/// Sorting ranks by their reversed bits scatters them: any first few are spread over all.
std::uint32_t reversed_bits(std::uint32_t value) {
  std::uint32_t reversed = 0;
  for (int bit = 0; bit < 32; ++bit) reversed |= (value >> bit & 1u) << (31 - bit);
  return reversed;
}

void set_curve_ranks(std::vector<WoodPiece>& pieces) {
  PointBox<glm::dvec3> box;
  for (const WoodPiece& piece : pieces) box.add(piece.center);
  const glm::dvec3 extent = box.extent();
  const double side_m = std::max({extent.x, extent.y, extent.z, std::numeric_limits<double>::min()});
  std::vector<std::pair<std::uint32_t, std::uint32_t>> along;
  for (std::uint32_t i = 0; i < pieces.size(); ++i) along.emplace_back(morton_code((pieces[i].center - box.low) / side_m), i);
  std::ranges::sort(along);
  for (std::uint32_t rank = 0; rank < along.size(); ++rank) pieces[along[rank].second].curve_rank = rank;
}

}  // namespace

double WoodPiece::girth_m() const {
  return length_m() > 0.0 ? 4.0 * projected_m2 / (std::numbers::pi * length_m()) : 0.0;
}

double projected_area_m2(double area_m2, const glm::dvec3& facing) {
  return 0.25 * area_m2 * (1.0 + std::min(glm::length(facing), 1.0));
}

double projected_area_m2(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices) {
  glm::dvec3 sum(0.0);
  double area_m2 = 0.0;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const glm::dvec3 area = area_vector(corners_of(positions, indices, i));
    sum += area;
    area_m2 += glm::length(area);
  }
  return area_m2 > 0.0 ? projected_area_m2(area_m2, sum / area_m2) : 0.0;
}

std::vector<AreaSample> area_samples(const WoodPiece& piece, double spacing_m) {
  constexpr int kMaxSplits = 6;
  std::vector<AreaSample> samples;
  for (std::size_t i = 0; i < piece.indices.size(); i += 3)
    append_samples(corners_of(piece.positions, piece.indices, i), spacing_m, kMaxSplits, samples);
  return samples;
}

std::vector<WoodPiece> split_wood(const Mesh& wood) {
  return by_weight(join_tubes(connected_pieces(wood)));
}

std::vector<WoodPiece> limbs_of(const WoodPiece& piece) {
  // Rings as far apart as the piece is thick have no bumps. The other bound limits the time, and sheets have no thickness.
  constexpr double kMaxRings = 64.0;
  const double ring_m = std::max(piece.thickness_m(), piece.length_m() / kMaxRings);
  const Mesh surface{.positions = piece.positions, .indices = piece.indices};
  const auto box = box_of(piece.positions);
  std::vector<WoodPiece> limbs = split_triangles(piece, wood_limbs(surface, {box.low.y, box.high.y, false}, ring_m));
  std::erase_if(limbs, [](const WoodPiece& limb) { return limb.indices.empty(); });
  return limbs;
}

std::vector<WoodPiece> by_weight(std::vector<WoodPiece> pieces) {
  set_curve_ranks(pieces);
  std::vector<std::tuple<int, std::uint32_t, std::uint32_t>> order;
  for (std::uint32_t i = 0; i < pieces.size(); ++i) {
    constexpr int kWeightless = -100000;
    const double weight = pieces[i].weight();
    order.emplace_back(weight > 0.0 ? -static_cast<int>(std::floor(std::log2(weight))) : -kWeightless, reversed_bits(pieces[i].curve_rank),
                       i);
  }
  std::ranges::sort(order);
  std::vector<WoodPiece> sorted;
  sorted.reserve(pieces.size());
  for (const auto& [weight_class, rank, i] : order) sorted.push_back(std::move(pieces[i]));
  return sorted;
}

}  // namespace coppice::bake
