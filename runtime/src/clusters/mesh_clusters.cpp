#include "mesh_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "convert.h"
#include "leaf_entry.h"
#include "page_clusters.h"

namespace coppice::gpu {
namespace {

constexpr std::uint32_t kLargest = 65535;

/// A triangle, and the keys by which it is clustered.
struct Triangle {
  LeafEntry entry;               ///< id: the triangle's number in its mesh; its normal is the sum of its vertices'
  std::uint32_t place = 0;       ///< Morton code of its middle
  std::uint32_t group = 0;       ///< the first id of its leaf, whose triangles have the same size class and place
  std::uint16_t size_class = 0;  ///< triangles of the same class are clustered together
  bool ends_cluster = false;     ///< the last one of its cluster
  float turning_m = 0;           ///< turning_m() of wood
};

std::uint32_t spread_bits(std::uint32_t value) {
  value = (value | value << 16) & 0x030000ffu;
  value = (value | value << 8) & 0x0300f00fu;
  value = (value | value << 4) & 0x030c30c3u;
  return (value | value << 2) & 0x09249249u;
}

std::uint16_t size_class_of(float length_m) {
  constexpr float kClassesPerDoubling = 2.0f;
  if (!(length_m > 1e-6f)) return 0;
  return static_cast<std::uint16_t>(std::clamp(64.0f + std::floor(kClassesPerDoubling * std::log2(length_m)), 0.0f, 127.0f));
}

void measure_box(const WoodSpan& mesh, MeshBlock& block) {
  block.low = block.high = vec3(mesh.vertices[0].position);
  for (const coppice::WoodVertex& vertex : mesh.vertices) {
    block.low = min(block.low, vec3(vertex.position));
    block.high = max(block.high, vec3(vertex.position));
  }
}

/// Sets everything but the light. triangles: the mesh's
void fill_triangles(const WoodSpan& mesh, const LeafBox& box, const MeshSource& source, std::span<Triangle> triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    std::array<uvec3, 4> corners;
    Triangle& triangle = triangles[i];
    vec3 normal(0.0f);
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const coppice::WoodVertex& vertex = mesh.vertices[mesh.indices[3 * i + std::min<std::size_t>(corner, 2)]];
      corners[corner] = quantised(vec3(vertex.position) - box.min, box.step);
      if (corner < 3) normal += vec3(vertex.normal);
    }
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t sum = corners[0][axis] + corners[1][axis] + corners[2][axis] + corners[3][axis];
      triangle.place |= spread_bits(std::min(sum * 256u / (kLargest + 1), 1023u)) << axis;
    }
    LeafEntry& entry = triangle.entry = make_entry(corners, box);
    entry.id = triangle.group = static_cast<std::uint32_t>(i);
    entry.leaf.card = source.appearance.looks.first_material() + mesh.vertices[mesh.indices[3 * i]].material;
    entry.normals.axis = normal;
    entry.covered_m2 = entry.area_m2;
    entry.is_triangle = entry.is_surface = true;
    triangle.size_class = size_class_of(entry.length_m);
    entry.light = source.appearance.light.at((entry.corners[0] + entry.corners[1] + entry.corners[2]) * (1.0f / 3.0f));
  }
}

/// Marks the ends of clusters in a sorted list of triangles. Clusters have about equal size. If a leaf has several triangles, a cluster
/// holds as many whole leaves as fit: a leaf in two clusters would show it, because shadows of other plants are computed per cluster.
void mark_ends(std::span<Triangle> triangles) {
  const auto same_leaf = [&](std::size_t at) { return triangles[at].group == triangles[at - 1].group; };
  const auto end_at = [&](std::size_t end) {
    triangles[end - 1].ends_cluster = true;
    return end;
  };
  bool split_leaves = false;
  for (std::size_t at = 1; at < triangles.size() && !split_leaves; ++at) split_leaves = same_leaf(at);
  if (!split_leaves) {
    const std::size_t count = (triangles.size() + kClusterLeaves - 1) / kClusterLeaves;
    for (std::size_t i = 1; i <= count; ++i) end_at(triangles.size() * i / count);
    return;
  }
  std::size_t start = 0, leaf_start = 0;
  for (std::size_t at = 1; at <= triangles.size(); ++at) {
    if (at < triangles.size() && same_leaf(at)) {
      if (at - start < kClusterLeaves) continue;
      if (leaf_start == start) leaf_start = at;  // larger than a cluster
      start = end_at(leaf_start);
      continue;
    }
    leaf_start = at;
    if (at - start == kClusterLeaves || at == triangles.size()) start = end_at(at);
  }
}

