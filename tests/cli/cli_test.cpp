// The coppice program from outside: help, exit codes, what it leaves on disk. The keys of reports are those of bake/README.md.

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "documents.h"
#include "generate_plant.h"
#include "import_gltf.h"
#include "leaf_cards.h"
#include "made_once.h"
#include "mentions.h"
#include "places.h"
#include "process.h"

namespace cli_test {

namespace fs = std::filesystem;
using coppice::test::mentions;
using coppice::test::ProcessOptions;
using coppice::test::ProcessResult;
using coppice::test::TemporaryFolder;

ProcessResult coppice_tool(const std::vector<std::string>& arguments, const ProcessOptions& options = {}) {
  return coppice::test::run_process(coppice::test::kTool, arguments, options);
}

std::string read_bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  ASSERT_TRUE(file.good()) << path;
}

/// Exit code 1 and one line on stderr that names the file; nothing on stdout.
void expect_one_line_error(const ProcessResult& result, const fs::path& file, const std::string& about) {
  EXPECT_EQ(result.exit_code, 1) << about;
  EXPECT_EQ(result.signal, 0) << about;
  EXPECT_EQ(result.out, "") << about;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << about << ":\n" << result.err;
  EXPECT_EQ(result.err.rfind("coppice: ", 0), 0u) << about << ":\n" << result.err;
  EXPECT_TRUE(mentions(result.err, {file.filename().string()})) << about;
}

/// The corylus plant and its bake.
struct Baked {
  fs::path glb, coppice, report;
};

Baked make_baked() {
  const fs::path glb = coppice::test::corylus_glb();
  const fs::path folder = coppice::test::made_once("corylus_mi", [&](const fs::path& kept) {
    const ProcessResult bake =
        coppice_tool({"bake", glb, "-o", kept / "corylus.coppice", "--metric", "mi", "--threads", "1", "--report", kept / "corylus.json"});
    if (bake.exit_code != 0) throw std::runtime_error("coppice bake failed: " + bake.err);
  });
  return {glb, folder / "corylus.coppice", folder / "corylus.json"};
}

const Baked& baked() {
  static const Baked files = make_baked();
  return files;
}

/// Makes a bake quick where its result does not matter.
std::vector<std::string> quick_bake(const fs::path& input, const fs::path& output) {
  return {"bake", input, "-o", output, "--views", "4", "--resolution", "32", "--quiet"};
}

