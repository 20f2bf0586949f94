// The product's reader against a second one that was written from FORMAT.md alone: both take the same files, and read the same from them.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "coppice_file.h"
#include "decoded_pages.h"
#include "inspect.h"
#include "naive_reader.h"
#include "packed_plant.h"
#include "places.h"
#include "reader.h"
#include "results.h"
#include "unpack.h"
#include "wood_codec.h"

namespace coppice::naive_reader_test {

using test::Bytes;
using test::NaivePlant;

struct NamedFile {
  std::string name;
  Bytes bytes;
};

std::vector<NamedFile> files_below(const std::filesystem::path& folder) {
  std::vector<NamedFile> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".coppice")
      files.push_back({entry.path().lexically_relative(folder).string(), *bake::read_file(entry.path())});
  std::ranges::sort(files, {}, &NamedFile::name);
  return files;
}

/// Files of this version with all that a file can have, each small.
std::vector<NamedFile> made_files() {
  std::vector<NamedFile> files;
  const auto add = [&](const char* name, const test::RandomPlantOptions& options) { files.push_back({name, test::packed_plant(options)}); };
  add("one_leaf", {.leaf_count = 1, .seed = 3, .wood_lod_count = 0, .texture_side = 0});
  add("many_cards", {.leaf_count = 60, .seed = 4, .card_count = 9, .wood_lod_count = 1, .texture_side = 2});
  add("leaf_meshes", {.leaf_count = 40, .seed = 5, .wood_lod_count = 3, .texture_side = 4, .leaf_mesh_count = 2});
  add("three_pages", {.leaf_count = 1200, .seed = 6, .wood_lod_count = 0, .texture_side = 0});
  add("smooth_looks", {.leaf_count = 700, .seed = 7, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::smooth});
  add("sided_looks", {.leaf_count = 700, .seed = 9, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::sided});
  add("noisy_looks", {.leaf_count = 30, .seed = 8, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::noise});
  add("many_noisy_looks", {.leaf_count = 1200, .seed = 10, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::noise});
  add("one_leaf_with_normals", {.leaf_count = 1, .seed = 3, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::sided});
  return files;
}

Bytes chunk_bytes(const Bytes& file, const PlantFile& front, coppice_chunk_kind kind, std::uint32_t index) {
  const coppice_file_chunk& chunk = *find_chunk(front, kind, index);
  const auto first = file.begin() + static_cast<std::ptrdiff_t>(chunk.offset);
  return Bytes(first, first + static_cast<std::ptrdiff_t>(chunk.bytes));
}

