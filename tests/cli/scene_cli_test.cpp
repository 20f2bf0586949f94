// `coppice scene` from outside: what it writes, what it says, exit codes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "gltf_builder.h"
#include "golden.h"
#include "pack.h"
#include "random_tree.h"
#include "results.h"
#include "scene_reader.h"
#include "tool.h"

namespace coppice::test::scene_cli_test {

namespace fs = std::filesystem;

ProcessResult scene(const Words& arguments) {
  return run_tool(joined({"scene"}, arguments));
}

void write_plant(const fs::path& path, std::uint32_t leaf_count) {
  bake::PackSizes sizes;
  fs::create_directories(path.parent_path());
  ASSERT_TRUE(bake::write_file_atomically(path, *bake::pack(random_plant({.leaf_count = leaf_count}), sizes)));
}

struct Read {
  SceneFile file;
  std::vector<SceneInstance> instances;
};

Read read_scene(const fs::path& path) {
  const auto bytes = must(bake::read_file(path));
  Read read{must(read_scene_front(bytes, bytes.size())), {}};
  for (const SceneTile& tile : read.file.tiles) {
    std::vector<SceneInstance> instances(tile.entry.instance_count);
    EXPECT_TRUE(read_scene_tile(read.file, tile, std::span(bytes).subspan(static_cast<std::size_t>(tile.offset), tile.bytes), instances));
    read.instances.insert(read.instances.end(), instances.begin(), instances.end());
  }
  return read;
}

/// A folder with two plants.
struct Plants {
  TemporaryFolder folder;
  fs::path baked = folder / "baked", oak = baked / "Oak.coppice", fern = baked / "fern.coppice", out = folder / "wood.forest";

  Plants() {
    write_plant(oak, 40);
    write_plant(fern, 20);
  }
};

TEST(SceneCommand, ScattersPlantsOfAFolder) {
  const Plants plants;
  const ProcessResult result = scene({"-o", plants.out, "--plants", plants.baked, "--size-m", "500", "--count", "9000", "--seed", "4"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"wood.forest", "9000"}));
  const Read read = read_scene(plants.out);
  EXPECT_EQ(read.instances.size(), 9000u);
  ASSERT_EQ(read.file.species.size(), 2u);
  EXPECT_EQ(read.file.species[0].path, "baked/Oak.coppice");
  EXPECT_EQ(read.file.species[1].path, "baked/fern.coppice");
  const auto first = bake::read_file(plants.out);
  ASSERT_EQ(scene({"-o", plants.out, "--plants", plants.baked, "--size-m", "500", "--count", "9000", "--seed", "4", "--quiet"}).out, "");
  EXPECT_EQ(*first, *bake::read_file(plants.out)) << "the same again";
}

TEST(SceneCommand, InspectShowsWhatAForestHolds) {
  const Plants plants;
  ASSERT_EQ(scene({"-o", plants.out, "--plants", plants.baked, "--size-m", "500", "--count", "900"}).exit_code, 0);
  const ProcessResult text = run_tool({"inspect", plants.out});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_TRUE(mentions(text.out, {"wood.forest", "900", "2", "1", "baked/Oak.coppice", "baked/fern.coppice"}));
  const ProcessResult json = run_tool({"inspect", plants.out, "--json"});
  const auto parsed = nlohmann::json::parse(json.out);
  EXPECT_EQ(parsed["plants"], 900);
  EXPECT_EQ(parsed["file_bytes"], fs::file_size(plants.out));
  EXPECT_EQ(parsed["species"].size(), 2u);
  const auto bytes = bake::read_file(plants.out);
  write_file(plants.out, std::span(*bytes).first(40));
  expect_one_line_error(run_tool({"inspect", plants.out}), {"wood.forest"});
}

TEST(SceneCommand, ADensityMapSaysWhereAPlantGrows) {
  const Plants plants;
  const fs::path map = plants.folder / "fern.png";
  Picture picture;
  picture.width_px = 4;
  picture.height_px = 1;
  picture.rgba = {0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255};
  write_png(map, picture);
  const ProcessResult result = scene({"-o", plants.out, "--plants", plants.oak.string() + "," + plants.fern.string(), "--size-m", "400",
                                      "--count", "500", "--spacing", "0", "--density", "fern=" + map.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Read read = read_scene(plants.out);
  ASSERT_EQ(read.file.species.size(), 1u) << "what has no map stays out";
  EXPECT_EQ(read.file.species[0].path, "baked/fern.coppice");
  for (const SceneInstance& instance : read.instances) EXPECT_GE(instance.position_m[0], 99.9f);
}

/// A triangle, for levels whose plants are known by their names.
int add_triangle(GltfBuilder& builder) {
  return builder.add_mesh({{"POSITION", builder.add_positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})}}, {}, builder.add_material("any"));
}

/// The scene that a level gives, and what is said of it.
std::pair<Read, std::string> scene_of(const GltfBuilder& level, const Plants& plants) {
  const ProcessResult result = scene({write_file(plants.folder / "level.glb", level.glb()), "-o", plants.out, "--plants", plants.baked});
  if (result.exit_code != 0) throw std::runtime_error(result.err);
  return {read_scene(plants.out), result.err};
}

