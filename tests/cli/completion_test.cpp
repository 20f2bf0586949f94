// Completion of the programs' command lines as shells do it: the scripts that the programs print are run in bash, and in fish where it is.
// They call the programs, which are on PATH here.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "help_text.h"
#include "tool.h"

namespace coppice::test::completion_test {

namespace fs = std::filesystem;

/// A program that completes, and how it is asked for its script.
struct Program {
  std::string name;
  fs::path file;
  std::string argument;  ///< before the shell's name
};

const std::vector<Program>& programs() {
  static const std::vector<Program> all = {{"coppice", kTool, "completion"}, {"coppice-forest", kForest, "--completion"}};
  return all;
}

fs::path write_script(const Program& program, const std::string& shell, const TemporaryFolder& folder) {
  const ProcessResult result = run_process(program.file, {program.argument, shell});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out, "");
  fs::path path = folder.path() / (program.name + "." + shell);
  write_text(path, result.out);
  return path;
}

Words sorted_lines(const std::string& text) {
  std::set<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) lines.insert(line.substr(0, line.find('\t')));
  return {lines.begin(), lines.end()};
}

/// Scripts and a folder of files to complete.
class Completion : public testing::Test {
 protected:
  Completion() {
    fs::create_directories(files_ / "a folder");
    for (const char* name : {"oak.glb", "oak.gltf", "oak.coppice", "birch.coppice", "wood.forest", "map.png", "notes.txt"})
      write_text(files_ / name, "x");
  }

  /// What bash offers for the last word. Words as readline has them: = is one of its own.
  Words in_bash(const Words& line) {
    const Program& program = *std::ranges::find(programs(), line.front(), &Program::name);
    std::string function = "_" + program.name;
    std::ranges::replace(function, '-', '_');
    static const std::string complete =
        "source \"$1\"; cd \"$2\"; complete=$3; PATH=$4:$PATH; shift 4; COMP_WORDS=(\"$@\"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); "
        "$complete; printf '%s\\n' \"${COMPREPLY[@]}\"";
    const Words arguments = {"-u", "-c", complete, "bash", write_script(program, "bash", folder_), files_, function, programs_};
    const ProcessResult result = run_process(program_on_path("bash"), joined(arguments, line));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return sorted_lines(result.out);
  }

  /// Words, each with a tab and its description where it has one.
  std::string answer_of_fish(const std::string& line) {
    const Program& program = *std::ranges::find(programs(), line.substr(0, line.find(' ')), &Program::name);
    const ProcessResult result =
        run_process(program_on_path("fish"),
                    {"-c", "source $argv[1]; cd $argv[2]; set PATH $argv[4] $PATH; complete --do-complete $argv[3]",
                     write_script(program, "fish", folder_), files_, line, programs_},
                    {.environment = {"HOME=" + folder_.path().string()}});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  }

  TemporaryFolder folder_;
  fs::path files_ = folder_.path() / "files";
  fs::path programs_ = fs::path(kTool).parent_path();  // where both are
};

TEST_F(Completion, ScriptsAreWellFormed) {
  for (const std::string shell : {"bash", "zsh", "fish"}) {
    const fs::path interpreter = program_on_path(shell);
    for (const Program& program : programs()) {
      const fs::path script = write_script(program, shell, folder_);
      if (interpreter.empty()) continue;
      const ProcessResult result = run_process(interpreter, {"-n", script});
      EXPECT_EQ(result.exit_code, 0) << shell << ", " << program.name << ": " << result.err;
      EXPECT_EQ(result.err, "");
    }
    if (interpreter.empty()) std::printf("%s is not installed: its scripts are not parsed\n", shell.c_str());
  }
}

