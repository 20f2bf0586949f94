#pragma once

// How much memory this process may use.

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace coppice::bake {

/// The machine's memory, or less where RLIMIT_AS or the process's control group (version 2), or one above it, allows less; bytes.
std::uint64_t usable_memory_bytes();

/// The least that a control group and those above it allow, bytes; the largest number where none has a limit.
/// root   where the groups' folders are
/// group  as /proc/self/cgroup names the process's: "0::/a/b"
std::uint64_t group_memory_bytes(const std::filesystem::path& root, std::string_view group);

}  // namespace coppice::bake
