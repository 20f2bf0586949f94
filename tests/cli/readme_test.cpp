// The documents beside the programs and the source: options, commands, values and defaults that they tell of are those of --help, names are
// names of something, and links lead somewhere. Tables of keys are compared where the files that they are of are written: cli_test,
// bake_all_test, evaluate_cli_test, demo_test; the table of glTF extensions in import_gltf_extensions_test.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "documents.h"
#include "help_text.h"
#include "process.h"

namespace coppice::test {
namespace {

namespace fs = std::filesystem;
using Strings = std::set<std::string>;

/// Those that tell of the programs as they are.
const std::vector<fs::path>& manuals() {
  static const std::vector<fs::path> all = {"README.md",      "SECURITY.md",    "ARCHITECTURE.md",
                                            "bake/README.md", "demo/README.md", "runtime/README.md"};
  return all;
}

/// The help of "coppice", of "coppice bake" and so on, and of "coppice-forest" where that is built.
const std::map<std::string, std::string>& helps() {
  static const std::map<std::string, std::string> all = [] {
    std::map<std::string, std::string> texts;
    texts["coppice"] = run_process(COPPICE_TOOL, {"--help"}).out;
    for (const std::string& command : listed_commands(texts["coppice"]))
      texts["coppice " + command] = run_process(COPPICE_TOOL, {command, "--help"}).out;
#ifdef COPPICE_FOREST
    texts["coppice-forest"] = run_process(COPPICE_FOREST, {"--help"}).out;
#endif
    return texts;
  }();
  return all;
}

bool has_option(const std::string& program, const std::string& option) {
  const auto help = helps().find(program);
  if (help == helps().end()) return false;
  const std::vector<std::string> options = listed_options(help->second);
  return std::ranges::find(options, option) != options.end();
}

/// Of any program; where coppice-forest is not built it may be one of that.
bool is_an_option(const std::string& option) {
  if (!helps().contains("coppice-forest")) return !option.empty();
  return std::ranges::any_of(helps(), [&](const auto& help) { return has_option(help.first, option); });
}

std::vector<std::string> words_of(const std::string& text) {
  static const std::regex word_form(R"('[^']*'|[^ ]+)");
  std::vector<std::string> words;
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
std::vector<std::string> faults_of_call(const std::string& call) {
  static const Strings program_names = {"coppice", "coppice-forest"};
  std::vector<std::string> words = words_of(call), faults;
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
    if (word == "--") program = program == "coppice view" ? "coppice-forest" : "sbatch";  // of coppice bake-all
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

TEST(Readme, TellsOfEveryCommandAndOfNoOther) {
  const std::vector<std::string> listed = listed_commands(helps().at("coppice"));
  Strings told;
  const std::string text = source_text("bake/README.md"), heading = "## Commands";
  const std::size_t begin = text.find(heading);
  ASSERT_NE(begin, std::string::npos);
  for (const std::string& line : code_lines(text.substr(begin, text.find("\n## ", begin) - begin)))
    if (const std::vector<std::string> words = words_of(line); words.size() > 1 && words[0] == "coppice") told.insert(words[1]);
  EXPECT_GT(listed.size(), 8u);
  EXPECT_EQ(told, Strings(listed.begin(), listed.end()));
}

#ifdef COPPICE_FOREST
/// "256" and "1024" of "256, and one for every 1,024 of `--count`, by default" beside "[256, and one for every 1024 of --count]".
std::vector<std::string> numbers_in(std::string text) {
  static const std::regex number_form(R"([0-9][0-9.]*)"), thousands_form(R"((\d),(\d\d\d))");
  text = std::regex_replace(text, thousands_form, "$1$2");
  std::vector<std::string> numbers;
  for (std::sregex_iterator number(text.begin(), text.end(), number_form), end; number != end; ++number) numbers.push_back(number->str());
  return numbers;
}

/// What an option's help has in its last brackets.
std::string default_of(const std::string& program, const std::string& option) {
  const std::string text = option_texts(helps().at(program)).at(option);
  const std::size_t begin = text.rfind('[');
  return begin == std::string::npos ? "" : text.substr(begin + 1, text.find(']', begin) - begin - 1);
}

TEST(DemoReadme, TableOfOptionsIsTrue) {
  const std::string readme = source_text("demo/README.md"), help = helps().at("coppice-forest");
  const std::map<std::string, std::string> texts = option_texts(help);
  std::size_t default_count = 0, value_count = 0;
  for (const auto& row : table_after(readme, "| option | effect |")) {
    std::string last;
    for (const std::string& span : code_spans(row.at(0))) {
      const std::vector<std::string> words = words_of(span);
      std::string value = words[0];  // of the option before, as `discrete` after "--lod cut"
      if (!option_in(words[0]).empty()) {
        last = option_in(words[0]);
        EXPECT_TRUE(has_option("coppice-forest", last)) << span;
        value = words.size() > 1 ? words[1] : "";
      }
      const std::string type = words_of(texts.at(last)).at(0);
      if (!value.empty() && type.find('|') != std::string::npos) {
        EXPECT_NE(("|" + type + "|").find("|" + value + "|"), std::string::npos) << last << " " << value;
        ++value_count;
      }
    }
    if (const std::size_t said = row.at(1).find(" by default"); said != std::string::npos && !numbers_in(row[1].substr(0, said)).empty()) {
      const std::string text = row[1].substr(0, said);
      EXPECT_EQ(numbers_in(text.substr(text.find_first_of("0123456789"))), numbers_in(default_of("coppice-forest", last))) << row[0];
      ++default_count;
    }
  }
  EXPECT_GT(default_count, 1u) << "--error-px and --memory-mb";
  EXPECT_GT(value_count, 5u) << "--lod and --path";
}

TEST(DemoReadme, TellsOfEveryOption) {
  const std::string readme = source_text("demo/README.md");
  for (const std::string& option : listed_options(helps().at("coppice-forest")))
    if (option.starts_with("--")) {
      EXPECT_TRUE(std::regex_search(readme, std::regex(option + "\\b(?!-)"))) << option;
    }
}

TEST(DemoReadme, CamerasAreThoseOfTheHelp) {
  const Table table = table_after(source_text("demo/README.md"), "| `--camera` | way |");
  Strings cameras;
  for (const auto& row : table)
    for (const std::string& name : words_of(std::regex_replace(row.at(0), std::regex("[`,]"), ""))) cameras.insert(name);
  Strings listed;
  const std::string type = words_of(option_texts(helps().at("coppice-forest")).at("--camera")).at(0);
  for (const std::string& name : words_of(std::regex_replace(type, std::regex(R"(\|)"), " "))) listed.insert(name);
  EXPECT_EQ(cameras, listed);
}
#endif

/// Both public headers of the runtime.
std::string public_headers() {
  return source_text("runtime/include/coppice/coppice.h") + source_text("runtime/include/coppice/vulkan.h");
}

TEST(Readme, DefaultThresholdIsThatOfTheHeader) {
  const std::string header = public_headers();
  EXPECT_NE(source_text("runtime/README.md").find("`coppice_camera.error_px` is the error threshold, 2 px by default"), std::string::npos);
  const std::string comment = "Threshold, > 0, at most 1e6; default 2.";
  EXPECT_LT(header.find("float error_px;") - header.find(comment), 600u) << "the header has another default";
}

TEST(Readme, MethodsOfEvaluateAreThoseOfTheHelp) {
  std::string text = option_texts(helps().at("coppice evaluate")).at("--methods");
  text = text.substr(text.find("without, "));
  const std::string row = [] {
    for (const auto& cells : table_after(source_text("bake/README.md"), "| `plant`, `source_leaves` |"))
      if (cells.at(0) == "`name`") return cells.at(1);
    return std::string();
  }();
  Strings told, listed;
  for (const std::string& span : code_spans(row))
    if (std::regex_match(span, std::regex("[a-z_]+"))) told.insert(span);
  static const std::regex list_form("[a-z_]+(,[a-z_]+)+");
  for (std::sregex_iterator list(text.begin(), text.end(), list_form), end; list != end; ++list)
    for (const std::string& name : words_of(std::regex_replace(list->str(), std::regex(","), " "))) listed.insert(name);
  EXPECT_GT(listed.size(), 10u) << text;
  EXPECT_EQ(told, listed);
}

/// Names of the folders in a folder of the source.
Strings folders_in(const fs::path& path) {
  Strings names;
  for (const auto& entry : fs::directory_iterator(source_folder() / path))
    if (entry.is_directory()) names.insert(entry.path().filename());
  return names;
}

TEST(BakeReadme, RoomsAreTheFoldersAndStandOnWhatTheyLink) {
  const Table table = table_after(source_text("bake/README.md"), "## Rooms");
  EXPECT_EQ(column_spans(table, 0), folders_in("bake/src"));
  const std::string cmake = source_text("bake/CMakeLists.txt");
  static const std::regex room_form(R"(coppice_bake_room\((\w+)\s+(?:SEES ([\w ]+)\n)?)");
  std::size_t room_count = 0;
  for (std::sregex_iterator room(cmake.begin(), cmake.end(), room_form), end; room != end; ++room) {
    const std::string name = (*room)[1];
    if ((*room)[2].length() == 0) continue;
    ++room_count;
    const std::vector<std::string> seen = words_of((*room)[2]);
    for (const auto& row : table)
      if (row.at(0) == "`" + name + "`") {
        const std::vector<std::string> told = code_spans(row.at(2));
        EXPECT_EQ(Strings(told.begin(), told.end()), Strings(seen.begin(), seen.end())) << name;
      }
  }
  EXPECT_GT(room_count, 15u);
}

TEST(Architecture, TableOfFoldersHasEveryRoom) {
  const Table table = table_after(source_text("ARCHITECTURE.md"), "| folder | target | what |");
  Strings rooms, folders = folders_in("bake/src");
  static const std::regex rooms_form(R"(bake/src/(?:\{([a-z_,]+)\}|([a-z_]+)))");
  for (const auto& row : table) {
    const std::string& cell = row.at(0);
    const auto add = [&](const std::string& names) {
      for (const std::string& name : words_of(std::regex_replace(names, std::regex(","), " "))) rooms.insert(name);
    };
    for (std::sregex_iterator found(cell.begin(), cell.end(), rooms_form), end; found != end; ++found)
      add((*found)[1].matched ? (*found)[1] : (*found)[2]);
    if (cell.find("bake/src/command_line") != std::string::npos)  // "`bake/src/command_line`, `cli`"
      for (const std::string& span : code_spans(cell)) rooms.insert(fs::path(span).filename());
  }
  EXPECT_EQ(rooms, folders);
}

/// The first column of a table of folders, "`shared/`".
Strings folders_told(const fs::path& document, const std::string& heading) {
  Strings names;
  for (const std::string& span : column_spans(table_after(source_text(document), heading), 0)) names.insert(span.substr(0, span.find('/')));
  return names;
}

TEST(Documents, TablesOfFoldersAreWhole) {
  EXPECT_EQ(folders_told("shaders/README.md", "| folder |"), folders_in("shaders"));
  EXPECT_EQ(folders_told("runtime/src/gpu/README.md", "| folder |"), folders_in("runtime/src/gpu"));
  EXPECT_EQ(folders_told("tests/README.md", "| folder |"), folders_in("tests"));
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
  ASSERT_EQ(run_process(COPPICE_TOOL, {"plant", "corylus", "-o", plant}).exit_code, 0);
  std::ofstream(classes) << block_from("{\"classes\"");
  const ProcessResult dry_run = run_process(COPPICE_TOOL, {"bake", plant, "--dry-run", "--classes", classes});
  EXPECT_EQ(dry_run.exit_code, 0) << dry_run.err;
  // All is read before the first plant, whose leaves are called otherwise here.
  std::ofstream(list) << block_from("[{\"input\"");
  const ProcessResult batch = run_process(COPPICE_TOOL, {"bake-all", list, "-o", folder / "baked", "--views", "2", "--resolution", "16"});
  EXPECT_NE(batch.err.find("--leaf-material matches none"), std::string::npos) << batch.err;
  const std::string help = option_texts(helps().at("coppice bake")).at("--classes");
  for (const std::string& key : column_spans(table_after(readme, fence + "{\"classes\""), 0))
    EXPECT_NE(help.find("\"" + key + "\""), std::string::npos) << key << " is not in the help of --classes";
}

TEST(RuntimeReadme, HooksAreThoseOfTheHeader) {
  const std::string headers = public_headers();
  static const std::regex hook_form(R"(\n  const coppice_([a-z_]+)\* ([a-z_]+);)");
  Strings hooks;
  for (const std::string begin : {"typedef struct coppice_context_desc {", "typedef struct coppice_vulkan_desc {"}) {
    const std::size_t at = headers.find(begin);
    ASSERT_NE(at, std::string::npos);
    const std::string desc = headers.substr(at, headers.find("\n}", at) - at);
    for (std::sregex_iterator hook(desc.begin(), desc.end(), hook_form), end; hook != end; ++hook) hooks.insert((*hook)[2]);
  }
  EXPECT_EQ(column_spans(table_after(source_text("runtime/README.md"), "| hook |"), 0), hooks);
}

/// The lines of a file that are no comments.
std::vector<std::string> listed_in(const fs::path& path) {
  std::istringstream lines(source_text(path));
  std::vector<std::string> listed;
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && line[0] != '#') listed.push_back(line);
  return listed;
}

TEST(ThirdParty, EveryPackageHasItsReason) {
  const std::string readme = source_text("third_party/README.md");
  const std::vector<std::string> packages = listed_in("third_party/packages.txt");
  EXPECT_GT(packages.size(), 25u);
  for (const std::string& package : packages)
    EXPECT_TRUE(std::regex_search(readme, std::regex("\n\\| ([a-z0-9.-]+, )*" + package + "[ ,]"))) << package;
}

TEST(TestsReadme, StagesArePresets) {
  const std::string presets = source_text("CMakePresets.json"), run = source_text("tests/run");
  for (const std::string& stage : column_spans(table_after(source_text("tests/README.md"), "| stage |"), 0))
    EXPECT_NE(presets.find("{\"name\": \"" + stage + "\", \"inherits\""), std::string::npos) << stage;
  const std::string begin = "valgrind_programs=(";
  const std::size_t at = run.find(begin) + begin.size();
  std::size_t program_count = 0;
  static const std::regex program_form("[a-z_]+_test");
  const std::string list = run.substr(at, run.find(")\n", at) - at), cmake = source_text("tests/CMakeLists.txt");
  for (std::sregex_iterator program(list.begin(), list.end(), program_form), end; program != end; ++program, ++program_count)
    EXPECT_NE(cmake.find("coppice_test(" + program->str() + " "), std::string::npos) << program->str();
  EXPECT_GT(program_count, 15u);
}

TEST(Documents, NamesOfTheApiAndPathsExist) {
  const std::string header = public_headers();
  static const std::regex name_form(R"((coppice_[a-z_]+)(\..*|\(.*)?)"),
      path_form(R"((tests|demo|bake|runtime|shaders|third_party)(/[A-Za-z0-9_.-]+)+)");
  std::size_t name_count = 0, path_count = 0;
  for (const char* manual :
       {"README.md", "ARCHITECTURE.md", "SECURITY.md", "bake/README.md", "demo/README.md", "runtime/README.md", "tests/README.md"})
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

TEST(Documents, NamedFilesOfSourceExist) {
  Strings names;
  for (const char* folder : {"bake", "demo", "runtime", "shaders", "tests", "third_party"})
    for (const auto& entry : fs::recursive_directory_iterator(source_folder() / folder)) names.insert(entry.path().filename());
  static const std::regex file_form(R"((.*/)?([a-z_0-9]+\.(h|cpp|c|comp|vert|frag|mjs|cmake)))");
  std::size_t file_count = 0;
  for (const fs::path& document : documents()) {
    if (document == "CHANGELOG.md" || document.string().starts_with("tests/bench/results")) continue;  // of their day
    for (const std::string& span : code_spans(prose(source_text(document)))) {
      std::smatch found;
      if (!std::regex_match(span, found, file_form) || span.starts_with("draco/")) continue;
      ++file_count;
      EXPECT_TRUE(names.contains(found[2])) << document << ": " << span;
    }
  }
  EXPECT_GT(file_count, 40u);
}

/// Of a heading, as GitHub makes it.
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
      run_process(COPPICE_GLSLANG, {"-V", "--target-env", "vulkan1.3", "-I" + (source_folder() / "runtime/include/coppice").string(), "-o",
                                    shader.string() + ".spv", shader.string()});
  EXPECT_EQ(compiled.exit_code, 0) << compiled.out << compiled.err;
  fs::remove(shader);
  fs::remove(shader.string() + ".spv");
}

TEST(Documents, DecisionsAreAllListed) {
  const std::string text = source_text("DECISIONS.md");
  for (const std::string& anchor : anchors_of(text))
    if (anchor != "decisions" && anchor != "contents") {
      EXPECT_NE(text.find("](#" + anchor + ")"), std::string::npos) << anchor;
    }
}

TEST(Documents, ReadmeIsShort) {
  const std::string text = source_text("README.md");
  EXPECT_LE(std::ranges::count(text, '\n'), 100);
}

}  // namespace
}  // namespace coppice::test