/// A level: three instances of a mesh, one plain node, and ground.
GltfBuilder level() {
  GltfBuilder builder;
  const int mesh = add_triangle(builder);
  const int instanced = builder.add_node(mesh, {{"name", "OAK.012"}, {"translation", {100, 0, 0}}});
  const int places = builder.add_positions({{0, 0, 0}, {10, 5, 0}, {0, 0, -20}});
  const int scales = builder.add_positions({{1, 1, 1}, {-2, 2, 2}, {1, 1, 1}});
  builder.node(instanced)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", places}, {"SCALE", scales}};
  builder.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  const float half = std::sqrt(0.5f);
  builder.add_node(mesh, {{"name", "fern_LOD0"}, {"translation", {1, 2, 3}}, {"rotation", {0, half, 0, half}}});
  builder.add_node(mesh, {{"name", "ground"}});
  return builder;
}

TEST(SceneCommand, TakesPlantsFromAGltfByName) {
  const Plants plants;
  auto [read, told] = scene_of(level(), plants);
  EXPECT_TRUE(mentions(told, {"level.glb", "1"}));
  ASSERT_EQ(read.instances.size(), 4u);
  std::ranges::sort(read.instances, {}, [](const SceneInstance& instance) { return instance.position_m[0]; });
  const SceneInstance& fern = read.instances[0];
  EXPECT_EQ(read.file.species[fern.species].path, "baked/fern.coppice");
  EXPECT_NEAR(fern.position_m[1], 2.0f, 1e-2f);
  EXPECT_NEAR(fern.yaw_rad, 1.5708f, 0.02f);
  const SceneInstance& large = read.instances[3];
  EXPECT_EQ(read.file.species[large.species].path, "baked/Oak.coppice");
  EXPECT_NEAR(large.position_m[0], 110.0f, 1e-2f);
  EXPECT_NEAR(large.position_m[1], 5.0f, 1e-2f);
  EXPECT_NEAR(large.scale, 2.0f, 0.02f);
  EXPECT_TRUE(large.mirrored);
  EXPECT_EQ(large.yaw_rad, 0.0f);
  EXPECT_FALSE(fern.mirrored);
  EXPECT_EQ(large.tint, (std::array<float, 3>{1, 1, 1}));
}

TEST(SceneCommand, OfSeveralLevelsInOnePlaceTheFinestIsAPlant) {
  const Plants plants;
  GltfBuilder builder;
  const int mesh = add_triangle(builder);
  for (const int x : {0, 10, 20}) {
    const std::string copy = x == 0 ? "" : ".00" + std::to_string(x / 10);
    for (const char* name : {"oak_LOD0", "oak_LOD1", "Oak_LOD2", "oak_billboard", "UCX_oak"})
      builder.add_node(mesh, {{"name", name + copy}, {"translation", {x, 0, 0}}});
  }
  builder.add_node(mesh, {{"name", "oak_LOD2.009"}, {"translation", {50, 0, 0}}});
  const int fern = builder.add_node(mesh, {{"name", "fern"}, {"translation", {5, 0, 0}}});
  const int far = builder.add_node(mesh, {{"name", "fern.001"}, {"translation", {5, 0, 0}}});
  builder.node(fern)["extensions"]["MSFT_lod"]["ids"] = {far};
  const auto [read, told] = scene_of(builder, plants);
  EXPECT_EQ(read.instances.size(), 5u) << "three oaks, one that has a coarse level alone, a fern";
  EXPECT_TRUE(mentions(told, {"level.glb", "13"}));
}

/// Plants as editors copy them: groups of parts, and meshes below nodes of other names.
TEST(SceneCommand, APlantMayBeANodeWithParts) {
  const Plants plants;
  GltfBuilder builder;
  const int mesh = add_triangle(builder);
  const auto add = [&](const nlohmann::json& members, int parent) {
    builder.json["nodes"].push_back(members);
    const auto node = builder.json["nodes"].size() - 1;
    builder.node(parent)["children"].push_back(node);
    return static_cast<int>(node);
  };
  // A group that is called as its plants are.
  const int group = builder.add_node(-1, {{"name", "Oak"}});
  for (const char* name :
       {"oak", "oak.001", "Oak (1)", "oak(Clone)", "SM_Oak_12", "Oak (2)(Clone)", "BP_Oak_C_3", "Oak copy 2", "oak - Copy"}) {
    const float x = 10.0f * static_cast<float>(builder.json["nodes"].size());
    const int oak = add({{"name", name}, {"translation", {x, 0, 0}}}, group);
    for (const char* part : {"trunk", "leaves"}) add({{"name", part}, {"mesh", mesh}, {"translation", {0, 3, 0}}}, oak);
  }
  // Levels below a plant are parts of it; a plant below another is one of its own.
  const int fern = builder.add_node(-1, {{"name", "fern"}, {"translation", {0, 0, 50}}});
  add({{"name", "fern_LOD0"}, {"mesh", mesh}}, fern);
  add({{"name", "fern_LOD1"}, {"mesh", mesh}}, fern);
  add({{"name", "oak.007"}, {"mesh", mesh}, {"translation", {4, 0, 0}}}, fern);
  const int hidden = builder.add_node(mesh, {{"name", "fern.003"}});
  builder.node(hidden)["extensions"]["KHR_node_visibility"]["visible"] = false;
  builder.node(builder.add_node(mesh, {{"name", "oak.008"}}))["scale"] = {0, 0, 0};
  for (const char* name : {"Rock", "Rock", "Terrain"}) builder.add_node(mesh, {{"name", name}});
  const auto [read, told] = scene_of(builder, plants);
  std::array<int, 2> counts{};
  for (const SceneInstance& instance : read.instances) ++counts.at(instance.species);
  EXPECT_EQ(counts, (std::array{10, 1}));
  for (const SceneInstance& instance : read.instances) EXPECT_NEAR(instance.position_m[1], 0.0f, 1e-2f);
  EXPECT_TRUE(mentions(told, {"3", "Rock (2)", "Terrain", "fern.003"}));
}

