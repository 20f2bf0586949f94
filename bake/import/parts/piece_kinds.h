#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "piece_points.h"
#include "piece_shape.h"
#include "plant.h"

namespace coppice::bake {

/// How many alike pieces are no accident.
inline constexpr std::uint32_t kRepeated = 8;

/// A small piece of surface. Its points are numbered in the order in which its triangles name them, so that copies number theirs alike.
/// Triangles without area, and repeated ones, are left out.
struct NumberedPiece {
  std::uint32_t first_triangle = 0;
  std::vector<std::uint32_t> points;    ///< numbers in Points
  std::vector<std::uint32_t> vertices;  ///< [points.size()] the mesh's first vertex at each
  std::vector<std::uint32_t> corners;   ///< 3 a triangle, numbers of points; may be empty
  std::uint32_t topology = kNone;       ///< equal for pieces with the same corners and material
  std::uint32_t kind = kNone;           ///< see KindTable; kNone: it is not repeated
};

/// triangles  the piece's, ascending
NumberedPiece number_piece(const Mesh& mesh, const Points& points, std::span<const std::uint32_t> triangles);

/// Copies of one piece, wherever they are, and however turned, scaled or bent along their edges.
struct PieceKind {
  PieceShape shape;             ///< the first copy's
  bool has_image_part = false;  ///< all show one part of the image
  std::uint32_t count = 0;
};

struct KindTable {
  std::vector<PieceKind> kinds;
  std::vector<std::uint32_t> topology_counts;  ///< how many pieces have each topology
};

/// Finds out which pieces are copies and fills in their topology and kind. If the triangles of equally large pieces come in many orders,
/// their points are renumbered by their places.
KindTable find_kinds(const Mesh& mesh, std::vector<NumberedPiece>& pieces);

}  // namespace coppice::bake
