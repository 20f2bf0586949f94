#pragma once

// Pages of version 1 (FORMAT.md, section 14).

#include "page_codec.h"

namespace coppice {

/// decode_page for version 1, arguments checked. errors  bad_file, out_of_memory
Result<std::uint32_t> decode_draco_page(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out);

}  // namespace coppice
