#version 460
// One triangle over the whole picture, at the far plane of reversed depth; three vertices, no buffers.

layout(location = 0) out vec2 clip;

void main() {
  clip = vec2(gl_VertexIndex == 1 ? 3 : -1, gl_VertexIndex == 2 ? 3 : -1);
  gl_Position = vec4(clip, 0, 1);
}
