#version 460
#extension GL_GOOGLE_include_directive : require

// Trunk and branches of one wood LoD.
// reads     view, instances, plants, wood_list, shadow_maps; vertices, materials, crown light and debug colours by address
// writes    position, and what surface_out.glsl says
// draws     indirect, wood_commands or parts among leaf_commands, of cull.comp or hardware_draws.comp: gl_InstanceIndex is a place in the
//           LoD's wood list, or a slot with kPartBit; recorded by coppice::gpu::ViewRecorder::record_draw

#include "bindings.glsl"
#include "surface_out.glsl"

void main() {
  Plant plant = plants[push.plant];
  uint slot = slot_of_draw(gl_InstanceIndex);
  Instance instance = instances[slot];
  WoodVertex vertex = WoodVertexArray(push.vertices).at[gl_VertexIndex];
  Material material = MaterialArray(plant.materials).at[vertex.material];

  vec3 world = world_from_object(instance, vertex.position);
  vec3 normal = unfold(unpackSnorm2x16(vertex.normal));
  place_vertex(material, world, vertex.uv);
#ifdef COPPICE_RELIEF
  out_color = material.base_color.rgb;
  out_position = vertex.position;
  out_normal = normal;
  out_slot_material = uvec2(slot, vertex.material);
#else
  WoodLight light = wood_light_at(plant, crown_of(plant), instance, vertex.position);
  vec3 world_normal = rotate(instance.rotation, normal);
  out_color = material.base_color.rgb * lit(light, world_normal);
  out_back_color = material.base_color.rgb * lit(light, -world_normal);
#endif
  if (view.debug_view != 0)
    show_debug(view.debug_view == kDebugPath ? kHardwareWood : view.debug_view == kDebugOverdraw ? kNotCounted : debug_color(slot));
}
