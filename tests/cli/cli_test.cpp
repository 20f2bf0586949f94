// The coppice program from outside: help, exit codes, what it leaves on disk. The keys of reports are those of bake/README.md.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bounds.h"
#include "documents.h"
#include "import_gltf.h"
#include "leaf_cards.h"
#include "made_once.h"
#include "tool.h"

namespace coppice::test::cli_test {

namespace fs = std::filesystem;

void expect_refused(const ProcessResult& result, const fs::path& file, const std::string& about) {
  expect_one_line_error(result, Words{file.filename()}, about);
}

/// The corylus plant and its bake.
struct Baked {
  fs::path glb, coppice, report;
};

Baked make_baked() {
  const fs::path glb = corylus_glb();
  const fs::path folder = made_once("corylus_mi", [&](const fs::path& kept) {
    const ProcessResult bake =
        run_tool({"bake", glb, "-o", kept / "corylus.coppice", "--metric", "mi", "--threads", "1", "--report", kept / "corylus.json"});
    if (bake.exit_code != 0) throw std::runtime_error("coppice bake failed: " + bake.err);
  });
  return {glb, folder / "corylus.coppice", folder / "corylus.json"};
}

const Baked& baked() {
  static const Baked files = make_baked();
  return files;
}

/// Makes a bake quick where its result does not matter.
Words quick_bake(const fs::path& input, const fs::path& output, const Words& more = {}) {
  return joined({"bake", input, "-o", output, "--views", "4", "--resolution", "32", "--quiet"}, more);
}

nlohmann::json inspected(const fs::path& file) {
  const ProcessResult json = run_tool({"inspect", file, "--json"});
  EXPECT_EQ(json.exit_code, 0) << json.err;
  return nlohmann::json::parse(json.out);
}

TEST(CommandLine, SlipsOfTheKeyboardAreNamedWithWhatWasMeant) {
  const ProcessResult bare = run_tool({});
  EXPECT_EQ(bare.exit_code, 0);
  EXPECT_EQ(bare.out, run_tool({"--help"}).out);
  struct Slip {
    Words arguments;
    std::string typed, meant;  ///< meant: empty where nothing is like it
  };
  const std::vector<Slip> slips = {{{"bakee", "x.glb"}, "bakee", "bake"},
                                   {{"bake", "x.glb", "-o", "y.coppice", "--metrics", "mi"}, "--metrics", "--metric"},
                                   {{"verify", "x.forest", "--alow-outside"}, "--alow-outside", "--allow-outside"},
                                   {{"verify", "x.forest", "--swift"}, "--swift", ""}};
  for (const Slip& slip : slips) {
    const ProcessResult result = run_tool(slip.arguments);
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
  const std::vector<Words> cases = {{"grow"},
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
    const ProcessResult result = run_tool(arguments);
    const std::string line = testing::PrintToString(arguments);
    EXPECT_EQ(result.exit_code, 2) << line;
    EXPECT_NE(result.err, "") << line;
    EXPECT_FALSE(fs::exists(out)) << line;
  }
}

TEST(CommandLine, PlantsHaveThePapersLeafCounts) {
  const TemporaryFolder folder;
  for (const auto& [species, leaf_count] : {std::pair{"corylus", 386u}, {"willow", 4456u}, {"juniper", 13162u}}) {
    const fs::path file = folder / "plant.glb";
    ASSERT_EQ(run_tool({"plant", species, "-o", file}).exit_code, 0) << species;
    const auto plant = bake::import_gltf(file, {});
    ASSERT_TRUE(plant) << species << ": " << plant.error().message();
    EXPECT_EQ(plant->leaves.size(), leaf_count) << species;
    EXPECT_GT(plant->wood.indices.size(), 0u) << species;
  }
}

TEST(CommandLine, SameSeedSamePlantOtherSeedOtherPlant) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_tool({"plant", "corylus", "-o", folder / "a.glb", "--seed", "5"}).exit_code, 0);
  ASSERT_EQ(run_tool({"plant", "corylus", "-o", folder / "b.glb", "--seed", "5"}).exit_code, 0);
  ASSERT_EQ(run_tool({"plant", "corylus", "-o", folder / "c.glb", "--seed", "6"}).exit_code, 0);
  EXPECT_EQ(read_text(folder / "a.glb"), read_text(folder / "b.glb"));
  EXPECT_NE(read_text(folder / "a.glb"), read_text(folder / "c.glb"));
}

