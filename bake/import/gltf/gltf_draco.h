#pragma once

#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// Decodes KHR_draco_mesh_compression: such primitives become triangles whose indices and coded attributes are new accessors at the end of
/// the model; attributes that are not coded keep theirs.
/// model   screened (gltf_screen.h)
/// errors  bad_file: damaged data, an attribute id that is not in it, an index beyond the vertices, more triangles or bytes than its length
///         can stand for; unsupported: a stream that is no mesh or not version 2.2, an attribute type that glTF does not know
Result<void> decode_draco_primitives(tinygltf::Model& model);

}  // namespace coppice::bake
