#version 460
#extension GL_GOOGLE_include_directive : require

// Trunk and branches of one wood LoD.
// reads     view, instances, plants, the LoD's wood list (gl_InstanceIndex from its first entry); vertices and materials by address
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
  WoodVertex vertex = WoodVertexArray(push.wood_vertices).at[gl_VertexIndex];
  Material material = MaterialArray(plant.materials).at[vertex.material];

  vec3 world = world_from_object(instance, vertex.position);
  vec3 normal = rotate(instance.rotation, octahedral_normal(vertex.normal));
  Crown crown = crown_of(plant);
  vec3 sun_object = rotate(vec4(-instance.rotation.xyz, instance.rotation.w), view.sun_direction);
  vec3 direct = view.sun_color * sun_through_crown(crown, vertex.position, sun_object) * max(0.0, dot(normal, view.sun_direction));
  vec3 ambient = ambient_light(normal) * sky_through_crown(crown, vertex.position);

  gl_Position = material.texture == push.texture ? view.clip_from_world * vec4(world, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  out_light = material.base_color.rgb * (direct + ambient);
  out_transmittance = transmittance(world);
  out_uv = vertex.uv;
  out_alpha_cutoff = material.alpha_cutoff;
}
