#include "batch_manifest.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "atomic_file.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

Error wrong(Status status, const char* what, const std::string& place, const std::string& detail = {}) {
  return Error{status, what, Error::kNoOffset, detail.empty() ? place : place + ": " + detail};
}

std::string option_name(std::string key) {
  std::ranges::replace(key, '_', '-');
  return "--" + key;
}

/// "input, output, metric, views, ..."
std::string known_keys(const CLI::App& parser) {
  std::string text = "input, output";
  for (const CLI::Option* option : parser.get_options()) {
    std::string name = option->get_name().substr(2);
    std::ranges::replace(name, '-', '_');
    text += ", " + name;
  }
  return text;
}

/// As it would stand on the command line; nothing for an object, an array or null.
std::optional<std::string> value_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_structured() || value.is_null()) return {};
  return value.dump();
}

/// The first line of what CLI11 says.
std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

Result<BakeArguments> entry_arguments(const Json& entry, const std::string& place, const BakeArguments& defaults) {
  BakeArguments arguments = defaults;
  CLI::App parser;
  parser.set_help_flag("");
  add_bake_options(parser, arguments);
  for (const auto& [key, value] : entry.items()) {
    if (key == "input" || key == "output") continue;
    const std::string here = std::string(place).append(".").append(key);
    if (parser.get_option_no_throw(option_name(key)) == nullptr || key.find('-') != std::string::npos)
      return wrong(Status::invalid_argument, "no such key in a manifest", here, "there are " + known_keys(parser));
    const auto text = value_text(value);
    if (!text) return wrong(Status::invalid_argument, "neither a text, a number, true nor false", here);
    try {
      std::vector<std::string> words{option_name(key) + "=" + *text};
      parser.parse(words);
    } catch (const CLI::ParseError& error) {
      return wrong(Status::invalid_argument, "not a value of this option", here, first_line(error.what()));
    }
  }
  return arguments;
}

Result<std::string> text_member(const Json& entry, const char* key, const std::string& place) {
  const auto found = entry.find(key);
  if (found == entry.end()) return wrong(Status::bad_file, "a plant without this key", place + "." + key);
  if (!found->is_string() || found->get_ref<const std::string&>().empty()) return wrong(Status::bad_file, "not a path", place + "." + key);
  return found->get<std::string>();
}

bool stays_below(const std::filesystem::path& path) {
  return path.is_relative() && path.has_filename() && path != "." && *path.begin() != "..";
}

Result<BatchPlant> plant_of(const Json& entry, const std::string& place, const std::filesystem::path& input_folder,
                            const std::filesystem::path& output_folder, const BakeArguments& defaults) {
  if (!entry.is_object()) return wrong(Status::bad_file, "a plant of a manifest is not an object", place);
  COPPICE_TRY(arguments, entry_arguments(entry, place, defaults));
  COPPICE_TRY(input_text, text_member(entry, "input", place));
  const std::filesystem::path input = std::filesystem::path(input_text).lexically_normal();
  std::filesystem::path output = stays_below(input) ? input : input.filename();
  output.replace_extension(".coppice");
  if (entry.contains("output")) {
    COPPICE_TRY(output_text, text_member(entry, "output", place));
    output = std::filesystem::path(output_text).lexically_normal();
    if (!stays_below(output)) return wrong(Status::invalid_argument, "not a file below the output folder", place + ".output", output_text);
  }
  // Of the keys only these hold a path; like all in a manifest it is beside it, while that of the command is where the user is.
  if (entry.contains("classes")) arguments.classes.classes = input_folder / arguments.classes.classes;
  COPPICE_TRY(options, bake_options(arguments));
  return BatchPlant{input_folder / input, output_folder / output, std::move(options), arguments.import.all_variants};
}

}  // namespace

Result<std::vector<BatchPlant>> plants_of_manifest(const std::filesystem::path& manifest, const std::filesystem::path& output_folder,
                                                   const BakeArguments& defaults) {
  COPPICE_TRY(bytes, read_file(manifest));
  Json root;
  try {
    root = Json::parse(bytes.begin(), bytes.end());
  } catch (const Json::parse_error& error) {
    return Error{Status::bad_file, "the manifest is not JSON", error.byte > 0 ? error.byte - 1 : 0};
  } catch (const Json::exception& error) {  // a number that no type holds
    return Error{Status::bad_file, "the manifest is not JSON", Error::kNoOffset, error.what()};
  }
  if (!root.is_array() || root.empty()) return Error{Status::bad_file, "the manifest is not a list of plants"};
  std::vector<BatchPlant> plants;
  for (std::size_t i = 0; i < root.size(); ++i) {
    COPPICE_TRY(plant, plant_of(root[i], "[" + std::to_string(i) + "]", manifest.parent_path(), output_folder, defaults));
    plants.push_back(std::move(plant));
  }
  return plants;
}

Result<std::string> manifest_entry(const BatchPlant& plant, const std::filesystem::path& output_folder,
                                   const std::filesystem::path& classes_file) {
  // Every member by name: one that is added later does not compile until it is written below.
  const auto& [metric, view_count, thread_count, import, collapse, textures, crown_normals, leaf_meshes, areas, wind] = plant.options;
  const auto& [leaf_material, wood_material, classes, up, metres_per_unit, wind_color_set, choice, outside_files] = import;
  const auto& [node, variant, whole] = choice;
  const auto& [wind_moves, wind_stiffness] = wind;
  const auto& [resolution_px, count_background, candidate_count] = collapse;
  static_cast<void>(thread_count);  // the machine's

  Json entry = {{"input", std::filesystem::absolute(plant.input).lexically_normal().string()},
                {"output", plant.output.lexically_relative(output_folder).string()},
                {"metric", metric == Metric::mi          ? "mi"
                           : metric == Metric::geometric ? "geometric"
                                                         : "default"},
                {"resolution", resolution_px},
                {"candidates", candidate_count},
                {"background", count_background ? "on" : "off"},
                {"areas", areas == Areas::vulkan ? "vulkan" : "item-buffers"},
                {"textures", textures == TextureCoding::rgba8 ? "rgba8" : "bc"},
                {"crown_normals", crown_normals},
                {"leaf_meshes", leaf_meshes ? "on" : "off"},
                {"wind_stiffness", wind_stiffness},
                {"up", up == UpAxis::z ? "z" : "y"},
                {"unit", metres_per_unit},
                {"variant", whole ? Json("whole") : Json(variant)}};
  if (view_count > 0) entry["views"] = view_count;
  if (!wind_moves) entry["no_wind"] = true;
  if (wind_color_set) entry["wind_weights"] = "COLOR_" + std::to_string(*wind_color_set);
  if (leaf_material) entry["leaf_material"] = *leaf_material;
  if (wood_material) entry["wood_material"] = *wood_material;
  if (!classes.empty()) entry["classes"] = classes_file.string();
  if (node) entry["node"] = *node;
  if (outside_files == OutsideFiles::allowed) entry["allow_outside"] = true;
  try {
    return entry.dump();
  } catch (const Json::exception&) {
    return wrong(Status::invalid_argument, "a name that is not UTF-8", plant.input.string());
  }
}

std::string classes_text(const std::vector<ClassRule>& rules) {
  Json list = Json::array();
  for (const ClassRule& rule : rules) {
    const char* part = rule.part == PlantPart::leaf ? "leaf" : rule.part == PlantPart::wood ? "wood" : "drop";
    list.push_back(
        {{"material", rule.material}, {"class", part}, {"min_triangles", rule.min_triangles}, {"max_triangles", rule.max_triangles}});
  }
  return Json{{"classes", std::move(list)}}.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace coppice::bake
