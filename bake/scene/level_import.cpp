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

/// Finds species by the names that editors give to nodes.
class SpeciesNames {
 public:
  explicit SpeciesNames(std::span<const std::string> species) {
    for (std::size_t i = 0; i < species.size(); ++i) {
      exact_.try_emplace(species[i], i);
      words_.try_emplace(joined(name_words(species[i])), i);
    }
  }

  [[nodiscard]] std::optional<std::size_t> find(const std::string& name) const {
    static const NamePattern appended =
        *NamePattern::compile(R"(( ?\([0-9]+\)|([._ -]+\(?|\()(clone|copy)\)?|_c_[0-9]+|[._ -]?(lod)?[0-9]+)+$)", "");
    static const NamePattern prefix = *NamePattern::compile("^(sm|sk|bp|pf|prefab)_", "");
    const std::string wanted = lower(name), bare = appended.without(wanted);
    const std::array forms{wanted, bare, prefix.without(wanted), prefix.without(bare)};
    for (const std::string& form : forms)
      if (const auto found = exact_.find(form); !form.empty() && found != exact_.end()) return found->second;
    for (const std::string& form : forms)
      if (const auto found = find_words(joined(name_words(form)))) return found;
    return {};
  }

  /// The species whose words are those of `stem`, a NodeName's, except for numbers at its end.
  [[nodiscard]] std::optional<std::size_t> find_stem(std::string stem) const {
    while (true) {
      if (const auto found = find_words(stem)) return found;
      const std::size_t last = stem.rfind(' ');
      if (last == std::string::npos || !std::isdigit(static_cast<unsigned char>(stem.back()))) return {};
      stem.resize(last);
    }
  }

 private:
  [[nodiscard]] std::optional<std::size_t> find_words(const std::string& words) const {
    const auto found = words_.find(words);
    return words.empty() || found == words_.end() ? std::nullopt : std::optional(found->second);
  }

  std::map<std::string, std::size_t> exact_, words_;
};

/// The level of billboards and of nodes that MSFT_lod names: coarser than any level in a name.
constexpr std::uint32_t kCoarsest = 1000;

/// The plant that a node's name, or its mesh's, stands for.
struct NodePlant {
  std::optional<std::size_t> species;
  NodeRole role = NodeRole::shape;
  std::uint32_t level = 0;
};

