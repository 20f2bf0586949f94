#version 460
#extension GL_GOOGLE_include_directive : require

// What the compute rasteriser has drawn, as colour and depth of the engine's attachments.
// reads     picture, view
// writes    colour, linear, but with COPPICE_DEPTH; depth
// draws     one triangle, recorded by coppice::gpu::LeafRaster::record_resolve

#include "bindings.glsl"
#include "debug_view.glsl"
#include "raster_shared.h"
#include "radiance.glsl"

layout(set = 1, binding = 9) uniform usamplerBuffer picture_words;
layout(push_constant, scalar) uniform Push { RasterPush push; };

#ifndef COPPICE_DEPTH
layout(location = 0) out vec4 out_color;
#endif

void main() {
  uvec2 at = uvec2(gl_FragCoord.xy) - view.eyes[push.eye].first_px;
  int word = int(2 * ((push.eye * push.height_px + at.y) * push.width_px + at.x));
  uint key = texelFetch(picture_words, word + 1).x;
  if (key == 0) discard;
#ifndef COPPICE_DEPTH
  uint radiance = texelFetch(picture_words, word).x;
  out_color = vec4(unpack_radiance(radiance), 1.0);
  if (view.debug_view == kDebugOverdraw) out_color.rgb = ramp(log2(float(radiance)) / 5.0);
#endif
  float depth = uintBitsToFloat(key);
  gl_FragDepth = push.reversed != 0 ? depth : 1.0 - depth;
}
