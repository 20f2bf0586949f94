#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// Where a plant is held: its wood's lowest end, or its highest where all of it hangs below its origin.
struct Stand {
  double base_y_m = 0.0;  ///< where it stands; the lowest point of one that hangs
  double top_y_m = 0.0;   ///< >= base_y_m
  bool hangs = false;

  [[nodiscard]] double height_m() const { return top_y_m - base_y_m; }
};

/// A piece of a stem, branch or twig: what of the wood's surface is about as far from the ground along the surface, and in one piece.
struct Ring {
  std::uint32_t parent = kNone;  ///< an earlier ring; kNone where it stands on the ground
  glm::dvec3 center{0.0};
  double radius_m = 0.0;  ///< mean distance of the surface from its axis; > 0
  double length_m = 0.0;  ///< from the parent's centre; of a first ring 0
};

/// The wood as a tree of rings, parents first. Any triangles will do: pieces that the mesh leaves loose grow out of what is nearest, and
/// of those that touch the ground all that are not slight stand on it.
/// ring_m  how far apart rings are, along the surface; further of wood of very much surface
/// returns  none without wood
std::vector<Ring> wood_skeleton(const Mesh& wood, const Stand& stand, double ring_m);

}  // namespace coppice::bake
