#version 460
// Grass near the eye: one instance a tuft, three vertices a blade, lit like the ground it stands on and from behind. Light is linear along
// a blade, so that its vertices' is enough; only shadow maps are looked up in the fragment shader, since some software drivers compile a
// vertex shader that samples anew in every frame. Reads tufts; writes blade vertices. Recorded by record_tufts.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec4 in_root;   // xyz world position, w height in m
layout(location = 1) in vec4 in_style;  // x yaw, y tone 0..1, z sunlight let through, w open sky
layout(location = 0) out vec3 shaded;  // light of the sky, and fog
layout(location = 1) out vec3 sunlit;  // light of the sun, where it gets here
layout(location = 3) out vec3 now;  // clip x, y and w
layout(location = 4) out vec3 before;  // likewise, in the frame before
layout(location = 2) flat out vec4 open;  // xyz where the tuft sees the sun from, w share of it without maps

const float kGolden = 2.399963;

// How far a blade's tip is moved, in its heights: it bows with the gust that plants bend by, and trembles.
vec3 sway(vec4 gusts[4], float time_s, int blade) {
  float gust = 0.0;
  for (int i = 1; i < 4; ++i) gust += gusts[i].w * sin(gusts[i].x * in_root.x + gusts[i].y * in_root.z + gusts[i].z);
  float load = gusts[0].z * (1.0 - gusts[0].w * (0.5 - 0.5 * gust));
  float tremble = sin(9.0 * time_s + 7.0 * in_style.y + 2.1 * float(blade));
  return load * vec3(gusts[0].x, -0.35 * load, gusts[0].y) * (0.8 + 0.15 * tremble);
}

void main() {
  int blade = gl_VertexIndex / 3;
  int corner = gl_VertexIndex % 3;
  float turn = in_style.x + kGolden * float(blade);
  float height = in_root.w * (0.65 + 0.35 * fract(in_style.y * 7.0 + 0.618 * float(blade)));
  vec3 lean = vec3(cos(turn), 0, sin(turn));
  vec3 side = vec3(-lean.z, 0, lean.x) * (0.006 + 0.035 * height);
  vec3 root = in_root.xyz + 0.05 * lean;
  float along = corner == 2 ? 1.0 : 0.0;  // 0 at the root, 1 at the tip
  vec3 still = corner == 2 ? root + vec3(0, height, 0) + 0.45 * height * lean : root + (corner == 0 ? side : -side);
  vec3 world_position = still + along * height * sway(frame.gusts, frame.eye.w, blade);
  vec3 albedo = mix(vec3(0.062, 0.112, 0.022), vec3(0.150, 0.146, 0.050), in_style.y * in_style.y);
  float sky = (0.25 + 0.75 * along) * (0.35 + 0.65 * in_style.w);
  float clear = transmittance(world_position);
  shaded = (1.0 - clear) * air(normalize(world_position - frame.eye.xyz)) + clear * albedo * ambient(vec3(0, 1, 0)) * sky;
  sunlit = clear * albedo * frame.sun_color.rgb * (0.62 * frame.sun_direction.y * (0.25 + 0.75 * along));
  open = vec4(in_root.xyz + vec3(0, height, 0), in_style.z);
  gl_Position = frame.clip_from_world * vec4(world_position, 1);
  now = gl_Position.xyw;
  before = (frame.clip_from_world_before * vec4(still + along * height * sway(frame.gusts_before, frame.sun_direction.w, blade), 1)).xyw;
}