template <class T, class U>
bool same_bits(const T& a, const U& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

void expect_same_front(const PlantFile& front, const NaivePlant& naive) {
  const coppice_file_plant& plant = front.plant;
  ASSERT_EQ(front.chunks.size(), naive.chunks.size());
  for (std::size_t i = 0; i < naive.chunks.size(); ++i) {
    EXPECT_EQ(front.chunks[i].kind, naive.chunks[i].kind);
    EXPECT_EQ(front.chunks[i].offset, naive.chunks[i].offset);
    EXPECT_EQ(front.chunks[i].bytes, naive.chunks[i].bytes);
  }
  EXPECT_EQ(plant.leaf_count, naive.leaf_count);
  EXPECT_EQ(plant.metric, naive.metric);
  EXPECT_EQ(quantised_max(plant), naive.largest);
  EXPECT_EQ(plant.name, naive.name);
  EXPECT_TRUE(std::ranges::equal(plant.leaf_box_min, naive.leaf_box_min) && std::ranges::equal(plant.leaf_box_max, naive.leaf_box_max));
  EXPECT_TRUE(std::ranges::equal(plant.sphere_center, naive.sphere_center) && plant.sphere_radius == naive.sphere_radius);
  EXPECT_TRUE(std::ranges::equal(plant.wood_vertex_counts, naive.wood_vertex_counts));
  EXPECT_TRUE(std::ranges::equal(plant.wood_triangle_counts, naive.wood_triangle_counts));
  EXPECT_TRUE(same_bits(front.error_leaf_counts, naive.error_leaf_counts) && same_bits(front.error_sizes_px, naive.error_sizes_px));
  EXPECT_TRUE(same_bits(front.error_px, naive.error_px));
  EXPECT_TRUE(same_bits(front.leaf_mesh_error_px, naive.leaf_mesh_error_px));
  EXPECT_TRUE(same_bits(front.wood_error_px, naive.wood_error_px));
}

void expect_same_materials(const PlantFile& front, const NaivePlant& naive) {
  ASSERT_EQ(front.materials.size(), naive.materials.size());
  for (std::size_t i = 0; i < naive.materials.size(); ++i) {
    const coppice_file_material& material = front.materials[i];
    const test::NaiveMaterial& other = naive.materials[i];
    EXPECT_TRUE(std::ranges::equal(material.base_color, other.base_color));
    EXPECT_EQ(material.alpha_cutoff, other.alpha_cutoff);
    EXPECT_EQ(material.roughness, other.roughness);
    EXPECT_EQ(material.flags, other.flags);
    EXPECT_EQ(material_texture(material), other.texture == 0xffff ? COPPICE_NO_TEXTURE : other.texture);
    EXPECT_EQ(material_normal_map(material), other.normal_map != 0 ? other.normal_map - 1 : COPPICE_NO_TEXTURE);
  }
  ASSERT_EQ(front.cards.size(), naive.cards.size());
  for (std::size_t i = 0; i < naive.cards.size(); ++i) {
    EXPECT_EQ(front.cards[i].material, naive.cards[i].material);
    EXPECT_EQ(std::memcmp(front.cards[i].uv, naive.cards[i].uv.data(), sizeof front.cards[i].uv), 0);
    EXPECT_TRUE(std::ranges::equal(front.cards[i].albedo, naive.cards[i].albedo));
    EXPECT_TRUE(std::ranges::equal(front.cards[i].mask, naive.cards[i].mask));
  }
}

void expect_same_wind(const WindField& field, const test::NaiveWind& naive) {
  const coppice_file_wind& head = field.head;
  EXPECT_EQ(
      (std::array{head.base_y_m, head.height_m, head.bend_m, head.lean_m, head.sway_m, head.stem_period_s, head.branch_period_s}),
      (std::array{naive.base_y_m, naive.height_m, naive.bend_m, naive.lean_m, naive.sway_m, naive.stem_period_s, naive.branch_period_s}));
  EXPECT_TRUE(std::ranges::equal(head.box_min, naive.box_min) && std::ranges::equal(head.box_max, naive.box_max));
  EXPECT_EQ(head.node_side, naive.side);
  ASSERT_EQ(field.nodes.size(), naive.nodes.size());
  for (std::size_t i = 0; i < field.nodes.size(); ++i) {
    EXPECT_NEAR(field.nodes[i].lean / 255.0, naive.nodes[i].lean, 1e-12) << i;
    EXPECT_NEAR(field.nodes[i].sway_cos / 127.0, naive.nodes[i].sway_cos, 1e-12) << i;
    EXPECT_NEAR(field.nodes[i].sway_sin / 127.0, naive.nodes[i].sway_sin, 1e-12) << i;
  }
}

void expect_same_tree(const Bytes& file, const PlantFile& front, const NaivePlant& naive) {
  const auto quad_of = [](const test::NaiveNode& node) {
    QuantisedQuad quad{};
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) quad[i][axis] = static_cast<std::uint16_t>(node.corners[i][axis]);
    return quad;
  };
  const auto normals_of = [](const test::NaiveNode& node) {
    return pack_normals(node.axis[0], node.axis[1], node.along, static_cast<NormalSide>(node.side));
  };
  const PageNode root = root_node(front.plant);
  bake::DecodedPages pages(root, front.plant.leaf_count, front.plant.card_count, quantised_max(front.plant));
  std::size_t first = 0;
  for (std::uint32_t page = 0; page < front.plant.page_count; ++page) {
    const auto splits = test::must(pages.add(chunk_bytes(file, front, COPPICE_CHUNK_PAGE, page)));
    for (std::size_t i = 0; i < splits.size(); ++i) {
      EXPECT_EQ(splits[i].parent, naive.splits[first + i].parent);
      EXPECT_TRUE(std::ranges::equal(splits[i].parent_slots, naive.splits[first + i].parent_slots)) << first + i;
    }
    first += splits.size();
  }
  const std::vector<PageNode> nodes = pages.nodes();
  ASSERT_EQ(nodes.size(), naive.nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_EQ(nodes[i].corners, quad_of(naive.nodes[i])) << i;
    EXPECT_EQ(nodes[i].card, naive.nodes[i].card) << i;
    EXPECT_EQ(nodes[i].opacity, naive.nodes[i].opacity) << i;
    EXPECT_EQ(nodes[i].normals, normals_of(naive.nodes[i])) << i;
    EXPECT_TRUE(i == 0 || nodes[i].split == naive.nodes[i].death) << i << ": but for the root, which is in no page";
  }
}

