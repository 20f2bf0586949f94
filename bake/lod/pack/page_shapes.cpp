#include "page_shapes.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace coppice::bake {

namespace {

using page_model::Point;
using page_model::Shape;

struct Affine {
  double a = 0.0, b = 0.0;
};

bool near(const Affine& one, const Affine& other) {
  constexpr double kSame = 0.03;
  return std::abs(one.a - other.a) < kSame && std::abs(one.b - other.b) < kSame;
}

double dot(const Point& u, const Point& v) {
  return double(u[0]) * v[0] + double(u[1]) * v[1] + double(u[2]) * v[2];
}

/// Corner 3 by least squares from the other three, in steps of the box. Empty for a parallelogram, a sliver, and values that a Shape cannot
/// hold.
std::optional<Affine> affine_of(const QuantisedQuad& quad) {
  constexpr double kLargest = 7.9, kSliver = 1e-6;
  constexpr std::int32_t kRounding = 3;
  std::array<Point, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = page_model::point_of(quad[i]);
  const Point e = page_model::difference(corners[1], corners[0]), f = page_model::difference(corners[2], corners[0]);
  const Point g = page_model::difference(corners[3], corners[0]);
  bool parallelogram = true;
  for (std::size_t axis = 0; axis < 3; ++axis) parallelogram = parallelogram && std::abs(g[axis] - f[axis] + e[axis]) <= kRounding;
  const double determinant = dot(e, e) * dot(f, f) - dot(e, f) * dot(e, f);
  if (parallelogram || determinant <= kSliver * dot(e, e) * dot(f, f)) return {};
  const Affine affine{(dot(g, e) * dot(f, f) - dot(g, f) * dot(e, f)) / determinant,
                      (dot(g, f) * dot(e, e) - dot(g, e) * dot(e, f)) / determinant};
  if (std::abs(affine.a) > kLargest || std::abs(affine.b) > kLargest) return {};
  return affine;
}

/// Removes the largest cluster of `affines` and returns its mean; empty if it has fewer members than `min_count`.
std::optional<Affine> take_cluster(std::vector<Affine>& affines, std::size_t min_count) {
  const Affine* centre = nullptr;
  std::ptrdiff_t largest = 0;
  for (const Affine& candidate : affines) {
    const auto count = std::ranges::count_if(affines, [&](const Affine& affine) { return near(affine, candidate); });
    if (count <= largest) continue;
    largest = count;
    centre = &candidate;
  }
  if (centre == nullptr || static_cast<std::size_t>(largest) < min_count) return {};
  Affine sum;
  std::vector<Affine> others;
  for (const Affine& affine : affines) {
    if (near(affine, *centre)) {
      sum.a += affine.a;
      sum.b += affine.b;
    } else {
      others.push_back(affine);
    }
  }
  affines = std::move(others);
  return Affine{sum.a / static_cast<double>(largest), sum.b / static_cast<double>(largest)};
}

std::int16_t fixed_point(double value) {
  return static_cast<std::int16_t>(std::lround(value * page_model::kShapeOne));
}

}  // namespace

std::vector<Shape> common_shapes(std::span<const QuantisedQuad> quads) {
  constexpr std::size_t kMinShare = 20;  // one quad in so many
  std::vector<Affine> affines;
  for (const QuantisedQuad& quad : quads)
    if (const auto affine = affine_of(quad)) affines.push_back(*affine);
  std::vector<Shape> shapes = {page_model::kParallelogram};
  while (shapes.size() < page_model::kMaxShapes) {
    const auto cluster = take_cluster(affines, quads.size() / kMinShare + 2);
    if (!cluster) break;
    shapes.push_back({fixed_point(cluster->a), fixed_point(cluster->b)});
  }
  return shapes;
}

}  // namespace coppice::bake
