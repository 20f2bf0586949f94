#include "normal_sum.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "tree.h"

namespace coppice::bake {
namespace {

struct Eigen {
  std::array<double, 3> values{};
  glm::dmat3 vectors{1.0};  ///< columns
};

/// Jacobi's method: rotations that make the off-diagonal entries 0, one after another. Three entries converge quadratically, so that six
/// sweeps leave nothing.
Eigen eigen_of(glm::dmat3 m) {
  Eigen eigen;
  for (int sweep = 0; sweep < 6; ++sweep)
    for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      if (m[p][q] == 0.0) continue;
      const double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
      const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
      const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
      glm::dmat3 turn(1.0);
      turn[p][p] = turn[q][q] = c, turn[q][p] = s, turn[p][q] = -s;
      m = glm::transpose(turn) * m * turn;
      m[p][q] = m[q][p] = 0.0;
      eigen.vectors = eigen.vectors * turn;
    }
  for (int i = 0; i < 3; ++i) eigen.values[static_cast<std::size_t>(i)] = m[i][i];
  return eigen;
}

std::uint32_t axis_step(double share, std::uint32_t bits) {
  const long half = 1l << (bits - 1);
  return axis_step_from(static_cast<std::uint32_t>(half + std::lround(std::clamp(share, -1.0, 1.0) * static_cast<double>(half - 1))), bits);
}

}  // namespace

NormalSum& NormalSum::operator+=(const NormalSum& other) {
  for (std::size_t i = 0; i < second.size(); ++i) second[i] += other.second[i];
  first += other.first;
  return *this;
}

NormalSum NormalSum::operator*(double factor) const {
  NormalSum sum = *this;
  for (double& value : sum.second) value *= factor;
  sum.first *= factor;
  return sum;
}

NormalSum normal_sum(const glm::dvec3& n, double area_m2, bool is_sided, double along) {
  const double across = 0.5 * (1.0 - along) * area_m2, bend = along * area_m2 - across;
  return {{across + bend * n.x * n.x, across + bend * n.y * n.y, across + bend * n.z * n.z, bend * n.x * n.y, bend * n.x * n.z,
           bend * n.y * n.z},
          is_sided ? area_m2 * std::sqrt(along) * n : glm::dvec3(0.0)};
}

NormalSum quad_normal_sum(const std::array<glm::vec3, 4>& quad) {
  NormalSum sum;
  for (const std::size_t second : {std::size_t{1}, std::size_t{2}}) {
    const glm::dvec3 across = glm::cross(glm::dvec3(quad[second] - quad[0]), glm::dvec3(quad[second + 1] - quad[0]));
    const double twice_m2 = glm::length(across);
    if (twice_m2 > 0.0) sum += normal_sum(across / twice_m2, 0.5 * twice_m2);
  }
  return sum;
}

std::uint16_t node_normals(const NormalSum& sum, const glm::dvec3& usual_axis) {
  constexpr double kMinUsualCosine = 0.99;  // 8 degrees
  const auto& [xx, yy, zz, xy, xz, yz] = sum.second;
  const double area_m2 = xx + yy + zz;
  if (!(area_m2 > 0.0)) return kFlatNormals;
  const Eigen eigen = eigen_of(glm::dmat3(xx, xy, xz, xy, yy, yz, xz, yz, zz) / area_m2);
  const auto& values = eigen.values;
  const auto largest = std::ranges::max_element(values) - values.begin(), smallest = std::ranges::min_element(values) - values.begin();
  const double largest_value = values[static_cast<std::size_t>(largest)], smallest_value = values[static_cast<std::size_t>(smallest)];
  const double middle_value = values[0] + values[1] + values[2] - largest_value - smallest_value;
  const auto at = middle_value - smallest_value <= largest_value - middle_value ? largest : smallest;
  glm::dvec3 axis = eigen.vectors[static_cast<int>(at)];
  if (std::abs(glm::dot(axis, usual_axis)) > kMinUsualCosine) axis = usual_axis;
  if (axis.y < 0.0 || (axis.y == 0.0 && axis.x < 0.0)) axis = -axis;

  // A quarter of what normals of one side would give: leaves of both sides, or without sides, have no front.
  const double along = std::clamp(values[static_cast<std::size_t>(at)], 0.0, 1.0);
  const double front = glm::dot(sum.first, axis) / area_m2, sided = 0.25 * std::sqrt(along);
  const NormalSide side = front > sided ? NormalSide::along : front < -sided ? NormalSide::against : NormalSide::either;
  const glm::dvec3 p = axis / (std::abs(axis.x) + std::abs(axis.y) + std::abs(axis.z));
  const auto along_step = static_cast<std::uint32_t>(std::lround(along * kAlongSteps));
  const std::uint32_t bits = axis_bits(along_step);
  return pack_normals(axis_step(p.x + p.z, bits), axis_step(p.x - p.z, bits), along_step, side);
}

}  // namespace coppice::bake
