#include "wood_proxies.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

struct Knot {
  glm::dvec3 at{0.0};
  double area_m2 = 0.0;  ///< area of the surface nearest to it
  double width_m = 0.0;  ///< surface per metre of the line
};

/// The knot below a place on a line, and the place's share of the way to the next.
struct Between {
  std::size_t lower = 0;
  double share = 0.0;
};

Between between_knots(const WoodPiece& piece, double at_m, std::uint32_t sections) {
  const double place = std::clamp((at_m - piece.first_m) / piece.length_m(), 0.0, 1.0) * sections;
  const auto lower = std::min(static_cast<std::size_t>(place), std::size_t{sections} - 1);
  return {lower, place - static_cast<double>(lower)};
}

std::vector<AreaSample> line_samples(const WoodPiece& piece, std::uint32_t sections) {
  return area_samples(piece, piece.length_m() / (2.0 * sections));
}

/// Fits widths that vary linearly from knot to knot to the piece's own (least squares). So even a line of one section narrows towards the
/// tip of its bough, and the tip does not stand out of the crown as a stub.
void fit_widths(std::vector<Knot>& knots) {
  constexpr double kMinShare = 0.1;  // relative to the mean width: anything thinner has no side to be lit
  // The mass matrix of a line's hat functions, without its common factor of a sixth: each knot's row, eliminated downwards.
  std::vector<double> diagonal(knots.size(), 0.0), upper(knots.size(), 0.0), right(knots.size(), 0.0);
  double area_m2 = 0.0, length_m = 0.0;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    right[i] = 6.0 * knots[i].area_m2;
    area_m2 += knots[i].area_m2;
    if (i + 1 == knots.size()) break;
    upper[i] = glm::distance(knots[i].at, knots[i + 1].at);
    length_m += upper[i];
    diagonal[i] += 2.0 * upper[i];
    diagonal[i + 1] += 2.0 * upper[i];
  }
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const double factor = upper[i - 1] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    right[i] -= factor * right[i - 1];
  }
  for (std::size_t i = knots.size(); i-- > 0;)
    knots[i].width_m = (right[i] - (i + 1 < knots.size() ? upper[i] * knots[i + 1].width_m : 0.0)) / diagonal[i];
  for (Knot& knot : knots) knot.width_m = std::max(knot.width_m, kMinShare * area_m2 / length_m);
}

/// The line through the middle of the piece's surface. Its knots are evenly spaced along axes[0].
std::vector<Knot> line_of(const WoodPiece& piece, const std::vector<AreaSample>& samples, std::uint32_t sections) {
  std::vector<Knot> knots(std::size_t{sections} + 1);
  std::vector<glm::dvec3> aside(knots.size(), glm::dvec3(0.0));
  for (const AreaSample& sample : samples) {
    const glm::dvec3 arm = sample.at - piece.center;
    const double at_m = glm::dot(arm, piece.axes[0]);
    const Between place = between_knots(piece, at_m, sections);
    for (const auto& [knot, share] : {std::pair{place.lower, 1.0 - place.share}, std::pair{place.lower + 1, place.share}}) {
      knots[knot].area_m2 += share * sample.area_m2;
      aside[knot] += share * sample.area_m2 * (arm - at_m * piece.axes[0]);
    }
  }
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const double at_m = piece.first_m + piece.length_m() * static_cast<double>(i) / sections;
    knots[i].at = piece.center + at_m * piece.axes[0];
    if (knots[i].area_m2 > 0.0) knots[i].at += aside[i] / knots[i].area_m2;
  }
  fit_widths(knots);
  return knots;
}

/// Corners and normals of a body before its final size.
struct Body {
  std::vector<glm::dvec3> centers;  ///< [corner] the centre of its ring, from which the body grows
  std::vector<glm::vec3> positions;
  std::vector<glm::dvec3> outward;
  std::vector<std::uint32_t> indices;
};

void add_corner(Body& body, const glm::dvec3& center, const glm::dvec3& arm) {
  body.centers.push_back(center);
  body.positions.emplace_back(center + arm);
  body.outward.push_back(glm::length(arm) > 0.0 ? glm::normalize(arm) : arm);
}

/// Adds an ellipse of corners round a place on the piece.
void add_ring(Body& body, const glm::dvec3& center, const std::array<glm::dvec3, 2>& radii, std::uint32_t sides) {
  for (std::uint32_t side = 0; side < sides; ++side) {
    const double angle = 2.0 * std::numbers::pi * side / sides;
    add_corner(body, center, std::cos(angle) * radii[0] + std::sin(angle) * radii[1]);
  }
}

/// Gives a line's rings the widths of their knots, but for a common factor. side  direction of the first corner; other_side  replaces it
/// where it is along the line
Body line_body(const std::vector<Knot>& knots, std::uint32_t sides, const glm::dvec3& side, const glm::dvec3& other_side) {
  Body body;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const glm::dvec3 way = knots[std::min(i + 1, knots.size() - 1)].at - knots[i > 0 ? i - 1 : 0].at;
    const glm::dvec3 along = glm::normalize(way);
    glm::dvec3 first = glm::cross(glm::cross(along, side), along);
    if (glm::length(first) < 1e-3) first = glm::cross(along, other_side);
    first = glm::normalize(first);
    add_ring(body, knots[i].at, {knots[i].width_m * first, knots[i].width_m * glm::cross(along, first)}, sides);
  }
  for (std::uint32_t ring = 0; ring + 1 < knots.size(); ++ring)
    for (std::uint32_t k = 0; k < (sides == 2 ? 1 : sides); ++k) {
      const std::uint32_t a = ring * sides + k, b = ring * sides + (k + 1) % sides, c = a + sides, d = b + sides;
      body.indices.insert(body.indices.end(), {a, b, c, c, b, d});
    }
  return body;
}