TEST(CommandLine, BakeRefusesWhatIsNoPlant) {
  const TemporaryFolder folder;
  const std::string glb = read_text(baked().glb);
  const std::vector<std::pair<const char*, std::string>> inputs = {{"text.glb", "this is a letter, not a plant\n"},
                                                                   {"text.gltf", "this is a letter, not a plant\n"},
                                                                   {"empty.glb", ""},
                                                                   {"empty.gltf", ""},
                                                                   {"truncated.glb", glb.substr(0, glb.size() / 2)},
                                                                   {"header_only.glb", glb.substr(0, 12)}};
  for (const auto& [name, bytes] : inputs) {
    const fs::path input = folder / name;
    write_text(input, bytes);
    const fs::path fresh = folder / "fresh.coppice";
    expect_refused(run_tool({"bake", input, "-o", fresh}), input, name);
    EXPECT_FALSE(fs::exists(fresh)) << name;

    const fs::path kept = folder / "kept.coppice";
    write_text(kept, "what was here before");
    expect_refused(run_tool({"bake", input, "-o", kept}), input, name);
    EXPECT_EQ(read_text(kept), "what was here before") << name;
  }
  const fs::path missing = folder / "missing.glb";
  expect_refused(run_tool({"bake", missing, "-o", folder / "fresh.coppice"}), missing, "missing");
}

TEST(CommandLine, DryRunTellsWhatWasFoundAndWritesNothing) {
  const TemporaryFolder folder;
  const fs::path output = folder / "out.coppice", preview = folder / "parts.png";
  const ProcessResult result = run_tool({"bake", baked().glb, "-o", output, "--dry-run", "--preview", preview});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_FALSE(fs::exists(output));
  EXPECT_TRUE(mentions(result.out, {"leaves", "wood", "386", "32", "30", "+3.0", "12352", "10358"}));
  const std::string png = read_text(preview);
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  // Without -o too.
  EXPECT_EQ(run_tool({"bake", baked().glb, "--dry-run"}).out, result.out);
  EXPECT_EQ(run_tool({"bake", baked().glb}).exit_code, 2) << "neither an output nor a dry run";
}

TEST(CommandLine, ExportWritesCapsulesOfTheWood) {
  const TemporaryFolder folder;
  const fs::path capsules = folder / "capsules.json";
  ASSERT_EQ(run_tool({"export", baked().coppice, "--capsules", "12", "-o", capsules}).exit_code, 0);
  const auto list = nlohmann::json::parse(read_text(capsules))["capsules"];
  ASSERT_GE(list.size(), 1u);
  EXPECT_LE(list.size(), 12u);
  EXPECT_LT(std::abs(list[0]["from"][1].get<double>()), 0.5) << "the stem stands on the ground";
  double top_m = 0.0;
  for (const auto& capsule : list) top_m = std::max(top_m, capsule["to"][1].get<double>());
  EXPECT_GT(top_m, 1.0);
  EXPECT_GT(list[0]["radius"].get<double>(), 0.0);
  EXPECT_EQ(run_tool({"export", baked().coppice, "--capsules", "12", "--leaves", "full", "-o", capsules}).exit_code, 2);
}

TEST(CommandLine, EveryCommandTakesAPlantWithoutLeaves) {
  const TemporaryFolder folder;
  const fs::path wood = folder / "wood.glb", plant = folder / "wood.coppice", exported = folder / "exported.glb";
  ASSERT_EQ(run_tool({"export", baked().coppice, "--part", "wood", "-o", wood}).exit_code, 0);
  const ProcessResult made = run_tool(quick_bake(wood, plant));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(count_of(made.err, "\n"), 1u) << made.err;
  EXPECT_EQ(run_tool({"verify", plant}).exit_code, 0);
  EXPECT_EQ(run_tool({"inspect", plant}).exit_code, 0);
  EXPECT_EQ(inspected(plant)["leaves"], 0);
  // Exported and baked again it is all wood still.
  ASSERT_EQ(run_tool({"export", plant, "--leaves", "full", "-o", exported}).exit_code, 0);
  const ProcessResult looked = run_tool({"bake", exported, "--dry-run"});
  EXPECT_TRUE(mentions(looked.out, {"0", "10358"}));
  EXPECT_EQ(count_of(looked.err, "\n"), 1u) << looked.err;
  EXPECT_TRUE(mentions(looked.err, {"exported.glb"}));
  expect_refused(run_tool({"export", plant, "--part", "foliage", "--leaves", "full", "-o", exported}), plant, "no leaves");
  expect_refused(run_tool({"evaluate", wood, "--methods", "geometric"}), wood, "nothing to simplify");
}

