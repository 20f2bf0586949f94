#version 460
#extension GL_GOOGLE_include_directive : require

// Trunk and branches of one wood LoD.
// reads     view, instances, plants, the LoD's wood list (gl_InstanceIndex from its first entry, or a slot with kPartBit); vertices and materials by address
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
  WoodVertex vertex = WoodVertexArray(push.vertices).at[gl_VertexIndex];
  Material material = MaterialArray(plant.materials).at[vertex.material];

  vec3 world = world_from_object(instance, vertex.position);
  vec3 normal = unfold(unpackSnorm2x16(vertex.normal));
  bool shown = material.texture == push.texture && material.normal_map == push.normal_map;
  gl_Position = shown ? view.clip_from_world * vec4(world, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
#ifdef COPPICE_RELIEF
  out_albedo = material.base_color.rgb;
  out_position = vertex.position;
  out_normal = normal;
  out_slot_material = uvec2(slot, vertex.material);
#else
  WoodLight light = wood_light_at(plant, crown_of(plant), instance, vertex.position);
  vec3 world_normal = rotate(instance.rotation, normal);
  out_light = material.base_color.rgb * lit(light, world_normal);
  out_back_light = material.base_color.rgb * lit(light, -world_normal);
#endif
  out_transmittance = transmittance(world);
  out_uv = vertex.uv;
  out_alpha_cutoff = material.alpha_cutoff;
  if (view.debug_view != 0) {
    vec3 color = view.debug_view == kDebugPath ? kHardwareWood : view.debug_view == kDebugOverdraw ? kNotCounted : debug_color(slot);
#ifdef COPPICE_RELIEF
    out_albedo = color;
#else
    out_light = out_back_light = color;
#endif
    out_transmittance = 1.0;
  }
}
