#include "class_arguments.h"

#include <CLI/CLI.hpp>
#include <string>
#include <utility>

#include "atomic_file.h"
#include "class_rules.h"

namespace coppice::bake {

void add_class_options(CLI::App& command, ClassArguments& arguments) {
  command
      .add_option(
          "--leaf-material", arguments.leaf_material,
          "All of the materials whose name this regular expression finds is leaves, everything else wood. Without it leaves are found "
          "by name, alpha mask, shape, repetition and colour")
      ->type_name("REGEX");
  command.add_option("--wood-material", arguments.wood_material, "All of the materials whose name this regular expression finds is wood")
      ->type_name("REGEX");
  command
      .add_option(
          "--classes", arguments.classes,
          "Say for each material what it is: {\"classes\": [{\"material\": \"^Leaves$\", \"class\": \"leaf\"}, ...]}. The first entry "
          "decides whose regular expression finds the material's name. A class is leaf, wood or drop. An entry may also have "
          "\"min_triangles\" and \"max_triangles\" of a connected piece")
      ->type_name("F.json");
}

Result<ImportOptions> import_options(const ClassArguments& arguments) {
  ImportOptions options;
  if (!arguments.leaf_material.empty()) options.leaf_material = arguments.leaf_material;
  if (!arguments.wood_material.empty()) options.wood_material = arguments.wood_material;
  if (arguments.classes.empty()) return options;
  COPPICE_TRY(bytes, read_file(arguments.classes));
  const std::string text(bytes.begin(), bytes.end());
  COPPICE_TRY(rules, parse_class_rules(text, arguments.classes.string()));
  options.classes = std::move(rules);
  return options;
}

}  // namespace coppice::bake
