// The coppice program among files, names and streams that mean it ill: pipes and devices as input, full disks, names full of escapes,
// outputs that cannot be written, signals, threads that cannot be started.
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "gltf_builder.h"
#include "pack.h"
#include "printable.h"
#include "random_tree.h"
#include "tool.h"

namespace coppice::test::cli_trust_test {

namespace fs = std::filesystem;

ProcessResult tool(const Words& arguments, ProcessOptions options = {}) {
  options.kill_after = std::chrono::seconds(60);  // what hangs fails
  return run_tool(arguments, options);
}

/// With calls of the system that fail: fail_malloc.c.
ProcessOptions with_fault(const std::string& fault) {
  return {.environment = {std::string("LD_PRELOAD=") + kFailMallocLibrary, fault}};
}

std::string line_of(const Words& arguments) {
  std::string line = "coppice";
  for (const std::string& word : arguments) line += " " + printable(word);
  return line;
}

/// names: the file or the cause. A warning may come before the error: of a plant outside the scene's folder.
void expect_cause(ProcessResult result, const std::string& names, const std::string& about) {
  static const std::regex warning("coppice: warning: [^\n]*\n");
  result.err = std::regex_replace(unwrapped(result.err), warning, "");
  expect_error(result, {names}, about);
}

ProcessResult expect_refused(const Words& arguments, const std::string& names, const ProcessOptions& options = {}) {
  ProcessResult result = tool(arguments, options);
  expect_cause(result, names, line_of(arguments));
  return result;
}

/// A quick bake of one plant or all.
Words quick(Words arguments) {
  return joined(std::move(arguments), {"--views", "2", "--resolution", "16"});
}

/// Inputs of every kind, and a folder for outputs.
class CommandTrust : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(out_);
    write_file(plants_ / "small.glb", small_plant().glb());
    bake::PackSizes sizes;
    write_file(oak_, *bake::pack(random_plant({.leaf_count = 40}), sizes));
  }

  /// Every command that has an output, with a quick job.
  [[nodiscard]] std::vector<Words> writers(const fs::path& output) const {
    const Words evaluate{"evaluate", small_, "--methods", "default", "--levels", "1", "--size", "32"};
    return {{"plant", "corylus", "-o", output},
            quick({"bake", small_, "-o", output}),
            {"bake", small_, "--dry-run", "--preview", output},
            {"export", oak_, "--leaves", "9", "-o", output},
            joined(evaluate, {"--json", output}),
            joined(evaluate, {"--html", output}),
            {"scene", "-o", output, "--allow-outside", "--plants", oak_, "--count", "10", "--size-m", "100"}};
  }

  [[nodiscard]] Words files_in(const fs::path& folder) const {
    Words names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
    std::ranges::sort(names);
    return names;
  }

  TemporaryFolder folder_;
  fs::path plants_ = make(folder_ / "plants"), small_ = plants_ / "small.glb", oak_ = folder_ / "oak.coppice", out_ = folder_ / "out";

 private:
  static fs::path make(const fs::path& folder) {
    fs::create_directories(folder);
    return folder;
  }
};

TEST_F(CommandTrust, OnlyRegularFilesAreRead) {
  const fs::path pipe = folder_ / "pipe", out = out_ / "x.coppice";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const fs::path& input : {pipe, fs::path("/dev/zero"), fs::path("/dev/tty"), out_})
    for (const Words& arguments : {Words{"inspect", input}, Words{"verify", input}, Words{"bake", input, "-o", out},
                                   Words{"bake", small_, "-o", out, "--classes", input}, Words{"export", input, "--leaves", "1", "-o", out},
                                   Words{"evaluate", input}, Words{"scene", input, "-o", out, "--allow-outside", "--plants", oak_},
                                   Words{"scene", "-o", out, "--allow-outside", "--plants", oak_, "--density", "oak=" + input.string()}})
      EXPECT_EQ(expect_refused(arguments, input.filename()).out, "") << line_of(arguments);
  for (const fs::path& input : {pipe, fs::path("/dev/zero")}) {
    expect_refused({"bake-all", input, "-o", out_ / "all"}, input.filename());
    expect_refused({"scene", "-o", out, "--allow-outside", "--plants", input}, input.filename());
  }
  expect_refused({"inspect", folder_ / "none"}, "none: " + std::string(std::strerror(ENOENT)));
  EXPECT_TRUE(files_in(out_).empty());
}

