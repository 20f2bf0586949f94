#include "wood_lods.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include <meshoptimizer.h>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "triangle_soup.h"
#include "wood_pieces.h"
#include "wood_proxies.h"

namespace coppice::bake {
namespace {

// Wood is tubes: a trunk, boughs and twigs, each its own connected surface. A simplifier that works on all of it at once fails. Edge
// collapse stalls when every twig is a prism (at 905 triangles of eztree_oak_medium's 3,166, however few are asked for). Vertex clustering
// loses what is thinner than its grid, which may be the trunk. So a LoD distributes its triangles over the pieces, always to the piece
// whose error they reduce most. A piece is simplified by itself, or becomes a proxy of few triangles (wood_proxies.h), or is left out; then
// its area goes to proxies near it, which grow wider. So a plant keeps the area and colour of thin pieces, down to some tens of triangles.
//
// Where trunk and boughs are one surface, either simplifier makes a spike of it or breaks it. Such a piece is also cut into its limbs,
// which are then pieces like others; the images decide which is better.

constexpr std::size_t kMaxLods = 7;
constexpr std::size_t kReduction = 4;
// Wood with fewer triangles gets no coarser LoD: there is nothing left to save.
constexpr std::size_t kMinTriangles = 96;
// Triangles of a prism with three sides.
constexpr std::size_t kTubeTriangles = 6;
// Edge collapse has stalled if it leaves more than kStalled times the triangles asked for. The coarsest clustering that keeps the other
// share of the piece's area then replaces it, if it leaves fewer.
constexpr std::size_t kStalled = 2;
constexpr double kMinClusteredArea = 0.7;
// Minimum share of its length to which a piece is squeezed, so that its cells stay some vertices long.
constexpr double kMinSqueeze = 0.01;
// A LoD with more than this share of the previous one's triangles is not worth its bytes.
constexpr double kMinProgress = 0.7;
// Errors are relative to a piece's extent, so this limits nothing.
constexpr float kAnyError = 1.0f;
// One in so many of a LoD's triangles is for pieces that would be left out.
constexpr std::size_t kRestShare = 5;
// A proxy grows to at most kMaxGrowth times the area of its piece, or to a pixel's width where the LoD is likely to be drawn: where the
// plant is kPxPerRootTriangle pixels high for each square root of a triangle. It takes the area of pieces with at least kMinGirthShare of
// its girth: thinner pieces look like a haze, which a thick bough would not show.
constexpr double kMaxGrowth = 2.0;
constexpr double kPxPerRootTriangle = 10.0;
constexpr double kMinGirthShare = 0.2;
constexpr double kGoldenAngle = 2.399963229728653;

using Indices = std::vector<std::uint32_t>;

/// What happens to the area of pieces that get no triangles in a LoD.
enum class LeftOut : std::uint8_t { merged, lost };

/// A way to draw a piece, and its error relative to leaving the piece out.
struct Choice {
  enum class Kind : std::uint8_t { nothing, proxy, simplified } kind = Kind::nothing;
  std::size_t triangle_count = 0;
  double error = 1.0;
  Proxy form{};
  double misfit_m2 = 0.0;   ///< squared distance from the piece
  std::size_t version = 0;  ///< index of a simplified version
};

struct Candidate {
  WoodPiece piece;
  std::vector<Indices> versions;  ///< simplified versions of the piece
  std::vector<Choice> all;        ///< errors do not include misfits
  /// For one LoD: from one to the next more triangles, less error, and less gain per triangle.
  std::vector<Choice> choices;
};

/// Drops choices that cost more for less, or that a mixture of two others beats.
std::vector<Choice> lower_hull(std::vector<Choice> choices) {
  std::ranges::stable_sort(choices, [](const Choice& a, const Choice& b) {
    return std::pair(a.triangle_count, a.error) < std::pair(b.triangle_count, b.error);
  });
  const auto gain = [](const Choice& from, const Choice& to) {
    return (from.error - to.error) / static_cast<double>(to.triangle_count - from.triangle_count);
  };
  std::vector<Choice> hull;
  for (const Choice& choice : choices) {
    if (!hull.empty() && (choice.error >= hull.back().error || choice.triangle_count == hull.back().triangle_count)) continue;
    while (hull.size() > 1 && gain(hull[hull.size() - 2], hull.back()) <= gain(hull.back(), choice)) hull.pop_back();
    hull.push_back(choice);
  }
  return hull;
}

/// A piece in fewer triangles, and their distance from it.
struct Version {
  Indices indices;
  double error_m = 0.0;
};

double scaled_error_m(float relative, const std::vector<glm::vec3>& positions) {
  return double{relative} * double{meshopt_simplifyScale(&positions[0].x, positions.size(), sizeof(glm::vec3))};
}

Version collapse_edges(const WoodPiece& piece, std::size_t target_count) {
  Indices result(piece.indices.size());
  float error = 0.0f;
  result.resize(meshopt_simplify(result.data(), piece.indices.data(), piece.indices.size(), &piece.positions[0].x, piece.positions.size(),
                                 sizeof(glm::vec3), 3 * target_count, kAnyError, 0, &error));
  return {std::move(result), scaled_error_m(error, piece.positions)};
}

/// Cells of a clustering are cubes. In the plant's proportions they are longer than a trunk is thick long before they are as long as its
/// sections. Squeezed along its length by the ratio of thickness to length, a tube of a few sections is a few cells.
std::vector<glm::vec3> squeezed(const WoodPiece& piece) {
  const double thickness_m = std::hypot(piece.spread_m[1], piece.spread_m[2]) / std::sqrt(2.0);
  const double factor = piece.spread_m[0] > 0.0 ? std::clamp(thickness_m / piece.spread_m[0], kMinSqueeze, 1.0) : 1.0;
  std::vector<glm::vec3> positions;
  for (const glm::vec3& position : piece.positions) {
    const glm::dvec3 arm = glm::dvec3(position) - piece.center;
    positions.emplace_back(arm + piece.axes[0] * (glm::dot(arm, piece.axes[0]) * (factor - 1.0)));
  }
  return positions;
}

/// The coarsest clustering of at least target_count triangles that keeps enough of the piece's area; empty if none has fewer than
/// max_count.
Version cluster_vertices(const WoodPiece& piece, std::size_t target_count, std::size_t max_count) {
  const std::vector<glm::vec3> positions = squeezed(piece);
  for (std::size_t count = target_count; count < max_count; count *= 2) {
    Indices result(piece.indices.size());
    float error = 0.0f;
    result.resize(meshopt_simplifySloppy(result.data(), piece.indices.data(), piece.indices.size(), &positions[0].x, positions.size(),
                                         sizeof(glm::vec3), 3 * count, kAnyError, &error));
    if (projected_area_m2(piece.positions, result) < kMinClusteredArea * piece.projected_m2) continue;
    if (result.size() >= 3 * max_count) return {};
    return {std::move(result), scaled_error_m(error, positions)};
  }
  return {};
}

/// Simplifies a piece to about target_count triangles, or as few as possible, but at least one.
Version simplify_piece(const WoodPiece& piece, std::size_t target_count) {
  Version simplified = collapse_edges(piece, target_count);
  if (simplified.indices.empty()) simplified = {piece.indices, 0.0};
  if (simplified.indices.size() / 3 <= kStalled * target_count) return simplified;
  Version clustered = cluster_vertices(piece, target_count, simplified.indices.size() / 3);
  return clustered.indices.empty() ? simplified : clustered;
}

// A strip's error comes from its width, which varies with the view direction, a tube's from looking flat with few sides. The values make
// the measured errors of oak, pine, poplar and bamboo small. A version that misses the piece by its radius, or by half a pixel if that is
// more, is half as wrong as none.
constexpr double kStripError = 0.35, kThreeSidedTubeError = 0.2, kTubeError = 0.1, kMisfitError = 0.5;
constexpr double kThreeSidedSpindleError = 0.3, kSpindleError = 0.2;
constexpr double kSimplifiedError = 5.0;  ///< divided by the number of triangles
constexpr double kMeanOfMax = 0.1;        ///< mean square of a simplified piece's distance, relative to the square of the largest
constexpr std::size_t kMinSimplified = 12;
constexpr std::uint32_t kMaxSections = 8;

/// Whether the piece shows about as much as the ellipsoid of its spreads: a fruit, a cactus. A piece that forks shows far less, and a
/// spindle in its place would hang in the air.
bool is_body(const WoodPiece& piece) {
  constexpr double kThomsen = 1.6075, kMinShare = 0.6;  // Thomsen's approximation of an ellipsoid's surface
  std::array<double, 3> power{};
  for (std::size_t k = 0; k < 3; ++k) power[k] = std::pow(std::sqrt(3.0) * piece.spread_m[k], kThomsen);
  const double mean = (power[0] * power[1] + power[0] * power[2] + power[1] * power[2]) / 3.0;
  return piece.projected_m2 >= kMinShare * std::numbers::pi * std::pow(mean, 1.0 / kThomsen);
}

Candidate candidate_of(WoodPiece&& piece) {
  using enum Choice::Kind;
  std::vector<Choice> choices{{}};
  const std::size_t all = piece.triangle_count();
  for (std::uint32_t sections = 1; sections <= kMaxSections; sections *= 2) {
    if (2 * sections >= all) break;
    const double misfit_m2 = line_misfit_m2(piece, sections);
    for (const auto& [sides, error] : {std::pair{2u, kStripError}, std::pair{3u, kThreeSidedTubeError}, std::pair{5u, kTubeError}}) {
      const Proxy form{sections, sides};
      if (form.triangle_count() < all) choices.push_back({proxy, form.triangle_count(), error, form, misfit_m2});
    }
  }
  // The spindle's error grows with the ratio of length to width.
  const double long_error = piece.spread_m[0] > 0.0 ? 0.8 * (1.0 - piece.spread_m[1] / piece.spread_m[0]) : 0.0;
  for (const auto& [sides, error] : {std::pair{3u, kThreeSidedSpindleError}, std::pair{4u, kSpindleError}}) {
    const Proxy form{0, sides};
    if (is_body(piece) && form.triangle_count() < all) choices.push_back({proxy, form.triangle_count(), error + long_error, form});
  }
  // The result may have far more triangles than asked for: edges do not collapse between parts, so each of them stays a tube.
  std::vector<Indices> versions;
  for (std::size_t asked = std::max(kMinSimplified, kTubeTriangles * piece.part_count); asked < all; asked *= 2) {
    Version version = simplify_piece(piece, asked);
    const std::size_t count = version.indices.size() / 3;
    versions.push_back(std::move(version.indices));
    choices.push_back({simplified,
                       count,
                       kSimplifiedError / static_cast<double>(count),
                       {},
                       kMeanOfMax * version.error_m * version.error_m,
                       versions.size() - 1});
  }
  versions.push_back(piece.indices);
  choices.push_back({simplified, all, 0.0, {}, 0.0, versions.size() - 1});
  return {std::move(piece), std::move(versions), std::move(choices), {}};
}

void set_choices(Candidate& candidate, double pixel_m) {
  candidate.choices = candidate.all;
  const double seen_m = 0.5 * std::max(std::min(candidate.piece.girth_m(), candidate.piece.thickness_m()), pixel_m);
  for (Choice& choice : candidate.choices)
    if (choice.misfit_m2 > 0.0) choice.error += kMisfitError * choice.misfit_m2 / (seen_m * seen_m);
  candidate.choices = lower_hull(std::move(candidate.choices));
}

/// A step of one candidate to its next choice.
struct Step {
  int gain_class = 0;
  std::size_t candidate = 0, choice = 0;
};

/// All steps, those with the most gain per triangle first; steps with about the same gain are in the candidates' order.
std::vector<Step> steps_of(const std::vector<Candidate>& candidates) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const WoodPiece& piece = candidates[i].piece;
    const std::vector<Choice>& choices = candidates[i].choices;
    for (std::size_t k = 1; k < choices.size(); ++k) {
      const double gain = piece.weight() * (choices[k - 1].error - choices[k].error) /
                          static_cast<double>(choices[k].triangle_count - choices[k - 1].triangle_count);
      if (gain > 0.0) steps.push_back({static_cast<int>(std::floor(2.0 * std::log2(gain))), i, k});
    }
  }
  std::ranges::stable_sort(steps, [](const Step& a, const Step& b) { return a.gain_class > b.gain_class; });
  return steps;
}