TEST(CommandLine, HelpListsEveryCommandAndOption) {
  const ProcessResult help = coppice_tool({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_TRUE(mentions(help.out, {"plant", "bake", "bake-all", "inspect", "verify", "export", "view"}));

  const std::vector<std::pair<std::string, std::vector<std::string>>> options = {
      {"plant", {"--output", "--seed", "corylus", "willow", "juniper"}},
      {"bake",
       {"--output", "--metric", "--areas", "--views", "--resolution", "--background", "--candidates", "--textures", "--leaf-material",
        "--wood-material", "--classes", "--node", "--variant", "--threads", "--report", "--dry-run", "--preview", "--quiet"}},
      {"bake-all", {"--output", "--jobs", "--metric", "--views", "--leaf-material", "--report", "--quiet", ".coppice-cache"}},
      {"inspect", {"--json"}},
      {"verify", {"input"}},
      {"export", {"--leaves", "--part", "--output"}}};
  for (const auto& [command, names] : options) {
    const ProcessResult result = coppice_tool({command, "--help"});
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_EQ(result.err, "") << command;
    for (const std::string& name : names) EXPECT_TRUE(mentions(result.out, {name})) << command;
  }
}

TEST(CommandLine, SlipsOfTheKeyboardAreNamedWithWhatWasMeant) {
  const ProcessResult bare = coppice_tool({});
  EXPECT_EQ(bare.exit_code, 0);
  EXPECT_EQ(bare.out, coppice_tool({"--help"}).out);
  struct Slip {
    std::vector<std::string> arguments;
    std::string typed, meant;  ///< meant: empty where nothing is like it
  };
  const std::vector<Slip> slips = {{{"bakee", "x.glb"}, "bakee", "bake"},
                                   {{"bake", "x.glb", "-o", "y.coppice", "--metrics", "mi"}, "--metrics", "--metric"},
                                   {{"verify", "x.forest", "--alow-outside"}, "--alow-outside", "--allow-outside"},
                                   {{"verify", "x.forest", "--swift"}, "--swift", ""}};
  for (const Slip& slip : slips) {
    const ProcessResult result = coppice_tool(slip.arguments);
    EXPECT_EQ(result.exit_code, 2) << slip.typed;
    std::string line = result.err.substr(0, result.err.find('\n'));
    EXPECT_TRUE(mentions(line, {slip.typed}));
    if (!slip.meant.empty()) {
      EXPECT_TRUE(mentions(line, {slip.meant}));
      continue;
    }
    line.erase(line.find(slip.typed), slip.typed.size());
    EXPECT_EQ(line.find("--"), std::string::npos) << line;
  }
}

TEST(CommandLine, UsageErrorsExitWith2) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const std::vector<std::vector<std::string>> cases = {{"grow"},
                                                       {"plant", "oak", "-o", out},
                                                       {"plant", "corylus"},
                                                       {"bake", "in.glb"},
                                                       {"bake", "-o", out},
                                                       {"bake", "in.glb", "-o", out, "--metric", "beauty"},
                                                       {"bake", "in.glb", "-o", out, "--views", "0"},
                                                       {"bake", "in.glb", "-o", out, "--background", "maybe"},
                                                       {"bake", "in.glb", "-o", out, "--unheard-of"},
                                                       {"export", "in.coppice", "-o", out},
                                                       {"export", "in.coppice", "-o", out, "--leaves", "0"},
                                                       {"export", "in.coppice", "-o", out, "--leaves", "most"},
                                                       {"verify"},
                                                       {"inspect"}};
  for (const auto& arguments : cases) {
    const ProcessResult result = coppice_tool(arguments);
    std::string line;
    for (const std::string& word : arguments) line += " " + word;
    EXPECT_EQ(result.exit_code, 2) << "coppice" << line;
    EXPECT_NE(result.err, "") << "coppice" << line;
    EXPECT_FALSE(fs::exists(out)) << "coppice" << line;
  }
}

TEST(CommandLine, PlantsHaveThePapersLeafCounts) {
  const TemporaryFolder folder;
  for (const auto& [species, leaf_count] : {std::pair{"corylus", 386u}, {"willow", 4456u}, {"juniper", 13162u}}) {
    const fs::path file = folder / "plant.glb";
    ASSERT_EQ(coppice_tool({"plant", species, "-o", file}).exit_code, 0) << species;
    const auto plant = coppice::bake::import_gltf(file, {});
    ASSERT_TRUE(plant) << species << ": " << plant.error().message();
    EXPECT_EQ(plant->leaves.size(), leaf_count) << species;
    EXPECT_GT(plant->wood.indices.size(), 0u) << species;
  }
}

TEST(CommandLine, SameSeedSamePlantOtherSeedOtherPlant) {
  const TemporaryFolder folder;
  ASSERT_EQ(coppice_tool({"plant", "corylus", "-o", folder / "a.glb", "--seed", "5"}).exit_code, 0);
  ASSERT_EQ(coppice_tool({"plant", "corylus", "-o", folder / "b.glb", "--seed", "5"}).exit_code, 0);
  ASSERT_EQ(coppice_tool({"plant", "corylus", "-o", folder / "c.glb", "--seed", "6"}).exit_code, 0);
  EXPECT_EQ(read_bytes(folder / "a.glb"), read_bytes(folder / "b.glb"));
  EXPECT_NE(read_bytes(folder / "a.glb"), read_bytes(folder / "c.glb"));
}

TEST(CommandLine, BakeRefusesWhatIsNoPlant) {
  const TemporaryFolder folder;
  const std::string glb = read_bytes(baked().glb);
  const std::vector<std::pair<const char*, std::string>> inputs = {{"text.glb", "this is a letter, not a plant\n"},
                                                                   {"text.gltf", "this is a letter, not a plant\n"},
                                                                   {"empty.glb", ""},
                                                                   {"empty.gltf", ""},
                                                                   {"truncated.glb", glb.substr(0, glb.size() / 2)},
                                                                   {"header_only.glb", glb.substr(0, 12)}};
  for (const auto& [name, bytes] : inputs) {
    const fs::path input = folder / name;
    write_bytes(input, bytes);
    const fs::path fresh = folder / "fresh.coppice";
    expect_one_line_error(coppice_tool({"bake", input, "-o", fresh}), input, name);
    EXPECT_FALSE(fs::exists(fresh)) << name;

    const fs::path kept = folder / "kept.coppice";
    write_bytes(kept, "what was here before");
    expect_one_line_error(coppice_tool({"bake", input, "-o", kept}), input, name);
    EXPECT_EQ(read_bytes(kept), "what was here before") << name;
  }
  const fs::path missing = folder / "missing.glb";
  expect_one_line_error(coppice_tool({"bake", missing, "-o", folder / "fresh.coppice"}), missing, "missing");
  const fs::path nowhere = missing / "out.coppice";
  write_bytes(missing, "a file, not a folder");
  expect_one_line_error(coppice_tool(quick_bake(baked().glb, nowhere)), nowhere, "no folder for the output");
}

TEST(CommandLine, LeafMaterialThatMatchesNothingListsTheNames) {
  const TemporaryFolder folder;
  const ProcessResult result = coppice_tool({"bake", baked().glb, "-o", folder / "out.coppice", "--leaf-material", "^petals$"});
  expect_one_line_error(result, baked().glb, "no such material");
  EXPECT_TRUE(mentions(result.err, {"--leaf-material", "'leaves'", "'wood'"}));
}

TEST(CommandLine, DryRunTellsWhatWasFoundAndWritesNothing) {
  const TemporaryFolder folder;
  const fs::path output = folder / "out.coppice", preview = folder / "parts.png";
  const ProcessResult result = coppice_tool({"bake", baked().glb, "-o", output, "--dry-run", "--preview", preview});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_FALSE(fs::exists(output));
  EXPECT_TRUE(mentions(result.out, {"leaves", "wood", "386", "32", "30", "+3.0", "12352", "10358"}));
  const std::string png = read_bytes(preview);
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  // Without -o too.
  EXPECT_EQ(coppice_tool({"bake", baked().glb, "--dry-run"}).out, result.out);
  EXPECT_EQ(coppice_tool({"bake", baked().glb}).exit_code, 2) << "neither an output nor a dry run";
}

TEST(CommandLine, ADryRunOfAPlantWithoutLeavesWarnsOnce) {
  for (const char* wood : {".", "^leaves$"}) {
    const ProcessResult result = coppice_tool({"bake", baked().glb, "--dry-run", "--wood-material", wood});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(mentions(result.out, {"0", "--wood-material"}));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_TRUE(mentions(result.err, {"corylus.glb"}));
  }
}

TEST(CommandLine, EveryCommandTakesAPlantWithoutLeaves) {
  const TemporaryFolder folder;
  const fs::path wood = folder / "wood.glb", plant = folder / "wood.coppice", exported = folder / "exported.glb";
  ASSERT_EQ(coppice_tool({"export", baked().coppice, "--part", "wood", "-o", wood}).exit_code, 0);
  const ProcessResult made = coppice_tool(quick_bake(wood, plant));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(std::count(made.err.begin(), made.err.end(), '\n'), 1) << made.err;
  EXPECT_EQ(coppice_tool({"verify", plant}).exit_code, 0);
  EXPECT_EQ(coppice_tool({"inspect", plant}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(coppice_tool({"inspect", plant, "--json"}).out)["leaves"], 0);
  // Exported and baked again it is all wood still.
  ASSERT_EQ(coppice_tool({"export", plant, "--leaves", "full", "-o", exported}).exit_code, 0);
  EXPECT_TRUE(mentions(coppice_tool({"bake", exported, "--dry-run"}).out, {"0", "10358"}));
  expect_one_line_error(coppice_tool({"export", plant, "--part", "foliage", "--leaves", "full", "-o", exported}), plant, "no leaves");
  expect_one_line_error(coppice_tool({"evaluate", wood, "--methods", "geometric"}), wood, "nothing to simplify");
}

TEST(CommandLine, AClassesFileDecides) {
  const TemporaryFolder folder;
  const fs::path classes = folder / "classes.json";
  const auto dry_run = [&](const std::string& text) {
    write_bytes(classes, text);
    return coppice_tool({"bake", baked().glb, "--dry-run", "--classes", classes});
  };
  // Petioles are the wood's pieces of three triangles.
  const ProcessResult result = dry_run(R"({"classes": [{"material": "wood", "class": "drop", "max_triangles": 3}]})");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"386", "12352", "9200", "classes.json", "classes[0]"}));
  for (const auto& [text, place] :
       {std::pair{R"({"classes": [)", "14"}, std::pair{R"({"classes": [{"material": "a"}]})", "classes[0].class"}}) {
    const ProcessResult bad = dry_run(text);
    expect_one_line_error(bad, classes, text);
    EXPECT_TRUE(mentions(bad.err, {place}));
  }
}

