#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gltf_meshopt.h"
#include "gltf_references.h"
#include "result.h"

namespace coppice::bake {

/// The JSON of a glTF that has been checked, without what the importer does not read.
struct ScreenedGltf {
  std::string json;
  std::vector<std::uint64_t> buffer_bytes;  ///< buffers[i].byteLength
  std::vector<GltfReference> references;    ///< the files of its buffers and images
  std::vector<MeshoptView> meshopt_views;   ///< these views hold coded bytes; accessors lie within the decoded bytes
};

/// Checks everything about a glTF 2.0 document that can be checked without its bytes: types, required members, every index into another
/// array, every buffer view within its buffer, every accessor within its view, and that the nodes are trees. tinygltf, which parses the
/// result, relies on all of these.
/// json             the text of a .gltf, or the JSON chunk of a .glb
/// bin_chunk_bytes  length of the .glb's BIN chunk; nothing for a .gltf or a .glb without one
/// errors  bad_file: `detail` is the place, as in "accessors[3].count"; unsupported: another glTF version, a required extension (named), or
///         more of anything than is read
Result<ScreenedGltf> screen_gltf(std::string_view json, std::optional<std::uint64_t> bin_chunk_bytes);

}  // namespace coppice::bake
