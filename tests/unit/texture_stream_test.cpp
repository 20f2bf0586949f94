// Textures through the streamer: as stored for a GPU that reads blocks, decoded for one that does not, every byte counted.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "block_texture.h"
#include "coppice_file.h"
#include "fake_gpu.h"
#include "fake_hooks.h"
#include "mentions.h"
#include "packed_plant.h"
#include "streamer.h"

namespace coppice {
namespace texture_stream_test {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kSide = 150;

Bytes plant_file(bake::TextureCoding coding) {
  return test::packed_plant({.leaf_count = 40, .wood_lod_count = 0, .texture_side = kSide}, coding);
}

class TextureStream : public testing::Test {
 protected:
  void start(Bytes file, bool block_textures) {
    file_ = std::move(file);
    io_.files["plant"] = file_;
    const StreamerOptions options{.gpu = {.block_textures = block_textures}};
    auto created = Streamer::create({allocator_.hook(), jobs_.hook(), io_.hook(), log_.hook()}, ledger_, options);
    ASSERT_TRUE(created) << created.error().message();
    streamer_ = *std::move(created);
    gpu_ = std::make_unique<test::FakeGpu>(*streamer_, ledger_);
    ASSERT_TRUE(streamer_->open_plant("plant"));
    frames(2, PlantDemand{});
  }
  void frames(int count, const PlantDemand& demand) {
    for (int i = 0; i < count; ++i) gpu_->frame(view_, std::span(&demand, 1));
  }
  /// The texture as the GPU side gets it; it is not uploaded.
  Bytes offered() {
    gpu_->uploads = false;
    frames(4, test::demand_of(500.0f));
    for (const DecodedChunk& chunk : streamer_->take_decoded(UINT64_MAX))
      if (chunk.id.kind == ChunkKind::texture) return {chunk.texture.begin(), chunk.texture.end()};
    return {};
  }
  [[nodiscard]] Bytes stored() const {
    const auto first = file_.begin() + static_cast<std::ptrdiff_t>(chunk().offset);
    return {first, first + static_cast<std::ptrdiff_t>(chunk().bytes)};
  }
  [[nodiscard]] const coppice_file_chunk& chunk() const { return *find_chunk(streamer_->file(0), COPPICE_CHUNK_TEXTURE, 0); }

  Ledger ledger_{256ull << 20};
  test::FakeAllocator allocator_;
  test::FakeJobs jobs_;
  test::FakeIo io_;
  test::FakeLog log_;
  LodView view_;
  Bytes file_;
  std::unique_ptr<Streamer> streamer_;
  std::unique_ptr<test::FakeGpu> gpu_;
};

TEST_F(TextureStream, BlocksGoAsTheyAreToAGpuThatReadsThem) {
  start(plant_file(bake::TextureCoding::bc), true);
  EXPECT_EQ(io_.log.size(), 2u) << "header and front";
  const std::uint64_t before = ledger_.reserved();
  EXPECT_EQ(offered(), stored());
  EXPECT_EQ(ledger_.reserved(), before + 2 * chunk().bytes) << "what waits for its upload, and the room of it";
  gpu_->uploads = true;
  frames(2, test::demand_of(500.0f));
  EXPECT_EQ(streamer_->state(0).resident_texture_count, 1u);
  EXPECT_EQ(ledger_.reserved(), before + chunk().bytes);
}

TEST_F(TextureStream, OtherwiseTheyAreDecodedAndCountedAsWhatTheyBecome) {
  start(plant_file(bake::TextureCoding::bc), false);
  EXPECT_EQ(io_.log.size(), 2u) << "header and front";
  const std::uint64_t before = ledger_.reserved();
  const std::size_t live_before = allocator_.live_bytes;
  const auto layout = read_texture(stored());
  ASSERT_TRUE(layout);
  ASSERT_EQ(layout->format, std::uint32_t{COPPICE_TEXTURE_BC3});
  Bytes expected(decoded_texture_bytes(*layout));
  decode_texture(*layout, stored(), expected);
  EXPECT_EQ(offered(), expected);
  EXPECT_EQ(allocator_.live_bytes, live_before + expected.size()) << "the chunk as stored is gone";
  EXPECT_EQ(ledger_.reserved(), before + 2 * expected.size());
  gpu_->uploads = true;
  frames(2, test::demand_of(500.0f));
  EXPECT_EQ(ledger_.reserved(), before + expected.size());
  EXPECT_EQ(allocator_.live_bytes, live_before);
}

TEST_F(TextureStream, WhileATextureIsDecodedBothFormsAreCounted) {
  jobs_.deferred = true;
  start(plant_file(bake::TextureCoding::bc), false);
  const std::uint64_t before = ledger_.reserved();
  const auto layout = read_texture(stored());
  ASSERT_TRUE(layout);
  frames(1, test::demand_of(500.0f));
  EXPECT_EQ(ledger_.reserved(), before + 2 * decoded_texture_bytes(*layout) + chunk().bytes);
  jobs_.run_all();
}

TEST_F(TextureStream, Rgba8IsNeverDecoded) {
  for (const bool block_textures : {true, false}) {
    start(plant_file(bake::TextureCoding::rgba8), block_textures);
    const std::uint64_t before = ledger_.reserved();
    EXPECT_EQ(offered(), stored());
    EXPECT_EQ(ledger_.reserved(), before + 2 * chunk().bytes);
    gpu_.reset();
    streamer_.reset();
  }
}

TEST_F(TextureStream, ADamagedTextureIsNamedWithItsPlace) {
  const Bytes good = plant_file(bake::TextureCoding::bc);
  const std::size_t texture = test::chunk_offset(good, COPPICE_CHUNK_TEXTURE);
  for (const bool block_textures : {true, false}) {
    Bytes bad = good;
    const std::uint32_t sides[2] = {kSide + 2, kSide - 1};  // as many blocks in every level
    std::memcpy(bad.data() + texture, sides, sizeof sides);
    test::fix_checksums(bad);
    log_.lines.clear();
    start(std::move(bad), block_textures);
    EXPECT_TRUE(offered().empty());
    EXPECT_EQ(streamer_->stats().all().failed, 1u);
    ASSERT_EQ(log_.lines.size(), 1u);
    EXPECT_TRUE(test::mentions(log_.lines[0], {"texture header", "byte " + std::to_string(texture)}));
    gpu_.reset();
    streamer_.reset();
    EXPECT_EQ(allocator_.live_bytes, 0u);
  }
}

}  // namespace texture_stream_test
}  // namespace coppice
