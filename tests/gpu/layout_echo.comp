#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Writes every field of every struct of coppice_shared.h to `words`, in order of declaration.
// dispatch  1; recorded by layout_test.cpp

#include "coppice_shared.h"

layout(local_size_x = 1) in;

layout(set = 0, binding = 0, scalar) readonly buffer Structs {
  Leaf leaf;
  Splat splat;
  Cluster cluster;
  ClusterList list;
  CardLook look;
  Instance instance;
  Card card;
  Material material;
  WoodVertex wood_vertex;
  LeafMeshVertex leaf_mesh_vertex;
  Plant plant;
  View view;
  Counters counters;
  DrawCommand command;
  DrawPush push;
};
layout(set = 0, binding = 1, scalar) writeonly buffer Words { uint words[]; };

uint at = 0;
void put(uint v) { words[at++] = v; }
void put(int v) { put(uint(v)); }
void put(float v) { put(floatBitsToUint(v)); }
void put(ivec3 v) { put(v.x); put(v.y); put(v.z); }
void put(uvec2 v) { put(v.x); put(v.y); }
void put(vec2 v) { put(v.x); put(v.y); }
void put(vec3 v) { put(v.xy); put(v.z); }
void put(vec4 v) { put(v.xyz); put(v.w); }
void put(mat4 m) { for (int i = 0; i < 4; ++i) put(m[i]); }

void put_clusters() {
  for (int i = 0; i < 6; ++i) put(leaf.corners[i]);
  put(leaf.card); put(leaf.life);
  put(splat.xy); put(splat.z_size); put(splat.axis); put(splat.normals); put(splat.look); put(splat.crown);
  put(cluster.center); put(cluster.radius_m); put(cluster.leaves); put(cluster.splats); put(cluster.counts);
  put(cluster.last_death); put(cluster.grains_m); put(cluster.leaf_sizes_m);
  put(cluster.splat_size_m); put(cluster.axis_steps);
  put(list.box_min); put(list.leaf_count); put(list.box_step); put(list.cluster_count); put(list.range_count); put(list.splat_step); put(list.leaf_size_m);
  put(list.blocks); put(list.grain_m); put(list.holed_m); put(list.facet_m);
  put(look.albedo); put(look.coverage);
  for (int i = 0; i < 2; ++i) put(look.mask[i]);
  put(look.roughness);
}

void put_plant() {
  put(plant.sphere_center); put(plant.sphere_radius);
  put(plant.box_min); put(plant.leaf_count);
  put(plant.box_step); put(plant.resident_leaf_count); put(plant.quantised_max);
  put(plant.error_level_count); put(plant.error_size_count);
  put(plant.lists); put(plant.cards); put(plant.materials); put(plant.card_looks); put(plant.crown_light);
  put(plant.instance_count); put(plant.leaf_command_base); put(plant.leaf_command_capacity); put(plant.part_base); put(plant.part_capacity); put(plant.wood_list_base);
  put(plant.wood_lod_count); put(plant.wood_resident_mask); put(plant.wood_list_mask);
  for (uint i = 0; i < kMaxWoodLods; ++i) put(plant.wood_index_counts[i]);
  put(plant.leaf_mesh_count); put(plant.leaf_mesh_triangles); put(plant.leaf_mesh_list_base);
  put(plant.mesh_list_count); put(plant.mesh_cluster_count);
  put(plant.material_override.leaf_tint); put(plant.material_override.leaf_roughness); put(plant.material_override.wood_tint);
  put(plant.material_override.wood_roughness); put(plant.material_override.translucency); put(plant.material_override.parameters);
}

void put_wind(WindNow wind) {
  put(wind.direction); put(wind.load); put(wind.gustiness); put(wind.time_s);
  for (uint i = 0; i < kWindWaves; ++i) put(wind.waves[i]);
  put(wind.speed_mps); put(wind.max_load); put(wind.max_reach); put(wind.map); put(wind.map_size); put(wind.map_first); put(wind.map_places_per_m);
}

void put_view() {
  for (uint eye = 0; eye < kMaxEyes; ++eye) {
    put(view.eyes[eye].clip_from_world); put(view.eyes[eye].clip_from_world_before); put(view.eyes[eye].world_from_key);
    for (int i = 0; i < 5; ++i) put(view.eyes[eye].planes[i]);
    put(view.eyes[eye].key_row); put(view.eyes[eye].place); put(view.eyes[eye].first_px);
  }
  put(view.eye_cell); put(view.eye_in_cell); put(view.layer_mask); put(view.error_px);
  put(view.focal_px); put(view.near_m); put(view.lod_full); put(view.lod_discrete); put(view.instance_slot_count); put(view.frame);
  put(view.fog_density);
  put(view.sun_direction); put(view.sun_color); put(view.sky_color); put(view.ground_color); put(view.fog_color);
  put(view.debug_view); put(view.debug_colors);
  put(view.instances); put(view.moved); put(view.tables); put(view.wind_maps);
  put(view.is_shadow); put(view.shadow_map_count); put(view.depth_sign); put(view.is_mirrored);
  put(view.is_perspective); put(view.toward_viewer);
  put(view.temporal_frame); put(view.half_size_px); put(view.has_overrides); put_wind(view.wind); put_wind(view.wind_before);
  for (uint i = 0; i < kMaxShadowMaps; ++i) put(view.map_clips[i]);
}

void main() {
  put_clusters();
  put(instance.position); put(instance.scale); put(instance.rotation); put(instance.cell_xy); put(instance.cell_z_bias);
  put(instance.tint_xy); put(instance.tint_z_share); put(instance.plant_seed); put(instance.layer_mask); put(instance.user_data); put(instance.before);
  put(card.material);
  for (int i = 0; i < 4; ++i) put(card.uv[i]);
  put(material.base_color); put(material.alpha_cutoff); put(material.texture); put(material.sided_normals); put(material.normal_map); put(material.roughness);
  put(wood_vertex.position); put(wood_vertex.normal); put(wood_vertex.uv); put(wood_vertex.material);
  put(leaf_mesh_vertex.position); put(leaf_mesh_vertex.normal); put(leaf_mesh_vertex.uv);
  put(leaf_mesh_vertex.stalk_xy); put(leaf_mesh_vertex.stalk_z_material);
  put_plant();
  put_view();
  put(counters.visible_instances); put(counters.occluded_instances);
  for (int i = 0; i < 2; ++i) put(counters.leaves[i]);
  for (int i = 0; i < 2; ++i) put(counters.wood_triangles[i]);
  put(counters.leaf_mesh_instances);
  for (int i = 0; i < 2; ++i) put(counters.leaf_mesh_triangles[i]);
  for (int i = 0; i < 2; ++i) put(counters.hardware_triangles[i]);
  put(command.index_count); put(command.instance_count); put(command.first_index); put(command.vertex_offset); put(command.first_instance);
  put(push.plant); put(push.texture); put(push.vertices); put(push.wood_list_first); put(push.normal_map); put(push.eye); put(push.unused);
}
