#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "coppice/format.h"
#include "result.h"

namespace coppice::bake {

/// Bytes and number of the chunks of one kind.
struct ChunkSummary {
  const char* kind = "";  ///< "PAGE" and the like
  std::uint32_t count = 0;
  std::uint64_t bytes = 0;
  const char* draco = "";  ///< what Draco codes in it: "mesh", "symbols", or nothing
};

/// How far full wind moves the plant.
struct WindSummary {
  coppice_file_wind head{};
  float max_lean_m = 0.0f, max_sway_m = 0.0f;  ///< maximum over the nodes
  double max_move_m = 0.0, max_growth = 0.0;   ///< see wind_field.h
};

/// The contents of `coppice inspect`.
struct FileSummary {
  std::uint32_t version = 0;
  std::string name;
  std::uint32_t metric = 0;  ///< coppice_metric
  std::uint64_t file_bytes = 0;
  std::uint64_t first_read_bytes = 0;
  std::uint32_t leaf_count = 0;  ///< 0 for a plant that is all wood, which the file stores as one leaf of no size
  std::uint32_t page_count = 0;
  std::uint32_t material_count = 0;
  std::uint32_t card_count = 0;
  std::vector<ChunkSummary> chunks;  ///< one per kind that occurs, in the order of coppice_chunk_kind
  struct Mesh {
    std::uint32_t vertices = 0, triangles = 0;
    std::uint64_t bytes = 0;
  };
  std::vector<Mesh> wood;         ///< [lod], finest first
  std::vector<Mesh> leaf_meshes;  ///< one a chunk; none if nothing is finer than the quads
  struct Texture {
    const char* format = "";  ///< "bc3" and the like
    std::uint32_t width = 0, height = 0, mip_count = 0;
    std::uint64_t bytes = 0;
  };
  std::vector<Texture> textures;
  std::vector<std::uint32_t> error_leaf_counts;  ///< levels that the error table measured
  std::vector<float> error_sizes_px;
  std::vector<float> error_px;     ///< [levels * sizes]
  double bytes_per_leaf = 0.0;     ///< page bytes per leaf; 0 without leaves
  std::array<double, 3> size_m{};  ///< width, height and depth of the leaves' box and the finest wood
  WindSummary wind;
  std::vector<float> wood_error_px;       ///< [wood LoDs * sizes] each LoD's error against the finest
  std::vector<float> leaf_mesh_error_px;  ///< [sizes] error of all quads against the leaf meshes; empty without these
};

/// Reads the front and the finest wood: cheap, and no proof that the rest is valid. errors  as read_front
Result<FileSummary> inspect(std::span<const std::uint8_t> file);

/// How much verify() checked.
struct VerifyReport {
  std::uint64_t bytes_checked = 0;  ///< the whole file
  std::uint32_t chunks_checked = 0;
  std::uint32_t splits_decoded = 0;
  std::uint32_t wood_triangles_decoded = 0;
  std::uint32_t leaf_mesh_triangles_decoded = 0;
};

/// Checks every checksum, decodes every page, wood LoD and leaf mesh, and checks every invariant of FORMAT.md, and that the name
/// is_printable.
/// errors  bad_file: the first thing wrong, its chunk and byte offset
Result<VerifyReport> verify(std::span<const std::uint8_t> file);

}  // namespace coppice::bake
