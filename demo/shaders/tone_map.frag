#version 460
// Linear radiance to display values: exposure, a filmic curve, sRGB encoding, and half a step of noise against banding.
// Reads scene_color texel by texel; writes an UNORM target that holds sRGB-encoded values. Recorded by record_tone_map.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_color;

// Shoulder and toe of a film: about linear in the middle, contrast in the darks, highlights that never clip hard. Narkowicz's fit of the
// ACES curve and sRGB's encoding in one ratio of polynomials in the root, within 0.9 of 255 of both: three powers would be half of the
// pass on a software driver.
vec3 displayed(vec3 x) {
  vec3 root = sqrt(x);
  return clamp(root * (5.94607 * root - 0.10405) / (root * (5.96129 * root - 0.52916) + 1.0), 0.0, 1.0);
}

uint mixed(uvec2 pixel) {
  uint h = pixel.x * 0x9e3779b1u ^ pixel.y * 0x85ebca77u;
  h = (h ^ h >> 16) * 0x7feb352du;
  return h ^ h >> 15;
}

void main() {
  vec3 color = texelFetch(scene_color, ivec2(gl_FragCoord.xy), 0).rgb * frame.ground.y;
  float noise = float(mixed(uvec2(gl_FragCoord.xy)) >> 8) / 16777216.0 - 0.5;
  out_color = vec4(displayed(color) + noise / 255.0, 1);
}
