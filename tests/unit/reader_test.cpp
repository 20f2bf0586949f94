#include "reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "atomic_file.h"
#include "coppice_file.h"
#include "gltf_builder.h"
#include "layout.h"
#include "packed_plant.h"
#include "places.h"
#include "results.h"
#include "unpack.h"

namespace coppice::reader_test {

using test::Bytes;

const std::filesystem::path kData = test::kTestData;

bool updating() {
  return std::getenv("COPPICE_UPDATE_GOLDEN") != nullptr;
}

/// Small enough to try every byte of.
Bytes small_file() {
  return test::packed_plant({.leaf_count = 6, .texture_side = 4});
}

/// The same with leaf meshes.
Bytes small_file_with_meshes() {
  return test::packed_plant({.leaf_count = 6, .texture_side = 4, .leaf_mesh_count = 2});
}

/// A copy in a heap block of exactly its size, so that a sanitizer sees a read past the end.
Result<bake::BakedPlant> unpack_exact(const Bytes& bytes) {
  const auto block = std::make_unique<std::uint8_t[]>(bytes.size());
  std::ranges::copy(bytes, block.get());
  return bake::unpack(std::span(block.get(), bytes.size()));
}

struct Expected {
  std::string name, reason;
  std::uint64_t value = 0;
};

/// Lines of "name|reason|value".
std::vector<Expected> read_expected(const std::filesystem::path& path) {
  std::vector<Expected> result;
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream fields(line);
    Expected expected;
    std::string value;
    std::getline(fields, expected.name, '|');
    std::getline(fields, expected.reason, '|');
    std::getline(fields, value);
    expected.value = std::stoull(value);
    result.push_back(expected);
  }
  return result;
}

std::set<std::string> files_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".coppice") names.insert(entry.path().stem());
  return names;
}

TEST(BadFiles, EachIsRefusedForItsReasonAtItsPlace) {
  auto generated = test::bad_files(small_file());
  for (test::BadFile& bad : test::bad_leaf_mesh_files(small_file_with_meshes())) generated.push_back(std::move(bad));
  if (updating()) {
    std::filesystem::create_directories(kData / "bad");
    for (const std::string& name : files_in(kData / "bad")) std::filesystem::remove(kData / "bad" / (name + ".coppice"));
    std::ofstream expected(kData / "bad" / "expected.txt");
    for (const test::BadFile& bad : generated) {
      test::write_file(kData / "bad" / (bad.name + ".coppice"), bad.bytes);
      expected << bad.name << '|' << bad.reason << '|' << bad.offset << '\n';
    }
  }
  const auto expected = read_expected(kData / "bad" / "expected.txt");
  std::set<std::string> listed;
  for (const Expected& bad : expected) {
    listed.insert(bad.name);
    const auto plant = unpack_exact(*bake::read_file(kData / "bad" / (bad.name + ".coppice")));
    ASSERT_FALSE(plant) << bad.name;
    EXPECT_EQ(plant.error().what, bad.reason) << bad.name << ": " << plant.error().message();
    EXPECT_EQ(plant.error().offset, bad.value) << bad.name << ": " << plant.error().message();
    EXPECT_EQ(plant.error().status, Status::bad_file) << bad.name;
  }
  EXPECT_EQ(listed, files_in(kData / "bad"));
  for (const test::BadFile& bad : generated) EXPECT_TRUE(listed.contains(bad.name)) << bad.name << " is not in expected.txt";
}

/// Everything a reader makes of a file, as one number: what a build has once made of a version's files, every build makes of them.
std::uint64_t digest(const bake::BakedPlant& plant) {
  Bytes bytes;
  const auto add = [&](const auto& values) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(values.data());
    bytes.insert(bytes.end(), first, first + values.size() * sizeof(values[0]));
  };
  add(plant.name);
  add(plant.tree.vertices);
  add(plant.tree.split_parent);
  for (const bake::Tree::Node& node : plant.tree.nodes) {
    add(node.vertices);
    add(std::vector{node.card});
    add(std::vector{node.opacity});
    add(std::vector{node.normals});
  }
  for (const bake::Card& card : plant.card_table) add(card.uv);
  add(plant.errors.leaf_counts);
  add(plant.errors.error_px);
  for (const bake::Mesh& lod : plant.wood.lods) {
    add(lod.positions);
    add(lod.uvs);
    add(lod.indices);
    add(lod.triangle_materials);
  }
  for (const bake::Image& image : plant.images) add(image.rgba);
  for (const bake::LeafMeshPart& part : plant.leaf_meshes.parts) {
    add(part.mesh.positions);
    add(part.mesh.uvs);
    add(part.mesh.indices);
    add(part.mesh.triangle_materials);
    add(part.stalks);
  }
  add(plant.leaf_meshes.error_px);
  add(std::vector{plant.wind.head});
  add(plant.wind.nodes);
  return checksum(bytes);
}

