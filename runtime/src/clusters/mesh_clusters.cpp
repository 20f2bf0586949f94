#include "mesh_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <span>

#include "leaf_entry.h"
#include "page_clusters.h"

namespace coppice::gpu {
namespace {

constexpr std::uint32_t kLargest = 65535;

/// A triangle, and what clusters are made by.
struct Triangle {
  LeafEntry entry;               ///< id: of the triangle in its mesh; normal: the sum of its vertices'
  std::uint32_t place = 0;       ///< Morton code of its middle
  std::uint32_t group = 0;       ///< the first id of its leaf, whose triangles have the same size class and place
  std::uint32_t size_class = 0;  ///< triangles of one are clustered together
  float turning_m = 0;           ///< turning_m() of wood
};

std::uint32_t spread_bits(std::uint32_t value) {
  value = (value | value << 16) & 0x030000ffu;
  value = (value | value << 8) & 0x0300f00fu;
  value = (value | value << 4) & 0x030c30c3u;
  return (value | value << 2) & 0x09249249u;
}

std::uint32_t size_class_of(float length_m) {
  constexpr float kClassesPerDoubling = 2.0f;
  if (!(length_m > 1e-6f)) return 0;
  return static_cast<std::uint32_t>(std::clamp(64.0f + std::floor(kClassesPerDoubling * std::log2(length_m)), 0.0f, 127.0f));
}

LeafBox box_of(const WoodMesh& mesh) {
  Point low = mesh.vertices[mesh.indices[0]].position, high = low;
  for (const std::uint32_t index : mesh.indices)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], mesh.vertices[index].position[axis]);
      high[axis] = std::max(high[axis], mesh.vertices[index].position[axis]);
    }
  const Point step = (high - low) * (1.0f / kLargest);
  return {{low[0], low[1], low[2]}, {step[0], step[1], step[2]}, kLargest};
}

/// Without what lights them.
std::vector<Triangle> triangles_of(const WoodMesh& mesh, const ListFrame& frame, std::uint32_t first_material, const CrownLight& light) {
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.indices.size() / 3);
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    std::array<std::array<std::uint32_t, 3>, 4> quantised{};
    Triangle triangle;
    Point normal{};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const coppice::WoodVertex& vertex = mesh.vertices[mesh.indices[i + std::min<std::size_t>(corner, 2)]];
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (frame.step[axis] > 0.0f)
          quantised[corner][axis] = static_cast<std::uint32_t>(
              std::clamp(std::lround((vertex.position[axis] - frame.low[axis]) / frame.step[axis]), 0L, static_cast<long>(kLargest)));
      if (corner < 3) normal = normal + vertex.normal;
    }
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t sum = quantised[0][axis] + quantised[1][axis] + quantised[2][axis] + quantised[3][axis];
      triangle.place |= spread_bits(std::min(sum * 256u / (kLargest + 1), 1023u)) << axis;
    }
    LeafEntry& entry = triangle.entry = make_entry(quantised, frame);
    entry.id = triangle.group = static_cast<std::uint32_t>(i / 3);
    entry.leaf.card = first_material + mesh.vertices[mesh.indices[i]].material;
    entry.normal = normal;
    entry.covered_m2 = entry.area_m2;
    entry.is_triangle = entry.is_surface = true;
    triangle.size_class = size_class_of(entry.length_m);
    entry.light = light.at((entry.corners[0] + entry.corners[1] + entry.corners[2]) * (1.0f / 3.0f));
    triangles.push_back(triangle);
  }
  return triangles;
}

/// Where clusters end: of about equal size; where leaves are several triangles, of as many whole leaves as there is room for. What of a
/// leaf were in two clusters would show it, as shadows of other plants are a cluster's.
std::vector<std::size_t> cluster_ends(std::span<const Triangle> triangles) {
  const auto same_leaf = [&](std::size_t at) { return triangles[at].group == triangles[at - 1].group; };
  std::vector<std::size_t> ends;
  bool split_leaves = false;
  for (std::size_t at = 1; at < triangles.size() && !split_leaves; ++at) split_leaves = same_leaf(at);
  if (!split_leaves) {
    const std::size_t count = (triangles.size() + kClusterLeaves - 1) / kClusterLeaves;
    for (std::size_t i = 1; i <= count; ++i) ends.push_back(triangles.size() * i / count);
    return ends;
  }
  std::size_t start = 0, leaf_start = 0;
  for (std::size_t at = 1; at <= triangles.size(); ++at) {
    if (at < triangles.size() && same_leaf(at)) {
      if (at - start < kClusterLeaves) continue;
      if (leaf_start == start) leaf_start = at;  // larger than a cluster
      ends.push_back(start = leaf_start);
      continue;
    }
    leaf_start = at;
    if (at - start == kClusterLeaves || at == triangles.size()) ends.push_back(start = at);
  }
  return ends;
}