TEST(CommandLine, AClassesFileDecides) {
  const TemporaryFolder folder;
  const fs::path classes = folder / "classes.json";
  const auto dry_run = [&](const std::string& text) {
    write_text(classes, text);
    return run_tool({"bake", baked().glb, "--dry-run", "--classes", classes});
  };
  // Petioles are the wood's pieces of three triangles.
  const ProcessResult result = dry_run(R"({"classes": [{"material": "wood", "class": "drop", "max_triangles": 3}]})");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"386", "12352", "9200", "classes.json", "classes[0]"}));
  for (const auto& [text, place] :
       {std::pair{R"({"classes": [)", "14"}, std::pair{R"({"classes": [{"material": "a"}]})", "classes[0].class"}}) {
    expect_one_line_error(dry_run(text), {"classes.json", place}, text);
  }
}

TEST(CommandLine, ReportHasTheKeysOfTheContract) {
  const auto report = read_json(baked().report);
  const Table table = table_after(source_text("bake/README.md"), "`coppice bake --report F.json`");
  EXPECT_EQ(keys_of(report), column_spans(table, 0));
  for (const char* key : {"areas", "leaf_meshes", "seconds"}) EXPECT_EQ(keys_of(report[key]), spans_of_row(table, key)) << key;
  std::set<std::string> information = keys_of(report["foliage_mi"]);
  information.merge(keys_of(report["foliage_mi"]["levels"].at(0)));
  EXPECT_EQ(information, spans_of_row(table, "foliage_mi"));
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

TEST(CommandLine, BakeMakesTheFoldersOfItsOutputsAndQuietPrintsNothing) {
  const TemporaryFolder folder;
  const fs::path output = folder / "new/folder/x.coppice", report = folder / "reports/x.json";
  const ProcessResult result = run_tool(quick_bake(baked().glb, output, {"--report", report}));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out + result.err, "");
  EXPECT_TRUE(fs::exists(output));
  EXPECT_TRUE(fs::exists(report));
}

TEST(CommandLine, VerifyAcceptsABakeAndRefusesOthers) {
  const ProcessResult good = run_tool({"verify", baked().coppice});
  EXPECT_EQ(good.exit_code, 0) << good.err;
  expect_refused(run_tool({"verify", baked().glb}), baked().glb, "a .glb");

  const TemporaryFolder folder;
  const fs::path file = folder / "damaged.coppice";
  const std::string bytes = read_text(baked().coppice);
  const auto expect_damaged = [&](const std::string& damaged, const std::string& about) {
    write_text(file, damaged);
    expect_refused(run_tool({"verify", file}), file, about);
  };
  for (const std::size_t length : {std::size_t{0}, std::size_t{7}, std::size_t{63}, bytes.size() / 2, bytes.size() - 1})
    expect_damaged(bytes.substr(0, length), std::to_string(length) + " bytes");
  expect_damaged(bytes + "x", "one byte too many");
  for (const std::size_t at : {std::size_t{0}, bytes.size() / 3, bytes.size() - 1}) {
    std::string flipped = bytes;
    flipped[at] ^= 0x10;
    expect_damaged(flipped, "byte " + std::to_string(at) + " flipped");
  }
}

