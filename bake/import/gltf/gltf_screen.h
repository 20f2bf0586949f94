#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gltf_meshopt.h"
#include "gltf_screen_extensions.h"
#include "result.h"

namespace coppice::bake {

/// An image has a URI or is a view of a buffer.
struct ScreenedImage {
  std::string name, uri;
  int view = -1;
};

/// A glTF that has been checked. The importer reads the files and data URIs of buffers and images, tinygltf the rest.
struct ScreenedGltf {
  std::string json;  ///< the document without buffers, images and whatever the importer does not read
  std::vector<ScreenedBuffer> buffers;
  std::vector<ScreenedImage> images;
  std::vector<MeshoptView> meshopt_views;  ///< these views hold coded bytes; accessors lie within the decoded bytes
};

/// Checks everything about a glTF 2.0 document that can be checked without its bytes: types, required members, every index into another
/// array, every buffer view within its buffer, every accessor within its view, and that the nodes are trees. tinygltf relies on all of these.
///
/// tinygltf does not get the document as it is, since it refuses files that exporters write, and lets hostile ones take memory: it wants
/// bytes for every buffer and every accessor of indices (EXT_meshopt_compression and Draco leave them out), knows few media types of data
/// URIs, and keeps 152 bytes for each value of extras, unknown extensions and animations.
/// json             the text of a .gltf, or the JSON chunk of a .glb
/// bin_chunk_bytes  length of the .glb's BIN chunk; nothing for a .gltf or a .glb without one
/// errors  bad_file: `detail` is the place, as in "accessors[3].count"; unsupported: another glTF version, a required extension (named), or
///         more of anything than is read
Result<ScreenedGltf> screen_gltf(std::string_view json, std::optional<std::uint64_t> bin_chunk_bytes);

}  // namespace coppice::bake
