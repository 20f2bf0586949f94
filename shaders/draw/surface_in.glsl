// Inputs of fragment shaders from surface_out.glsl, and the texture of a draw. After bindings.glsl.

#include "shading.glsl"

layout(push_constant, scalar) uniform Push { DrawPush push; };
layout(constant_id = 0) const uint kTextured = 1;
layout(constant_id = 1) const uint kLeaf = 0;  // 0: wood

layout(set = 1, binding = 0) uniform sampler2D base_color;

#ifdef COPPICE_QUADS
#define COPPICE_OF_LEAF flat
#else
#define COPPICE_OF_LEAF
#endif

layout(location = 0) flat in vec4 in_albedo_cutoff;
layout(location = 1) in vec4 in_world_sun;
layout(location = 2) in vec4 in_uv_occlusion_roughness;
layout(location = 3) COPPICE_OF_LEAF in vec4 in_normal_along;
layout(location = 4) flat in uvec4 in_ids;
layout(location = 5) in vec3 in_before;

uvec2 pixel_in_picture() { return uvec2(gl_FragCoord.xy) - view.eyes[push.eye].first_px; }

// True if a triangle's corners run counter-clockwise for the viewer, as they were modelled, whichever way y of the picture points.
bool is_front() { return gl_FrontFacing == ((view.is_mirrored != 0) == ((in_ids.w & kIsMirrored) != 0)); }

// Alpha of the mask at a pixel. uv_x, uv_y: derivatives of the texture coordinates; alpha: of the mip level that fits the long side of the
// pixel's footprint in the texture
//
// There the mask of a leaf that is seen nearly edge-on would be one blur, all leaf or all hole. So where the footprint is more than four
// times as long as wide, alpha comes from the level that fits four times its width; and it never comes from a level where a quad's
// card has less than 64 texels, or the image of a mesh less than 64 a side. Such alpha is a sample, which covers the right share of pixels.
float mask_alpha(vec2 uv, vec2 uv_x, vec2 uv_y, float alpha) {
  vec2 size = vec2(textureSize(base_color, 0));
  vec2 x = uv_x * size, y = uv_y * size;
  float mean = 0.5 * (dot(x, x) + dot(y, y)), half_difference = 0.5 * (dot(x, x) - dot(y, y));
  float spread = sqrt(half_difference * half_difference + dot(x, y) * dot(x, y));
  float long_level = 0.5 * log2(mean + spread), level = min(long_level, 2.0 + 0.5 * log2(max(mean - spread, 0.0625)));
#ifdef COPPICE_QUADS
  float texels = 0.5 * (unpackHalf2x16(in_ids.w).y + log2(size.x * size.y)) - 3.0;
#else
  float texels = log2(min(size.x, size.y)) - 6.0;
#endif
  level = min(level, max(texels, 0.0));
  return level < long_level ? textureLod(base_color, uv, level).a : alpha;
}

// Discards holes. Call it before other discards: they end derivatives.
vec3 textured_albedo() {
  vec3 albedo = in_albedo_cutoff.rgb;
  if (kTextured == 0) return albedo;
  vec2 uv = in_uv_occlusion_roughness.xy, uv_x = dFdx(uv), uv_y = dFdy(uv);
  vec4 texel = texture(base_color, uv);
  if (in_albedo_cutoff.w > 0.0 && mask_alpha(uv, uv_x, uv_y, texel.a) < in_albedo_cutoff.w) discard;
  return view.debug_view == 0 ? albedo * texel.rgb : albedo;
}

#ifndef COPPICE_DEPTH
#include "surface.glsl"

SurfacePlace surface_place() {
  vec2 pixel = gl_FragCoord.xy - vec2(view.eyes[push.eye].first_px);
  uvec4 names = needs_names() ? instance_texel(in_ids.x, 3) : uvec4(0);
  return SurfacePlace(in_world_sun.xyz, names.z, pixel, in_before, (in_ids.w & kHasCome) != 0, names.x & kNoPlant, kLeaf == 0);
}

// The surface from the vertex shader.
CoppiceSurface surface_here(vec3 albedo) {
  vec3 normal = normalize(in_normal_along.xyz);
  float sided = in_normal_along.w > 1.5 ? 1.0 : 0.0;
  bool turned = kLeaf == 0 ? !is_front() : sided == 0.0 && dot(normal, toward_eye(in_world_sun.xyz)) < 0.0;
  return CoppiceSurface(albedo, in_uv_occlusion_roughness.z, turned ? -normal : normal, in_uv_occlusion_roughness.w,
                        in_normal_along.w - 2.0 * sided, kLeaf != 0 ? kLeafTranslucency : 0.0, in_world_sun.w, sided);
}
#endif
