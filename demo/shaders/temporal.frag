#version 460
// Temporal antialiasing. Every frame is drawn moved by part of a pixel; here it is blended into the mean of the frames before it, which is
// looked up where this pixel's surface was then, and drawn towards the colours around the pixel where it shows what is no longer there. The
// history's alpha is the mean of its squared brightness.
// Frames that are smaller than the picture have one sample for several pixels: it counts for each by how near to its middle it lies.
// Reads toned, depth and velocity texel by texel, history filtered; writes the new history and the picture. Recorded by record_temporal.

layout(location = 0) in vec2 clip;
layout(location = 0) out vec4 out_history;
layout(location = 1) out vec4 out_picture;

layout(set = 0, binding = 0) uniform sampler2D toned;
layout(set = 0, binding = 1) uniform sampler2D depth;
layout(set = 0, binding = 2) uniform sampler2D history;
layout(set = 0, binding = 3) uniform sampler2D velocity;

layout(push_constant) uniform Push {
  mat4 before_from_clip;  // clip space of the frame before, not moved, from this frame's, moved
  vec2 moved_by, moved_by_before;  // by how much this frame was moved, and the one before, clip space
  vec2 drawn_px;          // what of toned and depth this frame is, from the first texel on
  vec2 blends_px;         // what of the new history and the picture is written
  vec2 past_px;           // what of history was
  float newest;           // weight of this frame
  float spread;           // standard deviations about the mean of a pixel's surroundings that history may differ by
} push;

// Bits: 1, frames are smaller than the picture; 2, the history is looked up sharply, which costs a software driver more than it is worth;
// 4, there is velocity.
layout(constant_id = 0) const uint kHow = 0;
const bool kEnlarges = (kHow & 1u) != 0, kSharp = (kHow & 2u) != 0, kHasVelocity = (kHow & 4u) != 0;
// About a sample that lies this far from a pixel's middle, picture's px, says little of it.
const float kReach_px = 0.5;

struct Sampled {
  ivec2 at;      // texel of the frame
  vec2 clip;     // where, in the frame's clip space
  float weight;  // weight for this pixel: 1 is the mean
};

// The frame's sample that is nearest to the pixel.
Sampled nearest_sample() {
  vec2 size = push.drawn_px;
  if (!kEnlarges) return Sampled(min(ivec2(gl_FragCoord.xy), ivec2(size) - 1), clip, 1.0);  // a quad at the far edge may reach beyond it
  vec2 place = (0.5 + 0.5 * (clip + push.moved_by)) * size;
  ivec2 at = clamp(ivec2(place), ivec2(0), ivec2(size) - 1);
  vec2 pixels = push.blends_px / size;  // pixels of the picture per sample
  vec2 away_px = (vec2(at) + 0.5 - place) * pixels;
  float weight = pixels.x * pixels.y * exp(-0.5 * dot(away_px, away_px) / (kReach_px * kReach_px));
  return Sampled(at, 2.0 * (vec2(at) + 0.5) / size - 1.0, weight);
}

vec3 toned_at(ivec2 at) { return texelFetch(toned, clamp(at, ivec2(0), ivec2(push.drawn_px) - 1), 0).rgb; }

// Catmull and Rom's filter, without its corners: what is looked up between texels frame after frame stays sharp.
vec4 history_at(vec2 place_px) {
  vec2 middle = floor(place_px - 0.5) + 0.5, f = place_px - middle;
  vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f)), w3 = f * f * (-0.5 + 0.5 * f);
  vec2 w12 = 1.0 - w0 - w3, w2 = f * (0.5 + f * (2.0 - 1.5 * f));
  vec2 least = vec2(0.5), most = push.past_px - 0.5, unit = 1.0 / vec2(textureSize(history, 0));
  if (!kSharp) return texture(history, clamp(place_px, least, most) * unit);
  vec2 at0 = clamp(middle - 1.0, least, most) * unit, at12 = clamp(middle + w2 / w12, least, most) * unit,
       at3 = clamp(middle + 2.0, least, most) * unit;
  vec4 sum = texture(history, at12) * (w12.x * w12.y);
  sum += texture(history, vec2(at0.x, at12.y)) * (w0.x * w12.y);
  sum += texture(history, vec2(at3.x, at12.y)) * (w3.x * w12.y);
  sum += texture(history, vec2(at12.x, at0.y)) * (w12.x * w0.y);
  sum += texture(history, vec2(at12.x, at3.y)) * (w12.x * w3.y);
  return max(sum / (w12.x + w12.y - w12.x * w12.y), 0.0);
}

float brightness(vec3 color) { return dot(color, vec3(0.2126, 0.7152, 0.0722)); }

void main() {
  Sampled sampled = nearest_sample();
  ivec2 at = sampled.at;
  vec3 now = texelFetch(toned, at, 0).rgb;
  vec3 sum = now, squares = now * now;
  // Two of the four neighbours are in the same quad of fragments. If a quad has four texels, their differences are known without a lookup.
  ivec2 outwards = 2 * (at & 1) - 1;
  ivec2 sideways = ivec2(outwards.x, 0), upwards = ivec2(0, outwards.y);
  bool quad = !kEnlarges;
  vec3 nears[4] = {quad ? now - float(outwards.x) * dFdxFine(now) : toned_at(at - sideways), toned_at(at + sideways),
                   quad ? now - float(outwards.y) * dFdyFine(now) : toned_at(at - upwards), toned_at(at + upwards)};
  for (int i = 0; i < 4; ++i) {
    sum += nears[i];
    squares += nears[i] * nears[i];
  }
  vec3 middle = sum / 5.0;

  // Where the surface was: plants say how they have moved; of all else only the camera has.
  vec4 moved = kHasVelocity ? texelFetch(velocity, at, 0) : vec4(0.0, 0.0, 2.0, 0.0);
  vec4 before = push.before_from_clip * vec4(sampled.clip, texelFetch(depth, at, 0).x, 1.0);
  vec2 was = clip + (moved.z > 1.5 ? before.xy / before.w - sampled.clip + push.moved_by
                                   : push.moved_by - push.moved_by_before - 2.0 * moved.xy / push.drawn_px);
  vec4 found = history_at((0.5 * was + 0.5) * push.past_px);
  // How far it may be from what is around the pixel now: as much as that differs from place to place, and as its own samples did from frame
  // to frame, since leaves before the sky hit and miss a pixel in turn. Of what moves far that says less: something else may be there now.
  vec2 moved_px = 0.5 * (was - clip) * push.past_px;
  float changes = exp(-2.0 * dot(moved_px, moved_px)) * max(found.a - brightness(found.rgb) * brightness(found.rgb), 0.0);
  vec3 reach = push.spread * sqrt(max(squares / 5.0 - middle * middle, vec3(0.0)) + changes);
  // Along the line to the mean: channel by channel, colours would come up that neither has.
  vec3 off = found.rgb - middle;
  vec3 share = reach / max(abs(off), vec3(1e-5));
  float kept = min(min(share.r, min(share.g, share.b)), 1.0);
  vec3 past = middle + off * kept;
  bool seen = all(lessThan(abs(was), vec2(1.0))) && push.newest < 1.0;  // else the history may hold anything
  vec4 latest = vec4(now, brightness(now) * brightness(now)), earlier = vec4(past, brightness(past) * brightness(past) + kept * changes);
  out_history = seen ? mix(earlier, latest, min(push.newest * sampled.weight, 1.0)) : latest;
  out_picture = vec4(out_history.rgb, 1.0);
}