/// The choice of each candidate, and the number of triangles that are left.
struct Deal {
  std::vector<std::size_t> chosen;
  std::size_t left = 0;

  void take(const std::vector<Candidate>& candidates, std::size_t i, std::size_t choice) {
    const std::vector<Choice>& choices = candidates[i].choices;
    left -= std::min(left, choices[choice].triangle_count - choices[chosen[i]].triangle_count);
    chosen[i] = choice;
  }
};

void deal_by_gain(const std::vector<Candidate>& candidates, const std::vector<Step>& steps, Deal& deal) {
  for (const Step& step : steps) {
    const std::vector<Choice>& choices = candidates[step.candidate].choices;
    if (deal.chosen[step.candidate] + 1 != step.choice) continue;
    if (choices[step.choice].triangle_count - choices[step.choice - 1].triangle_count <= deal.left)
      deal.take(candidates, step.candidate, step.choice);
  }
}

/// Gives the left triangles to pieces that would be left out, evenly by area: each of them stands for a share of the area of those that
/// stay out.
void deal_to_the_rest(const std::vector<Candidate>& candidates, Deal& deal) {
  double rest_m2 = 0.0;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (deal.chosen[i] == 0 && candidates[i].choices.size() > 1) rest_m2 += candidates[i].piece.projected_m2;
  constexpr double kStripTriangles = 2.0;
  const double share_m2 = rest_m2 * kStripTriangles / static_cast<double>(std::max<std::size_t>(deal.left, 1));
  double passed_m2 = 0.0, next_m2 = 0.0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const WoodPiece& piece = candidates[i].piece;
    const std::vector<Choice>& choices = candidates[i].choices;
    if (deal.chosen[i] != 0 || choices.size() < 2) continue;
    passed_m2 += piece.projected_m2;
    if (passed_m2 < next_m2 || choices[1].triangle_count > deal.left) continue;
    next_m2 += share_m2 * static_cast<double>(choices[1].triangle_count) / kStripTriangles;
    deal.take(candidates, i, 1);
  }
}

