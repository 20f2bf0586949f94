// coppice-forest and the host examples from outside: they run, their pictures show plants, their statistics keep the contract's keys.

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "baked_corylus.h"
#include "documents.h"
#include "golden.h"
#include "tool.h"

namespace coppice::test::demo_test {

namespace fs = std::filesystem;

Words headless_forest(const fs::path& plant, const fs::path& picture, const Words& more = {}) {
  return joined(
      {"--plants", plant, "--count", "40", "--size", "320x180", "--frames", "2", "--headless", "--validation", "--screenshot", picture},
      more);
}

/// With --validation among the arguments. statistics: the file that says how many messages there were
void run_without_messages(const Words& arguments, const fs::path& statistics) {
  const ProcessResult result = run_process(kForest, joined(arguments, {"--stats", statistics}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_json(statistics)["validation_messages"], 0) << result.out << result.err;
}

/// The keys of --stats.
Table table_of_statistics() {
  return table_after(source_text("demo/README.md"), "`coppice-forest --stats F.json`");
}

bool is_green(const std::uint8_t* rgb) {
  return rgb[1] > rgb[0] + 8 && rgb[1] > rgb[2] + 8;
}

/// The share of a picture's pixels that have a colour.
double share_of(const Picture& picture, const std::function<bool(const std::uint8_t* rgb)>& is_colour) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgba.size(); i += 4) count += is_colour(&picture.rgba[i]);
  return static_cast<double>(count) / static_cast<double>(picture.rgba.size() / 4);
}

TEST(HelloPlant, DrawsAPlant) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), picture = folder / "hello.ppm";
  const ProcessResult result = run_process(kHelloPlant, {plant, picture});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(mentions(result.out, {"386"}));

  std::ifstream file(picture, std::ios::binary);
  std::string magic;
  std::size_t width = 0, height = 0, largest = 0;
  file >> magic >> width >> height >> largest;
  file.get();
  ASSERT_EQ(magic, "P6");
  const std::string pixels{std::istreambuf_iterator<char>(file), {}};
  ASSERT_EQ(pixels.size(), width * height * 3);
  std::size_t green_count = 0;
  for (std::size_t i = 0; i < pixels.size(); i += 3) green_count += is_green(reinterpret_cast<const std::uint8_t*>(pixels.data()) + i);
  EXPECT_GT(green_count, width * height / 20);
}

TEST(HelloPlant, SaysWhatFailedOnAFileThatIsNoPlant) {
  expect_failure(run_process(kHelloPlant, {"/dev/null", "/dev/null"}), {"coppice_plant_open"});
}

TEST(CoppiceForest, HeadlessRunWritesPictureAndStatistics) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), cut_png = folder / "cut.png", full_png = folder / "full.png", json = folder / "stats.json";
  const ProcessResult cut = run_process(kForest, headless_forest(plant, cut_png, {"--stats", json, "--pass-times"}));
  ASSERT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_TRUE(mentions(cut.out, {cut_png.string()}));

  const auto stats = read_json(json);
  const Table table = table_of_statistics();
  std::set<std::string> keys = keys_of(stats), streamed = keys_of(stats["streamed"]), passes = spans_of_row(table, "pass_ms");
  keys.insert("scene");  // with --scene
  EXPECT_EQ(keys, column_spans(table, 0));
  EXPECT_EQ(keys_of(stats["frame_ms"]), spans_of_row(table, "frame_ms"));
  streamed.merge(keys_of(stats["streamed"]["pages"]));
  EXPECT_EQ(streamed, spans_of_row(table, "streamed"));
  for (const char* other : {"--pass-times", "coppice_record_draw"}) passes.erase(other);
  EXPECT_EQ(keys_of(stats["pass_ms"]), passes);
  EXPECT_EQ(stats["instances"], 40);
  EXPECT_EQ(stats["source_leaves_in_scene"], 40 * 386);
  EXPECT_EQ(stats["validation_messages"], 0);
  EXPECT_GE(stats["threshold_px_max"], stats["threshold_px_median"]);
  EXPECT_GT(stats["visible_instances_median"], 0);
  for (const char* pass : {"upload", "cull", "splats", "leaves", "tiles", "draw", "ground", "tufts", "sky", "tone_map"})
    EXPECT_GT(stats["pass_ms"][pass], 0) << pass;
  EXPECT_LE(stats["memory_peak_bytes"], stats["memory_budget_bytes"]);

  const ProcessResult full = run_process(kForest, headless_forest(plant, full_png, {"--lod", "full"}));
  ASSERT_EQ(full.exit_code, 0) << full.err;
  const Picture cut_picture = read_png(cut_png), full_picture = read_png(full_png);
  ASSERT_EQ(cut_picture.rgba.size(), full_picture.rgba.size());
  EXPECT_LT(rmse(cut_picture, full_picture), 25.0) << "of 255: the cut must look like the whole";
}

