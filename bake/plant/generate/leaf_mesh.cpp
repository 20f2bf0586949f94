#include "leaf_mesh.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "check.h"
#include "srgb.h"

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

/// Largest distance of the rim from the midrib, in leaf lengths.
float half_width(const LeafOutline& outline) {
  float widest = 0.0f;
  for (const auto& [x, z] : outline.rim_xz) widest = std::max(widest, x);
  return widest;
}

constexpr int kSamplesPerSide = 4;

/// Distance of the rim from the midrib at a distance z from the stalk; 0 beyond the leaf.
float rim_at(const LeafOutline& outline, float z) {
  if (z <= 0.0f || z >= 1.0f) return 0.0f;
  std::array<float, 2> below{0.0f, 0.0f};
  for (const auto& above : outline.rim_xz) {
    if (z <= above[1]) return glm::mix(below[0], above[0], (z - below[1]) / (above[1] - below[1]));
    below = above;
  }
  return below[0] * (1.0f - z) / (1.0f - below[1]);
}

/// 1 on a vein, 0 away from it. Side veins leave the midrib at an angle and run to the rim.
float vein_at(const LeafPaint& paint, float x, float z) {
  const auto line = [](float distance, float width) { return std::clamp(1.5f - distance / width, 0.0f, 1.0f); };
  const float midrib = line(std::abs(x), paint.vein_width * (1.4f - z));
  if (paint.side_vein_count == 0) return midrib;
  const float spacing = 1.0f / static_cast<float>(paint.side_vein_count);
  const float along = (z - paint.side_vein_slope * std::abs(x)) / spacing;
  const float off = std::abs(along - std::round(along)) * spacing / std::hypot(1.0f, paint.side_vein_slope);
  const float side = along > 0.4f ? line(off, 0.55f * paint.vein_width) : 0.0f;
  return std::max(midrib, 0.7f * side);
}

std::uint8_t byte_of(float value) {
  return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

std::uint8_t srgb_byte(float linear) {
  return byte_of(srgb_from_linear(std::clamp(linear, 0.0f, 1.0f)));
}

}  // namespace

Mesh build_leaf(const LeafOutline& outline) {
  COPPICE_ASSERT(outline.midrib_z.size() >= 2 && !outline.rim_xz.empty());
  Mesh leaf;
  add_vertices(leaf, outline);
  const auto midrib_count = static_cast<std::uint32_t>(outline.midrib_z.size());
  const auto rim_count = static_cast<std::uint32_t>(outline.rim_xz.size());
  add_side(leaf, midrib_count, midrib_count, rim_count, false);
  add_side(leaf, midrib_count, midrib_count + rim_count, rim_count, true);
  add_normals(leaf);
  const float half = half_width(outline);
  for (const glm::vec3& p : leaf.positions) leaf.uvs.push_back({0.5f + 0.5f * p.x / half, 1.0f - p.z});
  return leaf;
}

glm::vec3 posed(const LeafPose& pose, const glm::vec3& point) {
  const glm::vec3 side = glm::cross(pose.normal, pose.along);
  return pose.stalk + pose.length_m * (pose.width_scale * point.x * side + point.y * pose.normal + point.z * pose.along);
}

void append_leaf(Mesh& mesh, const Mesh& leaf, const LeafPose& pose, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const glm::vec3 side = glm::cross(pose.normal, pose.along);
  for (const glm::vec3& point : leaf.positions) mesh.positions.push_back(posed(pose, point));
  for (const glm::vec3& normal : leaf.normals)
    mesh.normals.push_back(glm::normalize(normal.x / pose.width_scale * side + normal.y * pose.normal + normal.z * pose.along));
  mesh.uvs.insert(mesh.uvs.end(), leaf.uvs.begin(), leaf.uvs.end());
  for (const std::uint32_t index : leaf.indices) mesh.indices.push_back(first + index);
  mesh.triangle_materials.insert(mesh.triangle_materials.end(), leaf.triangle_materials.size(), material);
}

Image paint_leaf(const LeafOutline& outline, const LeafPaint& paint) {
  Image image{.width = paint.width_px, .height = paint.height_px, .rgba = {}};
  const float half = half_width(outline);
  const float texel_x = 2.0f * half / static_cast<float>(paint.width_px);
  const float texel_z = 1.0f / static_cast<float>(paint.height_px);
  for (std::uint32_t row = 0; row < paint.height_px; ++row)
    for (std::uint32_t column = 0; column < paint.width_px; ++column) {
      float inside = 0.0f, vein = 0.0f;
      for (int sample = 0; sample < kSamplesPerSide * kSamplesPerSide; ++sample) {
        const int down = sample / kSamplesPerSide, right = sample % kSamplesPerSide;
        const float dx = (static_cast<float>(right) + 0.5f) / kSamplesPerSide;
        const float dy = (static_cast<float>(down) + 0.5f) / kSamplesPerSide;
        const float x = half * (2.0f * (static_cast<float>(column) + dx) / static_cast<float>(paint.width_px) - 1.0f);
        const float z = 1.0f - (static_cast<float>(row) + dy) / static_cast<float>(paint.height_px);
        inside += std::abs(x) <= texel_x + std::max({rim_at(outline, z - texel_z), rim_at(outline, z), rim_at(outline, z + texel_z)})
                      ? 1.0f
                      : 0.0f;
        vein += vein_at(paint, x, z);
      }
      constexpr float kSampleCount = kSamplesPerSide * kSamplesPerSide;
      const glm::vec3 color = glm::mix(paint.blade, paint.vein, vein / kSampleCount);
      // Colour does not stop at the outline: filtered samples there would pick up what lies outside.
      image.rgba.insert(image.rgba.end(), {srgb_byte(color.r), srgb_byte(color.g), srgb_byte(color.b), byte_of(inside / kSampleCount)});
    }
  return image;
}

}  // namespace coppice::bake
