// The documents beside the programs and the source: options and commands of their calls exist, blocks of code work, names are names of
// something, and links lead somewhere. Tables of keys are compared where the files that they are of are written: cli_test, bake_all_test,
// evaluate_cli_test, demo_test.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "documents.h"
#include "help_text.h"
#include "tool.h"

namespace coppice::test::readme_test {

namespace fs = std::filesystem;
using Strings = std::set<std::string>;

/// Those that tell of the programs as they are.
const std::vector<fs::path>& manuals() {
  static const std::vector<fs::path> all = {"README.md",      "SECURITY.md",           "ARCHITECTURE.md",
                                            "bake/README.md", "bake/import/README.md", "bake/lab/README.md",
                                            "demo/README.md", "runtime/README.md"};
  return all;
}

/// The help of "coppice", of "coppice bake" and so on, and of "coppice-forest" where that is built.
const std::map<std::string, std::string>& helps() {
  static const std::map<std::string, std::string> all = [] {
    std::map<std::string, std::string> texts;
    texts["coppice"] = run_tool({"--help"}).out;
    for (const std::string& command : listed_commands(texts["coppice"])) texts["coppice " + command] = run_tool({command, "--help"}).out;
    texts["coppice-forest"] = run_process(kForest, {"--help"}).out;
    return texts;
  }();
  return all;
}

bool has_option(const std::string& program, const std::string& option) {
  const auto help = helps().find(program);
  if (help == helps().end()) return false;
  const Words options = listed_options(help->second);
  return std::ranges::find(options, option) != options.end();
}

/// Whether any program has the option; where coppice-forest is not built it may be one of that.
bool is_an_option(const std::string& option) {
  if (!helps().contains("coppice-forest")) return !option.empty();
  return std::ranges::any_of(helps(), [&](const auto& help) { return has_option(help.first, option); });
}

Words words_of(const std::string& text) {
  static const std::regex word_form(R"('[^']*'|[^ ]+)");
  Words words;
  for (std::sregex_iterator word(text.begin(), text.end(), word_form), end; word != end; ++word) words.push_back(word->str());
  return words;
}

/// "--metric" of "--metric=mi" and of "--json,"; empty where the word is no option.
std::string option_in(const std::string& word) {
  static const std::regex option_form("(--[a-z][a-z-]*|-[a-z])(=.*|[,.;:])?");
  std::smatch found;
  return std::regex_match(word, found, option_form) ? found[1].str() : "";
}

/// Options of a call of one of our programs that the program does not have, and unknown commands. Other lines have none.
Words faults_of_call(const std::string& call) {
  static const Strings program_names = {"coppice", "coppice-forest"};
  Words words = words_of(call), faults;
  std::string program = words.empty() ? "" : fs::path(words[0]).filename().string();
  if (!program_names.contains(program)) return {};
  const bool is_tool = program == "coppice";
  if (is_tool && words.size() > 1 && option_in(words[1]).empty()) {
    if (words[1] == "COMMAND") return {};
    program += " " + words[1];
    if (!helps().contains(program)) return {program + " is no command"};
  }
  bool is_comment = false;
  for (const std::string& word : words) {
    is_comment = is_comment || word.starts_with('#');
    if (word == "--") program = program == "coppice view" ? "coppice-forest" : "sbatch";  // as coppice bake-all has it
    if (!helps().contains(program)) continue;                                             // not built here
    const std::string option = option_in(word);
    if (!option.empty() && !(is_comment ? is_an_option(option) : has_option(program, option)))
      faults.push_back(std::string(program).append(" has no ").append(option));
  }
  return faults;
}

TEST(Readme, CallsInBlocksOfCodeAreOnesThatTheProgramsTake) {
  std::size_t call_count = 0;
  for (const fs::path& manual : manuals())
    for (const std::string& line : code_lines(source_text(manual))) {
      call_count += line.starts_with("coppice");
      for (const std::string& fault : faults_of_call(line)) ADD_FAILURE() << manual << ": " << line << ": " << fault;
    }
  EXPECT_GT(call_count, 30u);
}

TEST(Readme, OptionsAndCallsInTheTextExist) {
  std::size_t option_count = 0;
  for (const fs::path& manual : manuals())
    for (const std::string& span : code_spans(prose(source_text(manual)))) {
      for (const std::string& fault : faults_of_call(span)) ADD_FAILURE() << manual << ": " << span << ": " << fault;
      if (span == "--" || span.starts_with("-- ") || !span.starts_with("--")) continue;  // the second: options of another program
      ++option_count;
      const std::string option = option_in(words_of(span)[0]);
      EXPECT_TRUE(is_an_option(option)) << manual << ": " << span;
    }
  EXPECT_GT(option_count, 60u);
}

/// The headers of the runtime's functions.
std::string public_headers() {
  std::string text;
  for (const char* name : {"base", "context", "coppice", "frame", "hooks", "host", "scene", "vulkan"})
    text += source_text(std::string("runtime/include/coppice/") + name + ".h");
  return text;
}

TEST(BakeReadme, FilesOfClassesAndListsAreTaken) {
  const std::string readme = source_text("bake/README.md"), fence = "```json\n";
  const auto block_from = [&](const std::string& begin) {
    const std::size_t at = readme.find(fence + begin);
    EXPECT_NE(at, std::string::npos) << begin;
    return readme.substr(at + fence.size(), readme.find("```", at + fence.size()) - at - fence.size());
  };
  const TemporaryFolder folder;
  const fs::path plant = folder / "oak.glb", classes = folder / "classes.json", list = folder / "list.json";
  ASSERT_EQ(run_tool({"plant", "corylus", "-o", plant}).exit_code, 0);
  write_text(classes, block_from("{\"classes\""));
  const ProcessResult dry_run = run_tool({"bake", plant, "--dry-run", "--classes", classes});
  EXPECT_EQ(dry_run.exit_code, 0) << dry_run.err;
  // All is read before the first plant, whose leaves are called otherwise here.
  write_text(list, block_from("[{\"input\""));
  const ProcessResult batch = run_tool({"bake-all", list, "-o", folder / "baked", "--views", "2", "--resolution", "16"});
  EXPECT_TRUE(mentions(batch.err, {"oak.glb", "--leaf-material"}));
}

TEST(Documents, NamesOfTheApiAndPathsExist) {
  const std::string header = public_headers();
  static const std::regex name_form(R"((coppice_[a-z_]+)(\..*|\(.*)?)"),
      path_form(R"((tests|demo|bake|runtime|shaders|third_party)(/[A-Za-z0-9_.-]+)+)");
  std::size_t name_count = 0, path_count = 0;
  for (const char* manual : {"README.md", "ARCHITECTURE.md", "SECURITY.md", "bake/README.md", "bake/lab/README.md", "demo/README.md",
                             "runtime/README.md", "tests/README.md"})
    for (const std::string& span : code_spans(prose(source_text(manual)))) {
      std::smatch found;
      if (std::string(manual) == "runtime/README.md" && std::regex_match(span, found, name_form)) {
        ++name_count;
        EXPECT_TRUE(std::regex_search(header, std::regex("\\b" + found[1].str() + "\\b"))) << manual << ": " << span;
      }
      const std::string path = span.substr(0, span.find(' '));
      if (!std::regex_match(path, path_form)) continue;
      ++path_count;
      EXPECT_TRUE(fs::exists(source_folder() / path)) << manual << ": " << span;
    }
  EXPECT_GT(name_count, 15u);
  EXPECT_GT(path_count, 15u);
}

TEST(Documents, NamedTestsExist) {
  std::string sources;
  for (const auto& entry : fs::recursive_directory_iterator(source_folder() / "tests"))
    if (entry.path().extension() == ".cpp") sources += source_text(entry.path());
  static const std::regex test_form(R"(([A-Z][A-Za-z0-9]*Test)\.([A-Z][A-Za-z0-9]*))");
  std::size_t test_count = 0;
  for (const char* manual : {"runtime/README.md", "tests/README.md"})
    for (const std::string& span : code_spans(prose(source_text(manual)))) {
      std::smatch found;
      if (!std::regex_match(span, found, test_form)) continue;
      ++test_count;
      EXPECT_NE(sources.find("(" + found[1].str() + ", " + found[2].str() + ")"), std::string::npos) << manual << ": " << span;
    }
  EXPECT_GT(test_count, 20u);
}

TEST(Documents, NamedFilesOfSourceExist) {
  Strings names;
  for (const char* folder : {"bake", "demo", "runtime", "shaders", "tests", "third_party"})
    for (const auto& entry : fs::recursive_directory_iterator(source_folder() / folder)) names.insert(entry.path().filename());
  static const std::regex file_form(R"((.*/)?([a-z_0-9]+\.(h|cpp|c|comp|vert|frag|mjs|cmake)))");
  std::size_t file_count = 0;
  for (const fs::path& document : documents()) {
    if (document == "CHANGELOG.md" || document.string().starts_with("tests/bench/results")) continue;  // they tell what held on their day
    for (const std::string& span : code_spans(prose(source_text(document)))) {
      std::smatch found;
      if (!std::regex_match(span, found, file_form) || span.starts_with("draco/")) continue;
      ++file_count;
      EXPECT_TRUE(names.contains(found[2])) << document << ": " << span;
    }
  }
  EXPECT_GT(file_count, 40u);
}

/// The anchor of a heading, as GitHub makes it.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char letter : heading) {
    const auto byte = static_cast<unsigned char>(letter);
    if (letter == ' ' || letter == '-')
      anchor += '-';
    else if (std::isalnum(byte) != 0 || letter == '_' || byte >= 0x80)
      anchor += static_cast<char>(std::tolower(byte));
  }
  return anchor;
}

