#version 460
#extension GL_EXT_buffer_reference : require
// Reads the mask: one byte a texel, rows top to bottom, not 0 for a hole; nearest texel, repeating. size 0: no holes.
// Writes nothing; discards holes. Recorded by occlusion_areas() in support/occlusion_areas.cpp.
layout(location = 0) in vec2 uv;

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Holes { uint words[]; };
layout(push_constant) uniform Push {
  mat4 clip_from_object;
  Holes holes;
  uvec2 size;
};

void main() {
  if (size.x == 0) return;
  uvec2 texel = min(uvec2(fract(uv) * vec2(size)), size - 1u);
  uint index = texel.y * size.x + texel.x;
  if ((holes.words[index / 4u] >> (8u * (index % 4u)) & 255u) != 0u) discard;
}
