#version 460
// Forest floor: grass, litter below crowns, trodden earth, at two scales and the ground map's; writes linear radiance. Recorded by record_ground.
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

const float kLitterTile_m = 2.1;

layout(location = 0) in vec3 world_position;
layout(location = 1) in vec3 world_normal;
layout(location = 2) in float foot;  // 1 where a stem comes out
layout(location = 0) out vec4 out_color;
layout(location = 1) out vec4 out_velocity;

void main() {
  vec2 at = world_position.xz;
  vec4 state = ground_state(at);
  vec4 fine = texture(ground_detail, at / 2.7);
  // Turned and scaled by numbers without a common measure, so that the tile's repetition does not show.
  vec4 coarse = texture(ground_detail, mat2(0.81, 0.59, -0.59, 0.81) * at / 14.3);

  float lush = clamp(0.9 * state.w + 0.5 * (coarse.y - 0.5) + 0.06, 0.0, 1.0);
  vec3 grass = mix(vec3(0.098, 0.094, 0.034), vec3(0.036, 0.068, 0.014), lush);
  float litter = clamp(1.3 - 1.3 * state.z + 0.9 * (fine.y - 0.5) + 0.8 * (coarse.x - 0.5) + 0.4 * foot, 0.0, 1.0);
  // What has fallen keeps how bright the plants' leaves are, and little of their hue.
  float bright = clamp(dot(frame.leaf_color.rgb, vec3(0.2126, 0.7152, 0.0722)), 0.03, 0.15);
  vec3 dead = mix(bright * vec3(1.25, 0.7, 0.34), frame.leaf_color.rgb, 0.2);
  vec3 albedo = mix(grass, 0.5 * dead, 0.75 * litter);
  float trodden = smoothstep(0.25, 0.75, state.y + 0.5 * (fine.y - 0.5) + 0.3 * (coarse.x - 0.5));
  albedo = mix(albedo, mix(vec3(0.10, 0.070, 0.045), vec3(0.165, 0.125, 0.083), coarse.x), 0.85 * trodden);
  albedo *= (0.45 + 1.1 * fine.x) * (0.75 + 0.5 * coarse.x);
  // Where tufts get fewer the ground takes on their colour, so that no line shows where the last ones stand (gather_tufts).
  float away_m = distance(world_position, frame.eye.xyz);
  float cover = smoothstep(3.0, 20.0, away_m) * (1.0 - trodden) * (1.0 - 0.7 * litter) * (0.4 + 0.6 * lush);
  albedo = mix(albedo, mix(vec3(0.066, 0.110, 0.024), vec3(0.125, 0.130, 0.042), coarse.y * coarse.y) * (0.6 + 0.7 * fine.y), 0.7 * cover);
  vec4 leaf = texture(ground_litter, at / kLitterTile_m);
  float leaves = (1.0 - trodden) * smoothstep(0.0, 0.12, leaf.z + litter - 1.0);
  albedo *= mix(1.0, leaf.w, litter);
  albedo = mix(albedo, dead * mix(vec3(0.7, 0.55, 0.5), vec3(1.3, 1.25, 1.05), leaf.y) * (0.35 + 1.3 * leaf.x), leaves);
  float earth = foot > 0.0 ? smoothstep(0.05, 0.6, foot + 0.5 * (fine.y - 0.5)) : 0.0;
  albedo = mix(albedo, foot_color(fine.y) * (0.5 + fine.x), earth * (1.0 - 0.8 * leaves));
  // Beyond what is planted the forest goes on, too far to be told from its colour.
  vec2 unit = abs(at) / frame.ground.x;
  float forest = frame.ground_color.w * smoothstep(0.86, 1.0, max(unit.x, unit.y));
  albedo = mix(albedo, 0.4 * frame.leaf_color.rgb * (0.5 + coarse.y), 0.8 * forest);

  vec2 slope = (0.9 + 0.6 * cover) * (fine.zw - 0.5) + (0.5 + forest) * (coarse.zw - 0.5);
  vec3 normal = normalize(world_normal - vec3(slope.x, 0, slope.y));
  // Holes in the crowns: the smooth shade breaks into flecks of light.
  float flecks = smoothstep(0.36, 0.68, coarse.y * 0.6 + fine.y * 0.4);
  float sunlit = mix(state.x * state.x, 1.0, 0.55 * flecks * smoothstep(0.0, 0.5, state.x));
  sunlit = sunlight(world_position, sunlit);
  float facing = max(dot(normal, frame.sun_direction.xyz), 0.0);
  float open = open_sky(world_position, gl_FragCoord.xy, 0.3 + 0.7 * state.z) * (1.0 - 0.5 * foot);
  vec3 light = frame.sun_color.rgb * facing * sunlit + light_of_surroundings(normal, open);
  // The ground's edge (make_axis) is behind the haze in any case: no line shows at the horizon.
  float edge = smoothstep(0.6, 0.98, max(abs(at.x), abs(at.y)) / max(1.417 * frame.ground.x, 1500.0));
  vec3 hazy = air(normalize(world_position - frame.eye.xyz));
  out_color = vec4(mix(fogged(albedo * light, world_position), hazy, edge), 1);
  out_velocity = kByDepth;
}
