// Shared by vertex shaders: push constants, and outputs to surface_in.glsl. With COPPICE_RELIEF they are for relief.frag, which computes
// normals and light itself; with COPPICE_QUADS they are for leaf.frag. After bindings.glsl.

#include "shading.glsl"
#include "contents.glsl"
#include "debug_view.glsl"
#include "wind.glsl"

layout(push_constant, scalar) uniform Push { DrawPush push; };

#ifdef COPPICE_QUADS
#define COPPICE_OF_LEAF flat  // alike at all corners
#else
#define COPPICE_OF_LEAF
#endif

layout(location = 0) flat out vec4 out_albedo_cutoff;
layout(location = 1) out vec4 out_world_sun;
layout(location = 2) out vec4 out_uv_occlusion_roughness;
layout(location = 3) COPPICE_OF_LEAF out vec4 out_normal_along;  // world space, either side's; along, plus 2 if it is sided
layout(location = 4) flat out uvec4 out_ids;  // slot, material, dither, kHasCome and kIsMirrored
layout(location = 5) out vec3 out_before;  // clip x, y and w in the frame before
#ifdef COPPICE_RELIEF
layout(location = 6) out vec3 out_position;  // object space, m
#endif

const vec4 kOutside = vec4(2.0, 2.0, 2.0, 1.0);  // outside the clip volume

void put_surface(CoppiceSurface surface) {
  out_albedo_cutoff.rgb = surface.albedo;
  out_world_sun.w = surface.sun;
  out_uv_occlusion_roughness.z = surface.occlusion;
  out_normal_along = vec4(surface.normal, surface.along + 2.0 * surface.sided);
}

// world: the place; object_before: the place in the frame before, object space
void put_place(Instance instance, vec3 world, vec3 object_before, Material material, vec2 uv, uvec3 slot_material_dither) {
  gl_Position = view.eyes[push.eye].clip_from_world * vec4(world, 1.0);
  out_world_sun.xyz = world;
  out_albedo_cutoff.w = material.alpha_cutoff;
  out_uv_occlusion_roughness.xy = uv;
  out_uv_occlusion_roughness.w = material.roughness;
  out_ids = uvec4(slot_material_dither, (instance.before == kCame ? kHasCome : 0) | (instance.rotation.w < 0.0 ? kIsMirrored : 0));
  if (has_content(kContentVelocity))
    out_before = (view.eyes[push.eye].clip_from_world_before * vec4(world_before(instance, object_before), 1.0)).xyw;
}

// Call it instead if nothing is drawn: the vertex goes outside the clip volume. Another draw shows its material, or none does.
void put_nothing() {
  gl_Position = kOutside;
  out_albedo_cutoff = out_world_sun = out_uv_occlusion_roughness = out_normal_along = vec4(0.0);
  out_before = vec3(0.0);
  out_ids = uvec4(0);
#ifdef COPPICE_RELIEF
  out_position = vec3(0.0);
#endif
}

// The instance of a draw of wood or leaf meshes.
uint slot_of_draw(uint instance) {
  return (instance & kPartBit) != 0 ? instance & ~kPartBit : wood_list[push.wood_list_first + instance];
}
bool is_drawn(Material material) { return material.texture == push.texture && material.normal_map == push.normal_map; }

// Shows a colour of a debug view instead of light.
void show_debug(vec3 color) { out_albedo_cutoff.rgb = color; }
