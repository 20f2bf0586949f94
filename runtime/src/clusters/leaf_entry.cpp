#include "leaf_entry.h"

#include <algorithm>
#include <bit>

#include "coppice_lod.h"

namespace coppice::gpu {
namespace {

std::uint32_t snorm8(float value) {
  return static_cast<std::uint32_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * 127.0f)) & 0xffu;
}

/// Two snorm8: the octahedron's lower half is folded outwards.
std::uint32_t octahedral(const Point& normal) {
  const float sum = std::abs(normal[0]) + std::abs(normal[1]) + std::abs(normal[2]);
  if (!(sum > 0.0f)) return 0;
  Point n{normal[0] / sum, normal[1] / sum, normal[2] / sum};
  if (n[2] < 0.0f) {
    const float x = (1.0f - std::abs(n[1])) * (n[0] >= 0.0f ? 1.0f : -1.0f);
    n[1] = (1.0f - std::abs(n[0])) * (n[1] >= 0.0f ? 1.0f : -1.0f);
    n[0] = x;
  }
  return snorm8(n[0]) | snorm8(n[1]) << 8;
}

/// Discs along each leaf of a cluster, a power of two: what most of its leaves' length wants.
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

std::uint32_t pack_length(float length_m) {
  if (!(length_m > 0.0f)) return 0;
  return static_cast<std::uint32_t>(std::clamp(std::lround(kLengthSteps * std::log2(length_m)) + long{kLengthZero}, 1L, 255L));
}

/// Of the first quarter of a cluster's places, two, three and all: how large leaves are, and how long grains in the mean of what they
/// cover, or half as long as the longest.
void set_quarters(std::span<const LeafEntry> entries, std::uint32_t grains, Cluster& cluster) {
  float area_m2 = 0, grain_m3 = 0, longest_m = 0, bulk = 0;
  for (std::size_t i = 0, quarter = 0; quarter < 4; ++quarter) {
    for (; i < std::min<std::size_t>(entries.size(), kClusterLeaves / 4 * (quarter + 1)); ++i) {
      area_m2 += entries[i].area_m2;
      const float grain_m = entries[i].length_m / static_cast<float>(entries[i].is_triangle ? 1u : grains);
      grain_m3 += entries[i].area_m2 * grain_m;
      longest_m = std::max(longest_m, grain_m);
      bulk += entries[i].bulk;
    }
    cluster.bulks |= static_cast<std::uint32_t>(std::lround(255.0f * bulk / static_cast<float>(i))) << (8 * quarter);
    if (!(area_m2 > 0.0f)) continue;
    cluster.grains_m |= pack_length(entries[0].is_triangle ? longest_m : std::max(grain_m3 / area_m2, 0.8f * longest_m)) << (8 * quarter);
    cluster.leaf_sizes_m |= pack_length(std::sqrt(area_m2 / static_cast<float>(i))) << (8 * quarter);
  }
}

void bound(std::span<const LeafEntry> entries, Cluster& cluster) {
  Point low = entries[0].corners[0], high = low;
  for (const LeafEntry& entry : entries)
    for (const Point& corner : entry.corners)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], corner[axis]);
        high[axis] = std::max(high[axis], corner[axis]);
      }
  const Point center = (low + high) * 0.5f;
  cluster.center = {center[0], center[1], center[2]};
  for (const LeafEntry& entry : entries)
    for (const Point& corner : entry.corners) cluster.radius_m = std::max(cluster.radius_m, length(corner - center));
}

/// Half of a leaf's axis but for half a disc at its end, in steps of its splat's place.
Point axis_steps(const LeafEntry& entry, const Point& splat_step) {
  const Point half = (entry.axis[1] - entry.axis[0]) * 0.5f;
  Point steps{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (splat_step[axis] > 0.0f) steps[axis] = half[axis] / splat_step[axis];
  return steps;
}

Splat splat_of(const LeafEntry& entry, const ListFrame& frame, std::uint32_t grains, const Cluster& cluster) {
  const Point step = frame.splat_step(), middle = (entry.axis[0] + entry.axis[1]) * 0.5f;
  std::array<std::uint32_t, 4> words{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (step[axis] > 0.0f)
      words[axis] = static_cast<std::uint32_t>(std::clamp(std::lround((middle[axis] - frame.low[axis]) / step[axis]), 0L, 65535L));
  if (cluster.splat_size_m > 0.0f) {
    const float side_m = std::sqrt(entry.covered_m2 / static_cast<float>(grains));
    words[3] = static_cast<std::uint32_t>(std::clamp(std::lround(65535.0f * side_m / cluster.splat_size_m), 0L, 65535L));
  }
  const auto sky = static_cast<std::uint32_t>(std::lround(255.0f * std::clamp(entry.light.sky, 0.0f, 1.0f)));
  Splat splat{.xy = words[0] | words[1] << 16,
              .z_size = words[2] | words[3] << 16,
              .axis = 0,
              .normals = octahedral(entry.normal) | octahedral(entry.face) << 16,
              .look = entry.look | sky << 24,
              .crown = pack_crown(entry.light)};
  const Point along = axis_steps(entry, step);
  for (std::size_t axis = 0; axis < 3 && cluster.axis_steps > 0.0f; ++axis)
    splat.axis |= snorm8(along[axis] / cluster.axis_steps) << (8 * axis);
  return splat;
}

}  // namespace

ClusterList ListFrame::empty_list() const {
  const Point splat = splat_step();
  return {.box_min = {low[0], low[1], low[2]}, .box_step = {step[0], step[1], step[2]}, .splat_step = {splat[0], splat[1], splat[2]}};
}

Crown::Crown(const LeafBox& box) {
  const ListFrame frame(box);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float half = 0.5f * static_cast<float>(box.largest) * frame.step[axis];
    center[axis] = frame.low[axis] + half;
    radii[axis] = std::max(half, 1e-3f);
  }
}