void expect_same_mesh(const Bytes& chunk, const WoodShape& shape, const test::NaiveMesh& naive) {
  const auto mesh = test::must(decode_wood(chunk, shape));
  EXPECT_EQ(mesh.vertices.size(), naive.vertex_count);
  ASSERT_EQ(mesh.indices.size(), naive.corners.size());
  for (std::size_t i = 0; i < naive.corners.size(); ++i) {
    const WoodVertex& vertex = mesh.vertices[mesh.indices[i]];
    const test::NaiveVertex& other = naive.corners[i];
    EXPECT_EQ(vertex.position, other.position);
    EXPECT_EQ(vertex.normal, other.normal);
    EXPECT_EQ(vertex.uv, other.uv);
    EXPECT_EQ(vertex.material, other.material);
    EXPECT_TRUE(std::ranges::equal(vertex.stalk, other.stalk));
  }
}

void expect_same_meshes(const Bytes& file, const PlantFile& front, const NaivePlant& naive) {
  ASSERT_EQ(naive.wood.size(), front.plant.wood_lod_count);
  for (std::uint32_t i = 0; i < front.plant.wood_lod_count; ++i)
    expect_same_mesh(chunk_bytes(file, front, COPPICE_CHUNK_WOOD, i),
                     {front.plant.wood_vertex_counts[i], front.plant.wood_triangle_counts[i], front.materials}, naive.wood[i]);
  ASSERT_EQ(naive.leaf_meshes.size(), front.leaf_meshes.size());
  for (std::uint32_t i = 0; i < front.leaf_meshes.size(); ++i)
    expect_same_mesh(chunk_bytes(file, front, COPPICE_CHUNK_LEAF_MESH, i),
                     {front.leaf_meshes[i].vertex_count, front.leaf_meshes[i].triangle_count, front.materials, true}, naive.leaf_meshes[i]);
}

void expect_same_textures(const Bytes& file, const PlantFile& front, const NaivePlant& naive) {
  ASSERT_EQ(naive.textures.size(), front.plant.texture_count);
  for (std::uint32_t t = 0; t < front.plant.texture_count; ++t) {
    const Bytes chunk = chunk_bytes(file, front, COPPICE_CHUNK_TEXTURE, t);
    const auto layout = test::must(read_texture(chunk));
    const test::NaiveTexture& other = naive.textures[t];
    EXPECT_EQ(layout.format, other.format);
    ASSERT_EQ(layout.levels().size(), other.mip_count);
    EXPECT_EQ(layout.levels()[0].width, other.width);
    EXPECT_EQ(layout.levels()[0].height, other.height);
    const auto& last = layout.levels().back();
    EXPECT_EQ(last.offset + last.bytes - layout.levels()[0].offset, other.levels.size());
    EXPECT_TRUE(
        std::equal(other.levels.begin(), other.levels.end(), chunk.begin() + static_cast<std::ptrdiff_t>(layout.levels()[0].offset)));
    const HookBuffer& small = front.small_textures[t];
    const test::NaiveTexture& other_small = naive.small_textures[t];
    ASSERT_EQ(small.empty(), other_small.levels.empty());
    EXPECT_TRUE(small.empty() || std::ranges::equal(small.span().subspan(sizeof(coppice_file_texture)), other_small.levels));
  }
}

