// What vertex shaders share: push constants, and what they hand on to surface_in.glsl. With COPPICE_RELIEF that is for relief.frag to
// light; with COPPICE_QUADS it is for leaf.frag. After bindings.glsl.

#include "shading.glsl"
#include "debug_view.glsl"

layout(push_constant, scalar) uniform Push { DrawPush push; };

layout(location = 0) out vec3 out_color;  // lit; with COPPICE_RELIEF the albedo
layout(location = 1) out float out_transmittance;
layout(location = 2) out vec2 out_uv;
layout(location = 3) flat out float out_alpha_cutoff;
#ifdef COPPICE_RELIEF
layout(location = 4) out vec3 out_position;  // object space, m
layout(location = 5) out vec3 out_normal;    // object space
layout(location = 6) flat out uvec2 out_slot_material;
#elif defined(COPPICE_QUADS)
layout(location = 4) flat out uint out_thinning;
#else
layout(location = 4) out vec3 out_back_color;  // where the back is seen
#endif

const vec4 kOutside = vec4(2.0, 2.0, 2.0, 1.0);  // the clip volume

// The instance of a draw of wood or leaf meshes.
uint slot_of_draw(uint instance) {
  return (instance & kPartBit) != 0 ? instance & ~kPartBit : wood_list[push.wood_list_first + instance];
}

// A vertex of wood or of a leaf mesh; outside where another draw shows its material.
void place_vertex(Material material, vec3 world, vec2 uv) {
  bool shown = material.texture == push.texture && material.normal_map == push.normal_map;
  gl_Position = shown ? view.eyes[push.eye].clip_from_world * vec4(world, 1.0) : kOutside;
  out_transmittance = transmittance(world);
  out_uv = uv;
  out_alpha_cutoff = material.alpha_cutoff;
}

// With a debug view, in place of light.
void show_debug(vec3 color) {
  out_color = color;
#if !defined(COPPICE_RELIEF) && !defined(COPPICE_QUADS)
  out_back_color = color;
#endif
  out_transmittance = 1.0;
}