/// The visible size of facets in the light: that of the largest triangle; or, if most of the wood is long triangles whose normals turn
/// along them, a part of their length.
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

/// Sorts by clusters: first triangles that are drawn as leaves (wood without holes, then with), then the others.
void sort_triangles(std::span<Triangle> triangles, std::size_t leaf_count) {
  std::ranges::sort(triangles.first(leaf_count), {}, [](const Triangle& triangle) {
    return std::array{triangle.entry.is_surface ? 0u : 1u, std::uint32_t{triangle.size_class}, triangle.place, triangle.group,
                      triangle.entry.id};
  });
  std::ranges::sort(triangles.subspan(leaf_count), {}, [](const Triangle& triangle) {
    return std::array{triangle.place, triangle.entry.id};
  });
}

/// Numbers of clusters of sorted triangles; those drawn as leaves come first.
struct ClusterCounts {
  std::size_t all = 0, of_leaves = 0;
};

ClusterCounts mark_all_ends(std::span<Triangle> triangles, std::size_t leaf_count) {
  const auto is_surface = [](const Triangle& triangle) { return triangle.entry.is_surface; };
  const auto count = [](std::span<const Triangle> in) {
    return static_cast<std::size_t>(std::ranges::count(in, true, &Triangle::ends_cluster));
  };
  const std::span<Triangle> leaves = triangles.first(leaf_count);
  const auto holed = static_cast<std::size_t>(std::ranges::partition_point(leaves, is_surface) - leaves.begin());
  mark_ends(leaves.first(holed));
  mark_ends(leaves.subspan(holed));
  mark_ends(triangles.subspan(leaf_count));
  return {count(triangles), count(leaves)};
}

/// The places of a block's parts.
struct BlockPlan {
  std::size_t vertices_at = 0, clusters_at = 0, first_cluster_at = 0, leaves_at = 0, splats_at = 0, bytes = 0;
};

BlockPlan plan_block(MeshKind kind, std::uint64_t vertex_count, std::uint64_t index_count, std::uint64_t cluster_count,
                     std::uint64_t leaf_count) {
  BlockPlan plan;
  plan.vertices_at = index_count * sizeof(std::uint32_t);
  plan.clusters_at = plan.vertices_at + vertex_count * (kind == MeshKind::wood ? sizeof(WoodVertex) : sizeof(LeafMeshVertex));
  plan.first_cluster_at = plan.clusters_at + (cluster_count + kBlockClusters - 1) / kBlockClusters * sizeof(uvec2);
  plan.leaves_at = plan.first_cluster_at + cluster_count * sizeof(Cluster);
  plan.splats_at = plan.leaves_at + leaf_count * sizeof(Leaf);
  plan.bytes = plan.splats_at + leaf_count * sizeof(Splat);
  return plan;
}

template <class T>
void write_at(MeshBlock& block, std::size_t at, const T* values, std::size_t count) {
  if (count > 0) std::memcpy(block.bytes.data() + at, values, count * sizeof(T));
}

