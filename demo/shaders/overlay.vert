#version 460
// ImGui's vertices in pixels to clip space. Recorded by record_overlay in overlay.cpp.

layout(push_constant) uniform Push {
  vec2 scale;
  vec2 offset;
};
layout(location = 0) in vec2 in_position;
layout(location = 1) in vec2 in_uv;
layout(location = 2) in vec4 in_color;
layout(location = 0) out vec2 uv;
layout(location = 1) out vec4 color;

void main() {
  uv = in_uv;
  color = in_color;
  gl_Position = vec4(in_position * scale + offset, 0, 1);
}
