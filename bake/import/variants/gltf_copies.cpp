#include "gltf_copies.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include <glm/geometric.hpp>

#include "seeded_random.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMinCopies = 3;

/// What is at a node and below: a sum over its meshes that copies have in common.
struct Shown {
  std::uint64_t meshes = 0, triangles = 0;
  NodeBox box;
  std::uint32_t first_item = kNone;
  bool operator==(const Shown& other) const { return meshes == other.meshes && triangles == other.triangles; }
};

std::vector<Shown> shown_below(const GltfNodes& scene, std::span<const std::uint32_t> items) {
  std::vector<Shown> all(scene.nodes.size());
  for (const std::uint32_t i : items) {
    const NodeItem& item = scene.items[i];
    all[item.position] = {mix_bits(item.mesh + 1) * item.placed.size(), item.triangles, item.box, i};
  }
  for (std::size_t i = all.size(); i-- > 0;)
    if (const std::uint32_t parent = scene.nodes[i].parent; parent != kNone) {
      all[parent].meshes += all[i].meshes;
      all[parent].triangles += all[i].triangles;
      all[parent].box.add(all[i].box);
      all[parent].first_item = std::min(all[parent].first_item, all[i].first_item);
    }
  return all;
}

/// A plant where it stands.
struct Copy {
  std::uint32_t node = 0;
  glm::dvec2 foot{0.0};
  glm::dvec3 up{0.0};
  double height_m = 0.0;
  std::uint64_t triangles = 0;
};

Copy copy_at(std::uint32_t node, const glm::dmat4& transform, double height_m, std::uint64_t triangles) {
  const glm::dvec3 up(transform[1]);
  return {node, {transform[3].x, transform[3].z}, glm::dot(up, up) > 0.0 ? glm::normalize(up) : up, height_m, triangles};
}

/// Copies by what they show; of a chain of nodes that show the same the highest counts. Nodes below copies are none.
std::vector<std::vector<Copy>> all_copies(const GltfNodes& scene, const std::vector<Shown>& shown) {
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::vector<Copy>> by_shown;
  const auto parent_of = [&](std::uint32_t i) { return scene.nodes[i].parent; };
  const auto key = [&](std::uint32_t i) { return std::pair(shown[i].meshes, shown[i].triangles); };
  const auto is_top = [&](std::uint32_t i) { return shown[i].triangles > 0 && (parent_of(i) == kNone || shown[parent_of(i)] != shown[i]); };
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::size_t> counts;
  for (std::uint32_t i = 0; i < shown.size(); ++i)
    if (is_top(i)) ++counts[key(i)];
  std::vector<bool> inside(shown.size());
  for (std::uint32_t i = 0; i < shown.size(); ++i) {
    inside[i] = parent_of(i) != kNone && inside[parent_of(i)];
    if (inside[i] || shown[i].triangles == 0) continue;
    const NodeItem& item = scene.items[shown[i].first_item];
    if (is_top(i) && counts[key(i)] >= kMinCopies) {
      inside[i] = true;
      by_shown[key(i)].push_back(copy_at(i, item.placed.front().scene_from_mesh, shown[i].box.height(), shown[i].triangles));
    } else if (item.position == i && item.placed.size() >= kMinCopies) {
      for (const MeshInstance& placed : item.placed)
        by_shown[key(i)].push_back(copy_at(i, placed.scene_from_mesh, item.first_box.height(), item.triangles / item.placed.size()));
    }
  }
  std::vector<std::vector<Copy>> all;
  for (auto& [what, copies] : by_shown) all.push_back(std::move(copies));
  return all;
}

/// The largest height of a thing that is no ground.
double tallest_m(const GltfNodes& scene, std::span<const std::uint32_t> items) {
  constexpr double kSlender = 0.3;
  double tallest = 0.0;
  for (const std::uint32_t i : items) {
    const NodeBox& box = scene.items[i].first_box;
    if (box.height() >= kSlender * box.width()) tallest = std::max(tallest, box.height());
  }
  return tallest;
}

bool are_plants(const std::vector<Copy>& copies, double tallest_m) {
  constexpr std::uint64_t kMinTriangles = 64;
  constexpr double kMinHeight = 0.3, kApart = 0.4, kUpright = 0.95;
  constexpr std::size_t kMaxCompared = 512;
  const Copy& first = copies.front();
  if (copies.size() < kMinCopies || first.triangles < kMinTriangles || first.height_m < kMinHeight * tallest_m) return false;
  const std::span compared = std::span(copies).first(std::min(copies.size(), kMaxCompared));
  const auto stands_apart = [&](const Copy& copy) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Copy& other : compared)
      if (&other != &copy) nearest = std::min(nearest, glm::distance(copy.foot, other.foot));
    return nearest >= kApart * copy.height_m && glm::dot(copy.up, first.up) >= kUpright;
  };
  return 2 * static_cast<std::size_t>(std::ranges::count_if(compared, stands_apart)) >= compared.size();
}

}  // namespace

std::optional<PlantCopies> find_copies(const GltfNodes& scene, std::span<const std::uint32_t> items) {
  const std::vector<Shown> shown = shown_below(scene, items);
  const double tallest = tallest_m(scene, items);
  PlantCopies found;
  std::uint32_t first_node = kNone;
  std::vector<bool> is_other(scene.nodes.size());
  for (const std::vector<Copy>& copies : all_copies(scene, shown)) {
    if (!are_plants(copies, tallest)) continue;
    found.count += copies.size();
    first_node = std::min(first_node, copies.front().node);
    for (const Copy& copy : copies) is_other[copy.node] = copy.node != copies.front().node;
  }
  if (first_node == kNone) return {};
  found.name = shown_name(scene.nodes[first_node]);
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i)
    if (scene.nodes[i].parent != kNone && is_other[scene.nodes[i].parent]) is_other[i] = true;
  for (const std::uint32_t item : items)
    if (is_other[scene.items[item].position]) found.other_items.push_back(item);
  return found;
}

}  // namespace coppice::bake
