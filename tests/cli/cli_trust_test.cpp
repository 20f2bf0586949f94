// The coppice program among files, names and streams that mean it ill: pipes and devices as input, full disks, names full of escapes,
// outputs that cannot be written, signals, threads that cannot be started.
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "gltf_builder.h"
#include "mentions.h"
#include "pack.h"
#include "places.h"
#include "printable.h"
#include "process.h"
#include "random_tree.h"
#include "text_files.h"

namespace coppice::test {
namespace cli_trust_test {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

ProcessResult tool(const Words& arguments, ProcessOptions options = {}) {
  options.kill_after = std::chrono::seconds(60);  // what hangs fails
  return run_process(test::kTool, arguments, options);
}

std::string joined(const Words& arguments) {
  std::string line = "coppice";
  for (const std::string& word : arguments) line += " " + printable(word);
  return line;
}

/// Lines of an error. A warning may come before it: of a plant outside the scene's folder.
std::ptrdiff_t error_line_count(const std::string& text) {
  std::istringstream lines(text);
  std::ptrdiff_t count = 0;
  for (std::string line; std::getline(lines, line);)
    if (!line.starts_with("coppice: warning: ")) ++count;
  return count;
}

/// names: the file or the cause
void expect_one_line_error(const ProcessResult& result, const std::string& names, const std::string& about) {
  EXPECT_EQ(result.signal, 0) << about;
  EXPECT_EQ(result.exit_code, 1) << about << "\n" << result.err;
  const std::string err = unwrapped(result.err);
  EXPECT_EQ(error_line_count(err), 1) << about << "\n" << err;
  EXPECT_TRUE(mentions(err, {names})) << about;
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
    return {{"plant", "corylus", "-o", output},
            {"bake", small_, "-o", output, "--views", "2", "--resolution", "16"},
            {"bake", small_, "--dry-run", "--preview", output},
            {"export", oak_, "--leaves", "9", "-o", output},
            {"evaluate", small_, "--methods", "default", "--levels", "1", "--size", "32", "--json", output},
            {"evaluate", small_, "--methods", "default", "--levels", "1", "--size", "32", "--html", output},
            {"scene", "-o", output, "--allow-outside", "--plants", oak_, "--count", "10", "--size-m", "100"}};
  }

