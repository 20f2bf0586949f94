#pragma once

// What a person says about which materials are leaves, as every command that imports a plant takes it.

#include <filesystem>
#include <string>

#include "import_gltf.h"

namespace CLI {
class App;
}

namespace coppice::bake {

struct ClassArguments {
  std::string leaf_material, wood_material;
  std::filesystem::path classes;
};

/// Adds --leaf-material, --wood-material and --classes to the command. `arguments` must outlive it.
void add_class_options(CLI::App& command, ClassArguments& arguments);

/// What they ask for.
/// errors  io, bad_file: the classes file cannot be read, or is not one; `detail` names it and the place in it
Result<ImportOptions> import_options(const ClassArguments& arguments);

}  // namespace coppice::bake
