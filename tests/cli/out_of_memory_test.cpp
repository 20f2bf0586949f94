// Every sub-command with one allocation that fails, at many different places: it does its work whole, or says that memory has run out and
// writes nothing. fail_malloc.c is preloaded for that. By default a few dozen places a command; with COPPICE_EVERY_ALLOCATION=1 each of the
// first 2,000 and then steps of 5 %, which takes half an hour.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "gltf_builder.h"
#include "pack.h"
#include "random_tree.h"
#include "tool.h"

namespace coppice::test::out_of_memory_test {

namespace fs = std::filesystem;

/// A sub-command on small inputs. Paths are relative to the folder that it runs on.
struct Command {
  const char* name;
  Words arguments;  ///< IN/ and OUT/ stand for folders
};

void PrintTo(const Command& command, std::ostream* stream) {
  *stream << command.name;
}

const std::vector<Command>& commands() {
  static const std::vector<Command> all = {
      {"help", {"--help"}},
      {"completion", {"completion", "zsh"}},
      {"plant", {"plant", "corylus", "-o", "OUT/plant.glb"}},
      {"bake", {"bake", "IN/small.glb", "-o", "OUT/small.coppice", "--views", "2", "--resolution", "16", "--threads", "1"}},
      {"bake_report",
       {"bake", "IN/small.glb", "-o", "OUT/small.coppice", "--metric", "mi", "--views", "2", "--resolution", "16", "--threads", "2",
        "--report", "OUT/small.json"}},
      {"dry_run", {"bake", "IN/small.glb", "--dry-run", "--preview", "OUT/small.png"}},
      {"bake_all", {"bake-all", "IN/plants", "-o", "OUT/baked", "--views", "2", "--resolution", "16", "--jobs", "1"}},
      {"inspect", {"inspect", "IN/oak.coppice"}},
      {"inspect_json", {"inspect", "IN/oak.coppice", "--json"}},
      {"verify", {"verify", "IN/oak.coppice"}},
      {"verify_scene", {"verify", "IN/oaks.forest"}},
      {"export", {"export", "IN/oak.coppice", "--leaves", "full", "-o", "OUT/oak.glb"}},
      {"evaluate",
       {"evaluate", "IN/small.glb", "--methods", "default", "--levels", ".5", "--size", "32", "--threads", "1", "--html",
        "OUT/small.html"}},
      {"scene", {"scene", "-o", "IN/made.forest", "--plants", "IN/oak.coppice", "--count", "3000", "--size-m", "400"}},
  };
  return all;
}

class OutOfMemory : public testing::TestWithParam<Command> {
 protected:
  void SetUp() override {
    fs::create_directories(in_ / "plants");
    GltfBuilder small = small_plant();
    small.set_texture(0, striped_png(16, {20, 140, 30, 255}, {30, 160, 40, 255}));
    write_file(in_ / "small.glb", small.glb());
    write_file(in_ / "plants" / "small.glb", small.glb());
    bake::PackSizes sizes;
    const auto oak = bake::pack(random_plant({.leaf_count = 700, .leaf_mesh_count = 2}), sizes);
    ASSERT_TRUE(oak);
    write_file(in_ / "oak.coppice", *oak);
    const ProcessResult scene =
        run_tool({"scene", "-o", in_ / "oaks.forest", "--plants", in_ / "oak.coppice", "--count", "3000", "--size-m", "400"});
    ASSERT_EQ(scene.exit_code, 0) << scene.err;
  }

  /// Runs the command into a fresh OUT, and with `made` removed from IN.
  ProcessResult run(const Words& environment) {
    fs::remove_all(out_);
    fs::remove(in_ / "made.forest");
    fs::create_directories(out_);
    Words arguments = GetParam().arguments;
    for (std::string& argument : arguments) {
      if (argument.starts_with("IN/")) argument = in_ / argument.substr(3);
      if (argument.starts_with("OUT/")) argument = out_ / argument.substr(4);
    }
    ProcessOptions options;
    options.environment = environment;
    options.environment.push_back(std::string("LD_PRELOAD=") + kFailMallocLibrary);
    options.kill_after = std::chrono::seconds(60);
    return run_tool(arguments, options);
  }

