#include "import_arguments.h"

#include <CLI/CLI.hpp>
#include <array>
#include <string_view>
#include <utility>

#include "text_number.h"

namespace coppice::bake {
namespace {

// Nanometres to light seconds: what lies outside is a slip of the keyboard.
constexpr double kMinUnit_m = 1e-9, kMaxUnit_m = 1e9;

/// Metres in a unit by name, or in a factor; 0 where the text is neither.
double metres_in(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, double>, 5> kUnits{
      {{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}};
  for (const auto& [name, metres] : kUnits)
    if (text == name) return metres;
  const double factor = number_of<double>(text).value_or(0.0);
  return factor >= kMinUnit_m && factor <= kMaxUnit_m ? factor : 0.0;
}

}  // namespace

void add_import_options(CLI::App& command, ImportArguments& arguments) {
  command.add_option("--up", arguments.up, "The file's axis that points to the sky; glTF says y, but not every exporter turns its z")
      ->check(CLI::IsMember({"y", "z"}))
      ->type_name("y|z")
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--unit",
          [&arguments](const std::string& text) {
            arguments.metres_per_unit = metres_in(text);
            if (arguments.metres_per_unit == 0.0)
              throw CLI::ValidationError("--unit", "not m, cm, mm, in, ft or a number of metres between 1e-9 and 1e9: " + text);
          },
          "The file's unit of length, by name or as a number of metres; glTF says m")
      ->type_name("m|cm|mm|in|ft|FACTOR");
  command.add_flag("--allow-outside", arguments.allow_outside,
                   "Read files outside the input's folder where it names any; a scene may name plants outside its own");
}

void add_plant_options(CLI::App& command, ImportArguments& arguments) {
  command
      .add_option_function<std::string>(
          "--node", [&arguments](const std::string& name) { arguments.plant.node = name; },
          "Of a file with several plants, take what is below nodes of this name, or whose names this regular expression finds")
      ->type_name("NAME");
  command
      .add_option_function<std::string>(
          "--variant",
          [&arguments](const std::string& text) {
            arguments.all_variants = text == "all";
            arguments.plant.whole = text == "whole";
            if (arguments.all_variants || arguments.plant.whole) return;
            arguments.plant.variant = number_of<std::uint32_t>(text).value_or(0);
            if (arguments.plant.variant == 0)
              throw CLI::ValidationError("--variant", "neither a number from 1 on, nor all, nor whole: " + text);
          },
          "Which of several plants in the file; --dry-run lists them, 1 is the default. all: each into a file of its own. whole: the file "
          "is "
          "one plant, with its levels of detail and billboards")
      ->type_name("N|all|whole");
}

void apply_import_arguments(const ImportArguments& arguments, ImportOptions& options) {
  options.up = arguments.up == "z" ? UpAxis::z : UpAxis::y;
  options.plant = arguments.plant;
  options.metres_per_unit = arguments.metres_per_unit;
  options.outside_files = arguments.allow_outside ? OutsideFiles::allowed : OutsideFiles::refused;
}

}  // namespace coppice::bake
