#include "leaf_lists.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "coppice_lod.h"

namespace coppice::gpu {
namespace {

using Point = std::array<float, 3>;

Point operator-(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Point operator*(const Point& a, float factor) {
  return {a[0] * factor, a[1] * factor, a[2] * factor};
}
Point operator+(const Point& a, const Point& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
float dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
float length(const Point& a) {
  return std::sqrt(dot(a, a));
}
Point normalised(const Point& a) {
  return a * (1.0f / length(a));
}

/// crown_of of shading.glsl.
struct Crown {
  Point center{}, radii{};

  explicit Crown(const LeafBox& box) {
    const Point low{box.min.x, box.min.y, box.min.z}, step{box.step.x, box.step.y, box.step.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float half = 0.5f * static_cast<float>(box.largest) * step[axis];
      center[axis] = low[axis] + half;
      radii[axis] = std::max(half, 1e-3f);
    }
  }
  /// -1..1 along each axis
  [[nodiscard]] Point place(const Point& p) const {
    return {(p[0] - center[0]) / radii[0], (p[1] - center[1]) / radii[1], (p[2] - center[2]) / radii[2]};
  }
};

/// A leaf on its way into a list.
struct Entry {
  RasterLeaf leaf{};
  std::array<Point, 4> corners{};  ///< object space, m
  std::uint32_t place = 0;         ///< Morton code of its middle
  std::uint32_t id = 0;            ///< breaks ties
  std::uint32_t group = 0;         ///< the first id of its leaf, whose triangles have the same size class and place
  std::uint32_t size_class = 0;    ///< leaves of one are clustered together
  float size_m = 0;                ///< the longer diagonal
  std::array<Point, 2> axis{};     ///< the longer of the lines that halve it
  std::uint32_t grain_count = 1;   ///< splats along it
  std::uint32_t wood_color = 0;
  float grain_m = 0;
  float area_m2 = 0;
  float turning_m = 0;                       ///< of wood: turning_m()
  bool is_wood = false, is_surface = false;  ///< RasterCluster's
  // Of its splat.
  Point normal{}, face{};
  Point albedo{};
  float covered_m2 = 0;
  CrownSample light;
  float bulk = 0;
};

std::uint32_t spread_bits(std::uint32_t value) {
  value = (value | value << 16) & 0x030000ffu;
  value = (value | value << 8) & 0x0300f00fu;
  value = (value | value << 4) & 0x030c30c3u;
  return (value | value << 2) & 0x09249249u;
}

/// Into how many splats a leaf falls: as many as make them about twice as long as wide.
void set_grains(Entry& entry) {
  const auto& c = entry.corners;
  const std::array<Point, 2> along{(c[0] + c[3]) * 0.5f, (c[1] + c[2]) * 0.5f}, across{(c[0] + c[1]) * 0.5f, (c[2] + c[3]) * 0.5f};
  const float along_m = length(along[1] - along[0]), across_m = length(across[1] - across[0]);
  entry.axis = along_m >= across_m ? along : across;
  const float length_m = std::max(along_m, across_m);
  if (entry.area_m2 > 0.0f) {
    constexpr float kGrainAspect = 2.0f;  // a disc passes for a leaf up to three times as long as wide
    const float aspect = length_m * length_m / entry.area_m2;
    entry.grain_count = static_cast<std::uint32_t>(std::clamp(std::lround(aspect / kGrainAspect), 1L, static_cast<long>(kMaxGrains)));
  }
  entry.grain_m = length_m / static_cast<float>(entry.grain_count);
  constexpr float kClassesPerDoubling = 2.0f;
  if (entry.grain_m > 1e-6f)
    entry.size_class =
        static_cast<std::uint32_t>(std::clamp(64.0f + std::floor(kClassesPerDoubling * std::log2(entry.grain_m)), 0.0f, 127.0f));
}

/// corners: three numbers of at most `largest` each
Entry make_entry(const std::array<std::array<std::uint32_t, 3>, 4>& quantised, std::uint32_t largest, const RasterList& box) {
  Entry entry;
  const Point low{box.box_min.x, box.box_min.y, box.box_min.z}, step{box.box_step.x, box.box_step.y, box.box_step.z};
  for (std::uint32_t i = 0; i < 12; ++i) {
    entry.leaf.corners[i / 2] |= quantised[i / 3][i % 3] << (i % 2 * 16);
    entry.corners[i / 3][i % 3] = low[i % 3] + step[i % 3] * static_cast<float>(quantised[i / 3][i % 3]);
  }
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t sum = quantised[0][axis] + quantised[1][axis] + quantised[2][axis] + quantised[3][axis];
    entry.place |= spread_bits(std::min(sum * 256u / (largest + 1), 1023u)) << axis;
  }
  const Point one = entry.corners[2] - entry.corners[0], other = entry.corners[3] - entry.corners[1];
  entry.size_m = std::max(length(one), length(other));
  entry.area_m2 =
      0.5f * (length(cross(entry.corners[1] - entry.corners[0], one)) + length(cross(one, entry.corners[3] - entry.corners[0])));
  set_grains(entry);
  return entry;
}

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

/// variation of shading.glsl.
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

/// The normal that leaf_light of shading.glsl has for a place of a leaf. face: its own, or zero; becomes unit
Point lit_normal(const Crown& crown, const Point& middle, Point& face, float crown_normals) {
  Point outward = middle - crown.center;
  for (std::size_t axis = 0; axis < 3; ++axis) outward[axis] /= crown.radii[axis] * crown.radii[axis];
  outward = normalised(outward + Point{0.0f, 1e-4f, 0.0f});
  face = dot(face, face) > 1e-20f ? normalised(face) : outward;
  const float side = std::clamp(4.0f * dot(face, outward), -1.0f, 1.0f), turned = std::max(crown_normals, 1e-3f);
  return normalised(face * (side * (1.0f - turned)) + outward * turned);
}

/// How it is lit, and what its card says of it.
void shade_leaf(Entry& entry, const Crown& crown, const RasterCard& look, const std::array<std::uint32_t, 3>& stalk) {
  const Point middle = (entry.corners[0] + entry.corners[1] + entry.corners[2] + entry.corners[3]) * 0.25f;
  entry.face = cross(entry.corners[2] - entry.corners[0], entry.corners[3] - entry.corners[1]);
  entry.normal = lit_normal(crown, middle, entry.face, look.crown_normals);
  const Point varied = variation(crown.place(entry.corners[0]), stalk);
  entry.albedo = {look.albedo.x * varied[0], look.albedo.y * varied[1], look.albedo.z * varied[2]};
  entry.covered_m2 = entry.area_m2 * look.coverage;
}

/// crown_light_at, leaf_bulk and leaf_sky of shading.glsl.
void set_light(Entry& entry, const LeafSource& source, const Crown& crown, std::uint32_t leaf_count) {
  entry.light = source.light.at((entry.corners[0] + entry.corners[1] + entry.corners[2] + entry.corners[3]) * 0.25f);
  const float radius_m = (crown.radii[0] + crown.radii[1] + crown.radii[2]) / 3.0f;
  const float merged = 1.0f - static_cast<float>(leaf_count) / static_cast<float>(source.plant_leaf_count);
  const float share = std::min(0.5f * entry.size_m / radius_m, 1.0f);
  entry.bulk = merged * share * share;
  entry.light.sky += (1.0f - entry.light.sky) * kBulkSky * entry.bulk;
}

std::uint32_t packed_normals(const Entry& entry) {
  return octahedral(entry.normal) | octahedral(entry.face) << 16;
}

/// RasterSplat::look.
std::uint32_t packed_look(const Entry& entry) {
  const auto sky = static_cast<std::uint32_t>(std::lround(255.0f * std::clamp(entry.light.sky, 0.0f, 1.0f)));
  return (entry.is_wood ? entry.wood_color : packed_albedo(entry.albedo)) | sky << 24;
}

/// grain: < entry.grain_count
RasterSplat splat_of(const Entry& entry, std::uint32_t grain, const RasterList& list) {
  const Point low{list.box_min.x, list.box_min.y, list.box_min.z}, step{list.splat_step.x, list.splat_step.y, list.splat_step.z};
  const float share = (static_cast<float>(grain) + 0.5f) / static_cast<float>(entry.grain_count);
  const Point middle = entry.axis[0] + (entry.axis[1] - entry.axis[0]) * share;
  const float side_m = std::sqrt(entry.covered_m2 / static_cast<float>(entry.grain_count));
  std::array<std::uint32_t, 4> words{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (step[axis] > 0.0f)
      words[axis] = static_cast<std::uint32_t>(std::clamp(std::lround((middle[axis] - low[axis]) / step[axis]), 0L, 65535L));
  if (list.splat_size_m > 0.0f)
    words[3] = static_cast<std::uint32_t>(std::clamp(std::lround(65535.0f * side_m / list.splat_size_m), 0L, 65535L));
  return {
      .xy = words[0] | words[1] << 16, .z_size = words[2] | words[3] << 16, .normals = packed_normals(entry), .look = packed_look(entry)};
}

RasterCluster bound(std::span<const Entry* const> entries, std::uint32_t first_leaf) {
  Point low = entries[0]->corners[0], high = low;
  for (const Entry* entry : entries)
    for (const Point& corner : entry->corners)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], corner[axis]);
        high[axis] = std::max(high[axis], corner[axis]);
      }
  const Point center{0.5f * (low[0] + high[0]), 0.5f * (low[1] + high[1]), 0.5f * (low[2] + high[2])};
  RasterCluster cluster{
      .center = {center[0], center[1], center[2]}, .first_leaf = first_leaf, .leaf_count = static_cast<std::uint32_t>(entries.size())};
  CrownSample light;
  float area_m2 = 0;
  for (const Entry* entry : entries) {
    for (const Point& corner : entry->corners) cluster.radius_m = std::max(cluster.radius_m, length(corner - center));
    cluster.grain_m = std::max(cluster.grain_m, entry->grain_m);
    cluster.splat_count += entry->grain_count;
    const float share = 1.0f / static_cast<float>(entries.size());
    cluster.bulk += share * entry->bulk;
    area_m2 += share * entry->area_m2;
    light.depth += share * entry->light.depth;
    for (std::size_t axis = 0; axis < 3; ++axis) light.slope[axis] += share * entry->light.slope[axis];
  }
  cluster.crown = pack_crown(light);
  cluster.leaf_size_m = std::sqrt(area_m2);
  return cluster;
}

/// Appends a cluster. Its leaves are sorted by size: invocations side by side take as long as the slowest.
void add_cluster(BuiltList& list, std::span<const Entry*> members) {
  std::ranges::sort(members, [](const Entry* a, const Entry* b) { return a->size_m != b->size_m ? a->size_m > b->size_m : a->id < b->id; });
  RasterCluster cluster = bound(members, static_cast<std::uint32_t>(list.leaves.size()));
  cluster.first_splat = static_cast<std::uint32_t>(list.splats.size());
  cluster.is_surface = members[0]->is_surface ? 1 : 0;
  list.header.grain_m = std::max(list.header.grain_m, cluster.grain_m);
  if (members[0]->is_wood && !members[0]->is_surface) list.header.holed_m = std::max(list.header.holed_m, cluster.grain_m);
  list.clusters.push_back(cluster);
  for (const Entry* entry : members) {
    list.leaves.push_back(entry->leaf);
    list.leaves.back().normals = packed_normals(*entry);
    list.leaves.back().look = packed_look(*entry);
    list.leaves.back().crown = pack_crown(entry->light);
    for (std::uint32_t grain = 0; grain < entry->grain_count; ++grain) list.splats.push_back(splat_of(*entry, grain, list.header));
  }
}

/// The order of leaves that clusters are cut from: neighbours of a size, of wood also with or without holes, side by side.
struct Place {
  std::array<std::uint32_t, 4> key{};  ///< of wood whether it has holes, size class, place, group
  const Entry* entry = nullptr;
};

std::vector<Place> places_of(std::span<const Entry> entries) {
  std::vector<Place> places;
  places.reserve(entries.size());
  for (const Entry& entry : entries)
    places.push_back({{entry.is_wood && !entry.is_surface ? 1u : 0u, entry.size_class, entry.place, entry.group}, &entry});
  std::ranges::stable_sort(places, {}, &Place::key);  // a leaf's by id, as they came
  return places;
}

/// Where clusters end: of about equal size; where leaves are several triangles, of as many whole leaves as there is room for. What of a
/// leaf were in two clusters would show it, as shadows of other plants are a cluster's.
std::vector<std::size_t> cluster_ends(std::span<const Place> places) {
  const auto same_leaf = [&](std::size_t at) { return places[at].entry->group == places[at - 1].entry->group; };
  std::vector<std::size_t> ends;
  bool split_leaves = false;
  for (std::size_t at = 1; at < places.size() && !split_leaves; ++at) split_leaves = same_leaf(at);
  if (!split_leaves) {
    const std::size_t count = (places.size() + kClusterLeaves - 1) / kClusterLeaves;
    for (std::size_t i = 1; i <= count; ++i) ends.push_back(places.size() * i / count);
    return ends;
  }
  std::size_t start = 0, leaf_start = 0;
  for (std::size_t at = 1; at <= places.size(); ++at) {
    if (at < places.size() && same_leaf(at)) {
      if (at - start < kClusterLeaves) continue;
      if (leaf_start == start) leaf_start = at;  // larger than a cluster
      ends.push_back(start = leaf_start);
      continue;
    }
    leaf_start = at;
    if (at - start == kClusterLeaves || at == places.size()) ends.push_back(start = at);
  }
  return ends;
}

/// Cuts the entries into clusters; those of wood have holes or have none.
BuiltList finish(std::span<const Entry> entries, const RasterList& box, float largest) {
  BuiltList list{.header = box};
  for (auto [step, splat_step] :
       {std::pair{box.box_step.x, &list.header.splat_step.x}, std::pair{box.box_step.y, &list.header.splat_step.y},
        std::pair{box.box_step.z, &list.header.splat_step.z}})
    *splat_step = step * largest / 65535.0f;
  double area_m2 = 0, turning_m3 = 0;
  for (const Entry& entry : entries) {
    list.header.splat_size_m = std::max(list.header.splat_size_m, std::sqrt(entry.covered_m2));
    area_m2 += static_cast<double>(entry.area_m2);
    turning_m3 += static_cast<double>(entry.area_m2) * static_cast<double>(entry.turning_m);
    list.header.facet_m = std::max(list.header.facet_m, std::sqrt(entry.area_m2));
  }
  // Long triangles whose light turns along them look like facets of a part of their length, where most of the wood is such.
  constexpr double kFacetShare = 0.4;
  if (area_m2 > 0.0) list.header.facet_m = std::max(list.header.facet_m, static_cast<float>(kFacetShare * turning_m3 / area_m2));
  const std::vector<Place> places = places_of(entries);
  list.leaves.reserve(entries.size());
  for (auto first = places.begin(); first != places.end();) {
    const auto end = std::find_if(first, places.end(), [&](const Place& place) { return place.key[0] != first->key[0]; });
    const std::span<const Place> run(first, end);
    std::size_t start = 0;
    for (const std::size_t cluster_end : cluster_ends(run)) {
      std::vector<const Entry*> members;
      for (const Place& place : run.subspan(start, cluster_end - start)) members.push_back(place.entry);
      add_cluster(list, members);
      start = cluster_end;
    }
    first = end;
  }
  list.header.leaf_count = static_cast<std::uint32_t>(list.leaves.size());
  list.header.cluster_count = static_cast<std::uint32_t>(list.clusters.size());
  if (!entries.empty()) list.header.leaf_size_m = static_cast<float>(std::sqrt(area_m2 / static_cast<double>(entries.size())));
  return list;
}

}  // namespace