TEST(CommandLine, BakeIsTheSameForAnyThreadCount) {
  const TemporaryFolder folder;
  const fs::path output = folder / "out.coppice";
  ASSERT_EQ(coppice_tool({"bake", baked().glb, "-o", output, "--metric", "mi", "--threads", "2", "--quiet"}).exit_code, 0);
  EXPECT_TRUE(read_bytes(output) == read_bytes(baked().coppice)) << "--threads 2 gives another file than --threads 1";
}

TEST(CommandLine, ReportHasTheKeysOfTheContract) {
  const auto report = nlohmann::json::parse(read_bytes(baked().report));
  const auto keys = [](const nlohmann::json& object) {
    std::set<std::string> names;
    for (const auto& item : object.items()) names.insert(item.key());
    return names;
  };
  const coppice::test::Table table =
      coppice::test::table_after(coppice::test::source_text("bake/README.md"), "`coppice bake --report F.json`");
  EXPECT_EQ(keys(report), coppice::test::column_spans(table, 0));
  for (const char* key : {"areas", "leaf_meshes", "seconds"}) EXPECT_EQ(keys(report[key]), coppice::test::spans_of_row(table, key)) << key;
  std::set<std::string> information = keys(report["foliage_mi"]);
  information.merge(keys(report["foliage_mi"]["levels"].at(0)));
  EXPECT_EQ(information, coppice::test::spans_of_row(table, "foliage_mi"));
  EXPECT_EQ(report["areas"], (nlohmann::json{{"initial", "item-buffers"}, {"steps", "item-buffers"}, {"device", ""}}));
  EXPECT_GT(report["leaf_meshes"]["triangles"], 2 * 386);
  EXPECT_GT(report["leaf_meshes"]["bytes"], 386);
  EXPECT_EQ(report["source_leaves"], 386);
  EXPECT_EQ(report["file_bytes"], fs::file_size(baked().coppice));
  EXPECT_GT(report["foliage_bytes"], 386 * 4);
  EXPECT_LT(report["foliage_bytes"], report["file_bytes"]);
  EXPECT_NEAR(report["bytes_per_leaf"].get<double>(), report["foliage_bytes"].get<double>() / 386.0, 0.01);
  EXPECT_GE(report["evaluations"], 385);
  EXPECT_GT(report["peak_rss_bytes"], 1 << 20);
  EXPECT_GT(report["foliage_mi"]["source"], 0.0);
  EXPECT_EQ(report["foliage_mi"]["levels"].size(), 7u);
  double sum = 0.0;
  for (const char* stage : {"import", "visibility", "collapse", "error_table", "pack"}) {
    EXPECT_GE(report["seconds"][stage], 0.0) << stage;
    sum += report["seconds"][stage].get<double>();
  }
  EXPECT_LE(sum, report["seconds"]["total"].get<double>() + 1e-3);
}

