#include "gltf_variant_groups.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include <tiny_gltf.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gltf_leave_out.h"
#include "material_words.h"
#include "node_names.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMaxVariants = 256;
/// Maximum number of top nodes that are compared in pairs.
constexpr std::size_t kMaxUnits = 2048;
constexpr int kMaxNesting = 4;

void add_item(const GltfNodes& scene, std::uint32_t item, NodeGroup& group) {
  group.items.push_back(item);
  group.box.add(scene.items[item].box);
}

NodeGroup joined(const std::vector<NodeGroup>& units, std::span<const std::size_t> members) {
  NodeGroup all;
  for (const std::size_t member : members) {
    all.items.insert(all.items.end(), units[member].items.begin(), units[member].items.end());
    all.box.add(units[member].box);
  }
  std::ranges::sort(all.items);
  std::string_view common = units[members.front()].name;
  for (const std::size_t member : members) {
    const std::string& name = units[member].name;
    common = common.substr(0, static_cast<std::size_t>(std::ranges::mismatch(common, name).in1 - common.begin()));
  }
  while (!common.empty() && std::string_view("_-. ").find(common.back()) != std::string_view::npos) common.remove_suffix(1);
  all.name = common.empty() ? units[members.front()].name : common;
  return all;
}

/// The top nodes: those below the last node that holds all items and has none of its own.
std::vector<NodeGroup> top_units(const GltfNodes& scene, std::span<const std::uint32_t> items) {
  std::vector<std::uint32_t> count(scene.nodes.size(), 0), own(scene.nodes.size(), 0);
  for (const std::uint32_t item : items) ++own[scene.items[item].position];
  for (std::size_t i = scene.nodes.size(); i-- > 0;) {
    count[i] += own[i];
    if (scene.nodes[i].parent != kNone) count[scene.nodes[i].parent] += count[i];
  }
  std::uint32_t holder = kNone;
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i)
    if (count[i] == items.size() && own[i] == 0) holder = i;
  // A node that shows a mesh and holds all other items is one plant.
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i)
    if (count[i] == items.size() && own[i] > 0) holder = scene.nodes[i].parent;
  std::vector<std::uint32_t> top(scene.nodes.size(), kNone);  // [nodes] the top node that it is, or is below
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i)
    top[i] = scene.nodes[i].parent == holder ? i : scene.nodes[i].parent == kNone ? kNone : top[scene.nodes[i].parent];
  std::map<std::uint32_t, NodeGroup> units;
  for (const std::uint32_t item : items) {
    const std::uint32_t at = top[scene.items[item].position];
    NodeGroup& unit = units[at];
    unit.name = shown_name(scene.nodes[at]);
    add_item(scene, item, unit);
  }
  std::vector<NodeGroup> list;
  for (auto& [at, unit] : units) list.push_back(std::move(unit));
  return list;
}

/// The words of a name without those that distinguish variants.
std::string common_words(const std::string& name) {
  std::string text;
  for (const std::string& word : name_words(name))
    if (!is_variant_word(word)) text += word + " ";
  return text;
}

/// Whether each group's name says that it is one of several ("oak_01", "oak_02"), and none names a part.
bool names_tell(const std::vector<NodeGroup>& groups) {
  if (std::ranges::all_of(groups, [](const NodeGroup& group) { return says_variant(group.name); })) return true;
  const std::string first = common_words(groups.front().name);
  return !first.empty() && !is_part_name(groups.front().name) &&
         std::ranges::all_of(groups, [&](const NodeGroup& group) { return common_words(group.name) == first; });
}

/// What a group's materials say about it.
struct GroupMaterials {
  std::set<std::uint32_t> materials;
  bool leaf = false, wood = false;  ///< by the materials' names
  bool masked = false;
};
GroupMaterials materials_of(const tinygltf::Model& model, const GltfNodes& scene, const NodeGroup& group) {
  GroupMaterials all;
  for (const std::uint32_t item : group.items)
    for (const std::uint32_t material : scene.items[item].materials) {
      if (!all.materials.insert(material).second) continue;
      const double evidence = material == kNone ? 0.0 : name_evidence(model.materials[material].name);
      all.leaf = all.leaf || evidence > 0.0;
      all.wood = all.wood || evidence < 0.0;
      all.masked = all.masked || is_masked(model, material);
    }
  return all;
}

