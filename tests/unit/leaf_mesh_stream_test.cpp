// Leaf meshes in the streamer: they come together where the quads' error asks for them, and go without leaving a hole.

#include <gtest/gtest.h>

#include <vector>

#include "chunk_value.h"
#include "mentions.h"
#include "packed_plant.h"
#include "streamer_fixture.h"

namespace coppice::leaf_mesh_stream_test {

using test::demand_of;

constexpr std::uint32_t kParts = 4;

/// Six pages, two textures, the second shown by leaf meshes alone. Quads err by size / 200 px: by the default 2 px at 400 px.
const std::vector<std::uint8_t>& plant_file() {
  static const std::vector<std::uint8_t> file = test::packed_plant({.leaf_count = 3000, .seed = 5, .leaf_mesh_count = kParts});
  return file;
}

class LeafMeshStream : public test::StreamerFixture {
 protected:
  void SetUp() override {
    io.files["a"] = plant_file();
    io.files["b"] = plant_file();
    options.gpu = {.plant_bytes = 1000, .block_textures = true};
    start();
  }
};

TEST_F(LeafMeshStream, ComeBeforeTheirQuadsErrTooMuchAndNoSooner) {
  const std::uint32_t plant = open("a");
  frames(20, {demand_of(150.0f)});
  EXPECT_FALSE(streamer->state(plant).leaf_meshes_resident);
  EXPECT_TRUE(gpu->plants[plant].leaf_meshes.empty());
  EXPECT_EQ(streamer->state(plant).resident_texture_count, 1u) << "the texture that only leaf meshes show is not asked for either";
  EXPECT_EQ(streamer->stats().all().wanted, 0u);
  frames(20, {demand_of(250.0f)});
  EXPECT_TRUE(streamer->state(plant).leaf_meshes_resident);
  EXPECT_EQ(gpu->plants[plant].leaf_meshes.size(), kParts);
  EXPECT_EQ(streamer->state(plant).resident_texture_count, 2u);
  EXPECT_EQ(streamer->stats().all().wanted, 0u);
}

TEST_F(LeafMeshStream, FullDetailAsksForEverything) {
  view.full = true;
  const std::uint32_t plant = open("a");
  frames(20, {demand_of(10.0f)});
  expect_whole(plant);
  EXPECT_TRUE(streamer->state(plant).leaf_meshes_resident);
}

TEST_F(LeafMeshStream, TakeExactlyWhatIsReservedForThem) {
  const std::uint32_t plant = open("a");
  frames(20, {demand_of(150.0f)});
  const std::uint64_t before = ledger.reserved();
  const std::uint32_t pages = streamer->state(plant).resident_page_count;
  frames(20, {demand_of(250.0f)});
  const PlantFile& file = streamer->file(plant);
  std::uint64_t expected = find_chunk(file, COPPICE_CHUNK_TEXTURE, 1)->bytes;
  for (const auto& [vertices, triangles] : file.leaf_meshes) {
    const std::uint64_t clusters = (triangles + gpu::kClusterLeaves - 1) / gpu::kClusterLeaves;
    const std::uint64_t blocks = (clusters + gpu::kBlockClusters - 1) / gpu::kBlockClusters;
    expected += vertices * 32u + 3 * triangles * 4u + clusters * sizeof(gpu::Cluster) + blocks * sizeof(uvec2);
  }
  const std::uint32_t more_pages = streamer->state(plant).resident_page_count - pages;
  EXPECT_EQ(ledger.reserved() - before, expected + more_pages * (32768u + 1024u * (sizeof(QuantisedQuad) + sizeof(std::uint32_t))));
}

TEST_F(LeafMeshStream, AreEvictedAsASetAndLeaveTheQuads) {
  const std::uint32_t plant = open("a");
  frames(30, {demand_of(5000.0f)});
  ASSERT_TRUE(streamer->state(plant).leaf_meshes_resident);
  const std::uint32_t pages = streamer->state(plant).resident_page_count;
  ASSERT_EQ(pages, 6u);
  // One byte too little: something has to go, and from that very frame on nothing may count on what went.
  for (std::uint64_t budget = ledger.reserved() - 1; budget > 300000; budget -= 100000) {
    ledger.set_budget(budget);
    frames(1, {demand_of(5000.0f)});
    const PlantState state = streamer->state(plant);
    EXPECT_EQ(state.leaf_meshes_resident, gpu->plants[plant].leaf_meshes.size() == kParts && state.resident_texture_count == 2);
    EXPECT_GE(state.resident_leaf_count, 513u) << "quads are there all the time";
  }
  EXPECT_FALSE(streamer->state(plant).leaf_meshes_resident);
  ledger.set_budget(256u << 20);
  frames(150, {demand_of(5000.0f)});
  EXPECT_TRUE(streamer->state(plant).leaf_meshes_resident) << "and they come back";
  EXPECT_EQ(streamer->state(plant).resident_page_count, 6u);
}

TEST_F(LeafMeshStream, NoneIsLoadedWhereNotAllFit) {
  const std::uint32_t plant = open("a");
  frames(20, {demand_of(150.0f)});
  const std::uint64_t without = ledger.reserved();
  frames(20, {demand_of(390.0f)});
  const std::uint64_t with = ledger.reserved();
  ASSERT_TRUE(streamer->state(plant).leaf_meshes_resident);
  ledger.set_budget(without);
  frames(20, {demand_of(150.0f)});
  ASSERT_TRUE(gpu->plants[plant].leaf_meshes.empty() || !streamer->state(plant).leaf_meshes_resident);
  ledger.set_budget(without / 2 + with / 2);
  frames(40, {demand_of(390.0f)});
  EXPECT_FALSE(streamer->state(plant).leaf_meshes_resident);
  const std::uint64_t loaded = streamer->stats().all().loaded;
  frames(100, {demand_of(390.0f)});
  EXPECT_EQ(streamer->stats().all().loaded, loaded) << "what cannot be complete is not tried again and again";
}

TEST_F(LeafMeshStream, ADamagedOneLeavesTheQuadsAndIsReportedOnce) {
  const std::uint32_t plant = open("a");
  io.files["a"][find_chunk(streamer->file(plant), COPPICE_CHUNK_LEAF_MESH, 2)->offset + 40] ^= 1;
  frames(30, {demand_of(1000.0f)});
  EXPECT_FALSE(streamer->state(plant).leaf_meshes_resident);
  EXPECT_EQ(streamer->stats().all().failed, 1u);
  EXPECT_EQ(streamer->stats().all().wanted, 0u) << "what can never come is not waited for";
  ASSERT_EQ(log.lines.size(), 1u);
  EXPECT_TRUE(test::mentions(log.lines[0], {"a: leaf mesh 2: "}));
  io.log.clear();
  frames(100, {demand_of(1000.0f)});
  EXPECT_TRUE(io.log.empty());
}

TEST_F(LeafMeshStream, AreWorthTheErrorTheyRemoveByAllTheirBytes) {
  open("a");
  ValuedPlant valued{lod_table(streamer->file(0), streamer->lod_words(0)), 3000, 61440, 1000};
  const PlantDemand demand = demand_of(800.0f, 3.0f);  // 4 px of error, of which the threshold hides 2 less its spread
  const DemandedDetail demanded = demanded_detail(valued, demand, view);
  EXPECT_TRUE(demanded.leaf_meshes);
  const float min_px = 2.0f * (1.0f - lod::kCoppiceThresholdSpread);
  EXPECT_NEAR(leaf_mesh_value(valued, demanded, demand, view), 3.0f * (4.0f - min_px) / 1000.0f, 1e-5f);
  valued.leaf_mesh_bytes = 0;
  EXPECT_FALSE(demanded_detail(valued, demand, view).leaf_meshes) << "a plant without";
}

TEST_F(LeafMeshStream, PagesForAllQuadsAreWantedWhereMeshesAreAboutToGo) {
  open("a");
  ValuedPlant valued{lod_table(streamer->file(0), streamer->lod_words(0)), 3000, 61440, 1000};
  const PlantDemand near_switch = demand_of(370.0f);
  EXPECT_GT(demanded_detail(valued, near_switch, view).page_count,
            demanded_detail({valued.table, 3000, 61440}, near_switch, view).page_count);
  EXPECT_EQ(demanded_detail(valued, demand_of(100.0f), view).page_count, 1u);
}

TEST_F(LeafMeshStream, ClosingGivesThemBack) {
  const std::uint32_t plant = open("a");
  const std::uint32_t other = open("b");
  frames(20, {demand_of(500.0f), demand_of(500.0f)});
  ASSERT_TRUE(streamer->state(plant).leaf_meshes_resident && streamer->state(other).leaf_meshes_resident);
  streamer->close_plant(plant);
  streamer->close_plant(other);
  frames(5, {});
  EXPECT_EQ(gpu->closed.size(), 2u);
  EXPECT_EQ(open("a"), 0u);
}

}  // namespace coppice::leaf_mesh_stream_test
