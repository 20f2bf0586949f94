#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace forest {

/// Refuses a file that cannot be written, before there is anything to write. Makes its folder; leaves a file that is there as it is.
/// option  names it in the error: "--stats"
/// errors  Failure with the system's reason
void check_output(const char* option, const std::string& file);

/// Writes the file whole or not at all, making its folder. A link is followed, but for one that another user made in a shared folder.
/// errors  Failure with the system's reason
void write_output(const std::string& file, std::string_view bytes);

/// Writes 8-bit RGB as PNG. rgba: [width * height * 4] row-major, top row first; alpha is dropped. errors  those of write_output
void write_png(const std::string& file, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> rgba);

}  // namespace forest