/// Whether one group is leaves, by its materials' names, and another is wood.
bool are_parts(const std::vector<GroupMaterials>& materials) {
  const auto only_leaf = [](const GroupMaterials& each) { return each.leaf && !each.wood; };
  const auto only_wood = [](const GroupMaterials& each) { return each.wood && !each.leaf; };
  return std::ranges::any_of(materials, only_leaf) && std::ranges::any_of(materials, only_wood);
}

/// Whether groups show the same meshes: then they are copies in one plant, such as its twigs.
bool has_copies(const GltfNodes& scene, const std::vector<NodeGroup>& groups) {
  std::set<std::vector<std::uint32_t>> seen;
  for (const NodeGroup& group : groups) {
    std::vector<std::uint32_t> meshes;
    for (const std::uint32_t item : group.items) meshes.push_back(scene.items[item].mesh);
    std::ranges::sort(meshes);
    if (!seen.insert(std::move(meshes)).second) return true;
  }
  return false;
}

/// Whether all are high enough to be plants, and stand on one ground or have their middles at one height.
bool on_one_ground(const std::vector<NodeGroup>& groups) {
  constexpr double kMinHeight = 0.2, kGroundSlack = 0.15, kMiddleSlack = 0.02;
  double tallest = 0.0, ground = std::numeric_limits<double>::infinity();
  for (const NodeGroup& group : groups) {
    tallest = std::max(tallest, group.box.height());
    ground = std::min(ground, group.box.low.y);
  }
  const double middle = 0.5 * (groups.front().box.low.y + groups.front().box.high.y);
  bool ground_fits = true, middle_fits = true;
  for (const NodeGroup& group : groups) {
    if (group.box.height() < kMinHeight * tallest) return false;
    ground_fits = ground_fits && group.box.low.y - ground <= kGroundSlack * 0.5 * (tallest + group.box.height());
    middle_fits = middle_fits && std::abs(0.5 * (group.box.low.y + group.box.high.y) - middle) <= kMiddleSlack * tallest;
  }
  return tallest > 0.0 && (ground_fits || middle_fits);
}

/// How two groups stand relative to each other.
enum class Standing { apart, same_spot, together };

/// A group's crown and foot, and the origin of its first node.
struct Stand {
  NodeBox box, base;
  glm::dvec2 origin{0.0};
};

/// Whether a crown is about over its foot: stems of one plant that spring from one spot lean away from it.
bool is_upright(const Stand& stand) {
  return glm::length(stand.box.centre() - stand.base.centre()) <= 0.35 * stand.box.width();
}

Standing standing(const Stand& a, const Stand& b) {
  constexpr double kMaxOverlap = 0.4, kMinDistance = 0.2;
  const double height = 0.5 * (a.box.height() + b.box.height());
  const double min_share = [&] {
    double smallest = 1.0;
    for (const int axis : {0, 2}) {
      const double common = std::min(a.box.high[axis], b.box.high[axis]) - std::max(a.box.low[axis], b.box.low[axis]);
      const double narrow = std::min(a.box.size()[axis], b.box.size()[axis]);
      smallest = std::min(smallest, narrow > 0.0 ? common / narrow : common > 0.0 ? 1.0 : 0.0);
    }
    return smallest;
  }();
  if (min_share <= kMaxOverlap && glm::length(a.box.centre() - b.box.centre()) >= kMinDistance * height) return Standing::apart;
  const double reach = 0.25 * (a.base.width() + b.base.width()) + 0.01 * height;
  // Variants at one origin share it. Things that were moved next to each other do not.
  const bool one_foot = glm::length(a.base.centre() - b.base.centre()) <= reach && glm::length(a.origin - b.origin) <= 0.02 * height;
  if (one_foot && is_upright(a) && is_upright(b)) return Standing::same_spot;
  return Standing::together;
}

/// Whether the groups stand too far apart to be stems, or flowers, of one plant.
bool are_far_apart(const std::vector<NodeGroup>& groups) {
  constexpr double kMinDistance = 0.4;  // heights
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (glm::length(groups[i].box.centre() - groups[k].box.centre()) <
          kMinDistance * 0.5 * (groups[i].box.height() + groups[k].box.height()))
        return false;
  return true;
}