TEST(CoppiceForest, OnePlantIsInEveryPictureOfItsTurn) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), frames = folder / "frames", png = folder / "last.png", json = folder / "stats.json";
  for (const char* camera : {"turntable", "front", "top"}) {
    const Words moved = std::string(camera) != "turntable" ? Words{"--camera", camera} : Words{};
    const ProcessResult run = run_process(kForest, joined({plant, "--headless", "--size", "160x160", "--frames", "5", "--no-taa",
                                                           "--no-shadows", "--record", frames, "--screenshot", png, "--stats", json},
                                                          moved));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(read_json(json)["instances"], 1);
    for (const char* name : {"00000.png", "00001.png", "00002.png", "00003.png", "00004.png"}) {
      const Picture picture = read_png(frames / name);
      // Its middle third is leaves, or what shows between them.
      std::size_t dark_count = 0;
      for (std::uint32_t y = 53; y < 107; ++y)
        for (std::uint32_t x = 53; x < 107; ++x) {
          const std::uint8_t* rgb = &picture.rgba[4 * (y * picture.width_px + x)];
          dark_count += rgb[2] < 110 && is_green(rgb);
        }
      EXPECT_GT(dark_count, 54u * 54u / 4) << camera << " " << name;
    }
  }
}

TEST(CoppiceForest, TakesAFolderOfPlantsAndSaysWhichItScales) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder, {"--unit", "cm"});
  fs::rename(bake_corylus(folder), folder / "a_hazel.coppice");
  bake_corylus(folder, {"--unit", "cm"});
  const ProcessResult run =
      run_process(kForest, {"--plants", folder.path(), "--headless", "--count", "20", "--size", "64x64", "--frames", "1"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(mentions(run.out, {"20", "2"}));
  EXPECT_EQ(lines_that_name(run.out, plant.string()), 1u) << run.out;
  EXPECT_EQ(lines_that_name(run.out, (folder / "a_hazel.coppice").string()), 0u) << run.out;
  EXPECT_NE(run.out.find(plant.string() + ": 0.0"), std::string::npos) << run.out;
}

TEST(CoppiceView, BakesOnceAndShowsThePlant) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "hazel.glb", png = folder / "hazel.png";
  ASSERT_EQ(run_tool({"plant", "corylus", "-o", plant}).exit_code, 0);
  const ProcessOptions options{.environment = {"XDG_CACHE_HOME=" + folder.path().string()}};
  const Words view{"view",         plant, "--resolution", "64",       "--headless", "--camera", "front",
                   "--screenshot", png,   "--",           "--frames", "1",          "--size",   "64x48"};
  const ProcessResult first = run_tool(view, options);
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_TRUE(mentions(first.out, {"hazel.glb", "baked", (folder / "coppice").string()}));
  EXPECT_EQ(read_png(png).width_px, 64u);
  const ProcessResult second = run_tool(view, options);
  EXPECT_TRUE(mentions(second.out, {"hazel.glb", "cached", (folder / "coppice").string()}));
}

TEST(CoppiceView, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const fs::path alone = folder / "coppice";
  fs::copy(kTool, alone);
  expect_failure(run_process(alone, {"view", "x.glb"}, {.environment = {"PATH=/nowhere"}}), {"coppice-forest", "PATH"});
  expect_failure(run_tool({"view", folder / "x.glb"}), {"x.glb"});
}

