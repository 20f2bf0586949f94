#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coppice/format.h"
#include "result.h"
#include "still_wind.h"

namespace coppice {

/// The contents of a file, chunk by chunk, already encoded. The writer sets all counts in `plant` from the sizes here, except leaf_count.
/// Only the baker writes files, so this memory does not come from a hook.
struct FileContents {
  coppice_file_plant plant{};
  std::vector<coppice_file_material> materials;
  std::vector<coppice_file_card> cards;
  std::vector<std::uint32_t> error_leaf_counts;
  std::vector<float> error_sizes_px;
  std::vector<float> error_px;
  coppice_file_wind wind = kStillWind;                   ///< node_side fits wind_nodes
  std::vector<coppice_file_wind_node> wind_nodes;        ///< [node_side^3]
  std::vector<coppice_file_leaf_mesh> leaf_mesh_counts;  ///< [leaf mesh]
  std::vector<float> wood_error_px;                      ///< [wood LoD * size]
  std::vector<float> leaf_mesh_error_px;                 ///< [size]; empty without leaf meshes
  std::vector<std::vector<std::uint8_t>> wood;           ///< [lod] WOOD chunks, finest first
  std::vector<std::vector<std::uint8_t>> pages;          ///< [page] PAGE chunks
  std::vector<std::vector<std::uint8_t>> textures;       ///< [texture] TEXTURE chunks
  std::vector<std::vector<std::uint8_t>> leaf_meshes;    ///< [leaf mesh] LEAF_MESH chunks
};

/// Makes the TEXTURES chunk for these TEXTURE chunks.
std::vector<std::uint8_t> textures_chunk(const std::vector<std::vector<std::uint8_t>>& textures,
                                         std::span<const coppice_file_material> materials);

/// Makes the file: header, table, chunks in the order that format.h draws. Same contents, same bytes.
/// errors  invalid_argument: read_front would refuse the result; its field and place are named
Result<std::vector<std::uint8_t>> write_file(const FileContents& contents);

}  // namespace coppice