BuiltList build_leaf_list(const LeafSource& source, std::uint32_t leaf_count) {
  const RasterList box{.box_min = source.box.min, .box_step = source.box.step};
  const Crown crown(source.box);
  std::vector<Entry> entries;
  entries.reserve(leaf_count);
  for (std::uint32_t id = 0; id < 2 * leaf_count - 1; ++id) {
    const PageNode& node = source.node(id);
    if (!lod::coppice_node_alive(id, node.split, leaf_count)) continue;
    std::array<std::array<std::uint32_t, 3>, 4> quantised{};
    for (std::size_t corner = 0; corner < 4; ++corner) std::ranges::copy(node.corners[corner], quantised[corner].begin());
    Entry entry = make_entry(quantised, source.box.largest, box);
    entry.id = entry.group = id;
    entry.leaf.card = node.card;
    shade_leaf(entry, crown, source.looks[node.card], quantised[0]);
    set_light(entry, source, crown, leaf_count);
    entries.push_back(entry);
  }
  return finish(entries, box, static_cast<float>(source.box.largest));
}

namespace {

/// A mesh's triangles, without what lights them; their place in the box is quantised to 1/kLargest of it.
struct Triangles {
  static constexpr std::uint32_t kLargest = 65535;
  RasterList box;
  std::vector<Entry> entries;  ///< normal: the sum of its vertices'
};

Triangles triangles_of(const WoodMesh& mesh, std::uint32_t first_material, const CrownLight& light) {
  Point low = mesh.vertices[mesh.indices[0]].position, high = low;
  for (const std::uint32_t index : mesh.indices)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], mesh.vertices[index].position[axis]);
      high[axis] = std::max(high[axis], mesh.vertices[index].position[axis]);
    }
  constexpr std::uint32_t kLargest = Triangles::kLargest;
  const Point step{(high[0] - low[0]) / kLargest, (high[1] - low[1]) / kLargest, (high[2] - low[2]) / kLargest};
  Triangles triangles{.box = {.box_min = {low[0], low[1], low[2]}, .box_step = {step[0], step[1], step[2]}}, .entries = {}};
  triangles.entries.reserve(mesh.indices.size() / 3);
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    std::array<std::array<std::uint32_t, 3>, 4> quantised{};
    Point normal{};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const coppice::WoodVertex& vertex = mesh.vertices[mesh.indices[i + std::min<std::size_t>(corner, 2)]];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (step[axis] > 0.0f)
          quantised[corner][axis] = static_cast<std::uint32_t>(
              std::clamp(std::lround((vertex.position[axis] - low[axis]) / step[axis]), 0L, static_cast<long>(kLargest)));
        if (corner < 3) normal[axis] += vertex.normal[axis];
      }
    }
    Entry entry = make_entry(quantised, kLargest, triangles.box);
    entry.id = entry.group = static_cast<std::uint32_t>(i / 3);
    entry.leaf.card = first_material + mesh.vertices[mesh.indices[i]].material;
    entry.normal = normal;
    entry.covered_m2 = entry.area_m2;
    entry.is_surface = true;
    // Discs along a slender triangle lie on those of the one beside it and cover half of what both do: they are for a point of a triangle.
    entry.grain_m *= static_cast<float>(entry.grain_count);
    entry.light = light.at((entry.corners[0] + entry.corners[1] + entry.corners[2]) * (1.0f / 3.0f));
    triangles.entries.push_back(entry);
  }
  return triangles;
}

