#include "leaf_quads.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "bounds.h"
#include "coppice/format.h"
#include "nearest_point.h"
#include "parallel_for.h"

namespace coppice::bake {
namespace {

// Edges longer than this share of the wood's box get extra points: the sides of tubes have vertices at their ends only.
constexpr double kSpacing = 1.0 / 512.0;
constexpr std::uint32_t kMaxPointsPerEdge = 256;
constexpr std::size_t kMaxBranchPoints = std::size_t{1} << 22;
constexpr std::size_t kMaxPlanePoints = 24;
// If a triple spans less than this share of the widest triple's area, its normal is rounding errors.
constexpr double kMinSpan = 1e-3;
// Distances to the branch that differ by less than this share of the leaf count as equal, since the branch is sampled.
constexpr double kEqualDistance = 1e-5;

std::vector<glm::vec3> branch_points(const Mesh& wood) {
  const auto [low, high] = box_of(wood.positions);
  const double spacing_m = glm::distance(glm::dvec3(low), glm::dvec3(high)) * kSpacing;
  std::vector<glm::vec3> points = wood.positions;
  if (spacing_m <= 0.0) return points;
  for (std::size_t i = 0; i < wood.indices.size() && points.size() < kMaxBranchPoints; ++i) {
    const glm::vec3& from = wood.positions[wood.indices[i]];
    const glm::vec3& to = wood.positions[wood.indices[i % 3 == 2 ? i - 2 : i + 1]];
    const double steps = std::ceil(glm::distance(glm::dvec3(from), glm::dvec3(to)) / spacing_m);
    const auto step_count = static_cast<std::uint32_t>(std::min(steps, double{kMaxPointsPerEdge}));
    for (std::uint32_t step = 1; step < step_count; ++step)
      points.push_back(glm::mix(from, to, static_cast<float>(step) / static_cast<float>(step_count)));
  }
  return points;
}

/// Distance of a point from the branch that bears it: from the nearest vertex of the wood, or point along one of its long edges. Without
/// wood, from the vertical axis through the middle of the foliage's box. Calls may overlap.
class BranchDistance {
 public:
  explicit BranchDistance(const Plant& plant) {
    if (!plant.wood.indices.empty()) {
      wood_.emplace(branch_points(plant.wood), 16);
    } else if (!plant.foliage.positions.empty()) {
      const auto [low, high] = box_of(plant.foliage.positions);
      axis_ = 0.5f * (low + high);
    }
  }

  /// The branch's nearest point: the wood bears a leaf there if the leaf's stalk is at `point`.
  [[nodiscard]] glm::vec3 nearest_point(const glm::vec3& point) const {
    return wood_ ? wood_->point(wood_->to(point)) : glm::vec3(axis_.x, point.y, axis_.z);
  }
  [[nodiscard]] float distance_m(const glm::vec3& point) const { return glm::distance(point, nearest_point(point)); }