TEST_F(CommandTrust, AFullDiskBehindTheStandardOutputIsAnError) {
  std::vector<Words> all = writers(out_ / "x.out");
  std::erase_if(all, [](const Words& arguments) { return arguments[0] == "evaluate"; });
  for (const Words& arguments :
       {Words{"--help"}, Words{"--version"}, Words{"bake", "--help"}, Words{"inspect", oak_}, Words{"inspect", oak_, "--json"},
        Words{"verify", oak_}, quick({"bake-all", plants_, "-o", out_ / "all"}), Words{"plant", "corylus", "-o", "-"},
        Words{"export", oak_, "--leaves", "full", "-o", "-"}, Words{"bake", small_, "--dry-run"},
        Words{"evaluate", small_, "--methods", "default", "--levels", "1", "--size", "32"}})
    all.push_back(arguments);
  for (const Words& arguments : all) expect_refused(arguments, std::strerror(ENOSPC), {.out = "/dev/full"});
}

TEST_F(CommandTrust, AStandardOutputThatIsClosedTakesNothingAndSpoilsNothing) {
  const auto expect_closed = [](const std::string& arguments) {
    expect_cause(run_process("/bin/sh", {"-c", std::string("exec '") + kTool + "' " + arguments + " >&-"}), std::strerror(EBADF),
                 arguments);
  };
  const fs::path file = out_ / "x.glb";
  expect_closed("verify '" + oak_.string() + "'");
  expect_closed("plant corylus -o '" + file.string() + "'");
  EXPECT_EQ(read_text(file).substr(0, 4), "glTF");
}

TEST_F(CommandTrust, AnOutputThatCannotBeWrittenIsRefusedBeforeTheWork) {
  const fs::path missing = folder_ / "missing.glb";
  const fs::path bad[] = {out_,          "/proc/none/x.out", out_ / std::string(256, 'n'), "/dev/full", "/proc/x.out",
                          out_ / "new/", oak_ / "x.out"};
  for (const fs::path& output : bad)
    for (Words arguments : writers(output)) {
      // An input that is not there would be the error, were it looked at first.
      for (std::string& word : arguments)
        if (word == small_ || word == oak_) word = missing;
      const ProcessResult refused = expect_refused(arguments, output);
      EXPECT_FALSE(mentions(refused.err, {"missing.glb"})) << line_of(arguments);
      EXPECT_EQ(refused.out, "") << line_of(arguments);
    }
  for (const Words& arguments : writers("")) EXPECT_EQ(tool(arguments).exit_code, 2) << line_of(arguments);
  EXPECT_TRUE(files_in(out_).empty());
}

TEST_F(CommandTrust, WhatGoesToTheNullDeviceIsGone) {
  std::vector<Words> commands = writers("/dev/null");
  commands.push_back(quick({"bake", small_, "-o", "/dev/null", "--report", "/dev/null"}));
  commands.push_back(quick({"bake-all", plants_, "-o", out_, "--report", "/dev/null", "--journal", "/dev/null"}));
  for (const Words& arguments : commands) {
    const ProcessResult result = tool(arguments);
    EXPECT_EQ(result.exit_code, 0) << line_of(arguments) << "\n" << result.err;
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
  }
}

TEST_F(CommandTrust, VerifyTakesScenesByWhatIsInThem) {
  const fs::path scene = folder_ / "wood.forest", moved = out_ / "no_name";
  ASSERT_EQ(tool({"scene", "-o", scene, "--allow-outside", "--plants", oak_, "--count", "3000", "--size-m", "300"}).exit_code, 0);
  const ProcessResult good = tool({"verify", scene});
  EXPECT_EQ(good.exit_code, 0) << good.err;
  EXPECT_TRUE(mentions(good.out, {"3000"}));
  std::string bytes = read_text(scene);
  bytes[bytes.size() - 3] ^= 1;
  write_text(moved, bytes);
  const ProcessResult bad = tool({"verify", moved});
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_EQ(bad.out, "");
  EXPECT_EQ(count_of(bad.err, "\n"), 2u) << bad.err;
  EXPECT_TRUE(mentions(bad.err, {"oak.coppice: " + std::string(std::strerror(ENOENT)), "no_name: tile checksum"}));
}

