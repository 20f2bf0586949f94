#include "dry_run.h"

#include <gtest/gtest.h>

#include "image_decode.h"
#include "polygons.h"
#include "results.h"
#include "test_foliage.h"

namespace coppice::bake::leaf_preview_test {

constexpr std::uint32_t kSide = kPreviewSizePx;

struct Decoded {
  Image image;
  [[nodiscard]] const std::uint8_t* at(std::uint32_t x, std::uint32_t y) const { return &image.rgba.at(4 * (y * image.width + x)); }
};

Decoded picture_of(const Plant& plant) {
  return {test::must(decode_image(test::must(render_leaf_preview_png(plant)), 3 * kSide))};
}

Mesh square(float x) {
  Mesh mesh;
  test::add_polygon(mesh, test::rectangle({x, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                    std::array{glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)});
  return mesh;
}

/// A leaf on the left, wood on the right, seen from the front.
Plant leaf_beside_wood() {
  Plant plant;
  plant.materials.resize(1);
  plant.foliage = square(-1.0f);
  plant.leaves = {{0, 2}};
  plant.wood = square(0.0f);
  return plant;
}

TEST(LeafPreview, LeavesAreGreenWoodIsBrownNothingIsWhite) {
  const Decoded picture = picture_of(leaf_beside_wood());
  ASSERT_EQ(picture.image.width, 3 * kSide);
  ASSERT_EQ(picture.image.height, kSide);
  const std::uint8_t *leaf = picture.at(kSide / 4, kSide / 2), *wood = picture.at(3 * kSide / 4, kSide / 2), *nothing = picture.at(2, 2);
  EXPECT_GT(leaf[1], leaf[0]);
  EXPECT_GT(leaf[1], leaf[2]);
  EXPECT_GT(wood[0], wood[1]);
  EXPECT_GT(wood[1], wood[2]);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(nothing[c], 255);
}

TEST(LeafPreview, MasksAreHoles) {
  Plant plant = leaf_beside_wood();
  plant.materials[0].image = 0;
  plant.materials[0].alpha_cutoff = 0.5f;
  plant.images = {{1, 2, {0, 0, 0, 255, 0, 0, 0, 0}}};
  const Decoded picture = picture_of(plant);
  // v is 0 at the lower edge, and row 0 of the image is opaque.
  const std::uint8_t *lower = picture.at(kSide / 4, kSide / 2 + kSide / 8), *upper = picture.at(kSide / 4, kSide / 2 - kSide / 8);
  EXPECT_LT(lower[0], 255);
  EXPECT_EQ(upper[0], 255);
}

TEST(LeafPreview, APlantWithoutAnythingIsWhite) {
  EXPECT_EQ(picture_of({}).at(kSide / 2, kSide / 2)[0], 255);
}

}  // namespace coppice::bake::leaf_preview_test