TEST_F(Completion, OffersWhatTheHelpLists) {
  for (const Program& program : programs()) {
    const std::string help = run_process(program.file, {"--help"}).out;
    Words commands = listed_commands(help), options = listed_options(help);
    std::ranges::sort(options);
    EXPECT_EQ(in_bash({program.name, "-"}), options);
    for (const std::string& command : commands) {
      options = listed_options(run_process(program.file, {command, "--help"}).out);
      EXPECT_GT(options.size(), 1u) << command;
      std::ranges::sort(options);
      EXPECT_EQ(in_bash({program.name, command, "-"}), options) << command;
    }
    std::ranges::sort(commands);
    if (program.name == "coppice") {
      EXPECT_GT(commands.size(), 8u);
      EXPECT_EQ(in_bash({program.name, ""}), commands);
    }
  }
}

TEST_F(Completion, BashOffersValuesAndFilesThatFit) {
  const std::vector<std::pair<Words, Words>> lines = {
      {{"coppice", "ba"}, {"bake", "bake-all"}},
      {{"coppice", "bake", "--metr"}, {"--metric"}},
      {{"coppice", "bake", "--metric", ""}, {"default", "geometric", "mi"}},
      {{"coppice", "bake", "--metric", "=", "g"}, {"geometric"}},
      {{"coppice", "bake", "--metric", "="}, {"default", "geometric", "mi"}},
      {{"coppice", "bake", "--views", ""}, {}},  // a number
      {{"coppice", "plant", ""}, {"corylus", "juniper", "willow"}},
      {{"coppice", "bake", ""}, {"a folder", "oak.glb", "oak.gltf"}},
      {{"coppice", "bake", "--quick", "--views", "4", "oak"}, {"oak.glb", "oak.gltf"}},
      {{"coppice", "bake", "oak.glb", ""}, {}},  // one plant is enough
      {{"coppice", "bake", "-o", "o"}, {"oak.coppice"}},
      {{"coppice", "bake-all", "-o", ""}, {"a folder"}},
      {{"coppice", "export", "--leaves", ""}, {"full"}},
      {{"coppice", "evaluate", "--methods", "mi,g"}, {"mi,geometric"}},
      {{"coppice", "scene", "--plants", "oak.coppice,b"}, {"oak.coppice,birch.coppice"}},
      {{"coppice", "scene", "--density", "oak", "=", "m"}, {"map.png"}},
      {{"coppice", "completion", ""}, {"bash", "fish", "zsh"}},
      {{"coppice", "no-such-command", ""}, {}},
      {{"coppice-forest", ""}, {"a folder", "birch.coppice", "oak.coppice"}},
      {{"coppice-forest", "--scene", ""}, {"a folder", "wood.forest"}},
      {{"coppice-forest", "oak.coppice", "--lod", "d"}, {"discrete"}},
      {{"coppice-forest", "--no-t"}, {"--no-taa"}},
      {{"coppice-forest", "--view", "o"}, {"occlusion", "overdraw"}},
      {{"coppice-forest", "--camera", "t"}, {"top", "turntable"}},
      {{"coppice-forest", "--camera", "n"}, {"notes.txt"}},
  };
  for (const auto& [line, offered] : lines) EXPECT_EQ(in_bash(line), offered) << testing::PrintToString(line);
}

TEST_F(Completion, FishOffersValuesAndFilesThatFit) {
  if (program_on_path("fish").empty()) GTEST_SKIP() << "fish is not installed";
  const std::vector<std::pair<std::string, Words>> lines = {
      {"coppice ba", {"bake", "bake-all"}},
      {"coppice bake --metric ", {"default", "geometric", "mi"}},
      {"coppice bake --metric=g", {"--metric=geometric"}},
      {"coppice bake o", {"oak.glb", "oak.gltf"}},
      {"coppice bake-all -o ", {"a folder/"}},
      {"coppice evaluate --methods mi,g", {"mi,geometric"}},
      {"coppice scene --density oak=m", {"oak=map.png"}},
      {"coppice-forest --no-t", {"--no-taa"}},
  };
  for (const auto& [line, offered] : lines) EXPECT_EQ(sorted_lines(answer_of_fish(line)), offered) << line;
  EXPECT_NE(answer_of_fish("coppice bake --metr").find("--metric\t"), std::string::npos) << "no description";
}

}  // namespace coppice::test::completion_test
