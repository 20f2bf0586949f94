#include "option_table.h"

#include <array>
#include <cstdio>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "class_rules.h"
#include "gltf_cost.h"
#include "raster.h"
#include "text_bytes.h"
#include "text_number.h"
#include "viewpoints.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

Error wrong(std::string message) {
  return Error{Status::invalid_argument, "not a value of this option", Error::kNoOffset, std::move(message)};
}

// A member is a function from a BakeOptions& to a reference, const if the options are.

/// One of some words.
template <class E>
struct Word {
  const char* text;
  E value;
};

template <class E, class Member>
BakeOption choice(std::string name, std::string help, std::vector<Word<E>> words, Member member) {
  std::string type;
  for (const Word<E>& word : words) type += (type.empty() ? "" : "|") + std::string(word.text);
  BakeOption option{std::move(name), type, std::move(help)};
  option.set = [=](BakeRequest& request, const std::string& text) -> Result<void> {
    for (const Word<E>& word : words)
      if (text == word.text) return member(request.options) = word.value, Result<void>();
    return wrong(text + ": it is one of " + type);
  };
  option.get = [=](const BakeOptions& options) -> std::optional<std::string> {
    for (const Word<E>& word : words)
      if (member(options) == word.value) return word.text;
    return {};
  };
  return option;
}

template <class Member>
BakeOption on_off(std::string name, std::string help, Member member) {
  return choice<bool>(std::move(name), std::move(help), {{"on", true}, {"off", false}}, member);
}

std::string exact(std::uint32_t number) {
  return std::to_string(number);
}
std::string exact(double number, int digits) {
  std::array<char, 32> text{};
  static_cast<void>(std::snprintf(text.data(), text.size(), "%.*g", digits, number));
  return text.data();
}
std::string exact(float number) {
  return exact(static_cast<double>(number), 9);
}

template <class T, class Member>
BakeOption number(std::string name, std::string type, std::string help, T least, T greatest, Member member) {
  BakeOption option{std::move(name), std::move(type), std::move(help)};
  option.set = [=](BakeRequest& request, const std::string& text) -> Result<void> {
    const auto value = number_of<T>(text);
    if (!value || !(*value >= least && *value <= greatest))
      return wrong(text + ": a number from " + exact(least) + " to " + exact(greatest));
    member(request.options) = *value;
    return {};
  };
  option.get = [=](const BakeOptions& options) -> std::optional<std::string> { return exact(member(options)); };
  return option;
}

template <class Member>
BakeOption text(std::string name, std::string type, std::string help, Member member) {
  BakeOption option{std::move(name), std::move(type), std::move(help)};
  option.set = [=](BakeRequest& request, const std::string& value) -> Result<void> {
    return member(request.options) = value, Result<void>();
  };
  option.get = [=](const BakeOptions& options) { return member(options); };
  return option;
}

/// set: called with the flag's state, "true" where nothing follows it.
BakeOption flag(std::string name, std::string help, std::function<void(BakeRequest&, bool)> set,
                std::function<bool(const BakeOptions&)> get) {
  BakeOption option{std::move(name), "", std::move(help)};
  option.set = [set = std::move(set)](BakeRequest& request, const std::string& value) -> Result<void> {
    if (value != "true" && value != "false") return wrong(value + ": true or false");
    set(request, value == "true");
    return {};
  };
  option.get = [get = std::move(get)](const BakeOptions& options) {
    return get(options) ? std::optional<std::string>("true") : std::nullopt;
  };
  return option;
}

// Nanometres to light seconds: what lies outside is a slip of the keyboard.
constexpr double kMinUnit_m = 1e-9, kMaxUnit_m = 1e9;

