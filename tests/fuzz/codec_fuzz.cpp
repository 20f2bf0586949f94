// libFuzzer: the codecs alone, without a file around the chunk. Byte 0 picks the codec (wood, or pages), bytes 1..4 what the front of a
// file would state; the rest is the chunk.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "check.h"
#include "coppice/format.h"
#include "page_codec.h"
#include "wood_codec.h"

namespace {

constexpr std::uint32_t kCards = 3, kMaterials = 2;

/// The bytes as the page of a plant whose earlier pages hold quads of some sort.
void fuzz_page(std::span<const std::uint8_t> bytes, std::uint32_t page, std::uint32_t split_count) {
  const std::uint32_t largest = split_count % 2 == 0 ? COPPICE_FINE_QUANTISED_MAX : COPPICE_QUANTISED_MAX;
  coppice::PageNode root;
  const coppice::PageNode lasting{.by_death = coppice::kNoPlace};
  std::vector<std::vector<coppice::PageNode>> pages(page, std::vector<coppice::PageNode>(2 * COPPICE_PAGE_SPLITS, lasting));
  std::uint32_t i = 0;
  for (auto& earlier : pages)
    for (coppice::PageNode& node : earlier)
      for (auto& corner : node.corners) {
        corner = {static_cast<std::uint16_t>(i * 37 % 16384), static_cast<std::uint16_t>(i * 11 % 16384), 16383};
        ++i;
      }
  // The page's splits replace every second node of the page before.
  for (i = 0; page > 0 && i < split_count; ++i) {
    pages.back()[2 * i].split = page * COPPICE_PAGE_SPLITS + i;
    pages.back()[i].by_death = static_cast<std::uint16_t>(2 * i);
  }
  pages.emplace_back(2 * split_count);
  std::vector<coppice::PageNode*> places;
  for (auto& nodes : pages) places.push_back(nodes.data());
  std::vector<coppice::Split> splits(split_count);
  const auto scratch = std::make_unique<coppice::PageScratch>();
  static coppice::DecoderPool decoders;  // what one page leaves in a set must not show in the next
  const std::uint32_t first_split = page * COPPICE_PAGE_SPLITS;
  const coppice::PageInfo info{page, first_split + split_count + 1, kCards, largest};
  if (!coppice::decode_page(bytes, info, {{&root, places}, splits}, *scratch, decoders)) return;
  for (i = 0; i < splits.size(); ++i) {
    COPPICE_ASSERT(splits[i].parent <= 2 * (first_split + i));
    unsigned filled = 0;
    for (std::uint8_t slot : splits[i].parent_slots) filled |= 1u << slot;
    COPPICE_ASSERT(__builtin_popcount(filled) == 4 && filled < 256);
    const coppice::PageNode& parent = coppice::NodePages{&root, places}[splits[i].parent];
    const coppice::ChildQuads children = coppice::child_quads(parent.corners, splits[i]);
    COPPICE_ASSERT(pages.back()[2 * i].corners == children.first && pages.back()[2 * i + 1].corners == children.second);
  }
  for (const coppice::PageNode& node : pages.back()) {
    COPPICE_ASSERT(node.card < kCards);
    COPPICE_ASSERT(node.opacity >= (node.split == coppice::kNeverReplaced ? coppice::kOpaque : 1) && node.opacity <= coppice::kOpaque);
    COPPICE_ASSERT(coppice::are_normals(node.normals));
    for (const auto& corner : node.corners)
      for (std::uint16_t coordinate : corner) COPPICE_ASSERT(coordinate <= largest);
  }
}

void fuzz_wood(std::span<const std::uint8_t> bytes, std::uint32_t vertex_count, std::uint32_t triangle_count) {
  static const std::vector<coppice_file_material> materials(kMaterials);
  const auto mesh = coppice::decode_wood(bytes, {vertex_count, triangle_count, materials});
  if (!mesh) return;
  COPPICE_ASSERT(mesh->vertices.size() == vertex_count && mesh->indices.size() == std::size_t{3} * triangle_count);
  for (std::uint32_t index : mesh->indices) COPPICE_ASSERT(index < vertex_count);
  for (const coppice::WoodVertex& vertex : mesh->vertices) COPPICE_ASSERT(vertex.material < kMaterials);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 5) return 0;
  const std::span<const std::uint8_t> chunk(data + 5, size - 5);
  const std::uint32_t first = data[1] | std::uint32_t{data[2]} << 8, second = data[3] | std::uint32_t{data[4]} << 8;
  if (data[0] % 3 == 1)
    fuzz_wood(chunk, first, second);
  else
    fuzz_page(chunk, first % 3, second % COPPICE_PAGE_SPLITS + 1);
  return 0;
}
