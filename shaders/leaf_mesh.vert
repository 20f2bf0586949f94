#version 460
#extension GL_GOOGLE_include_directive : require

// Leaves as they were modelled, one chunk of them.
// reads     view, instances, plants, the plant's list of instances drawn so (gl_InstanceIndex from its first entry); vertices and materials
//           by address
// writes    position and the lit colour
// dispatch  indirect, from cull.comp's counts; recorded by coppice::gpu::record_draw

#include "bindings.glsl"
#include "shading.glsl"

layout(push_constant, scalar) uniform Push { DrawPush push; };

layout(location = 0) out vec3 out_light;
layout(location = 1) out float out_transmittance;
layout(location = 2) out vec2 out_uv;
layout(location = 3) flat out float out_alpha_cutoff;

void main() {
  Plant plant = plants[push.plant];
  uint slot = wood_list[push.wood_list_first + gl_InstanceIndex];
  Instance instance = instances[slot];
  LeafMeshVertex vertex = LeafMeshVertexArray(push.wood_vertices).at[gl_VertexIndex];
  Material material = MaterialArray(plant.materials).at[vertex.stalk_z_material >> 16];
  uvec3 stalk = uvec3(vertex.stalk_xy & 0xffffu, vertex.stalk_xy >> 16, vertex.stalk_z_material & 0xffffu);

  vec3 world = world_from_object(instance, vertex.position);
  Crown crown = crown_of(plant);
  vec3 albedo = material.base_color.rgb * instance.tint * variation(crown, plant, stalk);

  gl_Position = material.texture == push.texture ? view.clip_from_world * vec4(world, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  out_light = albedo * leaf_light(crown, instance, material.crown_normals, vertex.position, vertex.position, octahedral_normal(vertex.normal));
  out_transmittance = transmittance(world);
  out_uv = vertex.uv;
  out_alpha_cutoff = material.alpha_cutoff;
}
