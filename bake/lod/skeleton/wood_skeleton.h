#pragma once

#include "plant.h"

namespace coppice::bake {

/// Where a plant is held: at its wood's lowest end, or at its highest if all of it hangs below its origin.
struct Stand {
  double base_y_m = 0.0;  ///< where it stands; the lowest point if it hangs
  double top_y_m = 0.0;   ///< >= base_y_m
  bool hangs = false;

  [[nodiscard]] double height_m() const { return top_y_m - base_y_m; }
};

/// Where a plant with these lowest and highest points is held.
Stand stand_of(double low_y_m, double high_y_m);

/// A piece of a stem, branch or twig: a connected part of the wood's surface, all about as far from the ground along the surface.
struct Ring {
  std::uint32_t parent = kNone;  ///< an earlier ring; kNone if it stands on the ground
  glm::dvec3 center{0.0};
  double radius_m = 0.0;  ///< mean distance of the surface from the ring's axis; > 0
  double length_m = 0.0;  ///< from the parent's centre; 0 for a first ring
};

/// The value that `tenths` tenths of all values are below; 0 without values.
double quantile(std::vector<double> values, std::size_t tenths);

/// Computes the wood as a tree of rings, parents first. Any triangles will do: loose pieces grow out of the nearest ones, and of the pieces
/// that touch the ground, all but slight ones stand on it.
/// ring_m   distance between rings, along the surface; larger if the wood has very much surface
/// returns  none without wood
std::vector<Ring> wood_skeleton(const Mesh& wood, const Stand& stand, double ring_m);

/// The limb of each triangle: a stem, branch or twig from where it leaves another to its tip. Where rings fork, the limb goes on to the tip
/// that is farthest from the ground. Limbs are numbered from 0, and a limb comes after the one that bears it.
/// stand, ring_m  as above
std::vector<std::uint32_t> wood_limbs(const Mesh& wood, const Stand& stand, double ring_m);

/// The same for rings. parents: the parent of each, an earlier one or kNone
std::vector<std::uint32_t> limbs_of_rings(const std::vector<std::uint32_t>& parents);

}  // namespace coppice::bake
