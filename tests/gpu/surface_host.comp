#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// An engine's lighting pass over a view of COPPICE_OUTPUT_SURFACE: what surface_test.cpp lights its attachments with.
// reads     albedo, normal and light attachments, depth; frame
// writes    radiance, linear; 0 where nothing is
// dispatch  an invocation a pixel

#include "coppice_surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D albedos;
layout(set = 0, binding = 1) uniform sampler2D normals;
layout(set = 0, binding = 2) uniform sampler2D lights;
layout(set = 0, binding = 3) uniform sampler2D depths;
layout(set = 0, binding = 4, scalar) readonly buffer Frame {
  mat4 from_eye;  // it takes (x, y, depth, 1) in clip space by w to what is seen from the eye, world axes
  CoppiceLight light;
} frame;
layout(set = 0, binding = 5, scalar) writeonly buffer Radiance { vec4 radiance[]; };

void main() {
  ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = textureSize(depths, 0);
  if (any(greaterThanEqual(at, size))) return;
  float depth = texelFetch(depths, at, 0).x;
  vec4 place = frame.from_eye * vec4((vec2(at) + 0.5) / vec2(size) * 2.0 - 1.0, depth, 1.0);
  CoppiceSurface surface = coppice_surface(texelFetch(albedos, at, 0), texelFetch(normals, at, 0), texelFetch(lights, at, 0));
  vec3 lit = coppice_lit(surface, normalize(-place.xyz / place.w), frame.light);
  radiance[at.y * size.x + at.x] = depth > 0.0 ? vec4(lit, 1.0) : vec4(0.0);
}
