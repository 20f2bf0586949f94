// Says what a view of COPPICE_OUTPUT_SURFACE writes into an engine's attachments, reads it back, and lights it as Coppice does. Coppice's
// own shaders include this file, so a host that lights with coppice_lit starts from the same picture.
//
// An attachment's content is one of coppice_content (coppice/vulkan.h); numbers are as the format holds them, normals are in world space:
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

// Describes a point of a plant's surface. Directions are unit, world space.
struct CoppiceSurface {
  vec3 albedo;         // linear; above 1 where a merged leaf stands for bright ones
  float occlusion;     // 0..1: the share of light from sky and ground that arrives; sunlight does not depend on it
  vec3 normal;         // the shading normal, on the visible side
  float roughness;     // glTF's: alpha is its square
  float roundness;     // 0: a flat surface; 1: a whole crown, which is lit all round
  float translucency;  // the share of the sun on its back that shines through; 0 for wood
  float sun;           // 0..1: the share of the sun that gets past the plant's own crown and the shadow maps of coppice_light
  vec3 face;           // the leaf's own normal, towards the eye; `normal` is turned towards that of the crown
};

// Maps a unit vector to a point in the unit square, and back.
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

// Reads a surface from the three attachments, as sampled.
CoppiceSurface coppice_surface(vec4 albedo, vec4 normal, vec4 light) {
  return CoppiceSurface(albedo.rgb, albedo.a, coppice_unfold(normal.xy), normal.z, normal.w, light.x, light.y, coppice_unfold(light.zw));
}

// The fields mean the same as those of coppice_light.
struct CoppiceLight {
  vec3 sun_direction;  // unit, towards the sun
  vec3 sun_color, sky_color, ground_color;
};

// Mean brightness of the visible side of a ball of leaves that turn outwards, relative to a surface that faces the sun. cosine: of the
// angle between eye and sun. The first term is close to Lambert's phase law, 0.85 (sin a + (pi - a) cos a) / pi.
float coppice_ball(float cosine) {
  float lit = 0.5 + 0.5 * cosine;
  return 0.53 * lit * sqrt(lit) + 0.15;
}

// Returns the radiance towards the eye, before fog. There is no division by pi: a white surface that faces the sun is as bright as
// sun_color.
// eye: unit, towards the eye
vec3 coppice_lit(CoppiceSurface s, vec3 eye, CoppiceLight light) {
  float flatness = 1.0 - s.roundness;
  // Light spreads inside a leaf, so its terminator is soft.
  float wrap = 0.45 * s.translucency;
  float front = max(0.0, wrap + (1.0 - wrap) * dot(s.normal, light.sun_direction));
  front = mix(front, coppice_ball(dot(eye, light.sun_direction)), s.roundness);
  // Light that shines through is yellower.
  float through = s.translucency * flatness * max(0.0, -dot(s.face, light.sun_direction));
  vec3 sun = light.sun_color * s.sun * (front + through * vec3(1.0, 1.15, 0.35));
  float up = mix(s.normal.y, 0.67 * eye.y, s.roundness);
  return s.albedo * (sun + mix(light.ground_color, light.sky_color, 0.5 + 0.5 * up) * s.occlusion);
}

#endif