 private:
  std::optional<NearestPoint<float>> wood_;
  glm::vec3 axis_{0.0f};
};

/// A corner of one of the leaf's triangles.
struct Corner {
  std::uint32_t vertex = 0;  ///< index in the foliage mesh
  std::uint32_t point = 0;   ///< index in LeafShape::points
};

/// A leaf as distinct points, and triangles over them.
struct LeafShape {
  std::vector<glm::dvec3> points;
  std::vector<Corner> corners;           ///< 3 per triangle
  std::vector<std::uint32_t> materials;  ///< 1 per triangle
};

LeafShape leaf_shape(const Plant& plant, const LeafRange& leaf) {
  const Mesh& mesh = plant.foliage;
  LeafShape shape;
  const auto key = [](const glm::vec3& position) { return std::tuple(position.x, position.y, position.z); };
  std::vector<glm::vec3> sorted;
  for (const std::uint32_t vertex : leaf_indices(mesh, leaf)) sorted.push_back(mesh.positions[vertex]);
  std::ranges::sort(sorted, {}, key);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  for (const glm::vec3& position : sorted) shape.points.emplace_back(position);
  for (const std::uint32_t vertex : leaf_indices(mesh, leaf)) {
    const auto found = std::ranges::lower_bound(sorted, key(mesh.positions[vertex]), {}, key);
    shape.corners.push_back({vertex, static_cast<std::uint32_t>(found - sorted.begin())});
  }
  for (std::size_t t = 0; t < leaf.triangle_count; ++t) shape.materials.push_back(mesh.triangle_materials[leaf.first_triangle + t]);
  return shape;
}

/// The normal of the triangle's front, as long as twice its area.
glm::dvec3 area_vector(const LeafShape& shape, std::size_t triangle) {
  const glm::dvec3& a = shape.points[shape.corners[3 * triangle].point];
  return glm::cross(shape.points[shape.corners[3 * triangle + 1].point] - a, shape.points[shape.corners[3 * triangle + 2].point] - a);
}

/// The direction of the leaf's front, not unit: the sum of its triangles' normals. If both sides of the leaf are there and cancel, the sum
/// of its vertex normals; if those cancel too, up.
glm::dvec3 front_direction(const Mesh& mesh, const LeafShape& shape) {
  constexpr double kCancels = 1e-3;
  glm::dvec3 sum(0.0), normal_sum(0.0);
  double total = 0.0;
  for (std::size_t t = 0; t < shape.materials.size(); ++t) {
    const glm::dvec3 area = area_vector(shape, t);
    const double weight = glm::length(area);
    sum += area;
    total += weight;
    for (std::size_t k = 0; k < 3; ++k) normal_sum += weight / 3.0 * glm::dvec3(mesh.normals[shape.corners[3 * t + k].vertex]);
  }
  if (glm::length(sum) > kCancels * total) return sum;
  if (glm::length(normal_sum) > kCancels * total) return normal_sum;
  return {0.0, 1.0, 0.0};
}

/// The material with the largest area of the leaf; the smaller number wins a tie.
std::uint32_t main_material(const LeafShape& shape) {
  std::map<std::uint32_t, double> areas;
  for (std::size_t t = 0; t < shape.materials.size(); ++t) areas[shape.materials[t]] += glm::length(area_vector(shape, t));
  return std::max_element(areas.begin(), areas.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
}

struct StalkAndTip {
  std::size_t stalk = 0, tip = 0;
};

StalkAndTip find_stalk_and_tip(const LeafShape& shape, const BranchDistance& branch) {
  std::vector<double> distances_m;
  for (const glm::dvec3& point : shape.points) distances_m.push_back(double{branch.distance_m(glm::vec3(point))});
  const auto stalk = static_cast<std::size_t>(std::ranges::min_element(distances_m) - distances_m.begin());
  // The tip is measured from where the branch bears this leaf: in a crown another branch may pass close to the tip.
  const glm::dvec3 bearing(branch.nearest_point(glm::vec3(shape.points[stalk])));
  std::ranges::transform(shape.points, distances_m.begin(), [&](const glm::dvec3& point) { return glm::distance(point, bearing); });
  const double max_m = *std::ranges::max_element(distances_m);
  const auto reach_m = [&](std::size_t i) { return glm::distance(shape.points[i], shape.points[stalk]); };
  double size_m = 0.0;
  for (std::size_t i = 0; i < shape.points.size(); ++i) size_m = std::max(size_m, reach_m(i));
  // If several are farthest, the tip is the one farthest from the stalk.
  StalkAndTip ends{stalk, stalk};
  for (std::size_t i = 0; i < shape.points.size(); ++i)
    if (distances_m[i] >= max_m - kEqualDistance * size_m && reach_m(i) > reach_m(ends.tip)) ends.tip = i;
  return ends;
}

std::vector<std::size_t> plane_candidates(std::span<const glm::dvec3> points, std::size_t stalk) {
  std::vector<std::size_t> chosen;
  if (points.size() - 1 <= kMaxPlanePoints) {
    for (std::size_t i = 0; i < points.size(); ++i)
      if (i != stalk) chosen.push_back(i);
    return chosen;
  }
  std::vector<double> gaps_m(points.size(), 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) gaps_m[i] = glm::distance(points[i], points[stalk]);
  while (chosen.size() < kMaxPlanePoints) {
    const auto farthest = static_cast<std::size_t>(std::max_element(gaps_m.begin(), gaps_m.end()) - gaps_m.begin());
    chosen.push_back(farthest);
    for (std::size_t i = 0; i < points.size(); ++i) gaps_m[i] = std::min(gaps_m[i], glm::distance(points[i], points[farthest]));
  }
  return chosen;
}

/// A quad's four points in ring order, with the winding of its first triangle.
using Ring = std::array<std::uint32_t, 4>;

/// The ring of a leaf that is two triangles on one edge, repeated any number of times, either way round.
std::optional<Ring> quad_ring(const LeafShape& shape) {
  if (shape.points.size() != 4) return std::nullopt;
  std::array<bool, 4> seen{};  // a triangle of four points is named by the point that it lacks
  std::size_t seen_count = 0;
  for (std::size_t t = 0; t < shape.materials.size(); ++t) {
    const std::uint32_t a = shape.corners[3 * t].point, b = shape.corners[3 * t + 1].point, c = shape.corners[3 * t + 2].point;
    if (a == b || b == c || c == a) return std::nullopt;
    bool& triangle = seen[6 - a - b - c];
    if (!triangle) ++seen_count;
    triangle = true;
  }
  if (seen_count != 2) return std::nullopt;
  const std::uint32_t a = shape.corners[0].point, b = shape.corners[1].point, c = shape.corners[2].point, d = 6 - a - b - c;
  // The other triangle lacks the corner opposite the shared edge, so d goes between that edge's ends.
  if (seen[a]) return Ring{a, b, d, c};
  if (seen[b]) return Ring{b, c, d, a};
  return Ring{c, a, d, b};
}

/// Turns the ring so that its last and first corner are the edge nearest to the branch.
Ring stalk_first(const LeafShape& shape, const Ring& ring, const BranchDistance& branch) {
  std::array<double, 4> distances_m{};
  for (std::size_t i = 0; i < 4; ++i) distances_m[i] = double{branch.distance_m(glm::vec3(shape.points[ring[i]]))};
  std::size_t best = 0;
  const auto edge_m = [&](std::size_t i) { return distances_m[i] + distances_m[(i + 3) % 4]; };
  for (std::size_t i = 1; i < 4; ++i)
    if (edge_m(i) < edge_m(best)) best = i;
  Ring turned = ring;
  std::rotate(turned.begin(), turned.begin() + best, turned.end());
  return turned;
}

glm::vec2 uv_at(const Mesh& mesh, const LeafShape& shape, std::uint32_t point) {
  const auto found = std::find_if(shape.corners.begin(), shape.corners.end(), [&](const Corner& c) { return c.point == point; });
  return mesh.uvs[found->vertex];
}

FittedLeaf keep_quad(const Mesh& mesh, const LeafShape& shape, const Ring& ring) {
  FittedLeaf fitted;
  fitted.card.material = main_material(shape);
  for (std::size_t i = 0; i < 4; ++i) {
    fitted.quad[i] = glm::vec3(shape.points[ring[i]]);
    fitted.card.uv[i] = uv_at(mesh, shape, ring[i]);
  }
  return fitted;
}

/// The leaf's own axes: x from stalk to tip, y across, z towards its front.
struct Frame {
  glm::dvec3 origin{0.0}, x{0.0}, y{0.0};
  [[nodiscard]] glm::dvec2 flatten(const glm::dvec3& point) const { return {glm::dot(point - origin, x), glm::dot(point - origin, y)}; }
};

glm::dvec3 any_perpendicular(const glm::dvec3& v) {
  const glm::dvec3 axis = std::abs(v.x) < std::abs(v.y) ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  return glm::normalize(glm::cross(v, axis));
}

/// Twice the area of the leaf as seen along a unit normal, whatever hides what.
double shown_area(const LeafShape& shape, const glm::dvec3& normal) {
  double sum = 0.0;
  for (std::size_t t = 0; t < shape.materials.size(); ++t) sum += std::abs(glm::dot(area_vector(shape, t), normal));
  return sum;
}

/// The normal of the triangle on whose plane most of the leaf shows; the first wins a tie.
glm::dvec3 most_shown_normal(const LeafShape& shape) {
  glm::dvec3 best(0.0);
  double most = 0.0;
  for (std::size_t t = 0; t < shape.materials.size(); ++t) {
    const glm::dvec3 area = area_vector(shape, t);
    const double length = glm::length(area);
    const double shown = length > 0.0 ? shown_area(shape, area / length) : 0.0;
    if (shown <= most) continue;
    most = shown;
    best = area / length;
  }
  return best;
}

Plane leaf_plane(const LeafShape& shape, std::size_t stalk, LeafPlane rule) {
  // The plane nearest to the points of a frond that droops to both sides is the one that sees it edge-on.
  constexpr double kMinShown = 0.5;
  Plane plane = best_plane(shape.points, stalk);
  if (rule == LeafPlane::nearest) return plane;
  double area = 0.0;
  for (std::size_t t = 0; t < shape.materials.size(); ++t) area += glm::length(area_vector(shape, t));
  if (shown_area(shape, plane.normal) < kMinShown * area) plane.normal = most_shown_normal(shape);
  return plane;
}

Frame leaf_frame(const LeafShape& shape, const StalkAndTip& ends, LeafPlane rule, const glm::dvec3& front) {
  const Plane plane = leaf_plane(shape, ends.stalk, rule);
  glm::dvec3 tip = shape.points[ends.tip];
  glm::dvec3 normal = plane.normal;
  if (normal == glm::dvec3(0.0)) normal = any_perpendicular(tip - plane.point);
  if (glm::dot(normal, front) < 0.0) normal = -normal;
  const auto in_plane = [&](const glm::dvec3& point) {
    const glm::dvec3 arm = point - plane.point;
    return arm - glm::dot(arm, normal) * normal;
  };
  // A tip right above the stalk has no direction in the plane, so the farthest point that has one takes its place.
  constexpr double kMinSlant = 1e-3;
  if (glm::length(in_plane(tip)) < kMinSlant * glm::distance(tip, plane.point))
    tip = *std::max_element(shape.points.begin(), shape.points.end(),
                            [&](const glm::dvec3& a, const glm::dvec3& b) { return glm::length(in_plane(a)) < glm::length(in_plane(b)); });
  Frame frame;
  frame.origin = plane.point;
  frame.x = glm::normalize(in_plane(tip));
  frame.y = glm::cross(normal, frame.x);
  return frame;
}

/// An affine map: u or v is value[0] + value[1] x + value[2] y.
struct AffineUv {
  glm::dvec3 u{0.0}, v{0.0};
  [[nodiscard]] glm::vec2 at(const glm::dvec2& point) const {
    const glm::dvec3 basis(1.0, point.x, point.y);
    return {static_cast<float>(glm::dot(u, basis)), static_cast<float>(glm::dot(v, basis))};
  }
};

/// Least squares over the corners of the triangles of the card's material, weighted by area. If a leaf has a back only the front counts,
/// since the back may lie elsewhere in the texture. If the points do not span the plane, the mean.
AffineUv fit_uv(const Mesh& mesh, const LeafShape& shape, const Frame& frame, std::uint32_t material, double length_m) {
  const glm::dvec3 normal = glm::cross(frame.x, frame.y);
  glm::dmat3 moments(0.0);
  glm::dvec3 u_moments(0.0), v_moments(0.0);
  for (std::size_t t = 0; t < shape.materials.size(); ++t) {
    const double weight = glm::dot(area_vector(shape, t), normal);
    if (shape.materials[t] != material || weight <= 0.0) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Corner& corner = shape.corners[3 * t + k];
      // Lengths are relative to the leaf's, so that all moments have one size.
      const glm::dvec3 basis(1.0, frame.flatten(shape.points[corner.point]) / length_m);
      const glm::dvec2 uv(mesh.uvs[corner.vertex]);
      moments += glm::outerProduct(weight * basis, basis);
      u_moments += weight * uv.x * basis;
      v_moments += weight * uv.y * basis;
    }
  }
  const double scale = moments[0][0];
  if (scale <= 0.0) return {};
  constexpr double kMinDeterminant = 1e-12;
  if (glm::determinant(moments / scale) < kMinDeterminant) return {{u_moments[0] / scale, 0.0, 0.0}, {v_moments[0] / scale, 0.0, 0.0}};
  const glm::dmat3 solve = glm::inverse(moments);
  const glm::dvec3 to_metres(1.0, 1.0 / length_m, 1.0 / length_m);
  return {solve * u_moments * to_metres, solve * v_moments * to_metres};
}

/// The rectangle along x from stalk to tip, on either side as wide as the leaf.
struct Rectangle {
  double length_m = 0.0, up_m = 0.0, down_m = 0.0;
};

Rectangle measure(const LeafShape& shape, const Frame& frame, const glm::dvec3& tip) {
  Rectangle rectangle;
  rectangle.length_m = frame.flatten(tip).x;
  double farthest_m = 0.0, area_m2 = 0.0;
  for (const glm::dvec3& point : shape.points) {
    const glm::dvec2 flat = frame.flatten(point);
    farthest_m = std::max(farthest_m, flat.x);
    rectangle.up_m = std::max(rectangle.up_m, flat.y);
    rectangle.down_m = std::max(rectangle.down_m, -flat.y);
  }
  constexpr double kMinShape = 1e-6;
  if (rectangle.length_m < kMinShape * farthest_m) rectangle.length_m = farthest_m;
  // A leaf that its own plane sees edge-on still has area: the rectangle gets that.
  if (rectangle.up_m + rectangle.down_m < kMinShape * rectangle.length_m) {
    for (std::size_t t = 0; t < shape.materials.size(); ++t) area_m2 += 0.5 * glm::length(area_vector(shape, t));
    rectangle.up_m = rectangle.down_m = 0.5 * area_m2 / rectangle.length_m;
  }
  return rectangle;
}

/// Fits a quad to one leaf of the plant, as fit_leaves does. The leaf has at least three distinct points.
FittedLeaf fit_leaf(const Plant& plant, const LeafRange& leaf, const BranchDistance& branch, LeafPlane plane) {
  const Mesh& mesh = plant.foliage;
  const LeafShape shape = leaf_shape(plant, leaf);
  if (const std::optional<Ring> ring = quad_ring(shape)) return keep_quad(mesh, shape, stalk_first(shape, *ring, branch));

  const StalkAndTip ends = find_stalk_and_tip(shape, branch);
  const Frame frame = leaf_frame(shape, ends, plane, front_direction(mesh, shape));
  const Rectangle rectangle = measure(shape, frame, shape.points[ends.tip]);
  const double length_m = rectangle.length_m;
  FittedLeaf fitted;
  fitted.card.material = main_material(shape);
  const AffineUv uv = fit_uv(mesh, shape, frame, fitted.card.material, length_m);
  const std::array<glm::dvec2, 4> corners{
      {{0.0, -rectangle.down_m}, {length_m, -rectangle.down_m}, {length_m, rectangle.up_m}, {0.0, rectangle.up_m}}};
  for (std::size_t i = 0; i < 4; ++i) {
    fitted.quad[i] = glm::vec3(frame.origin + corners[i].x * frame.x + corners[i].y * frame.y);
    fitted.card.uv[i] = uv.at(corners[i]);
  }
  return fitted;
}

bool has_area(const Mesh& mesh, const LeafRange& leaf) {
  for (std::size_t t = leaf.first_triangle; t < std::size_t{leaf.first_triangle} + leaf.triangle_count; ++t) {
    const glm::dvec3 a(mesh.positions[mesh.indices[3 * t]]), b(mesh.positions[mesh.indices[3 * t + 1]]),
        c(mesh.positions[mesh.indices[3 * t + 2]]);
    if (glm::length(glm::cross(b - a, c - a)) > 0.0) return true;
  }
  return false;
}

constexpr float kUvSteps = 4096.0f;
// Beyond this a float no longer holds steps of 1/4096, so such coordinates carry no information.
constexpr float kMaxUv = 2048.0f;
// Distance of cards of different materials.
constexpr double kFar = std::numeric_limits<double>::max();

constexpr std::array<glm::vec2, 4> kUnitSquare{{{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}};

Card canonical(const Card& card, const std::vector<Material>& materials) {
  Card shared{card.material, kUnitSquare};
  if (materials[card.material].image == kNone) return shared;
  glm::vec2 mean(0.0f);
  for (const glm::vec2& uv : card.uv) mean += 0.25f * glm::clamp(uv, -kMaxUv, kMaxUv);
  for (std::size_t i = 0; i < 4; ++i)
    shared.uv[i] = glm::round((glm::clamp(card.uv[i], -kMaxUv, kMaxUv) - glm::floor(mean)) * kUvSteps) / kUvSteps;
  return shared;
}

double squared_distance(const Card& a, const Card& b) {
  if (a.material != b.material) return kFar;
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec2 step(a.uv[i] - b.uv[i]);
    sum += glm::dot(step, step);
  }
  return sum;
}

/// Merges equal cards; the distinct ones are in order of first use.
SharedCards merge_equal(const std::vector<Card>& cards, const std::vector<Material>& materials) {
  SharedCards merged;
  std::map<std::pair<std::uint32_t, std::array<float, 8>>, std::uint32_t> index_of;  // by material and uvs
  for (const Card& card : cards) {
    const Card shared = canonical(card, materials);
    const auto [found, is_new] = index_of.try_emplace({shared.material, std::bit_cast<std::array<float, 8>>(shared.uv)},
                                                      static_cast<std::uint32_t>(merged.table.size()));
    if (is_new) merged.table.push_back(shared);
    merged.card_of.push_back(found->second);
  }
  return merged;
}

/// Farthest-point sampling: the worst leaf is as near to its card as this many cards allow, up to a factor of two. A material that is not
/// in the table yet is infinitely far, so each material gets a card.
SharedCards choose(const SharedCards& all) {
  SharedCards chosen;
  std::vector<double> gaps(all.table.size(), kFar);
  std::vector<std::uint32_t> nearest(all.table.size(), 0);
  while (chosen.table.size() < COPPICE_MAX_CARDS) {
    const auto farthest = static_cast<std::size_t>(std::max_element(gaps.begin(), gaps.end()) - gaps.begin());
    const auto number = static_cast<std::uint32_t>(chosen.table.size());
    chosen.table.push_back(all.table[farthest]);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      const double gap = squared_distance(all.table[i], chosen.table.back());
      if (gap >= gaps[i]) continue;
      gaps[i] = gap;
      nearest[i] = number;
    }
  }
  for (const std::uint32_t card : all.card_of) chosen.card_of.push_back(nearest[card]);
  return chosen;
}

}  // namespace

