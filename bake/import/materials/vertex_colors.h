#pragma once

#include <span>
#include <string>
#include <vector>

#include "plant.h"
#include "triangle_soup.h"

namespace coppice::bake {

/// Vertex colours become tints of triangles: each material's base colour is multiplied by their mean over its area, and triangle_tints of
/// the mesh are what each triangle's mean is of that (split_materials tells pieces by them). A plant's vertices have no colours of their
/// own. Engines also keep in them how wind moves a plant: such weights (looks_like_wind, wind_words.h) are no colours and are left out,
/// with a warning. Alpha is not used; a warning says so where it differs.
void apply_vertex_colors(TriangleSoup& soup, std::vector<Material>& materials, std::vector<std::string>& warnings);

/// Vertex colours of one material.
struct ColoredVertex {
  glm::vec3 position{0.0f};
  glm::vec3 color{0.0f};    ///< linear
  std::uint32_t piece = 0;  ///< vertices of one connected piece have one number
};

/// Whether the channels are weights rather than colours: one grows with height, or in each piece from one end to the other, or is one value
/// a piece that jumps from piece to piece, and the others have nothing to do with it: they are 0 or 1 throughout or vary by themselves.
/// Channels of colours vary together. Greys are colours (light in a crown) unless they run all the way from 0 to 1 so.
bool looks_like_wind(std::span<const ColoredVertex> vertices);

}  // namespace coppice::bake