/// Distributes about target_count triangles. The weightiest piece of each material gets some in any case.
std::vector<std::size_t> deal_out(const std::vector<Candidate>& candidates, std::size_t target_count, LeftOut left_out) {
  const std::vector<Step> steps = steps_of(candidates);
  Deal deal{std::vector<std::size_t>(candidates.size(), 0), target_count};
  std::map<std::uint32_t, bool> material_shown;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].choices.size() > 1 && !std::exchange(material_shown[candidates[i].piece.material], true)) deal.take(candidates, i, 1);
  const std::size_t kept_back = left_out == LeftOut::merged ? std::min(deal.left, target_count / kRestShare) : 0;
  deal.left -= kept_back;
  deal_by_gain(candidates, steps, deal);
  deal.left += kept_back;
  deal_to_the_rest(candidates, deal);
  deal_by_gain(candidates, steps, deal);
  return std::move(deal.chosen);
}

/// The nearest proxy that may take a piece's area, among some on either side of it along the curve; kNone if there is none.
/// proxies  by curve rank
std::size_t nearest_taker(const std::vector<Candidate>& candidates, std::span<const std::size_t> proxies, const WoodPiece& piece,
                          const auto& may_take) {
  constexpr std::ptrdiff_t kLookedAt = 24;
  const auto rank_of = [&](std::size_t i) { return candidates[i].piece.curve_rank; };
  const auto middle = std::ranges::lower_bound(proxies, piece.curve_rank, {}, rank_of);
  const auto first = middle - std::min(kLookedAt, middle - proxies.begin());
  std::size_t nearest = kNone;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const std::size_t i : std::span(first, middle + std::min(kLookedAt, proxies.end() - middle))) {
    const double distance_m = glm::distance(candidates[i].piece.center, piece.center);
    if (distance_m < nearest_m && may_take(i)) nearest = i, nearest_m = distance_m;
  }
  return nearest;
}

