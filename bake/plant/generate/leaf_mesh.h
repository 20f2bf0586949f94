#pragma once

#include <glm/vec3.hpp>

#include "plant.h"
#include "species.h"

namespace coppice::bake {

/// One leaf of unit length: x to the side, y the upper surface's normal, z from stalk to tip. Texture coordinates: u across, v = 0 at the
/// tip. One connected component, a strip of triangles from the midrib to the rim on either side, wound with the normals.
Mesh build_leaf(const LeafOutline& outline);

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
void append_leaf(Mesh& mesh, const Mesh& leaf, const LeafPose& pose, std::uint32_t material);

/// Paints an image of the leaf that fills the unit square of its texture coordinates: veins on a paler or darker blade around linear 1, to
/// be multiplied by the leaf colour. Alpha is the outline, grown by about a texel so that it never cuts the leaf mesh. It gives a leaf
/// *quad* the leaf's shape.
Image paint_leaf(const LeafOutline& outline, const LeafPaint& paint);

/// Alpha below this is a hole.
inline constexpr float kLeafAlphaCutoff = 0.5f;

}  // namespace coppice::bake
