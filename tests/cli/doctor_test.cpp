// What coppice-forest --doctor finds on drivers that draw, on one that fails, and without any.

#include <gtest/gtest.h>

#include <iterator>
#include <sstream>
#include <string>
#include <utility>

#include "tool.h"

namespace coppice::test::doctor_test {

ProcessResult doctor(const Words& more, const ProcessOptions& options = {}) {
  return run_process(kForest, joined({"--doctor"}, more), options);
}

/// With a device that fails as support/faulty_device.c says.
ProcessResult run_with_faults(const std::string& faults, const Words& arguments) {
  const TemporaryFolder folder;
  write_text(
      folder / "faulty_device.json",
      R"({"file_format_version": "1.1.2", "layer": {"name": "VK_LAYER_COPPICE_faulty_device", "type": "INSTANCE", "library_path": ")" +
          std::string(kFaultyDeviceLibrary) +
          R"(", "api_version": "1.3.0", "implementation_version": "1", "description": "fails on purpose"}})");
  return run_process(kForest, arguments,
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
void expect_well(const ProcessResult& result, const std::string& trial) {
  const std::string found = verdict(result, trial);
  EXPECT_TRUE(found == "ok" || found == "slow") << trial << ": " << result.out;
}

void expect_content(const ProcessOptions& options, const std::string& driver) {
  const ProcessResult result = doctor({"--doctor-limit-s", "600"}, options);
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  for (const char* trial : kTrials) expect_well(result, trial);
  EXPECT_TRUE(mentions(result.out, {driver, "drawIndirectCount", "maxTexelBufferElements"}));
  EXPECT_EQ(result.err, "");
}

TEST(Doctor, IsContentWithTheFirstDriver) {
  expect_content({}, "llvmpipe");
}

TEST(Doctor, IsContentWithASecondDriver) {
  if (std::string(kSwiftShader).ends_with("NOTFOUND")) GTEST_SKIP() << "no SwiftShader: Debian has it in chromium-common";
  expect_content({.environment = {std::string("VK_DRIVER_FILES=") + kSwiftShader}}, "SwiftShader");
}

TEST(Doctor, SaysWhatToInstallWithoutADriverOrALoader) {
  const ProcessResult driver = doctor({}, {.environment = {"VK_DRIVER_FILES=/nonexistent", "VK_ICD_FILENAMES=/nonexistent"}});
  EXPECT_EQ(driver.exit_code, 1);
  EXPECT_EQ(verdict(driver, "device"), "fails");
  EXPECT_EQ(verdict(driver, "uploads"), "");
  EXPECT_TRUE(mentions(driver.out, {"/nonexistent", "mesa-vulkan-drivers"}));
  const ProcessResult loader = doctor({}, {.environment = {std::string("LD_PRELOAD=") + kNoVulkanLibrary}});
  EXPECT_EQ(loader.exit_code, 1);
  EXPECT_TRUE(mentions(loader.out, {"fails", "libvulkan1"}));
}

TEST(Doctor, RefusesWhatItWouldIgnore) {
  expect_failure(doctor({"--path", "hardware"}), {"--doctor", "--path"}, 2);
}

TEST(Doctor, NamesADeviceThatHangsCopiesWronglyOrIsLost) {
  struct Fault {
    const char *fault, *limit_s, *verdict;
    Words names;
  };
  for (const Fault& fault : {Fault{"hang device", "0.5", "hangs", {"0.5 s", "copying to the GPU and back"}},
                             {"wrong device", "600", "wrong", {}},
                             {"lost device", "600", "fails", {"vkQueueSubmit2", "device was lost"}}}) {
    const ProcessResult result = run_with_faults(fault.fault, {"--doctor", "--doctor-limit-s", fault.limit_s});
    EXPECT_EQ(result.exit_code, 1) << fault.fault;
    EXPECT_EQ(verdict(result, "device"), fault.verdict);
    for (const std::string& name : fault.names) EXPECT_TRUE(mentions(result.out, {name}));
  }
}

TEST(Doctor, GoesOnAfterATrialThatHangsOrFailsOrIsWrong) {
  const ProcessResult result =
      run_with_faults("lost uploads;wrong leaves;hang splats;wrong shadow_map", {"--doctor", "--doctor-limit-s", "60"});
  EXPECT_EQ(result.exit_code, 1);
  for (const auto& [trial, found] : {std::pair{"uploads", "fails"}, {"leaves", "wrong"}, {"splats", "hangs"}, {"shadow_map", "wrong"}})
    EXPECT_EQ(verdict(result, trial), found) << trial;
  for (const char* trial : {"device", "selection", "hardware", "surfaces", "forest"}) expect_well(result, trial);
}

/// Copies, or frames alone, never end.
TEST(Doctor, OfItsOwnAccordTheForestGivesUpADeviceThatHangs) {
  for (const auto& [fault, waited_for] : {std::pair<std::string, std::string>{"hang", "a copy"}, {"stop", "frame 1"}}) {
    const ProcessResult result = run_with_faults(fault + " --headless", {"--headless", "--frames", "1", "--size", "64x64", "--gpu-wait-s",
                                                                         "0.5", std::string(kTestData) + "/plants/two_pages.coppice"});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(mentions(result.err, {waited_for, "0.5 s", "device:", "--doctor"}));
    EXPECT_EQ(result.err.find("pipelines:") != std::string::npos, fault == "stop") << "copies come before the library: " << result.err;
  }
}

class DoctorTrial : public testing::TestWithParam<const char*> {};

/// What a trial prints for its parent, and not a line of the layer.
TEST_P(DoctorTrial, MakesNoValidationMessage) {
  const ProcessResult result =
      run_process(kForest, {"--doctor-trial", GetParam(), "600"},
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

}  // namespace coppice::test::doctor_test
