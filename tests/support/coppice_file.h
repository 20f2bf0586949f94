#pragma once

// Damaging .coppice files on purpose: what the reader's tests and the fuzz target share.

#include <cstdint>
#include <string>
#include <vector>

#include "coppice/format.h"

namespace coppice::test {

using Bytes = std::vector<std::uint8_t>;

/// Makes every checksum that can be located right again, so that damage reaches the code behind them. Any bytes may be passed.
void fix_checksums(Bytes& file);

/// Where in the file chunk `index` of a kind starts; the file must be valid and have it.
std::size_t chunk_offset(const Bytes& file, coppice_chunk_kind kind, std::uint32_t index = 0);

/// Where in the file the table entry of that chunk starts.
std::size_t entry_offset(const Bytes& file, coppice_chunk_kind kind, std::uint32_t index = 0);

/// A file that must be refused, and for what.
struct BadFile {
  std::string name;  ///< file name in data/bad without ".coppice"
  Bytes bytes;
  std::string reason;  ///< Error::what
  std::uint64_t offset = 0;
};

/// One file per reason unpack() has to refuse a file, each derived from `good`: one of random_plant's with
/// four to 512 leaves, wood and a texture.
std::vector<BadFile> bad_files(const Bytes& good);

/// The same for leaf meshes, from a file that has two parts of them.
std::vector<BadFile> bad_leaf_mesh_files(const Bytes& good);

}  // namespace coppice::test
