#pragma once

// The part of gltf_screen that looks into `extensions` objects. An absent extension is fine everywhere. All errors are bad_file but one.

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

/// How an extension is treated. bake/README.md has the same table.
struct ExtensionRule {
  std::string_view name;  ///< a family of them where it ends in '*'
  std::string_view treatment;
};
/// Of every extension that a document may require; the first that fits counts.
std::span<const ExtensionRule> extension_rules();

/// Whether an extension is read, or changes nothing of what is read.
bool is_supported_extension(std::string_view name);

/// Of a node: the nodes that show it coarser.
inline constexpr const char* kLevelsExtension = "MSFT_lod";

/// A buffer, as far as the document tells.
struct ScreenedBuffer {
  std::uint64_t bytes = 0;
  bool is_fallback = false;  ///< stands in for what only the compressed form holds
};

/// KHR_draco_mesh_compression of a primitive whose attributes have been checked.
Result<void> check_draco(const nlohmann::json& primitive, const std::string& place, std::size_t view_count);

/// Whether KHR_draco_mesh_compression holds that attribute of a checked primitive.
bool is_draco_attribute(const nlohmann::json& primitive, const std::string& name);

/// EXT_meshopt_compression of buffer view number `index`, or KHR_meshopt_compression; nothing where it has neither.
/// errors  unsupported: a filter of KHR_meshopt_compression that is not in EXT_meshopt_compression
Result<std::optional<MeshoptView>> read_meshopt(const nlohmann::json& view, const std::string& place, std::size_t index,
                                                std::span<const ScreenedBuffer> buffers);

/// KHR_texture_transform of a textureInfo.
Result<void> check_texture_transform(const nlohmann::json& texture_info, const std::string& place);

/// EXT_texture_webp of a texture.
Result<void> check_webp(const nlohmann::json& texture, const std::string& place, std::size_t image_count);

/// KHR_texture_basisu of a texture, which is not read: whether there is an image that is read in its stead.
/// errors  unsupported: there is none; the error says how to convert the file
Result<void> check_basisu_fallback(const nlohmann::json& texture, const std::string& place);

/// KHR_materials_pbrSpecularGlossiness of a material.
Result<void> check_specular_glossiness(const nlohmann::json& material, const std::string& place, std::size_t texture_count);
/// What has been checked as pbrMetallicRoughness: diffuse is the base colour, and as rough as it is not glossy.
void take_specular_glossiness(nlohmann::json& material);

/// EXT_mesh_gpu_instancing of a node. counts  elements of each accessor
Result<void> check_instancing(const nlohmann::json& node, const std::string& place, std::span<const std::uint64_t> counts);

}  // namespace coppice::bake