Result<void> set_unit(BakeRequest& request, const std::string& text) {
  constexpr std::array<std::pair<std::string_view, double>, 5> kUnits{
      {{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}};
  double metres = number_of<double>(text).value_or(0.0);
  for (const auto& [name, length] : kUnits)
    if (text == name) metres = length;
  if (!(metres >= kMinUnit_m && metres <= kMaxUnit_m))
    return wrong(text + ": m, cm, mm, in, ft or a number of metres between 1e-9 and 1e9");
  request.options.import.metres_per_unit = metres;
  return {};
}

Result<void> set_variant(BakeRequest& request, const std::string& text) {
  PlantChoice& plant = request.options.import.plant;
  request.all_variants = text == "all";
  plant.whole = text == "whole";
  if (request.all_variants || plant.whole) return {};
  plant.variant = number_of<std::uint32_t>(text).value_or(0);
  return plant.variant > 0 ? Result<void>() : wrong(text + ": a number from 1 on, all, or whole");
}

Result<void> set_wind_weights(BakeRequest& request, const std::string& text) {
  constexpr std::string_view kPrefix = "COLOR_";
  const auto set = number_of<std::uint32_t>(text.starts_with(kPrefix) ? std::string_view(text).substr(kPrefix.size()) : std::string_view());
  if (!set) return wrong(text + ": a set of vertex colours, COLOR_0, COLOR_1 and so on");
  request.options.import.wind_color_set = *set;
  return {};
}

std::string rules_text(const std::vector<ClassRule>& rules) {
  Json list = Json::array();
  for (const ClassRule& rule : rules) {
    const char* part = rule.part == PlantPart::leaf ? "leaf" : rule.part == PlantPart::wood ? "wood" : "drop";
    list.push_back(
        {{"material", rule.material}, {"class", part}, {"min_triangles", rule.min_triangles}, {"max_triangles", rule.max_triangles}});
  }
  return json_line(Json{{"classes", std::move(list)}});
}

std::vector<BakeOption> bake_group() {
  std::vector<BakeOption> table;
  table.push_back(choice<Metric>(
      "metric",
      "What orders the collapses: default is the least error of the picture, which measures best; mi is the paper's viewpoint mutual "
      "information; geometric merges what is nearest and most alike, for comparison",
      {{"default", Metric::default_metric}, {"mi", Metric::mi}, {"geometric", Metric::geometric}},
      [](auto& o) -> auto& { return o.metric; }));
  table.push_back(number<std::uint32_t>(
      "views", "N", "Viewpoints; 20 is the paper's dodecahedron. By default 20; 42 for the default metric, 32 of it for over 8,192 leaves",
      1, kMaxViewCount, [](auto& o) -> auto& { return o.view_count; }));
  table.back().get = [](const BakeOptions& o) { return o.view_count > 0 ? std::optional(exact(o.view_count)) : std::nullopt; };
  table.push_back(number<std::uint32_t>(
      "resolution", "PX", "Side of an item buffer in pixels", 16, kMaxResolutionPx,
      [](auto& o) -> auto& { return o.collapse.resolution_px; }));
  table.push_back(on_off(
      "background", "Count the background as one more outcome", [](auto& o) -> auto& { return o.collapse.count_background; }));
  table.push_back(number<std::uint32_t>(
      "candidates", "N",
      "The octree cell of candidates grows until it holds so many. The default metric looks at up to four times as many where what it "
      "merges no longer covers the crown",
      1, kMaxCandidateCount, [](auto& o) -> auto& { return o.collapse.candidate_count; }));
  table.push_back(flag(
      "quick",
      "Four to eight times faster, for a first look: fewer and smaller views, fewer candidates, where --views, --resolution and "
      "--candidates "
      "do not say otherwise. The picture's error grows by about 5 %, of plants a few pixels large by a fifth",
      [](BakeRequest& request, bool on) { request.quick = on; }, [](const BakeOptions&) { return false; }));
  table.push_back(choice<Areas>(
      "areas",
      "Who measures the projected areas of --metric mi: item-buffers, or the paper's occlusion queries on a Vulkan device, at every step "
      "for up to " +
          std::to_string(kMaxMeasuredLeaves) + " leaves and only before the first for more. Another driver may then give another file",
      {{"item-buffers", Areas::item_buffers}, {"vulkan", Areas::vulkan}}, [](auto& o) -> auto& { return o.areas; }));
  table.push_back(choice<TextureCoding>(
      "textures",
      "How textures are stored: bc is BC1 and BC3 blocks, which a GPU reads as they are; rgba8 takes four to eight times the bytes",
      {{"bc", TextureCoding::bc}, {"rgba8", TextureCoding::rgba8}}, [](auto& o) -> auto& { return o.textures; }));
  table.push_back(number<float>(
      "crown-normals", "SHARE",
      "How leaves are lit: 0 each by the normals that the file gives it, 1 by those of the crown's round shape, which is softer", 0.0f,
      1.0f, [](auto& o) -> auto& { return o.crown_normals; }));
  table.push_back(on_off(
      "leaf-meshes", "Keep the leaves as they were modelled, to be drawn close up, where the error of their quads would be seen",
      [](auto& o) -> auto& { return o.leaf_meshes; }));
  table.push_back(number<float>(
      "wind-stiffness", "FACTOR",
      "How stiff the plant is in wind, against what its wood tells: 2 moves half as far, 0.5 twice as far where limits let it",
      kMinWindStiffness, kMaxWindStiffness, [](auto& o) -> auto& { return o.wind.stiffness; }));
  table.push_back({"wind-weights", "COLOR_N",
                   "The vertex colours whose red says how flexible a place is, from 0, stiff, to 1; they are then no tint. Without it an "
                   "attribute _WIND_WEIGHT or _WIND does",
                   OptionGroup::bake, set_wind_weights, [](const BakeOptions& o) {
                     const auto& set = o.import.wind_color_set;
                     return set ? std::optional("COLOR_" + std::to_string(*set)) : std::nullopt;
                   }});
  table.push_back(flag(
      "no-wind", "Wind does not move the plant", [](BakeRequest& request, bool on) { request.options.wind.moves = !on; },
      [](const BakeOptions& o) { return !o.wind.moves; }));
  return table;
}

std::vector<BakeOption> classes_group() {
  std::vector<BakeOption> table;
  table.push_back(text(
      "leaf-material", "REGEX",
      "All of the materials whose name this regular expression finds is leaves, everything else wood. Without it leaves are found by name, "
      "alpha mask, shape, repetition and colour",
      [](auto& o) -> auto& { return o.import.leaf_material; }));
  table.push_back(text(
      "wood-material", "REGEX", "All of the materials whose name this regular expression finds is wood",
      [](auto& o) -> auto& { return o.import.wood_material; }));
  table.push_back(
      {"classes", "F.json",
       "Say for each material what it is: {\"classes\": [{\"material\": \"^Leaves$\", \"class\": \"leaf\"}, ...]}. The first entry decides "
       "whose regular expression finds the material's name. A class is leaf, wood or drop. An entry may also have \"min_triangles\" and "
       "\"max_triangles\" of a connected piece",
       OptionGroup::classes, [](BakeRequest& request, const std::string& value) { return request.classes = value, Result<void>(); },
       [](const BakeOptions& o) { return o.import.classes.empty() ? std::nullopt : std::optional(rules_text(o.import.classes)); }});
  return table;
}

std::vector<BakeOption> units_group() {
  std::vector<BakeOption> table;
  table.push_back(choice<UpAxis>(
      "up", "The file's axis that points to the sky; glTF says y, but not every exporter turns its z", {{"y", UpAxis::y}, {"z", UpAxis::z}},
      [](auto& o) -> auto& { return o.import.up; }));
  table.push_back({"unit", "m|cm|mm|in|ft|FACTOR", "The file's unit of length, by name or as a number of metres; glTF says m",
                   OptionGroup::units, set_unit, [](const BakeOptions& o) { return std::optional(exact(o.import.metres_per_unit, 17)); }});
  table.push_back(flag(
      "allow-outside", "Read files outside the input's folder where it names any; a scene may name plants outside its own",
      [](BakeRequest& request, bool on) { request.options.import.outside_files = on ? OutsideFiles::allowed : OutsideFiles::refused; },
      [](const BakeOptions& o) { return o.import.outside_files == OutsideFiles::allowed; }));
  table.back().changes_result = false;  // nor with a file that is refused
  table.push_back(number<std::uint32_t>(
      "max-source-triangles", "N",
      "Refuse a file that asks for more triangles, in all places where it shows them, before any is read. Whatever else takes their memory "
      "counts too. By default as many as the memory that it may use (of the machine, its control group, ulimit -v) holds at 1 kB each, at "
      "most " +
          std::to_string(kMaxSourceTriangles),
      1, kMaxSourceTriangles, [](auto& o) -> auto& { return o.import.max_source_triangles; }));
  table.back().get = [](const BakeOptions& o) {
    return o.import.max_source_triangles > 0 ? std::optional(exact(o.import.max_source_triangles)) : std::nullopt;
  };
  table.back().changes_result = false;
  return table;
}

std::vector<BakeOption> plant_group() {
  std::vector<BakeOption> table;
  table.push_back(text(
      "node", "NAME", "Of a file with several plants, take what is below nodes of this name, or whose names this regular expression finds",
      [](auto& o) -> auto& { return o.import.plant.node; }));
  table.push_back({"variant", "N|all|whole",
                   "Which of several plants in the file; --dry-run lists them, 1 is the default. all: each into a file of its own. whole: "
                   "the file is one plant, with its levels of detail and billboards",
                   OptionGroup::plant, set_variant, [](const BakeOptions& o) {
                     return std::optional(o.import.plant.whole ? std::string("whole") : exact(o.import.plant.variant));
                   }});
  table.push_back(choice<Origin>(
      "origin",
      "The plant's origin, about which engines place it: the file's, the foot of the trunk, or the middle of the plant. By default the "
      "file's, or the foot where the file's lies outside the plant",
      {{"keep", Origin::keep}, {"foot", Origin::foot}, {"center", Origin::center}}, [](auto& o) -> auto& { return o.import.origin; }));
  return table;
}

}  // namespace

