#version 460
// Temporal antialiasing. Every frame is drawn moved by part of a pixel; here it is blended into the mean of the frames before it, which is
// looked up where this pixel's surface was then, and drawn towards the colours around the pixel where it shows what is no longer there.
// Reads toned and depth texel by texel, history filtered; writes the new history and the picture. Recorded by record_temporal.

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_history;
layout(location = 1) out vec4 out_picture;

layout(set = 0, binding = 0) uniform sampler2D toned;
layout(set = 0, binding = 1) uniform sampler2D depth;
layout(set = 0, binding = 2) uniform sampler2D history;

layout(push_constant) uniform Push {
  mat4 before_from_clip;  // clip space of the frame before, not moved, from this frame's, moved
  vec2 moved_by;          // by how much this frame was moved, clip space
  float newest;           // weight of this frame
  float spread;           // standard deviations about the mean of a pixel's surroundings that history may differ by
} push;

void main() {
  ivec2 last = textureSize(toned, 0) - 1;
  ivec2 at = min(ivec2(gl_FragCoord.xy), last);  // a quad at the far edge may reach beyond it
  vec3 now = texelFetch(toned, at, 0).rgb;
  vec3 sum = now, squares = now * now;
  // Of the four neighbours two are in the same quad of fragments, whose differences are there without looking.
  ivec2 outwards = 2 * (at & 1) - 1;
  vec3 nears[4] = {now - float(outwards.x) * dFdxFine(now), now - float(outwards.y) * dFdyFine(now),
                   texelFetch(toned, clamp(at + ivec2(outwards.x, 0), ivec2(0), last), 0).rgb,
                   texelFetch(toned, clamp(at + ivec2(0, outwards.y), ivec2(0), last), 0).rgb};
  for (int i = 0; i < 4; ++i) {
    sum += nears[i];
    squares += nears[i] * nears[i];
  }
  vec3 middle = sum / 5.0;
  vec3 reach = push.spread * sqrt(max(squares / 5.0 - middle * middle, vec3(0.0)));

  vec4 before = push.before_from_clip * vec4(clip, texelFetch(depth, at, 0).x, 1.0);
  vec2 was = before.xy / before.w + push.moved_by;
  vec3 past = clamp(texture(history, 0.5 * was + 0.5).rgb, middle - reach, middle + reach);
  bool seen = all(lessThan(abs(was), vec2(1.0))) && push.newest < 1.0;  // else the history may hold anything
  vec3 mean = seen ? mix(past, now, push.newest) : now;
  out_history = vec4(mean, 1.0);
  out_picture = vec4(mean, 1.0);
}
