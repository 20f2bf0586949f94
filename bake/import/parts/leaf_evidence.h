#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "class_rules.h"
#include "leaf_pieces.h"
#include "piece_shape.h"
#include "plant.h"

namespace coppice::bake {

struct ClassedPieces {
  std::vector<PieceClass> classes;      ///< by material, then most pieces first
  std::vector<double> bulks;            ///< [class count] medians; see piece_shape.h
  std::vector<std::uint32_t> class_of;  ///< [piece count] kNone for pieces that are left out
};

/// Groups the pieces by material, triangle and point count.
/// shapes    [pieces.ranges.size()]
/// left_out  [pieces.ranges.size()]
ClassedPieces class_pieces(const Mesh& mesh, const Pieces& pieces, const std::vector<PieceShape>& shapes,
                           const std::vector<bool>& left_out);

/// A plant's surface in pieces, and what they show. Holds references.
struct SurfacePieces {
  const Mesh& mesh;
  const Pieces& pieces;
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
  double extent_m = 0.0;  ///< diagonal of the plant's box
};

/// Fills in evidence, part and reason of each class, as find_leaves.h says.
void judge_classes(const SurfacePieces& surface, const std::vector<std::vector<MaterialRule>>& rules, ClassedPieces& classed);

/// For a plant without leaves: makes leaves of the sheets that judge_classes() found too few, too large or too plain (find_leaves.h).
/// Returns whether there are any.
bool judge_sheets(ClassedPieces& classed);

}  // namespace coppice::bake