const std::vector<BakeOption>& bake_option_table() {
  static const std::vector<BakeOption> table = [] {
    std::vector<BakeOption> all;
    const auto add = [&all](OptionGroup group, std::vector<BakeOption> options) {
      for (BakeOption& option : options) {
        option.group = group;
        all.push_back(std::move(option));
      }
    };
    add(OptionGroup::bake, bake_group());
    add(OptionGroup::classes, classes_group());
    add(OptionGroup::units, units_group());
    add(OptionGroup::plant, plant_group());
    return all;
  }();
  return table;
}

Result<BakeOptions> bake_options(const BakeRequest& request) {
  BakeOptions options = request.options;
  const BakeOptions defaults;
  const auto quicken = [&](auto member, auto value) {
    if (request.quick && member(options) == member(defaults)) member(options) = value;
  };
  quicken(
      [](auto& o) -> auto& { return o.view_count; }, kQuickViewCount);
  quicken(
      [](auto& o) -> auto& { return o.collapse.resolution_px; }, kQuickResolution_px);
  quicken(
      [](auto& o) -> auto& { return o.collapse.candidate_count; }, kQuickCandidateCount);
  COPPICE_CHECK(check_areas(options));
  if (request.classes.empty()) return options;
  const bool is_json = request.classes.starts_with('{');
  std::string json = request.classes;
  if (!is_json) {
    COPPICE_TRY(bytes, read_file(request.classes));
    json.assign(bytes.begin(), bytes.end());
  }
  COPPICE_TRY(rules, parse_class_rules(json, is_json ? "classes" : request.classes));
  options.import.classes = std::move(rules);
  return options;
}

}  // namespace coppice::bake