Strings anchors_of(const std::string& document) {
  static const std::regex heading_form(R"((^|\n)#+ ([^\n]+))");
  const std::string text = prose(document);
  std::map<std::string, int> counts;
  Strings anchors;
  for (std::sregex_iterator heading(text.begin(), text.end(), heading_form), end; heading != end; ++heading) {
    const std::string anchor = anchor_of((*heading)[2]);
    const int count = counts[anchor]++;
    anchors.insert(count == 0 ? anchor : anchor + "-" + std::to_string(count));
  }
  return anchors;
}

TEST(Documents, LinksLeadToFilesAndHeadings) {
  static const std::regex link_form(R"(\]\(([^)\s]+)\))");
  std::size_t link_count = 0;
  EXPECT_GT(documents().size(), 20u);
  for (const fs::path& document : documents()) {
    const std::string text = prose(source_text(document));
    for (std::sregex_iterator link(text.begin(), text.end(), link_form), end; link != end; ++link) {
      const std::string target = (*link)[1];
      if (target.find("://") != std::string::npos || target.starts_with("mailto:")) continue;
      ++link_count;
      const std::size_t hash = std::min(target.find('#'), target.size());
      const fs::path path = hash == 0 ? document : (document.parent_path() / target.substr(0, hash)).lexically_normal();
      ASSERT_TRUE(fs::exists(source_folder() / path)) << document << ": " << target;
      if (hash < target.size()) {
        EXPECT_TRUE(anchors_of(source_text(path)).contains(target.substr(hash + 1))) << document << ": " << target;
      }
    }
  }
  EXPECT_GT(link_count, 100u);
}

