#version 460
layout(location = 0) out vec4 color;
layout(push_constant) uniform Push { uint words[8]; } push;
void main() {
  if (push.words[0] != 0 && (uint(gl_FragCoord.x) & 1u) == 0) discard;
  color = vec4(0.0, 1.0, 0.0, 1.0);
  gl_FragDepth = 0.75;
}
