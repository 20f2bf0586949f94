#include "pair_silhouette.h"

#include <bit>
#include <limits>

#include <glm/geometric.hpp>

#include "bounds.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kCells = 16;  ///< along a side of a bit image
constexpr std::size_t kRowsPerWord = 64 / kCells;
constexpr std::size_t kTriangles = 56, kQuads = 420;
constexpr std::size_t kDirections = 6;

/// A bit image of 16 x 16 cells, rows bottom to top, 16 bits a row.
using Bits = std::array<std::uint64_t, kCells / kRowsPerWord>;

struct Basis {
  glm::dvec3 right, up;
};

std::array<Basis, kDirections> icosahedron_axes() {
  const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
  const std::array<glm::dvec3, 6> axes{{{0, 1, golden}, {0, 1, -golden}, {1, golden, 0}, {1, -golden, 0}, {golden, 0, 1}, {golden, 0, -1}}};
  std::array<Basis, kDirections> bases;
  for (std::size_t i = 0; i < bases.size(); ++i) {
    const glm::dvec3 towards = glm::normalize(axes[i]);
    bases[i].right = glm::normalize(glm::cross(glm::dvec3(axes[i].z, axes[i].x, axes[i].y), towards));
    bases[i].up = glm::cross(towards, bases[i].right);
  }
  return bases;
}

/// All triangles and quads that eight points make.
struct Shapes {
  std::array<std::array<std::uint8_t, 3>, kTriangles> triangles{};  ///< ascending vertices, in lexicographic order
  std::array<std::uint8_t, 512> triangle_of{};                      ///< [64 a + 8 b + c] for vertices in any order
  std::array<PairCorners, kQuads> quads{};                          ///< the diagonal joins corners 0 and 2
  std::array<std::array<std::uint8_t, 2>, kQuads> quad_triangles{};

  Shapes() {
    std::uint8_t count = 0;
    for (std::uint8_t a = 0; a < 8; ++a)
      for (auto b = static_cast<std::uint8_t>(a + 1); b < 8; ++b)
        for (auto c = static_cast<std::uint8_t>(b + 1); c < 8; ++c) {
          triangles[count] = {a, b, c};
          std::array<std::size_t, 3> order{a, b, c};
          do triangle_of[order[0] * 64 + order[1] * 8 + order[2]] = count;
          while (std::next_permutation(order.begin(), order.end()));
          ++count;
        }
    std::size_t quad = 0;
    for (std::uint8_t a = 0; a < 8; ++a)
      for (auto b = static_cast<std::uint8_t>(a + 1); b < 8; ++b)
        for (auto c = static_cast<std::uint8_t>(b + 1); c < 8; ++c)
          for (auto d = static_cast<std::uint8_t>(c + 1); d < 8; ++d)
            for (const PairCorners& ring : {PairCorners{a, b, c, d}, {a, c, b, d}, {a, b, d, c}})
              for (const PairCorners& corners : {ring, PairCorners{ring[1], ring[2], ring[3], ring[0]}}) {
                quads[quad] = corners;
                quad_triangles[quad++] = {triangle(corners[0], corners[1], corners[2]), triangle(corners[0], corners[2], corners[3])};
              }
  }

  [[nodiscard]] std::uint8_t triangle(std::size_t a, std::size_t b, std::size_t c) const { return triangle_of[a * 64 + b * 8 + c]; }
};

