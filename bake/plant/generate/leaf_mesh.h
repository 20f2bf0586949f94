#pragma once

#include <glm/vec3.hpp>

#include "plant.h"
#include "species.h"

namespace coppice::bake {

/// One leaf of unit length: x to the side, y the upper surface's normal, z from stalk to tip. Texture coordinates: u across, v = 0 at the
/// tip.
struct LeafTemplate {
  Mesh mesh;  ///< one connected component, triangles wound with the normals
};

/// Triangulates an outline: a strip from the midrib to the rim on either side.
LeafTemplate build_leaf(const LeafOutline& outline);

/// Says where a leaf is. The axes are unit vectors at right angles.
struct LeafPose {
  glm::vec3 stalk{0.0f};   ///< the leaf's first point, at the petiole's end
  glm::vec3 along{0.0f};   ///< stalk to tip
  glm::vec3 normal{0.0f};  ///< the upper surface's, unit
  float length_m = 0.0f;
  float width_scale = 1.0f;
};

/// Maps a point of the unit leaf to plant space.
glm::vec3 posed(const LeafPose& pose, const glm::vec3& point);

/// Appends a leaf with all its triangles. They share no vertex with earlier ones.
void append_leaf(Mesh& mesh, const LeafTemplate& leaf, const LeafPose& pose, std::uint32_t material);

}  // namespace coppice::bake
