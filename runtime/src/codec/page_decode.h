#pragma once

// Pages of version 2: see FORMAT.md, section 9, and page_model.h.

#include "page_codec.h"

namespace coppice {

/// decode_page for version 2, arguments checked. errors  bad_file
Result<std::uint32_t> decode_modelled_page(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out,
                                           PageScratch& scratch);

}  // namespace coppice