/// Cells whose centres are not right of the line from a to b. Points are in cells.
Bits left_of(const glm::dvec2& a, const glm::dvec2& b) {
  constexpr std::uint64_t kFullRow = (std::uint64_t{1} << kCells) - 1;
  constexpr double kFixed = 1 << 20, kFar = 1 << 20;  // fixed point; beyond kFar cells a row a line counts as horizontal
  Bits bits{};
  const glm::dvec2 along = b - a;
  if (along.y == 0.0) {
    for (std::size_t row = 0; row < kCells; ++row)
      if (along.x * (static_cast<double>(row) + 0.5 - a.y) >= 0.0) bits[row / kRowsPerWord] |= kFullRow << (row % kRowsPerWord * kCells);
    return bits;
  }
  // The line crosses a row at a.x + slope (y - a.y); the cells before it have their centres on its low side.
  const double slope = std::clamp(along.x / along.y, -kFar, kFar);
  const auto step = static_cast<std::int64_t>(slope * kFixed);
  auto crossing = static_cast<std::int64_t>((a.x + slope * (0.5 - a.y) + 0.5) * kFixed);
  for (std::uint64_t& word : bits)
    for (std::size_t row = 0; row < kRowsPerWord; ++row, crossing += step) {
      const std::int64_t cells = std::clamp<std::int64_t>(crossing >> 20, 0, kCells);
      word |= ((std::uint64_t{1} << cells) - 1) << (row * kCells);
    }
  if (along.y < 0.0)
    for (std::uint64_t& word : bits) word = ~word;
  return bits;
}

/// The silhouettes in one direction.
struct Silhouettes {
  std::array<Bits, kTriangles> triangles;
  Bits pair{};
  int pair_count = 0;
  float cell_area_m2 = 0.0f;  ///< 0: nothing is visible
};

void draw_triangles(const std::array<glm::dvec2, 8>& points, const Shapes& shapes, std::array<Bits, kTriangles>& images) {
  std::array<std::array<Bits, 8>, 8> left;
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = a + 1; b < 8; ++b) left[a][b] = left_of(points[a], points[b]);
  for (std::size_t t = 0; t < kTriangles; ++t) {
    const auto [a, b, c] = shapes.triangles[t];
    const glm::dvec2 ab = points[b] - points[a], ac = points[c] - points[a];
    const double doubled_area = ab.x * ac.y - ab.y * ac.x;
    const std::uint64_t flip = doubled_area > 0.0 ? 0 : ~std::uint64_t{0};
    for (std::size_t w = 0; w < images[t].size(); ++w)
      images[t][w] = doubled_area == 0.0 ? 0 : (left[a][b][w] ^ flip) & (left[b][c][w] ^ flip) & ~(left[a][c][w] ^ flip);
  }
}

void draw(const PairVertices& points, const Basis& basis, const Shapes& shapes, Silhouettes& seen) {
  std::array<glm::dvec2, 8> cells;
  PointBox<glm::dvec2> box;
  for (std::size_t i = 0; i < 8; ++i) {
    cells[i] = {glm::dot(points[i], basis.right), glm::dot(points[i], basis.up)};
    box.add(cells[i]);
  }
  const glm::dvec2 extent = box.extent();
  if (!(extent.x > 0.0) || !(extent.y > 0.0)) return;
  for (glm::dvec2& point : cells) point = (point - box.low) * (static_cast<double>(kCells) / extent);
  draw_triangles(cells, shapes, seen.triangles);
  for (std::size_t w = 0; w < seen.pair.size(); ++w) {
    for (const std::size_t leaf : {std::size_t{0}, std::size_t{4}})
      seen.pair[w] |=
          seen.triangles[shapes.triangle(leaf, leaf + 1, leaf + 2)][w] | seen.triangles[shapes.triangle(leaf, leaf + 2, leaf + 3)][w];
    seen.pair_count += std::popcount(seen.pair[w]);
  }
  seen.cell_area_m2 = static_cast<float>(extent.x * extent.y / (kCells * kCells));
}

/// Measures a quad. Returns false if it misses more of the pair than `enough`: then its mismatch cannot be smaller.
bool measure(const std::array<Silhouettes, kDirections>& views, const std::array<std::uint8_t, 2>& triangles, float enough,
             PairShape& shape) {
  float pair = 0.0f, quad = 0.0f, shared = 0.0f;
  for (const Silhouettes& seen : views) {
    if (seen.cell_area_m2 == 0.0f) continue;
    const Bits &first = seen.triangles[triangles[0]], &second = seen.triangles[triangles[1]];
    int count = 0, shared_count = 0;
    for (std::size_t w = 0; w < seen.pair.size(); ++w) {
      const std::uint64_t bits = first[w] | second[w];
      count += std::popcount(bits);
      shared_count += std::popcount(bits & seen.pair[w]);
    }
    pair += seen.cell_area_m2 * static_cast<float>(seen.pair_count);
    quad += seen.cell_area_m2 * static_cast<float>(count);
    shared += seen.cell_area_m2 * static_cast<float>(shared_count);
    if (pair - shared > enough * kDirections) return false;
  }
  shape.pair_m2 = pair / kDirections, shape.quad_m2 = quad / kDirections, shape.shared_m2 = shared / kDirections;
  return true;
}

