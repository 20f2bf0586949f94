// How wind moves places of plants. This text compiles as GLSL and as C++ (namespace coppice::gpu).
//
// A place at rest, p, is moved by the stem's bending, by the leaning of boughs, and by their swaying:
//
//     offset(p) = s(p.y)^2 bend - s(p.y)^3 fall up + lean(p) lean + cos(p) sway_cos + sin(p) sway_sin,    s: share of the plant's height
//
// where lean, cos and sin come from the plant's grid (coppice/format.h, WIND), linear between its nodes, and the vectors and the fall are
// an instance's at one moment (Sway). A stem that bends comes down, since it keeps its length: where it slopes by q, 1 - q^2 / 2 of its
// rise is left. The offset depends on the place, not on what is drawn there: cuts, wood and leaf meshes move together.
// Two oscillations a quarter turn apart add up to one of any phase. So boughs can sway out of step, and phases blend.
//
// In a shader after bindings.glsl and coppice_light.h.

#ifndef COPPICE_WIND_H
#define COPPICE_WIND_H

#include "coppice_light.h"
#include "coppice_lod.h"
#include "coppice_shared.h"

#ifdef __cplusplus
#define COPPICE_OUT(type) type&

namespace coppice::gpu {
using lod::CoppiceTable;

// On the CPU the address is one of the process.
inline vec2 wind_map_value(const uvec2& map, uint place) {
  return std::bit_cast<const vec2*>(std::uint64_t{map.y} << 32 | map.x)[place];
}
#else
#define COPPICE_OUT(type) out type
vec2 wind_map_value(uvec2 map, uint place) {
  return wind_map_at(map.x + place);
}
#endif

// A plant's field, in words behind its table: these, then the nodes. Frequencies are multiples of 1 / kWindPeriod_s.
struct PlantWind {
  float base_y_m, per_height_m;  // the stem: s is 0 at base_y_m, and 1 over its height
  float bend_m, lean_m, sway_m;  // at full load
  float stem_hz, branch_hz;
  uint node_side;  // side of the grid; 0: none
  vec3 box_min;
  vec3 nodes_per_m;
  float reach_m;  // maximum motion of any place at full load
};
const uint kReachWord = 14u;

COPPICE_FN float wind_float(CoppiceTable table, uint word) {
  return uintBitsToFloat(COPPICE_TABLE_WORD(table, kWindWord + word));
}

COPPICE_FN PlantWind plant_wind(CoppiceTable table) {
  PlantWind field;
  field.base_y_m = wind_float(table, 0u);
  field.per_height_m = wind_float(table, 1u);
  field.bend_m = wind_float(table, 2u);
  field.lean_m = wind_float(table, 3u);
  field.sway_m = wind_float(table, 4u);
  field.stem_hz = wind_float(table, 5u);
  field.branch_hz = wind_float(table, 6u);
  field.node_side = COPPICE_TABLE_WORD(table, kWindWord + 7u);
  field.box_min = vec3(wind_float(table, 8u), wind_float(table, 9u), wind_float(table, 10u));
  field.nodes_per_m = vec3(wind_float(table, 11u), wind_float(table, 12u), wind_float(table, 13u));
  field.reach_m = wind_float(table, kReachWord);
  return field;
}

// The factors of a place for an instance's Sway, and their growth along x, y and z, per m.
struct WindPlace {
  vec2 bend;  // s^2, s^3
  vec3 grid;  // lean, cos, sin
};
struct WindGradient {
  vec2 bend_y;
  vec3 grid_x, grid_y, grid_z;
};

COPPICE_FN vec3 wind_node(CoppiceTable table, uint node) {
  uint word = COPPICE_TABLE_WORD(table, kWindWord + kWindNodes + node);
  return vec3(float(word & 255u) / 255.0f, float(int(word << 16u) >> 24) / 127.0f, float(int(word << 8u) >> 24) / 127.0f);
}

// s
COPPICE_FN float height_share(PlantWind field, float y) {
  return clamp((y - field.base_y_m) * field.per_height_m, 0.0f, 1.0f);
}
COPPICE_FN vec2 bend_at(PlantWind field, float y) {
  float s = height_share(field, y);
  return vec2(s * s, s * s * s);
}

// gradient: out
COPPICE_FN WindPlace wind_place(CoppiceTable table, PlantWind field, vec3 p, COPPICE_OUT(WindGradient) gradient) {
  WindPlace place;
  float s = height_share(field, p.y), per_m = s < 1.0f ? field.per_height_m : 0.0f;
  place.bend = bend_at(field, p.y);
  place.grid = vec3(0.0f);
  gradient.bend_y = vec2(2.0f * s * per_m, 3.0f * s * s * per_m);
  gradient.grid_x = gradient.grid_y = gradient.grid_z = vec3(0.0f);
  if (field.node_side == 0u) return place;
  uint side = field.node_side;
  vec3 whole = (p - field.box_min) * field.nodes_per_m;
  vec3 at = clamp(whole, vec3(0.0f), vec3(float(side - 1u)));
  vec3 low = min(floor(at), vec3(float(side - 2u)));
  vec3 share = at - low;
  uint first = (uint(low.z) * side + uint(low.y)) * side + uint(low.x);
  for (uint i = 0u; i < 8u; ++i) {
    bool far_x = (i & 1u) != 0u, far_y = (i & 2u) != 0u, far_z = (i & 4u) != 0u;
    vec3 node = wind_node(table, first + (far_x ? 1u : 0u) + (far_y ? side : 0u) + (far_z ? side * side : 0u));
    float x = far_x ? share.x : 1.0f - share.x, y = far_y ? share.y : 1.0f - share.y, z = far_z ? share.z : 1.0f - share.z;
    place.grid += x * y * z * node;
    gradient.grid_x += (far_x ? y * z : -y * z) * node;
    gradient.grid_y += (far_y ? x * z : -x * z) * node;
    gradient.grid_z += (far_z ? x * y : -x * y) * node;
  }
  // Outside the box a place has the values of the border.
  gradient.grid_x = (whole.x == at.x ? field.nodes_per_m.x : 0.0f) * gradient.grid_x;
  gradient.grid_y = (whole.y == at.y ? field.nodes_per_m.y : 0.0f) * gradient.grid_y;
  gradient.grid_z = (whole.z == at.z ? field.nodes_per_m.z : 0.0f) * gradient.grid_z;
  return place;
}

// At kGale_mps the load is full. At kHalfLoad_mps it is half of its limit for a storm without end: leaves and boughs give way, so load
// grows slower than speed.
const float kGale_mps = 25.0f, kHalfLoad_mps = 8.0f;

COPPICE_FN float wind_load(float speed_mps) {
  return min(speed_mps / (speed_mps + kHalfLoad_mps) / (kGale_mps / (kGale_mps + kHalfLoad_mps)), 1.0f);
}

// The wind at an instance's place. gustiness: of all of the wind; the map's part has no gusts but its own.
struct WindHere {
  vec3 direction;
  float load, gustiness;
};

// foot: from the eye, as is the map's first place
COPPICE_FN WindHere wind_here(WindNow wind, vec3 foot) {
  WindHere here;
  here.direction = wind.direction;
  here.load = wind.load;
  here.gustiness = wind.gustiness;
  if ((wind.map.x | wind.map.y) == 0u) return here;
  float x = (foot.x - wind.map_first.x) * wind.map_places_per_m.x, z = (foot.z - wind.map_first.y) * wind.map_places_per_m.y;
  // False for a NaN.
  bool on_map = x >= 0.0f && z >= 0.0f && x <= float(wind.map_size.x - 1u) && z <= float(wind.map_size.y - 1u);
  if (!on_map) return here;
  uint column = min(uint(x), wind.map_size.x - 2u), row = min(uint(z), wind.map_size.y - 2u);
  float right = x - float(column), far = z - float(row);
  uint first = row * wind.map_size.x + column, next = first + wind.map_size.x;
  vec2 a = wind_map_value(wind.map, first), b = wind_map_value(wind.map, first + 1u);
  vec2 c = wind_map_value(wind.map, next), d = wind_map_value(wind.map, next + 1u);
  float added_x = (1.0f - far) * ((1.0f - right) * a.x + right * b.x) + far * ((1.0f - right) * c.x + right * d.x);
  float added_z = (1.0f - far) * ((1.0f - right) * a.y + right * b.y) + far * ((1.0f - right) * c.y + right * d.y);
  float added_mps = sqrt(added_x * added_x + added_z * added_z);
  if (added_mps == 0.0f) return here;
  vec3 sum = wind.speed_mps * wind.direction + vec3(added_x, 0.0f, added_z);
  float speed_mps = length(sum);
  here.load = wind_load(speed_mps);
  here.gustiness = wind.gustiness * wind.speed_mps / (wind.speed_mps + added_mps);
  if (speed_mps > 0.0f) here.direction = sum / vec3(speed_mps);
  return here;
}

// The motion of an instance at one moment; object space, m. load: the wind's at its place, without gusts
struct Sway {
  vec3 bend, lean, sway_cos, sway_sin;
  float fall, load;
};

// Neighbouring plants sway out of step: rad/m along x and z, in whole turns a cell.
const float kCellTurn = 6.2831853f / kCellSide_m;
const vec2 kStemPhase = vec2(114.0f * kCellTurn, 212.0f * kCellTurn), kBranchPhase = vec2(194.0f * kCellTurn, 360.0f * kCellTurn);

// foot: the instance's, from the eye, as in WindNow's waves. place: in its cell
COPPICE_FN Sway sway_of(WindNow wind, PlantWind field, vec4 rotation, vec3 foot, vec3 place) {
  WindHere here = wind_here(wind, foot);
  float gust = 0.0f;
  for (uint i = 0u; i < kWindWaves; ++i)
    gust += wind.waves[i].w * sin(wind.waves[i].x * foot.x + wind.waves[i].y * foot.z + wind.waves[i].z);
  // The strongest gust has the full load.
  float load = here.load * (1.0f - here.gustiness * (0.5f - 0.5f * gust));
  float phase = kStemPhase.x * place.x + kStemPhase.y * place.z;
  float turns = 6.2831853f * wind.time_s;
  float stem = 0.75f + 0.25f * sin(turns * field.stem_hz + phase);
  float branch = turns * field.branch_hz + kBranchPhase.x * place.x + kBranchPhase.y * place.z;
  vec4 to_object = vec4(-rotation.x, -rotation.y, -rotation.z, rotation.w);
  vec3 along = oriented(to_object, here.direction);
  vec3 across = oriented(to_object, vec3(-0.45f * here.direction.z, 0.6f, 0.45f * here.direction.x) + 0.66f * here.direction);
  Sway sway;
  sway.load = here.load;
  // A stem bends by the wind's force, which grows faster than leaves begin to stir.
  float bend_m = field.bend_m * here.load * load * stem;
  sway.bend = bend_m * along;
  sway.fall = 2.0f / 3.0f * bend_m * bend_m * field.per_height_m;
  sway.lean = field.lean_m * load * along;
  sway.sway_cos = field.sway_m * load * cos(branch) * across;
  sway.sway_sin = field.sway_m * load * sin(branch) * across;
  return sway;
}

// The grid's part only: the offset for WindPlace::grid, its growth along an axis for a WindGradient's.
COPPICE_FN vec3 grid_offset(vec3 grid, Sway sway) {
  return grid.x * sway.lean + grid.y * sway.sway_cos + grid.z * sway.sway_sin;
}
// The bend's: the offset for WindPlace::bend, its growth along y for a WindGradient's.
COPPICE_FN vec3 bend_offset(vec2 bend, Sway sway) {
  return bend.x * sway.bend - vec3(0.0f, bend.y * sway.fall, 0.0f);
}
COPPICE_FN vec3 wind_offset(WindPlace place, Sway sway) {
  return bend_offset(place.bend, sway) + grid_offset(place.grid, sway);
}

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
