#include "wind_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include <glm/glm.hpp>

#include "bounds.h"
#include "frame_wind.h"
#include "leaf_cards.h"
#include "wind.h"
#include "wood_joints.h"

namespace coppice::test {
namespace {

using gpu::PlantWind;
using gpu::Sway;

constexpr int kMoments = 24;
constexpr float kGale_mps = 25.0f;

/// Where a place of a triangle is, by its corners.
struct OnWood {
  std::array<glm::vec3, 3> corners{};
  glm::dvec3 shares{1.0, 0.0, 0.0};
  double distance_m = std::numeric_limits<double>::infinity();
};

/// The nearest place of a triangle (Ericson, Real-Time Collision Detection, 5.1.5), as shares of its corners.
glm::dvec3 nearest_shares(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp), d5 = glm::dot(ab, cp),
               d6 = glm::dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / (d4 - d3 + d5 - d6);
    return {0, 1 - w, w};
  }
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

/// The wood's triangles, with spheres that tell most of them to be farther away than what has been found.
class Wood {
 public:
  explicit Wood(const bake::Mesh& mesh) {
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const std::array corners{mesh.positions[mesh.indices[i]], mesh.positions[mesh.indices[i + 1]], mesh.positions[mesh.indices[i + 2]]};
      const glm::vec3 middle = (corners[0] + corners[1] + corners[2]) / 3.0f;
      float radius_m = 0.0f;
      for (const glm::vec3& corner : corners) radius_m = std::max(radius_m, glm::distance(corner, middle));
      triangles_.push_back({corners, middle, radius_m});
    }
  }
  [[nodiscard]] OnWood nearest(const glm::dvec3& place) const {
    OnWood found;
    const glm::vec3 from(place);
    for (const Triangle& triangle : triangles_) {
      if (glm::distance(triangle.middle, from) - triangle.radius_m > found.distance_m) continue;
      const glm::dvec3 a(triangle.corners[0]), b(triangle.corners[1]), c(triangle.corners[2]);
      const glm::dvec3 shares = nearest_shares(place, a, b, c);
      const double distance_m = glm::distance(place, shares.x * a + shares.y * b + shares.z * c);
      if (!(distance_m < found.distance_m)) continue;  // not so of a triangle without area
      found = {triangle.corners, shares, distance_m};
    }
    return found;
  }

 private:
  struct Triangle {
    std::array<glm::vec3, 3> corners;
    glm::vec3 middle;
    float radius_m;
  };
  std::vector<Triangle> triangles_;
};

/// The field as shaders have it.
class Field {
 public:
  explicit Field(const bake::Wind& wind) : words_(gpu::kWindWord + wind_word_count({wind.head, wind.nodes})) {
    pack_wind({wind.head, wind.nodes}, std::span(words_).subspan(gpu::kWindWord));
    table_.words = words_.data();
    plant_ = gpu::plant_wind(table_);
  }
  [[nodiscard]] glm::dvec3 offset(const glm::vec3& at, const Sway& sway) const {
    gpu::WindGradient unused;
    const vec3 moved = gpu::wind_offset(gpu::wind_place(table_, plant_, {at.x, at.y, at.z}, unused), sway);
    return {moved.x, moved.y, moved.z};
  }
  [[nodiscard]] double volume(const glm::vec3& at, const Sway& sway) const {
    gpu::WindGradient gradient;
    static_cast<void>(gpu::wind_place(table_, plant_, {at.x, at.y, at.z}, gradient));
    const vec3 x = gpu::grid_offset(gradient.grid_x, sway),
               y = gpu::grid_offset(gradient.grid_y, sway) + gpu::bend_offset(gradient.bend_y, sway),
               z = gpu::grid_offset(gradient.grid_z, sway);
    return glm::determinant(glm::dmat3(1.0) + glm::dmat3({x.x, x.y, x.z}, {y.x, y.y, y.z}, {z.x, z.y, z.z}));
  }
  [[nodiscard]] const PlantWind& plant() const { return plant_; }

