// Page decode: leaves a second, and bytes a leaf. A wrong answer fails: the decoded quads are compared by hash with the encoded ones.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include "layout.h"
#include "page_codec.h"
#include "page_encode.h"
#include "quantised_tree.h"
#include "random_tree.h"
#include "wood_codec.h"
#include "wood_encode.h"

namespace coppice {
namespace {

struct Pages {
  bake::QuantisedTree tree;
  std::vector<std::vector<std::uint8_t>> pages;
  std::size_t bytes = 0;
};

Pages encode_pages(std::uint32_t leaf_count) {
  Pages result{*bake::quantise_tree(test::random_tree(test::random_foliage(leaf_count, 1), 1)), {}, 0};
  const std::span<const Split> splits = result.tree.splits;
  for (std::size_t first = 0; first < splits.size(); first += COPPICE_PAGE_SPLITS) {
    const auto page_splits = splits.subspan(first, std::min<std::size_t>(COPPICE_PAGE_SPLITS, splits.size() - first));
    result.pages.push_back(
        *bake::encode_page({page_splits, static_cast<std::uint32_t>(first), result.tree.nodes, result.tree.box.max - result.tree.box.min}));
    result.bytes += result.pages.back().size();
  }
  return result;
}

/// Corners and cards: what a page says of its nodes.
std::uint64_t hash_of(std::span<const PageNode> nodes) {
  constexpr std::size_t kBytes = offsetof(PageNode, by_death);
  std::vector<std::uint8_t> bytes(kBytes * nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) std::memcpy(bytes.data() + kBytes * i, &nodes[i], kBytes);
  return checksum(bytes);
}

void decode_pages(benchmark::State& state) {
  const Pages pages = encode_pages(static_cast<std::uint32_t>(state.range(0)));
  std::vector<PageNode> nodes(pages.tree.nodes.size());
  nodes[0] = pages.tree.nodes[0];
  std::vector<PageNode*> places;
  for (std::size_t page = 0; page < pages.pages.size(); ++page) places.push_back(nodes.data() + 1 + 2 * COPPICE_PAGE_SPLITS * page);
  const auto scratch = std::make_unique<PageScratch>();
  DecoderPool decoders;
  for (auto _ : state) {
    for (std::uint32_t page = 0; page < pages.pages.size(); ++page) {
      const PageOutput out{{nodes.data(), std::span(places).first(page + 1)}, {}};
      if (auto decoded =
              decode_page(pages.pages[page], {page, static_cast<std::uint32_t>(pages.tree.splits.size() + 1), 2}, out, *scratch, decoders);
          !decoded)
        return state.SkipWithError(decoded.error().message().c_str());
    }
  }
  if (hash_of(nodes) != hash_of(pages.tree.nodes)) state.SkipWithError("decoded nodes differ from the encoded ones");
  state.counters["leaves/s"] = benchmark::Counter(static_cast<double>(state.range(0)), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes/leaf"] = static_cast<double>(pages.bytes) / static_cast<double>(state.range(0));
}
BENCHMARK(decode_pages)->Arg(386)->Arg(4456)->Arg(13162)->Arg(77280)->Arg(300000)->Unit(benchmark::kMillisecond);

void decode_wood_lod(benchmark::State& state) {
  const bake::EncodedWood wood = *bake::encode_wood(test::tube(16, static_cast<std::uint32_t>(state.range(0)), 0), 1);
  const std::vector<coppice_file_material> materials(1);
  for (auto _ : state)
    if (auto mesh = decode_wood(wood.bytes, {wood.vertex_count, wood.triangle_count, materials});
        !mesh || mesh->indices.size() != 3 * wood.triangle_count)
      return state.SkipWithError("wood does not decode to the triangles it had");
  state.counters["triangles/s"] = benchmark::Counter(wood.triangle_count, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes/triangle"] = static_cast<double>(wood.bytes.size()) / wood.triangle_count;
}
BENCHMARK(decode_wood_lod)->Arg(300)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice
