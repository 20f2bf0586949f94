// libFuzzer: the codecs alone, without a file around the chunk. Byte 0 picks the codec, bytes 1..4 the counts the front of a file would
// state; the rest is the chunk.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "check.h"
#include "coppice/format.h"
#include "page_codec.h"
#include "wood_codec.h"

namespace {

constexpr std::uint32_t kCards = 3, kMaterials = 2;

void fuzz_page(std::span<const std::uint8_t> bytes, std::uint32_t first_split, std::uint32_t split_count) {
  std::vector<coppice::QuantisedQuad> quads(2 * (first_split + split_count) + 1);
  for (std::size_t i = 0; i < quads.size(); ++i)
    for (auto& corner : quads[i]) corner = {static_cast<std::uint16_t>(i * 37 % 16384), static_cast<std::uint16_t>(i * 11 % 16384), 16383};
  std::vector<coppice::Split> splits(split_count);
  if (!coppice::decode_page(bytes, first_split, kCards, quads, splits)) return;
  for (std::size_t i = 0; i < splits.size(); ++i) {
    COPPICE_ASSERT(splits[i].parent <= 2 * (first_split + i));
    COPPICE_ASSERT(splits[i].cards[0] < kCards && splits[i].cards[1] < kCards);
    unsigned filled = 0;
    for (std::uint8_t slot : splits[i].parent_slots) filled |= 1u << slot;
    COPPICE_ASSERT(__builtin_popcount(filled) == 4 && filled < 256);
    for (const auto& vertex : splits[i].new_vertices)
      for (std::uint16_t coordinate : vertex) COPPICE_ASSERT(coordinate <= COPPICE_QUANTISED_MAX);
  }
}

void fuzz_wood(std::span<const std::uint8_t> bytes, std::uint32_t vertex_count, std::uint32_t triangle_count) {
  const auto mesh = coppice::decode_wood(bytes, {vertex_count, triangle_count, kMaterials});
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
  if (data[0] % 2 == 0)
    fuzz_page(chunk, first, second % COPPICE_PAGE_SPLITS + 1);
  else
    fuzz_wood(chunk, first, second);
  return 0;
}
