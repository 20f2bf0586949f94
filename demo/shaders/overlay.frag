#version 460
// ImGui's colour times its font texture; the target holds encoded values already, as ImGui's colours do. Recorded by record_overlay.

layout(set = 0, binding = 0) uniform sampler2D font;
layout(location = 0) in vec2 uv;
layout(location = 1) in vec4 color;
layout(location = 0) out vec4 out_color;

void main() {
  out_color = color * texture(font, uv);
}
