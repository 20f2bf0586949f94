#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace forest {

/// Writes 8-bit RGB. rgba: [width * height * 4] row-major, top row first; alpha is dropped. Missing folders are created.
/// errors  Failure: the file cannot be written
void write_png(const std::string& file, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> rgba);

}  // namespace forest
