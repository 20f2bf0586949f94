#version 460
// A blade of grass: the colour its vertices were lit with; writes linear radiance. Recorded by record_tufts.

layout(location = 0) in vec3 color;
layout(location = 0) out vec4 out_color;

void main() {
  out_color = vec4(color, 1);
}
