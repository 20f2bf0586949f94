#include "batch_manifest.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "printable.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

Error wrong(Status status, const char* what, const std::string& place, const std::string& detail = {}) {
  return Error{status, what, Error::kNoOffset, detail.empty() ? place : place + ": " + detail};
}

/// The name of an option as a key.
std::string list_key(const BakeOption& option) {
  std::string key = option.name;
  std::ranges::replace(key, '-', '_');
  return key;
}

/// "input, output, metric, views, ..."
std::string known_keys() {
  std::string text = "input, output";
  for (const BakeOption& option : bake_option_table()) text += ", " + list_key(option);
  return text;
}

/// As it would stand on the command line; nothing for an object, an array or null.
std::optional<std::string> value_text(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_structured() || value.is_null()) return {};
  return value.dump();
}

Result<BakeRequest> entry_request(const Json& entry, const std::string& place, const BakeRequest& defaults) {
  BakeRequest request = defaults;
  for (const auto& [key, value] : entry.items()) {
    if (key == "input" || key == "output") continue;
    const std::string here = std::string(place).append(".").append(key);
    const auto option = std::ranges::find(bake_option_table(), key, list_key);
    if (option == bake_option_table().end())
      return wrong(Status::invalid_argument, "no such key in a manifest", here, "there are " + known_keys());
    const auto text = value_text(value);
    if (!text) return wrong(Status::invalid_argument, "neither a text, a number, true nor false", here);
    if (key == "classes" && !text->starts_with('{') && has_control_character(*text)) return wrong(Status::bad_file, "not a path", here);
    if (const auto set = option->set(request, *text); !set)
      return wrong(Status::invalid_argument, set.error().what, here, set.error().detail);
  }
  return request;
}

Result<std::string> text_member(const Json& entry, const char* key, const std::string& place) {
  const auto found = entry.find(key);
  if (found == entry.end()) return wrong(Status::bad_file, "a plant without this key", place + "." + key);
  const std::string text = found->is_string() ? found->get<std::string>() : "";
  if (text.empty() || has_control_character(text)) return wrong(Status::bad_file, "not a path", place + "." + key);
  return text;
}

bool stays_below(const std::filesystem::path& path) {
  return path.is_relative() && path.has_filename() && path != "." && *path.begin() != "..";
}

Result<BatchPlant> plant_of(const Json& entry, const std::string& place, const std::filesystem::path& input_folder,
                            const std::filesystem::path& output_folder, const BakeRequest& defaults) {
  if (!entry.is_object()) return wrong(Status::bad_file, "a plant of a manifest is not an object", place);
  COPPICE_TRY(request, entry_request(entry, place, defaults));
  COPPICE_TRY(input_text, text_member(entry, "input", place));
  const std::filesystem::path input = std::filesystem::path(input_text).lexically_normal();
  std::filesystem::path output = stays_below(input) ? input : input.filename();
  output.replace_extension(".coppice");
  if (entry.contains("output")) {
    COPPICE_TRY(output_text, text_member(entry, "output", place));
    output = std::filesystem::path(output_text).lexically_normal();
    if (!stays_below(output)) return wrong(Status::invalid_argument, "not a file below the output folder", place + ".output", output_text);
  }
  // A path in a manifest is beside it, one on the command line where the user is.
  if (entry.contains("classes") && !request.classes.starts_with('{')) request.classes = input_folder / request.classes;
  COPPICE_TRY(options, bake_options(request));
  return BatchPlant{input_folder / input, output_folder / output, std::move(options), request.all_variants, place};
}

}  // namespace

Result<std::vector<BatchPlant>> plants_of_manifest(const std::filesystem::path& manifest, const std::filesystem::path& output_folder,
                                                   const BakeRequest& defaults) {
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

Result<std::string> manifest_entry(const BatchPlant& plant, const std::filesystem::path& output_folder) {
  const std::string input = std::filesystem::absolute(plant.input).lexically_normal();
  const std::string output = plant.output.lexically_relative(output_folder);
  if (has_control_character(input + output)) return wrong(Status::invalid_argument, "a name that no list may have", plant.input.string());
  Json entry = {{"input", input}, {"output", output}};
  for (const BakeOption& option : bake_option_table())
    if (const auto value = option.get(plant.options)) entry[list_key(option)] = *value;
  try {
    return entry.dump();
  } catch (const Json::exception&) {
    return wrong(Status::invalid_argument, "a name that is not UTF-8", plant.input.string());
  }
}

}  // namespace coppice::bake
