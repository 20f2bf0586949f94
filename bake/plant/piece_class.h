#pragma once

#include <cstdint>
#include <string>

namespace coppice::bake {

/// What becomes of a piece of the source's surface.
enum class PlantPart : std::uint8_t { leaf, wood, dropped };

/// Evidence for leaves (above 0) or for wood (below): see find_leaves.h.
struct LeafEvidence {
  double name = 0.0, holes = 0.0, colour = 0.0, flatness = 0.0, repetition = 0.0, size = 0.0, company = 0.0;
  [[nodiscard]] double sum() const { return name + holes + colour + flatness + repetition + size + company; }
};

/// The pieces of one material that have equal numbers of triangles and of points, and what became of them.
struct PieceClass {
  std::uint32_t material = 0;
  std::uint32_t triangle_count = 0, point_count = 0;  ///< each piece has so many; 0 for the class of pieces without area
  std::uint32_t piece_count = 0;
  std::uint64_t total_triangles = 0;
  double length_m = 0.0, elongation = 0.0, flatness = 0.0;  ///< medians; see piece_shape.h, elongation is length over width
  double slenderness = 0.0;                                 ///< median of length^2 over area: bends do not change it much
  double low_m = 0.0, high_m = 0.0;                         ///< heights: 2 % of the pieces reach below low_m, and above high_m
  LeafEvidence evidence;                                    ///< 0 where a rule decided
  PlantPart part = PlantPart::wood;
  bool is_shell = false;  ///< its material speaks for leaves, but it cannot be split into them
  std::string reason;     ///< why, for a person
};

}  // namespace coppice::bake
