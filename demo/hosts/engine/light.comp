#version 460
// The engine's light and temporal antialiasing of a view, recorded by light(). Reads what render() has drawn; writes history and picture. A
// group lights its 8 x 8 pixels and those about them, which bound what the history may show.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
#include "coppice_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D from[8];
const int kDepth = 0, kAlbedo = 1, kNormal = 2, kLight = 3, kVelocity = 5, kShadowMap = 6, kPast = 7;
layout(binding = 1, rgba16f) uniform writeonly image2D next;
layout(buffer_reference, scalar) writeonly buffer Picture { uint pixels[]; };
layout(push_constant, scalar) uniform Constants {  // LightConstants
  mat3 ray_from_clip;
  mat4x3 shadow_from_eye;
  vec3 sun_direction;
  float eye_height_m;
  vec2 jitter_px;
  float newest;
  Picture picture;
};
const vec3 kSun = vec3(3.0, 2.8, 2.4), kSky = vec3(0.45, 0.62, 0.85), kGround = vec3(0.12, 0.13, 0.05);
shared vec3 lit[10][10];

// Even ground at height 0, in the shadow of what the sun's view shows, and the sky.
vec3 light_behind_plants(vec3 ray) {
  vec3 sky = mix(vec3(0.8), kSky, clamp(2.0 * ray.y, 0.0, 1.0)), place = ray * (eye_height_m / max(-ray.y, 1e-6));
  vec3 clip = shadow_from_eye * vec4(place, 1.0);
  ivec2 texel = ivec2((0.5 * clip.xy + 0.5) * vec2(textureSize(from[kShadowMap], 0)));
  bool is_shaded = all(lessThan(abs(clip.xy), vec2(1.0))) && texelFetch(from[kShadowMap], texel, 0).x > clip.z;  // depth is reversed
  return mix(sky, kGround * (is_shaded ? kSky : kSun + kSky), ray.y < 0.0 ? exp(-0.002 * length(place)) : 0.0);
}

vec3 light_at(ivec2 at, ivec2 size) {
  vec3 ray = normalize(ray_from_clip * vec3(2.0 * (vec2(at) + 0.5) / vec2(size) - 1.0, 1.0));
  if (texelFetch(from[kDepth], at, 0).x == 0.0) return light_behind_plants(ray);
  CoppiceSurface s =
      coppice_surface(texelFetch(from[kAlbedo], at, 0), texelFetch(from[kNormal], at, 0), texelFetch(from[kLight], at, 0));
  // What an engine's own light takes in place of Lambert's cosine: x is that of the visible side, y shines through.
  vec2 cosines = coppice_leaf_light(s.normal, s.along, sun_direction, -ray, s.sided);
  vec3 around = mix(kGround, kSky, 0.5 + 0.5 * coppice_mean_normal(s.normal, s.along, -ray, s.sided).y);
  return s.albedo * (kSun * s.sun * (cosines.x + s.translucency * cosines.y) + around * s.occlusion);
}

void main() {
  ivec2 size = imageSize(next), corner = 8 * ivec2(gl_WorkGroupID.xy) - 1, at = ivec2(gl_GlobalInvocationID.xy), own = at - corner;
  for (uint i = gl_LocalInvocationIndex; i < 100; i += 64)
    lit[i / 10][i % 10] = light_at(clamp(corner + ivec2(i % 10, i / 10), ivec2(0), size - 1), size);
  barrier();
  if (any(greaterThanEqual(at, size))) return;
  vec3 color = lit[own.y][own.x], least = color, most = color;
  for (int i = 0; i < 9; ++i) {
    least = min(least, lit[own.y + i / 3 - 1][own.x + i % 3 - 1]);
    most = max(most, lit[own.y + i / 3 - 1][own.x + i % 3 - 1]);
  }
  vec2 was = (vec2(at) + 0.5 - texelFetch(from[kVelocity], at, 0).xy + jitter_px) / vec2(size);
  if (newest < 1.0 && was == clamp(was, 0.0, 1.0))  // else the history may hold anything
    color = mix(clamp(textureLod(from[kPast], was, 0.0).rgb, least, most), color, newest);
  imageStore(next, at, vec4(color, 1.0));
  picture.pixels[at.y * size.x + at.x] = packUnorm4x8(vec4(pow(color / (1.0 + color), vec3(1.0 / 2.2)), 1.0));
}