void write_vertices(MeshKind kind, const WoodSpan& mesh, std::span<const Triangle> triangles, MeshBlock& block) {
  for (std::size_t i = 0; i < triangles.size(); ++i)
    write_at(block, 3 * i * sizeof(std::uint32_t), mesh.indices.data() + std::size_t{3} * triangles[i].entry.id, 3);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const coppice::WoodVertex& vertex = mesh.vertices[i];
    const WoodVertex wood = gpu_wood_vertex(vertex);
    const LeafMeshVertex leaf = gpu_leaf_mesh_vertex(vertex);
    if (kind == MeshKind::wood)
      write_at(block, block.vertices_at + i * sizeof wood, &wood, 1);
    else
      write_at(block, block.vertices_at + i * sizeof leaf, &leaf, 1);
    block.materials.set(vertex.material);
  }
}

/// triangles, leaf_count: sorted; the first leaf_count are drawn as leaves. clusters: mark_all_ends of them
void write_clusters(std::span<const Triangle> triangles, std::size_t leaf_count, const ClusterCounts& clusters, const LeafBox& box,
                    const BlockPlan& plan, MeshBlock& block) {
  std::array<LeafEntry, kClusterLeaves> members;
  std::array<Leaf, kClusterLeaves> leaves;
  std::array<Splat, kClusterLeaves> splats;
  std::size_t start = 0, end = 0;
  for (std::size_t i = 0; i < clusters.all; ++i, start = end) {
    while (!triangles[end++].ends_cluster) continue;
    const std::size_t count = end - start;
    for (std::size_t member = 0; member < count; ++member) members[member] = triangles[start + member].entry;
    const std::span<LeafEntry> own(members.data(), count);
    // Invocations that run together take as long as the slowest.
    std::ranges::sort(own, [](const LeafEntry& a, const LeafEntry& b) { return a.size_m != b.size_m ? a.size_m > b.size_m : a.id < b.id; });
    Cluster cluster = write_cluster(own, {}, box, std::span(leaves).first(count), std::span(splats).first(count));
    cluster.last_death = static_cast<std::uint32_t>(start);
    if (i < clusters.of_leaves) {
      move_address(cluster.leaves, plan.leaves_at + start * sizeof(Leaf));
      move_address(cluster.splats, plan.splats_at + start * sizeof(Splat));
    }
    write_at(block, plan.first_cluster_at + i * sizeof cluster, &cluster, 1);
    if (i >= clusters.of_leaves) continue;
    write_at(block, plan.leaves_at + start * sizeof(Leaf), leaves.data(), count);
    write_at(block, plan.splats_at + start * sizeof(Splat), splats.data(), count);
    const float grain_m = unpack_length(cluster.grains_m, 3);
    block.list.grain_m = std::max(block.list.grain_m, grain_m);
    if (!own[0].is_surface) block.list.holed_m = std::max(block.list.holed_m, grain_m);
  }
  for (std::size_t i = 0; i * kBlockClusters < clusters.all; ++i) {
    uvec2 address{};
    move_address(address, plan.first_cluster_at + i * kBlockClusters * sizeof(Cluster));
    write_at(block, plan.clusters_at + i * sizeof address, &address, 1);
  }
  move_address(block.list.blocks, plan.clusters_at);
  block.list.leaf_count = static_cast<std::uint32_t>(leaf_count);
  block.list.cluster_count = static_cast<std::uint32_t>(clusters.of_leaves);
  block.list.range_count = static_cast<std::uint32_t>(clusters.all);
  block.list.facet_m = facet_of(triangles.first(leaf_count));
}

const coppice::WoodVertex& vertex_of(const WoodSpan& mesh, const Triangle& triangle, std::size_t corner) {
  return mesh.vertices[mesh.indices[std::size_t{3} * triangle.entry.id + corner]];
}

TriangleUvs uvs_of(const WoodSpan& mesh, const Triangle& triangle) {
  return {vertex_of(mesh, triangle, 0).uv, vertex_of(mesh, triangle, 1).uv, vertex_of(mesh, triangle, 2).uv};
}

