// Packs and sizes from outside: --variant, --node and --unit of bake and bake-all, and what is said of them.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "pack_gltf.h"
#include "tool.h"

namespace coppice::test::variants_cli_test {

namespace fs = std::filesystem;

/// A quick bake of one plant or all.
ProcessResult bake(const Words& arguments) {
  return run_tool(joined(arguments, {"--views", "2", "--resolution", "16"}));
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

/// How many leaves a baked file has.
nlohmann::json leaves_of(const fs::path& file) {
  return nlohmann::json::parse(run_tool({"inspect", file, "--json"}).out)["leaves"];
}

TEST(Variants, TheFirstIsBakedAndALineSaysSo) {
  const Folder folder;
  const ProcessResult result = bake({"bake", folder.input, "-o", folder.folder / "one.coppice"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"30"}));
  EXPECT_EQ(leaves_of(folder.folder / "one.coppice"), 30);
  EXPECT_TRUE(mentions(result.err, {"3", "'Oak_1'", "'Oak_2'", "'Oak_3'", "--variant", "'Oak_1_LOD1'"}));
  const ProcessResult looked = bake({"bake", folder.input, "--dry-run"});
  EXPECT_TRUE(mentions(looked.out, {"1", "3", "Oak_1", "Oak_2", "Oak_3", "Oak_1_LOD1"}));
}

TEST(Variants, AllAreBakedIntoFilesOfTheirOwn) {
  const Folder folder;
  const ProcessResult result = bake({"bake", folder.input, "-o", folder.folder / "oak.coppice", "--variant", "all"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.baked("."), (std::set<std::string>{"oak_1.coppice", "oak_2.coppice", "oak_3.coppice"}));
  EXPECT_EQ(leaves_of(folder.folder / "oak_3.coppice"), 32);
  EXPECT_EQ(bake({"bake", folder.input, "-o", "-", "--variant", "all"}).exit_code, 1);
  for (const char* wrong : {"0", "-1", "two", "2x", ""})
    EXPECT_EQ(bake({"bake", folder.input, "--dry-run", "--variant", wrong}).exit_code, 2) << wrong;
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
      bake({"bake", folder.input, "-o", folder.folder / "oak.coppice", "--variant", "all", "--leaf-material", "^leaf$"});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_EQ(folder.baked("."), (std::set<std::string>{"oak_2.coppice", "oak_3.coppice"})) << result.err;
}

TEST(Variants, BakeAllTakesThemToo) {
  const Folder folder;
  const fs::path out = folder.folder / "out";
  ProcessResult result = bake({"bake-all", folder.folder / ".", "-o", out, "--variant", "all"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.baked("out"), (std::set<std::string>{"oak_1.coppice", "oak_2.coppice", "oak_3.coppice"}));
  result = bake({"bake-all", folder.input, "-o", folder.folder / "one", "--variant", "all"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(folder.baked("one"), folder.baked("out")) << "a file by itself";
  result = bake({"view", folder.input, "--variant", "all", "--headless"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(mentions(result.err, {"--variant"}));
  write_text(folder.folder / "list.json", R"([{"input": "oak.glb", "output": "far.coppice", "node": "^Oak_1_LOD1$"},
                                              {"input": "oak.glb", "output": "b.coppice", "variant": 2}])");
  result = bake({"bake-all", folder.folder / "list.json", "-o", out});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(leaves_of(out / "far.coppice"), 10);
  EXPECT_EQ(leaves_of(out / "b.coppice"), 31);
}

TEST(Size, AnUnlikelyOneIsWarnedOfWithAUnit) {
  const TemporaryFolder folder;
  const auto warning = [&](float height, const Words& more) {
    Pack pack;
    pack.part("trunk", trunk_part(height));
    pack.part("leaves", crown_part(40, height, 1));
    return bake(joined({"bake", write_file(folder / "plant.glb", pack.file.glb()), "--dry-run"}, more)).err;
  };
  EXPECT_TRUE(mentions(warning(800, {}), {"--unit cm"}));
  EXPECT_TRUE(mentions(warning(9000, {}), {"--unit mm"}));
  EXPECT_TRUE(mentions(warning(0.004f, {}), {"--unit 100"}));
  EXPECT_FALSE(mentions(warning(800, {"--unit", "cm"}), {"--unit"}));
  EXPECT_FALSE(mentions(warning(60, {}), {"--unit"}));
}

}  // namespace coppice::test::variants_cli_test