Plane best_plane(std::span<const glm::dvec3> points, std::size_t stalk) {
  const std::vector<std::size_t> candidates = plane_candidates(points, stalk);
  const glm::dvec3 origin = points[stalk];
  const auto span_of = [&](std::size_t i, std::size_t j) {
    return glm::cross(points[candidates[i]] - origin, points[candidates[j]] - origin);
  };
  double widest = 0.0;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (std::size_t j = i + 1; j < candidates.size(); ++j) widest = std::max(widest, glm::length(span_of(i, j)));

  Plane best{origin, glm::dvec3(0.0)};
  std::optional<double> min_m;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (std::size_t j = i + 1; j < candidates.size(); ++j) {
      const glm::dvec3 span = span_of(i, j);
      const double length = glm::length(span);
      if (length <= kMinSpan * widest) continue;
      double sum_m = 0.0;
      for (const glm::dvec3& point : points) sum_m += std::abs(glm::dot(point - origin, span)) / length;
      if (min_m && sum_m >= *min_m) continue;
      min_m = sum_m;
      best.normal = span / length;
    }
  return best;
}

Result<std::vector<FittedLeaf>> fit_leaves(const Plant& plant, LeafPlane plane) {
  for (std::size_t i = 0; i < plant.leaves.size(); ++i)
    if (!has_area(plant.foliage, plant.leaves[i]))
      return Error{Status::invalid_argument, "leaf without area", Error::kNoOffset, "leaf " + std::to_string(i)};
  const BranchDistance branch(plant);
  std::vector<FittedLeaf> leaves(plant.leaves.size());
  // Each leaf writes its own slot, so the result does not depend on the threads.
  constexpr std::size_t kGrain = 64;
  parallel_for(
      plant.leaves.size(), [&](std::size_t i) { leaves[i] = fit_leaf(plant, plant.leaves[i], branch, plane); }, kGrain);
  return leaves;
}

SharedCards share_cards(const std::vector<Card>& cards, const std::vector<Material>& materials) {
  SharedCards merged = merge_equal(cards, materials);
  if (merged.table.size() <= COPPICE_MAX_CARDS) return merged;
  return choose(merged);
}

Foliage share_leaf_cards(const std::vector<FittedLeaf>& leaves, const std::vector<Material>& materials) {
  Foliage foliage;
  std::vector<Card> cards;
  for (const FittedLeaf& leaf : leaves) {
    foliage.quads.push_back(leaf.quad);
    cards.push_back(leaf.card);
  }
  SharedCards shared = share_cards(cards, materials);
  foliage.card_table = std::move(shared.table);
  foliage.cards = std::move(shared.card_of);
  return foliage;
}

Result<Foliage> fit_leaf_quads(const Plant& plant) {
  COPPICE_TRY(leaves, fit_leaves(plant));
  return share_leaf_cards(leaves, plant.materials);
}

}  // namespace coppice::bake
