#include "gltf_variants.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <tiny_gltf.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "gltf_copies.h"
#include "gltf_nodes.h"
#include "material_words.h"
#include "name_pattern.h"
#include "node_names.h"
#include "printable.h"
#include "text_number.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMaxVariants = 256;
/// Maximum number of top nodes that are compared in pairs.
constexpr std::size_t kMaxUnits = 2048;
constexpr int kMaxNesting = 4;

/// Items that are one plant, or a part of one.
struct NodeGroup {
  std::string name;                  ///< the node's above them, or the beginning that their names share
  std::vector<std::uint32_t> items;  ///< ascending
  NodeBox box;
};

/// The beginning that all names share, without what joins words.
std::string common_front(const std::vector<std::string>& names) {
  std::string_view common = names.front();
  for (const std::string& name : names)
    common = common.substr(0, static_cast<std::size_t>(std::ranges::mismatch(common, name).in1 - common.begin()));
  while (!common.empty() && std::string_view("_-. ").find(common.back()) != std::string_view::npos) common.remove_suffix(1);
  return std::string(common);
}

NodeGroup joined(const std::vector<NodeGroup>& units, std::span<const std::size_t> members) {
  NodeGroup all;
  for (const std::size_t member : members) {
    all.items.insert(all.items.end(), units[member].items.begin(), units[member].items.end());
    all.box.add(units[member].box);
  }
  std::ranges::sort(all.items);
  std::vector<std::string> names;
  for (const std::size_t member : members) names.push_back(units[member].name);
  all.name = common_front(names);
  if (all.name.empty()) all.name = names.front();
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
    unit.items.push_back(item);
    unit.box.add(scene.items[item].box);
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
  return glm::distance(stand.box.centre(), stand.base.centre()) <= 0.35 * stand.box.width();
}

/// The smaller share of the narrower plan's sides that two plans have in common; not above 0 if they are apart.
double common_plan(const NodeBox& a, const NodeBox& b) {
  double smallest = 1.0;
  for (const int axis : {0, 2}) {
    const double common = std::min(a.high[axis], b.high[axis]) - std::max(a.low[axis], b.low[axis]);
    const double narrow = std::min(a.size()[axis], b.size()[axis]);
    smallest = std::min(smallest, narrow > 0.0 ? common / narrow : common > 0.0 ? 1.0 : 0.0);
  }
  return smallest;
}

Standing standing(const Stand& a, const Stand& b) {
  constexpr double kMaxOverlap = 0.4, kMinDistance = 0.2;
  const double height = 0.5 * (a.box.height() + b.box.height());
  if (common_plan(a.box, b.box) <= kMaxOverlap && glm::distance(a.box.centre(), b.box.centre()) >= kMinDistance * height)
    return Standing::apart;
  const double reach = 0.25 * (a.base.width() + b.base.width()) + 0.01 * height;
  // Variants at one origin share it. Things that were moved next to each other do not.
  const bool one_foot = glm::distance(a.base.centre(), b.base.centre()) <= reach && glm::distance(a.origin, b.origin) <= 0.02 * height;
  return one_foot && is_upright(a) && is_upright(b) ? Standing::same_spot : Standing::together;
}

/// Whether all pairs of groups have boxes that fit.
template <class Fits>
bool all_pairs(const std::vector<NodeGroup>& groups, const Fits& fits) {
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (!fits(groups[i].box, groups[k].box)) return false;
  return true;
}

/// Whether two plants stand too far apart to be stems, or flowers, of one.
bool are_far_apart(const NodeBox& a, const NodeBox& b) {
  constexpr double kMinDistance = 0.4;  // heights
  return glm::distance(a.centre(), b.centre()) >= kMinDistance * 0.5 * (a.height() + b.height());
}

bool plans_overlap(const NodeBox& a, const NodeBox& b, double gap) {
  return a.low.x <= b.high.x + gap && b.low.x <= a.high.x + gap && a.low.z <= b.high.z + gap && b.low.z <= a.high.z + gap;
}

/// Whether the plans are apart by a margin.
bool are_clear(const NodeBox& a, const NodeBox& b) {
  constexpr double kGap = 0.05;
  return !plans_overlap(a, b, kGap * std::min(a.width(), b.width()));
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
  if (!all_pairs(groups, are_far_apart)) return false;
  const bool in_row = are_in_row(groups), clear = all_pairs(groups, are_clear);
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
    for (std::size_t k = 0; k < i; ++k)
      if (plans_overlap(units[i].box, units[k].box, 0.0)) sets.join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k));
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

