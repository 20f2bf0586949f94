#version 460
// A small picture on a larger one. Between texels it goes along a smooth step, not a line: near a texel's middle that is the texel, as with
// a bicubic filter, for the price of one look. Reads blended; recorded by record_enlarge.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_color;

void main() {
  vec2 size_px = frame.ground.zw;
  vec2 at = (0.5 + 0.5 * clip) * size_px - 0.5;
  vec2 between = fract(at);
  vec2 place = floor(at) + between * between * (3.0 - 2.0 * between) + 0.5;
  out_color = texture(blended, clamp(place, vec2(0.5), size_px - 0.5) / vec2(textureSize(blended, 0)));
}
