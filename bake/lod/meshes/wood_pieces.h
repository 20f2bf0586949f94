#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// A connected piece of wood of one material, or several that continue each other: trunk, bough, twig, spine, fruit.
struct WoodPiece {
  std::uint32_t material = 0;
  std::vector<std::uint32_t> vertices;  ///< in the source mesh
  std::vector<glm::vec3> positions;     ///< of those
  std::vector<std::uint32_t> indices;   ///< into `vertices`
  std::size_t part_count = 1;           ///< connected pieces that it was made of
  std::uint32_t curve_rank = 0;         ///< along a curve through all pieces: those of near ranks are mostly near
  // Its shape from afar.
  glm::dvec3 center{0.0};
  std::array<glm::dvec3, 3> axes{glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1)};  ///< unit; the first is its length's
  std::array<double, 3> spread_m{};    ///< standard deviations of its area along them, not rising
  glm::dvec3 facing{0.0};              ///< sum of its normals, by its area: 0 of what is closed, unit of a flat sheet
  double first_m = 0.0, last_m = 0.0;  ///< where it begins and ends along axes[0], from the centre
  double area_m2 = 0.0;
  double volume_m3 = 0.0;     ///< that it encloses, were its holes filled
  double projected_m2 = 0.0;  ///< as convex as it may be, mean over all directions
  [[nodiscard]] std::size_t triangle_count() const { return indices.size() / 3; }
  [[nodiscard]] double length_m() const { return last_m - first_m; }
  /// Diameter of the tube of this length and projected area.
  [[nodiscard]] double girth_m() const;
  /// Diameter of the tube of this volume and area, however it forks. Of a sheet nothing.
  [[nodiscard]] double thickness_m() const { return area_m2 > 0.0 ? 4.0 * volume_m3 / area_m2 : 0.0; }
  /// The squared error of leaving it out where it is thinner than a pixel: its projected area, of which the girth is the share of a pixel.
  [[nodiscard]] double weight() const { return projected_m2 * girth_m(); }
};

/// The mean over all directions of the projected area of what is convex, or a part of what is convex (Cauchy: a quarter of what is closed,
/// half of a sheet). facing  as WoodPiece::facing
double projected_area_m2(double area_m2, const glm::dvec3& facing);
/// The same of triangles.
double projected_area_m2(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices);

/// Pieces of a wood, the weightiest first. Tubes that continue each other end to end, as the internodes of a cane, are one. Pieces whose
/// weights differ by less than a factor of two are in an order that spreads over the plant, so that any first of them are.
std::vector<WoodPiece> split_wood(const Mesh& wood);

/// A place on a piece and how much of its area is there.
struct AreaSample {
  glm::dvec3 at{0.0};
  double area_m2 = 0.0;
};
/// Edge midpoints of triangles, split until no edge is longer than `spacing_m`: exact for second moments. spacing_m  may be infinite
std::vector<AreaSample> area_samples(const WoodPiece& piece, double spacing_m);

}  // namespace coppice::bake
