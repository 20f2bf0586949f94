#pragma once

#include <cstdint>

#include "plant.h"
#include "wood_pieces.h"

namespace coppice::bake {

/// A body of few triangles in a piece's place. Its projected area, mean over all directions, is what is asked for, so that a piece thinner
/// than a pixel keeps its part of the picture.
struct StandIn {
  /// Of the line that follows the piece. 0: no line, but a spindle with the piece's three axes.
  std::uint32_t sections = 1;
  /// 2: a flat strip, of which the eye sees more or less as it is turned. 3 and more: a tube of so many sides, open at its ends.
  std::uint32_t sides = 2;
  [[nodiscard]] std::uint32_t triangle_count() const { return sides == 2 ? 2 * sections : 2 * sides * (sections > 0 ? sections : 1); }
};

/// How much further from the line of so many sections the piece's surface is than that of a tube of its girth: difference of the mean
/// squares, m2, at least 0. Large where the piece bends more than the line, or forks.
double line_misfit_m2(const WoodPiece& piece, std::uint32_t sections);

/// What is asked of a stand-in.
struct StandInDesc {
  StandIn form;
  double projected_m2 = 0.0;
  double turn = 0.0;  ///< radians: where the first side of a round piece's line points. Strips that differ in it are not all seen by their
                      ///< edge at once
};

/// Appends it to `mesh`. Texture coordinates are those of the nearest vertex of the piece in `source`; normals point away from its line, as
/// far as the piece is closed, or where its sheet faces. Nothing where the piece has no area.
void append_stand_in(const Mesh& source, const WoodPiece& piece, const StandInDesc& desc, Mesh& mesh);

}  // namespace coppice::bake