const coppice::WoodVertex& vertex_of(const WoodMesh& mesh, const Entry& triangle, std::size_t corner) {
  return mesh.vertices[mesh.indices[std::size_t{3} * triangle.id + corner]];
}

TriangleUvs uvs_of(const WoodMesh& mesh, const Entry& triangle) {
  return {vertex_of(mesh, triangle, 0).uv, vertex_of(mesh, triangle, 1).uv, vertex_of(mesh, triangle, 2).uv};
}

/// How much a triangle's normals turn along it, times how long it is there: what one light for all of it gets wrong. In the direction in
/// which that is most, of the two in which the normals' gradient is largest and smallest.
float turning_m(const WoodMesh& mesh, const Entry& triangle) {
  const auto normal = [&](std::size_t corner) {
    const std::array<float, 3>& n = vertex_of(mesh, triangle, corner).normal;
    return Point{n[0], n[1], n[2]};
  };
  const Point along = triangle.corners[1] - triangle.corners[0], other = triangle.corners[2] - triangle.corners[0];
  const float a = length(along);
  if (!(a > 0.0f)) return 0.0f;
  // The triangle in its plane: (0, 0), (a, 0), (b, c).
  const float b = dot(along, other) / a, c = length(cross(along, other)) / a;
  if (!(c > 1e-6f * a)) return 0.0f;
  const Point by_x = (normal(1) - normal(0)) * (1.0f / a), by_y = (normal(2) - normal(0) - by_x * b) * (1.0f / c);
  const float xx = dot(by_x, by_x), xy = dot(by_x, by_y), yy = dot(by_y, by_y);
  const float angle = 0.5f * std::atan2(2.0f * xy, xx - yy), spread = std::hypot(0.5f * (xx - yy), xy);
  float turning = 0;
  for (const auto& [x, y, squared] : {std::array{std::cos(angle), std::sin(angle), 0.5f * (xx + yy) + spread},
                                      std::array{-std::sin(angle), std::cos(angle), 0.5f * (xx + yy) - spread}}) {
    const auto [low, high] = std::minmax({0.0f, a * x, b * x + c * y});
    turning = std::max(turning, std::sqrt(std::max(squared, 0.0f)) * (high - low) * (high - low));
  }
  return turning;
}