/// The projected area of each piece's proxy, m2: its own, plus the area of pieces near it that are left out.
/// pixel_m  width to which it may grow in any case; 0: no proxy takes other pieces' area
std::vector<double> proxy_areas(const std::vector<Candidate>& candidates, const std::vector<std::size_t>& chosen, double pixel_m) {
  std::vector<double> areas_m2;
  std::vector<std::size_t> proxies;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    areas_m2.push_back(candidates[i].piece.projected_m2);
    if (candidates[i].choices[chosen[i]].kind == Choice::Kind::proxy) proxies.push_back(i);
  }
  std::ranges::sort(proxies, {}, [&](std::size_t i) { return candidates[i].piece.curve_rank; });
  for (std::size_t i = 0; i < candidates.size() && pixel_m > 0.0; ++i) {
    const WoodPiece& piece = candidates[i].piece;
    if (candidates[i].choices[chosen[i]].kind != Choice::Kind::nothing) continue;
    const std::size_t taker = nearest_taker(candidates, proxies, piece, [&](std::size_t k) {
      const WoodPiece& other = candidates[k].piece;
      return other.material == piece.material && piece.girth_m() >= kMinGirthShare * other.girth_m() &&
             areas_m2[k] + piece.projected_m2 <= std::max(kMaxGrowth, pixel_m / other.girth_m()) * other.projected_m2;
    });
    if (taker != kNone) areas_m2[taker] += piece.projected_m2;
  }
  return areas_m2;
}

