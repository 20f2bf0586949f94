#version 460
#extension GL_EXT_buffer_reference : require
// Reads position, uv. Writes depth only. Recorded by occlusion_areas() in support/occlusion_areas.cpp, one draw per leaf.
// The same triangles are drawn twice and compared for equal depth: both pipelines are made from the same modules.
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 0) out vec2 out_uv;

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Holes { uint words[]; };
layout(push_constant) uniform Push {
  mat4 clip_from_object;
  Holes holes;
  uvec2 size;
};

void main() {
  gl_Position = clip_from_object * vec4(position, 1.0);
  out_uv = uv;
}
