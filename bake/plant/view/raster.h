#pragma once

// The baker's one rasteriser: which pixels a leaf quad covers in a view, how deep it is there and what it shows.
//
// Corners are rounded to 1/256 px. A pixel is covered by a triangle when its centre is inside, or on a top or left edge (rows go
// down; the rule of Direct3D and Vulkan), decided with exact integer edge functions: coverage is the same for either winding and
// any order, and two triangles that share an edge never share a pixel of it. A quad's two triangles are (0, 1, 2) and (0, 2, 3); a
// triangle that is edge-on covers nothing. Where a folded quad covers a pixel twice the nearer of its unmasked triangles counts, the
// first on a tie, so that a quad has at most one fragment per pixel.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "floor_to_int.h"
#include "plant.h"
#include "viewpoints.h"

namespace coppice::bake {

inline constexpr std::uint32_t kMaxResolutionPx = 2048;
inline constexpr std::int32_t kSubpixels = 256;
inline constexpr std::int32_t kHalfPixel = kSubpixels / 2;  ///< subpixels
inline constexpr double kDepthSteps = 2147483648.0;         ///< 2^31: depths are 0 (nearest point of the sphere) to this (farthest)

/// World to image for one view. With centre c and radius r of the sphere and R = resolution_px, a world point p falls on
///   column  R/2 + dot(p - c, right) * R / (2r)
///   row     R/2 - dot(p - c, up) * R / (2r)        (row 0 is the top)
/// and pixel (x, y) samples column x + 1/2, row y + 1/2. A sphere of radius 0 puts everything in the middle. From an eye e metres from c
/// R / (2r) becomes sqrt(e^2 / r^2 - 1) R / 2 / z with z = e - dot(p - c, direction), and depth a line in 1 / z: planes stay planes.
struct Projection {
  std::array<double, 3> center{}, right{}, up{}, direction{};
  double px_per_metre = 0.0;
  double depth_per_metre = 0.0;
  std::int32_t resolution_px = 0;
  double eye_m = 0.0;  ///< 0: orthographic
  double px_at_1_m = 0.0;
  double nearest_reciprocal = 0.0, depth_per_reciprocal = 0.0;  ///< depth is (nearest - 1 / z) * per
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
  if (sphere.radius > 0.0f && view.distance_radii > 0.0f) {
    const double distance = view.distance_radii, radius_m = sphere.radius;
    projection.eye_m = distance * radius_m;
    projection.px_at_1_m = std::sqrt(distance * distance - 1.0) * resolution_px / 2.0;
    projection.nearest_reciprocal = 1.0 / (projection.eye_m - radius_m);
    projection.depth_per_reciprocal = kDepthSteps / (projection.nearest_reciprocal - 1.0 / (projection.eye_m + radius_m));
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
  const auto fixed = [](double px) { return floor_to_int<std::int32_t>(px * kSubpixels + 0.5); };
  if (projection.eye_m > 0.0) {
    const double reciprocal = 1.0 / (projection.eye_m - along(projection.direction)), px_per_metre = projection.px_at_1_m * reciprocal;
    return {fixed(middle + along(projection.right) * px_per_metre), fixed(middle - along(projection.up) * px_per_metre),
            (projection.nearest_reciprocal - reciprocal) * projection.depth_per_reciprocal};
  }
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

/// Quantised depths of a triangle at the pixel centres of one row, 0 .. kDepthSteps; smaller is nearer.
struct DepthRow {
  std::int32_t origin_x = 0;  ///< 1/256 px
  double origin = 0.0, row_offset = 0.0, per_x = 0.0, low = 0.0, high = 0.0;

  [[nodiscard]] std::uint32_t at(std::int32_t x) const { return static_cast<std::uint32_t>(static_cast<std::int64_t>(unfloored(x))); }
  /// at(x) < than
  [[nodiscard]] bool is_nearer(std::int32_t x, std::uint32_t than) const { return unfloored(x) < static_cast<double>(than); }

 private:
  [[nodiscard]] double unfloored(std::int32_t x) const {
    const double dx = x * kSubpixels + kHalfPixel - origin_x;
    // A sliver's slopes amplify rounding: no pixel of a triangle is outside its corners' depths.
    return std::clamp(origin + (row_offset + dx * per_x), low, high) + 0.5;
  }
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
    if (y < first_row_ || y > last_row_) return {0, -1};
    const Pair left = edges_.left.columns(y), right = edges_.right.columns(y);
    const double first = std::max(-std::min(left[0], left[1]), 0.0);
    const double last = std::min(std::min(right[0], right[1]), width_px - 1.0);
    return last < first ? Span{} : Span{static_cast<std::int32_t>(first), static_cast<std::int32_t>(last)};
  }

  /// Weights of the triangle's corners at a pixel's centre; they sum to 1.
  [[nodiscard]] std::array<double, 3> weights(std::int32_t x, std::int32_t y) const {
    const double dx = x * kSubpixels + kHalfPixel - origin_x_, dy = y * kSubpixels + kHalfPixel - origin_y_;
    const double b = dx * weight_b_[0] + dy * weight_b_[1], c = dx * weight_c_[0] + dy * weight_c_[1];
    return {1.0 - b - c, b, c};
  }

  /// Depths along row y: functions of triangle and pixel only.
  [[nodiscard]] DepthRow depths(std::int32_t y) const {
    const double dy = y * kSubpixels + kHalfPixel - origin_y_;
    return {origin_x_, origin_depth_, dy * depth_per_y_, depth_per_x_, depth_low_, depth_high_};
  }
  [[nodiscard]] std::uint32_t depth(std::int32_t x, std::int32_t y) const { return depths(y).at(x); }

 private:
  /// Two doubles in one register of baseline x86-64; a comparison gives all ones where it holds.
  using Pair = double __attribute__((vector_size(16)));
  using PairMask = std::int64_t __attribute__((vector_size(16)));

  /// Up to two edges of one side of a triangle.
  struct Edges {
    Pair per_row{}, constant{}, denominator{1.0, 1.0}, reciprocal{1.0, 1.0};

    /// floor((per_row * y + constant) / denominator), exactly. All of these doubles are whole and below 2^53, and rounding to the nearest
    /// gives the floor or one more, so the comparison that tells which is exact too.
    [[nodiscard]] Pair columns(std::int32_t y) const {
      constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: added to a double, it leaves no bit below 1
      constexpr Pair kOne{1.0, 1.0};
      const Pair numerator = per_row * static_cast<double>(y) + constant;
      const Pair nearest = (numerator * reciprocal + kRound) - kRound;
      const PairMask is_above = nearest * denominator > numerator;
      return nearest - reinterpret_cast<Pair>(is_above & reinterpret_cast<PairMask>(kOne));
    }
  };
  /// A pixel's centre is inside, top-left rule included, where -x <= columns(y) of the left edges and x <= columns(y) of the right ones.
  struct Sides {
    Edges left, right{{}, {kMaxResolutionPx, kMaxResolutionPx}};
  };

  static std::int32_t first_center(std::int32_t subpixels) { return (subpixels + kHalfPixel - 1) >> 8; }
  static std::int32_t last_center(std::int32_t subpixels) { return (subpixels - kHalfPixel) >> 8; }

  void set_edges(const std::array<ProjectedPoint, 3>& corner) {
    constexpr double kLevel = 1.0 / 1048576.0;
    std::size_t left_count = 0, right_count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const ProjectedPoint& from = corner[i];
      const ProjectedPoint& to = corner[(i + 1) % 3];
      const std::int64_t dx = to.x - from.x, dy = to.y - from.y;
      // Rows go down and the corners run clockwise on screen: a top edge runs right, a left edge runs up.
      const bool top_left = (dy == 0 && dx > 0) || dy < 0;
      // A level edge excludes rows, never columns: it is a left edge whose denominator carries what is below 0 past every column.
      Edges& side = dy > 0 ? edges_.right : edges_.left;
      const std::size_t slot = (dy > 0 ? right_count : left_count)++;
      side.denominator[slot] = dy == 0 ? kLevel : static_cast<double>((dy < 0 ? -dy : dy) * kSubpixels);
      side.reciprocal[slot] = 1.0 / side.denominator[slot];
      side.per_row[slot] = static_cast<double>(dx * kSubpixels);
      side.constant[slot] = static_cast<double>(dx * (kHalfPixel - from.y) - dy * (kHalfPixel - from.x) - (top_left ? 0 : 1));
    }
  }

