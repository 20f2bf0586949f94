// The tool as a service runs it on what strangers send: limits, files outside the folder, patterns.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gltf_builder.h"
#include "mentions.h"
#include "places.h"
#include "process.h"

namespace coppice::test {
namespace untrusted_cli_test {

namespace fs = std::filesystem;

/// names: files, fields, options and limits
void expect_refused(const ProcessResult& result, const std::vector<std::string>& names) {
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_EQ(result.signal, 0);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err.rfind("coppice: ", 0), 0u) << result.err;
  EXPECT_EQ(result.err.rfind("\ncoppice: "), std::string::npos) << "one fault, told twice: " << result.err;
  const std::string err = unwrapped(result.err);
  for (const std::string& name : names) EXPECT_TRUE(mentions(err, {name}));
}

/// A plant of thousands of leaves, whose bake takes over a second and over 30 MB.
struct Grown {
  TemporaryFolder folder;
  fs::path plant = folder / "willow.glb", out = folder / "out";

  Grown() {
    const ProcessResult grown = run_process(test::kTool, {"plant", "willow", "-o", plant});
    EXPECT_EQ(grown.exit_code, 0) << grown.err;
    fs::create_directories(out);
  }
};

TEST(Limits, MemoryThatDoesNotSuffice) {
  const Grown grown;
  for (const char* megabytes : {"1", "8", "16", "30"}) {
    expect_refused(run_process(test::kTool, {"bake", grown.plant, "-o", grown.out / "willow.coppice", "--max-memory-mb", megabytes}),
                   {"willow.glb", "memory", megabytes, "--max-memory-mb"});
    EXPECT_TRUE(fs::is_empty(grown.out)) << megabytes;
  }
  expect_refused(run_process(test::kTool, {"evaluate", grown.plant, "--json", grown.out / "w.json", "--max-memory-mb", "16"}),
                 {"willow.glb", "16", "--max-memory-mb"});
  EXPECT_TRUE(fs::is_empty(grown.out));
}

TEST(Limits, TimeThatDoesNotSuffice) {
  const Grown grown;
  const auto start = std::chrono::steady_clock::now();
  expect_refused(run_process(test::kTool, {"bake", grown.plant, "-o", grown.out / "willow.coppice", "--max-seconds", "0.2"}),
                 {"willow.glb", "0.2", "--max-seconds"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  EXPECT_TRUE(fs::is_empty(grown.out));
}

TEST(Limits, OfEachPlantOfABatch) {
  const Grown grown;
  write_file(grown.folder / "small.glb", small_plant().glb());
  std::ofstream(grown.folder / "list.json") << R"([{"input": "small.glb", "views": 2, "resolution": 16},
                                                   {"input": "willow.glb", "views": 400, "resolution": 1024}])";
  const std::vector<std::string> batch{"bake-all", grown.folder / "list.json", "-o", grown.out, "--quiet"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = batch;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_process(test::kTool, arguments);
  };
  expect_refused(with({"--max-seconds", "8"}), {"willow.glb", "8", "--max-seconds"});
  EXPECT_TRUE(fs::exists(grown.out / "small.coppice")) << "the others are baked";
  EXPECT_FALSE(fs::exists(grown.out / "willow.coppice"));
  expect_refused(with({"--max-memory-mb", "30"}), {"willow.glb", "30", "--max-memory-mb"});
  for (const auto& entry : fs::recursive_directory_iterator(grown.out)) EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
}

TEST(Limits, ThatSufficeChangeNothing) {
  const TemporaryFolder folder;
  const fs::path plant = write_file(folder / "small.glb", small_plant().glb());
  const auto bake = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.begin(), {"bake", plant, "-o", (folder.path() / name).string(), "--views", "2", "--resolution", "16"});
    const ProcessResult result = run_process(test::kTool, more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(mentions(result.out, {"1"}));
    std::ifstream file(folder.path() / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string plain = bake("plain.coppice", {});
  EXPECT_FALSE(plain.empty());
  EXPECT_EQ(bake("limited.coppice", {"--max-memory-mb", "2000", "--max-seconds", "600"}), plain);
  EXPECT_EQ(run_process(test::kTool, {"bake", plant, "-o", folder / "x.coppice", "--max-seconds", "0"}).exit_code, 2);
  EXPECT_EQ(run_process(test::kTool, {"bake", plant, "-o", folder / "x.coppice", "--max-memory-mb", "-1"}).exit_code, 2);
}

TEST(OutsideFiles, EveryCommandRefusesAndMayAllowThem) {
  const TemporaryFolder folder;
  const fs::path inner = folder / "inner", out = folder / "out";
  fs::create_directories(inner);
  fs::create_directories(out);
  const GltfBuilder builder = small_plant();
  write_file(folder / "plant.bin", builder.bin);
  const fs::path plant = write_file(inner / "plant.gltf", builder.gltf_beside("../plant.bin"));
  const std::vector<std::vector<std::string>> commands{
      {"bake", plant, "-o", out / "plant.coppice", "--views", "2", "--resolution", "16"},
      {"bake", plant, "--dry-run"},
      {"bake-all", inner, "-o", out / "all", "--quiet", "--views", "2", "--resolution", "16"},
      {"evaluate", plant, "--methods", "geometric", "--levels", "1", "--size", "16"},
  };
  for (std::vector<std::string> command : commands) {
    expect_refused(run_process(test::kTool, command), {"plant.gltf", "buffers[0].uri: ../plant.bin", "--allow-outside"});
    command.emplace_back("--allow-outside");
    const ProcessResult allowed = run_process(test::kTool, command);
    EXPECT_EQ(allowed.exit_code, 0) << command[0] << ": " << allowed.err;
  }
  EXPECT_TRUE(fs::exists(out / "all" / "plant.coppice"));

  // One plant of a list by itself.
  const auto list = [&](const char* value) {
    std::ofstream(folder / "list.json") << R"([{"input": "inner/plant.gltf", "allow_outside": )" << value << "}]";
    return run_process(test::kTool,
                       {"bake-all", folder / "list.json", "-o", out / "list", "--quiet", "--views", "2", "--resolution", "16"});
  };
  expect_refused(list("false"), {"plant.gltf", "buffers[0].uri: ../plant.bin", "--allow-outside"});
  EXPECT_EQ(list("true").exit_code, 0);
  EXPECT_TRUE(fs::exists(out / "list" / "inner" / "plant.coppice"));
}

TEST(OutsideFiles, ASceneKeepsItsPlantsInItsFolder) {
  const TemporaryFolder folder;
  const fs::path plant = write_file(folder / "oak.glb", small_plant().glb()), scenes = folder / "scenes";
  fs::create_directories(scenes);
  ASSERT_EQ(run_process(test::kTool, {"bake", plant, "-o", folder / "oak.coppice", "--views", "2", "--resolution", "16"}).exit_code, 0);
  const std::vector<std::string> command{
      "scene", "-o", scenes / "wood.forest", "--plants", folder / "oak.coppice", "--count", "10", "--size-m", "100", "--spacing", "0"};
  expect_refused(run_process(test::kTool, command), {"../oak.coppice", "--allow-outside"});
  EXPECT_TRUE(fs::is_empty(scenes));
  std::vector<std::string> allowing = command;
  allowing.emplace_back("--allow-outside");
  const ProcessResult allowed = run_process(test::kTool, allowing);
  EXPECT_EQ(allowed.exit_code, 0) << allowed.err;
  EXPECT_EQ(std::ranges::count(allowed.err, '\n'), 1) << allowed.err;
  EXPECT_TRUE(mentions(allowed.err, {"wood.forest", "1"}));
  // By what it is, not by its name.
  fs::create_symlink("../oak.coppice", scenes / "oak.coppice");
  std::vector<std::string> linked = command;
  linked[4] = (scenes / "oak.coppice").string();
  expect_refused(run_process(test::kTool, linked), {"../oak.coppice", "--allow-outside"});
}

TEST(Patterns, OfManyBracketsAreAnError) {
  const TemporaryFolder folder;
  const fs::path plant = write_file(folder / "small.glb", small_plant().glb());
  const std::string brackets(20000, '(');
  const auto bake = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"bake", plant, "-o", folder / "out.coppice"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_process(test::kTool, arguments);
  };
  expect_refused(bake({"--leaf-material", brackets}), {"--leaf-material", "missing )"});
  expect_refused(bake({"--wood-material", brackets}), {"--wood-material", "missing )"});
  std::ofstream(folder / "classes.json") << R"({"classes": [{"material": ")" << brackets << R"(", "class": "leaf"}]})";
  expect_refused(bake({"--classes", folder / "classes.json"}), {"classes.json", "classes[0]", "missing )"});
  std::ofstream(folder / "list.json") << R"([{"input": "small.glb", "leaf_material": ")" << brackets << R"("}])";
  expect_refused(run_process(test::kTool, {"bake-all", folder / "list.json", "-o", folder / "all", "--quiet"}),
                 {"small.glb", "--leaf-material", "missing )"});
}

}  // namespace untrusted_cli_test
}  // namespace coppice::test