TEST(CoppiceForest, StreamsAScene) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), scene = folder / "wood.forest", png = folder / "scene.png", json = folder / "stats.json";
  const ProcessResult made = run_tool({"scene", "-o", scene, "--plants", plant, "--size-m", "600", "--count", "20000"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const ProcessResult run = run_process(kForest, {"--scene", scene, "--most-instances", "3000", "--size", "320x180", "--frames", "2",
                                                  "--headless", "--validation", "--screenshot", png, "--stats", json});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(mentions(run.out, {"20000"}));
  const auto stats = read_json(json);
  EXPECT_EQ(stats["validation_messages"], 0);
  std::set<std::string> keys = keys_of(stats["scene"]);
  keys.insert("--scene");
  EXPECT_EQ(keys, spans_of_row(table_of_statistics(), "scene"));
  EXPECT_EQ(stats["scene"]["instances"], 20000);
  EXPECT_EQ(stats["scene"]["tiles_missing"], 0);
  EXPECT_GT(stats["scene"]["tiles_resident"], 0);
  EXPECT_GT(stats["visible_instances_median"], 0);
  EXPECT_GT(stats["first_picture_ms"], 0);
  const Picture picture = read_png(png);
  EXPECT_GT(share_of(picture, is_green), 0.02);

  expect_failure(run_process(kForest, {"--scene", "/nowhere/a.forest", "--headless"}), {"/nowhere/a.forest"});
  EXPECT_EQ(run_process(kForest, {"--scene", scene, "--count", "5"}).exit_code, 2) << "either";
}

TEST(CoppiceForest, TracesReadsDecodesUploadsAndFrames) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), json = folder / "trace.json";
  const ProcessResult result = run_process(kForest, headless_forest(plant, folder / "cut.png", {"--trace", json, "--watch"}));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto trace = read_json(json);
  std::map<std::string, int> counts;
  std::map<int, double> open_reads;
  double reading_us = 0;
  for (const auto& event : trace["traceEvents"]) {
    ++counts[event["cat"]];
    EXPECT_GT(event["ts"], 0);
    if (event["ph"] == "b") open_reads[event["id"]] = event["ts"];
    EXPECT_TRUE(event["ph"] != "X" || event["dur"] >= 0);
    if (event["ph"] != "e") continue;
    ASSERT_TRUE(open_reads.contains(event["id"]));
    EXPECT_GE(event["ts"], open_reads[event["id"]]);
    reading_us += event["ts"].get<double>() - open_reads[event["id"]];
    open_reads.erase(event["id"]);
  }
  EXPECT_TRUE(open_reads.empty());
  EXPECT_GT(reading_us, 0);
  EXPECT_GE(counts["read"], 2) << "the texture, from the request to the bytes";
  for (const char* kind : {"decode", "upload"}) EXPECT_GE(counts[kind], 1) << kind;
  for (const char* call : {"coppice_frame_begin", "coppice_record_upload", "coppice_record_cull", "coppice_record_draw"})
    EXPECT_GE(counts[call], 6) << call;
}

/// Pictures of headless_forest's forest from one place, with further options. keyframe: a line of a keyframe file
class StillForest {
 public:
  explicit StillForest(const char* keyframe) : plant_(bake_corylus(folder_)) {
    write_text(folder_ / "still.txt", std::string(keyframe) + "\n");
  }

  [[nodiscard]] Picture picture_with(const Words& options) const {
    const fs::path png = folder_ / "still.png";
    run_without_messages(headless_forest(plant_, png, joined({"--camera", folder_ / "still.txt"}, options)), folder_ / "messages.json");
    return read_png(png);
  }

 private:
  TemporaryFolder folder_;
  fs::path plant_;
};

