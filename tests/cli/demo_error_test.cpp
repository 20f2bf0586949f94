// What coppice-forest says, and how it exits, when something is missing, damaged or cannot be written.

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "baked_corylus.h"
#include "mentions.h"
#include "places.h"
#include "process.h"

namespace demo_error_test {

namespace fs = std::filesystem;
using coppice::test::bake_corylus;
using coppice::test::lines_that_name;
using coppice::test::mentions;
using coppice::test::ProcessResult;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

std::vector<std::string> small_forest(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"--size", "160x90", "--frames", "2", "--headless", "--no-shadows", "--no-taa"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// Through a shell, for what is set round a program: variables, where its output goes.
ProcessResult run_in_shell(const std::string& before, const std::vector<std::string>& arguments, const std::string& after) {
  std::string line = before + " " + coppice::test::kForest;
  for (const std::string& argument : arguments) line += " '" + argument + "'";
  return run_process("/bin/sh", {"-c", line + " " + after});
}

/// A scene of the plant, in its folder.
fs::path scene_of(const fs::path& plant, const TemporaryFolder& folder) {
  fs::path scene = folder / "wood.forest";
  const ProcessResult made =
      run_process(coppice::test::kTool, {"scene", "-o", scene, "--plants", plant, "--size-m", "200", "--count", "500"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return scene;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count(text, '\n'));
}

TEST(CoppiceForestErrors, AGpuThatTakesTooLongIsGivenUp) {
  const ProcessResult run = run_process(
      coppice::test::kForest, small_forest({"--gpu-wait-s", "0.001", std::string(coppice::test::kTestData) + "/plants/two_pages.coppice"}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(mentions(run.err, {"0.001 s", "device:", "--gpu-wait-s"}));
}

TEST(CoppiceForestErrors, ASpeciesThatIsNotThereIsSaidOnceAndFailsTheRun) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), scene = scene_of(plant, folder), json = folder / "stats.json";
  fs::remove(plant);
  const ProcessResult run = run_process(coppice::test::kForest, small_forest({"--scene", scene, "--stats", json}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(count_of(run.err, "corylus.coppice"), 1u) << run.err;
  EXPECT_TRUE(mentions(run.err, {"--ignore-errors"}));
  std::ifstream file(json);
  EXPECT_EQ(nlohmann::json::parse(file)["errors"], 1);
  EXPECT_EQ(run_process(coppice::test::kForest, small_forest({"--scene", scene, "--ignore-errors"})).exit_code, 0);
}

TEST(CoppiceForestErrors, ASpeciesOutsideTheScenesFolderIsLeftOutUnlessAllowed) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder), scene = scene_of(plant, folder), inner = folder / "inner";
  fs::create_directory(inner);
  fs::rename(scene, inner / "wood.forest");
  fs::create_symlink(plant, inner / "corylus.coppice");
  const fs::path json = folder / "stats.json";
  const ProcessResult run = run_process(coppice::test::kForest, small_forest({"--scene", inner / "wood.forest", "--stats", json}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(lines_that_name(run.err, "corylus.coppice"), 1u) << run.err;
  std::ifstream file(json);
  EXPECT_EQ(nlohmann::json::parse(file)["scene"]["species_failed"], 1);
  EXPECT_EQ(run_process(coppice::test::kForest, small_forest({"--scene", inner / "wood.forest", "--allow-outside"})).exit_code, 0);
}

TEST(CoppiceForestErrors, APlantThatIsNotBakedIsToldHowToBakeIt) {
  const TemporaryFolder folder;
  for (const auto& [path, advice] : {std::pair<std::string, std::string>{"oak.GLB", "coppice view oak.GLB"},
                                     {"oak.glb", "coppice bake oak.glb -o oak.coppice"},
                                     {"wood.forest", "coppice-forest --scene wood.forest"},
                                     {folder.path(), "coppice bake-all " + folder.path().string()}})
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--plants", path}, {path}}) {
      const ProcessResult run = run_process(coppice::test::kForest, small_forest(arguments));
      EXPECT_EQ(run.exit_code, 1) << path;
      EXPECT_EQ(line_count(run.err), 1u) << run.err;
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
  const ProcessResult run = run_process(coppice::test::kForest, small_forest({"--plants", plant, "--count", "5", "--error-px", "0.01"}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(count_of(run.err, "corylus.coppice"), 1u) << run.err;
  EXPECT_EQ(line_count(run.err), 2u) << run.err;
}

TEST(CoppiceForestErrors, OutputsThatCannotBeWrittenAreRefusedFirst) {
  const TemporaryFolder folder;
  for (const char* option : {"--screenshot", "--stats", "--trace", "--compare", "--record"}) {
    const ProcessResult run =
        run_process(coppice::test::kForest, {"--headless", "--plants", "/nowhere.coppice", option, "/dev/null/picture"});
    EXPECT_EQ(run.exit_code, 1) << option;
    EXPECT_TRUE(mentions(run.err, {option, "/dev/null/picture"}));
    EXPECT_EQ(run.err.find("nowhere"), std::string::npos) << "before anything is opened: " << run.err;
    EXPECT_EQ(line_count(run.err), 1u) << run.err;
  }
}

TEST(CoppiceForestErrors, OutputsThatFillTheDiskAndCamerasThatAreNoFilesFailTheRun) {
  const TemporaryFolder folder;
  const fs::path plant = bake_corylus(folder);
  for (const char* option : {"--screenshot", "--stats", "--trace"}) {
    const ProcessResult run = run_process(coppice::test::kForest, small_forest({"--plants", plant, "--count", "5", option, "/dev/full"}));
    EXPECT_EQ(run.exit_code, 1) << option;
    EXPECT_TRUE(mentions(run.err, {"/dev/full", std::strerror(ENOSPC)}));
  }
  const ProcessResult table = run_in_shell("", small_forest({"--plants", plant, "--count", "5"}), "> /dev/full");
  EXPECT_EQ(table.exit_code, 1);
  EXPECT_TRUE(mentions(table.err, {std::strerror(ENOSPC)}));
  EXPECT_EQ(run_in_shell("", {"--help"}, "> /dev/full").exit_code, 1);

  const ProcessResult camera =
      run_process(coppice::test::kForest, small_forest({"--plants", plant, "--count", "5", "--camera", folder.path()}));
  EXPECT_EQ(camera.exit_code, 1);
  EXPECT_TRUE(mentions(camera.err, {folder.path().string()}));
}

TEST(CoppiceForestErrors, WithoutADriverItSaysWhatToInstallOrSet) {
  const ProcessResult run =
      run_in_shell("VK_DRIVER_FILES=/nowhere.json VK_ICD_FILENAMES=/nowhere.json", {"--headless", "--plants", "x.coppice"}, "");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(mentions(run.err, {"Vulkan", "VK_DRIVER_FILES=/nowhere.json", "mesa-vulkan-drivers"}));
}

}  // namespace demo_error_test
