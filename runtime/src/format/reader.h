#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "hooks.h"
#include "result.h"
#include "wind_field.h"

namespace coppice {

/// The front of a .coppice file, parsed and checked: everything but wood, textures, pages and leaf meshes.
struct PlantFile {
  coppice_file_header header{};
  HookArray<coppice_file_chunk> chunks;  ///< in file order
  coppice_file_plant plant{};
  HookArray<coppice_file_material> materials;
  HookArray<coppice_file_card> cards;
  HookArray<std::uint32_t> error_leaf_counts;  ///< [L], ascending
  HookArray<float> error_sizes_px;             ///< [S], ascending
  HookArray<float> error_px;                   ///< [L * S], a row per level
  coppice_file_wind wind{};
  HookArray<coppice_file_wind_node> wind_nodes;   ///< [wind.node_side^3]
  HookArray<coppice_file_leaf_mesh> leaf_meshes;  ///< [leaf_mesh_count]
  HookArray<float> wood_error_px;                 ///< [W * S] error of each wood LoD against the finest, a row per LoD
  HookArray<coppice_file_texture> textures;       ///< [texture_count] headers of the TEXTURE chunks
  /// [texture_count] laid out like a TEXTURE chunk of at most COPPICE_MAX_SMALL_TEXTURE_SIDE; empty if it is no material's base colour.
  HookArray<HookBuffer> small_textures;
  HookArray<float> leaf_mesh_error_px;  ///< [S] error of all leaf quads against the leaf meshes; empty without leaf meshes

  /// Bytes from the allocator hook.
  [[nodiscard]] std::size_t bytes() const;
};

/// Reads and checks bytes [0, 64): magic, version, checksum, sizes.
/// file_bytes  size of the file on disk; must equal the header's
/// errors  bad_file, with the field and its byte offset; "version" for a .coppice file of another version
Result<coppice_file_header> read_header(std::span<const std::uint8_t> bytes, std::uint64_t file_bytes);

/// Parses the front. It checks the chunks that it parses; check_chunk checks the others.
/// bytes  at least header.first_read_bytes long; the whole file is allowed
/// errors  bad_file, with the field and its byte offset: truncated, wrong checksum, count over a limit, tables that disagree; out_of_memory
Result<PlantFile> read_front(std::span<const std::uint8_t> bytes, std::uint64_t file_bytes,
                             const coppice_allocator& allocator = default_allocator());

/// Returns the plant's wind, which refers to `file`.
WindField wind_field(const PlantFile& file);

/// The chunk table's entry, or null.
const coppice_file_chunk* find_chunk(const PlantFile& file, coppice_chunk_kind kind, std::uint32_t index);

/// Returns the largest coordinate of the plant's quantised positions.
std::uint32_t quantised_max(const coppice_file_plant& plant);

/// Returns a material's base colour texture and its normal map, COPPICE_NO_TEXTURE if it has none.
std::uint32_t material_texture(const coppice_file_material& material);
std::uint32_t material_normal_map(const coppice_file_material& material);
/// Each texture: COPPICE_NO_TEXTURE, or < 256.
void set_material_textures(coppice_file_material& material, std::uint32_t texture, std::uint32_t normal_map);

/// Checks that `bytes` are the chunk's: length and XXH3-64.
/// errors  bad_file, with the chunk's kind, index and offset
Result<void> check_chunk(const coppice_file_chunk& chunk, std::span<const std::uint8_t> bytes);

/// Number of splits in foliage page `page` of a plant with leaf_count leaves; 0 if there is no such page.
std::uint32_t page_split_count(std::uint32_t leaf_count, std::uint32_t page);

/// Length of a mip level, and its offset in the TEXTURE chunk.
struct MipLevel {
  std::uint32_t width = 0, height = 0;
  std::uint64_t offset = 0, bytes = 0;
};

struct TextureLayout {
  std::uint32_t format = COPPICE_TEXTURE_RGBA8;  ///< coppice_texture_format
  std::uint64_t bytes = 0;                       ///< length of the whole chunk
  std::uint32_t level_count = 0;
  std::array<MipLevel, std::bit_width(COPPICE_MAX_TEXTURE_SIDE)> all_levels{};  ///< enough for the largest texture

  /// Largest first.
  [[nodiscard]] std::span<const MipLevel> levels() const { return std::span(all_levels).first(level_count); }
};

/// The layout of a TEXTURE chunk that begins with `texture`. errors  bad_file: the field, offset from the start of the chunk
Result<TextureLayout> texture_layout(const coppice_file_texture& texture);

/// Reads the layout of a whole chunk, which its levels must fill.
Result<TextureLayout> read_texture(std::span<const std::uint8_t> chunk);

/// Checks that TEXTURE `index`, of the right length, begins with the header that the front has. errors  bad_file, with the chunk's offset
Result<void> check_texture(const PlantFile& file, std::uint32_t index, std::span<const std::uint8_t> chunk);

}  // namespace coppice
