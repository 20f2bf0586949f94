#pragma once

// glTF files that are wrong in one way each, and what the importer has to say of them.

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

namespace coppice::test {

struct BadGltf {
  std::string file;  ///< name with its extension
  std::vector<std::uint8_t> bytes;
  std::vector<std::string> says;  ///< parts of the message: what is wrong, and where
};

/// For GoogleTest, which would print the struct's bytes, padding included. NOLINTNEXTLINE(readability-identifier-naming)
inline void PrintTo(const BadGltf& bad, std::ostream* out) {
  *out << bad.file;
}

/// In order of their names, which are unique.
std::vector<BadGltf> bad_gltf_files();

/// Lines of "file|part|part...": the list beside the committed files. Throws std::runtime_error when it cannot be read.
std::vector<BadGltf> read_bad_gltf_list(const std::string& path);

}  // namespace coppice::test