/// What the runtime's README gives an engine's lighting pass, in a shader that has nothing else but what the lines name.
TEST(Documents, TheLightingThatTheReadmeShowsCompiles) {
  const std::string text = source_text("runtime/README.md");
  const std::size_t first = text.find("```glsl\n"), end = text.find("```\n", first + 8);
  ASSERT_NE(end, std::string::npos);
  std::string lines = text.substr(first + 8, end - first - 8);
  const std::size_t body = lines.find("CoppiceSurface s");
  ASSERT_NE(body, std::string::npos);
  const fs::path shader = fs::temp_directory_path() / ("readme_light" + std::to_string(getpid()) + ".comp");
  std::ofstream(shader) << "#version 460\n#extension GL_GOOGLE_include_directive : require\n"
                        << lines.substr(0, body) << R"(
layout(set = 0, binding = 0) uniform sampler2D albedos;
layout(set = 0, binding = 1) uniform sampler2D normals;
layout(set = 0, binding = 2) uniform sampler2D lights;
layout(set = 0, binding = 3) uniform Light { vec3 sun_direction, sun_color, sky_color, ground_color, toward_eye; float your_shadow; };
layout(set = 0, binding = 4) writeonly buffer Lit { vec4 lit[]; };
void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy);
)" << lines.substr(body) << "lit[at.x] = vec4(radiance, 1.0);\n}\n";
  const ProcessResult compiled =
      run_process(kGlslang, {"-V", "--target-env", "vulkan1.3", "-I" + (source_folder() / "runtime/include/coppice").string(), "-o",
                             shader.string() + ".spv", shader.string()});
  EXPECT_EQ(compiled.exit_code, 0) << compiled.out << compiled.err;
  fs::remove(shader);
  fs::remove(shader.string() + ".spv");
}

}  // namespace coppice::test::readme_test