TEST(CommandLine, BakeMakesTheFoldersOfItsOutputs) {
  const TemporaryFolder folder;
  const fs::path output = folder / "new/folder/x.coppice", report = folder / "reports/x.json";
  std::vector<std::string> arguments = quick_bake(baked().glb, output);
  arguments.insert(arguments.end(), {"--report", report});
  const ProcessResult result = coppice_tool(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(output));
  EXPECT_TRUE(fs::exists(report));
}

TEST(CommandLine, QuietPrintsNothing) {
  const TemporaryFolder folder;
  const ProcessResult result = coppice_tool(quick_bake(baked().glb, folder / "out.coppice"));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
}

TEST(CommandLine, VerifyAcceptsABakeAndFindsAnyFlippedByte) {
  const ProcessResult good = coppice_tool({"verify", baked().coppice});
  EXPECT_EQ(good.exit_code, 0) << good.err;

  const TemporaryFolder folder;
  const std::string bytes = read_bytes(baked().coppice);
  constexpr std::size_t kFlips = 64;
  for (std::size_t i = 0; i < kFlips; ++i) {
    const std::size_t offset = i * (bytes.size() - 1) / (kFlips - 1);
    std::string damaged = bytes;
    damaged[offset] = static_cast<char>(damaged[offset] ^ 0x10);
    const fs::path file = folder / "damaged.coppice";
    write_bytes(file, damaged);
    expect_one_line_error(coppice_tool({"verify", file}), file, "byte " + std::to_string(offset) + " flipped");
  }
}

