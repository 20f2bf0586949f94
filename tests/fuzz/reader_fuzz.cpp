// libFuzzer: any bytes, with their checksums made right, are refused or unpack to a valid plant, and a second reader, of FORMAT.md alone,
// takes and refuses the same. The checks trap, so that a wrong answer is found like a crash.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "check.h"
#include "coppice_file.h"
#include "inspect.h"
#include "naive_reader.h"
#include "unpack.h"

namespace {

void check_tree(const coppice::bake::BakedPlant& plant) {
  const coppice::bake::Tree& tree = plant.tree;
  COPPICE_ASSERT(tree.nodes.size() == 2 * std::size_t{tree.leaf_count()} - 1);
  COPPICE_ASSERT(tree.vertices.size() == 4 * std::size_t{tree.leaf_count()});
  std::vector<bool> replaced(tree.nodes.size());
  for (std::size_t split = 0; split < tree.split_parent.size(); ++split) {
    COPPICE_ASSERT(tree.split_parent[split] <= 2 * split && !replaced[tree.split_parent[split]]);
    replaced[tree.split_parent[split]] = true;
  }
  for (const auto& node : tree.nodes) {
    COPPICE_ASSERT(node.card < plant.card_table.size());
    for (std::uint32_t vertex : node.vertices) COPPICE_ASSERT(vertex < tree.vertices.size());
  }
}

void check_wood(const coppice::bake::BakedPlant& plant) {
  for (const coppice::bake::Mesh& lod : plant.wood.lods) {
    COPPICE_ASSERT(lod.indices.size() == 3 * lod.triangle_materials.size());
    for (std::uint32_t index : lod.indices) COPPICE_ASSERT(index < lod.positions.size());
    for (std::uint32_t material : lod.triangle_materials) COPPICE_ASSERT(material < plant.materials.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> file(data, data + size);
  coppice::test::fix_checksums(file);
  const auto plant = coppice::bake::unpack(file);
  if (plant) {
    check_tree(*plant);
    check_wood(*plant);
    COPPICE_ASSERT(coppice::bake::inspect(file));
  } else {
    COPPICE_ASSERT(plant.error().offset != coppice::Error::kNoOffset);
  }
  const std::string refusal = coppice::test::read_naively(file).refusal;
  if (bool(plant) != refusal.empty())
    std::fprintf(stderr, "the reader: %s\nthe naive reader: %s\n", plant ? "takes it" : plant.error().message().c_str(), refusal.c_str());
  COPPICE_ASSERT(bool(plant) == refusal.empty());
  return 0;
}
