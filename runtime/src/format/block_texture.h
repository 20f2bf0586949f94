#pragma once

// Sizes of texels in each coppice_texture_format, and their decoding for readers that cannot read blocks.

#include <cstdint>
#include <span>

#include "reader.h"

namespace coppice {

/// Returns "rgba8" and the like; static storage. "unknown" for a value that is no format.
const char* texture_format_name(std::uint32_t format);

/// Returns the bytes of a mip level. format: a coppice_texture_format
std::uint64_t texture_level_bytes(std::uint32_t format, std::uint32_t width, std::uint32_t height);

/// Decodes a mip level to RGBA8, rows from top to bottom.
/// stored  [level.bytes]; any bytes are valid
/// rgba    [level.width * level.height * 4] out
void decode_texture_level(std::uint32_t format, const MipLevel& level, std::span<const std::uint8_t> stored, std::span<std::uint8_t> rgba);

/// Bytes of the TEXTURE chunk that decode_texture writes.
std::uint64_t decoded_texture_bytes(const TextureLayout& layout);

/// Writes a TEXTURE chunk of COPPICE_TEXTURE_RGBA8 with the texels of `chunk`. Allocates nothing.
/// layout   of `chunk`
/// decoded  [decoded_texture_bytes(layout)] out
void decode_texture(const TextureLayout& layout, std::span<const std::uint8_t> chunk, std::span<std::uint8_t> decoded);

}  // namespace coppice
