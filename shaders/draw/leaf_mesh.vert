#version 460
#extension GL_GOOGLE_include_directive : require

// Leaves as they were modelled, one chunk of them.
// reads     view, instances, plants, wood_list, shadow_maps; vertices, materials, crown light and debug colours by address
// writes    position, and what surface_out.glsl says
// draws     indirect, wood_commands or parts among leaf_commands, of cull.comp or hardware_draws.comp: gl_InstanceIndex is a place in the
//           plant's list of instances drawn so, or a slot with kPartBit; recorded by coppice::gpu::ViewRecorder::record_draw

#include "bindings.glsl"
#include "surface_out.glsl"

void main() {
  Plant plant = plants[push.plant];
  uint slot = slot_of_draw(gl_InstanceIndex);
  Instance instance = instances[slot];
  LeafMeshVertex vertex = LeafMeshVertexArray(push.vertices).at[gl_VertexIndex];
  uint material_index = vertex.stalk_z_material >> 16;
  Material material = MaterialArray(plant.materials).at[material_index];
  uvec3 stalk = uvec3(vertex.stalk_xy & 0xffffu, vertex.stalk_xy >> 16, vertex.stalk_z_material & 0xffffu);

  // All vertices of a leaf have its stalk.
  bool shown = is_among(coppice_hash(vertex.stalk_xy ^ (vertex.stalk_z_material & 0xffffu) * 2654435769u) ^ slot, leaf_share_of(instance));
  vec3 world = world_from_object(instance, vertex.position);
  vec3 normal = unfold(unpackSnorm2x16(vertex.normal));
  Crown crown = crown_of(plant);
  vec3 albedo = material.base_color.rgb * tint_of(instance) * variation(crown, plant.box_min + plant.box_step * vec3(stalk), stalk);
  place_vertex(material, world, vertex.uv);
  if (!shown) gl_Position = kOutside;
#ifdef COPPICE_RELIEF
  out_color = albedo;
  out_position = vertex.position;
  out_normal = normal;
  out_slot_material = uvec2(slot, material_index);
#else
  LeafPlace leaf = LeafPlace(vertex.position, vertex.position, normal, material.crown_normals, 0.0);
  out_color = out_back_color = albedo * leaf_light(plant, crown, crown_light_at(plant.crown_light, crown, vertex.position), instance, leaf);
#endif
  if (view.debug_view != 0) show_debug(debug_color(slot));
}
