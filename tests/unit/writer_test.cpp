#include "writer.h"

#include <gtest/gtest.h>

#include <cstring>

#include "layout.h"
#include "reader.h"
#include "results.h"
#include "tree.h"

namespace coppice::writer_test {

/// Two pages, two wood LoDs, one texture; the bytes of pages and wood mean nothing to the writer.
FileContents contents() {
  FileContents result;
  result.plant.leaf_count = 514;
  result.plant.root_opacity = kOpaque;
  result.plant.sphere_radius = 1.0f;
  result.plant.metric = COPPICE_METRIC_MI;
  std::strcpy(result.plant.name, "hazel");
  result.plant.wood_triangle_counts[0] = 8;
  result.plant.wood_triangle_counts[1] = 4;
  result.plant.wood_vertex_counts[0] = 9;
  result.plant.wood_vertex_counts[1] = 6;
  result.materials.resize(1);
  result.cards.resize(1);
  result.cards[0].mask[0] = 1;
  result.error_leaf_counts = {1, 514};
  result.error_sizes_px = {64.0f};
  result.error_px = {2.0f, 0.0f};
  result.wood_error_px = {0.0f, 1.0f};
  result.wood = {{1, 2, 3}, {4, 5}};
  result.pages = {{6, 7, 8, 9}, {10}};
  result.textures = {{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, COPPICE_TEXTURE_RGBA8, 0, 0, 0, 11, 12, 13, 14}};
  return result;
}

TEST(Writer, LaysChunksOutInTheOrderOfTheFormat) {
  const auto file = test::must(write_file(contents()));
  const auto front = test::must(read_front(file, file.size()));
  std::string order;
  for (const coppice_file_chunk& chunk : front.chunks)
    order += std::string(chunk_kind_name(chunk.kind)) + std::to_string(chunk.index) + " ";
  EXPECT_EQ(order, "PLANT0 MATERIALS0 CARDS0 ERRORS0 WIND0 TEXTURES0 WOOD1 PAGE0 TEXTURE0 WOOD0 PAGE1 ");
  EXPECT_EQ(front.chunks[0].offset, 64u + 11u * 32u);
  EXPECT_EQ(front.header.first_read_bytes, front.chunks[8].offset);
  EXPECT_EQ(front.chunks.back().offset + 1, file.size());
}

TEST(Writer, StoresChunksUnchanged) {
  const auto file = *write_file(contents());
  const auto front = read_front(file, file.size());
  const coppice_file_chunk& page = *find_chunk(*front, COPPICE_CHUNK_PAGE, 0);
  EXPECT_TRUE(std::ranges::equal(std::span(file).subspan(page.offset, page.bytes), contents().pages[0]));
  EXPECT_STREQ(front->plant.name, "hazel");
  EXPECT_TRUE(std::ranges::equal(front->error_px, contents().error_px));
  EXPECT_EQ(front->plant.page_count, 2u);
  const std::vector<std::uint8_t> magic_and_version = {'C', 'O', 'P', 'P', 'I', 'C', 'E', 0x1a, 9, 0, 0, 0, 11, 0, 0, 0};
  EXPECT_TRUE(std::equal(magic_and_version.begin(), magic_and_version.end(), file.begin()));
}

TEST(Writer, RefusesWhatTheReaderWould) {
  FileContents wrong = contents();
  wrong.pages.pop_back();
  EXPECT_EQ(write_file(wrong).error().status, Status::invalid_argument);
  EXPECT_STREQ(write_file(wrong).error().what, "plant page_count");
  wrong = contents();
  wrong.pages[1].resize(COPPICE_MAX_PAGE_BYTES + 1);
  EXPECT_STREQ(write_file(wrong).error().what, "chunk table bytes");
  wrong = contents();
  wrong.error_px[1] = 3.0f;
  EXPECT_STREQ(write_file(wrong).error().what, "error table error_px");
}

}  // namespace coppice::writer_test
