// Close up an instance is drawn with its leaf meshes, far away with quads; under validation, and looked at.

#include <algorithm>
#include <cmath>

#include "random_tree.h"
#include "renderer_scene.h"

namespace coppice::test::leaf_mesh_test {

constexpr std::uint32_t kSidePx = 192;
constexpr std::uint32_t kLeaves = 300;

class LeafMeshTest : public VulkanTest {};

/// Quads are green, meshes red, so that a picture tells which was drawn.
DecodedPlant two_coloured_plant(std::uint32_t part_count, std::uint32_t leaf_count = kLeaves) {
  bake::BakedPlant plant =
      random_plant({.leaf_count = leaf_count, .seed = 4, .wood_lod_count = 1, .texture_side = 0, .leaf_mesh_count = part_count});
  plant.materials[0].base_color = {0.0f, 0.5f, 0.0f, 1.0f};
  plant.materials[1].base_color = {0.0f, 0.0f, 0.2f, 1.0f};
  if (part_count > 0) plant.materials[2].base_color = {0.5f, 0.0f, 0.0f, 1.0f};
  return decoded_plant(plant);
}

coppice_placement at(float x, float z) {
  return placement_at({x, 0.0f, z});
}

/// Quads err by size / 200 px.
Shot view_with(float error_px) {
  return make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = kSidePx, .error_px = error_px});
}

struct Pixels {
  std::size_t green = 0, red = 0;
};

Pixels count(const Picture& picture, std::uint32_t first_column = 0, std::uint32_t last_column = kSidePx) {
  Pixels pixels;
  for (std::uint32_t y = 0; y < picture.height_px; ++y)
    for (std::uint32_t x = first_column; x < last_column; ++x) {
      const std::uint8_t* rgb = picture.at(x, y);
      if (rgb[2] > 100) continue;  // white ground
      if (rgb[1] > rgb[0] + 20) ++pixels.green;
      if (rgb[0] > rgb[1] + 20) ++pixels.red;
    }
  return pixels;
}

TEST_F(LeafMeshTest, CloseUpMeshesFarAwayQuads) {
  RendererScene scene(gpu(), 64);
  scene.place(scene.add_plant(two_coloured_plant(3)), {at(0.0f, 0.0f)});
  // The plant is about 190 px wide: its quads err by about 1 px.
  const RendererScene::Frame near = scene.draw(view_with(0.5f));
  EXPECT_EQ(near.counts.leaf_mesh_instances, 1u);
  EXPECT_EQ(near.counts.leaf_mesh_triangles, 4u * kLeaves);
  EXPECT_EQ(near.counts.leaves, kLeaves);
  EXPECT_GT(count(near.picture).red, std::size_t{kSidePx} * kSidePx / 20);
  EXPECT_EQ(count(near.picture).green, 0u) << "no quad is drawn besides";

  const RendererScene::Frame far = scene.draw(view_with(2.0f));
  EXPECT_EQ(far.counts.leaf_mesh_instances, 0u);
  EXPECT_EQ(far.counts.leaf_mesh_triangles, 0u);
  EXPECT_EQ(count(far.picture).red, 0u);
  EXPECT_GT(count(far.picture).green, std::size_t{kSidePx} * kSidePx / 40);
}

TEST_F(LeafMeshTest, QuadsAreThoseOfAPlantWithoutMeshes) {
  RendererScene with(gpu(), 64), without(gpu(), 64);
  with.place(with.add_plant(two_coloured_plant(1)), {at(0.0f, 0.0f)});
  without.place(without.add_plant(two_coloured_plant(0)), {at(0.0f, 0.0f)});
  Shot view = view_with(0.5f);
  const Pixels meshes = count(with.draw(view).picture);
  view.lod = COPPICE_LOD_FULL;
  const Pixels all_quads = count(without.draw(view).picture);
  EXPECT_EQ(all_quads.red, 0u);
  // A leaf mesh is its quad with the middle raised: it covers about as much.
  EXPECT_NEAR(static_cast<double>(meshes.red), static_cast<double>(all_quads.green), 0.1 * static_cast<double>(all_quads.green));
}

TEST_F(LeafMeshTest, EveryInstanceGetsWhatItsSizeAsksFor) {
  RendererScene scene(gpu(), 256);
  const std::uint32_t first = scene.add_plant(two_coloured_plant(1)), second = scene.add_plant(two_coloured_plant(2));
  // Left near, right far, both of both plants.
  scene.place(first, {at(-1.5f, 0.0f), at(8.0f, -30.0f)});
  scene.place(second, {at(-1.5f, -1.0f), at(7.0f, -30.0f)});
  const RendererScene::Frame frame = scene.draw(view_with(0.5f));
  EXPECT_EQ(frame.counts.visible_instances, 4u);
  EXPECT_EQ(frame.counts.leaf_mesh_instances, 2u);
  EXPECT_EQ(frame.counts.leaf_mesh_triangles, 2u * 4u * kLeaves);
  EXPECT_GT(count(frame.picture, 0, kSidePx / 2).red, 1000u);
  EXPECT_GT(count(frame.picture, kSidePx / 2 + 20, kSidePx).green, 10u);
}