/// How much a triangle's normals turn along it, times the length: the error of a single light for all of it. Measured in the direction in
/// which it is largest, of the two in which the gradient of the normals is largest and smallest.
float turning_m(const WoodSpan& mesh, const Triangle& triangle) {
  const auto normal = [&](std::size_t corner) { return vec3(vertex_of(mesh, triangle, corner).normal); };
  const std::array<vec3, 4>& corners = triangle.entry.corners;
  const vec3 along = corners[1] - corners[0], other = corners[2] - corners[0];
  const float a = length(along);
  if (!(a > 0.0f)) return 0.0f;
  // The triangle in its plane has the corners (0, 0), (a, 0), (b, c).
  const float b = dot(along, other) / a, c = length(cross(along, other)) / a;
  if (!(c > 1e-6f * a)) return 0.0f;
  const vec3 by_x = (normal(1) - normal(0)) * (1.0f / a), by_y = (normal(2) - normal(0) - by_x * b) * (1.0f / c);
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

/// Subtracts holes. False if nothing is left.
bool subtract_holes(const PlantLooks& looks, const WoodSpan& mesh, Triangle& triangle) {
  const std::uint32_t material = vertex_of(mesh, triangle, 0).material;
  if (!is_masked(looks.materials[material])) return true;
  constexpr std::uint32_t kSide = 8;
  const float coverage = triangle_look(looks, material, uvs_of(mesh, triangle), kSide).coverage;
  triangle.entry.covered_m2 *= coverage;
  triangle.entry.is_surface = coverage == 1.0f;
  return coverage > 0.0f;
}

/// Gives the triangles of a leaf, which share a stalk, the same keys for clustering.
void gather_leaves(const WoodSpan& mesh, std::span<Triangle> triangles) {
  const auto stalk_of = [&](const Triangle& triangle) { return vertex_of(mesh, triangle, 0).stalk; };
  std::ranges::sort(triangles, {}, [&](const Triangle& triangle) { return std::pair(stalk_of(triangle), triangle.entry.id); });
  for (auto first = triangles.begin(); first != triangles.end();) {
    const auto end = std::find_if(first, triangles.end(), [&](const Triangle& other) { return stalk_of(other) != stalk_of(*first); });
    const std::uint16_t size_class = std::ranges::max(std::span(first, end), {}, &Triangle::size_class).size_class;
    for (Triangle& triangle : std::span(first, end)) {
      triangle.group = first->entry.id;
      triangle.place = first->place;
      triangle.size_class = size_class;
    }
    first = end;
  }
}

/// Returns the number of triangles that are drawn as leaves, and sets their light; the others go behind them.
std::size_t light_wood(const WoodSpan& mesh, const MeshSource& source, std::span<Triangle> triangles) {
  const auto shows = [&](Triangle& triangle) {
    LeafEntry& entry = triangle.entry;
    const vec3 face = cross(entry.corners[1] - entry.corners[0], entry.corners[2] - entry.corners[0]);
    entry.face = dot(face, face) > 0.0f ? face : entry.normals.axis;
    const std::uint32_t material = vertex_of(mesh, triangle, 0).material;
    entry.look = wood_color_of(source.appearance.looks, material, uvs_of(mesh, triangle));
    entry.roughness = source.appearance.looks.materials[material].roughness;
    triangle.turning_m = turning_m(mesh, triangle);
    return subtract_holes(source.appearance.looks, mesh, triangle);
  };
  return static_cast<std::size_t>(std::partition(triangles.begin(), triangles.end(), shows) - triangles.begin());
}

std::size_t light_leaves(const WoodSpan& mesh, const MeshSource& source, std::span<Triangle> triangles) {
  const Crown crown = crown_of(source.box);
  float area_m2 = 0, partial_m2 = 0;
  const auto shows = [&](Triangle& triangle) {
    LeafEntry& entry = triangle.entry;
    const coppice::WoodVertex& first = vertex_of(mesh, triangle, 0);
    constexpr std::uint32_t kSide = 2;
    const TriangleLook look = triangle_look(source.appearance.looks, first.material, uvs_of(mesh, triangle), kSide);
    const uvec3 stalk{first.stalk[0], first.stalk[1], first.stalk[2]};
    const coppice_file_material& material = source.appearance.looks.materials[first.material];
    const vec3 face = cross(entry.corners[1] - entry.corners[0], entry.corners[2] - entry.corners[0]);
    entry.face = dot(face, face) > 0.0f ? face : entry.normals.axis;
    if (!(dot(entry.normals.axis, entry.normals.axis) > 1e-12f)) entry.normals.axis = entry.face;
    entry.normals.sided = (material.flags & COPPICE_MATERIAL_SIDED_NORMALS) != 0 ? 1.0f : 0.0f;
    entry.roughness = material.roughness;
    entry.look = pack_albedo(look.albedo * variation(crown, source.box.at(stalk), stalk));
    area_m2 += entry.area_m2;
    if (look.coverage > 0.0f && look.coverage < 1.0f) partial_m2 += entry.area_m2;
    return look.coverage >= 0.5f;
  };
  const std::span<Triangle> shown(triangles.begin(), std::partition(triangles.begin(), triangles.end(), shows));
  // If the triangles do not follow the leaf's outline, they would look worse than its quad.
  constexpr float kMaxPartial = 0.2f;
  if (partial_m2 > kMaxPartial * area_m2) return 0;
  gather_leaves(mesh, shown);
  return shown.size();
}

}  // namespace