/// Parts that are instanced alike, as tools make them of copies.
TEST(SceneCommand, InstancedPartsAreAPlantForEachInstance) {
  const Plants plants;
  GltfBuilder builder;
  const int mesh = add_triangle(builder);
  const int places = builder.add_positions({{0, 0, 0}, {10, 5, 0}, {0, 0, -20}});
  const auto add_oak = [&](int other_places) {
    const int oak = builder.add_node(-1, {{"name", "oak"}, {"translation", {100, 0, 0}}});
    for (const int part_places : {places, other_places}) {
      builder.json["nodes"].push_back({{"name", "part"},
                                       {"mesh", mesh},
                                       {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", part_places}}}}}}}});
      builder.node(oak)["children"].push_back(builder.json["nodes"].size() - 1);
    }
  };
  add_oak(places);
  EXPECT_EQ(scene_of(builder, plants).first.instances.size(), 3u);
  add_oak(builder.add_positions({{0, 2, 0}, {0, 3, 0}}));  // one whose leaves are instances
  EXPECT_EQ(scene_of(builder, plants).first.instances.size(), 4u);
}

TEST(SceneCommand, NamesWhatHasNoPlant) {
  const Plants plants;
  GltfBuilder builder = level();
  builder.json["nodes"][0]["name"] = "Beech";
  const fs::path input = write_file(plants.folder / "level.glb", builder.glb());
  expect_one_line_error(scene({input, "-o", plants.out, "--plants", plants.baked}), {"Beech", "3", "oak", "fern"});
  EXPECT_FALSE(fs::exists(plants.out));
  const ProcessResult skipped = scene({input, "-o", plants.out, "--plants", plants.baked, "--skip-missing"});
  EXPECT_EQ(skipped.exit_code, 0) << skipped.err;
  EXPECT_TRUE(mentions(skipped.err, {"level.glb", "3"}));
  EXPECT_EQ(read_scene(plants.out).instances.size(), 1u);
}

TEST(SceneCommand, OneClearErrorForABadInput) {
  const Plants plants;
  const std::string out = plants.out;
  const std::string baked = plants.baked;
  expect_one_line_error(scene({"-o", out, "--plants", plants.folder / "none.coppice"}), {"none.coppice"});
  const fs::path text = plants.folder / "text.coppice", empty = plants.folder / "empty";
  fs::create_directories(empty);
  write_text(text, "not a plant, but long enough to have a header of sixty-four bytes or more than that");
  expect_one_line_error(scene({"-o", out, "--plants", text}), {"text.coppice", "magic"});
  expect_one_line_error(scene({"-o", out, "--plants", empty}), {"empty", ".coppice"});
  expect_one_line_error(scene({"-o", out, "--plants", baked, "--density", "elm=x.png"}), {"--density", "oak", "fern", "elm"});
  expect_one_line_error(scene({"-o", out, "--plants", baked, "--density", "oak"}), {"--density", "NAME=MAP.png", "oak"});
  expect_one_line_error(scene({"-o", out, "--plants", baked, "--density", "oak=" + text.string()}), {"text.coppice"});
  expect_one_line_error(scene({"-o", out, "--plants", baked, "--density", "oak=missing.png"}), {"missing.png"});
  expect_one_line_error(scene({"-o", out, "--plants", baked, "--size-m", "2", "--count", "100000", "--spacing", "2"}),
                        {"100000", "oak", "fern", "2"});
  expect_one_line_error(scene({plants.folder / "missing.glb", "-o", out, "--plants", baked}), {"missing.glb"});
  expect_one_line_error(scene({"-o", plants.folder / "no" / "where.forest", "--plants", baked}), {"Oak.coppice", "--allow-outside"});
  EXPECT_EQ(scene({"-o", out}).exit_code, 2);
  EXPECT_EQ(scene({"x.glb", "-o", out, "--plants", baked, "--count", "5"}).exit_code, 2) << "scattering needs no input";
}

}  // namespace coppice::test::scene_cli_test
