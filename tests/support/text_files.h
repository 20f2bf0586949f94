#pragma once

// Files as strings and bytes, for tests and benchmarks.

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace coppice::test {

/// All bytes of a file; empty where there is none.
std::string read_text(const std::filesystem::path& path);

/// Folders that are missing are made.
void write_text(const std::filesystem::path& path, const std::string& text);

/// Writes a file; returns its path.
std::filesystem::path write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more);

/// Every file below a folder by its path in it, but those whose path begins with `left_out`: what coppice keeps there is its cache, and
/// beside that, with the prefix ".coppice-", its runs on a cluster.
std::map<std::string, std::string> outputs(const std::filesystem::path& folder, const std::string& left_out = ".coppice-cache");

}  // namespace coppice::test