LeafEntry make_entry(const std::array<std::array<std::uint32_t, 3>, 4>& quantised, const ListFrame& frame) {
  LeafEntry entry;
  entry.leaf.life = kNoDeath;
  for (std::uint32_t i = 0; i < 12; ++i) entry.leaf.corners[i / 2] |= quantised[i / 3][i % 3] << (i % 2 * 16);
  auto& c = entry.corners;
  for (std::size_t i = 0; i < 4; ++i) c[i] = frame.at(quantised[i]);
  entry.size_m = std::max(length(c[2] - c[0]), length(c[3] - c[1]));
  entry.area_m2 = quad_area(c);
  const std::array<Point, 2> along{(c[0] + c[3]) * 0.5f, (c[1] + c[2]) * 0.5f}, across{(c[0] + c[1]) * 0.5f, (c[2] + c[3]) * 0.5f};
  const float along_m = length(along[1] - along[0]), across_m = length(across[1] - across[0]);
  entry.axis = along_m >= across_m ? along : across;
  entry.length_m = std::max(along_m, across_m);
  if (entry.area_m2 > 0.0f) {
    constexpr float kGrainAspect = 2.0f;  // a disc passes for a leaf up to three times as long as wide
    const float aspect = entry.length_m * entry.length_m / entry.area_m2;
    entry.grain_count = static_cast<std::uint32_t>(std::clamp(std::lround(aspect / kGrainAspect), 1L, long{kMaxGrains}));
  }
  return entry;
}

Point variation(const Point& place_in_crown, const std::array<std::uint32_t, 3>& stalk) {
  const auto cell = [&](std::size_t axis) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(place_in_crown[axis] * 4.0f)) + 16);
  };
  const std::uint32_t tuft = lod::coppice_hash(cell(0) + cell(1) * 64u + cell(2) * 4096u);
  const std::uint32_t leaf = lod::coppice_hash((stalk[0] + stalk[1] * 16384u) ^ (stalk[2] * 747796405u));
  const float a = static_cast<float>(tuft >> 16) / 65535.0f - 0.5f;
  const float b = static_cast<float>(leaf >> 16) / 65535.0f - 0.5f;
  const float c = static_cast<float>(leaf & 0xffffu) / 65535.0f - 0.5f;
  return Point{1.0f + 0.16f * c, 1.0f, 1.0f - 0.14f * c} * (1.0f + 0.16f * a + 0.30f * b);
}

Point lit_normal(const Crown& crown, const Point& middle, Point& face, float crown_normals) {
  Point outward = middle - crown.center;
  for (std::size_t axis = 0; axis < 3; ++axis) outward[axis] /= crown.radii[axis] * crown.radii[axis];
  outward = normalised(outward + Point{0.0f, 1e-4f, 0.0f});
  face = dot(face, face) > 1e-20f ? normalised(face) : outward;
  const float side = std::clamp(4.0f * dot(face, outward), -1.0f, 1.0f), turned = std::max(crown_normals, 1e-3f);
  return normalised(face * (side * (1.0f - turned)) + outward * turned);
}

Cluster write_cluster(std::span<const LeafEntry> entries, const Births& births, const ListFrame& frame, std::span<Leaf> leaves,
                      std::span<Splat> splats) {
  Cluster cluster{};
  bound(entries, cluster);
  const std::uint32_t log_grains = log2_grains(entries), grains = 1u << log_grains;
  set_quarters(entries, grains, cluster);
  cluster.counts = static_cast<std::uint32_t>(entries.size()) | log_grains << kCountGrains |
                   (entries[0].is_surface ? 1u : 0u) << kCountSurface | births.first << kCountFirstBirth | births.last << kCountLastBirth;
  const Point step = frame.splat_step();
  for (const LeafEntry& entry : entries) {
    cluster.last_death = std::max(cluster.last_death, entry.leaf.life & kNoDeath);
    cluster.splat_size_m = std::max(cluster.splat_size_m, std::sqrt(entry.covered_m2 / static_cast<float>(grains)));
    for (const float along : axis_steps(entry, step)) cluster.axis_steps = std::max(cluster.axis_steps, std::abs(along));
  }
  for (std::size_t i = 0; i < entries.size(); ++i) {
    leaves[i] = entries[i].leaf;
    splats[i] = splat_of(entries[i], frame, grains, cluster);
  }
  return cluster;
}

float unpack_length(std::uint32_t packed, std::uint32_t quarter) {
  const std::uint32_t step = packed >> (8 * quarter) & 0xffu;
  return step == 0 ? 0.0f : std::exp2((static_cast<float>(step) - static_cast<float>(kLengthZero)) / kLengthSteps);
}

}  // namespace coppice::gpu
