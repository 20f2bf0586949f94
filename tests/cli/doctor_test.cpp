// What coppice-forest --doctor finds on drivers that draw, on one that fails, and without any.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "mentions.h"
#include "places.h"
#include "process.h"

namespace doctor_test {

using coppice::test::mentions;
using coppice::test::ProcessResult;
using coppice::test::run_process;
using coppice::test::TemporaryFolder;

/// With a device that fails as support/faulty_device.c says.
ProcessResult run_with_faults(const std::string& faults, const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  std::ofstream(folder / "faulty_device.json")
      << R"({"file_format_version": "1.1.2", "layer": {"name": "VK_LAYER_COPPICE_faulty_device", "type": "INSTANCE", "library_path": ")"
      << coppice::test::kFaultyDeviceLibrary
      << R"(", "api_version": "1.3.0", "implementation_version": "1", "description": "fails on purpose"}})";
  return run_process(coppice::test::kForest, arguments,
                     {.environment = {"VK_LAYER_PATH=" + folder.path().string(), "VK_INSTANCE_LAYERS=VK_LAYER_COPPICE_faulty_device",
                                      "COPPICE_FAULTS=" + faults}});
}

/// The verdict on a trial, as the report at the end has it; empty: it was not tried.
std::string verdict(const ProcessResult& result, const std::string& trial) {
  std::istringstream lines(result.out.substr(result.out.find("----")));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name, verdict;
    if (words >> name >> verdict && name == trial) return verdict;
  }
  return "";
}

/// But for the last one, which is the program itself, each is a trial of trial.h.
constexpr const char* kTrials[] = {"device", "uploads", "selection", "hardware", "leaves", "splats", "surfaces", "shadow_map", "forest"};

/// All well. How fast, depends on the machine.
void expect_well(const ProcessResult& result, const std::string& driver) {
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  for (const char* trial : kTrials) {
    const std::string found = verdict(result, trial);
    EXPECT_TRUE(found == "ok" || found == "slow") << trial << ": " << result.out;
  }
  EXPECT_TRUE(mentions(result.out, {driver, "drawIndirectCount", "maxTexelBufferElements"}));
  EXPECT_EQ(result.err, "");
}

TEST(Doctor, IsContentWithTheFirstDriver) {
  expect_well(run_process(coppice::test::kForest, {"--doctor", "--doctor-limit-s", "600"}), "llvmpipe");
}

TEST(Doctor, IsContentWithASecondDriver) {
  if (std::string(coppice::test::kSwiftShader).ends_with("NOTFOUND")) GTEST_SKIP() << "no SwiftShader: Debian has it in chromium-common";
  expect_well(run_process(coppice::test::kForest, {"--doctor", "--doctor-limit-s", "600"},
                          {.environment = {std::string("VK_DRIVER_FILES=") + coppice::test::kSwiftShader}}),
              "SwiftShader");
}

TEST(Doctor, SaysWhatToInstallWithoutADriver) {
  const ProcessResult result =
      run_process(coppice::test::kForest, {"--doctor"}, {.environment = {"VK_DRIVER_FILES=/nonexistent", "VK_ICD_FILENAMES=/nonexistent"}});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(verdict(result, "device"), "fails");
  EXPECT_EQ(verdict(result, "uploads"), "");
  EXPECT_TRUE(mentions(result.out, {"/nonexistent", "mesa-vulkan-drivers"}));
}

TEST(Doctor, SaysWhatToInstallWithoutALoader) {
  const ProcessResult result =
      run_process(coppice::test::kForest, {"--doctor"}, {.environment = {std::string("LD_PRELOAD=") + coppice::test::kNoVulkanLibrary}});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(mentions(result.out, {"fails", "libvulkan1"}));
}

TEST(Doctor, RefusesWhatItWouldIgnore) {
  const ProcessResult result = run_process(coppice::test::kForest, {"--doctor", "--path", "hardware"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(mentions(result.err, {"--doctor", "--path"}));
}

TEST(Doctor, NamesADeviceThatHangs) {
  const ProcessResult result = run_with_faults("hang device", {"--doctor", "--doctor-limit-s", "0.5"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(verdict(result, "device"), "hangs");
  EXPECT_TRUE(mentions(result.out, {"0.5 s", "copying to the GPU and back"}));
}

TEST(Doctor, NamesADeviceThatCopiesWrongly) {
  const ProcessResult result = run_with_faults("wrong device", {"--doctor", "--doctor-limit-s", "600"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(verdict(result, "device"), "wrong");
}

TEST(Doctor, NamesADeviceThatIsLost) {
  const ProcessResult result = run_with_faults("lost device", {"--doctor", "--doctor-limit-s", "600"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(verdict(result, "device"), "fails");
  EXPECT_TRUE(mentions(result.out, {"vkQueueSubmit2", "device was lost"}));
}

TEST(Doctor, GoesOnAfterATrialThatHangsOrFailsOrIsWrong) {
  const ProcessResult result =
      run_with_faults("lost uploads;wrong leaves;hang splats;wrong shadow_map", {"--doctor", "--doctor-limit-s", "60"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(verdict(result, "uploads"), "fails");
  EXPECT_EQ(verdict(result, "leaves"), "wrong");
  EXPECT_EQ(verdict(result, "splats"), "hangs");
  EXPECT_EQ(verdict(result, "shadow_map"), "wrong");
  for (const char* trial : {"device", "selection", "hardware", "surfaces", "forest"}) {
    const std::string found = verdict(result, trial);
    EXPECT_TRUE(found == "ok" || found == "slow") << trial << ": " << result.out;
  }
}

/// Copies, or frames alone, never end.
TEST(Doctor, OfItsOwnAccordTheForestGivesUpADeviceThatHangs) {
  for (const auto& [fault, waited_for] : {std::pair<std::string, std::string>{"hang", "a copy"}, {"stop", "frame 1"}}) {
    const ProcessResult result =
        run_with_faults(fault + " --headless", {"--headless", "--frames", "1", "--size", "64x64", "--gpu-wait-s", "0.5",
                                                std::string(coppice::test::kTestData) + "/plants/two_pages.coppice"});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(mentions(result.err, {waited_for, "0.5 s", "device:", "--doctor"}));
    EXPECT_EQ(result.err.find("pipelines:") != std::string::npos, fault == "stop") << "copies come before the library: " << result.err;
  }
}

class DoctorTrial : public testing::TestWithParam<const char*> {};

/// What a trial prints for its parent, and not a line of the layer.
TEST_P(DoctorTrial, MakesNoValidationMessage) {
  const ProcessResult result =
      run_process(coppice::test::kForest, {"--doctor-trial", GetParam(), "600"},
                  {.environment = {"VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation",
                                   "VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT"}});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(line.starts_with("at ") || line.starts_with("say ") || line.starts_with("result ")) << line;
}

INSTANTIATE_TEST_SUITE_P(Trials, DoctorTrial, testing::ValuesIn(kTrials, std::end(kTrials) - 1),
                         [](const testing::TestParamInfo<const char*>& trial) { return std::string(trial.param); });

}  // namespace doctor_test
