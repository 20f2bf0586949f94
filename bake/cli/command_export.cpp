#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "commands.h"
#include "coppice/format.h"
#include "gltf_write.h"
#include "inspect.h"
#include "leaf_mesh_parts.h"
#include "output.h"
#include "text_bytes.h"
#include "text_number.h"
#include "tree_order.h"
#include "unpack.h"
#include "wood_capsules.h"

namespace coppice::bake {
namespace {

struct ExportArguments {
  std::filesystem::path input, output;
  std::string leaves;            ///< a number, or "full"
  std::uint32_t leaf_count = 0;  ///< 0 for "full"
  std::string part = "all";
  bool solid = false;
  std::uint32_t capsules = 0;  ///< 0: the cut is written
};

/// A .coppice file keeps no material names. These tell leaves from wood, so that an exported cut can be baked again.
void name_materials(BakedPlant& plant) {
  for (Material& material : plant.materials) material.name = "wood";
  for (const Card& card : plant.card_table) plant.materials[card.material].name = "leaves";
  for (const LeafMeshPart& part : plant.leaf_meshes.parts)
    for (const std::uint32_t material : part.mesh.triangle_materials) plant.materials[material].name = "leaves";
}

/// The cut asked for; "full" is the finest that the file holds.
Mesh leaf_mesh(const BakedPlant& plant, const ExportArguments& arguments) {
  if (arguments.leaf_count == 0 && !plant.leaf_meshes.parts.empty()) return whole_leaf_mesh(plant.leaf_meshes);
  const std::uint32_t leaf_count = arguments.leaf_count == 0 ? plant.tree.leaf_count() : arguments.leaf_count;
  Foliage cut = cut_foliage(plant.tree, plant.card_table, leaf_count);
  return foliage_mesh(arguments.solid ? solid_foliage(std::move(cut)) : cut);
}

std::string capsules_json(const std::vector<Capsule>& capsules) {
  auto list = nlohmann::ordered_json::array();
  const auto place = [](const glm::dvec3& at) {
    return nlohmann::ordered_json{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
  };
  for (const Capsule& capsule : capsules)
    list.push_back({{"from", place(capsule.from)}, {"to", place(capsule.to)}, {"radius", static_cast<float>(capsule.radius_m)}});
  return nlohmann::ordered_json{{"capsules", std::move(list)}}.dump(1) + "\n";
}

int run_capsules(const ExportArguments& arguments, const BakedPlant& plant) {
  if (plant.wood.lods.empty()) return report_failure(arguments.input, Error{Status::invalid_argument, "the plant has no wood to export"});
  const std::vector<Capsule> capsules = wood_capsules(plant.wood.lods.front(), arguments.capsules);
  const std::string text = capsules_json(capsules);
  return write_outputs({{arguments.output, bytes_of(text)}},
                       formatted("%s: %zu capsules\n", shown(arguments.output).c_str(), capsules.size()));
}

int run(const ExportArguments& arguments) {
  if (const auto possible = check_output(arguments.output, {arguments.input}); !possible)
    return report_failure(arguments.output, possible.error());
  const auto bytes = read_file(arguments.input);
  if (!bytes) return report_failure(arguments.input, bytes.error());
  auto plant = unpack(*bytes);
  if (!plant) return report_failure(arguments.input, plant.error());
  if (arguments.capsules > 0) return run_capsules(arguments, *plant);
  const auto summary = inspect(*bytes);
  if (!summary) return report_failure(arguments.input, summary.error());
  const bool has_leaves = summary->leaf_count > 0;
  if (!has_leaves) plant->card_table.clear();
  name_materials(*plant);
  if (arguments.leaf_count > plant->tree.leaf_count())
    return report_failure(arguments.input, Error{Status::invalid_argument, "--leaves is over the plant's leaf count", Error::kNoOffset,
                                                 std::to_string(arguments.leaf_count) + " > " + std::to_string(plant->tree.leaf_count())});

  Mesh leaves;
  std::vector<GltfPart> parts;
  if (arguments.part != "wood" && has_leaves) {
    leaves = leaf_mesh(*plant, arguments);
    parts.push_back({"leaves", &leaves});
  }
  if (arguments.part != "foliage" && !plant->wood.lods.empty()) parts.push_back({"wood", &plant->wood.lods.front()});
  if (parts.empty())
    return report_failure(arguments.input, Error{Status::invalid_argument,
                                                 has_leaves ? "the plant has no wood to export" : "the plant has no leaves to export"});
  const auto glb = encode_glb(parts, plant->materials, plant->images);
  if (!glb) return report_failure(arguments.output, glb.error());
  const std::size_t wood_triangles = parts.back().mesh == &leaves ? 0 : parts.back().mesh->indices.size() / 3;
  const bool as_modelled = arguments.leaf_count == 0 && !plant->leaf_meshes.parts.empty() && !leaves.indices.empty();
  return write_outputs(
      {{arguments.output, *glb}},
      formatted(as_modelled ? "%s: leaf meshes of %zu triangles, %zu wood triangles\n" : "%s: %zu leaf quads, %zu wood triangles\n",
                shown(arguments.output).c_str(), leaves.indices.size() / (as_modelled ? 3 : 6), wood_triangles));
}

}  // namespace

void add_export_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Write one cut of a plant as plain glTF, for any engine");
  command->footer(
      "A leaf of a cut stands for many, and one quad cannot have the normals of all. NORMAL is the axis of their normals, and the float "
      "attribute _SPREAD says how far they lie along it: 1 for one flat leaf, 1/3 for leaves of all directions, 0 for leaves about a "
      "twig. It is negative where NORMAL is on the front of the leaves, which is lit whoever looks. A cut of flat leaves has none. "
      "A shader gives coppice_leaf_light (coppice/coppice_surface.glsl) NORMAL, abs(_SPREAD), and 1 for a negative one, else 0, as "
      "`sided`; one that knows no _SPREAD lights the axis as it lights any normal.");
  command->add_option("input", arguments->input, "A .coppice file")->required()->type_name("IN.coppice");
  const CLI::Range counts(1u, COPPICE_MAX_LEAVES);
  command
      ->add_option("--leaves", arguments->leaves,
                   "Leaf quads in the cut, 1 to the plant's leaf count, or full: the leaves as they were modelled where the file holds "
                   "them, else all quads; not needed for wood alone")
      ->check(counts | CLI::IsMember({"full"}))
      ->type_name("M|full");
  command->add_option("--part", arguments->part, "What is written; wood is the finest")
      ->check(CLI::IsMember({"foliage", "wood", "all"}))
      ->type_name("foliage|wood|all")
      ->capture_default_str();
  command->add_flag("--solid", arguments->solid,
                    "Leaves without opacity, for engines that draw none: each shrinks to the area that its opacity is of. Otherwise "
                    "opacity is the alpha of COLOR_0, and leaves that have it are blended");
  command
      ->add_option("--capsules", arguments->capsules,
                   "In place of a cut, at most this many capsules of stem and boughs as JSON, for colliders and navigation meshes: the "
                   "ends' middles and the radius, metres, the most wood first")
      ->check(CLI::Range(1u, 1024u))
      ->type_name("N")
      ->excludes("--leaves")
      ->excludes("--part")
      ->excludes("--solid");
  add_output_option(*command, "-o,--output", arguments->output, "The .glb or .json to write; - for the standard output")
      ->required()
      ->type_name("OUT");
  command->callback([arguments, exit_code] {
    if (arguments->capsules == 0 && arguments->part != "wood" && arguments->leaves.empty()) throw CLI::RequiredError("--leaves");
    if (!arguments->leaves.empty() && arguments->leaves != "full")
      arguments->leaf_count = static_cast<std::uint32_t>(std::stoul(arguments->leaves, nullptr, 0));
    *exit_code = run(*arguments);
  });
}

}  // namespace coppice::bake
