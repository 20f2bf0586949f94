#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <set>

#include "error_image.h"
#include "inspect.h"
#include "packed_plant.h"
#include "quantised_tree.h"
#include "reader.h"
#include "results.h"
#include "unpack.h"

namespace coppice::bake::pack_test {

using test::packed;
using test::packed_plant;
using test::random_plant;

Quad quad_of(const Tree& tree, std::uint32_t node) {
  Quad quad;
  for (std::size_t corner = 0; corner < 4; ++corner) quad[corner] = tree.vertices[tree.nodes[node].vertices[corner]];
  return quad;
}

/// Nodes alive after the first leaf_count - 1 splits.
std::vector<std::uint32_t> cut(const Tree& tree, std::uint32_t leaf_count) {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t node = 0; node < 2 * leaf_count - 1; ++node)
    if (tree.node_split[node] == kNone || tree.node_split[node] >= leaf_count - 1) nodes.push_back(node);
  return nodes;
}

/// Loose triangles, which no simplifier can join.
Mesh crumbs(std::uint32_t triangle_count) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 3 * triangle_count; ++i) {
    const auto angle = static_cast<float>(i) * 2.4f, height = static_cast<float>(i) / static_cast<float>(triangle_count);
    mesh.positions.emplace_back(std::cos(angle) * height, height, std::sin(angle) * height);
    mesh.normals.emplace_back(0.0f, 1.0f, 0.0f);
    mesh.uvs.emplace_back(height, 0.5f);
    mesh.indices.push_back(i);
  }
  mesh.triangle_materials.assign(triangle_count, 0);
  return mesh;
}

TEST(Pack, TheFirstPictureIsOneReadOf64KiB) {
  for (std::size_t lod_count : {std::size_t{1}, std::size_t{COPPICE_MAX_WOOD_LODS}}) {
    BakedPlant plant = random_plant({.leaf_count = 3000, .card_count = 200});
    plant.wood.lods.assign(lod_count, crumbs(20000));
    plant.errors.sizes_px.assign(kErrorSizesPx.begin(), kErrorSizesPx.end());  // errors of another LoD are measured there
    plant.errors.error_px.assign(plant.errors.leaf_counts.size() * kErrorSizesPx.size(), 0.0f);
    plant.sphere.radius = 10.0f;
    const auto file = packed(plant);
    const auto front = test::must(read_front(file, file.size()));
    EXPECT_GT(find_chunk(front, COPPICE_CHUNK_WOOD, 0)->bytes, 2 * COPPICE_FIRST_READ_BYTES) << "fits anyway: no test";
    EXPECT_LE(front.header.first_read_bytes, COPPICE_FIRST_READ_BYTES);
    const std::uint32_t coarsest = front.plant.wood_lod_count - 1;
    EXPECT_EQ(coarsest, std::min<std::size_t>(lod_count, COPPICE_MAX_WOOD_LODS - 1));
    EXPECT_EQ(front.plant.wood_triangle_counts[0], 20000u);
    EXPECT_GT(front.plant.wood_triangle_counts[coarsest], 100u) << "coarser than need be";
    EXPECT_TRUE(unpack(file));
  }
}

void expect_round_trip(const BakedPlant& plant, std::uint32_t steps) {
  const std::vector<std::uint8_t> file = packed(plant);
  const auto front = test::must(read_front(file, file.size()));
  EXPECT_EQ(quantised_max(front.plant), steps);
  const auto back = test::must(unpack(file));
  ASSERT_EQ(back.tree.leaf_count(), plant.tree.leaf_count());
  EXPECT_EQ(back.tree.split_parent, plant.tree.split_parent);
  EXPECT_EQ(back.tree.node_split, plant.tree.node_split);
  EXPECT_EQ(back.tree.vertices.size(), 4u * plant.tree.leaf_count());
  const QuantisationBox box = leaf_box(plant.tree, steps);
  for (std::uint32_t node = 0; node < plant.tree.nodes.size(); ++node) {
    EXPECT_EQ(back.tree.nodes[node].card, plant.tree.nodes[node].card);
    EXPECT_EQ(back.tree.nodes[node].opacity, plant.tree.nodes[node].opacity);
    EXPECT_EQ(back.tree.nodes[node].normals, plant.tree.nodes[node].normals) << node;
    const Quad before = quad_of(plant.tree, node), after = quad_of(back.tree, node);
    for (std::size_t corner = 0; corner < 4; ++corner)
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_LE(std::abs(before[corner][axis] - after[corner][axis]),
                  (box.max[axis] - box.min[axis]) * (0.502f / static_cast<float>(steps)))
            << "node " << node;
  }
}

