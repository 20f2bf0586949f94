// Descriptor set 0 of every shader, written by gpu/view/passes.cpp, and the buffers that it leads to by address.
// COPPICE_CULL_ACCESS is defined as empty by shaders that fill the buffers; for the others they are readonly.

#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

#include "coppice_shared.h"

#ifndef COPPICE_CULL_ACCESS
#define COPPICE_CULL_ACCESS readonly
#endif

// A uniform buffer, because software drivers load a word of it once for all invocations, but one of a storage buffer once for each.
layout(set = 0, binding = 0, scalar) uniform ViewBuffer { View view; };
// Texels, because software drivers gather them, but load a storage buffer's words one invocation after the other. A device whose texel
// buffers are too small reads the same data by address: gpu/device/shader_words.cpp then drops the branches that read texels.
layout(constant_id = 8) const bool kReadsTexels = true;
layout(set = 0, binding = 1) uniform usamplerBuffer instance_texels;  // Instance[]
layout(set = 0, binding = 2, scalar) readonly buffer PlantBuffer { Plant plants[]; };
layout(set = 0, binding = 3) uniform usamplerBuffer table_words;
layout(set = 0, binding = 4, scalar) COPPICE_CULL_ACCESS buffer CutBuffer { float cuts[]; };
layout(set = 0, binding = 5, scalar) COPPICE_CULL_ACCESS buffer WoodListBuffer { uint wood_list[]; };

layout(set = 0, binding = 10) uniform sampler2D shadow_maps[kMaxShadowMaps];
// The engine's depth of each eye before plants. Only compute shaders see it.
layout(set = 0, binding = 11) uniform sampler2D occluders[kMaxEyes];
layout(set = 0, binding = 12) uniform usamplerBuffer wind_maps;  // two floats each
// Instance[]: former places of instances that have moved since the frame before.
layout(set = 0, binding = 13) uniform usamplerBuffer moved_texels;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AddressArray { uvec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer WordArray { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) COPPICE_CULL_ACCESS buffer DebugColorArray { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CardArray { Card at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialArray { Material at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer WoodVertexArray { WoodVertex at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LeafMeshVertexArray { LeafMeshVertex at[]; };

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TexelArray { uvec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer WindMapArray { vec2 at[]; };

uvec4 instance_texel(uint slot, uint part) {
  return kReadsTexels ? texelFetch(instance_texels, int(4 * slot + part)) : TexelArray(view.instances).at[4 * slot + part];
}
uvec4 moved_texel(uint place, uint part) {
  return kReadsTexels ? texelFetch(moved_texels, int(4 * place + part)) : TexelArray(view.moved).at[4 * place + part];
}
uint table_word(uint place) {
  return kReadsTexels ? texelFetch(table_words, int(place)).x : WordArray(view.tables).at[place];
}
vec2 wind_map_at(uint place) {
  return kReadsTexels ? uintBitsToFloat(texelFetch(wind_maps, int(place)).xy) : WindMapArray(view.wind_maps).at[place];
}
#define COPPICE_TABLE_WORD(table, i) table_word((table).first_word + (i))
#include "coppice_lod.h"
#include "coppice_instance.h"

// One that grows up has its size in this frame, and counts as one that has just come.
Instance unpacked_instance(uvec4 first, uvec4 second, uvec4 third, uvec4 fourth) {
  float grown = grown_share(fourth.w, view.frame);
  uint before = has_growth(fourth.w) ? (grown < 1.0 ? kCame : 0) : fourth.w;
  return Instance(uintBitsToFloat(first.xyz), uintBitsToFloat(first.w) * grown, uintBitsToFloat(second), third.x, third.y, third.z,
                  third.w, fourth.x, fourth.y, fourth.z, before);
}
Instance instance_at(uint slot) {
  return unpacked_instance(instance_texel(slot, 0), instance_texel(slot, 1), instance_texel(slot, 2), instance_texel(slot, 3));
}
uint plant_at(uint slot) { return instance_texel(slot, 3).x & kNoPlant; }

// The distance from the eye that determines sizes, m; the caller limits it to view.near_m from below.
float size_distance_m(vec3 place) { return view.is_perspective * length(place); }
// Unit direction from a place towards the viewer.
vec3 toward_eye(vec3 place) { return normalize(view.toward_viewer - view.is_perspective * place); }

bool sphere_in_eye(uint eye, vec3 center, float radius) {
  for (int i = 0; i < 5; ++i)
    if (dot(view.eyes[eye].planes[i].xyz, center) + view.eyes[eye].planes[i].w < -radius) return false;
  return true;
}

// The view's number of eyes in shaders that select: a constant, because software drivers would run the second eye's code for one eye too.
layout(constant_id = 6) const uint kEyes = 1;

bool sphere_in_view(vec3 center, float radius) {
  return sphere_in_eye(0, center, radius) || (kEyes > 1 && sphere_in_eye(1, center, radius));
}
