#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "file_place.h"

namespace forest {

/// A file that an option names. file  empty: none
struct NamedOutput {
  const char* option;  ///< "--stats"
  std::string file;
};

/// Refuses files that cannot be written, that are read, or that are each other, before there is anything to write. Makes their folders;
/// leaves files that are there as they are.
/// inputs  empty names are skipped
/// errors  Failure: the option, the file and why, or the system's reason
void check_outputs(std::span<const NamedOutput> outputs, std::span<const std::string> inputs);

/// Writes a plain file whole or not at all, or /dev/null, and makes its folder. Links are followed as find_place says
/// (bake/core/files/file_place.h), not those that another user made in a shared folder.
/// errors  Failure with the system's reason
void write_output(const std::string& file, std::string_view bytes);

/// A file that grows: what was added is there, however the program ends.
struct GrowingOutput {
  std::string file;
  coppice::bake::Descriptor open;  ///< none: /dev/null
};
/// Writes the start as write_output does, which says the errors of both.
GrowingOutput start_output(const std::string& file, std::string_view start);
void add(const GrowingOutput& output, std::string_view bytes);

/// Writes 8-bit RGB as PNG. rgba: [width * height * 4] row-major, top row first; alpha is dropped. errors  those of write_output
void write_png(const std::string& file, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> rgba);

}  // namespace forest
