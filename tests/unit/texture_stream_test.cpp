// Textures through the streamer: as stored for a GPU that reads blocks, decoded for one that does not, every byte counted.

#include <gtest/gtest.h>

#include <cstring>

#include "block_texture.h"
#include "coppice_file.h"
#include "mentions.h"
#include "packed_plant.h"
#include "results.h"
#include "streamer_fixture.h"

namespace coppice::texture_stream_test {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kSide = 150;

Bytes plant_file(bake::TextureCoding coding) {
  return test::packed_plant({.leaf_count = 40, .wood_lod_count = 0, .texture_side = kSide}, coding);
}

class TextureStream : public test::StreamerFixture {
 protected:
  void start(Bytes file, bool block_textures) {
    io.files["plant"] = std::move(file);
    options.gpu = {.block_textures = block_textures};
    StreamerFixture::start();
    open("plant");
    frames(2, {PlantDemand{}});
  }
  /// The texture as the GPU side gets it; it is not uploaded.
  Bytes offered() {
    gpu->uploads = false;
    frames(4, {test::demand_of(500.0f)});
    for (const DecodedChunk& chunk : streamer->take_decoded(UINT64_MAX))
      if (chunk.id.kind == ChunkKind::texture) return {chunk.texture.begin(), chunk.texture.end()};
    return {};
  }
  [[nodiscard]] Bytes stored() const {
    const auto first = io.files.at("plant").begin() + static_cast<std::ptrdiff_t>(chunk().offset);
    return {first, first + static_cast<std::ptrdiff_t>(chunk().bytes)};
  }
  [[nodiscard]] const coppice_file_chunk& chunk() const { return *find_chunk(streamer->file(0), COPPICE_CHUNK_TEXTURE, 0); }
};

TEST_F(TextureStream, BlocksGoAsTheyAreToAGpuThatReadsThem) {
  start(plant_file(bake::TextureCoding::bc), true);
  EXPECT_EQ(io.log.size(), 2u) << "header and front";
  const std::uint64_t before = ledger.reserved();
  EXPECT_EQ(offered(), stored());
  EXPECT_EQ(ledger.reserved(), before + 2 * chunk().bytes) << "what waits for its upload, and the room of it";
  gpu->uploads = true;
  frames(2, {test::demand_of(500.0f)});
  EXPECT_EQ(streamer->state(0).resident_texture_count, 1u);
  EXPECT_EQ(ledger.reserved(), before + chunk().bytes);
}

TEST_F(TextureStream, OtherwiseTheyAreDecodedAndCountedAsWhatTheyBecome) {
  start(plant_file(bake::TextureCoding::bc), false);
  EXPECT_EQ(io.log.size(), 2u) << "header and front";
  const std::uint64_t before = ledger.reserved();
  const std::size_t live_before = allocator.live_bytes;
  const auto layout = test::must(read_texture(stored()));
  ASSERT_EQ(layout.format, std::uint32_t{COPPICE_TEXTURE_BC3});
  Bytes expected(decoded_texture_bytes(layout));
  decode_texture(layout, stored(), expected);
  EXPECT_EQ(offered(), expected);
  EXPECT_EQ(allocator.live_bytes, live_before + expected.size()) << "the chunk as stored is gone";
  EXPECT_EQ(ledger.reserved(), before + 2 * expected.size());
  gpu->uploads = true;
  frames(2, {test::demand_of(500.0f)});
  EXPECT_EQ(ledger.reserved(), before + expected.size());
  EXPECT_EQ(allocator.live_bytes, live_before);
}

TEST_F(TextureStream, WhileATextureIsDecodedBothFormsAreCounted) {
  jobs.deferred = true;
  start(plant_file(bake::TextureCoding::bc), false);
  const std::uint64_t before = ledger.reserved();
  const auto layout = test::must(read_texture(stored()));
  frames(1, {test::demand_of(500.0f)});
  EXPECT_EQ(ledger.reserved(), before + 2 * decoded_texture_bytes(layout) + chunk().bytes);
  jobs.run_all();
}

TEST_F(TextureStream, Rgba8IsNeverDecoded) {
  for (const bool block_textures : {true, false}) {
    start(plant_file(bake::TextureCoding::rgba8), block_textures);
    const std::uint64_t before = ledger.reserved();
    EXPECT_EQ(offered(), stored());
    EXPECT_EQ(ledger.reserved(), before + 2 * chunk().bytes);
    gpu.reset();
    streamer.reset();
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
    log.lines.clear();
    start(std::move(bad), block_textures);
    EXPECT_TRUE(offered().empty());
    EXPECT_EQ(streamer->stats().all().failed, 1u);
    ASSERT_EQ(log.lines.size(), 1u);
    EXPECT_TRUE(test::mentions(log.lines[0], {"texture header", "byte " + std::to_string(texture)}));
    gpu.reset();
    streamer.reset();
    EXPECT_EQ(allocator.live_bytes, 0u);
  }
}

}  // namespace coppice::texture_stream_test
