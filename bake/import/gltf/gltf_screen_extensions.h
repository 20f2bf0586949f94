#pragma once

// The part of gltf_screen that looks into `extensions` objects. Every extension may be absent. Errors are bad_file unless a function says
// otherwise.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "gltf_meshopt.h"
#include "result.h"

namespace coppice::bake {

/// The extensions that a document may require; a name that ends in '*' is a family. bake/import/README.md says how each is treated.
std::span<const std::string_view> known_extensions();

/// Whether an extension is read, or changes nothing that is read.
bool is_supported_extension(std::string_view name);

/// An extension of a node: names the nodes that show it coarser.
inline constexpr const char* kLevelsExtension = "MSFT_lod";

/// A buffer, as far as the document describes it.
struct ScreenedBuffer {
  std::uint64_t bytes = 0;
  bool is_fallback = false;  ///< a placeholder for bytes that only the compressed form holds
};

/// Checks KHR_draco_mesh_compression of a primitive whose attributes have been checked.
Result<void> check_draco(const nlohmann::json& primitive, const std::string& place, std::size_t view_count);

/// Whether KHR_draco_mesh_compression codes that attribute of a checked primitive.
bool is_draco_attribute(const nlohmann::json& primitive, const std::string& name);

/// Reads EXT_meshopt_compression or KHR_meshopt_compression of buffer view number `index`; nothing if it has neither.
/// errors  unsupported: a filter of KHR_meshopt_compression that is not in EXT_meshopt_compression
Result<std::optional<MeshoptView>> read_meshopt(const nlohmann::json& view, const std::string& place, std::size_t index,
                                                std::span<const ScreenedBuffer> buffers);

/// Checks KHR_texture_transform of a textureInfo.
Result<void> check_texture_transform(const nlohmann::json& texture_info, const std::string& place);

/// Checks EXT_texture_webp of a texture.
Result<void> check_webp(const nlohmann::json& texture, const std::string& place, std::size_t image_count);

/// Checks that a texture with KHR_texture_basisu, which is not read, names an image that is read.
/// errors  unsupported: it names none; the error says how to convert the file
Result<void> check_basisu_fallback(const nlohmann::json& texture, const std::string& place);

/// Checks KHR_materials_pbrSpecularGlossiness of a material.
Result<void> check_specular_glossiness(const nlohmann::json& material, const std::string& place, std::size_t texture_count);
/// Writes a checked material's values as pbrMetallicRoughness: diffuse becomes the base colour, roughness is 1 - glossiness.
void take_specular_glossiness(nlohmann::json& material);

/// Checks EXT_mesh_gpu_instancing of a node. counts  elements of each accessor
Result<void> check_instancing(const nlohmann::json& node, const std::string& place, std::span<const std::uint64_t> counts);

}  // namespace coppice::bake
