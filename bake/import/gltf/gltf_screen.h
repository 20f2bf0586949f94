#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gltf_compression.h"
#include "gltf_cost.h"
#include "gltf_references.h"
#include "result.h"

namespace coppice::bake {

/// An extension of a node: names the nodes that show it coarser.
inline constexpr const char* kLevelsExtension = "MSFT_lod";
/// An extension of a node: says whether the node and what is below it are seen.
inline constexpr const char* kVisibilityExtension = "KHR_node_visibility";

/// The extensions whose members are read from tinygltf's model. The screen empties all others.
inline constexpr std::array<std::string_view, 8> kReadExtensions{
    "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_mesh_gpu_instancing",
    "KHR_texture_transform",      "EXT_texture_webp",        kLevelsExtension,          kVisibilityExtension};
/// Others that a document may require: the screen itself reads them, or they change nothing that is read. A name that ends in '*' is a
/// family. bake/import/README.md says how each is treated.
inline constexpr std::string_view kOtherExtensions[] = {"KHR_mesh_quantization",
                                                        "KHR_texture_basisu",
                                                        "KHR_materials_pbrSpecularGlossiness",
                                                        "KHR_materials_variants",
                                                        "KHR_materials_unlit",
                                                        "KHR_materials_emissive_strength",
                                                        "KHR_materials_diffuse_transmission",
                                                        "KHR_materials_transmission",
                                                        "KHR_materials_*",
                                                        "KHR_lights_punctual",
                                                        "KHR_xmp_json_ld"};

/// Whether an extension is read, or changes nothing that is read.
bool is_supported_extension(std::string_view name);

/// A buffer, as far as the document describes it.
struct ScreenedBuffer {
  std::uint64_t bytes = 0;
  bool is_fallback = false;        ///< a placeholder for bytes that only the compressed form holds
  std::optional<std::string> uri;  ///< without one it is the BIN chunk, or a fallback
};

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
  std::vector<GltfReference> references;  ///< the files among these
  bool has_animations = false;
  std::uint64_t triangles = 0;             ///< of the default scene, in all places where they stand: check_cost
  std::vector<MeshoptView> meshopt_views;  ///< these views hold coded bytes; accessors lie within the decoded bytes
};

/// Checks everything about a glTF 2.0 document that can be checked without its bytes: types, required members, every index into another
/// array, every buffer view within its buffer, every accessor within its view, and that the nodes are trees. tinygltf relies on all of
/// these.
///
/// tinygltf does not get the document as it is, since it refuses files that exporters write, and lets hostile ones take memory: it wants
/// bytes for every buffer and every accessor of indices (EXT_meshopt_compression and Draco leave them out), knows few media types of data
/// URIs, and keeps 152 bytes for each value of extras, unknown extensions and animations.
/// json             the text of a .gltf, or the JSON chunk of a .glb
/// bin_chunk_bytes  length of the .glb's BIN chunk; nothing for a .gltf or a .glb without one
/// errors  bad_file: `detail` is the place, as in "accessors[3].count"; unsupported: another glTF version, a required extension (named),
///         more of anything than is read, or what check_cost refuses
Result<ScreenedGltf> screen_gltf(std::string_view json, std::optional<std::uint64_t> bin_chunk_bytes, const CostLimit& limit = {});

}  // namespace coppice::bake
