#version 460
#extension GL_GOOGLE_include_directive : require

// Leaves as they were modelled, one chunk of them.
// reads     view, instances, plants, the plant's list of instances drawn so (gl_InstanceIndex from its first entry, or a slot with kPartBit); vertices and materials
//           by address
// writes    position, and what surface_out.glsl says
// dispatch  indirect, from cull.comp's counts; recorded by coppice::gpu::record_draw

#include "bindings.glsl"
#include "shading.glsl"
#include "debug_view.glsl"
#include "surface_out.glsl"

layout(push_constant, scalar) uniform Push { DrawPush push; };

#include "mesh_slot.glsl"

void main() {
  Plant plant = plants[push.plant];
  uint slot = slot_of_draw(gl_InstanceIndex);
  Instance instance = instances[slot];
  LeafMeshVertex vertex = LeafMeshVertexArray(push.vertices).at[gl_VertexIndex];
  uint material_index = vertex.stalk_z_material >> 16;
  Material material = MaterialArray(plant.materials).at[material_index];
  uvec3 stalk = uvec3(vertex.stalk_xy & 0xffffu, vertex.stalk_xy >> 16, vertex.stalk_z_material & 0xffffu);

  vec3 world = world_from_object(instance, vertex.position);
  vec3 normal = unfold(unpackSnorm2x16(vertex.normal));
  Crown crown = crown_of(plant);
  vec3 albedo = material.base_color.rgb * instance.tint * variation(crown, plant.box_min + plant.box_step * vec3(stalk), stalk);
  bool shown = material.texture == push.texture && material.normal_map == push.normal_map;
  gl_Position = shown ? view.clip_from_world * vec4(world, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
#ifdef COPPICE_RELIEF
  out_albedo = albedo;
  out_position = vertex.position;
  out_normal = normal;
  out_slot_material = uvec2(slot, material_index);
#else
  LeafPlace leaf = LeafPlace(vertex.position, vertex.position, normal, material.crown_normals, 0.0);
  out_light = albedo * leaf_light(plant, crown, crown_light_at(plant.crown_light, crown, vertex.position), instance, leaf);
#endif
  out_transmittance = transmittance(world);
  out_uv = vertex.uv;
  out_alpha_cutoff = material.alpha_cutoff;
  if (view.debug_view != 0) {
    vec3 color = debug_color(slot);
#ifdef COPPICE_RELIEF
    out_albedo = color;
#else
    out_light = color;
#endif
    out_transmittance = 1.0;
  }
#ifndef COPPICE_RELIEF
  out_back_light = out_light;
#endif
}