/// A variant's name for people and files: without its level; where a program gave it ("Object_4"), what its nodes' or meshes' names share.
std::string variant_name(const GltfNodes& scene, const NodeGroup& group) {
  std::vector<std::string> nodes, meshes;
  for (const std::uint32_t item : group.items) {
    nodes.push_back(scene.nodes[scene.items[item].position].name);
    meshes.push_back(scene.nodes[scene.items[item].position].mesh_name);
  }
  for (const std::string& name : {group.name, common_front(nodes), common_front(meshes)})
    if (std::string stem = without_level(name); !stem.empty() && !is_part_name(stem)) return stem;
  return group.name;
}

/// Whether two plants of nearly one size stand in one place.
bool are_in_one_place(const NodeBox& a, const NodeBox& b) {
  constexpr double kCommon = 0.7;
  const glm::dvec3 common = glm::min(a.high, b.high) - glm::max(a.low, b.low);
  return glm::all(glm::greaterThanEqual(common, kCommon * glm::max(a.size(), b.size())));
}

/// Sorts variants that are levels of detail by all but their names: in one place, each of at most three quarters of the triangles of the
/// one before. So the one that is taken is the finest.
void put_finest_first(const GltfNodes& scene, std::vector<NodeGroup>& groups) {
  std::vector<std::pair<std::uint64_t, NodeGroup>> sorted;
  for (const NodeGroup& group : groups) {
    if (!are_in_one_place(group.box, groups.front().box)) return;
    std::uint64_t triangles = 0;
    for (const std::uint32_t item : group.items) triangles += scene.items[item].triangles;
    sorted.emplace_back(triangles, group);
  }
  std::ranges::stable_sort(sorted, std::greater(), [](const auto& each) { return each.first; });
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (4 * sorted[i].first > 3 * sorted[i - 1].first) return;
  for (std::size_t i = 0; i < groups.size(); ++i) groups[i] = std::move(sorted[i].second);
}

/// Finds the plants that `items` are, in the order of their first items; one if they cannot be separated. Ground under several plants is in
/// none.
std::vector<NodeGroup> split_variants(const tinygltf::Model& model, const GltfNodes& scene, std::span<const std::uint32_t> items) {
  std::vector<NodeGroup> groups = split_nested(model, scene, items, kMaxNesting);
  std::ranges::sort(groups, {}, [](const NodeGroup& group) { return group.items.front(); });
  put_finest_first(scene, groups);
  std::map<std::string, int> seen;
  for (NodeGroup& group : groups) group.name = variant_name(scene, group);
  for (NodeGroup& group : groups)
    if (const int number = ++seen[group.name]; number > 1) group.name += "_" + std::to_string(number);
  return groups;
}

constexpr std::size_t kShownNames = 4;

std::string quoted(const std::string& name) {
  return "'" + name.substr(0, 64) + "'";
}

/// Lists names: "'a', 'b', 'c', 'd' and 3 more".
std::string name_list(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kShownNames); ++i) text += (i > 0 ? ", " : "") + quoted(names[i]);
  return names.size() > kShownNames ? text + " and " + std::to_string(names.size() - kShownNames) + " more" : text;
}

/// Leaves out items that are not below a node that `fits`, unless that would be all. returns  whether any are
template <class Fits>
bool keep_nodes(const GltfNodes& scene, const Fits& fits, LeftOut& left) {
  std::vector<bool> kept(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const GltfNode& node = scene.nodes[i];
    kept[i] = fits(node.name) || (node.item != kNone && fits(node.mesh_name)) || (node.parent != kNone && kept[node.parent]);
  }
  const auto is_kept = [&](const NodeItem& item) { return kept[item.position]; };
  if (std::ranges::none_of(scene.items, is_kept)) return false;
  for (std::size_t i = 0; i < scene.items.size(); ++i)
    if (!is_kept(scene.items[i])) left.reason[i] = LeftReason::not_chosen;
  return true;
}

Result<void> keep_chosen(const GltfNodes& scene, const std::string& wanted, LeftOut& left) {
  if (keep_nodes(
          scene, [&](const std::string& name) { return name == wanted; }, left))
    return {};
  COPPICE_TRY(pattern, NamePattern::compile(wanted, "--node"));
  if (keep_nodes(
          scene, [&](const std::string& name) { return !name.empty() && pattern.is_in(name); }, left))
    return {};
  std::vector<std::string> names;
  for (const NodeItem& item : scene.items) names.push_back(shown_name(scene.nodes[item.position]));
  return Error{Status::invalid_argument, "--node: no node with a mesh has this name, or is below one that has", Error::kNoOffset,
               quoted(wanted) + "; there are " + name_list(names)};
}