/// The vertices of a piece by place: the corner of a box is three vertices, one for each side.
using Places = std::map<std::tuple<float, float, float>, Indices>;

std::tuple<float, float, float> place_of(const WoodPiece& piece, std::uint32_t vertex) {
  return {piece.positions[vertex].x, piece.positions[vertex].y, piece.positions[vertex].z};
}

Places places_of(const WoodPiece& piece) {
  Places places;
  for (std::uint32_t i = 0; i < piece.positions.size(); ++i) places[place_of(piece, i)].push_back(i);
  return places;
}

/// Unit normals of the vertices, equal for all in one place, so that a surface stays whole if its vertices move along them.
std::vector<glm::vec3> joint_normals(const Mesh& source, const WoodPiece& piece, const Places& places) {
  std::vector<glm::vec3> normals(piece.positions.size(), glm::vec3(0.0f));
  for (const auto& [place, vertices] : places) {
    glm::vec3 sum(0.0f);
    for (const std::uint32_t vertex : vertices) sum += source.normals[piece.vertices[vertex]];
    if (!(glm::length(sum) > 1e-6f)) continue;
    for (const std::uint32_t vertex : vertices) normals[vertex] = glm::normalize(sum);
  }
  return normals;
}

/// Thickens a simplified tube: its corners lie on the tube, its faces inside, so it is thinner. Moves the corners out until it is as thick
/// as the piece.
/// normals  from joint_normals
std::vector<glm::vec3> thickened(const WoodPiece& piece, const std::vector<glm::vec3>& normals, const Indices& indices) {
  constexpr double kMaxThickened = 0.5;  // radii of the tube that has the piece's volume and area
  const double now_m2 = projected_area_m2(piece.positions, indices), radius_m = 0.5 * piece.thickness_m();
  const double step_m = 0.02 * radius_m;
  if (!(now_m2 < piece.projected_m2) || !(step_m > 0.0)) return piece.positions;
  const auto moved = [&](double by_m) {
    std::vector<glm::vec3> positions = piece.positions;
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += static_cast<float>(by_m) * normals[i];
    return positions;
  };
  const double gained_m2 = projected_area_m2(moved(step_m), indices) - now_m2;
  if (!(gained_m2 > 0.0)) return piece.positions;
  return moved(std::min(step_m * (piece.projected_m2 - now_m2) / gained_m2, kMaxThickened * radius_m));
}

struct Corner {
  std::uint32_t vertex = 0;  ///< index in the piece
  glm::vec3 normal{0.0f};
};

/// The vertex and normal for a corner of a simplified piece. A simplifier keeps any one of the vertices in a place, so a side of a box
/// might be lit like the side round the corner. This takes the vertex whose normal is nearest to the face's, or the face's normal if even
/// that is far off.
/// face  unit
Corner corner_of(const Mesh& source, const WoodPiece& piece, const Indices& in_place, std::uint32_t vertex, const glm::vec3& face) {
  constexpr float kNearer = 1e-3f, kMinFacing = 0.25f;
  Corner corner{vertex, source.normals[piece.vertices[vertex]]};
  for (const std::uint32_t other : in_place) {
    const glm::vec3& normal = source.normals[piece.vertices[other]];
    if (glm::dot(normal, face) > glm::dot(corner.normal, face) + kNearer) corner = {other, normal};
  }
  if (glm::dot(corner.normal, face) < kMinFacing) corner.normal = face;
  return corner;
}