// Textured quads have the finer steps, unless leaf meshes are finer still.
TEST(Pack, RoundTripKeepsEveryNodeWithinHalfAStep) {
  for (std::uint32_t leaf_count : {1u, 2u, 100u, 513u, 1200u}) {
    BakedPlant plant = random_plant({.leaf_count = leaf_count});
    expect_round_trip(plant, COPPICE_FINE_QUANTISED_MAX);
    for (Material& material : plant.materials) material.image = kNone;
    expect_round_trip(plant, COPPICE_QUANTISED_MAX);
  }
}

TEST(Pack, RoundTripKeepsHowNodesShow) {
  for (const test::Looks looks : {test::Looks::smooth, test::Looks::sided, test::Looks::noise})
    for (std::uint32_t leaf_count : {1u, 2u, 1200u})
      expect_round_trip(random_plant({.leaf_count = leaf_count, .looks = looks}), COPPICE_FINE_QUANTISED_MAX);
}

TEST(Pack, TheFinestCutIsTheSourceLeaves) {
  const BakedPlant plant = random_plant({.leaf_count = 300});
  const auto back = test::must(unpack(packed(plant)));
  const QuantisationBox box = leaf_box(plant.tree, COPPICE_FINE_QUANTISED_MAX);
  const auto source_leaves = [&](const Tree& tree) {
    std::multiset<std::array<QuantisedPoint, 4>> quads;
    for (std::uint32_t node : cut(tree, 300)) {
      EXPECT_NE(tree.node_source[node], kNone);
      std::array<QuantisedPoint, 4> quad;
      for (std::size_t corner = 0; corner < 4; ++corner) quad[corner] = quantise(box, quad_of(tree, node)[corner]);
      quads.insert(quad);
    }
    return quads;
  };
  EXPECT_EQ(source_leaves(back.tree), source_leaves(plant.tree));
}

TEST(Pack, SamePlantSameBytes) {
  const BakedPlant plant = random_plant({.leaf_count = 600});
  EXPECT_EQ(packed(plant), packed(plant));
}

// The leaf box may differ by a rounding of float: its far side is computed from the last step.
TEST(Pack, RepackingAnUnpackedFileGivesTheSamePages) {
  const auto file = packed_plant({.leaf_count = 600});
  const auto again = packed(*unpack(file));
  const auto front = read_front(file, file.size()), front_again = read_front(again, again.size());
  for (std::uint32_t page = 0; page < 2; ++page)
    EXPECT_EQ(find_chunk(*front, COPPICE_CHUNK_PAGE, page)->checksum, find_chunk(*front_again, COPPICE_CHUNK_PAGE, page)->checksum);
}