SourceContents::Variant variant_of(const GltfNodes& scene, const NodeGroup& group) {
  SourceContents::Variant variant{group.name, 0, {}};
  for (const std::uint32_t item : group.items) variant.triangles += scene.items[item].triangles;
  for (int axis = 0; axis < 3; ++axis) variant.size_m[static_cast<std::size_t>(axis)] = group.box.size()[axis];
  return variant;
}

/// The reasons that a person is told.
using Reason = std::pair<LeftReason, const char*>;
constexpr std::array<Reason, 5> kReasons{{{LeftReason::hidden, "hidden node"},
                                          {LeftReason::coarser_level, "coarser level"},
                                          {LeftReason::billboard, "billboard"},
                                          {LeftReason::collision, "collision shape"},
                                          {LeftReason::ground, "ground"}}};

/// Lists what is left out, an entry for each node whose name or shape says so.
std::vector<SourceContents::Left> left_entries(const GltfNodes& scene, const LeftOut& left) {
  std::vector<SourceContents::Left> entries;
  std::vector<std::size_t> entry_of(scene.nodes.size(), static_cast<std::size_t>(-1));
  for (std::size_t i = 0; i < scene.items.size(); ++i) {
    const LeftReason reason = left.reason[i];
    if (std::ranges::find(kReasons, reason, &Reason::first) == kReasons.end()) continue;
    std::size_t& entry = entry_of[left.by[i]];
    if (entry == static_cast<std::size_t>(-1)) {
      entry = entries.size();
      entries.push_back({reason, shown_name(scene.nodes[left.by[i]]), 0});
    }
    entries[entry].triangles += scene.items[i].triangles;
  }
  return entries;
}

/// Finds the variants of the taken items, and leaves out what stands between them.
std::vector<NodeGroup> variants_of(const tinygltf::Model& model, const GltfNodes& scene, LeftOut& left) {
  const std::vector<std::uint32_t> items = taken_items(left);
  std::vector<NodeGroup> groups = split_variants(model, scene, items);
  std::set<std::uint32_t> grouped;
  for (const NodeGroup& group : groups) {
    grouped.insert(group.items.begin(), group.items.end());
    leave_shaped_billboards(model, scene, group.items, left);
  }
  for (const std::uint32_t item : items) {
    if (grouped.contains(item)) continue;
    left.reason[item] = is_billboard_shaped(model, scene.items[item]) ? LeftReason::billboard : LeftReason::ground;
    left.by[item] = scene.items[item].position;
  }
  for (NodeGroup& group : groups) std::erase_if(group.items, [&](std::uint32_t item) { return left.reason[item] != LeftReason::none; });
  return groups;
}

Error no_such_variant(std::uint32_t wanted, const std::vector<SourceContents::Variant>& variants) {
  std::vector<std::string> names;
  for (const SourceContents::Variant& variant : variants) names.push_back(variant.name);
  return Error{Status::invalid_argument, "--variant: the file has fewer", Error::kNoOffset,
               std::to_string(wanted) + " of " + std::to_string(variants.size()) + ": " + name_list(names)};
}

/// Leaves out everything that is not the plant.
Result<SourceContents> weigh(const tinygltf::Model& model, const GltfNodes& scene, const PlantChoice& choice, LeftOut& left) {
  leave_hidden(model, scene, left);
  leave_collision_shapes(scene, left);
  leave_coarser_levels(model, scene, left);
  leave_named_billboards(scene, left);
  SourceContents contents;
  if (const auto copies = find_copies(scene, taken_items(left)); copies && choice.node) {
    for (const std::uint32_t item : copies->other_items) left.reason[item] = LeftReason::not_chosen;
  } else if (copies) {
    contents.copied_plant = copies->name;
    contents.copy_count = copies->count;
  }
  const std::vector<NodeGroup> groups = variants_of(model, scene, left);
  for (const NodeGroup& group : groups) contents.variants.push_back(variant_of(scene, group));
  contents.left = left_entries(scene, left);
  if (choice.variant == 0 || choice.variant > groups.size()) return no_such_variant(choice.variant, contents.variants);
  contents.taken = choice.variant - 1;
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (const std::uint32_t item : groups[i].items)
      if (i != contents.taken) left.reason[item] = LeftReason::other_variant;
  return contents;
}

}  // namespace

