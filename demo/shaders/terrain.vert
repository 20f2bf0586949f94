#version 460
// Reads the ground's vertices; writes position and normal in world space. Recorded by record_ground in renderer.cpp.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in float in_foot;
layout(location = 0) out vec3 world_position;
layout(location = 1) out vec3 world_normal;
layout(location = 2) out float foot;

void main() {
  world_position = in_position;
  world_normal = in_normal;
  foot = in_foot;
  gl_Position = frame.clip_from_world * vec4(in_position, 1);
}
