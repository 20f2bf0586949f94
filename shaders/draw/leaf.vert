#version 460
#extension GL_GOOGLE_include_directive : require

// Leaf quads of one cluster of an instance: four vertices for each leaf, those not born yet collapsed outside the clip volume.
// reads     view, instances, plants, cuts, shadow_maps; lists, clusters, leaves, splats, cards, materials, debug colours by address
// writes    position, and what surface_out.glsl says
// draws     indirect, leaf_commands of cull.comp or leaf_expand.comp: gl_InstanceIndex names slot and list, gl_VertexIndex cluster, leaf and
//           corner; recorded by coppice::gpu::ViewRecorder::record_draw

#define COPPICE_QUADS
#include "bindings.glsl"
#include "surface_out.glsl"
#include "leaf_shading.glsl"
#include "clusters.glsl"

void main() {
  uint slot = slot_of(gl_InstanceIndex), list_index = list_of(gl_InstanceIndex);
  uint corner = uint(gl_VertexIndex) & 3;
  Plant plant = plants[push.plant];
  gl_Position = kOutside;
  out_color = vec3(0.0);
  out_transmittance = 1.0;
  out_uv = vec2(0.0);
  out_alpha_cutoff = 0.0;
  out_thinning = 0;
  ClusterList list = list_at(plant, list_index);
  uint place = uint(gl_VertexIndex) >> 2, cluster = place / kClusterLeaves;
  Leaf leaf = LeafArray(cluster_at(list, cluster).leaves).at[place % kClusterLeaves];
  uint crown_word = SplatArray(cluster_at(list, cluster).splats).at[place % kClusterLeaves].crown;
  bool paged = list_index == kPageList;
  uint leaf_count = paged ? cut_leaf_count(slot, plant) : list.leaf_count;
  if (paged && !is_born(leaf.life, born_splits(leaf_count, cluster))) return;

  Instance instance = instances[slot];
  Card card = CardArray(plant.cards).at[card_of_leaf(leaf.card)];
  Material material = MaterialArray(plant.materials).at[card.material];
  if (material.texture != push.texture) return;
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = plant.box_min + plant.box_step * quantised(leaf.corners, i);
  vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  vec3 world_middle;
  float loss = outline_loss(corners, instance, world_middle);
  // A quad of the same covered area, whatever the cutoff lets through: of the soft texels of a small mip level soon all.
  float let_through = mix(material.coverage, 1.0, min(1.5 * loss, 1.0));
  uint name = name_of(leaf, slot);
  float share = shared_side(name, is_single(leaf, paged, leaf_count == plant.leaf_count), leaf_share_of(instance));
  if (share == 0.0) return;
  float scale = share * sqrt(material.coverage / let_through);
  vec3 object = middle + (corners[corner] - middle) * scale;
  vec3 world = world_from_object(instance, object);
  gl_Position = view.eyes[push.eye].clip_from_world * vec4(world, 1.0);

  Crown crown = crown_of(plant);
  vec3 face = cross(corners[2] - corners[0], corners[3] - corners[1]);
  vec3 albedo = brightness_of_leaf(leaf.card) * material.base_color.rgb * tint_of(instance) *
                variation(crown, corners[0], uvec3(quantised(leaf.corners, 0)));
  float size_m = max(distance(corners[0], corners[2]), distance(corners[1], corners[3]));
  float bulk = merged_share(plant, leaf_count) * full_bulk(crown, size_m);
  LeafPlace leaf_place = LeafPlace(middle, object, face, material.crown_normals, bulk);
  out_color = albedo * leaf_light(plant, crown, unpack_crown(crown_word), instance, leaf_place);
  out_transmittance = transmittance(world);
  out_uv = card.uv[corner];
  out_alpha_cutoff = material.alpha_cutoff * (1.0 - loss);
  vec4 clip_middle = view.eyes[push.eye].clip_from_world * vec4(world_middle, 1.0);
  out_thinning = thinning_of(leaf, name, view.half_size_px * (clip_middle.xy / clip_middle.w + 1.0));
  if (view.debug_view != 0) show_debug(view.debug_view == kDebugPath ? kHardwareLeaves : debug_color(slot));
}