TEST(GoldenFiles, TheyAreReadAsEver) {
  const std::filesystem::path folder = kData / "plants";
  const std::map<std::string, test::RandomPlantOptions> plants = {
      {"one_leaf", {.leaf_count = 1, .wood_lod_count = 0, .texture_side = 0}},
      {"two_pages", {.leaf_count = 520, .card_count = 3, .wood_lod_count = 1, .texture_side = 0}},
      {"wood_and_texture", {.leaf_count = 12, .wood_lod_count = 3, .texture_side = 8}},
      {"block_texture", {.leaf_count = 8, .wood_lod_count = 0, .texture_side = 10}},
      {"leaf_meshes", {.leaf_count = 9, .wood_lod_count = 1, .texture_side = 4, .leaf_mesh_count = 2}},
      {"smooth_looks", {.leaf_count = 70, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::smooth}},
      {"sided_looks", {.leaf_count = 70, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::sided}},
      {"noisy_looks", {.leaf_count = 70, .wood_lod_count = 0, .texture_side = 0, .looks = test::Looks::noise}},
  };
  if (updating()) {
    std::filesystem::create_directories(folder);
    std::ofstream listed(folder / "expected.txt");
    for (const auto& [name, options] : plants) {
      const std::filesystem::path path = folder / (name + ".coppice");
      if (!std::filesystem::exists(path)) test::write_file(path, test::packed_plant(options));  // what an earlier build wrote stays
      listed << name << "|digest|" << digest(*bake::unpack(*bake::read_file(path))) << '\n';
    }
  }
  const auto expected = read_expected(folder / "expected.txt");
  ASSERT_GE(expected.size(), plants.size());
  ASSERT_EQ(expected.size(), files_in(folder).size());
  for (const Expected& golden : expected)
    EXPECT_EQ(digest(*unpack_exact(*bake::read_file(folder / (golden.name + ".coppice")))), golden.value) << golden.name;
}

TEST(HostileFile, EveryTruncationIsRefused) {
  const Bytes file = small_file_with_meshes();
  ASSERT_TRUE(unpack_exact(file));
  for (std::size_t length = 0; length < file.size(); ++length) {
    const auto plant = unpack_exact(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length)));
    ASSERT_FALSE(plant) << length << " of " << file.size() << " bytes accepted";
    ASSERT_NE(plant.error().offset, Error::kNoOffset);
  }
}

TEST(HostileFile, ATransparentSourceLeafIsRefused) {
  Bytes file = test::packed_plant({.leaf_count = 1, .wood_lod_count = 0, .texture_side = 0});
  file[test::chunk_offset(file, COPPICE_CHUNK_PLANT) + offsetof(coppice_file_plant, root_opacity)] = 15;
  test::fix_checksums(file);
  EXPECT_STREQ(bake::unpack(file).error().what, "plant root_opacity");
}

TEST(HostileFile, AnExtraByteIsRefused) {
  Bytes file = small_file();
  file.push_back(0);
  ASSERT_FALSE(unpack_exact(file));
  // Also where the header counts it: chunks tile the file.
  const std::uint64_t file_bytes = file.size();
  std::memcpy(file.data() + offsetof(coppice_file_header, file_bytes), &file_bytes, sizeof file_bytes);
  test::fix_checksums(file);
  EXPECT_STREQ(unpack_exact(file).error().what, "chunk table");
}

TEST(HostileFile, EveryFlippedBitIsRefused) {
  const Bytes file = small_file_with_meshes();
  for (std::size_t at = 0; at < file.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = file;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ (1 << bit));
      const auto plant = unpack_exact(damaged);
      ASSERT_FALSE(plant) << "bit " << bit << " of byte " << at;
      ASSERT_NE(plant.error().offset, Error::kNoOffset);
      ASSERT_LE(plant.error().offset, file.size());
    }
}