  Sides edges_;
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

/// The two triangles of a quad, ready to be walked.
struct RasterQuad {
  explicit RasterQuad(const ProjectedQuad& quad)
      : triangles{RasterTriangle(quad[0], quad[1], quad[2]), RasterTriangle(quad[0], quad[2], quad[3])} {}
  std::array<RasterTriangle, 2> triangles;
};

/// Pixels [first, last] of row y that the same triangles cover.
struct PixelRun {
  std::int32_t y = 0, first = 0, last = -1;
  std::uint32_t triangle = 0;  ///< the one that covers them
  bool folded = false;         ///< both do
};

/// Calls visit(PixelRun) for runs that hold every pixel of the quad exactly once, row by row. No run is empty.
template <class Visit>
void for_each_run(const RasterQuad& quad, std::int32_t resolution_px, Visit&& visit) {
  std::int32_t first_row = resolution_px, last_row = -1;
  for (const RasterTriangle& triangle : quad.triangles) {
    if (triangle.last_row() < triangle.first_row()) continue;
    first_row = std::min(first_row, triangle.first_row());
    last_row = std::max(last_row, triangle.last_row());
  }
  for (std::int32_t y = std::max(first_row, 0); y <= std::min(last_row, resolution_px - 1); ++y) {
    const Span a = quad.triangles[0].row(y, resolution_px), b = quad.triangles[1].row(y, resolution_px);
    const Span both{std::max(a.first, b.first), std::min(a.last, b.last)};
    // One call of visit, so that it is compiled into the loop.
    std::array<PixelRun, 3> runs;
    if (both.last < both.first)
      runs = {PixelRun{y, a.first, a.last, 0, false}, PixelRun{y, b.first, b.last, 1, false}, PixelRun{}};
    else
      runs = {PixelRun{y, std::min(a.first, b.first), both.first - 1, a.first < b.first ? 0u : 1u, false},
              PixelRun{y, both.first, both.last, 0, true},
              PixelRun{y, both.last + 1, std::max(a.last, b.last), a.last > b.last ? 0u : 1u, false}};
    for (const PixelRun& run : runs)
      if (run.first <= run.last) visit(run);
  }
}

/// Calls visit(QuadFragment) once for each pixel of a run that shows the quad.
/// keep   bool(const RasterTriangle&, std::uint32_t triangle, std::int32_t x, std::int32_t y): false where the triangle has a hole
template <class Keep, class Visit>
void for_each_fragment(const RasterQuad& quad, const PixelRun& run, Keep&& keep, Visit&& visit) {
  const std::uint32_t t = run.triangle;
  const DepthRow depths = quad.triangles[t].depths(run.y), other_depths = quad.triangles[1].depths(run.y);
  for (std::int32_t x = run.first; x <= run.last; ++x) {
    const bool kept = keep(quad.triangles[t], t, x, run.y);
    if (run.folded && (!kept || other_depths.at(x) < depths.at(x)) && keep(quad.triangles[1], 1u, x, run.y))
      visit(QuadFragment{x, run.y, other_depths.at(x), 1});
    else if (kept)
      visit(QuadFragment{x, run.y, depths.at(x), t});
  }
}

/// Calls visit(QuadFragment) once for each pixel that the quad covers, row by row. keep  as above
template <class Keep, class Visit>
void rasterise_quad(const ProjectedQuad& quad, std::int32_t resolution_px, Keep&& keep, Visit&& visit) {
  const RasterQuad raster(quad);
  for_each_run(raster, resolution_px, [&](const PixelRun& run) { for_each_fragment(raster, run, keep, visit); });
}

}  // namespace coppice::bake