TEST(CommandLine, InspectJsonAgreesWithTheBake) {
  const ProcessResult text = run_tool({"inspect", baked().coppice});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  const nlohmann::json parsed = inspected(baked().coppice);
  EXPECT_EQ(parsed["leaves"], 386) << parsed;
  EXPECT_NEAR(parsed["size_m"][1].get<double>(), read_json(baked().report)["size_m"][1].get<double>(), 0.05);
  EXPECT_EQ(parsed["file_bytes"], fs::file_size(baked().coppice)) << parsed;
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
  const auto blocks = inspected(baked().coppice)["textures"];
  ASSERT_FALSE(blocks.empty());
  const fs::path file = folder / "plain.coppice";
  const ProcessResult bake = run_tool(quick_bake(baked().glb, file, {"--textures", "rgba8", "--metric", "geometric"}));
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  const auto plain = inspected(file)["textures"];
  ASSERT_EQ(plain.size(), blocks.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_TRUE(blocks[i]["format"] == "bc3" || blocks[i]["format"] == "bc1") << blocks[i];
    EXPECT_EQ(plain[i]["format"], "rgba8");
    EXPECT_GT(plain[i]["bytes"].get<int>(), 3 * blocks[i]["bytes"].get<int>());
  }
  EXPECT_EQ(run_tool({"bake", baked().glb, "-o", file, "--textures", "etc2"}).exit_code, 2);
}

TEST(CommandLine, ExportGivesExactlySoManyLeafQuads) {
  const TemporaryFolder folder;
  const fs::path cut = folder / "cut.glb";
  for (const std::uint32_t leaves : {1u, 2u, 9u, 77u, 385u, 386u}) {
    const ProcessResult result = run_tool({"export", baked().coppice, "--leaves", std::to_string(leaves), "--part", "foliage", "-o", cut});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto plant = bake::import_gltf(cut, {});
    ASSERT_TRUE(plant) << plant.error().message();
    EXPECT_EQ(plant->foliage.indices.size(), 6u * leaves);
    EXPECT_EQ(plant->foliage.positions.size(), 4u * leaves);
    EXPECT_EQ(plant->wood.indices.size(), 0u);
    EXPECT_EQ(plant->foliage.vertex_alongs.empty(), leaves == 386u) << "a leaf that stands for many says how their normals lie";
    for (const float along : plant->foliage.vertex_alongs)
      EXPECT_TRUE(along >= 0.0f && along <= 1.0f) << along << " of leaves without a front";
  }
  ASSERT_EQ(run_tool({"export", baked().coppice, "--leaves", "20", "-o", cut}).exit_code, 0);
  const auto whole = bake::import_gltf(cut, {});
  ASSERT_TRUE(whole) << whole.error().message();
  EXPECT_EQ(whole->foliage.indices.size(), 6u * 20u);
  EXPECT_GT(whole->wood.indices.size(), 0u);

  const fs::path refused = folder / "refused.glb";
  expect_refused(run_tool({"export", baked().coppice, "--leaves", "387", "-o", refused}), baked().coppice, "too many leaves");
  EXPECT_FALSE(fs::exists(refused));
}

TEST(CommandLine, LeafMeshesTravelThroughBakeAndExport) {
  const TemporaryFolder folder;
  const fs::path full = folder / "full.glb", plain = folder / "plain.coppice", quads = folder / "quads.glb";
  ASSERT_EQ(run_tool({"export", baked().coppice, "--leaves", "full", "--part", "foliage", "-o", full}).exit_code, 0);
  const auto source = bake::import_gltf(baked().glb, {}), exported = bake::import_gltf(full, {});
  ASSERT_TRUE(source && exported);
  EXPECT_EQ(exported->leaves.size(), 386u);
  EXPECT_EQ(exported->foliage.indices.size(), source->foliage.indices.size());

  const ProcessResult bake = run_tool({"bake", baked().glb, "-o", plain, "--leaf-meshes", "off", "--metric", "geometric", "--views", "4"});
  ASSERT_EQ(bake.exit_code, 0) << bake.err;
  EXPECT_TRUE(inspected(plain)["leaf_meshes"].empty());
  EXPECT_EQ(inspected(baked().coppice)["leaf_meshes"][0]["triangles"], source->foliage.indices.size() / 3);
  EXPECT_EQ(inspected(baked().coppice)["leaf_mesh_error_px"].size(), 7u);
  ASSERT_EQ(run_tool({"export", plain, "--leaves", "full", "--part", "foliage", "-o", quads}).exit_code, 0);
  EXPECT_EQ(bake::import_gltf(quads, {})->foliage.indices.size(), 6u * 386u) << "all quads, where that is the finest";
}

