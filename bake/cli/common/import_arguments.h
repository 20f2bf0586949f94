#pragma once

#include <string>

#include "import_gltf.h"

namespace CLI {
class App;
}

namespace coppice::bake {

/// How a command's glTF input is to be read: --up, --unit and --allow-outside, and what of it, --node and --variant.
struct ImportArguments {
  std::string up = "y";
  double metres_per_unit = 1.0;
  bool allow_outside = false;
  PlantChoice plant;
  bool all_variants = false;
};

/// Adds the options to a command; `arguments` must outlive it.
void add_import_options(CLI::App& command, ImportArguments& arguments);

/// Adds --node and --variant.
void add_plant_options(CLI::App& command, ImportArguments& arguments);

/// Copies what was chosen into `options`.
void apply_import_arguments(const ImportArguments& arguments, ImportOptions& options);

}  // namespace coppice::bake
