#include "quad_match.h"

#include <limits>

#include <glm/geometric.hpp>

#include "quad_merge.h"

namespace coppice::bake {
namespace {

using Ring = std::array<std::uint8_t, 4>;
using EightPoints = std::array<glm::dvec3, 8>;

glm::dvec3 area_vector(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
  return 0.5 * glm::cross(c - a, d - b);
}

/// What the two leaves are together, and how far a ring is from it.
struct Target {
  double area = 0.0;
  glm::dvec3 area_vector{0.0};
  glm::dvec3 centroid{0.0};

  Target(const Quad& first, const Quad& second) {
    const double first_area = quad_area(first), second_area = quad_area(second);
    const auto vector_of = [](const Quad& q) { return bake::area_vector(q[0], q[1], q[2], q[3]); };
    area = first_area + second_area;
    const glm::dvec3 a = vector_of(first), b = vector_of(second);
    area_vector = glm::dot(a, b) < 0.0 ? a - b : a + b;
    const double share = area > 0.0 ? first_area / area : 0.5;
    centroid = quad_centroid(first) * share + quad_centroid(second) * (1.0 - share);
  }

  [[nodiscard]] double distance(const EightPoints& p, const Ring& r) const {
    const glm::dvec3 &a = p[r[0]], &b = p[r[1]], &c = p[r[2]], &d = p[r[3]];
    const double ring_area = 0.5 * (glm::length(glm::cross(b - a, c - a)) + glm::length(glm::cross(c - a, d - a)));
    const glm::dvec3 n = bake::area_vector(a, b, c, d);
    const glm::dvec3 turned = glm::dot(n, area_vector) < 0.0 ? n + area_vector : n - area_vector;
    const glm::dvec3 offset = (a + b + c + d) * 0.25 - centroid;
    return (ring_area - area) * (ring_area - area) + glm::dot(turned, turned) + area * glm::dot(offset, offset);
  }
};

Ring best_ring(const EightPoints& points, const Target& target) {
  Ring best{0, 1, 2, 3};
  double best_distance = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Ring& ring) {
    const double distance = target.distance(points, ring);
    if (distance < best_distance) best = ring, best_distance = distance;
  };
  for (std::uint8_t i = 0; i < 8; ++i)
    for (auto j = static_cast<std::uint8_t>(i + 1); j < 8; ++j)
      for (auto k = static_cast<std::uint8_t>(j + 1); k < 8; ++k)
        for (auto l = static_cast<std::uint8_t>(k + 1); l < 8; ++l)
          for (const Ring& ring : {Ring{i, j, k, l}, Ring{i, k, j, l}, Ring{i, j, l, k}}) consider(ring);
  return best;
}

/// The same ring, begun and turned so that its corners point where those of `like` do.
Ring aligned(const EightPoints& points, const Ring& ring, const Quad& like) {
  const glm::dvec3 center = (points[ring[0]] + points[ring[1]] + points[ring[2]] + points[ring[3]]) * 0.25;
  const glm::dvec3 like_center = quad_centroid(like);
  Ring best = ring;
  double best_agreement = -std::numeric_limits<double>::infinity();
  for (const std::size_t step : {std::size_t{1}, std::size_t{3}}) {
    for (std::size_t start = 0; start < 4; ++start) {
      Ring turned{};
      double agreement = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        turned[i] = ring[(start + i * step) % 4];
        agreement += glm::dot(points[turned[i]] - center, glm::dvec3(like[i]) - like_center);
      }
      if (agreement > best_agreement) best = turned, best_agreement = agreement;
    }
  }
  return best;
}

}  // namespace

std::array<std::uint8_t, 4> matching_corners(const Quad& first, const Quad& second) {
  EightPoints points;
  for (std::size_t i = 0; i < 4; ++i) {
    points[i] = first[i];
    points[i + 4] = second[i];
  }
  const Ring ring = best_ring(points, Target(first, second));
  return aligned(points, ring, quad_area(second) > quad_area(first) ? second : first);
}

}  // namespace coppice::bake