TEST(CommandLine, VerifyRefusesTruncatedAndForeignFiles) {
  const TemporaryFolder folder;
  const std::string bytes = read_bytes(baked().coppice);
  const fs::path file = folder / "short.coppice";
  for (const std::size_t length : {std::size_t{0}, std::size_t{7}, std::size_t{63}, bytes.size() / 2, bytes.size() - 1}) {
    write_bytes(file, bytes.substr(0, length));
    expect_one_line_error(coppice_tool({"verify", file}), file, std::to_string(length) + " bytes");
  }
  write_bytes(file, bytes + "x");
  expect_one_line_error(coppice_tool({"verify", file}), file, "one byte too many");
  expect_one_line_error(coppice_tool({"verify", baked().glb}), baked().glb, "a .glb");
}

TEST(CommandLine, InspectJsonAgreesWithTheBake) {
  const ProcessResult text = coppice_tool({"inspect", baked().coppice});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  const ProcessResult json = coppice_tool({"inspect", baked().coppice, "--json"});
  EXPECT_EQ(json.exit_code, 0) << json.err;
  const auto parsed = nlohmann::json::parse(json.out);
  EXPECT_EQ(parsed["leaves"], 386) << json.out;
  EXPECT_NEAR(parsed["size_m"][1].get<double>(), nlohmann::json::parse(read_bytes(baked().report))["size_m"][1].get<double>(), 0.05);
  EXPECT_EQ(parsed["file_bytes"], fs::file_size(baked().coppice)) << json.out;
  std::array<char, 32> height{};
  std::snprintf(height.data(), height.size(), "%.3g", parsed["size_m"][1].get<double>());
  EXPECT_TRUE(mentions(text.out, {"386", height.data(), "Draco"}));
  for (const auto& chunk : parsed["chunks"])
    EXPECT_EQ(chunk.value("draco", ""), chunk["kind"] == "PAGE"                                   ? "symbols"
                                        : chunk["kind"] == "WOOD" || chunk["kind"] == "LEAF_MESH" ? "mesh"
                                                                                                  : "");
}

