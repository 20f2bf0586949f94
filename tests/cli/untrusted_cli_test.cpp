// The tool as a service runs it on what strangers send: limits, files outside the folder.

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gltf_builder.h"
#include "tool.h"

namespace coppice::test::untrusted_cli_test {

namespace fs = std::filesystem;

/// names: files, fields, options and limits
void expect_refused(const Words& arguments, const Words& names) {
  const ProcessResult result = run_tool(arguments);
  expect_error(result, names);
  EXPECT_EQ(result.out, "");
}

/// A quick bake of one plant or all.
Words quick(Words arguments) {
  return joined(std::move(arguments), {"--views", "2", "--resolution", "16"});
}

/// A plant of thousands of leaves, whose bake takes over a second and over 30 MB.
struct Grown {
  TemporaryFolder folder;
  fs::path plant = folder / "willow.glb", out = folder / "out";

  Grown() {
    const ProcessResult grown = run_tool({"plant", "willow", "-o", plant});
    EXPECT_EQ(grown.exit_code, 0) << grown.err;
    fs::create_directories(out);
  }
};

TEST(Limits, MemoryThatDoesNotSuffice) {
  const Grown grown;
  for (const char* megabytes : {"1", "8", "16", "30"}) {
    expect_refused({"bake", grown.plant, "-o", grown.out / "willow.coppice", "--max-memory-mb", megabytes},
                   {"willow.glb", "memory", megabytes, "--max-memory-mb"});
    EXPECT_TRUE(fs::is_empty(grown.out)) << megabytes;
  }
  expect_refused({"evaluate", grown.plant, "--json", grown.out / "w.json", "--max-memory-mb", "16"},
                 {"willow.glb", "16", "--max-memory-mb"});
  EXPECT_TRUE(fs::is_empty(grown.out));
}

TEST(Limits, TimeThatDoesNotSuffice) {
  const Grown grown;
  const auto start = std::chrono::steady_clock::now();
  expect_refused({"bake", grown.plant, "-o", grown.out / "willow.coppice", "--max-seconds", "0.2"}, {"willow.glb", "0.2", "--max-seconds"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  EXPECT_TRUE(fs::is_empty(grown.out));
}

TEST(Limits, OfEachPlantOfABatch) {
  const Grown grown;
  write_file(grown.folder / "small.glb", small_plant().glb());
  write_text(grown.folder / "list.json", R"([{"input": "small.glb", "views": 2, "resolution": 16},
                                             {"input": "willow.glb", "views": 400, "resolution": 1024}])");
  const Words batch{"bake-all", grown.folder / "list.json", "-o", grown.out, "--quiet"};
  expect_refused(joined(batch, {"--max-seconds", "8"}), {"willow.glb", "8", "--max-seconds"});
  EXPECT_TRUE(fs::exists(grown.out / "small.coppice")) << "the others are baked";
  EXPECT_FALSE(fs::exists(grown.out / "willow.coppice"));
  expect_refused(joined(batch, {"--max-memory-mb", "30"}), {"willow.glb", "30", "--max-memory-mb"});
  for (const auto& entry : fs::recursive_directory_iterator(grown.out)) EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
}

TEST(Limits, ThatSufficeChangeNothing) {
  const TemporaryFolder folder;
  const fs::path plant = write_file(folder / "small.glb", small_plant().glb());
  const auto bake = [&](const char* name, const Words& more) {
    const ProcessResult result = run_tool(joined(quick({"bake", plant, "-o", folder / name}), more));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(mentions(result.out, {"1"}));
    return read_text(folder / name);
  };
  const std::string plain = bake("plain.coppice", {});
  EXPECT_FALSE(plain.empty());
  EXPECT_EQ(bake("limited.coppice", {"--max-memory-mb", "2000", "--max-seconds", "600"}), plain);
  for (const Words& wrong : {Words{"--max-seconds", "0"}, {"--max-memory-mb", "-1"}})
    EXPECT_EQ(run_tool(joined({"bake", plant, "-o", folder / "x.coppice"}, wrong)).exit_code, 2);
}

TEST(SourceTriangles, EveryCommandRefusesTooManyAndMayRaiseTheLimit) {
  const TemporaryFolder folder;
  GltfBuilder builder = small_plant();
  builder.node(0)["name"] = "plant";
  fs::create_directories(folder / "plants");
  const fs::path plant = write_file(folder / "plants" / "plant.glb", builder.glb()), out = folder / "out";
  for (const Words& command : {quick({"bake", plant, "-o", out / "plant.coppice"}),
                               {"bake", plant, "--dry-run"},
                               quick({"bake-all", folder / "plants", "-o", out, "--quiet"}),
                               {"evaluate", plant, "--methods", "geometric", "--levels", "1", "--size", "16"},
                               {"scene", plant, "-o", out / "w.forest", "--plants", out / "plant.coppice"},
                               quick({"view", plant})}) {
    const bool counts_places = command[0] == "scene";
    expect_refused(joined(command, {"--max-source-triangles", counts_places ? "1" : "2"}),
                   {"plant.glb", "meshes[0]", counts_places ? "2" : "3", "--max-source-triangles"});
    if (command[0] == "view") continue;  // it would show the plant
    const ProcessResult allowed = run_tool(joined(command, {"--max-source-triangles", counts_places ? "2" : "3"}));
    EXPECT_EQ(allowed.exit_code, 0) << command[0] << ": " << allowed.err;
  }
}

TEST(OutsideFiles, EveryCommandRefusesAndMayAllowThem) {
  const TemporaryFolder folder;
  const fs::path inner = folder / "inner", out = folder / "out";
  fs::create_directories(inner);
  fs::create_directories(out);
  const GltfBuilder builder = small_plant();
  write_file(folder / "plant.bin", builder.bin);
  const fs::path plant = write_file(inner / "plant.gltf", builder.gltf_beside("../plant.bin"));
  for (const Words& command : {quick({"bake", plant, "-o", out / "plant.coppice"}),
                               {"bake", plant, "--dry-run"},
                               quick({"bake-all", inner, "-o", out / "all", "--quiet"}),
                               {"evaluate", plant, "--methods", "geometric", "--levels", "1", "--size", "16"}}) {
    expect_refused(command, {"plant.gltf", "buffers[0].uri: ../plant.bin", "--allow-outside"});
    const ProcessResult allowed = run_tool(joined(command, {"--allow-outside"}));
    EXPECT_EQ(allowed.exit_code, 0) << command[0] << ": " << allowed.err;
  }
  EXPECT_TRUE(fs::exists(out / "all" / "plant.coppice"));

  // A list allows it for one plant by itself.
  const Words batch = quick({"bake-all", folder / "list.json", "-o", out / "list", "--quiet"});
  write_text(folder / "list.json", R"([{"input": "inner/plant.gltf", "allow_outside": false}])");
  expect_refused(batch, {"plant.gltf", "buffers[0].uri: ../plant.bin", "--allow-outside"});
  write_text(folder / "list.json", R"([{"input": "inner/plant.gltf", "allow_outside": true}])");
  EXPECT_EQ(run_tool(batch).exit_code, 0);
  EXPECT_TRUE(fs::exists(out / "list" / "inner" / "plant.coppice"));
}

TEST(OutsideFiles, ASceneKeepsItsPlantsInItsFolder) {
  const TemporaryFolder folder;
  const fs::path plant = write_file(folder / "oak.glb", small_plant().glb()), scenes = folder / "scenes";
  fs::create_directories(scenes);
  ASSERT_EQ(run_tool(quick({"bake", plant, "-o", folder / "oak.coppice"})).exit_code, 0);
  const Words command{"scene",     "-o", scenes / "wood.forest", "--plants", folder / "oak.coppice", "--count", "10", "--size-m", "100",
                      "--spacing", "0"};
  expect_refused(command, {"../oak.coppice", "--allow-outside"});
  EXPECT_TRUE(fs::is_empty(scenes));
  const ProcessResult allowed = run_tool(joined(command, {"--allow-outside"}));
  EXPECT_EQ(allowed.exit_code, 0) << allowed.err;
  EXPECT_EQ(count_of(allowed.err, "\n"), 1u) << allowed.err;
  EXPECT_TRUE(mentions(allowed.err, {"wood.forest", "1"}));
  // By what it is, not by its name.
  fs::create_symlink("../oak.coppice", scenes / "oak.coppice");
  Words linked = command;
  linked[4] = (scenes / "oak.coppice").string();
  expect_refused(linked, {"../oak.coppice", "--allow-outside"});
}

}  // namespace coppice::test::untrusted_cli_test
