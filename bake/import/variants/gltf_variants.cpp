#include "gltf_variants.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <utility>

#include <tiny_gltf.h>

#include "gltf_leave_out.h"
#include "gltf_nodes.h"
#include "gltf_variant_groups.h"
#include "name_pattern.h"
#include "printable.h"

namespace coppice::bake {
namespace {

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

/// Leaves out items that are not below a node that `fits`. returns  whether any stay
template <class Fits>
bool keep_nodes(const GltfNodes& scene, const Fits& fits, LeftOut& left) {
  std::vector<bool> kept(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const GltfNode& node = scene.nodes[i];
    kept[i] = fits(node.name) || (node.item != kNone && fits(node.mesh_name)) || (node.parent != kNone && kept[node.parent]);
  }
  bool any = false;
  for (std::size_t i = 0; i < scene.items.size(); ++i) {
    if (kept[scene.items[i].position])
      any = true;
    else
      left.reason[i] = LeftReason::not_chosen;
  }
  return any;
}

Result<void> keep_chosen(const GltfNodes& scene, const std::string& wanted, LeftOut& left) {
  const LeftOut all = left;
  if (keep_nodes(
          scene, [&](const std::string& name) { return name == wanted; }, left))
    return {};
  left = all;
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

/// Lists what is left out, an entry for each node whose name or shape says so.
std::vector<SourceContents::Left> left_entries(const GltfNodes& scene, const LeftOut& left) {
  std::vector<SourceContents::Left> entries;
  std::vector<std::size_t> entry_of(scene.nodes.size(), static_cast<std::size_t>(-1));
  for (std::size_t i = 0; i < scene.items.size(); ++i) {
    const LeftReason reason = left.reason[i];
    if (reason == LeftReason::none || reason == LeftReason::not_chosen || reason == LeftReason::other_variant) continue;
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
  leave_collision_shapes(scene, left);
  leave_coarser_levels(model, scene, left);
  leave_named_billboards(scene, left);
  const std::vector<NodeGroup> groups = variants_of(model, scene, left);
  SourceContents contents;
  for (const NodeGroup& group : groups) contents.variants.push_back(variant_of(scene, group));
  contents.left = left_entries(scene, left);
  if (choice.variant == 0 || choice.variant > groups.size()) return no_such_variant(choice.variant, contents.variants);
  contents.taken = choice.variant - 1;
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (const std::uint32_t item : groups[i].items)
      if (i != contents.taken) left.reason[item] = LeftReason::other_variant;
  return contents;
}

const char* reason_name(LeftReason reason) {
  switch (reason) {
    case LeftReason::collision:
      return "collision shape";
    case LeftReason::coarser_level:
      return "coarser level";
    case LeftReason::billboard:
      return "billboard";
    case LeftReason::ground:
      return "ground";
    case LeftReason::none:
    case LeftReason::not_chosen:
    case LeftReason::other_variant:
      break;
  }
  return "";
}

template <class... Values>
std::string line(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
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
  if (!choice.whole && !taken_items(left).empty()) {
    COPPICE_TRY(contents, weigh(model, *scene, choice, left));
    chosen.contents = std::move(contents);
  }
  std::set<std::uint32_t> left_nodes;
  for (std::size_t i = 0; i < scene->items.size(); ++i)
    if (left.reason[i] != LeftReason::none) left_nodes.insert(scene->nodes[scene->items[i].position].node);
  std::erase_if(instances, [&](const MeshInstance& instance) { return left_nodes.contains(instance.node); });
  chosen.instances = std::move(instances);
  return chosen;
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
  for (const LeftReason reason : {LeftReason::coarser_level, LeftReason::billboard, LeftReason::collision, LeftReason::ground}) {
    std::vector<std::string> names;
    for (const SourceContents::Left& left : contents.left)
      if (left.reason == reason) names.push_back(left.name);
    if (!names.empty())
      text += (text.empty() ? "left out: " : "; left out: ") + std::string(reason_name(reason)) + (names.size() > 1 ? "s " : " ") +
              name_list(names);
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
  std::string text = line("%-32s %10s  %-24s %s\n", "the file holds", "triangles", "size, m", "is");
  for (std::size_t i = 0; i < contents.variants.size(); ++i) {
    const SourceContents::Variant& variant = contents.variants[i];
    const std::string size = line("%.3g x %.3g x %.3g", variant.size_m[0], variant.size_m[1], variant.size_m[2]);
    text += line("%-32s %10llu  %-24s variant %zu%s\n", printable(variant.name.substr(0, 32)).c_str(),
                 static_cast<unsigned long long>(variant.triangles), size.c_str(), i + 1, i == contents.taken ? ", taken" : "");
  }
  for (const SourceContents::Left& left : contents.left)
    text += line("%-32s %10llu  %-24s %s\n", printable(left.name.substr(0, 32)).c_str(), static_cast<unsigned long long>(left.triangles),
                 "", reason_name(left.reason));
  return text + "\n";
}

}  // namespace coppice::bake
