#include "leaf_entry.h"

#include <algorithm>

namespace coppice::gpu {
namespace {

/// Number of discs along each leaf of a cluster, a power of two that suits most of the leaves' length.
std::uint32_t log2_grains(std::span<const LeafEntry> entries) {
  float length_m = 0, grains_m = 0;
  for (const LeafEntry& entry : entries) {
    length_m += entry.length_m;
    grains_m += entry.length_m * static_cast<float>(entry.grain_count);
  }
  if (!(length_m > 0.0f)) return 0;
  const float grains = grains_m / length_m;
  return grains < 2.0f ? 0 : grains < 3.5f ? 1 : 2;
}

/// Sets values for the first quarter of a cluster's places, for two, three and all quarters: how large leaves are, and how long grains are,
/// as a mean weighted by area or as half the longest.
void set_quarters(std::span<const LeafEntry> entries, std::uint32_t grains, Cluster& cluster) {
  float area_m2 = 0, grain_m3 = 0, longest_m = 0;
  for (std::size_t i = 0, quarter = 0; quarter < 4; ++quarter) {
    for (; i < std::min<std::size_t>(entries.size(), kClusterLeaves / 4 * (quarter + 1)); ++i) {
      area_m2 += entries[i].area_m2;
      const float grain_m = entries[i].length_m / static_cast<float>(entries[i].is_triangle ? 1u : grains);
      grain_m3 += entries[i].area_m2 * grain_m;
      longest_m = std::max(longest_m, grain_m);
    }
    if (!(area_m2 > 0.0f)) continue;
    cluster.grains_m |= pack_length(entries[0].is_triangle ? longest_m : std::max(grain_m3 / area_m2, 0.8f * longest_m)) << (8 * quarter);
    cluster.leaf_sizes_m |= pack_length(std::sqrt(area_m2 / static_cast<float>(i))) << (8 * quarter);
  }
}

void bound(std::span<const LeafEntry> entries, Cluster& cluster) {
  vec3 low = entries[0].corners[0], high = low;
  for (const LeafEntry& entry : entries)
    for (const vec3& corner : entry.corners) {
      low = min(low, corner);
      high = max(high, corner);
    }
  cluster.center = (low + high) * 0.5f;
  for (const LeafEntry& entry : entries)
    for (const vec3& corner : entry.corners) cluster.radius_m = std::max(cluster.radius_m, distance(corner, cluster.center));
}

/// Half of a leaf's axis without half a disc at its end, in steps of its splat's place.
vec3 axis_steps(const LeafEntry& entry, const vec3& splat_step) {
  return in_steps((entry.axis[1] - entry.axis[0]) * 0.5f, splat_step);
}

Splat splat_of(const LeafEntry& entry, const LeafBox& box, std::uint32_t grains, const Cluster& cluster) {
  const vec3 step = box.splat_step();
  const uvec3 place = quantised((entry.axis[0] + entry.axis[1]) * 0.5f - box.min, step);
  const float side_m = std::sqrt(entry.covered_m2 / static_cast<float>(grains));
  const float side = cluster.splat_size_m > 0.0f ? round(65535.0f * side_m / cluster.splat_size_m) : 0.0f;
  const vec2 normal = octahedral(entry.normals.axis), face = octahedral(entry.face);
  const uint axis_byte = packed_steps({entry.normals.along, entry.roughness, 0, 0, 0, 0, 0, 0}, 0.0f, 15.0f);
  const uint sided_bit = entry.normals.sided > 0.0f ? 1u << 31 : 0u;
  const vec3 along = cluster.axis_steps > 0.0f ? axis_steps(entry, step) / vec3(cluster.axis_steps) : vec3(0.0f);
  return {.xy = place.x | place.y << 16,
          .z_size = place.z | static_cast<uint>(side) << 16,
          .axis = packSnorm4x8(vec4(along, 0.0f)) | axis_byte << 24,
          .normals = packSnorm4x8(vec4(normal.x, normal.y, face.x, face.y)),
          .look = entry.look | sided_bit,
          .crown = pack_crown(entry.light)};
}

}  // namespace

ClusterList empty_list(const LeafBox& box) {
  return {.box_min = box.min, .box_step = box.step, .splat_step = box.splat_step()};
}

vec3 in_steps(const vec3& offset, const vec3& step) {
  const vec3 steps = offset / step;
  return {step.x > 0.0f ? steps.x : 0.0f, step.y > 0.0f ? steps.y : 0.0f, step.z > 0.0f ? steps.z : 0.0f};
}

uvec3 quantised(const vec3& offset, const vec3& step) {
  const vec3 steps = clamp(round(in_steps(offset, step)), vec3(0.0f), vec3(65535.0f));
  return {static_cast<uint>(steps.x), static_cast<uint>(steps.y), static_cast<uint>(steps.z)};
}

float quad_area(const std::array<vec3, 4>& c) {
  const vec3 across = c[2] - c[0];
  return 0.5f * (length(cross(c[1] - c[0], across)) + length(cross(across, c[3] - c[0])));
}

LeafEntry make_entry(const std::array<uvec3, 4>& corners, const LeafBox& box) {
  LeafEntry entry;
  entry.leaf.life = kNoDeath;
  for (std::uint32_t i = 0; i < 12; ++i) entry.leaf.corners[i / 2] |= corners[i / 3][i % 3] << (i % 2 * 16);
  auto& c = entry.corners;
  for (std::size_t i = 0; i < 4; ++i) c[i] = box.at(corners[i]);
  entry.size_m = std::max(length(c[2] - c[0]), length(c[3] - c[1]));
  entry.area_m2 = quad_area(c);
  const std::array<vec3, 2> along{(c[0] + c[3]) * 0.5f, (c[1] + c[2]) * 0.5f}, across{(c[0] + c[1]) * 0.5f, (c[2] + c[3]) * 0.5f};
  const float along_m = length(along[1] - along[0]), across_m = length(across[1] - across[0]);
  entry.axis = along_m >= across_m ? along : across;
  entry.length_m = std::max(along_m, across_m);
  if (entry.area_m2 > 0.0f) {
    constexpr float kGrainAspect = 2.0f;  // a disc replaces a leaf that is up to three times as long as wide
    const float aspect = entry.length_m * entry.length_m / entry.area_m2;
    entry.grain_count = static_cast<std::uint32_t>(std::clamp(std::lround(aspect / kGrainAspect), 1L, long{kMaxGrains}));
  }
  return entry;
}

Cluster write_cluster(std::span<const LeafEntry> entries, const Births& births, const LeafBox& box, std::span<Leaf> leaves,
                      std::span<Splat> splats) {
  Cluster cluster{};
  bound(entries, cluster);
  const std::uint32_t log_grains = log2_grains(entries), grains = 1u << log_grains;
  set_quarters(entries, grains, cluster);
  cluster.counts = static_cast<std::uint32_t>(entries.size()) | log_grains << kCountGrains |
                   (entries[0].is_surface ? 1u : 0u) << kCountSurface | births.first << kCountFirstBirth | births.last << kCountLastBirth;
  const vec3 step = box.splat_step();
  for (const LeafEntry& entry : entries) {
    if (entry.transparency > 0) cluster.counts |= 1u << kCountTransparent;
    cluster.last_death = std::max(cluster.last_death, entry.leaf.life & kNoDeath);
    cluster.splat_size_m = std::max(cluster.splat_size_m, std::sqrt(entry.covered_m2 / static_cast<float>(grains)));
    const vec3 along = abs(axis_steps(entry, step));
    cluster.axis_steps = std::max({cluster.axis_steps, along.x, along.y, along.z});
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    leaves[i] = entries[i].leaf;
    splats[i] = splat_of(entries[i], box, grains, cluster);
  }
  return cluster;
}

}  // namespace coppice::gpu
