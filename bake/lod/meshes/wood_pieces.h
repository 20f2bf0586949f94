#pragma once

#include "plant.h"

namespace coppice::bake {

/// A connected piece of wood of one material, or several pieces that continue each other: trunk, bough, twig, spine, fruit.
struct WoodPiece {
  std::uint32_t material = 0;
  std::vector<std::uint32_t> vertices;  ///< indices in the source mesh
  std::vector<glm::vec3> positions;     ///< [vertices.size()]
  std::vector<std::uint32_t> indices;   ///< indices into `vertices`
  std::size_t part_count = 1;           ///< how many connected pieces it was made of
  std::uint32_t curve_rank = 0;         ///< rank along a curve through all pieces: pieces of similar rank are mostly near each other
  // The next members are its shape from afar.
  glm::dvec3 center{0.0};
  std::array<glm::dvec3, 3> axes{glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1)};  ///< unit; the first is its length's
  std::array<double, 3> spread_m{};    ///< standard deviations of its area along the axes, non-increasing
  glm::dvec3 facing{0.0};              ///< sum of its normals over its area: 0 if it is closed, a unit vector for a flat sheet
  double first_m = 0.0, last_m = 0.0;  ///< where it begins and ends along axes[0], from the centre
  double area_m2 = 0.0;
  double volume_m3 = 0.0;     ///< enclosed volume, with its holes filled
  double projected_m2 = 0.0;  ///< mean over all directions, as if it were convex
  [[nodiscard]] std::size_t triangle_count() const { return indices.size() / 3; }
  [[nodiscard]] double length_m() const { return last_m - first_m; }
  /// Diameter of a tube with this length and projected area.
  [[nodiscard]] double girth_m() const;
  /// Diameter of a tube with this volume and area, however the piece forks. 0 for a sheet.
  [[nodiscard]] double thickness_m() const { return area_m2 > 0.0 ? 4.0 * volume_m3 / area_m2 : 0.0; }
  /// Squared error of leaving the piece out where it is thinner than a pixel: its projected area, in which the girth is the share of a
  /// pixel.
  [[nodiscard]] double weight() const { return projected_m2 * girth_m(); }
};

/// Mean projected area over all directions of a convex surface, or a part of one (Cauchy: a quarter of a closed surface's area, half of a
/// sheet's).
/// facing  as WoodPiece::facing
double projected_area_m2(double area_m2, const glm::dvec3& facing);
/// The same for triangles.
double projected_area_m2(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& indices);

/// Splits wood into pieces, by weight. Tubes that continue each other end to end, like the internodes of a cane, are one piece.
std::vector<WoodPiece> split_wood(const Mesh& wood);

/// Splits a piece that forks into its limbs (wood_skeleton.h), in no particular order; a copy of the piece if it has only one.
std::vector<WoodPiece> limbs_of(const WoodPiece& piece);

/// Sorts pieces, the weightiest first, and sets their ranks. Pieces whose weights differ by less than a factor of two are in an order that
/// spreads over the plant, so that any first few of them do.
std::vector<WoodPiece> by_weight(std::vector<WoodPiece> pieces);

/// A place on a piece, and how much of its area is there.
struct AreaSample {
  glm::dvec3 at{0.0};
  double area_m2 = 0.0;
};
/// Edge midpoints of triangles, which are split until no edge is longer than `spacing_m`: exact for second moments. spacing_m  may be
/// infinite
std::vector<AreaSample> area_samples(const WoodPiece& piece, double spacing_m);

}  // namespace coppice::bake
