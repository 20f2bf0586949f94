#version 460
// Linear radiance to display values: exposure, a filmic curve, sRGB encoding, and half a step of noise against banding.
// Reads scene_color texel by texel; writes an UNORM target that holds sRGB-encoded values. Recorded by record_tone_map.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_color;

// Shoulder and toe of a film: about linear in the middle, contrast in the darks, highlights that never clip hard.
vec3 film(vec3 x) {
  return clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 encode_srgb(vec3 x) {
  return mix(12.92 * x, 1.055 * pow(max(x, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}

uint mixed(uvec2 pixel) {
  uint h = pixel.x * 0x9e3779b1u ^ pixel.y * 0x85ebca77u;
  h = (h ^ h >> 16) * 0x7feb352du;
  return h ^ h >> 15;
}

void main() {
  vec3 color = texelFetch(scene_color, ivec2(gl_FragCoord.xy), 0).rgb * frame.ground.y;
  float noise = float(mixed(uvec2(gl_FragCoord.xy)) >> 8) / 16777216.0 - 0.5;
  out_color = vec4(encode_srgb(film(color)) + noise / 255.0, 1);
}
