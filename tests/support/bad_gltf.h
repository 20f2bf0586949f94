#pragma once

// glTF files that are wrong in one way each, and what the importer has to name.

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "result.h"

namespace coppice::test {

struct BadGltf {
  std::string file;  ///< name with its extension
  std::vector<std::uint8_t> bytes;
  std::vector<std::string> names;  ///< what the message has to name: field, place and value
  Status status = Status::bad_file;
};

/// For GoogleTest, which would print the struct's bytes, padding included. NOLINTNEXTLINE(readability-identifier-naming)
inline void PrintTo(const BadGltf& bad, std::ostream* out) {
  *out << bad.file;
}

/// In order of their names, which are unique.
std::vector<BadGltf> bad_gltf_files();

/// Lines of "file|status|name|name...", the status as a number: the list beside the committed files. Throws std::runtime_error when it
/// cannot be read.
std::vector<BadGltf> read_bad_gltf_list(const std::string& path);

}  // namespace coppice::test
