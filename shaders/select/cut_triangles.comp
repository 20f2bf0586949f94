#version 460
#extension GL_GOOGLE_include_directive : require

// Writes the positions of a plant's triangles, three corners each, for an engine's acceleration structures: a cut's leaves, two triangles
// each in the order of its clusters, or all triangles of a mesh.
// reads     the plant's lists, clusters and leaves, or a mesh's indices and vertices, by address
// writes    vec3[] at `positions`
// dispatch  a group for each cluster of the list that may show leaves, or for kClusterLeaves indices of a mesh; recorded by
//           coppice::gpu::record_triangles

#include "bindings.glsl"
#include "clusters.glsl"

layout(local_size_x = kClusterLeaves) in;
layout(push_constant, scalar) uniform Push { TrianglePush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PositionArray { vec3 at[]; };

shared uint before;

ShownLeaves shown_of(ClusterList list, uint cluster) {
  return push.paged != 0 ? shown_of_page(cluster_at(list, cluster), cluster, push.count) : all_shown(cluster_at(list, cluster));
}

bool is_shown(Cluster cluster, ShownLeaves shown, uint index, uint leaf) {
  return !shown.partly_born || is_born(LeafArray(cluster.leaves).at[leaf].life, born_splits(push.count, index));
}

// The number of those of a cluster's first `end` leaves that are shown.
uint shown_count(Cluster cluster, ShownLeaves shown, uint index, uint end) {
  uint count = 0;
  for (uint leaf = 0; leaf < end; ++leaf) count += is_shown(cluster, shown, index, leaf) ? 1 : 0;
  return count;
}

void write_leaf(ClusterList list, Leaf leaf, uint place) {
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = list.box_min + list.box_step * quantised(leaf.corners, i);
  PositionArray positions = PositionArray(push.positions);
  for (uint i = 0; i < 3; ++i) {
    positions.at[6 * place + i] = corners[i];
    positions.at[6 * place + 3 + i] = corners[i == 0 ? 0 : i + 1];
  }
}

void write_leaves(uint index) {
  ClusterList list = ClusterListArray(push.lists).at[0];
  if (gl_LocalInvocationIndex == 0) before = 0;
  barrier();
  for (uint other = gl_LocalInvocationIndex; other < index; other += kClusterLeaves) {
    ShownLeaves shown = shown_of(list, other);
    atomicAdd(before, shown.partly_born ? shown_count(cluster_at(list, other), shown, other, shown.count) : shown.count);
  }
  barrier();
  Cluster cluster = cluster_at(list, index);
  ShownLeaves shown = shown_of(list, index);
  uint leaf = gl_LocalInvocationIndex;
  if (leaf >= shown.count || !is_shown(cluster, shown, index, leaf)) return;
  uint place = before + (shown.partly_born ? shown_count(cluster, shown, index, leaf) : leaf);
  write_leaf(list, LeafArray(cluster.leaves).at[leaf], place);
}

// Vertices of wood and of leaf meshes begin with their position.
void write_mesh(uint place) {
  if (place >= push.count) return;
  uint first = WordArray(push.indices).at[place] * push.vertex_words;
  WordArray words = WordArray(push.vertices);
  PositionArray(push.positions).at[place] = uintBitsToFloat(uvec3(words.at[first], words.at[first + 1], words.at[first + 2]));
}

void main() {
  if (push.vertex_words == 0) write_leaves(gl_WorkGroupID.x);
  else write_mesh(gl_GlobalInvocationID.x);
}