  [[nodiscard]] std::vector<std::string> files_in(const fs::path& folder) const {
    std::vector<std::string> names;
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
      expect_one_line_error(tool(arguments), input.filename(), joined(arguments));
  for (const fs::path& input : {pipe, fs::path("/dev/zero")}) {
    expect_one_line_error(tool({"bake-all", input, "-o", out_ / "all"}), input.filename(), input);
    expect_one_line_error(tool({"scene", "-o", out, "--allow-outside", "--plants", input}), input.filename(), input);
  }
  expect_one_line_error(tool({"inspect", folder_ / "none"}), "none: " + std::string(std::strerror(ENOENT)), "missing");
  EXPECT_TRUE(files_in(out_).empty());
}

TEST_F(CommandTrust, AFullDiskBehindTheStandardOutputIsAnError) {
  ProcessOptions full;
  full.out = "/dev/full";
  std::vector<Words> all = writers(out_ / "x.out");
  std::erase_if(all, [](const Words& arguments) { return arguments[0] == "evaluate"; });
  for (const Words& arguments :
       {Words{"--help"}, Words{"--version"}, Words{"bake", "--help"}, Words{"inspect", oak_}, Words{"inspect", oak_, "--json"},
        Words{"verify", oak_}, Words{"bake-all", plants_, "-o", out_ / "all", "--views", "2", "--resolution", "16"},
        Words{"plant", "corylus", "-o", "-"}, Words{"export", oak_, "--leaves", "full", "-o", "-"}, Words{"bake", small_, "--dry-run"},
        Words{"evaluate", small_, "--methods", "default", "--levels", "1", "--size", "32"}})
    all.push_back(arguments);
  for (const Words& arguments : all) expect_one_line_error(tool(arguments, full), std::strerror(ENOSPC), joined(arguments));
}

TEST_F(CommandTrust, AStandardOutputThatIsClosedTakesNothingAndSpoilsNothing) {
  const auto closed = [](const std::string& arguments) {
    return run_process("/bin/sh", {"-c", std::string("exec '") + test::kTool + "' " + arguments + " >&-"});
  };
  expect_one_line_error(closed("verify '" + oak_.string() + "'"), std::strerror(EBADF), "verify");
  const fs::path file = out_ / "x.glb";
  expect_one_line_error(closed("plant corylus -o '" + file.string() + "'"), std::strerror(EBADF), "plant");
  EXPECT_EQ(read_text(file).substr(0, 4), "glTF");
}

TEST_F(CommandTrust, AnOutputThatCannotBeWrittenIsRefusedBeforeTheWork) {
  const fs::path missing = folder_ / "missing.glb";
  const fs::path bad[] = {out_, "/proc/none/x.out", out_ / std::string(256, 'n'), "/dev/null", "/proc/x.out", out_ / "new/"};
  for (const fs::path& output : bad)
    for (Words arguments : writers(output)) {
      // An input that is not there would be the error, were it looked at first.
      for (std::string& word : arguments)
        if (word == small_ || word == oak_) word = missing;
      const ProcessResult result = tool(arguments);
      expect_one_line_error(result, output, joined(arguments));
      EXPECT_FALSE(mentions(result.err, {"missing.glb"})) << joined(arguments);
    }
  for (const Words& arguments : writers("")) EXPECT_EQ(tool(arguments).exit_code, 2) << joined(arguments);
  EXPECT_TRUE(files_in(out_).empty());
}

TEST_F(CommandTrust, VerifyTakesScenesByWhatIsInThem) {
  const fs::path scene = folder_ / "wood.forest", moved = out_ / "no_name";
  ASSERT_EQ(tool({"scene", "-o", scene, "--allow-outside", "--plants", oak_, "--count", "3000", "--size-m", "300"}).exit_code, 0);
  const ProcessResult good = tool({"verify", scene});
  EXPECT_EQ(good.exit_code, 0) << good.err;
  EXPECT_TRUE(mentions(good.out, {"3000"}));
  std::string bytes = read_text(scene);
  bytes[bytes.size() - 3] ^= 1;
  write_file(moved, std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
  const ProcessResult bad = tool({"verify", moved});
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_EQ(bad.out, "");
  EXPECT_EQ(std::ranges::count(bad.err, '\n'), 2) << bad.err;
  EXPECT_TRUE(mentions(bad.err, {"oak.coppice: " + std::string(std::strerror(ENOENT)), "no_name: tile checksum"}));
}

TEST_F(CommandTrust, NoInputIsOverwritten) {
  const fs::path rules = out_ / "rules.json", map = out_ / "map.png";
  for (const fs::path& file : {rules, map}) write_file(file, std::vector<std::uint8_t>(9));
  for (const auto& [input, arguments] :
       {std::pair{rules, Words{"bake", small_, "-o", rules, "--classes", rules}},
        std::pair{rules, Words{"evaluate", small_, "--json", rules, "--classes", rules}},
        std::pair{oak_, Words{"scene", "-o", oak_, "--allow-outside", "--plants", oak_}},
        std::pair{map, Words{"scene", "-o", map, "--allow-outside", "--plants", oak_, "--density", "oak=" + map.string()}}}) {
    const std::string before = read_text(input);
    expect_one_line_error(tool(arguments), input.filename(), joined(arguments));
    EXPECT_EQ(read_text(input), before);
  }
}

TEST_F(CommandTrust, ABatchRefusesSuchOutputsPlantByPlant) {
  const fs::path taken = out_ / "small.coppice";
  fs::create_directories(taken);
  const ProcessResult result = tool({"bake-all", plants_, "-o", out_, "--views", "2", "--resolution", "16"});
  expect_one_line_error(result, "small.coppice: " + std::string(std::strerror(EISDIR)), "bake-all");
  EXPECT_EQ(files_in(out_ / ".coppice-cache"), (std::vector<std::string>{"lock"})) << "it was baked";
}

TEST_F(CommandTrust, ANameAsLongAsTheSystemTakesIsWritten) {
  const fs::path output = out_ / (std::string(247, 'n') + ".coppice");
  EXPECT_EQ(tool({"bake", small_, "-o", output, "--views", "2", "--resolution", "16"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(output));
}

TEST_F(CommandTrust, ADashIsTheStandardOutput) {
  const fs::path file = out_ / "x.out";
  for (const bool to_file : {true, false}) {
    const std::string output = to_file ? file.string() : "-";
    for (const Words& arguments : writers(output)) {
      if (arguments[0] == "scene" || (arguments[0] == "evaluate" && !to_file)) continue;
      const ProcessResult result = tool(arguments);
      ASSERT_EQ(result.exit_code, 0) << joined(arguments) << "\n" << result.err;
      if (!to_file) continue;
      Words piped = arguments;
      std::ranges::replace(piped, output, "-");
      const std::string out = tool(piped).out;
      const bool is_timed = std::ranges::find(piped, "--html") != piped.end();
      EXPECT_TRUE(is_timed ? out.starts_with("<!") && out.ends_with(">\n") : out == read_text(file)) << joined(piped);
    }
  }
  for (const Words& arguments : {Words{"bake", small_, "-o", "-", "--report", "-"},
                                 Words{"scene", "-o", "-", "--allow-outside", "--plants", oak_}, Words{"bake-all", plants_, "-o", "-"}}) {
    const ProcessResult refused = tool(arguments);
    expect_one_line_error(refused, ":", joined(arguments));
    EXPECT_EQ(refused.out, "") << joined(arguments);
  }
  const ProcessResult report = tool({"bake-all", plants_, "-o", out_, "--views", "2", "--resolution", "16", "--report", "-"});
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
  const Words quick = {"--views", "2", "--resolution", "16"};
  const auto with_quick = [&](Words arguments) {
    arguments.insert(arguments.end(), quick.begin(), quick.end());
    return arguments;
  };
  for (const Words& arguments :
       {with_quick({"bake", glb, "-o", baked}), Words{"inspect", baked}, Words{"inspect", baked, "--json"}, Words{"verify", baked},
        Words{"export", baked, "--leaves", "full", "-o", out_ / ("x" + evil)}, Words{"bake", named, "--dry-run"},
        Words{"bake", glb, "--dry-run"}, Words{"bake", glb, "--dry-run", "--leaf-material", evil}, Words{"plant", evil, "-o", "x"},
        Words{"plant", "corylus", "-o", out_ / ("p" + evil)}, Words{evil}, Words{"verify", baked, "--" + evil}, Words{"verify", glb},
        Words{"evaluate", glb, "--methods", "default", "--levels", "1", "--size", "32"}, Words{"inspect", out_ / evil},
        Words{"scene", "-o", out_ / ("s" + evil), "--allow-outside", "--plants", baked, "--count", "9"},
        Words{"scene", "-o", out_ / ("s" + evil), "--allow-outside", "--plants", oak_, "--density", evil + "=x"},
        with_quick({"bake-all", plants_, "-o", out_ / ("all" + evil)})}) {
    const ProcessResult result = tool(arguments);
    EXPECT_EQ(result.signal, 0) << joined(arguments);
    std::string text = result.out + result.err;
    EXPECT_NE(text, "") << joined(arguments);
    std::erase(text, '\n');
    EXPECT_EQ(printable(text), text) << joined(arguments);
  }
  EXPECT_EQ(tool({"verify", baked}).exit_code, 0) << "what is baked is what verify takes";
}

/// What a killed process leaves, in the name of one that cannot be.
fs::path abandoned_file(const fs::path& folder) {
  return write_file(folder / ".coppice-999999999-0.tmp", std::vector<std::uint8_t>(9));
}

TEST_F(CommandTrust, EveryCommandRemovesWhatAKilledOneLeft) {
  for (const Words& arguments : writers(out_ / "x.out")) {
    const fs::path abandoned = abandoned_file(out_);
    EXPECT_EQ(tool(arguments).exit_code, 0) << joined(arguments);
    EXPECT_FALSE(fs::exists(abandoned)) << joined(arguments);
  }
}

TEST_F(CommandTrust, AFileThatGetsTooLargeIsAnErrorWithoutATemporaryFile) {
  ProcessOptions small_files;
  small_files.largest_file_bytes = 200;
  small_files.out = "/dev/null";
  for (const Words& arguments : writers(out_ / "x.out")) {
    const ProcessResult result = tool(arguments, small_files);
    expect_one_line_error(result, std::strerror(EFBIG), joined(arguments));
    EXPECT_TRUE(files_in(out_).empty()) << joined(arguments);
  }
}

TEST_F(CommandTrust, ASignalInTheMiddleOfAWriteLeavesNothing) {
  const auto expect_clean_end = [this](const Words& arguments, int signal) {
    ProcessOptions options;
    options.environment = {std::string("LD_PRELOAD=") + test::kFailMallocLibrary, "COPPICE_SIGNAL_IN_FSYNC=" + std::to_string(signal)};
    const ProcessResult result = tool(arguments, options);
    EXPECT_EQ(result.signal, signal) << joined(arguments) << "\n" << result.err;
    EXPECT_TRUE(files_in(out_).empty()) << joined(arguments) << ", signal " << signal;
  };
  for (const Words& arguments : writers(out_ / "x.out")) expect_clean_end(arguments, SIGTERM);
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGPIPE, SIGXCPU}) expect_clean_end({"plant", "corylus", "-o", out_ / "x.glb"}, signal);
}

TEST_F(CommandTrust, AThreadThatCannotBeStartedIsNoReasonToFailOrIsSaid) {
  for (const int nth : {1, 2}) {
    ProcessOptions options;
    options.environment = {std::string("LD_PRELOAD=") + test::kFailMallocLibrary, "COPPICE_FAIL_THREAD=" + std::to_string(nth)};
    const fs::path output = out_ / "x.coppice";
    const Words arguments = {"bake", small_, "-o", output, "--threads", "4", "--views", "20", "--resolution", "64"};
    const ProcessResult result = tool(arguments, options);
    if (result.exit_code == 0) continue;
    expect_one_line_error(result, std::strerror(EAGAIN), joined(arguments));
    EXPECT_TRUE(files_in(out_).empty());
  }
}

TEST_F(CommandTrust, APathForWhichThereIsNoMemoryIsNoOtherError) {
  const fs::path scene = folder_ / "oaks.forest", linked = out_ / "linked.glb";
  ASSERT_EQ(tool({"scene", "-o", scene, "--plants", oak_, "--count", "10", "--size-m", "100"}).exit_code, 0);
  write_file(folder_ / "grown.glb", small_plant().glb());
  fs::create_symlink(folder_ / "grown.glb", linked);
  for (const Words& arguments :
       {Words{"scene", "-o", folder_ / "new.forest", "--plants", oak_, "--count", "10", "--size-m", "100"}, Words{"verify", scene},
        Words{"plant", "corylus", "-o", linked}, Words{"bake-all", plants_, "-o", out_ / "baked", "--views", "2", "--resolution", "16"}}) {
    std::size_t refused = 0;
    for (int nth = 1; nth < 100; ++nth) {
      fs::remove_all(out_ / "baked");
      ProcessOptions options;
      options.environment = {std::string("LD_PRELOAD=") + test::kFailMallocLibrary, "COPPICE_FAIL_REALPATH=" + std::to_string(nth)};
      const ProcessResult result = tool(arguments, options);
      if (result.exit_code == 0) break;
      ++refused;
      expect_one_line_error(result, "memory", joined(arguments) + ", path " + std::to_string(nth));
    }
    EXPECT_GT(refused, 0u) << joined(arguments);
    EXPECT_TRUE(fs::is_symlink(linked)) << joined(arguments);
  }
}

}  // namespace cli_trust_test
}  // namespace coppice::test