TEST(Pack, TablesComeBackUnchanged) {
  const BakedPlant plant = random_plant({.leaf_count = 50, .card_count = 3});
  const auto back = test::must(unpack(packed(plant)));
  EXPECT_EQ(back.name, plant.name);
  EXPECT_EQ(back.metric, plant.metric);
  EXPECT_EQ(back.errors.leaf_counts, plant.errors.leaf_counts);
  EXPECT_EQ(back.errors.sizes_px, plant.errors.sizes_px);
  EXPECT_EQ(back.errors.error_px, plant.errors.error_px);
  EXPECT_EQ(back.sphere.radius, plant.sphere.radius);
  ASSERT_EQ(back.card_table.size(), plant.card_table.size());
  for (std::size_t i = 0; i < plant.card_table.size(); ++i) {
    EXPECT_EQ(back.card_table[i].material, plant.card_table[i].material);
    EXPECT_EQ(back.card_table[i].uv, plant.card_table[i].uv);
  }
  ASSERT_EQ(back.materials.size(), plant.materials.size());
  for (std::size_t i = 0; i < plant.materials.size(); ++i) {
    EXPECT_EQ(back.materials[i].base_color, plant.materials[i].base_color);
    EXPECT_EQ(back.materials[i].image, plant.materials[i].image);
    EXPECT_EQ(back.materials[i].alpha_cutoff, plant.materials[i].alpha_cutoff);
    EXPECT_EQ(back.materials[i].double_sided, plant.materials[i].double_sided);
  }
  ASSERT_EQ(back.wood.lods.size(), plant.wood.lods.size());
  for (std::size_t lod = 0; lod < plant.wood.lods.size(); ++lod)
    EXPECT_EQ(back.wood.lods[lod].indices.size(), plant.wood.lods[lod].indices.size());
  ASSERT_EQ(back.images.size(), 1u);
  EXPECT_EQ(back.images[0].width, plant.images[0].width);
}

TEST(Pack, TheFirstPictureIsOneRead) {
  const auto file = packed_plant({.leaf_count = 600});
  const auto header = test::must(read_header(std::span(file).first(64), file.size()));
  const std::vector<std::uint8_t> first_read(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(header.first_read_bytes));
  const auto front = test::must(read_front(first_read, file.size()));
  for (const auto* chunk : {find_chunk(front, COPPICE_CHUNK_WOOD, 1), find_chunk(front, COPPICE_CHUNK_PAGE, 0)})
    EXPECT_LE(chunk->offset + chunk->bytes, first_read.size());
  for (const auto* chunk :
       {find_chunk(front, COPPICE_CHUNK_WOOD, 0), find_chunk(front, COPPICE_CHUNK_PAGE, 1), find_chunk(front, COPPICE_CHUNK_TEXTURE, 0)})
    EXPECT_GE(chunk->offset, first_read.size());
}

TEST(Pack, AFlatPlantHasAFlatBox) {
  BakedPlant plant = random_plant({.leaf_count = 30});
  for (glm::vec3& vertex : plant.tree.vertices) vertex.z = 0.25f;
  const auto back = test::must(unpack(packed(plant)));
  for (const glm::vec3& vertex : back.tree.vertices) EXPECT_EQ(vertex.z, 0.25f);
}

TEST(Pack, NamesAreCutAtAWholeCharacter) {
  BakedPlant plant = random_plant({.leaf_count = 3});
  plant.name = std::string(62, 'a') + "\xc3\xbc";
  EXPECT_EQ(unpack(packed(plant))->name, std::string(62, 'a'));
  plant.name = "W\xc3\xa4lder\xff";
  EXPECT_EQ(unpack(packed(plant))->name, "W\xc3\xa4lder?");
}

TEST(Pack, KeepsWhetherNormalsAreSided) {
  BakedPlant plant = random_plant({.leaf_count = 3});
  EXPECT_FALSE(unpack(packed(plant))->materials[0].sided_normals);
  plant.materials[0].sided_normals = true;
  EXPECT_TRUE(unpack(packed(plant))->materials[0].sided_normals);
  EXPECT_FALSE(unpack(packed(plant))->materials[1].sided_normals);
}

TEST(Pack, KeepsWind) {
  const BakedPlant plant = random_plant({.leaf_count = 30});
  ASSERT_EQ(plant.wind.nodes.size(), 8u);
  const Wind back = unpack(packed(plant))->wind;
  EXPECT_EQ(std::memcmp(&back.head, &plant.wind.head, sizeof back.head), 0);
  ASSERT_EQ(back.nodes.size(), 8u);
  EXPECT_EQ(std::memcmp(back.nodes.data(), plant.wind.nodes.data(), 32), 0);
}

