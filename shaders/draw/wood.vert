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
  Instance instance = instance_at(slot);
  WoodVertex vertex = WoodVertexArray(push.vertices).at[gl_VertexIndex];
  Material material = MaterialArray(plant.materials).at[vertex.material];

  put_nothing();
  if (!is_drawn(material)) return;
  WindMoves moves = wind_moves(instance, vertex.position, vertex.position);
  vec3 world = world_from_object(instance, vertex.position + moves.now);
  put_place(instance, world, vertex.position + moves.before, material, vertex.uv, uvec3(slot, vertex.material, 0));
  if (kContents == 0) return;
  vec3 normal = unfold(unpackSnorm2x16(vertex.normal));
#ifdef COPPICE_RELIEF
  out_position = vertex.position;
  out_albedo_cutoff.rgb = material.base_color.rgb;
  out_normal_along.xyz = normal;  // object space, for relief.frag
#else
  CrownSample crown_light = crown_light_at(plant.crown_light, crown_of(plant), vertex.position);
  LeafLight light = LeafLight(crown_light, sun_past_others(instance, plant, world));
  CoppiceSurface surface = wood_surface(instance, light, oriented(instance.rotation, normal));
  surface.albedo = material.base_color.rgb;
  put_surface(surface);
#endif
  if (view.debug_view != 0)
    show_debug(view.debug_view == kDebugPath ? kHardwareWood : view.debug_view == kDebugOverdraw ? kNotCounted : debug_color(slot));
}
