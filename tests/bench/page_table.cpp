// Bytes a leaf and decoded leaves a second of .coppice files, with their pages as they are stored and as this build would store them.
//   page_table A.coppice B.coppice ...

#include <algorithm>
#include <cstdio>
#include <memory>
#include <numeric>
#include <optional>

#include "atomic_file.h"
#include "page_codec.h"
#include "page_encode.h"
#include "quantised_tree.h"
#include "reader.h"
#include "stopwatch.h"
#include "unpack.h"

namespace {

using namespace coppice;

using Pages = std::vector<std::vector<std::uint8_t>>;

Pages encode(const bake::QuantisedTree& tree) {
  Pages pages;
  const std::span<const Split> splits = tree.splits;
  for (std::size_t first = 0; first < splits.size(); first += COPPICE_PAGE_SPLITS) {
    const auto page_splits = splits.subspan(first, std::min<std::size_t>(COPPICE_PAGE_SPLITS, splits.size() - first));
    pages.push_back(
        *bake::encode_page({page_splits, static_cast<std::uint32_t>(first), tree.nodes, tree.box.max - tree.box.min, tree.box.steps}));
  }
  return pages;
}

double bytes_of(const Pages& pages) {
  double sum = 0.0;
  for (const auto& page : pages) sum += static_cast<double>(page.size());
  return sum;
}

/// Decodes every page in order and lowers best_s[page] where that took less; false if one does not decode.
bool decode(const bake::QuantisedTree& tree, const Pages& pages, std::vector<PageNode>& nodes, DecoderPool& decoders,
            std::vector<double>& best_s) {
  const auto scratch = std::make_unique<PageScratch>();
  std::vector<PageNode*> places;
  for (std::size_t page = 0; page < pages.size(); ++page) places.push_back(nodes.data() + 1 + 2 * COPPICE_PAGE_SPLITS * page);
  for (std::uint32_t page = 0; page < pages.size(); ++page) {
    const PageOutput out{{nodes.data(), std::span(places).first(page + 1)}, {}};
    const test::Stopwatch watch;
    if (!decode_page(pages[page], {page, static_cast<std::uint32_t>(tree.splits.size() + 1), COPPICE_MAX_CARDS, tree.box.steps}, out,
                     *scratch, decoders))
      return false;
    best_s[page] = std::min(best_s[page], watch.seconds());
  }
  return true;
}

/// Each page at the best of several runs: other programs share the cores.
std::optional<double> leaves_per_second(const bake::QuantisedTree& tree, const Pages& pages) {
  constexpr int kRuns = 15;
  DecoderPool decoders;
  std::vector<PageNode> nodes(tree.nodes.size());
  nodes[0] = tree.nodes[0];
  std::vector<double> best_s(pages.size(), 1e9);
  for (int run = 0; run < kRuns; ++run)
    if (!decode(tree, pages, nodes, decoders, best_s)) return {};
  for (std::size_t node = 0; node < nodes.size(); ++node)
    if (nodes[node].corners != tree.nodes[node].corners || nodes[node].card != tree.nodes[node].card) return {};
  return static_cast<double>(tree.splits.size() + 1) / std::accumulate(best_s.begin(), best_s.end(), 0.0);
}

bool print_row(const char* path) {
  const auto bytes = bake::read_file(path);
  const auto plant = bytes ? bake::unpack(*bytes) : Result<bake::BakedPlant>(bytes.error());
  if (!plant) {
    std::fprintf(stderr, "%s: %s\n", path, plant.error().message().c_str());
    return false;
  }
  const auto front = read_front(*bytes, bytes->size());
  double stored = 0.0;
  for (const coppice_file_chunk& chunk : front->chunks)
    if (chunk.kind == COPPICE_CHUNK_PAGE) stored += static_cast<double>(chunk.bytes);
  const auto tree = bake::quantise_tree(plant->tree, quantised_max(front->plant));
  if (!tree) return false;
  const Pages pages = encode(*tree);
  const auto speed = leaves_per_second(*tree, pages);
  if (!speed) {
    std::fprintf(stderr, "%s: pages do not decode to what was encoded\n", path);
    return false;
  }
  const auto leaves = static_cast<double>(plant->tree.leaf_count());
  std::printf("| %s | %.0f | %.2f | %.2f | %.2f |\n", plant->name.c_str(), leaves, stored / leaves, bytes_of(pages) / leaves, *speed / 1e6);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  std::printf("| plant | leaves | stored B/leaf | now B/leaf | decoded M leaves/s |\n| --- | --- | --- | --- | --- |\n");
  bool all = argc > 1;
  for (int i = 1; i < argc; ++i) all = print_row(argv[i]) && all;
  return all ? 0 : 1;
}
