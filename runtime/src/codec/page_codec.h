#pragma once

#include <cstdint>
#include <span>

#include "result.h"
#include "tree.h"

namespace coppice {

/// Splits [first_split, first_split + out.size()) from a PAGE chunk's bytes. Checks parents (< 2s+1), slots (four different), coordinates and
/// cards (< card_count). Whether a parent is alive depends on earlier pages and is not checked here.
/// out  [split count of the page]
/// errors  bad_file: not the Draco point cloud FORMAT.md describes; out_of_memory
Result<void> decode_page(std::span<const std::uint8_t> bytes, std::uint32_t first_split, std::uint32_t card_count, std::span<Split> out);

}  // namespace coppice
