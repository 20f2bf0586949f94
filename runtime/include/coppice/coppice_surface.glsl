// Says what a view of COPPICE_OUTPUT_SURFACE writes into an engine's attachments, reads it back, and lights it as Coppice does. Coppice's
// own shaders include this file, so a host that lights with coppice_lit starts from the same picture.
//
// An attachment's content is one of coppice_content (coppice/vulkan.h); numbers are as the format holds them, normals are in world space:
//
//   content   x, y                              z                    w
//   ALBEDO    red, green                        blue                 occlusion: the share of sky light that arrives
//   NORMAL    octahedral normal, 0..1           roughness            along
//   LIGHT     translucency, sun                 sided                0
//   USER      coppice_placement.user_data, a byte each, lowest first, 1.0 is 255
//   VELOCITY  px since the frame before, x, y   1: came this frame   0
//
// An engine that lights surfaces itself calls coppice_leaf_light for each of its lights in place of max(0, dot(normal, light)): x is that
// cosine for the visible side, y for the light that shines through. For wood, and for one leaf, both are Lambert's cosines.
//
// Requires GLSL 4.5, or 3.1 ES and later with highp floats. The functions up to coppice_leaf_light compile as C++, too, where vec2, vec3, dot,
// sqrt, max and clamp are in scope.

#ifndef COPPICE_SURFACE_GLSL
#define COPPICE_SURFACE_GLSL

#ifdef __cplusplus
#define COPPICE_SURFACE_FUNCTION inline
#else
#define COPPICE_SURFACE_FUNCTION
#endif

// The leaves that a surface stands for have normals n whose second moment is M = along a a^T + (1 - along) / 2 (I - a a^T), where a is the
// axis. Light and eye come from the unit directions s and v. Means are by the area that the eye sees. All is exact for one flat leaf, and
// near to it for leaves of all directions and for leaves about a twig.
//
// axis: unit; along: 0..1; eye, light: unit, towards them; sided: 1 if the axis, not the eye, decides which side is the front, else 0

// 0 for leaves of all directions, 1 for a flat leaf: (3 tr(M M) - 1) / 2.
COPPICE_SURFACE_FUNCTION float coppice_flatness(float along) {
  float across = 0.5f * (1.0f - along);
  return 1.5f * (along * along + 2.0f * across * across) - 0.5f;
}

// The mean normal of the visible sides, Mv / sqrt(v.Mv) times a factor; of sided leaves that of their fronts.
COPPICE_SURFACE_FUNCTION vec3 coppice_mean_normal(vec3 axis, float along, vec3 eye, float sided) {
  float across = 0.5f * (1.0f - along), bend = along - across, axis_eye = dot(axis, eye);
  float seen = sqrt(max(across + bend * axis_eye * axis_eye, 1e-12f));
  vec3 visible = (across * eye + bend * axis_eye * axis) / ((0.866f + 0.134f * coppice_flatness(along)) * seen);
  return visible + sided * (sqrt(along) * axis - visible);
}

// Mean cosines of the light. x: on the visible sides, or on the fronts; y: on the others. Their sum is the mean of |n.s|, about
// sqrt(s.Ms) (1 + r^2 / 2 + 0.07 r^4) times a factor with r = s.Mv / sqrt(s.Ms v.Mv); their difference that of n.s.
COPPICE_SURFACE_FUNCTION vec2 coppice_leaf_light(vec3 axis, float along, vec3 light, vec3 eye, float sided) {
  float across = 0.5f * (1.0f - along), bend = along - across;
  float axis_light = dot(axis, light), axis_eye = dot(axis, eye);
  float lit = sqrt(max(across + bend * axis_light * axis_light, 0.0f));
  float seen = sqrt(max(across + bend * axis_eye * axis_eye, 1e-12f));
  float r = clamp((across * dot(light, eye) + bend * axis_light * axis_eye) / max(lit * seen, 1e-6f), -1.0f, 1.0f);
  float sum = (0.735f - 0.098f * coppice_flatness(along)) * lit * (1.0f + r * r * (0.5f + 0.0708f * r * r));
  float difference = clamp(dot(coppice_mean_normal(axis, along, eye, sided), light), -sum, sum);
  return vec2(0.5f * (sum + difference), 0.5f * (sum - difference));
}

#ifndef __cplusplus

// Describes a point of a plant's surface. Directions are unit, world space.
struct CoppiceSurface {
  vec3 albedo;         // linear
  float occlusion;     // 0..1: the share of light from sky and ground that arrives; sunlight does not depend on it
  vec3 normal;         // on the visible side, or on the front of a sided leaf; of leaves that stand for many the axis of their normals
  float roughness;     // glTF's: alpha is its square
  float along;         // how far the normals of the leaves that it stands for lie along `normal`: 1 for one surface, 1/3 for all directions
  float translucency;  // the share of the sun on its back that shines through; 0 for wood
  float sun;           // 0..1: the share of the sun that gets past the plant's own crown and the shadow maps of coppice_light
  float sided;         // 1: `normal` says which side is lit, whoever looks: wood's, and an artist's of a leaf; 0: the visible side is
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
vec4 coppice_normal_content(CoppiceSurface s) { return vec4(coppice_octahedral(s.normal), s.roughness, s.along); }
vec4 coppice_light_content(CoppiceSurface s) { return vec4(s.translucency, s.sun, s.sided, 0.0); }

// Reads a surface from the three attachments, as sampled.
CoppiceSurface coppice_surface(vec4 albedo, vec4 normal, vec4 light) {
  return CoppiceSurface(albedo.rgb, albedo.a, coppice_unfold(normal.xy), normal.z, normal.w, light.x, light.y, light.z);
}

// The fields mean the same as those of coppice_light.
struct CoppiceLight {
  vec3 sun_direction;  // unit, towards the sun
  vec3 sun_color, sky_color, ground_color;
};

// Returns the radiance towards the eye, before fog. There is no division by pi: a white surface that faces the sun is as bright as
// sun_color.
// eye: unit, towards the eye
vec3 coppice_lit(CoppiceSurface s, vec3 eye, CoppiceLight light) {
  vec2 from_sun = coppice_leaf_light(s.normal, s.along, light.sun_direction, eye, s.sided);
  // Light that shines through is yellower.
  vec3 sun = light.sun_color * s.sun * (from_sun.x + s.translucency * from_sun.y * vec3(1.0, 1.15, 0.35));
  float up = coppice_mean_normal(s.normal, s.along, eye, s.sided).y;
  return s.albedo * (sun + mix(light.ground_color, light.sky_color, 0.5 + 0.5 * up) * s.occlusion);
}
#endif

#endif
