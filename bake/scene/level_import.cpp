#include "level_import.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include <tiny_gltf.h>
#include <glm/gtc/matrix_inverse.hpp>

#include "gltf_document.h"
#include "gltf_instances.h"
#include "gltf_nodes.h"
#include "name_pattern.h"
#include "node_names.h"

namespace coppice::bake {
namespace {

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::optional<std::size_t> find_species(const std::string& name, std::span<const std::string> species) {
  static const NamePattern appended = *NamePattern::compile("([._ -]?(lod)?[0-9]+)+$", "");
  const std::string wanted = lower(name);
  for (const std::string& form : {wanted, appended.without(wanted)}) {
    const auto found = std::ranges::find(species, form);
    if (!form.empty() && found != species.end()) return static_cast<std::size_t>(found - species.begin());
  }
  return {};
}

/// The species whose words are those of `stem`, a NodeName's, except for numbers at its end.
std::optional<std::size_t> find_stem(std::string stem, std::span<const std::string> species) {
  const auto joined = [](const std::string& name) {
    std::string text;
    for (const std::string& word : name_words(name)) text += (text.empty() ? "" : " ") + word;
    return text;
  };
  while (true) {
    const auto found = std::ranges::find(species, stem, joined);
    if (found != species.end()) return static_cast<std::size_t>(found - species.begin());
    const std::size_t last = stem.rfind(' ');
    if (last == std::string::npos || !std::isdigit(static_cast<unsigned char>(stem.back()))) return {};
    stem.resize(last);
  }
}

/// The plant that a node's mesh stands for.
struct NodePlant {
  std::optional<std::size_t> species;
  std::string name;
  bool instanced = false;
  NodeRole role = NodeRole::shape;
  std::uint32_t level = 0;
};

/// The level of billboards and of nodes that MSFT_lod names: coarser than any level in a name.
constexpr std::uint32_t kCoarsest = 1000;

NodePlant node_plant(const tinygltf::Model& model, const MeshInstance& instance, std::span<const std::string> species) {
  const tinygltf::Node& node = model.nodes.at(instance.node);
  const tinygltf::Mesh& mesh = model.meshes.at(instance.mesh);
  NodePlant plant;
  plant.instanced = node.extensions.contains("EXT_mesh_gpu_instancing");
  plant.name = !node.name.empty() ? node.name : !mesh.name.empty() ? mesh.name : "nodes[" + std::to_string(instance.node) + "]";
  for (const std::string& name : {node.name, mesh.name}) {
    if (plant.species) break;
    const NodeName read = read_node_name(name);
    plant.species = find_species(name, species);
    plant.level = read.level.value_or(0);
    // Skips "oak_billboard", unless a plant has that name.
    if (plant.species || read.role == NodeRole::shape) continue;
    plant.species = find_stem(read.stem, species);
    plant.role = read.role;
    plant.level = kCoarsest;
  }
  return plant;
}

/// [model's nodes] Whether MSFT_lod says that the node, or one above it, is a coarser level.
std::vector<bool> msft_coarser(const tinygltf::Model& model) {
  const std::set<std::uint32_t> named = msft_coarser_nodes(model);
  std::vector<bool> coarser(model.nodes.size());
  const std::vector<SceneNode> nodes = scene_nodes(model);
  for (const SceneNode& each : nodes)
    coarser[each.node] = named.contains(each.node) || (each.parent < nodes.size() && coarser[nodes[each.parent].node]);
  return coarser;
}

/// A species and its place, to a centimetre.
using SpeciesPlace = std::array<std::int64_t, 4>;
SpeciesPlace place_of(const NodePlant& plant, const glm::dmat4& world_from_plant) {
  SpeciesPlace place{static_cast<std::int64_t>(*plant.species)};
  for (int axis = 0; axis < 3; ++axis) place[static_cast<std::size_t>(axis) + 1] = std::llround(100.0 * world_from_plant[3][axis]);
  return place;
}

/// Adds a plant upright and with one scale: a scene holds no more of a transform.
void add_plant(LevelPlants& level, const glm::dmat4& world_from_plant, std::size_t species) {
  const glm::dvec3 x(world_from_plant[0]), y(world_from_plant[1]), z(world_from_plant[2]);
  const std::array<double, 3> lengths = {glm::length(x), glm::length(y), glm::length(z)};
  const auto [shortest, longest] = std::ranges::minmax(lengths);
  const double scale = std::cbrt(lengths[0] * lengths[1] * lengths[2]);
  if (longest > 1.02 * shortest) ++level.stretched_count;
  constexpr double kLean = 0.9986;  // cos 3 degrees
  if (scale > 0.0 && y.y < kLean * lengths[1]) ++level.tilted_count;
  ScenePlant plant;
  for (int axis = 0; axis < 3; ++axis) plant.position_m[static_cast<std::size_t>(axis)] = static_cast<float>(world_from_plant[3][axis]);
  plant.scale = static_cast<float>(scale);
  plant.species = static_cast<std::uint16_t>(species);
  plant.mirrored = glm::determinant(glm::dmat3(world_from_plant)) < 0.0;
  const double turn = std::atan2(z.x, z.z) / (2.0 * std::numbers::pi);
  plant.yaw = static_cast<std::uint16_t>(std::lround((turn - std::floor(turn)) * 65535.0));
  level.plants.push_back(plant);
}

}  // namespace

std::string species_name(const std::filesystem::path& plant) {
  return lower(plant.stem().string());
}

Result<LevelPlants> import_level(const std::filesystem::path& path, std::span<const std::string> species, const ImportOptions& options) {
  COPPICE_TRY(model, load_gltf(path, options.outside_files));
  COPPICE_TRY(scene_from_units, scene_from_file(options));
  COPPICE_TRY(instances, mesh_instances(*model, scene_from_units));
  // The plants were baked with the same axes and unit.
  const glm::dmat4 file_from_plant = glm::inverse(scene_from_units);
  const std::vector<bool> coarser = msft_coarser(*model);
  std::map<std::uint32_t, NodePlant> nodes;
  std::map<SpeciesPlace, std::uint32_t> finest;
  for (const MeshInstance& instance : instances) {
    auto node = nodes.find(instance.node);
    if (node == nodes.end()) {
      node = nodes.emplace(instance.node, node_plant(*model, instance, species)).first;
      if (coarser[instance.node]) node->second.level = kCoarsest;
    }
    if (!node->second.species || node->second.role != NodeRole::shape) continue;
    const auto [found, is_new] = finest.try_emplace(place_of(node->second, instance.scene_from_mesh), node->second.level);
    if (!is_new) found->second = std::min(found->second, node->second.level);
  }
  LevelPlants level;
  std::map<std::string, std::size_t> missing;
  for (const MeshInstance& instance : instances) {
    const NodePlant& plant = nodes.at(instance.node);
    const auto here = plant.species ? finest.find(place_of(plant, instance.scene_from_mesh)) : finest.end();
    if (here != finest.end() && (here->second < plant.level || plant.role != NodeRole::shape)) {
      ++level.coarser_count;
    } else if (plant.species && plant.role == NodeRole::shape) {
      add_plant(level, instance.scene_from_mesh * file_from_plant, *plant.species);
    } else if (plant.instanced) {
      ++missing[plant.name];
      ++level.missing_count;
    } else {
      ++level.other_count;
    }
  }
  for (const auto& [name, count] : missing) level.missing.push_back(name + " (" + std::to_string(count) + ")");
  return level;
}

}  // namespace coppice::bake
