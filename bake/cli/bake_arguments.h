#pragma once

// The options of a bake that change its result, as `bake` and `bake-all` take them from the command line and a manifest from its entries.

#include <string>

#include "bake.h"
#include "class_arguments.h"
#include "import_arguments.h"

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

namespace coppice::bake {

struct BakeArguments {
  std::string metric = "default", background = "on", textures = "bc", leaf_meshes = "on", areas = "item-buffers";
  bool quick = false, no_wind = false;
  ClassArguments classes;
  ImportArguments import;
  BakeOptions options;  ///< what needs no translation
};

/// Adds an option to the command for each of them. What is not given when the command is parsed stays as it is in `arguments`, which must
/// outlive the command.
void add_bake_options(CLI::App& command, BakeArguments& arguments);

/// Throws CLI::ValidationError for options that do not go together.
void check_bake_arguments(const BakeArguments& arguments);

/// What they ask for. errors  those of import_options and check_areas
Result<BakeOptions> bake_options(const BakeArguments& arguments);

}  // namespace coppice::bake
