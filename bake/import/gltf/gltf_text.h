#pragma once

// Extracts the JSON of a glTF that is not loaded. Nothing of it is checked: a bake does that (gltf_document.h).

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "result.h"

namespace coppice::bake {

/// Finds the JSON in the bytes of a .gltf, without a byte order mark, or of a .glb; empty if there is none.
std::string_view gltf_text(std::span<const std::uint8_t> gltf);

/// Reads as many of a file's bytes as gltf_text needs: of a .glb those up to its JSON's end, at most `max_bytes`.
/// errors  as read_file
Result<std::vector<std::uint8_t>> read_gltf_text(const std::filesystem::path& file, std::uint64_t max_bytes);

}  // namespace coppice::bake