TEST(CoppiceForest, TemporalAntialiasingOfAStillViewBeatsFourSamples) {
  const StillForest forest("0 0 1.7 20 0 0");
  const auto picture_with = [&](const Words& options) { return forest.picture_with(joined({"--no-shadows"}, options)); };
  const Picture reference = picture_with({"--supersample", "8"}), four = picture_with({"--supersample", "2"}),
                one = picture_with({"--no-taa"}), temporal = picture_with({"--taa", "--render-scale", "1"});
  EXPECT_LT(rmse(temporal, reference), 0.8 * rmse(four, reference));
  EXPECT_LT(rmse(four, reference), 0.8 * rmse(one, reference)) << "else the pictures do not show what samples do";
  // A quarter of the pixels, enlarged: what one frame lacks comes back over several. The threshold is in pixels that are drawn.
  const Picture small = picture_with({"--no-taa", "--render-scale", "0.5", "--error-px", "1"}),
                enlarged = picture_with({"--taa", "--render-scale", "0.5", "--error-px", "1"});
  EXPECT_LT(rmse(enlarged, reference), 0.7 * rmse(small, reference));
  EXPECT_LT(rmse(enlarged, reference), 0.9 * rmse(one, reference));
}

// It has 0.42 of one frame's error here; blended by depth and cameras alone, and not by how leaves have moved, it has 0.51.
TEST(CoppiceForest, TemporalAntialiasingFollowsLeavesInWind) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder);
  write_text(folder / "camera.txt", "0 0 2 4 0 0\n0.5 0 2 4 0 0\n");
  const auto picture_with = [&](const Words& options, const fs::path& picture) {
    const Words arguments =
        joined({"--plants", plant, "--count", "1", "--camera", folder / "camera.txt", "--size", "320x180", "--wind", "12.0", "--fog", "0",
                "--headless", "--render-scale", "1", "--frames", "31", "--no-shadows", "--validation"},
               options);
    run_without_messages(arguments, folder / "messages.json");
    return read_png(picture);
  };
  const fs::path still = folder / "still.png", frames = folder / "frames";
  const Picture reference = picture_with({"--supersample", "8", "--screenshot", still}, still),
                one = picture_with({"--no-taa", "--screenshot", still}, still);
  fs::create_directory(frames);
  const Picture temporal = picture_with({"--taa", "--record", frames}, frames / "00030.png");
  EXPECT_LT(rmse(temporal, reference), 0.46 * rmse(one, reference));
}

TEST(CoppiceForest, LightsPlantsItselfAboutAsTheLibraryDoes) {
  const StillForest forest("0 0 1.7 20 0 0");
  const Picture deferred = forest.picture_with({}), forward = forest.picture_with({"--renderer", "forward"});
  EXPECT_GT(rmse(deferred, forward), 1.0) << "light between crowns, gloss, air";
  EXPECT_LT(rmse(deferred, forward), 25.0);
}

TEST(CoppiceForest, TwoCamerasOrTwoEyesAreSideBySide) {
  const StillForest forest("0 0 6 1.8 0 0");
  const auto halves_with = [&](const char* option) {
    const Picture picture = forest.picture_with({option});
    EXPECT_EQ(picture.width_px, 320u);
    return std::array{half_of(picture, 0), half_of(picture, 1)};
  };
  const auto split = halves_with("--split"), stereo = halves_with("--stereo");
  EXPECT_LT(rmse(stereo[0], split[0]), 0.5 * rmse(split[0], split[1])) << "the left one looks the same way";
  EXPECT_LT(rmse(stereo[0], stereo[1]), 0.7 * rmse(split[0], split[1])) << "eyes see nearly the same";
  EXPECT_GT(rmse(stereo[0], stereo[1]), 1.0);
}

TEST(CoppiceForest, PlantsCastShadowsOnTheGround) {
  const StillForest forest("0 0 6 8 0 -35");
  const Picture with = forest.picture_with({"--shadows"}), without = forest.picture_with({"--no-shadows"});
  ASSERT_EQ(with.rgba.size(), without.rgba.size());
  // Plants shade themselves alike with maps and without; what gets darker is ground.
  std::size_t darker = 0;
  for (std::size_t i = 0; i < with.rgba.size(); i += 4)
    darker += with.rgba[i] + 25 < without.rgba[i] && with.rgba[i + 1] + 25 < without.rgba[i + 1];
  EXPECT_GT(darker, with.rgba.size() / 4 / 400);
  EXPECT_LT(darker, with.rgba.size() / 4 / 4);
}