Result<ChosenNodes> choose_plant(const tinygltf::Model& model, std::vector<MeshInstance> instances, const PlantChoice& choice) {
  const auto is_first_node = [&](const MeshInstance& instance) { return instance.node == instances.front().node; };
  const bool is_one_node = std::ranges::all_of(instances, is_first_node);
  if (!choice.node && choice.variant == 1 && (choice.whole || is_one_node)) return ChosenNodes{std::move(instances), {}};
  Result<GltfNodes> scene = read_gltf_nodes(model, instances);
  // The importer reads the same data, and reports what is wrong with it.
  if (!scene) return ChosenNodes{std::move(instances), {}};
  LeftOut left{std::vector<LeftReason>(scene->items.size()), std::vector<std::uint32_t>(scene->items.size(), kNone)};
  if (choice.node) COPPICE_CHECK(keep_chosen(*scene, *choice.node, left));
  ChosenNodes chosen;
  if (!choice.whole && !taken_items(left).empty()) COPPICE_CHECK(move_into(chosen.contents, weigh(model, *scene, choice, left)));
  std::set<std::uint32_t> left_nodes;
  for (std::size_t i = 0; i < scene->items.size(); ++i)
    if (left.reason[i] != LeftReason::none) left_nodes.insert(scene->nodes[scene->items[i].position].node);
  std::erase_if(instances, [&](const MeshInstance& instance) { return left_nodes.contains(instance.node); });
  chosen.instances = std::move(instances);
  return chosen;
}

std::string level_line(const SourceContents& contents) {
  if (contents.copied_plant.empty()) return {};
  return "the file is a level: it has " + std::to_string(contents.copy_count) +
         " copies of whole plants, and all of it is baked as one; --node " + quoted(contents.copied_plant) +
         " bakes one plant, and coppice scene with --plants places baked ones as the level does";
}

std::string contents_line(const SourceContents& contents) {
  std::string text;
  if (contents.variants.size() > 1) {
    std::vector<std::string> others;
    for (std::size_t i = 0; i < contents.variants.size(); ++i)
      if (i != contents.taken) others.push_back(contents.variants[i].name);
    text = std::to_string(contents.variants.size()) + " variants: " + quoted(contents.variants[contents.taken].name) + " is taken, not " +
           name_list(others) + " (--variant N or all)";
  }
  for (const auto& [reason, reason_name] : kReasons) {
    std::vector<std::string> names;
    for (const SourceContents::Left& left : contents.left)
      if (left.reason == reason) names.push_back(left.name);
    if (!names.empty())
      text +=
          (text.empty() ? "left out: " : "; left out: ") + std::string(reason_name) + (names.size() > 1 ? "s " : " ") + name_list(names);
  }
  if (!contents.left.empty()) text += " (--node NAME takes one of them)";
  return text.empty() ? text : text + "; --variant whole bakes all of the file as one plant";
}

std::vector<std::filesystem::path> variant_outputs(const std::filesystem::path& output, const SourceContents& contents) {
  constexpr std::size_t kMaxChars = 64;
  const auto lower = [](std::string text) {
    std::ranges::transform(text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
  };
  const std::string stem = output.stem().string();
  std::set<std::string> used;
  std::vector<std::filesystem::path> outputs;
  for (const SourceContents::Variant& variant : contents.variants) {
    std::string name = variant.name.substr(0, kMaxChars);
    for (char& c : name)
      if (!(c >= '0' && c <= '9') && !(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z') && c != '-' && c != '.') c = '_';
    if (lower(name).starts_with(lower(stem))) name.erase(0, stem.size());
    while (name.starts_with('_') || name.starts_with('.')) name.erase(0, 1);
    std::string file = name.empty() ? stem : stem + "_" + name;
    for (int number = 2; !used.insert(lower(file)).second; ++number) file = stem + "_" + name + "_" + std::to_string(number);
    outputs.push_back(output.parent_path() / (file + output.extension().string()));
  }
  if (outputs.empty()) outputs.push_back(output);
  return outputs;
}

std::string contents_table(const SourceContents& contents) {
  if (contents.variants.size() < 2 && contents.left.empty()) return {};
  std::string text = formatted("%-32s %10s  %-24s %s\n", "the file holds", "triangles", "size, m", "is");
  for (std::size_t i = 0; i < contents.variants.size(); ++i) {
    const SourceContents::Variant& variant = contents.variants[i];
    const std::string size = formatted("%.3g x %.3g x %.3g", variant.size_m[0], variant.size_m[1], variant.size_m[2]);
    text += formatted("%-32s %10llu  %-24s variant %zu%s\n", printable(variant.name.substr(0, 32)).c_str(),
                      static_cast<unsigned long long>(variant.triangles), size.c_str(), i + 1, i == contents.taken ? ", taken" : "");
  }
  for (const SourceContents::Left& left : contents.left)
    text +=
        formatted("%-32s %10llu  %-24s %s\n", printable(left.name.substr(0, 32)).c_str(), static_cast<unsigned long long>(left.triangles),
                  "", std::ranges::find(kReasons, left.reason, &Reason::first)->second);
  return text + "\n";
}

}  // namespace coppice::bake
