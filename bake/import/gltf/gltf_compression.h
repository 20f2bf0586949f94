#pragma once

// Decoders of compressed geometry.
//
// KHR_draco_mesh_compression: Draco codes the triangles and attributes of a primitive, in a buffer view.
// EXT_meshopt_compression: meshoptimizer codes the bytes of buffer views. KHR_meshopt_compression is the same with one more filter and
// newer versions of the codecs; these are refused by name.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
inline constexpr std::array<const char*, 2> kMeshoptExtensions{"EXT_meshopt_compression", "KHR_meshopt_compression"};

/// A compressed buffer view decodes to `count` elements of stride_bytes, within the limits that the extension sets for its mode and filter.
struct MeshoptView {
  enum class Mode { attributes, triangles, indices };
  enum class Filter { none, octahedral, quaternion, exponential };
  std::size_t view = 0;  ///< index into bufferViews
  const char* extension = kMeshoptExtensions[0];
  Mode mode = Mode::attributes;
  Filter filter = Filter::none;
  std::size_t count = 0;
  std::size_t stride_bytes = 0;
};

/// Whether `coded_bytes` bytes can code so much. Limits what a file may ask for. count  in elements of stride_bytes
bool meshopt_is_plausible(MeshoptView::Mode mode, std::uint64_t count, std::uint64_t stride_bytes, std::uint64_t coded_bytes);

/// Decodes each of `views`, which hold their coded bytes, into a buffer of its own and points the view at it.
/// errors  bad_file: the bytes are not what the extension says, or views share them; unsupported: a newer version of the coding
Result<void> decode_meshopt_views(tinygltf::Model& model, const std::vector<MeshoptView>& views);

/// Decodes KHR_draco_mesh_compression: such primitives become triangles whose indices and coded attributes are new accessors at the end of
/// the model; attributes that are not coded keep theirs.
/// model   screened (gltf_screen.h)
/// errors  bad_file: damaged data, an attribute id that is not in it, an index beyond the vertices, more triangles or bytes than its length
///         can stand for; unsupported: a stream that is no mesh or not version 2.2, an attribute type that glTF does not know
Result<void> decode_draco_primitives(tinygltf::Model& model);

}  // namespace coppice::bake
