// Packs and sizes from outside: --variant, --node and --unit of bake and bake-all, and what is said of them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "mentions.h"
#include "pack_gltf.h"
#include "places.h"
#include "process.h"

namespace coppice::test {
namespace variants_cli_test {

namespace fs = std::filesystem;

ProcessResult coppice_tool(std::vector<std::string> arguments) {
  if (arguments.front() != "inspect") arguments.insert(arguments.end(), {"--views", "2", "--resolution", "16"});
  return run_process(test::kTool, arguments);
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

/// What `inspect` says of a baked file's leaves.
nlohmann::json leaves_of(const fs::path& file) {
  return nlohmann::json::parse(coppice_tool({"inspect", file, "--json"}).out)["leaves"];
}

TEST(Variants, TheFirstIsBakedAndALineSaysSo) {
  const Folder folder;
  const ProcessResult result = coppice_tool({"bake", folder.input, "-o", folder.folder / "one.coppice"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"30"}));
  EXPECT_EQ(leaves_of(folder.folder / "one.coppice"), 30);
  EXPECT_TRUE(mentions(result.err, {"3", "'Oak_1'", "'Oak_2'", "'Oak_3'", "--variant", "'Oak_1_LOD1'"}));
  const ProcessResult looked = coppice_tool({"bake", folder.input, "--dry-run"});
  EXPECT_TRUE(mentions(looked.out, {"1", "3", "Oak_1", "Oak_2", "Oak_3", "Oak_1_LOD1"}));
}

TEST(Variants, AllAreBakedIntoFilesOfTheirOwn) {
  const Folder folder;
  const ProcessResult result = coppice_tool({"bake", folder.input, "-o", folder.folder / "oak.coppice", "--variant", "all"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.baked("."), (std::set<std::string>{"oak_1.coppice", "oak_2.coppice", "oak_3.coppice"}));
  EXPECT_EQ(leaves_of(folder.folder / "oak_3.coppice"), 32);
  EXPECT_EQ(coppice_tool({"bake", folder.input, "-o", "-", "--variant", "all"}).exit_code, 1);
  for (const char* wrong : {"0", "-1", "two", "2x", ""})
    EXPECT_EQ(coppice_tool({"bake", folder.input, "--dry-run", "--variant", wrong}).exit_code, 2) << wrong;
}

TEST(Variants, OneThatFailsIsSaidAndTheOthersAreBaked) {
  Pack pack;
  for (int i = 0; i < 3; ++i) {
    Parts parts = tree(30, 5, static_cast<std::uint64_t>(i));
    if (i == 0) parts.back().first = "dry leaf";
    pack.part("Oak_" + std::to_string(i + 1), parts, {6.0f * static_cast<float>(i), 0, 0});
  }
  Folder folder;
  write_file(folder.input, pack.file.glb());
  const ProcessResult result =
      coppice_tool({"bake", folder.input, "-o", folder.folder / "oak.coppice", "--variant", "all", "--leaf-material", "^leaf$"});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_EQ(folder.baked("."), (std::set<std::string>{"oak_2.coppice", "oak_3.coppice"})) << result.err;
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
  EXPECT_TRUE(mentions(result.err, {"--variant"}));
  std::ofstream(folder.folder / "list.json") << R"([{"input": "oak.glb", "output": "far.coppice", "node": "^Oak_1_LOD1$"},
                                                    {"input": "oak.glb", "output": "b.coppice", "variant": 2}])";
  result = coppice_tool({"bake-all", folder.folder / "list.json", "-o", out});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(leaves_of(out / "far.coppice"), 10);
  EXPECT_EQ(leaves_of(out / "b.coppice"), 31);
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
  EXPECT_TRUE(mentions(bake(800, {}).err, {"--unit cm"}));
  EXPECT_TRUE(mentions(bake(9000, {}).err, {"--unit mm"}));
  EXPECT_TRUE(mentions(bake(0.004f, {}).err, {"--unit 100"}));
  EXPECT_FALSE(mentions(bake(800, {"--unit", "cm"}).err, {"--unit"}));
  EXPECT_FALSE(mentions(bake(60, {}).err, {"--unit"}));
}

}  // namespace variants_cli_test
}  // namespace coppice::test