/// Whether all boxes' plans are apart by a margin.
bool are_all_clear(const std::vector<NodeGroup>& groups) {
  constexpr double kGap = 0.05;
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const NodeBox &a = groups[i].box, &b = groups[k].box;
      const double gap = kGap * std::min(a.width(), b.width());
      const bool clear = a.low.x > b.high.x + gap || b.low.x > a.high.x + gap || a.low.z > b.high.z + gap || b.low.z > a.high.z + gap;
      if (!clear) return false;
    }
  return true;
}

/// Whether the groups stand in a line along x or z.
bool are_in_row(const std::vector<NodeGroup>& groups) {
  glm::dvec2 low = groups.front().box.centre(), high = low;
  double width = 0.0;
  for (const NodeGroup& group : groups) {
    low = glm::min(low, group.box.centre());
    high = glm::max(high, group.box.centre());
    width += group.box.width() / static_cast<double>(groups.size());
  }
  const glm::dvec2 spread = high - low;
  return std::min(spread.x, spread.y) <= 0.5 * width;
}

/// Whether the groups are plants, by where they stand and what they are made of.
bool stand_like_variants(const tinygltf::Model& model, const GltfNodes& scene, const std::vector<NodeGroup>& groups,
                         const std::vector<GroupMaterials>& materials) {
  std::vector<Stand> stands;
  for (const NodeGroup& group : groups) {
    const glm::dvec4& origin = scene.items[group.items.front()].placed.front().scene_from_mesh[3];
    stands.push_back({group.box, base_of(model, scene, group.items), {origin.x, origin.z}});
  }
  bool any_same_spot = false;
  for (std::size_t i = 0; i < stands.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Standing how = standing(stands[i], stands[k]);
      if (how == Standing::together) return false;
      any_same_spot = any_same_spot || how == Standing::same_spot;
    }
  // A pot stands where its plant does.
  const auto has_leaves = [](const GroupMaterials& each) { return each.leaf || each.masked; };
  const auto leafy_count = std::ranges::count_if(materials, has_leaves);
  if (any_same_spot && leafy_count > 0 && leafy_count < std::ssize(materials)) return false;
  if (names_tell(groups)) return true;
  // Rings of leaves round one spot, or blades side by side, have one material.
  const bool mixed = std::ranges::all_of(materials, [](const GroupMaterials& each) { return each.materials.size() >= 2; });
  const auto has_first_materials = [&](const GroupMaterials& each) { return each.materials == materials.front().materials; };
  if (any_same_spot) return mixed && (leafy_count > 0 || std::ranges::all_of(materials, has_first_materials));
  if (!are_far_apart(groups)) return false;
  const bool in_row = are_in_row(groups), clear = are_all_clear(groups);
  const bool parts = std::ranges::any_of(groups, [](const NodeGroup& group) { return part_evidence(group.name) != 0.0; });
  return mixed ? in_row || clear : in_row && clear && !parts;
}

bool are_variants(const tinygltf::Model& model, const GltfNodes& scene, const std::vector<NodeGroup>& groups) {
  if (groups.size() < 2 || groups.size() > kMaxVariants || !on_one_ground(groups) || has_copies(scene, groups)) return false;
  std::vector<GroupMaterials> materials;
  for (const NodeGroup& group : groups) materials.push_back(materials_of(model, scene, group));
  return !are_parts(materials) && stand_like_variants(model, scene, groups, materials);
}

/// Groups units whose names differ in one word only: oak1_trunk and oak1_leaves, oak2_trunk and oak2_leaves. Empty if there are none.
std::vector<NodeGroup> grouped_by_name(const std::vector<NodeGroup>& units) {
  std::vector<std::vector<std::string>> words;
  std::size_t max_words = 0;
  for (const NodeGroup& unit : units) max_words = std::max(max_words, words.emplace_back(name_words(unit.name)).size());
  for (std::size_t word = 0; word < max_words; ++word) {
    std::map<std::string, std::vector<std::size_t>> by_value;
    std::map<std::string, std::multiset<std::string>> rests;
    for (std::size_t i = 0; i < units.size(); ++i) {
      // The original of a copy has no number.
      const bool has_word = word < words[i].size() && is_variant_word(words[i][word]);
      const std::string value = has_word ? words[i][word] : "";
      std::string rest;
      for (std::size_t k = 0; k < words[i].size(); ++k)
        if (k != word || !has_word) rest += words[i][k] + " ";
      by_value[value].push_back(i);
      rests[value].insert(rest);
    }
    const std::multiset<std::string>& first = rests.begin()->second;
    const auto same = [&](const auto& each) { return each.second == first; };
    if (by_value.size() < 2 || first.size() < 2 || !std::ranges::all_of(rests, same)) continue;
    std::vector<NodeGroup> groups;
    for (const auto& [value, members] : by_value) groups.push_back(joined(units, members));
    return groups;
  }
  return {};
}