TEST(CommandLine, TexturesAreStoredAsAskedFor) {
  const TemporaryFolder folder;
  const auto textures = [&](const fs::path& file) {
    const ProcessResult json = coppice_tool({"inspect", file, "--json"});
    EXPECT_EQ(json.exit_code, 0) << json.err;
    return nlohmann::json::parse(json.out)["textures"];
  };
  const auto blocks = textures(baked().coppice);
  ASSERT_FALSE(blocks.empty());
  const fs::path file = folder / "plain.coppice";
  const ProcessResult bake =
      coppice_tool({"bake", baked().glb, "-o", file, "--textures", "rgba8", "--metric", "geometric", "--views", "4", "--resolution", "32"});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  const auto plain = textures(file);
  ASSERT_EQ(plain.size(), blocks.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_TRUE(blocks[i]["format"] == "bc3" || blocks[i]["format"] == "bc1") << blocks[i];
    EXPECT_EQ(plain[i]["format"], "rgba8");
    EXPECT_GT(plain[i]["bytes"].get<int>(), 3 * blocks[i]["bytes"].get<int>());
  }
  EXPECT_EQ(coppice_tool({"bake", baked().glb, "-o", file, "--textures", "etc2"}).exit_code, 2);
}

TEST(CommandLine, ExportGivesExactlySoManyLeafQuads) {
  const TemporaryFolder folder;
  const fs::path cut = folder / "cut.glb";
  for (const std::uint32_t leaves : {1u, 2u, 9u, 77u, 385u, 386u}) {
    const ProcessResult result =
        coppice_tool({"export", baked().coppice, "--leaves", std::to_string(leaves), "--part", "foliage", "-o", cut});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto plant = coppice::bake::import_gltf(cut, {});
    ASSERT_TRUE(plant) << plant.error().message();
    EXPECT_EQ(plant->foliage.indices.size(), 6u * leaves);
    EXPECT_EQ(plant->foliage.positions.size(), 4u * leaves);
    EXPECT_EQ(plant->wood.indices.size(), 0u);
  }
  ASSERT_EQ(coppice_tool({"export", baked().coppice, "--leaves", "20", "-o", cut}).exit_code, 0);
  const auto whole = coppice::bake::import_gltf(cut, {});
  ASSERT_TRUE(whole) << whole.error().message();
  EXPECT_EQ(whole->foliage.indices.size(), 6u * 20u);
  EXPECT_GT(whole->wood.indices.size(), 0u);

  const fs::path refused = folder / "refused.glb";
  expect_one_line_error(coppice_tool({"export", baked().coppice, "--leaves", "387", "-o", refused}), baked().coppice, "too many leaves");
  EXPECT_FALSE(fs::exists(refused));
}

TEST(CommandLine, LeafMeshesTravelThroughBakeAndExport) {
  const TemporaryFolder folder;
  const fs::path full = folder / "full.glb", plain = folder / "plain.coppice", quads = folder / "quads.glb";
  ASSERT_EQ(coppice_tool({"export", baked().coppice, "--leaves", "full", "--part", "foliage", "-o", full}).exit_code, 0);
  const auto source = coppice::bake::import_gltf(baked().glb, {}), exported = coppice::bake::import_gltf(full, {});
  ASSERT_TRUE(source && exported);
  EXPECT_EQ(exported->leaves.size(), 386u);
  EXPECT_EQ(exported->foliage.indices.size(), source->foliage.indices.size());

  const ProcessResult bake =
      coppice_tool({"bake", baked().glb, "-o", plain, "--leaf-meshes", "off", "--metric", "geometric", "--views", "4"});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  const auto inspected = [&](const fs::path& file) { return nlohmann::json::parse(coppice_tool({"inspect", file, "--json"}).out); };
  EXPECT_TRUE(inspected(plain)["leaf_meshes"].empty());
  EXPECT_EQ(inspected(baked().coppice)["leaf_meshes"][0]["triangles"], source->foliage.indices.size() / 3);
  EXPECT_EQ(inspected(baked().coppice)["leaf_mesh_error_px"].size(), 7u);
  ASSERT_EQ(coppice_tool({"export", plain, "--leaves", "full", "--part", "foliage", "-o", quads}).exit_code, 0);
  EXPECT_EQ(coppice::bake::import_gltf(quads, {})->foliage.indices.size(), 6u * 386u) << "all quads, where that is the finest";
}

