#include "page_codec.h"

#include "page_decode.h"
#include "page_draco.h"

namespace coppice {

Result<std::uint32_t> decode_page(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out, PageScratch& scratch) {
  if (info.split_count == 0 || info.split_count > COPPICE_PAGE_SPLITS || out.nodes.root == nullptr ||
      out.nodes.pages.size() != info.page + std::size_t{1} || out.patches.size() != info.split_count ||
      (!out.splits.empty() && out.splits.size() != info.split_count))
    return Error{Status::invalid_argument, "decode_page: a span of the wrong length"};
  return info.version == 1 ? decode_draco_page(bytes, info, out) : decode_modelled_page(bytes, info, out, scratch);
}

}  // namespace coppice
