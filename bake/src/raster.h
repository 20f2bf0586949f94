#pragma once

// Which pixels a leaf quad covers in an orthographic view, how deep it is there and what it shows: the one rasteriser of the baker.
//
// Corners are rounded to 1/256 px. A pixel is covered by a triangle when its centre is inside, or on a top or left edge (rows go
// down; the rule of Direct3D and Vulkan), decided with exact integer edge functions: coverage is the same for either winding and
// any order, and two triangles that share an edge never share a pixel of it. A quad's two triangles are (0, 1, 2) and (0, 2, 3); a
// triangle that is edge-on covers nothing. Where a folded quad covers a pixel twice the nearer of its unmasked triangles counts, the
// first on a tie, so that a quad has at most one fragment per pixel.

#include <algorithm>
#include <array>
#include <cstdint>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "plant.h"
#include "viewpoints.h"

namespace coppice::bake {

inline constexpr std::uint32_t kMaxResolutionPx = 2048;
inline constexpr std::int32_t kSubpixels = 256;
inline constexpr double kDepthSteps = 2147483648.0;  ///< 2^31: depths are 0 (nearest point of the sphere) to this (farthest)

namespace detail {

/// std::floor and a cast, without the library call that baseline x86-64 makes of it. |value| must fit.
template <class Integer>
[[nodiscard]] inline Integer floor_to_int(double value) {
  const auto truncated = static_cast<Integer>(value);
  return truncated - (static_cast<double>(truncated) > value ? 1 : 0);
}

/// floor(numerator / denominator), exactly; denominator > 0. The product in double is off by at most one for our magnitudes (< 2^52).
[[nodiscard]] inline std::int64_t floor_quotient(std::int64_t numerator, std::int64_t denominator, double reciprocal) {
  auto quotient = floor_to_int<std::int64_t>(static_cast<double>(numerator) * reciprocal);
  if (quotient * denominator > numerator) --quotient;
  if ((quotient + 1) * denominator <= numerator) ++quotient;
  return quotient;
}

}  // namespace detail

/// World to image for one view. With centre c and radius r of the sphere and R = resolution_px, a world point p falls on
///   column  R/2 + dot(p - c, right) * R / (2r)
///   row     R/2 - dot(p - c, up) * R / (2r)        (row 0 is the top)
/// and pixel (x, y) samples column x + 1/2, row y + 1/2. A sphere of radius 0 puts everything in the middle.
struct Projection {
  std::array<double, 3> center{}, right{}, up{}, direction{};
  double px_per_metre = 0.0;
  double depth_per_metre = 0.0;
  std::int32_t resolution_px = 0;
};

/// resolution_px  1 .. kMaxResolutionPx
[[nodiscard]] inline Projection make_projection(const Viewpoint& view, const Sphere& sphere, std::uint32_t resolution_px) {
  const auto widen = [](const glm::vec3& v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  Projection projection{
      widen(sphere.center), widen(view.right), widen(view.up), widen(view.direction), 0.0, 0.0, static_cast<std::int32_t>(resolution_px)};
  if (sphere.radius > 0.0f) {
    projection.px_per_metre = resolution_px / (2.0 * sphere.radius);
    projection.depth_per_metre = kDepthSteps / (2.0 * sphere.radius);
  }
  return projection;
}

struct ProjectedPoint {
  std::int32_t x = 0, y = 0;  ///< 1/256 px, right and down from the image's top left corner
  double depth = 0.0;         ///< 0 .. kDepthSteps
};
using ProjectedQuad = std::array<ProjectedPoint, 4>;

[[nodiscard]] inline ProjectedPoint project(const Projection& projection, const glm::vec3& point) {
  const double x = point.x - projection.center[0], y = point.y - projection.center[1], z = point.z - projection.center[2];
  const auto along = [&](const std::array<double, 3>& axis) { return x * axis[0] + y * axis[1] + z * axis[2]; };
  const double middle = projection.resolution_px * 0.5;
  const auto fixed = [](double px) { return detail::floor_to_int<std::int32_t>(px * kSubpixels + 0.5); };
  return {fixed(middle + along(projection.right) * projection.px_per_metre), fixed(middle - along(projection.up) * projection.px_per_metre),
          kDepthSteps * 0.5 - along(projection.direction) * projection.depth_per_metre};
}

[[nodiscard]] inline ProjectedQuad project(const Projection& projection, const Quad& quad) {
  return {project(projection, quad[0]), project(projection, quad[1]), project(projection, quad[2]), project(projection, quad[3])};
}

/// Columns [first, last] of a row; empty when last < first.
struct Span {
  std::int32_t first = 0, last = -1;
};

/// One triangle of a quad, ready to be walked row by row.
class RasterTriangle {
 public:
  RasterTriangle(const ProjectedPoint& a, const ProjectedPoint& b, const ProjectedPoint& c) {
    const std::int64_t abx = b.x - a.x, aby = b.y - a.y, acx = c.x - a.x, acy = c.y - a.y;
    const std::int64_t doubled_area = abx * acy - aby * acx;
    if (doubled_area == 0) return;
    first_row_ = first_center(std::min({a.y, b.y, c.y}));
    last_row_ = last_center(std::max({a.y, b.y, c.y}));
    if (last_row_ < first_row_ || last_center(std::max({a.x, b.x, c.x})) < first_center(std::min({a.x, b.x, c.x}))) {
      last_row_ = first_row_ - 1;
      return;
    }
    set_edges(doubled_area > 0 ? std::array{a, b, c} : std::array{a, c, b});
    const double per_area = 1.0 / static_cast<double>(doubled_area);
    origin_x_ = a.x, origin_y_ = a.y;
    weight_b_ = {static_cast<double>(acy) * per_area, static_cast<double>(-acx) * per_area};
    weight_c_ = {static_cast<double>(-aby) * per_area, static_cast<double>(abx) * per_area};
    origin_depth_ = a.depth;
    depth_per_x_ = weight_b_[0] * (b.depth - a.depth) + weight_c_[0] * (c.depth - a.depth);
    depth_per_y_ = weight_b_[1] * (b.depth - a.depth) + weight_c_[1] * (c.depth - a.depth);
    depth_low_ = std::clamp(std::min({a.depth, b.depth, c.depth}), 0.0, kDepthSteps);
    depth_high_ = std::clamp(std::max({a.depth, b.depth, c.depth}), 0.0, kDepthSteps);
  }

  [[nodiscard]] std::int32_t first_row() const { return first_row_; }
  [[nodiscard]] std::int32_t last_row() const { return last_row_; }

  /// Covered columns of a row, within [0, width_px).
  [[nodiscard]] Span row(std::int32_t y, std::int32_t width_px) const {
    Span span{0, width_px - 1};
    if (y < first_row_ || y > last_row_) return {0, -1};
    for (const Edge& edge : edges_) {
      const std::int64_t at_column_0 = edge.constant + edge.per_row * y;
      if (edge.per_column > 0) {
        const std::int64_t first = -detail::floor_quotient(at_column_0, edge.per_column, edge.reciprocal);
        if (first > span.first) span.first = static_cast<std::int32_t>(std::min<std::int64_t>(first, width_px));
      } else if (edge.per_column < 0) {
        const std::int64_t last = detail::floor_quotient(at_column_0, -edge.per_column, edge.reciprocal);
        if (last < span.last) span.last = static_cast<std::int32_t>(std::max<std::int64_t>(last, -1));
      } else if (at_column_0 < 0) {
        return {0, -1};
      }
    }
    return span;
  }

  /// Weights of the triangle's corners at a pixel's centre; they sum to 1.
  [[nodiscard]] std::array<double, 3> weights(std::int32_t x, std::int32_t y) const {
    const double dx = x * kSubpixels + kSubpixels / 2 - origin_x_, dy = y * kSubpixels + kSubpixels / 2 - origin_y_;
    const double b = dx * weight_b_[0] + dy * weight_b_[1], c = dx * weight_c_[0] + dy * weight_c_[1];
    return {1.0 - b - c, b, c};
  }

  /// Quantised depth at a pixel's centre, 0 .. kDepthSteps; smaller is nearer. A function of triangle and pixel only.
  [[nodiscard]] std::uint32_t depth(std::int32_t x, std::int32_t y) const {
    const double dx = x * kSubpixels + kSubpixels / 2 - origin_x_, dy = y * kSubpixels + kSubpixels / 2 - origin_y_;
    const double depth = origin_depth_ + (dy * depth_per_y_ + dx * depth_per_x_);
    // A sliver's slopes amplify rounding: no pixel of a triangle is outside its corners' depths.
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(std::clamp(depth, depth_low_, depth_high_) + 0.5));
  }

 private:
  /// per_column * x + per_row * y + constant >= 0 inside, at pixel (x, y)'s centre, top-left rule included.
  struct Edge {
    std::int64_t per_column = 0, per_row = 0, constant = 0;
    double reciprocal = 0.0;  ///< 1 / |per_column|
  };

  static std::int32_t first_center(std::int32_t subpixels) { return (subpixels + kSubpixels / 2 - 1) >> 8; }
  static std::int32_t last_center(std::int32_t subpixels) { return (subpixels - kSubpixels / 2) >> 8; }

  void set_edges(const std::array<ProjectedPoint, 3>& corner) {
    for (std::size_t i = 0; i < 3; ++i) {
      const ProjectedPoint& from = corner[i];
      const ProjectedPoint& to = corner[(i + 1) % 3];
      const std::int64_t dx = to.x - from.x, dy = to.y - from.y;
      // Rows go down and the corners run clockwise on screen: a top edge runs right, a left edge runs up.
      const bool top_left = (dy == 0 && dx > 0) || dy < 0;
      Edge& edge = edges_[i];
      edge.per_column = -dy * kSubpixels;
      edge.per_row = dx * kSubpixels;
      edge.constant = dx * (kSubpixels / 2 - from.y) - dy * (kSubpixels / 2 - from.x) - (top_left ? 0 : 1);
      if (dy != 0) edge.reciprocal = 1.0 / static_cast<double>(edge.per_column < 0 ? -edge.per_column : edge.per_column);
    }
  }

  std::array<Edge, 3> edges_{};
  std::int32_t first_row_ = 0, last_row_ = -1;
  std::int32_t origin_x_ = 0, origin_y_ = 0;
  std::array<double, 2> weight_b_{}, weight_c_{};
  double origin_depth_ = 0.0, depth_per_x_ = 0.0, depth_per_y_ = 0.0, depth_low_ = 0.0, depth_high_ = 0.0;
};

/// One covered pixel of a quad.
struct QuadFragment {
  std::int32_t x = 0, y = 0;
  std::uint32_t depth = 0;     ///< smaller is nearer
  std::uint32_t triangle = 0;  ///< 0: corners 0 1 2; 1: corners 0 2 3
};

/// Interpolated texture coordinate of a card at a fragment of one of its quad's triangles.
[[nodiscard]] inline glm::dvec2 card_uv(const RasterTriangle& triangle, std::uint32_t index, const Card& card, std::int32_t x,
                                        std::int32_t y) {
  const std::array<double, 3> weight = triangle.weights(x, y);
  const glm::dvec2 a = card.uv[0], b = card.uv[index + 1], c = card.uv[index + 2];
  return a * weight[0] + b * weight[1] + c * weight[2];
}

/// Calls visit(QuadFragment) once for each pixel that the quad covers, row by row.
/// keep   bool(const RasterTriangle&, std::uint32_t triangle, std::int32_t x, std::int32_t y): false where the triangle has a hole
template <class Keep, class Visit>
void rasterise_quad(const ProjectedQuad& quad, std::int32_t resolution_px, Keep&& keep, Visit&& visit) {
  const std::array triangles{RasterTriangle(quad[0], quad[1], quad[2]), RasterTriangle(quad[0], quad[2], quad[3])};
  const auto emit = [&](std::uint32_t t, std::int32_t x, std::int32_t y) {
    if (keep(triangles[t], t, x, y)) visit(QuadFragment{x, y, triangles[t].depth(x, y), t});
  };
  const auto emit_nearer = [&](std::int32_t x, std::int32_t y) {
    if (!keep(triangles[0], 0u, x, y)) return emit(1, x, y);
    const std::uint32_t depth_0 = triangles[0].depth(x, y), depth_1 = triangles[1].depth(x, y);
    if (depth_1 < depth_0)
      return keep(triangles[1], 1u, x, y) ? visit(QuadFragment{x, y, depth_1, 1}) : visit(QuadFragment{x, y, depth_0, 0});
    visit(QuadFragment{x, y, depth_0, 0});
  };
  std::int32_t first_row = resolution_px, last_row = -1;
  for (const RasterTriangle& triangle : triangles) {
    if (triangle.last_row() < triangle.first_row()) continue;
    first_row = std::min(first_row, triangle.first_row());
    last_row = std::max(last_row, triangle.last_row());
  }
  for (std::int32_t y = std::max(first_row, 0); y <= std::min(last_row, resolution_px - 1); ++y) {
    const Span a = triangles[0].row(y, resolution_px), b = triangles[1].row(y, resolution_px);
    const Span both{std::max(a.first, b.first), std::min(a.last, b.last)};
    if (both.last < both.first) {
      for (std::int32_t x = a.first; x <= a.last; ++x) emit(0, x, y);
      for (std::int32_t x = b.first; x <= b.last; ++x) emit(1, x, y);
      continue;
    }
    for (std::int32_t x = std::min(a.first, b.first); x <= std::max(a.last, b.last); ++x) {
      if (x >= both.first && x <= both.last)
        emit_nearer(x, y);
      else
        emit(x >= a.first && x <= a.last ? 0 : 1, x, y);
    }
  }
}

}  // namespace coppice::bake