TEST(CommandLine, WindIsBakedStiffenedAndLeftOut) {
  const TemporaryFolder folder;
  const fs::path file = folder / "wind.coppice";
  const auto wind_with = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"bake", baked().glb, "-o", file, "--metric", "geometric", "--views", "4", "--resolution", "32"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ProcessResult bake = coppice_tool(arguments);
    EXPECT_EQ(bake.exit_code, 0) << bake.err;
    EXPECT_EQ(coppice_tool({"verify", file}).exit_code, 0);
    return nlohmann::json::parse(coppice_tool({"inspect", file, "--json"}).out)["wind"];
  };
  const auto plain = wind_with({}), stiff = wind_with({"--wind-stiffness", "2"}), none = wind_with({"--no-wind"});
  EXPECT_EQ(plain["node_side"], 4) << "of 386 leaves";
  for (const char* key : {"bend_m", "lean_m", "sway_m", "most_move_m"}) {
    EXPECT_GT(plain[key].get<double>(), 0.0) << key;
    EXPECT_NEAR(stiff[key].get<double>(), 0.5 * plain[key].get<double>(), 1e-6) << key;
    EXPECT_EQ(none[key].get<double>(), 0.0) << key;
  }
  EXPECT_LE(plain["most_growth"].get<double>(), 0.08);
  EXPECT_EQ(none["node_side"], 0);
  EXPECT_FALSE(mentions(coppice_tool({"inspect", file}).out, {"4^3"})) << "there is no grid";
  EXPECT_TRUE(mentions(coppice_tool({"inspect", baked().coppice}).out, {"4^3"}));
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"--wind-stiffness", "0"}, {"--wind-stiffness", "11"}, {"--wind-weights", "COLOR"}, {"--wind-weights", "RED"}}) {
    std::vector<std::string> arguments{"bake", baked().glb, "-o", file};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    EXPECT_EQ(coppice_tool(arguments).exit_code, 2) << wrong[1];
  }
}

/// The largest distance between corresponding corners along an axis, in units of the box's side along that axis.
float quad_distance(const coppice::bake::Quad& a, const std::array<glm::vec3, 4>& b, const glm::vec3& box) {
  float worst = 0.0f;
  for (std::size_t i = 0; i < 4; ++i)
    for (int axis = 0; axis < 3; ++axis) worst = std::max(worst, std::abs(a[i][axis] - b[i][axis]) / box[axis]);
  return worst;
}

TEST(CommandLine, ExportOfAllLeavesGivesTheSourceQuadsBack) {
  const TemporaryFolder folder;
  const fs::path cut = folder / "cut.glb";
  ASSERT_EQ(coppice_tool({"export", baked().coppice, "--leaves", "386", "--part", "foliage", "-o", cut}).exit_code, 0);
  const auto exported = coppice::bake::import_gltf(cut, {});
  ASSERT_TRUE(exported) << exported.error().message();
  ASSERT_EQ(exported->foliage.positions.size(), 4u * 386u);
  auto source = coppice::bake::import_gltf(baked().glb, {});
  ASSERT_TRUE(source) << source.error().message();
  const auto foliage = coppice::bake::card_foliage(*source);
  ASSERT_TRUE(foliage) << foliage.error().message();

  glm::vec3 low = foliage->quads[0][0];
  glm::vec3 high = low;
  for (const auto& quad : foliage->quads) {
    for (const auto& corner : quad) {
      low = glm::min(low, corner);
      high = glm::max(high, corner);
    }
  }
  const glm::vec3 box = high - low;
  std::vector<bool> taken(386, false);
  for (std::size_t leaf = 0; leaf < 386; ++leaf) {
    std::size_t nearest = 386;
    for (std::size_t i = 0; i < 386; ++i) {
      const auto* p = &exported->foliage.positions[4 * i];
      if (!taken[i] && quad_distance(foliage->quads[leaf], {p[0], p[1], p[2], p[3]}, box) <= 1.0f / 16384.0f) nearest = i;
    }
    ASSERT_LT(nearest, 386u) << "leaf " << leaf << " is not among the exported quads";
    taken[nearest] = true;
  }
}

