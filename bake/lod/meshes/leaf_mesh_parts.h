#pragma once

// The finest level of a plant: its leaves as they were modelled.

#include "plant.h"

namespace coppice::bake {

/// The leaf meshes that a plant keeps; if none, the reason in a sentence.
struct KeptLeafMeshes {
  LeafMeshes meshes;  ///< without errors: measure_leaf_mesh_error adds them
  std::string note;   ///< empty if there are parts
  bool too_large = false;
};

/// Splits the plant's leaf meshes into parts of at most COPPICE_MAX_LEAF_MESH_TRIANGLES, about equally large. Leaves stay whole and follow
/// a space-filling curve through their stalks, so that neighbours are coded together. A leaf's uvs are shifted by whole numbers to start in
/// 0..1, which makes no difference with a repeated image. Keeps nothing if all leaves' triangles are those of their quads, or if there are
/// more triangles than COPPICE_MAX_LEAF_MESHES parts hold. Same input, same parts.
/// foliage  the plant's quads, one a leaf, in leaf order
KeptLeafMeshes keep_leaf_meshes(const Plant& plant, const Foliage& foliage);

/// All parts as one mesh: each leaf's triangles together.
Mesh whole_leaf_mesh(const LeafMeshes& meshes);

std::uint32_t triangle_count(const LeafMeshes& meshes);

}  // namespace coppice::bake