/// The few shapes with the smallest mismatch, ascending.
template <std::size_t kCount>
struct BestShapes {
  std::array<PairShape, kCount> shapes{};
  std::array<float, kCount> mismatches_m2;

  BestShapes() { mismatches_m2.fill(std::numeric_limits<float>::infinity()); }
  [[nodiscard]] float enough() const { return mismatches_m2.back(); }
  void offer(const PairShape& shape, float mismatch_m2) {
    if (mismatch_m2 >= enough()) return;
    std::size_t place = kCount - 1;
    for (; place > 0 && mismatch_m2 < mismatches_m2[place - 1]; --place)
      shapes[place] = shapes[place - 1], mismatches_m2[place] = mismatches_m2[place - 1];
    shapes[place] = shape, mismatches_m2[place] = mismatch_m2;
  }
};

/// The same quad with the same diagonal, started and wound so that its corners point where those of `like` do.
PairCorners aligned(const PairVertices& points, const PairCorners& ring, const Quad& like) {
  const glm::dvec3 center = (points[ring[0]] + points[ring[1]] + points[ring[2]] + points[ring[3]]) * 0.25;
  const glm::dvec3 like_center = quad_centroid(like);
  PairCorners best = ring;
  double best_agreement = -std::numeric_limits<double>::infinity();
  for (const std::size_t step : {std::size_t{1}, std::size_t{3}}) {
    for (const std::size_t start : {std::size_t{0}, std::size_t{2}}) {
      PairCorners turned{};
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

PairShapes pair_shapes(const Quad& first, const Quad& second) {
  static const std::array<Basis, kDirections> bases = icosahedron_axes();
  static const Shapes all;
  const PairVertices points = pair_vertices(first, second);
  std::array<Silhouettes, kDirections> views;
  for (std::size_t v = 0; v < kDirections; ++v) draw(points, bases[v], all, views[v]);

  BestShapes<PairShapes::kOpaque> opaque;
  BestShapes<PairShapes::kOpaque + PairShapes::kTranslucent> translucent;  // may hold some of the opaque ones
  for (std::size_t q = 0; q < kQuads; ++q) {
    PairShape shape{all.quads[q]};
    if (!measure(views, all.quad_triangles[q], std::max(opaque.enough(), translucent.enough()), shape)) continue;
    opaque.offer(shape, shape.mismatch_m2(1.0f, 1.0f));
    translucent.offer(shape, shape.mismatch_m2(1.0f, shape.covering_opacity(1.0f)));
  }
  PairShapes result;
  for (const PairShape& shape : opaque.shapes) result.shapes[result.count++] = shape;
  for (const PairShape& shape : translucent.shapes) {
    const bool is_new = std::ranges::none_of(result.all(), [&](const PairShape& other) { return other.corners == shape.corners; });
    if (is_new && result.count < PairShapes::kOpaque + PairShapes::kTranslucent) result.shapes[result.count++] = shape;
  }
  const Quad& like = quad_area(second) > quad_area(first) ? second : first;
  for (std::size_t i = 0; i < result.count; ++i) result.shapes[i].corners = aligned(points, result.shapes[i].corners, like);
  PairShape largest{merge_corners(first, second)};
  const PairCorners& c = largest.corners;
  measure(views, {all.triangle(c[0], c[1], c[2]), all.triangle(c[0], c[2], c[3])}, std::numeric_limits<float>::infinity(), largest);
  result.shapes[result.count++] = largest;
  return result;
}

}  // namespace coppice::bake