Result<MeshBlock> build_mesh(MeshKind kind, const WoodSpan& mesh, const MeshSource& source, const coppice_allocator& allocator) {
  COPPICE_TRY(triangles, HookArray<Triangle>::allocate(allocator, mesh.indices.size() / 3));
  MeshBlock block;
  measure_box(mesh, block);
  const LeafBox box{block.low, (block.high - block.low) * (1.0f / kLargest), kLargest};
  fill_triangles(mesh, box, source, triangles.span());
  std::size_t leaf_count = 0;
  if (source.leaves)
    leaf_count = kind == MeshKind::wood ? light_wood(mesh, source, triangles.span()) : light_leaves(mesh, source, triangles.span());
  sort_triangles(triangles.span(), leaf_count);
  const ClusterCounts clusters = mark_all_ends(triangles.span(), leaf_count);
  const BlockPlan plan = plan_block(kind, mesh.vertices.size(), mesh.indices.size(), clusters.all, leaf_count);
  COPPICE_CHECK(allocate_into(block.bytes, allocator, plan.bytes));
  block.index_count = static_cast<std::uint32_t>(mesh.indices.size());
  block.vertices_at = plan.vertices_at;
  block.clusters_at = plan.clusters_at;
  block.list = empty_list(box);
  write_vertices(kind, mesh, triangles.span(), block);
  write_clusters(triangles.span(), leaf_count, clusters, box, plan, block);
  return block;
}

void MeshBlock::move(std::uint64_t base) {
  const std::size_t first_cluster_at = clusters_at + (list.range_count + kBlockClusters - 1) / kBlockClusters * sizeof(uvec2);
  for (std::size_t at = clusters_at; at < first_cluster_at; at += sizeof(uvec2)) {
    uvec2 address{};
    std::memcpy(&address, bytes.data() + at, sizeof address);
    move_address(address, base);
    std::memcpy(bytes.data() + at, &address, sizeof address);
  }
  move_clusters(bytes.span().subspan(first_cluster_at), list.cluster_count, base);
  move_address(list.blocks, base);
}

std::uint64_t max_mesh_bytes(MeshKind kind, std::uint64_t vertex_count, std::uint64_t triangle_count, bool leaves) {
  // Two neighbouring clusters hold more leaves than one could, or they are the last of a group: with holes, without, or not drawn as
  // leaves.
  constexpr std::uint64_t kMeanLeaves = kClusterLeaves / 2;
  const std::uint64_t cluster_count = triangle_count / kMeanLeaves + 6;
  return plan_block(kind, vertex_count, 3 * triangle_count, cluster_count, leaves ? triangle_count : 0).bytes;
}

std::uint64_t mesh_scratch_bytes(std::uint64_t triangle_count) {
  return triangle_count * sizeof(Triangle);
}

}  // namespace coppice::gpu