TEST_F(LeafMeshTest, PlantsSideBySideAreDrawnAsEachAlone) {
  const DecodedPlant left = two_coloured_plant(1), right = two_coloured_plant(2);
  const std::vector<coppice_placement> on_the_left{at(-2.2f, 0.0f), at(-2.2f, -1.0f)}, on_the_right{at(2.2f, 0.0f), at(2.2f, -1.0f)};
  Shot view = make_view({.eye_m = {0.0f, 0.3f, 12.0f}, .width_px = kSidePx, .error_px = 0.1f});
  RendererScene both(gpu(), 64), alone_left(gpu(), 64), alone_right(gpu(), 64);
  both.place(both.add_plant(left), on_the_left);
  both.place(both.add_plant(right), on_the_right);
  alone_left.place(alone_left.add_plant(left), on_the_left);
  alone_right.place(alone_right.add_plant(right), on_the_right);
  const RendererScene::Frame frame = both.draw(view);
  EXPECT_EQ(frame.counts.leaf_mesh_instances, 4u);
  const Picture expected_left = alone_left.draw(view).picture, expected_right = alone_right.draw(view).picture;
  for (std::uint32_t y = 0; y < kSidePx; ++y)
    for (std::uint32_t x = 0; x < kSidePx; ++x) {
      const Picture& expected = x < kSidePx / 2 ? expected_left : expected_right;
      ASSERT_TRUE(std::equal(frame.picture.at(x, y), frame.picture.at(x, y) + 3, expected.at(x, y))) << x << ", " << y;
    }
}

TEST_F(LeafMeshTest, FullDetailDrawsMeshesAtAnySize) {
  RendererScene scene(gpu(), 64);
  scene.place(scene.add_plant(two_coloured_plant(2)), {at(0.0f, -40.0f)});
  Shot view = view_with(2.0f);
  view.lod = COPPICE_LOD_FULL;
  EXPECT_EQ(scene.draw(view).counts.leaf_mesh_instances, 1u);
}

/// What a view with so many of the pixels in a square from `first` on sees.
Shot part_of(Shot view, std::uint32_t first, std::uint32_t side) {
  const float scale = static_cast<float>(view.width_px) / static_cast<float>(side);
  const float shift = scale - 1.0f - 2.0f * static_cast<float>(first) / static_cast<float>(side);
  for (std::size_t column = 0; column < 4; ++column)
    for (std::size_t row = 0; row < 2; ++row) {
      float& value = view.clip_from_view[4 * column + row];
      value = scale * value + shift * view.clip_from_view[4 * column + 3];
    }
  view.width_px = view.height_px = side;
  return view;
}

/// A large instance is partly in view: its clusters that are not are left out, and that is not to be seen.
TEST_F(LeafMeshTest, NearThePartsInViewAreDrawn) {
  constexpr std::uint32_t kWide = 512, kFirst = 100, kPart = 128, kManyLeaves = 6000;
  for (const bool compute_raster : {false, true}) {
    RendererScene scene(gpu(), 64, {.compute_raster = compute_raster});
    scene.place(scene.add_plant(two_coloured_plant(3, kManyLeaves)), {at(0.0f, 0.0f)});
    Shot view = make_view({.eye_m = {0.0f, 0.3f, 5.0f}, .width_px = kWide, .error_px = 0.5f});
    const RendererScene::Frame wide = scene.draw(view), part = scene.draw(part_of(view, kFirst, kPart));
    ASSERT_EQ(wide.counts.leaf_mesh_triangles, 4u * kManyLeaves) << "whole";
    EXPECT_EQ(part.counts.leaf_mesh_instances, 1u);
    EXPECT_LT(part.counts.leaf_mesh_triangles, 2u * kManyLeaves);
    std::size_t different = 0, covered = 0;
    for (std::uint32_t y = 0; y < kPart; ++y)
      for (std::uint32_t x = 0; x < kPart; ++x) {
        const std::uint8_t* expected = wide.picture.at(kFirst + x, kFirst + y);
        covered += expected[2] < 200 ? 1u : 0u;
        different += std::equal(expected, expected + 3, part.picture.at(x, y), [](int a, int b) { return std::abs(a - b) <= 2; }) ? 0u : 1u;
      }
    EXPECT_GT(covered, kPart * kPart / 20);
    EXPECT_LE(different, covered / 100) << "but for pixels on edges";
  }
}

/// A mesh leaf in the colours of its quad is lit and tinted as that is: at the switch a leaf keeps its colour.
TEST_F(LeafMeshTest, ALeafKeepsItsColour) {
  bake::BakedPlant plant = random_plant({.leaf_count = 1, .seed = 4, .wood_lod_count = 0, .texture_side = 0, .leaf_mesh_count = 1});
  for (bake::Material& material : plant.materials) material.base_color = {0.2f, 0.3f, 0.1f, 1.0f};
  // Flat: the pyramid's top in the plane of the quad.
  bake::Mesh& mesh = plant.leaf_meshes.parts[0].mesh;
  mesh.positions[4] = 0.25f * (mesh.positions[0] + mesh.positions[1] + mesh.positions[2] + mesh.positions[3]);
  RendererScene scene(gpu(), 64);
  scene.place(scene.add_plant(decoded_plant(plant)), {at(0.0f, 0.0f)});
  const Picture meshes = scene.draw(view_with(0.1f)).picture, quads = scene.draw(view_with(50.0f)).picture;
  ASSERT_EQ(meshes.rgba.size(), quads.rgba.size());
  std::size_t leaf_pixels = 0, different = 0;
  for (std::size_t i = 0; i < meshes.rgba.size(); i += 4) {
    if (quads.rgba[i + 2] > 200 && meshes.rgba[i + 2] > 200) continue;
    ++leaf_pixels;
    for (std::size_t c = 0; c < 3; ++c)
      if (std::abs(int{meshes.rgba[i + c]} - int{quads.rgba[i + c]}) > 8) {
        ++different;
        break;
      }
  }
  EXPECT_GT(leaf_pixels, 100u);
  EXPECT_LT(different, leaf_pixels / 50);
}

}  // namespace coppice::test::leaf_mesh_test
