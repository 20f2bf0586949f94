#pragma once

// The part of gltf_screen that looks into `extensions` objects. An absent extension is fine everywhere. All errors are bad_file but one.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "gltf_meshopt.h"
#include "result.h"

namespace coppice::bake {

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

/// EXT_mesh_gpu_instancing of a node. counts  elements of each accessor
Result<void> check_instancing(const nlohmann::json& node, const std::string& place, std::span<const std::uint64_t> counts);

}  // namespace coppice::bake
