#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "coppice/format.h"
#include "result.h"
#include "still_wind.h"

namespace coppice {

/// What goes into a file, chunk by chunk, already encoded. Counts in `plant` are set by the writer from the sizes here,
/// leaf_count excepted. The baker's: the runtime writes nothing, so that memory here does not come from a hook.
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
  std::vector<float> leaf_mesh_error_px;                 ///< [size]; nothing without leaf meshes
  std::vector<std::vector<std::uint8_t>> wood;           ///< [lod] WOOD chunks, finest first
  std::vector<std::vector<std::uint8_t>> pages;          ///< [page] PAGE chunks
  std::vector<std::vector<std::uint8_t>> textures;       ///< [texture] TEXTURE chunks
  std::vector<std::vector<std::uint8_t>> leaf_meshes;    ///< [leaf mesh] LEAF_MESH chunks
};

/// The TEXTURES chunk of these TEXTURE chunks.
std::vector<std::uint8_t> textures_chunk(const std::vector<std::vector<std::uint8_t>>& textures,
                                         std::span<const coppice_file_material> materials);

/// The file: header, table, chunks in the order format.h draws. Same contents, same bytes.
/// errors  invalid_argument: read_front would refuse the result; its field and place are named
Result<std::vector<std::uint8_t>> write_file(const FileContents& contents);

}  // namespace coppice