/// How large a facet its light shows: the largest triangle, or, where most of the wood is long triangles whose light turns along them, a
/// part of their length.
float facet_of(std::span<const Triangle> triangles) {
  constexpr double kFacetShare = 0.4;
  float facet_m = 0;
  double area_m2 = 0, turning_m3 = 0;
  for (const Triangle& triangle : triangles) {
    facet_m = std::max(facet_m, std::sqrt(triangle.entry.area_m2));
    area_m2 += static_cast<double>(triangle.entry.area_m2);
    turning_m3 += static_cast<double>(triangle.entry.area_m2) * static_cast<double>(triangle.turning_m);
  }
  return area_m2 > 0.0 ? std::max(facet_m, static_cast<float>(kFacetShare * turning_m3 / area_m2)) : facet_m;
}

template <class T>
void append(std::vector<std::uint8_t>& bytes, std::span<const T> values) {
  const std::size_t at = bytes.size();
  bytes.resize(at + values.size_bytes());
  if (!values.empty()) std::memcpy(bytes.data() + at, values.data(), values.size_bytes());
}

/// The clusters in their order; those of wood have holes or have none.
MeshClusters finish(std::vector<Triangle>& triangles, const ListFrame& frame) {
  MeshClusters built{.list = frame.empty_list(), .bytes = {}};
  if (triangles.empty()) return built;
  const auto key = [](const Triangle& triangle) {
    return std::array{triangle.entry.is_surface ? 0u : 1u, triangle.size_class, triangle.place, triangle.group};
  };
  std::ranges::stable_sort(triangles, {}, key);  // a leaf's by id, as they came
  std::vector<Cluster> clusters;
  std::vector<Leaf> leaves(triangles.size());
  std::vector<Splat> splats(triangles.size());
  std::size_t written = 0;
  for (auto first = triangles.begin(); first != triangles.end();) {
    const auto end = std::find_if(first, triangles.end(), [&](const Triangle& other) { return key(other)[0] != key(*first)[0]; });
    const std::span<const Triangle> run(first, end);
    std::size_t start = 0;
    for (const std::size_t cluster_end : cluster_ends(run)) {
      std::vector<LeafEntry> members;
      for (const Triangle& triangle : run.subspan(start, cluster_end - start)) members.push_back(triangle.entry);
      // Invocations side by side take as long as the slowest.
      std::ranges::sort(members,
                        [](const LeafEntry& a, const LeafEntry& b) { return a.size_m != b.size_m ? a.size_m > b.size_m : a.id < b.id; });
      Cluster cluster = write_cluster(members, {}, frame, std::span(leaves).subspan(written), std::span(splats).subspan(written));
      cluster.leaves.x = static_cast<std::uint32_t>(written * sizeof(Leaf));
      cluster.splats.x = static_cast<std::uint32_t>(written * sizeof(Splat));
      clusters.push_back(cluster);
      const float grain_m = unpack_length(cluster.grains_m, 3);
      built.list.grain_m = std::max(built.list.grain_m, grain_m);
      if (!members[0].is_surface) built.list.holed_m = std::max(built.list.holed_m, grain_m);
      written += members.size();
      start = cluster_end;
    }
    first = end;
  }
  built.list.leaf_count = static_cast<std::uint32_t>(written);
  built.list.cluster_count = static_cast<std::uint32_t>(clusters.size());
  built.list.facet_m = facet_of(triangles);
  const std::size_t block_count = (clusters.size() + kBlockClusters - 1) / kBlockClusters, clusters_at = block_count * sizeof(uvec2);
  const std::size_t leaves_at = clusters_at + clusters.size() * sizeof(Cluster), splats_at = leaves_at + written * sizeof(Leaf);
  std::vector<uvec2> blocks(block_count);
  for (std::size_t i = 0; i < block_count; ++i) move_address(blocks[i], clusters_at + i * kBlockClusters * sizeof(Cluster));
  for (Cluster& cluster : clusters) {
    move_address(cluster.leaves, leaves_at);
    move_address(cluster.splats, splats_at);
  }
  append<uvec2>(built.bytes, blocks);
  append<Cluster>(built.bytes, clusters);
  append<Leaf>(built.bytes, leaves);
  append<Splat>(built.bytes, splats);
  return built;
}

const coppice::WoodVertex& vertex_of(const WoodMesh& mesh, const Triangle& triangle, std::size_t corner) {
  return mesh.vertices[mesh.indices[std::size_t{3} * triangle.entry.id + corner]];
}

TriangleUvs uvs_of(const WoodMesh& mesh, const Triangle& triangle) {
  return {vertex_of(mesh, triangle, 0).uv, vertex_of(mesh, triangle, 1).uv, vertex_of(mesh, triangle, 2).uv};
}