/// Takes away what holes leave open. False where they leave nothing.
bool cover_wood(const PlantLooks& looks, const WoodMesh& mesh, Entry& triangle) {
  const std::uint32_t material = vertex_of(mesh, triangle, 0).material;
  if (!is_masked(looks.materials[material])) return true;
  constexpr std::uint32_t kSide = 8;
  const float coverage = triangle_look(looks, material, uvs_of(mesh, triangle), kSide).coverage;
  triangle.covered_m2 *= coverage;
  triangle.is_surface = coverage == 1.0f;
  return coverage > 0.0f;
}

}  // namespace

BuiltList build_wood_list(const WoodMesh& mesh, const WoodSource& source) {
  if (mesh.indices.empty()) return {};
  Triangles triangles = triangles_of(mesh, source.looks.first_material(), source.light);
  std::erase_if(triangles.entries, [&](Entry& entry) {
    const Point face = cross(entry.corners[1] - entry.corners[0], entry.corners[2] - entry.corners[0]);
    entry.face = dot(face, face) > 0.0f ? face : entry.normal;
    entry.is_wood = true;
    entry.turning_m = turning_m(mesh, entry);
    entry.wood_color = wood_color_of(source.looks, vertex_of(mesh, entry, 0).material, uvs_of(mesh, entry));
    return !cover_wood(source.looks, mesh, entry);
  });
  return finish(triangles.entries, triangles.box, Triangles::kLargest);
}