/// Invariants of FORMAT.md that memory safety and the runtime rest on.
void expect_valid(const bake::BakedPlant& plant) {
  const std::uint32_t leaves = plant.tree.leaf_count();
  ASSERT_EQ(plant.tree.nodes.size(), 2 * leaves - 1);
  std::vector<bool> replaced(plant.tree.nodes.size());
  for (std::uint32_t split = 0; split + 1 < leaves; ++split) {
    ASSERT_LE(plant.tree.split_parent[split], 2 * split);
    ASSERT_FALSE(replaced[plant.tree.split_parent[split]]);
    replaced[plant.tree.split_parent[split]] = true;
  }
  for (const bake::Tree::Node& node : plant.tree.nodes) ASSERT_LT(node.card, plant.card_table.size());
  for (const bake::Card& card : plant.card_table) ASSERT_LT(card.material, plant.materials.size());
  for (const bake::Mesh& lod : plant.wood.lods)
    for (std::uint32_t index : lod.indices) ASSERT_LT(index, lod.positions.size());
  for (const bake::LeafMeshPart& part : plant.leaf_meshes.parts) {
    ASSERT_EQ(part.stalks.size(), part.mesh.positions.size());
    for (std::uint32_t index : part.mesh.indices) ASSERT_LT(index, part.mesh.positions.size());
    for (std::uint32_t material : part.mesh.triangle_materials) ASSERT_LT(material, plant.materials.size());
  }
}

TEST(HostileFile, DamageBehindRightChecksumsGivesAnErrorOrAValidPlant) {
  const Bytes file = small_file_with_meshes();
  for (std::size_t at = 0; at < file.size(); ++at)
    for (int mask : {0x01, 0x10, 0x80, 0xff}) {
      Bytes damaged = file;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ mask);
      test::fix_checksums(damaged);
      if (const auto plant = unpack_exact(damaged)) expect_valid(*plant);
    }
}

TEST(Reader, TextIsNotAPlant) {
  const std::string text = "solid teapot\n";
  EXPECT_STREQ(unpack_exact(Bytes(text.begin(), text.end())).error().what, "magic");
}

TEST(Reader, FindsEveryChunkOfTheTableAndNoOther) {
  const Bytes file = test::packed_plant({.leaf_count = 1200, .wood_lod_count = 3, .leaf_mesh_count = 2});
  const auto front = test::must(read_front(file, file.size()));
  for (const coppice_file_chunk& chunk : front.chunks)
    EXPECT_EQ(find_chunk(front, static_cast<coppice_chunk_kind>(chunk.kind), chunk.index), &chunk)
        << chunk_kind_name(chunk.kind) << chunk.index;
  for (const auto& [kind, count] : {std::pair{COPPICE_CHUNK_PLANT, 1u},
                                    {COPPICE_CHUNK_WIND, 1u},
                                    {COPPICE_CHUNK_WOOD, 3u},
                                    {COPPICE_CHUNK_PAGE, 3u},
                                    {COPPICE_CHUNK_TEXTURE, 2u},
                                    {COPPICE_CHUNK_LEAF_MESH, 2u},
                                    {COPPICE_CHUNK_LEAF_MESHES, 1u}})
    EXPECT_EQ(find_chunk(front, kind, count), nullptr) << chunk_kind_name(kind);
}

TEST(Reader, CheckChunkLooksAtLengthAndBytes) {
  const Bytes file = small_file();
  const auto front = read_front(file, file.size());
  const coppice_file_chunk& page = *find_chunk(*front, COPPICE_CHUNK_PAGE, 0);
  const auto first = file.begin() + static_cast<std::ptrdiff_t>(page.offset);
  Bytes bytes(first, first + static_cast<std::ptrdiff_t>(page.bytes));
  EXPECT_TRUE(check_chunk(page, bytes));
  bytes.back() ^= 1;
  EXPECT_STREQ(check_chunk(page, bytes).error().what, "chunk checksum");
  EXPECT_EQ(check_chunk(page, bytes).error().offset, page.offset);
  bytes.pop_back();
  EXPECT_STREQ(check_chunk(page, bytes).error().what, "chunk length");
}

}  // namespace coppice::reader_test