NodePlant node_plant(const std::array<std::string, 2>& names, const SpeciesNames& species) {
  NodePlant plant;
  for (const std::string& name : names) {
    if (plant.species) break;
    const NodeName read = read_node_name(name);
    plant.species = species.find(name);
    plant.level = read.level.value_or(0);
    // Skips "oak_billboard", unless a plant has that name.
    if (plant.species || read.role == NodeRole::shape) continue;
    plant.species = species.find_stem(read.stem);
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
SpeciesPlace place_of(std::size_t species, const glm::dmat4& world_from_plant) {
  SpeciesPlace place{static_cast<std::int64_t>(species)};
  for (int axis = 0; axis < 3; ++axis) place[static_cast<std::size_t>(axis) + 1] = std::llround(100.0 * world_from_plant[3][axis]);
  return place;
}

/// A node of the level. Positions are indices into the list of nodes.
struct LevelNode {
  std::string name;  ///< for messages
  std::uint32_t parent = kNone;
  std::span<const MeshInstance> placed;  ///< its mesh; empty without one
  bool is_instanced = false;
  bool is_hidden = false;
  bool shows = false;  ///< a mesh, itself or below
  glm::dmat4 scene_from_node{1.0};
  NodePlant plant;
  std::uint32_t owner = kNone;  ///< the node of the plant that this one is a part of, or itself
};

std::vector<LevelNode> level_nodes(const tinygltf::Model& model, std::span<const MeshInstance> instances, const SpeciesNames& species,
                                   const glm::dmat4& scene_from_file) {
  const std::vector<bool> coarser = msft_coarser(model);
  const std::vector<glm::dmat4> transforms = file_from_nodes(model);
  std::vector<LevelNode> nodes;
  std::size_t next = 0;
  for (const SceneNode& each : scene_nodes(model)) {
    const tinygltf::Node& node = model.nodes.at(each.node);
    LevelNode& added = nodes.emplace_back();
    added.parent = each.parent;
    added.is_hidden = hides(node) || (each.parent != kNone && nodes[each.parent].is_hidden);
    added.scene_from_node = scene_from_file * transforms[each.node];
    const std::size_t first = next;
    while (next < instances.size() && instances[next].node == each.node) ++next;
    added.placed = instances.subspan(first, next - first);
    added.shows = !added.placed.empty() && !added.is_hidden;
    added.is_instanced = node.extensions.contains("EXT_mesh_gpu_instancing");
    const std::string mesh_name = node.mesh >= 0 ? model.meshes.at(static_cast<std::size_t>(node.mesh)).name : "";
    added.name = !node.name.empty() ? node.name : !mesh_name.empty() ? mesh_name : "nodes[" + std::to_string(each.node) + "]";
    added.plant = node_plant({node.name, mesh_name}, species);
    if (coarser[each.node]) added.plant.level = kCoarsest;
  }
  for (std::size_t i = nodes.size(); i-- > 0;)
    if (const std::uint32_t parent = nodes[i].parent; parent != kNone && nodes[i].shows) nodes[parent].shows = true;
  return nodes;
}

/// [nodes] Whether a node only groups plants: it has no mesh, and nodes below it with plants' names stand in several places.
std::vector<bool> find_groups(const std::vector<LevelNode>& nodes) {
  std::vector<std::uint32_t> named_above(nodes.size(), kNone);
  std::vector<std::set<SpeciesPlace>> places(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const LevelNode& node = nodes[i];
    if (node.parent != kNone) named_above[i] = nodes[node.parent].plant.species ? node.parent : named_above[node.parent];
    if (named_above[i] == kNone || !node.plant.species || !node.shows) continue;
    places[named_above[i]].insert(place_of(0, node.scene_from_node));
  }
  std::vector<bool> groups(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) groups[i] = nodes[i].placed.empty() && places[i].size() > 1;
  return groups;
}

/// Finds the plant that each node is, or is a part of.
void find_owners(std::vector<LevelNode>& nodes) {
  const std::vector<bool> groups = find_groups(nodes);
  const auto is_part = [&](const LevelNode& node, const LevelNode& of) {
    if (node.plant.species != of.plant.species) return false;
    const std::size_t species = *node.plant.species;
    return of.placed.empty() || place_of(species, node.scene_from_node) == place_of(species, of.scene_from_node);
  };
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    LevelNode& node = nodes[i];
    node.owner = node.parent == kNone ? kNone : nodes[node.parent].owner;
    if (!node.plant.species || !node.shows || groups[i]) continue;
    if (node.owner == kNone || !is_part(node, nodes[node.owner])) node.owner = i;
  }
}

/// [nodes] Where plants stand, empty for nodes that are none. A plant is instanced if its own mesh is, or if all its parts are, as often.
std::vector<std::vector<glm::dmat4>> find_places(const std::vector<LevelNode>& nodes) {
  std::vector<std::uint32_t> first_part(nodes.size(), kNone);
  std::vector<bool> is_instanced(nodes.size(), true);
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const LevelNode& node = nodes[i];
    if (node.owner == kNone || node.placed.empty() || node.is_hidden) continue;
    std::uint32_t& first = first_part[node.owner];
    if (first == kNone) first = i;
    if (first != node.owner && (!node.is_instanced || node.placed.size() != nodes[first].placed.size())) is_instanced[node.owner] = false;
  }
  std::vector<std::vector<glm::dmat4>> places(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    // What is below a plant may be other plants alone.
    if (nodes[i].owner != i || first_part[i] == kNone) continue;
    const LevelNode& first = nodes[first_part[i]];
    if (first.is_instanced && is_instanced[i])
      for (const MeshInstance& instance : first.placed) places[i].push_back(instance.scene_from_mesh);
    else
      places[i].push_back(nodes[i].scene_from_node);
  }
  return places;
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

std::size_t LeftMeshes::count() const {
  std::size_t sum = 0;
  for (const auto& [name, count] : names) sum += count;
  return sum;
}

Result<LevelPlants> import_level(const std::filesystem::path& path, std::span<const std::string> species, const ImportOptions& options) {
  COPPICE_TRY(model, load_gltf(path, options.outside_files, {options.max_source_triangles, true}));
  COPPICE_TRY(scene_from_units, scene_from_file(options));
  COPPICE_TRY(instances, mesh_instances(*model, scene_from_units));
  // The plants were baked with the same axes and unit.
  const glm::dmat4 file_from_plant = glm::inverse(scene_from_units);
  std::vector<LevelNode> nodes = level_nodes(*model, instances, SpeciesNames(species), scene_from_units);
  find_owners(nodes);
  const std::vector<std::vector<glm::dmat4>> places = find_places(nodes);
  std::map<SpeciesPlace, std::uint32_t> finest;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (const glm::dmat4& place : places[i]) {
      const NodePlant& plant = nodes[i].plant;
      if (plant.role != NodeRole::shape) continue;
      const auto [found, is_new] = finest.try_emplace(place_of(*plant.species, place), plant.level);
      if (!is_new) found->second = std::min(found->second, plant.level);
    }
  LevelPlants level;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const LevelNode& node = nodes[i];
    if (node.is_hidden && !node.placed.empty()) ++level.hidden.names[node.name];
    for (const glm::dmat4& place : places[i]) {
      const auto here = finest.find(place_of(*node.plant.species, place));
      const bool is_shape = node.plant.role == NodeRole::shape;
      if (here != finest.end() && (here->second < node.plant.level || !is_shape))
        ++level.coarser.names[node.name];
      else if (is_shape)
        add_plant(level, place * file_from_plant, *node.plant.species);
      else
        ++(node.is_instanced ? level.missing : level.other).names[node.name];
    }
    if (node.owner == kNone && !node.is_hidden && !node.placed.empty())
      (node.is_instanced ? level.missing : level.other).names[node.name] += node.placed.size();
  }
  return level;
}

}  // namespace coppice::bake
