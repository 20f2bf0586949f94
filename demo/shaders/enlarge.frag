#version 460
// A small picture on a larger one. Between texels it goes along a smooth step, not a line: near a texel's middle that is the texel, as with
// a bicubic filter, for the price of one look. Reads toned; recorded by record_enlarge.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_color;

void main() {
  vec2 size = vec2(textureSize(toned, 0));
  vec2 at = (0.5 + 0.5 * clip) * size - 0.5;
  vec2 between = fract(at);
  out_color = texture(toned, (floor(at) + between * between * (3.0 - 2.0 * between) + 0.5) / size);
}
