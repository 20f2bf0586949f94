#include "components.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "union_find.h"
#include "weld.h"

namespace coppice::bake {
namespace {

/// Triangles grouped by component, components in order of their first triangle.
struct Components {
  std::vector<std::uint32_t> triangles;
  std::vector<LeafRange> ranges;      ///< into `triangles`
  std::uint32_t collapsed_count = 0;  ///< components all of whose triangles have two corners in one place
};

bool is_collapsed(const std::vector<std::uint32_t>& welded, const std::uint32_t* corners) {
  const std::uint32_t a = welded[corners[0]], b = welded[corners[1]], c = welded[corners[2]];
  return a == b || b == c || c == a;
}

Components connect(const Mesh& mesh, const std::vector<std::uint32_t>& welded) {
  const std::size_t triangle_count = mesh.triangle_materials.size();
  UnionFind sets(welded.size());
  for (std::size_t t = 0; t < triangle_count; ++t) {
    const std::uint32_t* corners = &mesh.indices[3 * t];
    if (is_collapsed(welded, corners)) continue;
    sets.join(welded[corners[0]], welded[corners[1]]);
    sets.join(welded[corners[0]], welded[corners[2]]);
  }

  Components components;
  std::vector<std::uint32_t> component_of_set(welded.size(), kNone);
  std::vector<std::uint32_t> component_of_triangle(triangle_count, kNone);
  for (std::size_t t = 0; t < triangle_count; ++t) {
    const std::uint32_t* corners = &mesh.indices[3 * t];
    if (is_collapsed(welded, corners)) continue;
    std::uint32_t& component = component_of_set[sets.find(welded[corners[0]])];
    if (component == kNone) {
      component = static_cast<std::uint32_t>(components.ranges.size());
      components.ranges.emplace_back();
    }
    component_of_triangle[t] = component;
    ++components.ranges[component].triangle_count;
  }
  std::uint32_t first = 0;
  for (LeafRange& range : components.ranges) {
    range.first_triangle = first;
    first += range.triangle_count;
  }

  components.triangles.resize(first);
  std::vector<std::uint32_t> filled(components.ranges.size(), 0);
  std::vector<bool> counted(welded.size(), false);
  for (std::size_t t = 0; t < triangle_count; ++t) {
    const std::uint32_t component = component_of_triangle[t];
    if (component != kNone) {
      components.triangles[components.ranges[component].first_triangle + filled[component]++] = static_cast<std::uint32_t>(t);
      continue;
    }
    const std::uint32_t* corners = &mesh.indices[3 * t];
    const bool borders_leaf =
        std::any_of(corners, corners + 3, [&](std::uint32_t c) { return component_of_set[sets.find(welded[c])] != kNone; });
    const std::uint32_t set = std::min({welded[corners[0]], welded[corners[1]], welded[corners[2]]});
    if (borders_leaf || counted[set]) continue;
    counted[set] = true;
    ++components.collapsed_count;
  }
  return components;
}

double area_m2(const Mesh& mesh, const Components& components, const LeafRange& range) {
  double area = 0.0;
  for (std::uint32_t i = 0; i < range.triangle_count; ++i) {
    const std::uint32_t* corners = &mesh.indices[3 * std::size_t{components.triangles[range.first_triangle + i]}];
    const glm::dvec3 a(mesh.positions[corners[0]]), b(mesh.positions[corners[1]]), c(mesh.positions[corners[2]]);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

/// The square of the weld tolerance: less is a leaf that rounding made.
double least_area_m2(const Mesh& mesh) {
  if (mesh.positions.empty()) return 0.0;
  glm::dvec3 low(mesh.positions[0]), high(mesh.positions[0]);
  for (const glm::vec3& position : mesh.positions) {
    low = glm::min(low, glm::dvec3(position));
    high = glm::max(high, glm::dvec3(position));
  }
  const double tolerance_m = glm::distance(low, high) * static_cast<double>(kWeldTolerance);
  return tolerance_m * tolerance_m;
}

}  // namespace

SplitFoliage split_leaves(TriangleSoup soup) {
  Mesh& mesh = soup.mesh;
  const std::vector<std::uint32_t> welded = weld(mesh.positions, soup.vertex_instances);
  for (std::size_t i = 0; i < welded.size(); ++i) mesh.positions[i] = mesh.positions[welded[i]];
  const Components components = connect(mesh, welded);

  SplitFoliage split;
  split.dropped_leaf_count = components.collapsed_count;
  const double least_m2 = least_area_m2(mesh);
  std::vector<std::uint32_t> indices, materials;
  for (const LeafRange& range : components.ranges) {
    if (area_m2(mesh, components, range) <= least_m2) {
      ++split.dropped_leaf_count;
      continue;
    }
    split.leaves.push_back({static_cast<std::uint32_t>(materials.size()), range.triangle_count});
    for (std::uint32_t i = 0; i < range.triangle_count; ++i) {
      const std::size_t triangle = components.triangles[range.first_triangle + i];
      indices.insert(indices.end(), mesh.indices.begin() + static_cast<std::ptrdiff_t>(3 * triangle),
                     mesh.indices.begin() + static_cast<std::ptrdiff_t>(3 * triangle + 3));
      materials.push_back(mesh.triangle_materials[triangle]);
    }
  }
  mesh.indices = std::move(indices);
  mesh.triangle_materials = std::move(materials);
  split.mesh = compact(mesh);
  return split;
}

}  // namespace coppice::bake
