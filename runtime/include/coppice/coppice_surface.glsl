// What a view of COPPICE_OUTPUT_SURFACE writes into an engine's attachments, how to read it back, and the light that Coppice gives it
// itself. Coppice's own shaders include this file: a host that lights by coppice_lit starts from the same picture.
//
// An attachment's content is one of coppice_content (coppice/vulkan.h); numbers are as the format holds them, normals in world space:
//
//   content   x, y                              z                    w
//   ALBEDO    red, green                        blue                 occlusion: the share of sky light that arrives
//   NORMAL    octahedral normal, 0..1           roughness            roundness
//   LIGHT     translucency, sun                 octahedral face, 0..1 (z and w)
//   USER      coppice_placement.user_data, a byte each, lowest first, 1.0 is 255
//   VELOCITY  px since the frame before, x, y   1: came this frame   0
//
// Requires GLSL 4.5, or 3.1 ES and later.

#ifndef COPPICE_SURFACE_GLSL
#define COPPICE_SURFACE_GLSL

// A place of a plant's surface. Directions are unit, world space.
struct CoppiceSurface {
  vec3 albedo;         // linear; a merged leaf that stands for bright ones may be above 1
  float occlusion;     // 0..1: the share of the light of the sky, and of the ground, that arrives; the sun's does not depend on it
  vec3 normal;         // the one to light it with, of the side that is seen
  float roughness;     // glTF's: alpha is its square
  float roundness;     // 0: as flat as it is; 1: it stands for a whole crown, which the eye sees lit all round
  float translucency;  // the share of the sun on its back that shines through: 0 of wood
  float sun;           // 0..1: the share of the sun that gets past the plant's own crown, and past the shadow maps of coppice_light
  vec3 face;           // a leaf's own normal, towards the eye; `normal` of a leaf is turned towards its crown's
};

// A unit vector's place in a square of 0..1, and the inverse.
vec2 coppice_octahedral(vec3 n) {
  vec2 e = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
  if (n.z < 0.0) e = (1.0 - abs(e.yx)) * vec2(e.x >= 0.0 ? 1.0 : -1.0, e.y >= 0.0 ? 1.0 : -1.0);
  return 0.5 + 0.5 * e;
}
vec3 coppice_unfold(vec2 stored) {
  vec2 e = 2.0 * stored - 1.0;
  vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
  float fold = max(-n.z, 0.0);
  n.xy -= vec2(n.x >= 0.0 ? fold : -fold, n.y >= 0.0 ? fold : -fold);
  return normalize(n);
}

vec4 coppice_albedo_content(CoppiceSurface s) { return vec4(s.albedo, s.occlusion); }
vec4 coppice_normal_content(CoppiceSurface s) { return vec4(coppice_octahedral(s.normal), s.roughness, s.roundness); }
vec4 coppice_light_content(CoppiceSurface s) { return vec4(s.translucency, s.sun, coppice_octahedral(s.face)); }

// From the three attachments, as sampled.
CoppiceSurface coppice_surface(vec4 albedo, vec4 normal, vec4 light) {
  return CoppiceSurface(albedo.rgb, albedo.a, coppice_unfold(normal.xy), normal.z, normal.w, light.x, light.y, coppice_unfold(light.zw));
}

// As coppice_light has them.
struct CoppiceLight {
  vec3 sun_direction;  // unit, towards the sun
  vec3 sun_color, sky_color, ground_color;
};

// How bright a ball of leaves that turn outwards is, all of it that the eye sees, in parts of a surface that faces the sun. cosine: of the
// angle between eye and sun. Its first term is close to Lambert's phase law, 0.85 (sin a + (pi - a) cos a) / pi.
float coppice_ball(float cosine) {
  float lit = 0.5 + 0.5 * cosine;
  return 0.53 * lit * sqrt(lit) + 0.15;
}

// Radiance towards the eye, before fog. No division by pi: a white surface that faces the sun is as bright as sun_color.
// eye: unit, towards it
vec3 coppice_lit(CoppiceSurface s, vec3 eye, CoppiceLight light) {
  float flatness = 1.0 - s.roundness;
  // Light wanders through a leaf, so that its terminator is soft.
  float wrap = 0.45 * s.translucency;
  float front = max(0.0, wrap + (1.0 - wrap) * dot(s.normal, light.sun_direction));
  front = mix(front, coppice_ball(dot(eye, light.sun_direction)), s.roundness);
  // What shines through is yellower.
  float through = s.translucency * flatness * max(0.0, -dot(s.face, light.sun_direction));
  vec3 sun = light.sun_color * s.sun * (front + through * vec3(1.0, 1.15, 0.35));
  float up = mix(s.normal.y, 0.67 * eye.y, s.roundness);
  return s.albedo * (sun + mix(light.ground_color, light.sky_color, 0.5 + 0.5 * up) * s.occlusion);
}

#endif