TEST(CoppiceForest, ComparesCutsWithDiscreteLevelsAndFullDetail) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), json = folder / "compared.json";
  const ProcessResult result = run_process(
      kForest, {"--plants", plant, "--count", "20", "--size", "128x72", "--frames", "1", "--no-shadows", "--wind", "8", "--compare", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(fs::exists(folder / "compared.svg"));
  const auto compared = read_json(json);
  const auto& modes = compared["modes"];
  ASSERT_EQ(modes.size(), 7u);
  const Table table = table_after(source_text("demo/README.md"), "`coppice-forest --compare F.json`");
  std::set<std::string> keys = keys_of(compared), told = column_spans(table, 0);
  keys.merge(keys_of(modes[0]));
  told.insert({"lod", "error_px"});  // in the row of modes
  EXPECT_EQ(keys, told);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const auto& mode = modes[i];
    EXPECT_EQ(mode["lod"], i < 3 ? "cut" : i < 6 ? "discrete" : "full");
    const bool full = i == 6;
    EXPECT_EQ(mode["rmse"] == 0.0, full);
    EXPECT_EQ(mode["popping_mean"] == 0.0, full);
    EXPECT_LE(mode["popping_mean"], mode["popping_max"]);
    EXPECT_EQ(mode["wind_popping_mean"] == 0.0, full);
    EXPECT_LE(mode["wind_popping_mean"], mode["wind_popping_max"]);
    EXPECT_EQ(mode["wind_popping_mean"] == mode["popping_mean"], full) << "plants move";
    // With the cuts of an eye beside it the picture stays where it is: moved, it would differ by more than its steady error.
    EXPECT_LE(mode["switching_rmse"], mode["rmse"]);
  }
}

TEST(CoppiceForest, DebugViewsColourPlantsByWhatDrawsThem) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), png = folder / "view.png";
  // Colours of the path view, as they are after tone mapping: compute shaders' leaves, quads by the hardware.
  const auto share_with = [&](const Words& options, const auto& is_colour) {
    // Colours as they are, on any device.
    run_without_messages(headless_forest(plant, png, joined({"--no-taa", "--no-shadows"}, options)), folder / "messages.json");
    return share_of(read_png(png), is_colour);
  };
  const auto is_compute = [](const std::uint8_t* rgb) { return rgb[1] > 180 && rgb[0] < 120 && rgb[2] < 120; };
  const auto is_hardware = [](const std::uint8_t* rgb) { return rgb[0] > 180 && rgb[1] > 120 && rgb[2] < 100; };
  const auto is_blue = [](const std::uint8_t* rgb) { return rgb[2] > 180 && rgb[0] < 80 && rgb[1] < 80; };
  EXPECT_GT(share_with({"--view", "path"}, is_compute), 0.02);
  EXPECT_GT(share_with({"--view", "path", "--path", "hardware"}, is_hardware), 0.005);
  EXPECT_LT(share_with({"--view", "none"}, is_compute), 0.001);
  EXPECT_GT(share_with({"--view", "residency"}, is_blue), 0.02) << "everything is resident";
  EXPECT_GT(share_with({"--view", "occlusion"}, is_blue), 0.02) << "the first round";
  EXPECT_GT(share_with({"--view", "overdraw"}, is_blue), 0.005) << "leaves before nothing";
  EXPECT_LT(share_with({"--view", "lod", "--lod", "full"}, is_blue), 0.001) << "every leaf";
  EXPECT_LT(share_with({"--view", "error", "--error-px", "100"}, is_blue), 0.02) << "a large error";
}

TEST(CoppiceForest, ErrorsAreOneLineAndTheRightExitCode) {
  expect_failure(run_process(kForest, {"--plants", "/nowhere/fern.coppice", "--headless"}), {"/nowhere/fern.coppice"});
  EXPECT_EQ(run_process(kForest, {"--size", "wide"}).exit_code, 2);
  const ProcessResult slip = run_process(kForest, {"--screenshoot", "x.png"});
  EXPECT_EQ(slip.exit_code, 2);
  EXPECT_TRUE(mentions(slip.err.substr(0, slip.err.find('\n')), {"--screenshoot", "--screenshot"}));
  EXPECT_EQ(run_process(kForest, {"--help"}).exit_code, 0);
}

}  // namespace coppice::test::demo_test
