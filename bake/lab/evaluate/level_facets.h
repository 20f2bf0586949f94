#pragma once

// How a shape that stands for many leaves looks from one camera: which normals it shows, and where rays meet it.

#include <vector>

#include <glm/vec3.hpp>

#include "evaluation_render.h"
#include "level.h"

namespace coppice::bake {

/// A needle as a ribbon whose face turns to a point. There is none if the needle points at it, or has no length or width.
struct NeedleRibbon {
  Mesh mesh;
  /// Normals of flat leaves, rolled about the needle's axis in eight even steps and weighted by the area that each shows.
  std::vector<UnlitImage::Facet> facets;
};
NeedleRibbon ribbon_towards(const Needle& needle, const glm::dvec3& camera);

/// The leaves of a voxel as seen from a far point.
struct VoxelFacets {
  double area_m2 = 0.0;                   ///< area across the line of sight
  std::vector<UnlitImage::Facet> facets;  ///< on the point's side
};
VoxelFacets facets_towards(const Voxel& voxel, const glm::dvec3& camera);

/// The part of a ray inside a box, in lengths of `ray`; far <= near: none.
struct BoxHit {
  double near = 0.0, far = 0.0;
};
BoxHit hit_box(const glm::dvec3& from, const glm::dvec3& ray, const glm::dvec3& center, double half_m);

}  // namespace coppice::bake