TEST_F(CommandTrust, NoFileOfACommandIsOverwritten) {
  const fs::path rules = out_ / "rules.json", map = out_ / "map.png", baked = out_ / "x.coppice";
  const GltfBuilder builder = small_plant();
  const fs::path named = write_file(out_ / "named.gltf", builder.gltf_beside("a%20b.bin")),
                 buffer = write_file(out_ / "a b.bin", builder.bin);
  for (const fs::path& file : {rules, map}) write_file(file, std::vector<std::uint8_t>(9));
  for (const auto& [input, arguments] :
       {std::pair{rules, Words{"bake", small_, "-o", rules, "--classes", rules}}, std::pair{small_, Words{"bake", small_, "-o", small_}},
        std::pair{small_, Words{"bake", small_, "-o", baked, "--report", small_}}, std::pair{buffer, Words{"bake", named, "-o", buffer}},
        std::pair{buffer, Words{"bake", named, "--dry-run", "--preview", buffer}},
        std::pair{buffer, Words{"bake-all", named, "-o", out_ / "all", "--report", buffer}},
        std::pair{buffer, Words{"evaluate", named, "--json", buffer}}, std::pair{buffer, Words{"view", named, "--screenshot", buffer}},
        std::pair{buffer, Words{"scene", named, "-o", buffer, "--allow-outside", "--plants", oak_}},
        std::pair{oak_, Words{"export", oak_, "--leaves", "9", "-o", oak_}},
        std::pair{rules, Words{"evaluate", small_, "--json", rules, "--classes", rules}},
        std::pair{oak_, Words{"scene", "-o", oak_, "--allow-outside", "--plants", oak_}},
        std::pair{map, Words{"scene", "-o", map, "--allow-outside", "--plants", oak_, "--density", "oak=" + map.string()}}}) {
    const std::string before = read_text(input);
    expect_refused(arguments, input.filename());
    EXPECT_EQ(read_text(input), before);
  }
  fs::create_symlink("x.coppice", out_ / "link");
  for (const fs::path& report : {baked, out_ / "link"})
    EXPECT_EQ(expect_refused({"bake", small_, "-o", baked, "--report", report}, report.filename()).out, "");
  EXPECT_FALSE(fs::exists(baked));
}

TEST_F(CommandTrust, ABatchRefusesSuchOutputsPlantByPlant) {
  const fs::path taken = out_ / "small.coppice";
  fs::create_directories(taken);
  expect_refused(quick({"bake-all", plants_, "-o", out_}), "small.coppice: " + std::string(std::strerror(EISDIR)));
  EXPECT_EQ(files_in(out_ / ".coppice-cache"), Words{"lock"}) << "it was baked";
}

TEST_F(CommandTrust, ADashIsTheStandardOutput) {
  const fs::path file = out_ / "x.out";
  for (const bool to_file : {true, false}) {
    const std::string output = to_file ? file.string() : "-";
    for (const Words& arguments : writers(output)) {
      if (arguments[0] == "scene" || (arguments[0] == "evaluate" && !to_file)) continue;
      const ProcessResult result = tool(arguments);
      ASSERT_EQ(result.exit_code, 0) << line_of(arguments) << "\n" << result.err;
      if (!to_file) continue;
      Words piped = arguments;
      std::ranges::replace(piped, output, "-");
      const std::string out = tool(piped).out;
      const bool is_timed = std::ranges::find(piped, "--html") != piped.end();
      EXPECT_TRUE(is_timed ? out.starts_with("<!") && out.ends_with(">\n") : out == read_text(file)) << line_of(piped);
    }
  }
  for (const Words& arguments : {Words{"bake", small_, "-o", "-", "--report", "-"},
                                 Words{"scene", "-o", "-", "--allow-outside", "--plants", oak_}, Words{"bake-all", plants_, "-o", "-"}})
    EXPECT_EQ(expect_refused(arguments, ":").out, "") << line_of(arguments);
  const ProcessResult report = tool(quick({"bake-all", plants_, "-o", out_, "--report", "-"}));
  EXPECT_EQ(report.out.substr(0, 1) + report.out.substr(report.out.size() - 2), "{}\n") << report.out;
}

TEST_F(CommandTrust, NothingThatATerminalObeysIsPrinted) {
  const std::string evil =
      "\x1b]0;x\x07\n\xc2\x9b"
      "31m";
  GltfBuilder builder = small_plant();
  builder.json["materials"][0]["name"] = "leaves" + evil;
  builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 9;
  const fs::path glb = write_file(plants_ / ("oak" + evil + ".glb"), small_plant().glb());
  const fs::path named = write_file(plants_ / "named.glb", builder.glb()), baked = out_ / ("oak" + evil + ".coppice");
  for (const Words& arguments :
       {quick({"bake", glb, "-o", baked}), Words{"inspect", baked}, Words{"inspect", baked, "--json"}, Words{"verify", baked},
        Words{"export", baked, "--leaves", "full", "-o", out_ / ("x" + evil)}, Words{"bake", named, "--dry-run"},
        Words{"bake", glb, "--dry-run"}, Words{"bake", glb, "--dry-run", "--leaf-material", evil}, Words{"plant", evil, "-o", "x"},
        Words{"plant", "corylus", "-o", out_ / ("p" + evil)}, Words{evil}, Words{"verify", baked, "--" + evil}, Words{"verify", glb},
        Words{"evaluate", glb, "--methods", "default", "--levels", "1", "--size", "32"}, Words{"inspect", out_ / evil},
        Words{"scene", "-o", out_ / ("s" + evil), "--allow-outside", "--plants", baked, "--count", "9"},
        Words{"scene", "-o", out_ / ("s" + evil), "--allow-outside", "--plants", oak_, "--density", evil + "=x"},
        quick({"bake-all", plants_, "-o", out_ / ("all" + evil)})}) {
    const ProcessResult result = tool(arguments);
    EXPECT_EQ(result.signal, 0) << line_of(arguments);
    std::string text = result.out + result.err;
    EXPECT_NE(text, "") << line_of(arguments);
    std::erase(text, '\n');
    EXPECT_EQ(printable(text), text) << line_of(arguments);
  }
  EXPECT_EQ(tool({"verify", baked}).exit_code, 0) << "what is baked is what verify takes";
}

