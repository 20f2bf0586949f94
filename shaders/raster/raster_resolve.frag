#version 460
#extension GL_GOOGLE_include_directive : require

// Copies the compute rasteriser's picture into the engine's attachments: the surface of each pixel's leaf or triangle, and its depth.
// reads     picture, work_items, view, instances; splats and debug colours by address
// writes    what surface.glsl says, unless COPPICE_DEPTH; depth
// draws     one triangle, recorded by coppice::gpu::LeafRaster::record_resolve

#include "bindings.glsl"
#include "debug_view.glsl"
#include "raster_shared.h"
#define COPPICE_ACCESS readonly
#include "raster_reads.glsl"
#ifndef COPPICE_DEPTH
#include "shading.glsl"
#include "clusters.glsl"
#include "names.glsl"
#include "surface.glsl"

layout(set = 1, binding = 10) uniform usamplerBuffer motion_texels;

vec4 motion_row(uint place, uint row) {
  uint texel = 3 * place + row;
  return uintBitsToFloat(kReadsTexels ? texelFetch(motion_texels, int(texel)) : TexelArray(push.motion).at[texel]);
}

// pixel: in the picture
void resolve(uint name, float key, vec2 pixel) {
  uint work_place = place_of_name(name, push.place_bits);
  WorkItem work = work_at(work_place);
  uint leaf = leaf_of_name(name, first_name(work_place, work, push.place_bits), push.place_bits);
  uint slot = slot_of(work.item), list = list_of(work.item);
  bool wood = list >= kWoodLists && list < kMeshLists;
  // Loads only the parts of the instance that are needed: light needs two of its four texels.
  bool moves = has_content(kContentVelocity);
  uvec4 names = moves || needs_names() ? instance_texel(slot, 3) : uvec4(0);
  Instance instance = unpacked_instance(uvec4(0), instance_texel(slot, 1), instance_texel(slot, 2), names);
  Splat splat = SplatArray(splats_of_work(work)).at[leaf];
  vec4 key_place = view.eyes[push.eye].world_from_key * vec4(pixel / view.half_size_px - 1.0, key, 1.0);
  vec3 world = key_place.xyz / key_place.w;
  vec3 look = unpackUnorm4x8(splat.look).rgb;
  LeafNormals normals = in_world(instance, normals_of(splat));
  LeafLight light = LeafLight(unpack_crown(splat.crown), sun_of_work(work));
  CoppiceSurface surface;
  if (wood) {
    vec3 face = oriented(instance.rotation, unfold(unpackSnorm4x8(splat.normals).zw));
    surface = wood_surface(instance, light, dot(face, toward_eye(world)) < 0.0 ? -normals.axis : normals.axis);
  } else {
    surface = leaf_surface(instance, light, normals, world);
  }
  surface.albedo *= kMaxSplatAlbedo * look * look;
  surface.roughness = roughness_of(splat);
  vec4 before = vec4(0.0);
  if (moves) {
    vec4 now = vec4(world, 1.0);
    for (int i = 0; i < 3; ++i) before[i] = dot(motion_row(work_place, i), now);
    before = view.eyes[push.eye].clip_from_world_before * vec4(before.xyz, 1.0);
  }
  SurfacePlace place = SurfacePlace(world, instance.user_data, pixel, before.xyw, instance.before == kCame, plant_of(instance), wood);
  if (view.debug_view != 0) write_color(debug_color(slot) * (wood && view.debug_view == kDebugPath ? 0.3 : 1.0), place);
  else write_surface(surface, place);
}
#endif

void main() {
  // The viewport need not begin at an even pixel. Helper invocations of a quad, which read too, are clamped to the picture.
  ivec2 last = ivec2(push.width_px, push.height_px) - 1;
  uvec2 at = uvec2(clamp(ivec2(gl_FragCoord.xy) - ivec2(view.eyes[push.eye].first_px), ivec2(0), last));
  uint word = 2 * ((push.eye * push.height_px + at.y) * push.width_px + at.x);
  uint name = picture_word(word);
  if (name == 0) discard;
  float key = uintBitsToFloat(picture_word(word + 1));
#ifndef COPPICE_DEPTH
  if (view.debug_view == kDebugOverdraw)
    write_color(ramp(log2(float(name)) / 5.0), SurfacePlace(vec3(0.0), 0, vec2(0.0), vec3(0.0), true, 0, false));
  else if (name != 0) resolve(name, key, vec2(at) + 0.5);  // some drivers let discarded invocations continue as helpers
#endif
  gl_FragDepth = push.reversed != 0 ? key : 1.0 - key;
}
