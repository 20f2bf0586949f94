#pragma once

#include <vector>

#include "leaf_mesh.h"
#include "skeleton.h"

namespace coppice::bake {

/// A leaf and the end of its petiole that is inside the twig.
struct PlacedLeaf {
  LeafPose pose;
  glm::vec3 petiole_start{0.0f};
};

/// Places exactly species.leaf_count leaves on the leaf-bearing stems, in proportion to length times density, the last of a stem at its
/// tip. Vertices of two leaves are at least `kLeafGap` of the skeleton's box diagonal apart, so that an importer that welds positions keeps
/// the leaves apart.
std::vector<PlacedLeaf> place_leaves(const Species& species, const std::vector<Stem>& stems, const Mesh& leaf, SeededRandom& random);

inline constexpr float kLeafGap = 5e-5f;

}  // namespace coppice::bake