/// The face normal of a simplified piece's triangle, unit, on the side from which its source is lit; zero if it has none.
glm::vec3 lit_face(const std::array<glm::vec3, 3>& corners, const std::array<glm::vec3, 3>& joint_normals) {
  const glm::vec3 face = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const float length = glm::length(face);
  if (!(length > 0.0f)) return glm::vec3(0.0f);
  return face * (glm::dot(face, joint_normals[0] + joint_normals[1] + joint_normals[2]) < 0.0f ? -1.0f / length : 1.0f / length);
}

void append_piece(const Mesh& source, const WoodPiece& piece, const Indices& indices, Mesh& mesh) {
  const bool is_whole = indices.size() == piece.indices.size();
  const Places places = is_whole ? Places{} : places_of(piece);
  const std::vector<glm::vec3> normals = joint_normals(source, piece, places);
  const std::vector<glm::vec3> positions = is_whole ? piece.positions : thickened(piece, normals, indices);
  std::map<std::tuple<std::uint32_t, float, float, float>, std::uint32_t> appended;  // vertices of the mesh
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    const glm::vec3 face = is_whole ? glm::vec3(0.0f) : lit_face(at_corners(positions, indices, i), at_corners(normals, indices, i));
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = indices[i + k];
      const Corner corner = face == glm::vec3(0.0f) ? Corner{vertex, source.normals[piece.vertices[vertex]]}
                                                    : corner_of(source, piece, places.at(place_of(piece, vertex)), vertex, face);
      const auto [found, is_new] = appended.try_emplace({corner.vertex, corner.normal.x, corner.normal.y, corner.normal.z},
                                                        static_cast<std::uint32_t>(mesh.positions.size()));
      if (is_new) {
        mesh.positions.push_back(positions[corner.vertex]);
        mesh.normals.push_back(corner.normal);
        mesh.uvs.push_back(source.uvs[piece.vertices[corner.vertex]]);
      }
      mesh.indices.push_back(found->second);
    }
  }
  mesh.triangle_materials.insert(mesh.triangle_materials.end(), indices.size() / 3, piece.material);
}

Mesh simplify_pieces(const Mesh& source, std::vector<Candidate>& candidates, std::size_t target_count, LeftOut left_out) {
  const glm::vec3 extent = box_of(source.positions).extent();
  const double pixel_m =
      double{std::max({extent.x, extent.y, extent.z})} / (kPxPerRootTriangle * std::sqrt(static_cast<double>(target_count)));
  for (Candidate& candidate : candidates) set_choices(candidate, pixel_m);
  const std::vector<std::size_t> chosen = deal_out(candidates, target_count, left_out);
  const std::vector<double> areas_m2 = proxy_areas(candidates, chosen, left_out == LeftOut::merged ? pixel_m : 0.0);
  Mesh mesh;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const WoodPiece& piece = candidates[i].piece;
    const Choice& choice = candidates[i].choices[chosen[i]];
    if (choice.kind == Choice::Kind::proxy)
      append_proxy(source, piece, {choice.form, areas_m2[i], kGoldenAngle * static_cast<double>(i)}, mesh);
    if (choice.kind == Choice::Kind::simplified) append_piece(source, piece, candidates[i].versions[choice.version], mesh);
  }
  return mesh;
}

/// Triangles of a LoD, by material.
using Parts = std::map<std::uint32_t, Indices>;

/// Makes one mesh of all parts, in an order that suits a GPU's vertex cache.
Mesh merge(const Mesh& source, const Parts& parts) {
  Mesh merged{.positions = source.positions, .normals = source.normals, .uvs = source.uvs};
  for (const auto& [material, indices] : parts) {
    Indices ordered(indices.size());
    meshopt_optimizeVertexCache(ordered.data(), indices.data(), indices.size(), source.positions.size());
    merged.indices.insert(merged.indices.end(), ordered.begin(), ordered.end());
    merged.triangle_materials.resize(merged.indices.size() / 3, material);
  }
  return compact(merged);
}