TEST_F(CommandTrust, EveryCommandRemovesWhatAKilledOneLeft) {
  const fs::path abandoned = out_ / ".coppice-999999999-0.tmp";  // in the name of a process that cannot be
  for (const Words& arguments : writers(out_ / "x.out")) {
    write_text(abandoned, "half");
    EXPECT_EQ(tool(arguments).exit_code, 0) << line_of(arguments);
    EXPECT_FALSE(fs::exists(abandoned)) << line_of(arguments);
  }
}

TEST_F(CommandTrust, AFileThatGetsTooLargeIsAnErrorAndLeavesTheOldOneOrNone) {
  const fs::path output = out_ / "x.out";
  for (const Words& arguments : writers(output))
    for (const bool is_there : {false, true}) {
      if (is_there) write_text(output, "what was here before");
      expect_refused(arguments, std::strerror(EFBIG), {.largest_file_bytes = 200, .out = "/dev/null"});
      EXPECT_EQ(files_in(out_), is_there ? Words{"x.out"} : Words{}) << line_of(arguments);
      EXPECT_EQ(read_text(output), is_there ? "what was here before" : "") << line_of(arguments);
      fs::remove(output);
    }
}

TEST_F(CommandTrust, ASignalInTheMiddleOfAWriteLeavesNothing) {
  const auto expect_clean_end = [this](const Words& arguments, int signal) {
    const ProcessResult result = tool(arguments, with_fault("COPPICE_SIGNAL_IN_FSYNC=" + std::to_string(signal)));
    EXPECT_EQ(result.signal, signal) << line_of(arguments) << "\n" << result.err;
    EXPECT_TRUE(files_in(out_).empty()) << line_of(arguments) << ", signal " << signal;
  };
  for (const Words& arguments : writers(out_ / "x.out")) expect_clean_end(arguments, SIGTERM);
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGPIPE, SIGXCPU}) expect_clean_end({"plant", "corylus", "-o", out_ / "x.glb"}, signal);
}

TEST_F(CommandTrust, AThreadThatCannotBeStartedIsNoReasonToFailOrIsSaid) {
  for (const char* nth : {"1", "2"}) {
    const Words arguments = {"bake", small_, "-o", out_ / "x.coppice", "--threads", "4", "--views", "20", "--resolution", "64"};
    const ProcessResult result = tool(arguments, with_fault(std::string("COPPICE_FAIL_THREAD=") + nth));
    if (result.exit_code == 0) continue;
    expect_cause(result, std::strerror(EAGAIN), line_of(arguments));
    EXPECT_TRUE(files_in(out_).empty());
  }
}

TEST_F(CommandTrust, APathForWhichThereIsNoMemoryIsNoOtherError) {
  const fs::path scene = folder_ / "oaks.forest";
  ASSERT_EQ(tool({"scene", "-o", scene, "--plants", oak_, "--count", "10", "--size-m", "100"}).exit_code, 0);
  for (const Words& arguments : {Words{"scene", "-o", folder_ / "new.forest", "--plants", oak_, "--count", "10", "--size-m", "100"},
                                 Words{"verify", scene}, quick({"bake-all", plants_, "-o", out_ / "baked"})}) {
    std::size_t refused = 0;
    for (int nth = 1; nth < 100; ++nth) {
      fs::remove_all(out_ / "baked");
      const ProcessResult result = tool(arguments, with_fault("COPPICE_FAIL_REALPATH=" + std::to_string(nth)));
      if (result.exit_code == 0) break;
      ++refused;
      expect_cause(result, "memory", line_of(arguments) + ", path " + std::to_string(nth));
    }
    EXPECT_GT(refused, 0u) << line_of(arguments);
  }
}

}  // namespace coppice::test::cli_trust_test
