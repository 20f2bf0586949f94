#include "leaf_mesh.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "check.h"
#include "leaf_image.h"

namespace coppice::bake {
namespace {

glm::vec3 surface_point(const LeafOutline& outline, float x, float z, float ripple) {
  return {x, outline.fold * std::abs(x) - outline.arch * z * z + ripple, z};
}

/// Vertices of the midrib, then of one rim after the other.
void add_vertices(Mesh& mesh, const LeafOutline& outline) {
  for (const float z : outline.midrib_z) mesh.positions.push_back(surface_point(outline, 0.0f, z, 0.0f));
  for (const float side : {1.0f, -1.0f}) {
    float ripple = outline.ripple;
    for (const auto& [x, z] : outline.rim_xz) {
      mesh.positions.push_back(surface_point(outline, side * x, z, ripple));
      ripple = -ripple;
    }
  }
}

/// Zips midrib and rim together, always advancing the chain whose next point is nearer the stalk.
void add_side(Mesh& mesh, std::uint32_t midrib_count, std::uint32_t rim_first, std::uint32_t rim_count, bool left) {
  std::uint32_t midrib = 0, rim = 0;
  const auto z = [&](std::uint32_t vertex) { return mesh.positions[vertex].z; };
  while (midrib + 1 < midrib_count || rim + 1 < rim_count) {
    const bool along_midrib = rim + 1 == rim_count || (midrib + 1 < midrib_count && z(midrib + 1) < z(rim_first + rim + 1));
    const std::uint32_t a = midrib, b = along_midrib ? midrib + 1 : rim_first + rim + 1, c = rim_first + rim;
    if (left)
      mesh.indices.insert(mesh.indices.end(), {a, c, b});
    else
      mesh.indices.insert(mesh.indices.end(), {a, b, c});
    mesh.triangle_materials.push_back(0);
    (along_midrib ? midrib : rim) += 1;
  }
}

/// Area-weighted vertex normals.
void add_normals(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), glm::vec3(0.0f));
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::uint32_t a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
    const glm::vec3 area = glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    for (const std::uint32_t vertex : {a, b, c}) mesh.normals[vertex] += area;
  }
  for (glm::vec3& normal : mesh.normals) normal = glm::normalize(normal);
}

}  // namespace

LeafTemplate build_leaf(const LeafOutline& outline) {
  COPPICE_ASSERT(outline.midrib_z.size() >= 2 && !outline.rim_xz.empty());
  LeafTemplate leaf;
  add_vertices(leaf.mesh, outline);
  const auto midrib_count = static_cast<std::uint32_t>(outline.midrib_z.size());
  const auto rim_count = static_cast<std::uint32_t>(outline.rim_xz.size());
  add_side(leaf.mesh, midrib_count, midrib_count, rim_count, false);
  add_side(leaf.mesh, midrib_count, midrib_count + rim_count, rim_count, true);
  add_normals(leaf.mesh);
  const float half = half_width(outline);
  for (const glm::vec3& p : leaf.mesh.positions) leaf.mesh.uvs.push_back({0.5f + 0.5f * p.x / half, 1.0f - p.z});
  return leaf;
}

glm::vec3 posed(const LeafPose& pose, const glm::vec3& point) {
  const glm::vec3 side = glm::cross(pose.normal, pose.along);
  return pose.stalk + pose.length_m * (pose.width_scale * point.x * side + point.y * pose.normal + point.z * pose.along);
}

void append_leaf(Mesh& mesh, const LeafTemplate& leaf, const LeafPose& pose, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const glm::vec3 side = glm::cross(pose.normal, pose.along);
  for (const glm::vec3& point : leaf.mesh.positions) mesh.positions.push_back(posed(pose, point));
  for (const glm::vec3& normal : leaf.mesh.normals)
    mesh.normals.push_back(glm::normalize(normal.x / pose.width_scale * side + normal.y * pose.normal + normal.z * pose.along));
  mesh.uvs.insert(mesh.uvs.end(), leaf.mesh.uvs.begin(), leaf.mesh.uvs.end());
  for (const std::uint32_t index : leaf.mesh.indices) mesh.indices.push_back(first + index);
  mesh.triangle_materials.insert(mesh.triangle_materials.end(), leaf.mesh.triangle_materials.size(), material);
}

}  // namespace coppice::bake
