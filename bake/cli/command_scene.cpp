#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "asset_path.h"
#include "atomic_file.h"
#include "bake_arguments.h"
#include "commands.h"
#include "gltf_document.h"
#include "io_result.h"
#include "level_import.h"
#include "output.h"
#include "printable.h"
#include "progress_bar.h"
#include "reader.h"
#include "scene_scatter.h"
#include "scene_write.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

struct SceneArguments {
  std::filesystem::path input, output;
  std::vector<std::string> plants, densities;
  BakeRequest bake;
  LimitArguments limits;
  ScatterOptions scatter;
  bool skip_missing = false, quiet = false;
};

/// A plant that the scene may have, and how often it has.
struct Species {
  std::string name;
  SceneSpecies entry;
  std::uint64_t count = 0;
};

Error wrong(const char* what, std::string detail) {
  return {Status::invalid_argument, what, Error::kNoOffset, std::move(detail)};
}

/// Files, and the .coppice files of folders, by name.
/// at_fault, here and below: the file that an error is about.
Result<std::vector<std::filesystem::path>> plant_files(const std::vector<std::string>& arguments, std::filesystem::path& at_fault) {
  std::vector<std::filesystem::path> files;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (!std::filesystem::is_directory(argument, error)) {
      files.emplace_back(argument);
      continue;
    }
    std::vector<std::filesystem::path> found;
    at_fault = argument;
    for (std::filesystem::directory_iterator entry(argument, error), end; !error && entry != end; entry.increment(error))
      if (entry->path().extension() == ".coppice") found.push_back(entry->path());
    if (error) return Error{status_of(error.value()), "cannot read the folder", Error::kNoOffset, error.message()};
    if (found.empty()) return wrong("no .coppice file in the folder", {});
    std::ranges::sort(found);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

Result<Species> open_species(const std::filesystem::path& file, const std::filesystem::path& scene_folder, bool allow_outside) {
  COPPICE_TRY(bytes, read_file(file));
  COPPICE_TRY(front, read_front(bytes, bytes.size()));
  std::error_code error;
  const std::filesystem::path relative = std::filesystem::relative(file, scene_folder, error);
  if (error) return Error{status_of(error.value()), "cannot resolve the path", Error::kNoOffset, file.string() + ": " + error.message()};
  if (relative.empty()) return wrong("no relative path from the scene to the plant", file.string());
  if (!allow_outside && !stays_inside(relative.native()))
    return wrong("a plant outside the scene's folder, where it is not read: move it there, or give --allow-outside", relative.string());
  Species species{species_name(file), {relative.generic_string(), {}, front.plant.sphere_radius}, 0};
  std::ranges::copy(front.plant.sphere_center, species.entry.sphere_center.begin());
  return species;
}

Result<std::vector<Species>> open_all_species(const SceneArguments& arguments, std::filesystem::path& at_fault) {
  COPPICE_TRY(files, plant_files(arguments.plants, at_fault));
  const std::filesystem::path folder = folder_of(arguments.output);
  std::vector<Species> all;
  for (const std::filesystem::path& file : files) {
    at_fault = file;
    COPPICE_TRY(species, open_species(file, folder, arguments.bake.options.import.outside_files == OutsideFiles::allowed));
    if (std::ranges::find(all, species.name, &Species::name) != all.end()) return wrong("two plants of one name", species.name);
    all.push_back(std::move(species));
  }
  return all;
}

std::string names_of(const std::vector<Species>& species) {
  std::string names;
  for (const Species& s : species) names += (names.empty() ? "" : ", ") + s.name;
  return names;
}

/// [species], null where none was given.
Result<std::vector<std::unique_ptr<DensityMap>>> read_densities(const SceneArguments& arguments, const std::vector<Species>& species,
                                                                std::filesystem::path& at_fault) {
  std::vector<std::unique_ptr<DensityMap>> maps(species.size());
  for (const std::string& argument : arguments.densities) {
    const std::size_t equals = argument.find('=');
    if (equals == std::string::npos || equals == 0) return wrong("--density takes NAME=MAP.png", argument);
    const std::string name = species_name(argument.substr(0, equals));
    const auto found = std::ranges::find(species, name, &Species::name);
    if (found == species.end()) return wrong("--density names no plant; there are", names_of(species) + ", not " + name);
    at_fault = argument.substr(equals + 1);
    COPPICE_TRY(bytes, read_file(at_fault));
    COPPICE_TRY(map, decode_density_map(bytes));
    maps[static_cast<std::size_t>(found - species.begin())] = std::make_unique<DensityMap>(std::move(map));
  }
  return maps;
}

/// A line for each species that found fewer places than its share; the others have them.
void warn_of_shares(const SceneArguments& arguments, const std::vector<ScatterSpecies>& species, const std::vector<ScenePlant>& plants) {
  const std::vector<std::uint64_t> shares = scatter_shares(species, arguments.scatter.count);
  std::vector<std::uint64_t> counts(species.size(), 0);
  for (const ScenePlant& plant : plants) ++counts[plant.species];
  for (std::size_t s = 0; s < species.size(); ++s)
    if (counts[s] < shares[s])
      std::fprintf(stderr,
                   "coppice: warning: %s: %s: room for %llu of %llu: its bounding sphere is %.3g m wide; other species stand for the rest "
                   "(--spacing, --size-m or --count change that)\n",
                   shown(arguments.output).c_str(), printable(species[s].name).c_str(), static_cast<unsigned long long>(counts[s]),
                   static_cast<unsigned long long>(shares[s]), static_cast<double>(2.0f * species[s].sphere_radius_m));
}

Result<std::vector<ScenePlant>> scatter(const SceneArguments& arguments, const std::vector<Species>& species, ProgressBar& bar,
                                        std::filesystem::path& at_fault) {
  COPPICE_TRY(maps, read_densities(arguments, species, at_fault));
  at_fault = arguments.output;
  std::vector<ScatterSpecies> scattered;
  for (std::size_t i = 0; i < species.size(); ++i) {
    // Where some species have maps, the others stay out.
    if (!maps[i] && !arguments.densities.empty()) maps[i] = std::make_unique<DensityMap>(DensityMap{1, 1, {0}});
    scattered.push_back({species[i].entry.sphere_radius_m, maps[i].get(), species[i].name});
  }
  COPPICE_TRY(plants, scatter_plants(scattered, arguments.scatter, [&bar](float share) { bar.show("scatter", share); }));
  bar.clear();
  warn_of_shares(arguments, scattered, plants);
  return plants;
}

/// Names, each with its number where that is not 1.
std::string names_of(const LeftMeshes& left) {
  constexpr std::size_t kMost = 12;
  std::string line;
  std::size_t listed = 0;
  for (const auto& [name, count] : left.names) {
    if (listed++ == kMost) return line + " and " + std::to_string(left.names.size() - kMost) + " more names";
    line += (line.empty() ? "" : ", ") + name.substr(0, 64) + (count > 1 ? " (" + std::to_string(count) + ")" : "");
  }
  return line;
}

void warn(const std::filesystem::path& file, std::size_t count, const char* what, const std::string& names = {}) {
  if (count == 0) return;
  std::fprintf(stderr, "coppice: warning: %s: %zu %s%s%s\n", shown(file).c_str(), count, what, names.empty() ? "" : ": ",
               printable(names).c_str());
}

void warn(const std::filesystem::path& file, const LeftMeshes& left, const char* what) {
  warn(file, left.count(), what, names_of(left));
}

Result<std::vector<ScenePlant>> import(const SceneArguments& arguments, const std::vector<Species>& species) {
  std::vector<std::string> names(species.size());
  std::ranges::transform(species, names.begin(), &Species::name);
  COPPICE_TRY(scene, import_level(arguments.input, names, arguments.bake.options.import));
  if (!scene.missing.names.empty() && !arguments.skip_missing)
    return wrong("instanced meshes without a baked plant of their name (--skip-missing leaves them out)",
                 names_of(scene.missing) + "; the plants are " + names_of(species));
  if (scene.plants.empty())
    return wrong("no node or mesh is named like one of the plants", names_of(species) + "; there are " + names_of(scene.other));
  warn(arguments.input, scene.missing, "instances left out, as no baked plant has their name");
  warn(arguments.input, scene.coarser, "coarser levels, billboards and collision shapes left out, as a plant stands in their places");
  warn(arguments.input, scene.other, "meshes left out that are neither instanced nor named like a plant");
  warn(arguments.input, scene.hidden, "hidden meshes left out");
  warn(arguments.input, scene.tilted_count, "plants lean; they stand upright in the scene");
  warn(arguments.input, scene.stretched_count, "plants are stretched; they get the mean of their scales");
  return std::move(scene.plants);
}

/// Species that stand somewhere, in their order; renumbers the plants.
std::vector<SceneSpecies> used_species(std::vector<Species>& species, std::vector<ScenePlant>& plants) {
  for (const ScenePlant& plant : plants) ++species[plant.species].count;
  std::vector<SceneSpecies> used;
  std::vector<std::uint16_t> numbers;
  for (const Species& s : species) {
    numbers.push_back(static_cast<std::uint16_t>(used.size()));
    if (s.count > 0) used.push_back(s.entry);
  }
  for (ScenePlant& plant : plants) plant.species = numbers[plant.species];
  return used;
}

struct MadeScene {
  SceneStatistics statistics;
  std::vector<std::uint8_t> bytes;
  std::size_t outside_count = 0;  ///< species outside the scene's folder
};

Result<MadeScene> make_scene(const SceneArguments& arguments, std::vector<Species>& species, std::filesystem::path& at_fault) {
  at_fault = arguments.output;
  COPPICE_CHECK(refuse_standard_output(arguments.output, "a scene names its plants by paths from its own folder"));
  std::vector<std::filesystem::path> inputs = files_of_gltf(arguments.input);
  inputs.insert(inputs.end(), arguments.plants.begin(), arguments.plants.end());
  for (const std::string& density : arguments.densities) inputs.emplace_back(density.substr(density.find('=') + 1));
  COPPICE_CHECK(check_output(arguments.output, inputs));
  COPPICE_TRY(opened, open_all_species(arguments, at_fault));
  species = std::move(opened);
  ProgressBar bar(arguments.quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  at_fault = arguments.input.empty() ? arguments.output : arguments.input;
  COPPICE_TRY(plants, arguments.input.empty() ? scatter(arguments, species, bar, at_fault) : import(arguments, species));
  at_fault = arguments.output;
  const std::vector<SceneSpecies> used = used_species(species, plants);
  MadeScene made;
  COPPICE_TRY(bytes, encode_scene(used, plants, &made.statistics, [&bar](float share) { bar.show("tiles", share); }));
  made.bytes = std::move(bytes);
  const auto is_outside = [](const SceneSpecies& plant) { return !stays_inside(plant.path); };
  made.outside_count = static_cast<std::size_t>(std::ranges::count_if(used, is_outside));
  return made;
}

int run(const SceneArguments& arguments) {
  std::vector<Species> species;
  std::filesystem::path at_fault;
  const auto made = make_scene(arguments, species, at_fault);
  if (!made) return report_failure(at_fault, made.error());
  std::string text = formatted("%s: %llu plants in %u tiles, %u levels, %s\n", shown(arguments.output).c_str(),
                               static_cast<unsigned long long>(made->statistics.plant_count), made->statistics.tile_count,
                               made->statistics.level_count, readable_bytes(made->statistics.file_bytes).c_str());
  for (const Species& s : species)
    text +=
        formatted("  %-24s %10llu  %s\n", printable(s.name).c_str(), static_cast<unsigned long long>(s.count), shown(s.entry.path).c_str());
  const int exit_code = write_outputs({{arguments.output, made->bytes}}, arguments.quiet ? "" : text);
  if (exit_code == 0) warn(arguments.output, made->outside_count, "species from outside its folder: read only where the host allows that");
  return exit_code;
}

constexpr const char* kFooter =
    "A scene says where plants stand; coppice-forest --scene F.forest and coppice_scene_open stream it, however large it is.\n"
    "Scattered, groves and clearings come from the seed:\n"
    "  coppice scene -o wood.forest --plants oak.coppice,birch.coppice --size-m 10000 --count 1000000\n"
    "or from maps over the whole square, white dense, black bare, north (-z) at the top; plants without a map then stay out, and of each "
    "other there are as many as its map is white:\n"
    "  coppice scene -o wood.forest --plants baked --size-m 2000 --count 50000 --density oak=oaks.png\n"
    "From a level editor's glTF: each node, or mesh, that is named like a baked plant (Oak, oak.001, oak_LOD0, Oak (1), Oak(Clone) and "
    "SM_Oak_12 all are oak) becomes one with all that is below it, of several levels in one place the finest, with EXT_mesh_gpu_instancing "
    "as many as it has instances:\n"
    "  coppice scene level.glb -o level.forest --plants baked\n"
    "Plants are named in the scene by paths relative to it, and lie in its folder or below: move them together.";

}  // namespace

void add_scene_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<SceneArguments>();
  arguments->scatter.count = 100000;
  CLI::App* command =
      app.add_subcommand("scene", "Make a .forest file: where plants stand, scattered by a seed and maps or from a glTF scene");
  command->footer(kFooter);
  CLI::Option* input =
      command->add_option("input", arguments->input, "A glTF scene; without it plants are scattered")->type_name("IN.glb|IN.gltf");
  add_output_option(*command, "-o,--output", arguments->output, "The .forest to write")->required()->type_name("F.forest");
  command->add_option("--plants", arguments->plants, "Baked plants, and folders of them, separated by commas")
      ->required()
      ->delimiter(',')
      ->type_name("A.coppice,...");
  const auto scatter_option = [&](CLI::Option* option) { return option->excludes(input)->group("Scattering"); };
  scatter_option(command->add_option("--count", arguments->scatter.count, "Plants"))
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100000000}))
      ->capture_default_str();
  scatter_option(command->add_option("--size-m", arguments->scatter.size_m, "Side of the square, metres"))
      ->check(CLI::Range(1.0, 100000.0))
      ->capture_default_str();
  scatter_option(command->add_option("--seed", arguments->scatter.seed, "Same seed, same scene"))->capture_default_str();
  scatter_option(command->add_option("--density", arguments->densities, "A map of where a plant grows; may be given for each"))
      ->type_name("NAME=MAP.png");
  scatter_option(command->add_option("--spacing", arguments->scatter.spacing,
                                     "Least distance of two stems, as a share of the sum of their crowns' radii; 0 for none"))
      ->check(CLI::Range(0.0, 2.0))
      ->capture_default_str();
  command->add_flag("--skip-missing", arguments->skip_missing, "Leave out instanced meshes that no plant is named like")->needs(input);
  add_bake_options(*command, arguments->bake, {OptionGroup::units});
  command->add_flag("--quiet", arguments->quiet, "Print nothing but warnings and errors");
  add_limit_options(*command, arguments->limits);
  command->callback([arguments, exit_code] {
    *exit_code = run_limited(arguments->limits, arguments->output, {arguments->output}, [&] { return run(*arguments); });
  });
}

}  // namespace coppice::bake
