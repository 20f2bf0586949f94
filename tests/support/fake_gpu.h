#pragma once

// What the GPU side does with a streamer, in plain memory; checks on the way that what is resident is a prefix and that memory is not used
// after it was released.

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "ledger.h"
#include "select.h"
#include "streamer.h"

namespace coppice::test {

struct FakeGpuPlant {
  std::uint32_t pages = 0;  ///< uploaded and not evicted
  std::set<std::uint32_t> wood, textures, leaf_meshes;
  std::vector<PageNode> nodes;  ///< by id; grows with the pages

  [[nodiscard]] std::vector<std::uint32_t> node_split() const {
    std::vector<std::uint32_t> splits;
    for (const PageNode& node : nodes) splits.push_back(node.split);
    return splits;
  }
};

class FakeGpu {
 public:
  FakeGpu(Streamer& streamer, Ledger& ledger) : streamer_(streamer), ledger_(ledger) {}

  std::map<std::uint32_t, FakeGpuPlant> plants;
  std::vector<ChunkId> evicted, released;
  std::vector<std::uint32_t> closed;
  std::uint64_t frame_number = 0;
  std::uint64_t frames_behind = 0;  ///< how many frames the GPU has not finished beyond the usual
  bool uploads = true;

  using Groups = std::array<std::optional<ViewGroup>, kMaxViewGroups>;
  /// One frame of the engine; demands by plant index.
  void frame(const LodView& view, std::span<const PlantDemand> demands) { frame({ViewGroup{view, demands}}); }
  void frame(const Groups& view_groups) {
    ++frame_number;
    const std::uint64_t completed = frame_number - 1 > frames_behind ? frame_number - 1 - frames_behind : 0;
    ledger_.begin_frame(frame_number);
    for (const ChunkId& id : streamer_.release(completed)) release(id);
    for (std::uint32_t plant : streamer_.take_closed_plants()) {
      closed.push_back(plant);
      plants.erase(plant);
    }
    streamer_.begin_frame({.frame_number = frame_number, .view_groups = view_groups});
    for (const ChunkId& id : streamer_.take_evicted()) evict(id);
    if (!uploads) return;
    for (const DecodedChunk& chunk : streamer_.take_decoded(UINT64_MAX)) upload(chunk);
    for (const auto& [index, plant] : plants) {
      if (!streamer_.is_open(index)) continue;
      EXPECT_EQ(streamer_.state(index).resident_page_count, plant.pages);
    }
  }

  /// chunk: of take_decoded
  void upload(const DecodedChunk& chunk) {
    ASSERT_TRUE(streamer_.begin_upload(chunk.id));
    ledger_.reserve(chunk.bytes);
    bytes_[key(chunk.id)] = chunk.bytes;
    take(chunk);
    streamer_.uploaded(chunk.id);
  }

 private:
  using Key = std::tuple<std::uint32_t, ChunkKind, std::uint32_t>;
  static Key key(const ChunkId& id) { return {id.plant, id.kind, id.index}; }

  void release(const ChunkId& id) {
    released.push_back(id);
    const auto of = bytes_.extract(key(id));
    ASSERT_FALSE(of.empty());
    ledger_.release(of.mapped());
  }

  void evict(const ChunkId& id) {
    evicted.push_back(id);
    FakeGpuPlant& plant = plants[id.plant];
    if (id.kind != ChunkKind::page) {
      EXPECT_EQ(chunks_of(plant, id.kind).erase(id.index), 1u);
      return;
    }
    EXPECT_EQ(id.index + 1, plant.pages) << "only the last page may go";
    plant.pages = id.index;
  }

  void take(const DecodedChunk& chunk) {
    FakeGpuPlant& plant = plants[chunk.id.plant];
    if (chunk.id.kind == ChunkKind::wood || chunk.id.kind == ChunkKind::leaf_mesh) {
      ASSERT_NE(chunk.mesh, nullptr);
      EXPECT_GT(chunk.mesh->index_count, 0u);
      EXPECT_EQ(chunk.mesh->bytes.size(), chunk.bytes);
      EXPECT_TRUE(chunks_of(plant, chunk.id.kind).insert(chunk.id.index).second);
    } else if (chunk.id.kind == ChunkKind::texture) {
      EXPECT_FALSE(chunk.texture.empty());
      EXPECT_TRUE(plant.textures.insert(chunk.id.index).second);
    } else {
      upload_page(plant, chunk);
    }
  }

  static std::set<std::uint32_t>& chunks_of(FakeGpuPlant& plant, ChunkKind kind) {
    if (kind == ChunkKind::leaf_mesh) return plant.leaf_meshes;
    return kind == ChunkKind::wood ? plant.wood : plant.textures;
  }

  static void upload_page(FakeGpuPlant& plant, const DecodedChunk& chunk) {
    ASSERT_EQ(chunk.id.index, plant.pages) << "pages must come in order";
    ASSERT_EQ(chunk.first_node, 2 * COPPICE_PAGE_SPLITS * chunk.id.index + 1);
    plant.nodes.resize(std::max(plant.nodes.size(), chunk.first_node + chunk.nodes.size()));
    std::ranges::copy(chunk.nodes, plant.nodes.begin() + chunk.first_node);
    plant.nodes[0].split = 0;  // the root, which is in no page
    ++plant.pages;
  }

  Streamer& streamer_;
  Ledger& ledger_;
  std::map<Key, std::uint64_t> bytes_;  ///< what is uploaded takes them
};

/// `count` instances of a size.
inline PlantDemand demand_of(float size_px, float count = 1.0f) {
  PlantDemand demand;
  demand.max_size_px = size_px;
  std::uint32_t bin = 0;
  while (bin + 1 < kSizeBinCount && size_bin_px(bin) < size_px) ++bin;
  demand.instances[bin] = count;
  return demand;
}

}  // namespace coppice::test