/// How much a triangle's normals turn along it, times how long it is there: what one light for all of it gets wrong. In the direction in
/// which that is most, of the two in which the normals' gradient is largest and smallest.
float turning_m(const WoodMesh& mesh, const Triangle& triangle) {
  const auto normal = [&](std::size_t corner) { return vertex_of(mesh, triangle, corner).normal; };
  const std::array<Point, 4>& corners = triangle.entry.corners;
  const Point along = corners[1] - corners[0], other = corners[2] - corners[0];
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
bool cover_wood(const PlantLooks& looks, const WoodMesh& mesh, Triangle& triangle) {
  const std::uint32_t material = vertex_of(mesh, triangle, 0).material;
  if (!is_masked(looks.materials[material])) return true;
  constexpr std::uint32_t kSide = 8;
  const float coverage = triangle_look(looks, material, uvs_of(mesh, triangle), kSide).coverage;
  triangle.entry.covered_m2 *= coverage;
  triangle.entry.is_surface = coverage == 1.0f;
  return coverage > 0.0f;
}

/// Makes the triangles of a leaf, which share a stalk, alike in what clusters are made by.
void gather_leaves(const WoodMesh& mesh, std::span<Triangle> triangles) {
  const auto stalk_of = [&](const Triangle& triangle) { return vertex_of(mesh, triangle, 0).stalk; };
  std::map<QuantisedPoint, Triangle*> leaves;  // their first triangles
  for (Triangle& triangle : triangles) {
    Triangle& first = *leaves.try_emplace(stalk_of(triangle), &triangle).first->second;
    triangle.group = first.entry.id;
    triangle.place = first.place;
    first.size_class = std::max(first.size_class, triangle.size_class);
  }
  for (Triangle& triangle : triangles) triangle.size_class = leaves.at(stalk_of(triangle))->size_class;
}

}  // namespace

MeshClusters build_wood(const WoodMesh& mesh, const WoodSource& source) {
  if (mesh.indices.empty()) return {};
  const ListFrame frame(box_of(mesh));
  std::vector<Triangle> triangles = triangles_of(mesh, frame, source.looks.first_material(), source.light);
  std::erase_if(triangles, [&](Triangle& triangle) {
    LeafEntry& entry = triangle.entry;
    const Point face = cross(entry.corners[1] - entry.corners[0], entry.corners[2] - entry.corners[0]);
    entry.face = dot(face, face) > 0.0f ? face : entry.normal;
    entry.look = wood_color_of(source.looks, vertex_of(mesh, triangle, 0).material, uvs_of(mesh, triangle));
    triangle.turning_m = turning_m(mesh, triangle);
    return !cover_wood(source.looks, mesh, triangle);
  });
  return finish(triangles, frame);
}

MeshClusters build_leaf_mesh(const WoodMesh& mesh, const LeafMeshSource& source) {
  if (mesh.indices.empty()) return {};
  const ListFrame frame(box_of(mesh)), leaf_frame(source.box);
  std::vector<Triangle> triangles = triangles_of(mesh, frame, source.looks.first_material(), source.light);
  const Crown crown(source.box);
  float area_m2 = 0, partial_m2 = 0;
  std::erase_if(triangles, [&](Triangle& triangle) {
    LeafEntry& entry = triangle.entry;
    const coppice::WoodVertex& first = vertex_of(mesh, triangle, 0);
    constexpr std::uint32_t kSide = 2;
    const TriangleLook look = triangle_look(source.looks, first.material, uvs_of(mesh, triangle), kSide);
    const std::array<std::uint32_t, 3> stalk{first.stalk[0], first.stalk[1], first.stalk[2]};
    const Point middle = (entry.corners[0] + entry.corners[1] + entry.corners[2]) * (1.0f / 3.0f);
    entry.face = entry.normal;
    entry.normal = lit_normal(crown, middle, entry.face, source.looks.looks[entry.leaf.card].crown_normals);
    const Point varied = variation(crown.place(leaf_frame.at(stalk)), stalk);
    entry.look = packed_albedo({look.albedo[0] * varied[0], look.albedo[1] * varied[1], look.albedo[2] * varied[2]});
    area_m2 += entry.area_m2;
    if (look.coverage > 0.0f && look.coverage < 1.0f) partial_m2 += entry.area_m2;
    return look.coverage < 0.5f;
  });
  // Triangles that do not follow the leaf's outline would be worse than its quad.
  constexpr float kMostPartial = 0.2f;
  if (partial_m2 > kMostPartial * area_m2) return {};
  gather_leaves(mesh, triangles);
  return finish(triangles, frame);
}

void MeshClusters::move(std::uint64_t base) {
  const std::size_t clusters_at = (list.cluster_count + kBlockClusters - 1) / kBlockClusters * sizeof(uvec2);
  for (std::size_t at = 0; at < clusters_at; at += sizeof(uvec2)) {
    uvec2 address{};
    std::memcpy(&address, bytes.data() + at, sizeof address);
    move_address(address, base);
    std::memcpy(bytes.data() + at, &address, sizeof address);
  }
  move_clusters(std::span(bytes).subspan(clusters_at), list.cluster_count, base);
  move_address(list.blocks, base);
}

std::uint64_t most_mesh_cluster_bytes(std::uint64_t triangle_count) {
  constexpr std::uint64_t kLeastClusterLeaves = 16;
  return triangle_count * (sizeof(Leaf) + sizeof(Splat)) + (triangle_count / kLeastClusterLeaves + 16) * (sizeof(Cluster) + sizeof(uvec2));
}

}  // namespace coppice::gpu
