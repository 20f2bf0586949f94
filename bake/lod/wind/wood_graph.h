#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// The surface of wood as points and the edges between them, all in one piece.
struct WoodGraph {
  std::vector<glm::vec3> points;           ///< welded vertices, then middles of long edges
  std::vector<std::uint32_t> pieces;       ///< [points] what is connected in the mesh has one number
  std::vector<double> piece_areas_m2;      ///< [points] of a piece at its number
  std::vector<std::uint32_t> first_links;  ///< [points + 1] into links
  std::vector<std::uint32_t> links;        ///< points that are next to a point, ascending

  [[nodiscard]] std::span<const std::uint32_t> links_of(std::uint32_t point) const {
    return std::span(links).subspan(first_links[point], first_links[point + 1] - first_links[point]);
  }
};

/// Triangles are split until no edge is longer than spacing_m, so that a tube of few triangles has rings all along. What the mesh leaves
/// loose is linked to the nearest point of the rest, the nearest pieces first.
WoodGraph wood_graph(const Mesh& wood, double spacing_m);

}  // namespace coppice::bake