Body spindle_body(const WoodPiece& piece, std::uint32_t sides) {
  Body body;
  // A thin shell gets something of a third axis, so that it has two sides.
  constexpr double kMinSpread = 0.02;
  std::array<glm::dvec3, 3> axes{};
  for (std::size_t k = 0; k < 3; ++k) axes[k] = std::max(piece.spread_m[k], kMinSpread * piece.spread_m[0]) * piece.axes[k];
  add_ring(body, piece.center, {axes[1], axes[2]}, sides);
  add_corner(body, piece.center, -axes[0]);
  add_corner(body, piece.center, axes[0]);
  for (std::uint32_t side = 0; side < sides; ++side) {
    const std::uint32_t next = (side + 1) % sides;
    body.indices.insert(body.indices.end(), {next, side, sides, side, next, sides + 1});
  }
  return body;
}

/// Scales a body to a projected area. A spindle's area grows as the square of its size, a line's nearly as its width: after three passes it
/// is almost exact.
void resize(Body& body, double projected_m2, bool is_line) {
  constexpr int kTimes = 3;
  for (int time = 0; time < kTimes; ++time) {
    const double now_m2 = projected_area_m2(body.positions, body.indices);
    if (!(now_m2 > 0.0)) return;
    const double factor = is_line ? projected_m2 / now_m2 : std::sqrt(projected_m2 / now_m2);
    for (std::size_t i = 0; i < body.positions.size(); ++i)
      body.positions[i] = glm::vec3(body.centers[i] + factor * (glm::dvec3(body.positions[i]) - body.centers[i]));
  }
}

/// The direction of the first side. A flat piece keeps its plane, a round one is turned.
glm::dvec3 first_side(const WoodPiece& piece, double turn) {
  constexpr double kFlat = 0.3;
  if (piece.spread_m[2] < kFlat * piece.spread_m[1]) return piece.axes[1];
  return std::cos(turn) * piece.axes[1] + std::sin(turn) * piece.axes[2];
}

std::uint32_t nearest_vertex(const WoodPiece& piece, const glm::vec3& place) {
  const auto squared_m2 = [&](const glm::vec3& position) { return glm::dot(position - place, position - place); };
  const auto nearest = std::ranges::min_element(piece.positions, {}, squared_m2);
  return piece.vertices[static_cast<std::size_t>(nearest - piece.positions.begin())];
}

}  // namespace

double line_misfit_m2(const WoodPiece& piece, std::uint32_t sections) {
  if (!(piece.length_m() > 0.0) || !(piece.projected_m2 > 0.0)) return 0.0;
  const std::vector<AreaSample> samples = line_samples(piece, sections);
  const std::vector<Knot> knots = line_of(piece, samples, sections);
  double excess = 0.0, area_m2 = 0.0;
  for (const Knot& knot : knots) area_m2 += knot.area_m2;
  for (const AreaSample& sample : samples) {
    const Between place = between_knots(piece, glm::dot(sample.at - piece.center, piece.axes[0]), sections);
    const Knot& from = knots[place.lower];
    const Knot& to = knots[place.lower + 1];
    const glm::dvec3 aside = sample.at - glm::mix(from.at, to.at, place.share);
    const double tube_m = 0.5 * piece.girth_m() * glm::mix(from.width_m, to.width_m, place.share) * piece.length_m() / area_m2;
    excess += sample.area_m2 * (glm::dot(aside, aside) - tube_m * tube_m);
  }
  return area_m2 > 0.0 ? std::max(excess / area_m2, 0.0) : 0.0;
}

void append_proxy(const Mesh& source, const WoodPiece& piece, const ProxyDesc& desc, Mesh& mesh) {
  if (!(piece.length_m() > 0.0) || !(piece.projected_m2 > 0.0)) return;
  const bool is_line = desc.form.sections > 0;
  const auto line = [&] { return line_of(piece, line_samples(piece, desc.form.sections), desc.form.sections); };
  Body body =
      is_line ? line_body(line(), desc.form.sides, first_side(piece, desc.turn), piece.axes[0]) : spindle_body(piece, desc.form.sides);
  resize(body, desc.projected_m2, is_line);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const double openness = std::min(glm::length(piece.facing), 1.0);
  for (std::size_t i = 0; i < body.positions.size(); ++i) {
    const std::uint32_t vertex = nearest_vertex(piece, body.positions[i]);
    const glm::dvec3 normal = (1.0 - openness) * body.outward[i] + piece.facing;
    mesh.positions.push_back(body.positions[i]);
    mesh.normals.push_back(glm::length(normal) > 1e-6 ? glm::vec3(glm::normalize(normal)) : source.normals[vertex]);
    mesh.uvs.push_back(source.uvs[vertex]);
  }
  for (const std::uint32_t index : body.indices) mesh.indices.push_back(first + index);
  mesh.triangle_materials.insert(mesh.triangle_materials.end(), body.indices.size() / 3, piece.material);
}

}  // namespace coppice::bake