TEST(Pack, KeepsNormalMaps) {
  BakedPlant plant = random_plant({.leaf_count = 3});
  Image map{4, 4, {}, true};
  for (int i = 0; i < 16; ++i) map.rgba.insert(map.rgba.end(), {204, 128, 230, 255});
  const auto number = static_cast<std::uint32_t>(plant.images.size());
  plant.images.push_back(map);
  plant.materials[0].normal_map = number;
  plant.materials.push_back({.name = "bare", .normal_map = number});
  const auto back = test::must(unpack(packed(plant)));
  EXPECT_EQ(back.materials[0].image, plant.materials[0].image);
  EXPECT_EQ(back.materials[0].normal_map, number);
  EXPECT_EQ(back.materials.back().image, kNone);
  EXPECT_EQ(back.materials.back().normal_map, number);
  EXPECT_TRUE(back.images[number].is_normal_map);
  EXPECT_FALSE(back.images[0].is_normal_map);
  for (std::size_t i = 0; i < map.rgba.size(); ++i) ASSERT_NEAR(back.images[number].rgba[i], map.rgba[i], 6) << i;
}

TEST(Pack, RefusesWhatTheFormatCannotHold) {
  const std::vector<std::function<void(BakedPlant&)>> faults = {
      [](BakedPlant& plant) { plant.tree.nodes[0].card = 2; },
      [](BakedPlant& plant) { plant.tree.nodes.back().opacity = 15; },  // a source leaf's
      [](BakedPlant& plant) { plant.tree.nodes[0].opacity = 0; },
      [](BakedPlant& plant) { plant.tree.nodes[0].opacity = 17; },
      [](BakedPlant& plant) { plant.tree.nodes[0].normals = 0xc001; },
      [](BakedPlant& plant) { plant.tree.vertices[3].y = std::numeric_limits<float>::quiet_NaN(); },
      [](BakedPlant& plant) { plant.tree.split_parent[1] = plant.tree.split_parent[0]; },
      [](BakedPlant& plant) { plant.errors.leaf_counts.back() = 9; },
      [](BakedPlant& plant) { plant.wood = random_plant({.leaf_count = 10, .wood_lod_count = 9}).wood; },
      [](BakedPlant& plant) { plant.materials.clear(); },
  };
  for (std::size_t i = 0; i < faults.size(); ++i) {
    BakedPlant plant = random_plant({.leaf_count = 10});
    faults[i](plant);
    PackSizes sizes;
    EXPECT_EQ(pack(plant, sizes).error().status, Status::invalid_argument) << i;
  }
}

TEST(Inspect, CountsChunksAndBytes) {
  PackSizes sizes;
  const auto file = *pack(random_plant({.leaf_count = 600}), sizes);
  const auto summary = test::must(inspect(file));
  EXPECT_EQ(summary.leaf_count, 600u);
  EXPECT_EQ(summary.page_count, 2u);
  EXPECT_EQ(summary.wood.size(), 2u);
  ASSERT_EQ(summary.textures.size(), 1u);
  EXPECT_EQ(summary.textures[0].mip_count, 4u);
  EXPECT_STREQ(summary.textures[0].format, "bc3");
  EXPECT_STREQ(inspect(packed_plant({.leaf_count = 6}, TextureCoding::rgba8))->textures[0].format, "rgba8");
  std::uint64_t sum = 64;
  for (const ChunkSummary& chunk : summary.chunks) sum += chunk.bytes + 32 * chunk.count;
  EXPECT_EQ(sum, file.size());
  EXPECT_DOUBLE_EQ(summary.bytes_per_leaf, static_cast<double>(sizes.foliage_bytes) / 600.0);
}

TEST(Verify, GoesThroughTheWholeFile) {
  const auto file = packed_plant({.leaf_count = 600});
  const auto report = test::must(verify(file));
  EXPECT_EQ(report.bytes_checked, file.size());
  EXPECT_EQ(report.splits_decoded, 599u);
  EXPECT_EQ(report.chunks_checked, 11u);
  EXPECT_GT(report.wood_triangles_decoded, 0u);
}

TEST(Verify, NoticesASphereThatIsTooSmall) {
  BakedPlant plant = random_plant({.leaf_count = 20});
  plant.sphere.radius *= 0.9f;
  EXPECT_STREQ(verify(packed(plant)).error().what, "plant sphere");
}

}  // namespace coppice::bake::pack_test
