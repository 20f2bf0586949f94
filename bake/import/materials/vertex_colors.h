#pragma once

#include <span>
#include <string>
#include <vector>

#include "plant.h"
#include "triangle_soup.h"

namespace coppice::bake {

/// Turns vertex colours into tints of triangles. Each material's base colour is multiplied by their mean over its area; the mesh's
/// triangle_tints hold each triangle's mean relative to that, by which split_materials distinguishes pieces. A plant's vertices have no
/// colours of their own. Engines also store wind weights in vertex colours: such weights (looks_like_wind) are no colours and
/// are left out, with a warning. Alpha is not used; a warning says so if it varies.
void apply_vertex_colors(TriangleSoup& soup, std::vector<Material>& materials, std::vector<std::string>& warnings);

/// A vertex of one material with its colour.
struct ColoredVertex {
  glm::vec3 position{0.0f};
  glm::vec3 color{0.0f};    ///< linear
  std::uint32_t piece = 0;  ///< vertices of one connected piece have the same number
};

/// Whether the channels are wind weights rather than colours. In a weight one channel grows with height, or from one end of each piece to
/// the other, or is one value a piece that jumps from piece to piece; and the other channels have nothing to do with it: they are 0 or 1
/// throughout, or vary by themselves. Channels of colours vary together. Greys are colours (light in a crown) unless they vary like a
/// weight over all of 0 to 1.
bool looks_like_wind(std::span<const ColoredVertex> vertices);

}  // namespace coppice::bake