namespace {

/// Makes the triangles of a leaf, which share a stalk, alike in what clusters are made by.
void gather_leaves(const WoodMesh& mesh, std::span<Entry> triangles) {
  const auto stalk_of = [&](const Entry& triangle) { return vertex_of(mesh, triangle, 0).stalk; };
  std::map<QuantisedPoint, Entry*> leaves;  // their first triangles
  for (Entry& triangle : triangles) {
    Entry& first = *leaves.try_emplace(stalk_of(triangle), &triangle).first->second;
    triangle.group = first.id;
    triangle.place = first.place;
    first.size_class = std::max(first.size_class, triangle.size_class);
  }
  for (Entry& triangle : triangles) triangle.size_class = leaves.at(stalk_of(triangle))->size_class;
}

}  // namespace

BuiltList build_leaf_mesh_list(const WoodMesh& mesh, const LeafMeshSource& source) {
  if (mesh.indices.empty()) return {};
  const auto first_material = source.looks.first_material();
  Triangles triangles = triangles_of(mesh, first_material, source.light);
  const Crown crown(source.box);
  float area_m2 = 0, partial_m2 = 0;
  const Point low{source.box.min.x, source.box.min.y, source.box.min.z}, step{source.box.step.x, source.box.step.y, source.box.step.z};
  std::erase_if(triangles.entries, [&](Entry& entry) {
    const coppice::WoodVertex& first = vertex_of(mesh, entry, 0);
    constexpr std::uint32_t kSide = 2;
    const TriangleLook look = triangle_look(source.looks, first.material, uvs_of(mesh, entry), kSide);
    const std::array<std::uint16_t, 3>& stalk = first.stalk;
    Point place{};
    for (std::size_t axis = 0; axis < 3; ++axis) place[axis] = low[axis] + step[axis] * static_cast<float>(stalk[axis]);
    const Point middle = (entry.corners[0] + entry.corners[1] + entry.corners[2]) * (1.0f / 3.0f);
    entry.face = entry.normal;
    entry.normal = lit_normal(crown, middle, entry.face, source.looks.looks[entry.leaf.card].crown_normals);
    const Point varied = variation(crown.place(place), {stalk[0], stalk[1], stalk[2]});
    entry.albedo = {look.albedo[0] * varied[0], look.albedo[1] * varied[1], look.albedo[2] * varied[2]};
    area_m2 += entry.area_m2;
    if (look.coverage > 0.0f && look.coverage < 1.0f) partial_m2 += entry.area_m2;
    return look.coverage < 0.5f;
  });
  // Triangles that do not follow the leaf's outline would be worse than its quad.
  constexpr float kMostPartial = 0.2f;
  if (partial_m2 > kMostPartial * area_m2) return {};
  gather_leaves(mesh, triangles.entries);
  return finish(triangles.entries, triangles.box, Triangles::kLargest);
}

}  // namespace coppice::gpu
