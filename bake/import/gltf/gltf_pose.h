#pragma once

// The pose in which a glTF stands without animation: skins with their joints where the nodes are, morph targets at their default weights.

#include <string>

#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

/// Poses the meshes of the scene's nodes (glTF 2.0, 3.7.2.2 and 3.7.3). A posed mesh has new accessors for positions and normals, and is a
/// copy at the end of the model where several nodes show it differently. Morph weights are the node's, else the mesh's. Skinned meshes get
/// positions in the file's world space: their node's own transform does not count (mesh_instances). A primitive of a skinned mesh that has
/// no joints stays where its node is. A vertex without weights follows its first joint. Nodes without a skinned primitive lose their skin.
/// model   screened (gltf_screen.h), decompressed
/// errors  `detail` names the primitive. bad_file: attributes of unequal length, a joint that the skin does not have, a position that
///         is not finite
Result<void> apply_rest_pose(tinygltf::Model& model);

/// One line that says what was posed, and that animation is not kept; empty if there is nothing of that.
std::string pose_line(const tinygltf::Model& model);

}  // namespace coppice::bake
