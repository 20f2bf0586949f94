#include <CLI/CLI.hpp>
#include <memory>

#include "commands.h"
#include "generate_plant.h"
#include "gltf_write.h"
#include "output.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

struct PlantArguments {
  std::string species;
  std::filesystem::path output;
  std::uint64_t seed = 1;
};

int run(const PlantArguments& arguments) {
  if (const auto possible = check_output(arguments.output, {}); !possible) return report_failure(arguments.output, possible.error());
  const auto plant = generate_plant(arguments.species, arguments.seed);
  if (!plant) return report_failure(arguments.species, plant.error());
  const auto bytes = encode_glb({{"leaves", &plant->foliage}, {"wood", &plant->wood}}, plant->materials, plant->images);
  if (!bytes) return report_failure(arguments.output, bytes.error());
  return write_outputs(
      {{arguments.output, *bytes}},
      formatted("%s: %s, %zu leaves of %zu triangles, %zu wood triangles\n", shown(arguments.output).c_str(), arguments.species.c_str(),
                plant->leaves.size(), plant->foliage.indices.size() / 3 / plant->leaves.size(), plant->wood.indices.size() / 3));
}

}  // namespace

void add_plant_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<PlantArguments>();
  CLI::App* command = app.add_subcommand(
      "plant", "Grow one of the paper's three plants as glTF: corylus (hazel, 386 leaves), willow (4,456), juniper (13,162)");
  command->add_option("species", arguments->species, "corylus, willow or juniper")
      ->required()
      ->check(CLI::IsMember({"corylus", "willow", "juniper"}))
      ->type_name("SPECIES");
  add_output_option(*command, "-o,--output", arguments->output, "The .glb to write; - for the standard output")
      ->required()
      ->type_name("OUT.glb");
  command->add_option("--seed", arguments->seed, "Same seed, same plant")->capture_default_str();
  command->callback([arguments, exit_code] { *exit_code = run(*arguments); });
}

}  // namespace coppice::bake
