#version 460
#extension GL_GOOGLE_include_directive : require

// Leaves as they were modelled, one chunk of them.
// reads     view, instances, plants, wood_list, shadow_maps; vertices, materials, crown light and debug colours by address
// writes    position, and what surface_out.glsl says
// draws     indirect, wood_commands or parts among leaf_commands, of cull.comp or hardware_draws.comp: gl_InstanceIndex is a place in the
//           plant's list of instances drawn so, or a slot with kPartBit; recorded by coppice::gpu::ViewRecorder::record_draw

#include "bindings.glsl"
#include "surface_out.glsl"
#include "clusters.glsl"

void main() {
  Plant plant = plants[push.plant];
  uint slot = slot_of_draw(gl_InstanceIndex);
  Instance instance = instance_at(slot);
  LeafMeshVertex vertex = LeafMeshVertexArray(push.vertices).at[gl_VertexIndex];
  uint material_index = vertex.stalk_z_material >> 16;
  Material material = MaterialArray(plant.materials).at[material_index];
  uvec3 stalk = uvec3(vertex.stalk_xy & 0xffffu, vertex.stalk_xy >> 16, vertex.stalk_z_material & 0xffffu);

  // All vertices of a leaf have its stalk.
  uint leaf = coppice_hash(vertex.stalk_xy ^ (vertex.stalk_z_material & 0xffffu) * 2654435769u);
  bool shown = is_among(leaf ^ seed_of(instance), leaf_share_of(instance));
  put_nothing();
  if (!is_drawn(material) || !shown) return;
  vec3 stalk_m = plant.box_min + plant.box_step * vec3(stalk);
  WindMoves moves = wind_moves(instance, vertex.position, vertex.position);
  vec3 normal = unfold(unpackSnorm2x16(vertex.normal));
  float strength = flutter_strength(instance, stalk_m, list_at(plant, list_of_cut(plant.leaf_count)).leaf_size_m);
  vec3 swing = strength * flutter_swing_m(instance, distance(vertex.position, stalk_m)) * normal;
  uint name = flutter_name(stalk);
  vec3 object = vertex.position + moves.now + flutter(moves.load, view.wind.time_s, name, swing);
  vec3 object_before = vertex.position + moves.before + flutter(moves.load_before, view.wind_before.time_s, name, swing);
  vec3 world = world_from_object(instance, object);
  put_place(instance, world, object_before, material, vertex.uv, uvec3(slot, material_index, 0));
  Crown crown = crown_of(plant);
  vec3 albedo = material.base_color.rgb * tint_of(instance) * variation(crown, stalk_m, stalk);
#ifdef COPPICE_RELIEF
  out_position = vertex.position;
  out_albedo_cutoff.rgb = albedo;
  out_normal_along.xyz = normal;  // object space, for relief.frag
#else
  LeafNormals normals = in_world(instance, LeafNormals(normal, 1.0, material.sided_normals));
  CrownSample crown_light = crown_light_at(plant.crown_light, crown, vertex.position);
  LeafLight light = LeafLight(crown_light, sun_past_others(instance, plant, world));
  CoppiceSurface surface = leaf_surface(instance, light, normals, world);
  surface.albedo = albedo;
  surface.normal = normals.axis;  // surface_here turns it to the eye
  put_surface(surface);
#endif
  if (view.debug_view != 0) show_debug(debug_color(slot));
}