 private:
  std::vector<std::uint32_t> words_;
  lod::CoppiceTable table_{};
  PlantWind plant_{};
};

/// Moments of a wind; every second one has gusts if `gusty` is above 0.
std::vector<Sway> moments(const PlantWind& field, float speed_mps, float gusty) {
  std::vector<Sway> all;
  for (int i = 0; i < kMoments; ++i) {
    const float turn = 2.4f * static_cast<float>(i);
    const coppice_wind wind{.struct_size = sizeof(coppice_wind),
                            .direction = {std::cos(turn), 0.0f, std::sin(turn)},
                            .speed = speed_mps,
                            .gustiness = i % 2 == 0 ? 0.0f : gusty,
                            .time_s = 1.37 * i};
    all.push_back(gpu::sway_of(wind_now({wind}, {0, 0, 0}), field, {0, 0, 0, 1}, {0, 0, 0}, {0, 0, 0}));
  }
  return all;
}

/// What takes as much room as these, but for a factor.
double spread(std::span<const glm::dvec3> places) {
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& place : places) mean += place / static_cast<double>(places.size());
  glm::dmat3 sum(0.0);
  for (const glm::dvec3& place : places) sum += glm::outerProduct(place - mean, place - mean) / static_cast<double>(places.size());
  return std::sqrt(std::max(glm::determinant(sum), 0.0));
}

double value_at(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

/// One of the leaves that are looked at.
struct Leaf {
  glm::dvec3 stalk{0.0}, middle{0.0};
  double length_m = 0.0;
  OnWood wood;
};

std::vector<Leaf> leaves_of(std::span<const bake::Quad> quads, const bake::Mesh& wood_mesh, std::uint32_t most) {
  const Wood wood(wood_mesh);
  std::vector<Leaf> leaves;
  const std::size_t step = (quads.size() + most - 1) / std::max(most, 1u);
  for (std::size_t i = 0; i < quads.size(); i += std::max<std::size_t>(step, 1)) {
    const bake::Quad& quad = quads[i];
    const glm::dvec3 stalk = 0.5 * (glm::dvec3(quad[0]) + glm::dvec3(quad[3])), tip = 0.5 * (glm::dvec3(quad[1]) + glm::dvec3(quad[2]));
    leaves.push_back({stalk, 0.5 * (stalk + tip), glm::distance(stalk, tip), wood.nearest(stalk)});
  }
  return leaves;
}

/// The largest change of an edge's length, as a share. Of many triangles some are looked at, evenly.
double stretch_of(const bake::Mesh& mesh, const Field& field, std::span<const Sway> sways) {
  constexpr std::size_t kMaxTriangles = 2000;
  const std::size_t step = 3 * (mesh.indices.size() / 3 / kMaxTriangles + 1);
  double largest = 0.0;
  for (std::size_t first = 0; first < mesh.indices.size(); first += step) {
    const auto corners = bake::at_corners(mesh.positions, mesh.indices, first);
    for (const Sway& sway : sways)
      for (std::size_t i = 0; i < 3; ++i) {
        const glm::vec3 &from = corners[i], &to = corners[(i + 1) % 3];
        const glm::dvec3 edge = glm::dvec3(to) - glm::dvec3(from), moved = edge + field.offset(to, sway) - field.offset(from, sway);
        if (glm::length(edge) > 0.0) largest = std::max(largest, std::abs(glm::length(moved) / glm::length(edge) - 1.0));
      }
  }
  return largest;
}

void add_bending(const bake::Plant& plant, std::span<const bake::Quad> quads, const Field& field, WindFigures& figures) {
  std::vector<glm::vec3> places = plant.wood.positions;
  for (const bake::Quad& quad : quads) places.insert(places.end(), quad.begin(), quad.end());
  const glm::vec3 tip = *std::ranges::max_element(places, {}, &glm::vec3::y);
  for (std::size_t i = 0; i < kTipWinds_mps.size(); ++i)
    for (const Sway& sway : moments(field.plant(), kTipWinds_mps[i], 0.0f))
      figures.tip_shares[i] = std::max(figures.tip_shares[i], glm::length(field.offset(tip, sway)) * double{field.plant().per_height_m});
  const std::vector<Sway> sways = moments(field.plant(), kTipWinds_mps.back(), 0.0f);
  figures.stretch_max = std::max(stretch_of(plant.wood, field, sways), stretch_of(plant.foliage, field, sways));
}

}  // namespace

