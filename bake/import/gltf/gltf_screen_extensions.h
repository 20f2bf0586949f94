#pragma once

// The part of gltf_screen that looks into `extensions` objects. Every extension may be absent. Errors are bad_file unless a function says
// otherwise.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "gltf_json.h"
#include "gltf_meshopt.h"
#include "result.h"

namespace coppice::bake {

/// An extension of a node: names the nodes that show it coarser.
inline constexpr const char* kLevelsExtension = "MSFT_lod";

/// The extensions that a document may require; a name that ends in '*' is a family. bake/import/README.md says how each is treated.
inline constexpr std::array<std::string_view, 18> kKnownExtensions{"KHR_draco_mesh_compression",
                                                                   "EXT_meshopt_compression",
                                                                   "KHR_meshopt_compression",
                                                                   "EXT_mesh_gpu_instancing",
                                                                   "KHR_texture_transform",
                                                                   "EXT_texture_webp",
                                                                   kLevelsExtension,
                                                                   "KHR_mesh_quantization",
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
/// Those whose members are read from tinygltf's model; of any other only the name is kept.
inline constexpr std::span kReadExtensions = std::span(kKnownExtensions).first<7>();

/// Whether an extension is read, or changes nothing that is read.
bool is_supported_extension(std::string_view name);

/// A buffer, as far as the document describes it.
struct ScreenedBuffer {
  std::uint64_t bytes = 0;
  bool is_fallback = false;        ///< a placeholder for bytes that only the compressed form holds
  std::optional<std::string> uri;  ///< without one it is the BIN chunk, or a fallback
};

/// Checks KHR_draco_mesh_compression of a primitive whose attributes have been checked.
Result<void> check_draco(const JsonObject& primitive, std::size_t view_count);

/// Whether KHR_draco_mesh_compression codes that attribute of a checked primitive.
bool is_draco_attribute(const JsonObject& primitive, const std::string& name);

/// Takes EXT_meshopt_compression or KHR_meshopt_compression of buffer view number `index`, which then is a view of its coded bytes; nothing
/// if it has neither.
/// errors  unsupported: a filter of KHR_meshopt_compression that is not in EXT_meshopt_compression
Result<std::optional<MeshoptView>> take_meshopt(const JsonObject& view, std::size_t index, std::span<const ScreenedBuffer> buffers);

/// Checks KHR_texture_transform of a textureInfo.
Result<void> check_texture_transform(const JsonObject& texture_info);

/// Checks EXT_texture_webp of a texture.
Result<void> check_webp(const JsonObject& texture, std::size_t image_count);

/// Checks that a texture with KHR_texture_basisu, which is not read, names an image that is read.
/// errors  unsupported: it names none; the error says how to convert the file
Result<void> check_basisu_fallback(const JsonObject& texture);

/// Checks KHR_materials_pbrSpecularGlossiness of a material and writes its values as pbrMetallicRoughness: diffuse becomes the base colour,
/// roughness is 1 - glossiness.
Result<void> take_specular_glossiness(const JsonObject& material, std::size_t texture_count);

/// Checks EXT_mesh_gpu_instancing of a node. counts  elements of each accessor
Result<void> check_instancing(const JsonObject& node, std::span<const std::uint64_t> counts);

}  // namespace coppice::bake
