#include "wood_joints.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include <glm/geometric.hpp>

namespace coppice::bake {
namespace {

/// Maximum distance of an edge from the curve that it stands for, relative to the plant's height.
constexpr double kMaxGap = 0.01;
/// More triangles with long edges are a model of many flat parts, which would grow too large.
constexpr std::size_t kMaxLongTriangles = 20000;

/// The corner where a triangle's edge begins that rises most, if that is more than max_rise_m and there is a height between its ends.
std::optional<std::size_t> long_edge(const Mesh& mesh, std::size_t triangle, float max_rise_m) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < 3; ++i) {
    const float from_m = mesh.positions[mesh.indices[3 * triangle + i]].y,
                to_m = mesh.positions[mesh.indices[3 * triangle + (i + 1) % 3]].y;
    const float middle_m = 0.5f * (from_m + to_m);
    if (!(std::abs(to_m - from_m) > max_rise_m) || middle_m == from_m || middle_m == to_m) continue;
    max_rise_m = std::abs(to_m - from_m);
    found = i;
  }
  return found;
}

std::uint32_t add_middle(std::uint32_t a, std::uint32_t b, Mesh& mesh) {
  const glm::vec3 normal = mesh.normals[a] + mesh.normals[b];
  mesh.positions.push_back(0.5f * (mesh.positions[a] + mesh.positions[b]));
  mesh.normals.push_back(glm::length(normal) > 1e-6f ? glm::normalize(normal) : mesh.normals[a]);
  mesh.uvs.push_back(0.5f * (mesh.uvs[a] + mesh.uvs[b]));
  return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}

}  // namespace

void add_joints(const coppice_file_wind& wind, Mesh& wood) {
  if (!(wind.bend_m > 0.0f)) return;
  // A parabola of bend_m over height_m is bend_m / 4 (rise / height)^2 off the middle of its chord.
  const double height_m = wind.height_m;
  const auto max_rise_m = static_cast<float>(height_m * std::sqrt(4.0 * kMaxGap * height_m / wind.bend_m));
  std::size_t count = wood.indices.size() / 3, long_count = 0;
  for (std::size_t i = 0; i < count; ++i) long_count += long_edge(wood, i, max_rise_m) ? 1u : 0u;
  if (long_count == 0 || long_count > kMaxLongTriangles) return;
  wood.wind_weights.clear();  // the wind has been computed
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  for (std::size_t i = 0; i < count;) {
    const auto edge = long_edge(wood, i, max_rise_m);
    if (!edge) {
      ++i;
      continue;
    }
    const std::array<std::uint32_t, 3> turned{wood.indices[3 * i + *edge], wood.indices[3 * i + (*edge + 1) % 3],
                                              wood.indices[3 * i + (*edge + 2) % 3]};
    const auto [found, is_new] = middles.try_emplace({std::min(turned[0], turned[1]), std::max(turned[0], turned[1])}, 0u);
    if (is_new) found->second = add_middle(turned[0], turned[1], wood);
    const std::uint32_t middle = found->second;
    const std::array<std::uint32_t, 3> lower{turned[0], middle, turned[2]}, upper{middle, turned[1], turned[2]};
    std::ranges::copy(lower, wood.indices.begin() + static_cast<std::ptrdiff_t>(3 * i));
    wood.indices.insert(wood.indices.end(), upper.begin(), upper.end());
    wood.triangle_materials.push_back(wood.triangle_materials[i]);
    if (!wood.triangle_tints.empty()) wood.triangle_tints.push_back(wood.triangle_tints[i]);
    ++count;
  }
}

}  // namespace coppice::bake
