#pragma once

// What makes two bakes the same: the cache of `coppice bake-all` finds finished files by it.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bake.h"
#include "gltf_references.h"
#include "key_parts.h"
#include "result.h"

namespace coppice::bake {

/// To be raised with every change after which some input and options give other bytes: files baked before are then baked again. A test
/// compares a bake with what it was at this version.
inline constexpr std::uint32_t kBakeVersion = 31;

/// All that a bake's bytes depend on: the input's name (which the file keeps), its bytes, the names and bytes of the files it refers to,
/// option_parts(), kBakeVersion, the file format's version, and with Areas::vulkan device and driver, which are opened for it. Of bytes
/// there is their XXH3-128. A file referred to that is missing counts as missing.
/// errors  io: the input, or a file it refers to, is there and unreadable; those of resolve_reference for a file outside the folder; with
///         Areas::vulkan those of open_area_device
Result<std::vector<KeyPart>> bake_key_parts(const std::filesystem::path& input, const BakeOptions& options);

/// Whether the key is of these bytes of a file, as a ReadObserver hears of them.
bool is_part_of(std::span<const KeyPart> parts, std::string_view uri, std::span<const std::uint8_t> bytes);

/// key_of them. errors  as bake_key_parts
Result<std::string> bake_key(const std::filesystem::path& input, const BakeOptions& options);

/// Every option that can change the result, as a person may read it: "metric", "mi". thread_count is none of them.
std::vector<KeyPart> option_parts(const BakeOptions& options);

/// The files that a .gltf or .glb names. Empty for what is not glTF.
std::vector<GltfReference> referred_files(std::span<const std::uint8_t> gltf);

}  // namespace coppice::bake