TEST(CommandLine, AnOutputThatIsAnotherFileOfTheCommandIsRefused) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "mine.glb", output = folder / "mine.coppice";
  fs::copy(baked().glb, plant);
  const std::string before = read_bytes(plant);
  expect_one_line_error(coppice_tool({"bake", plant, "-o", plant}), plant, "bake over its input");
  expect_one_line_error(coppice_tool({"bake", plant, "-o", output, "--report", plant}), plant, "report over the input");
  expect_one_line_error(coppice_tool({"bake", plant, "-o", output, "--report", output}), output, "report over the output");
  expect_one_line_error(coppice_tool({"export", baked().coppice, "--leaves", "9", "-o", baked().coppice}), baked().coppice, "export");
  EXPECT_EQ(read_bytes(plant), before);
  EXPECT_FALSE(fs::exists(output));
}

TEST(CommandLine, AnOutputFolderThatCannotBeMadeIsNoticedBeforeTheWork) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "juniper.glb", output = plant / "juniper.coppice";
  ASSERT_EQ(coppice_tool({"plant", "juniper", "-o", plant}).exit_code, 0);
  ProcessOptions options;
  options.kill_after = std::chrono::seconds(2);  // a bake takes longer
  expect_one_line_error(coppice_tool({"bake", plant, "-o", output}, options), output, "no such folder");
}

TEST(CommandLine, WoodAloneNeedsNoLeafCount) {
  const TemporaryFolder folder;
  const fs::path wood = folder / "wood.glb";
  EXPECT_EQ(coppice_tool({"export", baked().coppice, "--part", "wood", "-o", wood}).exit_code, 0);
  EXPECT_TRUE(fs::exists(wood));
  EXPECT_EQ(coppice_tool({"export", baked().coppice, "-o", wood}).exit_code, 2);
}

TEST(CommandLine, AKilledBakeLeavesTheOldFile) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "juniper.glb";
  ASSERT_EQ(coppice_tool({"plant", "juniper", "-o", plant}).exit_code, 0);
  const fs::path kept = folder / "kept.coppice";
  write_bytes(kept, "what was here before");
  for (const int milliseconds : {20, 200, 600}) {
    ProcessOptions options;
    options.kill_after = std::chrono::milliseconds(milliseconds);
    EXPECT_EQ(coppice_tool({"bake", plant, "-o", kept}, options).signal, SIGKILL) << milliseconds << " ms: it was not killed midway";
    EXPECT_EQ(read_bytes(kept), "what was here before") << "killed after " << milliseconds << " ms";
    EXPECT_EQ(coppice_tool({"bake", plant, "-o", folder / "fresh.coppice"}, options).signal, SIGKILL);
    EXPECT_FALSE(fs::exists(folder / "fresh.coppice")) << "killed after " << milliseconds << " ms";
  }
}

TEST(CommandLine, ABakeThatCannotWriteAllLeavesTheOldFile) {
  const TemporaryFolder folder;
  const fs::path kept = folder / "kept.coppice";
  write_bytes(kept, "what was here before");
  ProcessOptions options;
  options.largest_file_bytes = 2048;  // as on a disk that is full
  expect_one_line_error(coppice_tool(quick_bake(baked().glb, kept), options), kept, "over another file");
  EXPECT_EQ(read_bytes(kept), "what was here before");
  expect_one_line_error(coppice_tool(quick_bake(baked().glb, folder / "fresh.coppice"), options), "fresh.coppice", "a new file");
  EXPECT_FALSE(fs::exists(folder / "fresh.coppice"));
}

}  // namespace cli_test