Parts split_by_material(const Mesh& mesh) {
  Parts parts;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) parts[mesh.triangle_materials[i / 3]].push_back(mesh.indices[i]);
  return parts;
}

std::vector<Candidate> candidates_of(std::vector<WoodPiece> pieces) {
  std::vector<Candidate> candidates;
  for (WoodPiece& piece : pieces) candidates.push_back(candidate_of(std::move(piece)));
  return candidates;
}

/// The limbs of a piece that forks: it is farther from the best line than it is thick, and more of it than bumps is outside its largest
/// limb. Others stay as they are.
std::vector<WoodPiece> parts_of(const WoodPiece& piece) {
  constexpr double kMaxLargest = 0.9;  // share of the piece's area
  if (line_misfit_m2(piece, kMaxSections) > piece.thickness_m() * piece.thickness_m()) {
    std::vector<WoodPiece> limbs = limbs_of(piece);
    if (std::ranges::max(limbs, {}, &WoodPiece::area_m2).area_m2 < kMaxLargest * piece.area_m2) return limbs;
  }
  return {piece};
}

/// The wood's pieces, and, if a weighty one of them forks, the same with its limbs in its place.
std::vector<std::vector<Candidate>> ways_to_split(const Mesh& wood) {
  constexpr double kMinWeight = 0.01;  // share of the wood's
  std::vector<WoodPiece> pieces = split_wood(wood), limbs;
  double weight = 0.0;
  for (const WoodPiece& piece : pieces) weight += piece.weight();
  for (const WoodPiece& piece : pieces) {
    std::vector<WoodPiece> parts = piece.weight() > kMinWeight * weight ? parts_of(piece) : std::vector{piece};
    std::ranges::move(parts, std::back_inserter(limbs));
  }
  std::vector<std::vector<Candidate>> ways;
  const bool any_forks = limbs.size() > pieces.size();
  ways.push_back(candidates_of(std::move(pieces)));
  if (any_forks) ways.push_back(candidates_of(by_weight(std::move(limbs))));
  return ways;
}

}  // namespace

Mesh halve_wood(const Mesh& wood) {
  Parts parts = split_by_material(wood);
  for (auto& [material, indices] : parts) {
    const std::size_t target_count = std::max<std::size_t>(indices.size() / 6, 1);
    Indices clustered(indices.size());
    clustered.resize(meshopt_simplifySloppy(clustered.data(), indices.data(), indices.size(), &wood.positions[0].x, wood.positions.size(),
                                            sizeof(glm::vec3), 3 * target_count, kAnyError, nullptr));
    // Clusters may swallow wood that is all crumbs; then the first crumbs stay.
    if (clustered.empty()) clustered.assign(indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(3 * target_count));
    indices = std::move(clustered);
  }
  return merge(wood, parts);
}

std::vector<WoodLevel> wood_levels(const Mesh& wood) {
  std::vector<WoodLevel> levels;
  if (wood.indices.empty()) return levels;
  std::vector<std::vector<Candidate>> ways = ways_to_split(wood);
  levels.push_back({merge(wood, split_by_material(wood))});
  std::size_t target_count = wood.triangle_materials.size() / kReduction;
  std::size_t last_count = wood.triangle_materials.size();
  while (levels.size() < kMaxLods && last_count > kMinTriangles) {
    WoodLevel level;
    for (std::vector<Candidate>& candidates : ways)
      for (const LeftOut left_out : {LeftOut::merged, LeftOut::lost}) {
        Mesh mesh = simplify_pieces(wood, candidates, target_count, left_out);
        turn_to_normals(mesh);
        level.push_back(merge(mesh, split_by_material(mesh)));
      }
    const std::size_t count = level.front().triangle_materials.size();
    if (static_cast<double>(count) <= kMinProgress * static_cast<double>(last_count)) {
      levels.push_back(std::move(level));
      last_count = count;
    }
    target_count /= kReduction;
    if (target_count < kTubeTriangles) break;
  }
  return levels;
}

}  // namespace coppice::bake
