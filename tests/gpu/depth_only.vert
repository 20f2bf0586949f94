#version 460
// Reads position; writes nothing but depth. Recorded by occlusion_areas() in support/occlusion_areas.cpp, one draw per leaf.
// The same triangles are drawn twice and compared for equal depth: both pipelines are made from this one module.
layout(location = 0) in vec3 position;
layout(push_constant) uniform Push { mat4 clip_from_object; };

void main() { gl_Position = clip_from_object * vec4(position, 1.0); }
