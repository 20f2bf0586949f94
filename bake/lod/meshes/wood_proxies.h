#pragma once

#include "plant.h"
#include "wood_pieces.h"

namespace coppice::bake {

/// A proxy: a body of few triangles in a piece's place. Its mean projected area over all directions is given, so that a piece thinner than
/// a pixel keeps its part of the image.
struct Proxy {
  /// Sections of the line that follows the piece. 0: no line, but a spindle with the piece's three axes.
  std::uint32_t sections = 1;
  /// 2: a flat strip, which shows more or less as it turns. 3 and more: a tube of so many sides, open at its ends.
  std::uint32_t sides = 2;
  [[nodiscard]] std::uint32_t triangle_count() const { return sides == 2 ? 2 * sections : 2 * sides * (sections > 0 ? sections : 1); }
};

/// How much farther the piece's surface is from a line of so many sections than the surface of a tube of its girth: difference of the mean
/// squares, m2, at least 0. Large if the piece bends more than the line, or forks.
double line_misfit_m2(const WoodPiece& piece, std::uint32_t sections);

/// Describes a proxy.
struct ProxyDesc {
  Proxy form;
  double projected_m2 = 0.0;
  double turn = 0.0;  ///< radians: direction of the first side of a round piece's line. It varies, so that not all strips are seen by their
                      ///< edge at once.
};

/// Appends a proxy to `mesh`. Texture coordinates are those of the nearest vertex of the piece in `source`. Normals point away from the
/// proxy's line as far as the piece is closed, or where its sheet faces. Appends nothing if the piece has no area.
void append_proxy(const Mesh& source, const WoodPiece& piece, const ProxyDesc& desc, Mesh& mesh);

}  // namespace coppice::bake