  /// Every file in IN and OUT that is an output or should not be there, by its path. Where the cache of bake-all ends is its own affair.
  [[nodiscard]] std::map<std::string, std::string> outputs() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      const std::string name = entry.path().lexically_relative(folder_.path());
      const bool cached = name.find(".coppice-cache") != std::string::npos && entry.path().extension() != ".tmp";
      if (entry.is_regular_file() && !cached && inputs_.count(name) == 0) files[name] = read_text(entry.path());
    }
    return files;
  }

  /// Seconds, and with them sizes of reports, are not the same twice.
  static bool is_same_output(const std::string& name, const std::string& a, const std::string& b) {
    if (name.ends_with(".json") || name.ends_with(".html"))
      return a.size() + 200 > b.size() && b.size() + 200 > a.size() && a.back() == b.back();
    return a == b;
  }

  TemporaryFolder folder_;
  fs::path in_ = folder_ / "in", out_ = folder_ / "out";
  std::map<std::string, std::string> inputs_;
};

/// A few dozen places from the first allocation to the last; with COPPICE_EVERY_ALLOCATION=1 those that the head of this file promises.
std::vector<std::uint64_t> places(std::uint64_t count) {
  const bool all = std::getenv("COPPICE_EVERY_ALLOCATION") != nullptr;
  std::vector<std::uint64_t> list;
  const std::uint64_t dense = all ? 2000 : 4;
  for (std::uint64_t n = 1; n <= count; n += n < dense ? 1 : std::max<std::uint64_t>(1, all ? n / 20 : n / 2)) list.push_back(n);
  // Where outputs get their names and the last line is printed.
  for (std::uint64_t n = count - std::min<std::uint64_t>(count, all ? 200 : 6); n < count; ++n) list.push_back(n + 1);
  return list;
}

TEST_P(OutOfMemory, EndsWithoutHalfAFile) {
  inputs_ = outputs();
  const fs::path counts = folder_ / "counts";
  const ProcessResult whole = run({"COPPICE_COUNT_MALLOC=" + counts.string()});
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const std::uint64_t count = std::stoull(read_text(counts));
  fs::remove(counts);
  const auto expected = outputs();
  std::size_t done = 0, refused = 0;
  for (const std::uint64_t n : places(count))
    for (const char* after : {"", "+"}) {
      const std::string place = "allocation " + std::to_string(n) + after + " of " + std::to_string(count);
      const ProcessResult result = run({"COPPICE_FAIL_MALLOC=" + std::to_string(n) + after});
      EXPECT_EQ(result.signal, 0) << place << "\n" << result.err;
      const auto files = outputs();
      if (result.exit_code == 0) {
        ++done;
        EXPECT_EQ(result.out.size() + 40 > whole.out.size(), true) << place << "\n" << result.out;
        EXPECT_EQ(files.size(), expected.size()) << place;
        for (const auto& [name, bytes] : files)
          EXPECT_TRUE(expected.count(name) == 1 && is_same_output(name, bytes, expected.at(name))) << place << ": " << name;
      } else {
        ++refused;
        EXPECT_TRUE(mentions(result.err, {"memory"})) << place;
        // Libraries below libcurl may have a line of their own where their constructors get no memory.
        EXPECT_EQ(lines_that_name(result.err, "coppice:"), 1u) << place << "\n" << result.err;
        for (const auto& [name, bytes] : files)
          EXPECT_TRUE(GetParam().arguments[0] == "bake-all") << place << ": " << name << " was written";
      }
    }
  EXPECT_GT(refused, 0u);
  RecordProperty("allocations", std::to_string(count));
  std::printf("%s: %llu allocations, %zu runs done, %zu out of memory\n", GetParam().name, static_cast<unsigned long long>(count), done,
              refused);
}

INSTANTIATE_TEST_SUITE_P(Commands, OutOfMemory, testing::ValuesIn(commands()),
                         [](const testing::TestParamInfo<Command>& command) { return std::string(command.param.name); });

}  // namespace coppice::test::out_of_memory_test
