#include "writer.h"

#include <gtest/gtest.h>

#include "tree.h"

namespace coppice::writer_test {

/// Two pages and a texture; the bytes of pages mean nothing to the writer.
FileContents contents() {
  FileContents result;
  result.plant.leaf_count = 514;
  result.plant.root_opacity = kOpaque;
  result.plant.sphere_radius = 1.0f;
  result.plant.metric = COPPICE_METRIC_MI;
  result.materials.resize(1);
  result.cards.resize(1);
  result.cards[0].mask[0] = 1;
  result.error_leaf_counts = {1, 514};
  result.error_sizes_px = {64.0f};
  result.error_px = {2.0f, 0.0f};
  result.pages = {{6, 7, 8, 9}, {10}};
  result.textures = {{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, COPPICE_TEXTURE_RGBA8, 0, 0, 0, 11, 12, 13, 14}};
  return result;
}

TEST(Writer, RefusesWhatTheReaderWould) {
  FileContents wrong = contents();
  wrong.pages.pop_back();
  EXPECT_EQ(write_file(wrong).error().status, Status::invalid_argument);
  EXPECT_STREQ(write_file(wrong).error().what, "plant page_count");
  wrong = contents();
  EXPECT_TRUE(write_file(wrong));
  wrong.pages[1].resize(COPPICE_MAX_PAGE_BYTES + 1);
  EXPECT_STREQ(write_file(wrong).error().what, "chunk table bytes");
  wrong = contents();
  wrong.error_px[1] = 3.0f;
  EXPECT_STREQ(write_file(wrong).error().what, "error table error_px");
}

}  // namespace coppice::writer_test
