#pragma once

#include "plant.h"

namespace coppice::bake {

/// The surface of wood as points and the edges between them, connected as a whole.
struct WoodGraph {
  std::vector<glm::vec3> points;           ///< welded vertices, then middles of long edges
  std::vector<std::uint32_t> corners;      ///< [wood.indices.size()] the point of each corner of a triangle
  std::vector<std::uint32_t> pieces;       ///< [points] points that the mesh connects have the same number
  std::vector<double> piece_areas_m2;      ///< [points] area of a piece, at its number
  std::vector<std::uint32_t> first_links;  ///< [points + 1] indices into `links`
  std::vector<std::uint32_t> links;        ///< neighbours of each point, ascending

  [[nodiscard]] std::span<const std::uint32_t> links_of(std::uint32_t point) const {
    return std::span(links).subspan(first_links[point], first_links[point + 1] - first_links[point]);
  }
};

double triangle_m2(const std::array<glm::vec3, 3>& corners);

/// Builds the graph. Triangles are split until no edge is longer than spacing_m, so that a tube of few triangles has rings all along. Loose
/// pieces of the mesh are linked to the nearest point of the rest, the nearest pieces first.
WoodGraph wood_graph(const Mesh& wood, double spacing_m);

}  // namespace coppice::bake