TEST(CommandLine, WindIsBakedStiffenedAndLeftOut) {
  const TemporaryFolder folder;
  const fs::path file = folder / "wind.coppice";
  const auto wind_with = [&](const Words& options) {
    const ProcessResult bake = run_tool(quick_bake(baked().glb, file, joined({"--metric", "geometric"}, options)));
    EXPECT_EQ(bake.exit_code, 0) << bake.err;
    EXPECT_EQ(run_tool({"verify", file}).exit_code, 0);
    return inspected(file)["wind"];
  };
  const auto plain = wind_with({}), stiff = wind_with({"--wind-stiffness", "2"}), none = wind_with({"--no-wind"});
  EXPECT_EQ(plain["node_side"], 4) << "of 386 leaves";
  for (const char* key : {"bend_m", "lean_m", "sway_m", "most_move_m"}) {
    EXPECT_GT(plain[key].get<double>(), 0.0) << key;
    // The top of a stem that bends half as far comes down by a quarter.
    EXPECT_NEAR(stiff[key].get<double>(), 0.5 * plain[key].get<double>(), key == std::string("most_move_m") ? 0.1 : 1e-6) << key;
    EXPECT_EQ(none[key].get<double>(), 0.0) << key;
  }
  EXPECT_LE(plain["most_growth"].get<double>(), 0.08);
  EXPECT_EQ(none["node_side"], 0);
  EXPECT_FALSE(mentions(run_tool({"inspect", file}).out, {"4^3"})) << "there is no grid";
  EXPECT_TRUE(mentions(run_tool({"inspect", baked().coppice}).out, {"4^3"}));
  for (const Words& wrong :
       {Words{"--wind-stiffness", "0"}, {"--wind-stiffness", "11"}, {"--wind-weights", "COLOR"}, {"--wind-weights", "RED"}})
    EXPECT_EQ(run_tool(quick_bake(baked().glb, file, wrong)).exit_code, 2) << wrong[1];
}

/// The largest distance between corresponding corners along an axis, in units of the box's side along that axis.
float quad_distance(const bake::Quad& a, const std::array<glm::vec3, 4>& b, const glm::vec3& box) {
  float worst = 0.0f;
  for (std::size_t i = 0; i < 4; ++i)
    for (int axis = 0; axis < 3; ++axis) worst = std::max(worst, std::abs(a[i][axis] - b[i][axis]) / box[axis]);
  return worst;
}

TEST(CommandLine, ExportOfAllLeavesGivesTheSourceQuadsBack) {
  const TemporaryFolder folder;
  const fs::path cut = folder / "cut.glb";
  ASSERT_EQ(run_tool({"export", baked().coppice, "--leaves", "386", "--part", "foliage", "-o", cut}).exit_code, 0);
  const auto exported = bake::import_gltf(cut, {});
  ASSERT_TRUE(exported) << exported.error().message();
  ASSERT_EQ(exported->foliage.positions.size(), 4u * 386u);
  auto source = bake::import_gltf(baked().glb, {});
  ASSERT_TRUE(source) << source.error().message();
  const auto foliage = bake::card_foliage(*source);
  ASSERT_TRUE(foliage) << foliage.error().message();

  bake::PointBox<glm::vec3> box;
  for (const bake::Quad& quad : foliage->quads)
    for (const glm::vec3& corner : quad) box.add(corner);
  std::vector<bool> taken(386, false);
  for (std::size_t leaf = 0; leaf < 386; ++leaf) {
    std::size_t nearest = 386;
    for (std::size_t i = 0; i < 386; ++i) {
      const auto* p = &exported->foliage.positions[4 * i];
      if (!taken[i] && quad_distance(foliage->quads[leaf], {p[0], p[1], p[2], p[3]}, box.extent()) <= 1.0f / 16384.0f) nearest = i;
    }
    ASSERT_LT(nearest, 386u) << "leaf " << leaf << " is not among the exported quads";
    taken[nearest] = true;
  }
}

}  // namespace coppice::test::cli_test