/// Groups units whose plans overlap: they stand on one piece of ground.
std::vector<NodeGroup> grouped_by_ground(const std::vector<NodeGroup>& units) {
  UnionFind sets(units.size());
  for (std::size_t i = 0; i < units.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const NodeBox &a = units[i].box, &b = units[k].box;
      if (a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.z <= b.high.z && b.low.z <= a.high.z)
        sets.join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k));
    }
  std::map<std::uint32_t, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < units.size(); ++i) members[sets.find(static_cast<std::uint32_t>(i))].push_back(i);
  std::vector<NodeGroup> groups;
  for (const auto& [root, of_root] : members) groups.push_back(joined(units, of_root));
  return groups;
}

/// Drops what is no plant by itself: flat ground, and billboards that stand alone.
std::vector<NodeGroup> possible_plants(const tinygltf::Model& model, const GltfNodes& scene, std::vector<NodeGroup> units) {
  constexpr double kFlat = 0.03, kBoard = 0.25;  // relative to the tallest; leaves are quads, too, but small
  double tallest = 0.0;
  for (const NodeGroup& unit : units) tallest = std::max(tallest, unit.box.height());
  const auto is_flat = [&](const NodeGroup& unit) {
    const auto stands_on = [&](const NodeGroup& other) {
      const glm::dvec2 at = other.box.centre();
      return other.box.height() > kFlat * tallest && at.x > unit.box.low.x && at.x < unit.box.high.x && at.y > unit.box.low.z &&
             at.y < unit.box.high.z;
    };
    return unit.box.height() <= kFlat * tallest && std::ranges::count_if(units, stands_on) >= 2;
  };
  const auto is_board = [&](const NodeGroup& unit) {
    const auto is_shaped = [&](std::uint32_t item) { return is_billboard_shaped(model, scene.items[item]); };
    return unit.box.height() >= kBoard * tallest && std::ranges::all_of(unit.items, is_shaped);
  };
  std::vector<NodeGroup> plants;
  for (const NodeGroup& unit : units)
    if (!is_flat(unit) && !is_board(unit)) plants.push_back(unit);
  return plants.size() >= 2 ? plants : units;
}

std::vector<NodeGroup> split_nested(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items, int depth) {
  const std::vector<NodeGroup> units = top_units(scene, items);
  std::vector<std::size_t> all(units.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::vector<NodeGroup> one{joined(units, all)};
  if (depth == 0 || units.size() < 2 || units.size() > kMaxUnits) return one;
  const std::vector<NodeGroup> plants = possible_plants(model, scene, units);
  for (const auto& groups : {plants, grouped_by_name(plants), grouped_by_ground(plants)}) {
    if (!are_variants(model, scene, groups)) continue;
    std::vector<NodeGroup> split;
    for (const NodeGroup& group : groups) {
      std::vector<NodeGroup> inner = split_nested(model, scene, group.items, depth - 1);
      if (inner.size() == 1) inner.front().name = group.name;
      split.insert(split.end(), inner.begin(), inner.end());
    }
    return split;
  }
  return one;
}

}  // namespace

std::vector<NodeGroup> split_variants(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items) {
  std::vector<NodeGroup> groups = split_nested(model, scene, items, kMaxNesting);
  std::ranges::sort(groups, {}, [](const NodeGroup& group) { return group.items.front(); });
  std::map<std::string, int> seen;
  for (NodeGroup& group : groups)
    if (const int number = ++seen[group.name]; number > 1) group.name += "_" + std::to_string(number);
  return groups;
}

}  // namespace coppice::bake