/// Both take it or both refuse it. Returns whether they take it.
bool expect_agreement(const std::string& name, const Bytes& file) {
  const auto product = bake::unpack(file);
  const test::NaiveReading naive = test::read_naively(file);
  EXPECT_EQ(bool(product), naive.refusal.empty()) << name << "\nproduct: " << (product ? "takes it" : product.error().message())
                                                  << "\nnaive reader: " << (naive.refusal.empty() ? "takes it" : naive.refusal);
  return product && naive.refusal.empty();
}

void expect_same(const std::string& name, const Bytes& file) {
  SCOPED_TRACE(name);
  if (!expect_agreement(name, file)) return;
  const NaivePlant naive = test::read_naively(file).plant;
  const auto front = test::must(read_front(file, file.size()));
  expect_same_front(front, naive);
  expect_same_wind(wind_field(front), naive.wind_field);
  expect_same_materials(front, naive);
  expect_same_tree(file, front, naive);
  expect_same_meshes(file, front, naive);
  expect_same_textures(file, front, naive);
}

/// Flips a bit, sets a byte, or swaps in another of the file's, at a place in each short stretch of bytes.
void expect_agreement_on_mutants(const NamedFile& file, std::uint32_t seed) {
  const std::size_t stride = file.bytes.size() > 5000 ? 40 : 3;
  std::minstd_rand random(seed);
  std::uint32_t taken = 0, count = 0;
  for (std::size_t first = 0; first < file.bytes.size(); first += stride) {
    const std::size_t at = std::min(first + random() % stride, file.bytes.size() - 1);
    Bytes mutant = file.bytes;
    constexpr std::array<std::uint8_t, 6> kValues = {0, 1, 0x3f, 0x7f, 0x80, 0xff};
    const auto kind = random() % 4;
    if (kind == 0)
      mutant[at] = kValues[random() % kValues.size()];
    else if (kind == 1)
      mutant[at] = mutant[random() % mutant.size()];
    else
      mutant[at] = static_cast<std::uint8_t>(mutant[at] ^ 1u << random() % 8);
    const bool repaired = random() % 8 != 0;
    if (repaired) test::fix_checksums(mutant);
    const std::string name =
        file.name + ", byte " + std::to_string(at) + " is " + std::to_string(mutant[at]) + (repaired ? ", repaired" : "");
    if (repaired && random() % 8 == 0)
      expect_same(name, mutant);
    else
      taken += expect_agreement(name, mutant) ? 1u : 0u;
    ++count;
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(count, 20u);
  EXPECT_GT(taken, 0u) << "no mutant gets past the checks";
}

TEST(NaiveReader, ReadsTheSameFromEveryTestFile) {
  const std::vector<NamedFile> files = files_below(test::kTestData);
  EXPECT_GT(files.size(), 80u);
  for (const NamedFile& file : files) expect_same(file.name, file.bytes);
}

TEST(NaiveReader, ReadsTheSameFromNewFiles) {
  for (const NamedFile& file : made_files()) expect_same(file.name, file.bytes);
}

TEST(NaiveReader, RefusesTheSameTruncations) {
  for (const NamedFile& file : made_files()) {
    const std::size_t step = file.bytes.size() / 50 + 1;
    for (std::size_t bytes = 0; bytes < file.bytes.size(); bytes += step)
      EXPECT_FALSE(expect_agreement(file.name, Bytes(file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(bytes))));
  }
}

TEST(NaiveReader, AgreesOnMutants) {
  for (const NamedFile& file : made_files()) expect_agreement_on_mutants(file, 1);
  for (const NamedFile& file : files_below(std::filesystem::path(test::kTestData) / "plants")) expect_agreement_on_mutants(file, 2);
}

}  // namespace coppice::naive_reader_test
