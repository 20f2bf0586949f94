#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "file_place.h"

namespace forest {

/// By which two names of one file are told: bake/core/files/file_place.h.
std::filesystem::path place_of(const std::string& file);

/// Refuses a file that cannot be written, before there is anything to write. Makes its folder; leaves a file that is there as it is.
/// option  names it in the error: "--stats"
/// errors  Failure with the system's reason
void check_output(const char* option, const std::string& file);

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
