// What coppice-forest says, and how it exits, when something is missing, damaged or cannot be written.

#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "baked_corylus.h"
#include "tool.h"

namespace coppice::test::demo_error_test {

namespace fs = std::filesystem;

/// Draws two small frames without a window, with further options.
ProcessResult draw(const Words& more, const ProcessOptions& options = {}) {
  return run_process(kForest, joined({"--size", "160x90", "--frames", "2", "--headless", "--no-shadows", "--no-taa"}, more), options);
}

/// A scene of the plant, in its folder.
fs::path scene_of(const fs::path& plant, const TemporaryFolder& folder) {
  fs::path scene = folder / "wood.forest";
  const ProcessResult made = run_tool({"scene", "-o", scene, "--plants", plant, "--size-m", "200", "--count", "500"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return scene;
}

TEST(CoppiceForestErrors, AGpuThatTakesTooLongIsGivenUp) {
  expect_failure(draw({"--gpu-wait-s", "0.001", std::string(kTestData) + "/plants/two_pages.coppice"}),
                 {"0.001 s", "device:", "--gpu-wait-s"});
}

TEST(CoppiceForestErrors, ASpeciesThatIsNotThereIsSaidOnceAndFailsTheRun) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), scene = scene_of(plant, folder), json = folder / "stats.json";
  fs::remove(plant);
  const ProcessResult run = draw({"--scene", scene, "--stats", json});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(count_of(run.err, "corylus.coppice"), 1u) << run.err;
  EXPECT_TRUE(mentions(run.err, {"--ignore-errors"}));
  EXPECT_EQ(read_json(json)["errors"], 1);
  EXPECT_EQ(draw({"--scene", scene, "--ignore-errors"}).exit_code, 0);
}

TEST(CoppiceForestErrors, ASpeciesOutsideTheScenesFolderIsLeftOutUnlessAllowed) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), scene = scene_of(plant, folder), inner = folder / "inner";
  fs::create_directory(inner);
  fs::rename(scene, inner / "wood.forest");
  fs::create_symlink(plant, inner / "corylus.coppice");
  const fs::path json = folder / "stats.json";
  const ProcessResult run = draw({"--scene", inner / "wood.forest", "--stats", json});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(lines_that_name(run.err, "corylus.coppice"), 1u) << run.err;
  EXPECT_EQ(read_json(json)["scene"]["species_failed"], 1);
  EXPECT_EQ(draw({"--scene", inner / "wood.forest", "--allow-outside"}).exit_code, 0);
}

TEST(CoppiceForestErrors, APlantThatIsNotBakedIsToldHowToBakeIt) {
  const TemporaryFolder folder;
  for (const auto& [path, advice] : {std::pair<std::string, std::string>{"oak.GLB", "coppice view oak.GLB"},
                                     {"oak.glb", "coppice bake oak.glb -o oak.coppice"},
                                     {"wood.forest", "coppice-forest --scene wood.forest"},
                                     {folder.path(), "coppice bake-all " + folder.path().string()}})
    for (const Words& arguments : {Words{"--plants", path}, {path}}) {
      const ProcessResult run = draw(arguments);
      EXPECT_EQ(run.exit_code, 1) << path;
      EXPECT_EQ(count_of(run.err, "\n"), 1u) << run.err;
      EXPECT_TRUE(mentions(run.err, {advice}));
    }
}

TEST(CoppiceForestErrors, ADamagedPageIsSaidOnceAndFailsTheRun) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder, {"--leaf-meshes", "off"});
  std::fstream file(plant, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(-1, std::ios::end);  // the finest of what streams
  file.put('\x55');
  file.close();
  const ProcessResult run = draw({"--plants", plant, "--count", "5", "--error-px", "0.01"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(count_of(run.err, "corylus.coppice"), 1u) << run.err;
  EXPECT_EQ(count_of(run.err, "\n"), 2u) << run.err;
}

TEST(CoppiceForestErrors, OutputsThatCannotBeWrittenAreRefusedFirst) {
  const TemporaryFolder folder;
  for (const char* option : {"--screenshot", "--stats", "--trace", "--compare", "--record"}) {
    const ProcessResult run = run_process(kForest, {"--headless", "--plants", "/nowhere.coppice", option, "/dev/null/picture"});
    EXPECT_EQ(run.exit_code, 1) << option;
    EXPECT_TRUE(mentions(run.err, {option, "/dev/null/picture"}));
    EXPECT_EQ(run.err.find("nowhere"), std::string::npos) << "before anything is opened: " << run.err;
    EXPECT_EQ(count_of(run.err, "\n"), 1u) << run.err;
    expect_failure(run_process(kForest, {"--headless", "--plants", "/nowhere.coppice", option, "/dev/full"}), {"/dev/full", option});
  }
}

TEST(CoppiceForestErrors, NoFileOfARunIsOverwritten) {
  const TemporaryFolder folder;
  const fs::path plant = folder / "plant.coppice", link = folder / "link", twice = folder / "twice", name = folder / "another name";
  write_text(plant, "a plant");
  fs::create_symlink("plant.coppice", link);
  fs::create_hard_link(plant, name);
  for (const Words& arguments : {Words{plant, "--stats", link},
                                 {plant, "--stats", name},
                                 {folder.path(), "--screenshot", plant},
                                 {"--scene", plant, "--trace", plant},
                                 {plant, "--camera", link, "--compare", plant},
                                 {plant, "--stats", twice, "--trace", twice}})
    expect_failure(run_process(kForest, joined({"--headless"}, arguments)), {arguments.back(), "overwritten"});
  EXPECT_EQ(read_text(plant), "a plant");
  const fs::path null = folder / "null";
  fs::create_symlink("/dev/null", null);
  expect_failure(run_process(kForest, {"--headless", "/nowhere.coppice", "--stats", "/dev/null", "--trace", null}), {"nowhere"});
  expect_failure(run_process(kForest, {"--headless", plant, "--stats", "."}), {"--stats", std::strerror(EISDIR)});
}

TEST(CoppiceForestErrors, AStandardOutputThatIsFullAndCamerasThatAreNoFilesFailTheRun) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder);
  expect_failure(draw({"--plants", plant, "--count", "5"}, {.out = "/dev/full"}), {std::strerror(ENOSPC)});
  EXPECT_EQ(run_process(kForest, {"--help"}, {.out = "/dev/full"}).exit_code, 1);

  expect_failure(draw({"--plants", plant, "--count", "5", "--camera", folder.path()}), {folder.path().string()});
}

TEST(CoppiceForestErrors, WithoutADriverItSaysWhatToInstallOrSet) {
  expect_failure(run_process(kForest, {"--headless", "--plants", "x.coppice"},
                             {.environment = {"VK_DRIVER_FILES=/nowhere.json", "VK_ICD_FILENAMES=/nowhere.json"}}),
                 {"Vulkan", "VK_DRIVER_FILES=/nowhere.json", "mesa-vulkan-drivers"});
}

}  // namespace coppice::test::demo_error_test