WindFigures wind_figures(bake::Plant plant, std::uint32_t max_leaves) {
  bake::Foliage foliage;
  if (plant.leaves.empty()) {
    foliage.quads.emplace_back().fill(plant.wood.positions.front());
  } else {
    auto made = bake::card_foliage(plant);
    if (!made) throw std::runtime_error(made.error().message());
    foliage = std::move(*made);
  }
  const bake::Sphere sphere = bake::plant_sphere(foliage, plant.wood);
  const bake::Wind wind = bake::wind_of({plant.wood, plant.foliage, plant.leaves, foliage.quads, sphere}, {});
  bake::add_joints(wind.head, plant.wood);
  WindFigures figures{.radius_m = sphere.radius,
                      .bend_share = double{wind.head.bend_m} / wind.head.height_m,
                      .reach_m = max_wind_move_m({wind.head, wind.nodes}),
                      .growth = max_wind_growth({wind.head, wind.nodes})};
  const std::vector<Leaf> leaves = leaves_of(std::span<const bake::Quad>(foliage.quads).first(plant.leaves.size()), plant.wood, max_leaves);
  const Field field(wind);
  std::vector<double> gaps(leaves.size(), 0.0), moves_m(leaves.size(), 0.0);
  std::vector<glm::dvec3> at_rest, moved(leaves.size());
  for (const Leaf& leaf : leaves) at_rest.push_back(leaf.middle);
  add_bending(plant, foliage.quads, field, figures);
  for (const Sway& sway : moments(field.plant(), kGale_mps, 0.5f)) {
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      const Leaf& leaf = leaves[i];
      const glm::dvec3 by = field.offset(glm::vec3(leaf.stalk), sway);
      moved[i] = leaf.middle + field.offset(glm::vec3(leaf.middle), sway);
      moves_m[i] = std::max(moves_m[i], glm::length(by));
      figures.squeeze_max = std::max(figures.squeeze_max, std::abs(field.volume(glm::vec3(leaf.middle), sway) - 1.0));
      if (plant.wood.indices.empty() || !(leaf.length_m > 0.0)) continue;
      glm::dvec3 wood(0.0);
      for (int corner = 0; corner < 3; ++corner) {
        const glm::vec3& at = leaf.wood.corners[static_cast<std::size_t>(corner)];
        wood += leaf.wood.shares[corner] * (glm::dvec3(at) + field.offset(at, sway));
      }
      const double gap_m = glm::distance(leaf.stalk + by, wood);
      gaps[i] = std::max(gaps[i], std::abs(gap_m - leaf.wood.distance_m) / std::max(leaf.length_m, leaf.wood.distance_m));
    }
    if (const double rest = spread(at_rest); rest > 1e-6 * std::pow(double{sphere.radius}, 3))  // not a crown that is flat
      figures.volume_max = std::max(figures.volume_max, std::abs(spread(moved) / rest - 1.0));
  }
  figures.move_median_m = value_at(moves_m, 0.5);
  figures.move_max_m = value_at(moves_m, 1.0);
  figures.gap_median = value_at(gaps, 0.5);
  figures.gap_99 = value_at(gaps, 0.99);
  figures.gap_max = value_at(gaps, 1.0);
  return figures;
}

}  // namespace coppice::test
