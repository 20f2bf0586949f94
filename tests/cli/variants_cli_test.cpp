// Packs and sizes from outside: --variant, --node and --unit of bake and bake-all, and what is said of them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "pack_gltf.h"
#include "process.h"

namespace coppice::test {
namespace {

namespace fs = std::filesystem;

ProcessResult coppice_tool(std::vector<std::string> arguments) {
  if (arguments.front() != "inspect") arguments.insert(arguments.end(), {"--views", "2", "--resolution", "16"});
  return run_process(COPPICE_TOOL, arguments);
}

/// Three oaks in a row, the first with a coarser level.
Pack oaks() {
  Pack pack;
  for (int i = 0; i < 3; ++i)
    pack.part("Oak_" + std::to_string(i + 1), tree(30 + i, 5, static_cast<std::uint64_t>(i)), {6.0f * static_cast<float>(i), 0, 0});
  pack.part("Oak_1_LOD1", tree(10, 5, 9));
  return pack;
}

struct Folder {
  TemporaryFolder folder;
  fs::path input = write_file(folder / "oak.glb", oaks().file.glb());

  [[nodiscard]] std::set<std::string> baked(const char* below) const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder / below))
      if (entry.path().extension() == ".coppice") names.insert(entry.path().filename().string());
    return names;
  }
};

void expect_says(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(Variants, TheFirstIsBakedAndALineSaysSo) {
  const Folder folder;
  const ProcessResult result = coppice_tool({"bake", folder.input, "-o", folder.folder / "one.coppice"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_says(result.out, "30 leaves, ");
  expect_says(result.out, " m high, ");
  expect_says(result.err, "3 variants: 'Oak_1' is taken, not 'Oak_2', 'Oak_3' (--variant N or all); left out: coarser level 'Oak_1_LOD1'");
  const ProcessResult looked = coppice_tool({"bake", folder.input, "--dry-run"});
  for (const char* says : {"variant 1, taken", "variant 3", "Oak_1_LOD1", "coarser level", " m high, "}) expect_says(looked.out, says);
}

TEST(Variants, AllAreBakedIntoFilesOfTheirOwn) {
  const Folder folder;
  const ProcessResult result = coppice_tool({"bake", folder.input, "-o", folder.folder / "oak.coppice", "--variant", "all"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.baked("."), (std::set<std::string>{"oak_1.coppice", "oak_2.coppice", "oak_3.coppice"}));
  expect_says(coppice_tool({"inspect", folder.folder / "oak_3.coppice"}).out, "32 leaves");
  EXPECT_EQ(coppice_tool({"bake", folder.input, "-o", "-", "--variant", "all"}).exit_code, 1);
  for (const char* wrong : {"0", "-1", "two", "2x", ""})
    EXPECT_EQ(coppice_tool({"bake", folder.input, "--dry-run", "--variant", wrong}).exit_code, 2) << wrong;
}

TEST(Variants, BakeAllTakesThemToo) {
  const Folder folder;
  const fs::path out = folder.folder / "out";
  ProcessResult result = coppice_tool({"bake-all", folder.folder / ".", "-o", out, "--variant", "all"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.baked("out"), (std::set<std::string>{"oak_1.coppice", "oak_2.coppice", "oak_3.coppice"}));
  result = coppice_tool({"bake-all", folder.input, "-o", folder.folder / "one", "--variant", "all"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.baked("one"), folder.baked("out")) << "a file by itself";
  result = coppice_tool({"view", folder.input, "--variant", "all", "--headless"});
  EXPECT_EQ(result.exit_code, 1);
  expect_says(result.err, "--variant takes a number here");
  std::ofstream(folder.folder / "list.json") << R"([{"input": "oak.glb", "output": "far.coppice", "node": "^Oak_1_LOD1$"},
                                                    {"input": "oak.glb", "output": "b.coppice", "variant": 2}])";
  result = coppice_tool({"bake-all", folder.folder / "list.json", "-o", out});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_says(coppice_tool({"inspect", out / "far.coppice"}).out, "10 leaves");
  expect_says(coppice_tool({"inspect", out / "b.coppice"}).out, "31 leaves");
}

TEST(Size, AnUnlikelyOneIsWarnedOfWithAUnit) {
  const TemporaryFolder folder;
  const auto bake = [&](float height, std::vector<std::string> more) {
    Pack pack;
    pack.part("trunk", trunk_part(height));
    pack.part("leaves", crown_part(40, height, 1));
    more.insert(more.begin(), {"bake", write_file(folder / "plant.glb", pack.file.glb()), "--dry-run"});
    return coppice_tool(more);
  };
  expect_says(bake(800, {}).err, "m wide: looks like centimetres: --unit cm");
  expect_says(bake(9000, {}).err, "m wide: looks like millimetres: --unit mm");
  expect_says(bake(0.004f, {}).err, "m wide: looks like units of 100 m: --unit 100");
  EXPECT_EQ(bake(800, {"--unit", "cm"}).err.find("looks like"), std::string::npos);
  EXPECT_EQ(bake(60, {}).err.find("looks like"), std::string::npos);
}

}  // namespace
}  // namespace coppice::test
