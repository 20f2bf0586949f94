#version 460
#extension GL_GOOGLE_include_directive : require

// Leaf quads of one cluster of an instance: four vertices for each leaf. Leaves that are not born yet are collapsed outside the clip
// volume.
// reads     view, instances, plants, cuts, shadow_maps; lists, clusters, leaves, splats, cards, materials, debug colours by address
// writes    position, and what surface_out.glsl says
// draws     indirect, leaf_commands of cull.comp or leaf_expand.comp: gl_InstanceIndex names slot and list, gl_VertexIndex cluster, leaf
// and
//           corner; recorded by coppice::gpu::ViewRecorder::record_draw

#define COPPICE_QUADS
#include "bindings.glsl"
#include "surface_out.glsl"
#include "clusters.glsl"
#include "leaf_shading.glsl"

void main() {
  uint slot = slot_of(gl_InstanceIndex), list_index = list_of(gl_InstanceIndex);
  uint corner = uint(gl_VertexIndex) & 3;
  Plant plant = plants[push.plant];
  put_nothing();
  ClusterList list = list_at(plant, list_index);
  uint place = uint(gl_VertexIndex) >> 2, cluster = place / kClusterLeaves;
  Leaf leaf = LeafArray(cluster_at(list, cluster).leaves).at[place % kClusterLeaves];
  Splat splat = SplatArray(cluster_at(list, cluster).splats).at[place % kClusterLeaves];
  bool paged = list_index == kPageList;
  uint leaf_count = paged ? cut_leaf_count(slot, plant) : list.leaf_count;
  if (paged && !is_born(leaf.life, born_splits(leaf_count, cluster))) return;

  Instance instance = instance_at(slot);
  Card card = CardArray(plant.cards).at[card_of_leaf(leaf.card)];
  Material material = MaterialArray(plant.materials).at[card.material];
  if (material.texture != push.texture) return;
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = plant.box_min + plant.box_step * quantised(leaf.corners, i);
  vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  uint name = name_of(leaf, seed_of(instance));
  bool single = is_single(leaf, paged, leaf_count == plant.leaf_count);
  float share = shared_side(name, single, leaf_share_of(instance));
  if (share == 0.0) return;
  vec3 rest = middle + (corners[corner] - middle) * share;
  vec3 face = cross(corners[2] - corners[0], corners[3] - corners[1]);

  // A merged leaf leans as its middle does, and does not flutter; a single one does once the cut is beyond the split that bears it.
  WindMoves moves = wind_moves(instance, rest, single ? rest : middle);
  float strength = flutter_strength(instance, corners[0], list.leaf_size_m);
  float birth = float(cluster / kBlockClusters * kPageSplits + (leaf.life >> kBirthShift));
  if (paged) strength *= clamp((cuts[slot] - birth) / (0.1 * birth + 16.0), 0.0, 1.0);
  if (!single) strength = 0.0;
  uint stalk = flutter_name(uvec3(quantised(leaf.corners, 0)));
  vec3 normal = face * inversesqrt(max(dot(face, face), 1e-30));
  vec3 swing = strength * flutter_swing_m(instance, distance(rest, corners[0])) * normal;
  vec3 world = world_from_object(instance, rest + moves.now + flutter(moves.load, view.wind.time_s, stalk, swing));
  vec3 before = rest + moves.before + flutter(moves.load_before, view.wind_before.time_s, stalk, swing);
  vec4 clip_middle = view.eyes[push.eye].clip_from_world * vec4(world_from_object(instance, middle + moves.now), 1.0);
  uint dither = dither_of(leaf, name, view.half_size_px * (clip_middle.xy / clip_middle.w + 1.0));
  put_place(instance, world, before, material, card.uv[corner], uvec3(slot, card.material, dither));
  vec2 uv_along = card.uv[1] - card.uv[0], uv_across = card.uv[3] - card.uv[0];
  out_ids.w |= packHalf2x16(vec2(0.0, log2(abs(uv_along.x * uv_across.y - uv_along.y * uv_across.x))));
  if (kContents == 0) return;

  Crown crown = crown_of(plant);
  LeafLight light = LeafLight(unpack_crown(splat.crown), sun_past_others(instance, plant, world));
  CoppiceSurface surface = leaf_surface(instance, light, in_world(instance, normals_of(splat)), world);
  surface.albedo *= material.base_color.rgb * variation(crown, corners[0], uvec3(quantised(leaf.corners, 0)));
  put_surface(surface);
  if (view.debug_view != 0) show_debug(view.debug_view == kDebugPath ? kHardwareLeaves : debug_color(slot));
}
