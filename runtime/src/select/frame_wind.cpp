#include "frame_wind.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

namespace coppice {
namespace {

/// A gust's wave: its direction relative to the wind, its length, and its share.
struct Wave {
  double turn_rad, length_m;
  float share;
};
constexpr std::array<Wave, gpu::kWindWaves> kWaves{{{0.0, 80.0, 0.5f}, {0.5, 37.0, 0.3f}, {-0.7, 19.0, 0.2f}}};

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Rounds a frequency so that a plant's motion repeats after kWindPeriod_s.
float whole_hz(float period_s) {
  return std::max(std::round(gpu::kWindPeriod_s / period_s), 1.0f) / gpu::kWindPeriod_s;
}

static_assert(gpu::kMaxWindNodes == COPPICE_MAX_WIND_SIDE * COPPICE_MAX_WIND_SIDE * COPPICE_MAX_WIND_SIDE);

}  // namespace

std::size_t wind_word_count(const WindField& field) {
  return gpu::kWindNodes + field.nodes.size();
}

void pack_wind(const WindField& field, std::span<std::uint32_t> words) {
  const coppice_file_wind& head = field.head;
  const auto side = static_cast<float>(head.node_side);
  std::array<float, gpu::kWindNodes> numbers{head.base_y_m,
                                             1.0f / head.height_m,
                                             head.bend_m,
                                             head.lean_m,
                                             head.sway_m,
                                             whole_hz(head.stem_period_s),
                                             whole_hz(head.branch_period_s),
                                             0.0f};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    numbers[8 + axis] = head.box_min[axis];
    numbers[11 + axis] = head.node_side > 0 ? (side - 1.0f) / (head.box_max[axis] - head.box_min[axis]) : 0.0f;
  }
  std::ranges::transform(numbers, words.begin(), [](float number) { return std::bit_cast<std::uint32_t>(number); });
  words[7] = head.node_side;
  // Rounded up, because it is a bound.
  words[gpu::kReachWord] = std::bit_cast<std::uint32_t>(std::nextafter(static_cast<float>(max_wind_move_m(field)), HUGE_VALF));
  static_assert(sizeof(coppice_file_wind_node) == sizeof(std::uint32_t));
  std::memcpy(words.data() + gpu::kWindNodes, field.nodes.data(), field.nodes.size_bytes());
}

namespace {

/// Wind straight up or down has no horizontal speed.
float level_speed_mps(const coppice_wind& wind) {
  return std::hypot(wind.direction[0], wind.direction[2]) > 1e-6f ? wind.speed : 0.0f;
}

void set_map(const PlacedWind& wind, const dvec3& eye_m, gpu::WindNow& now) {
  const coppice_wind& blows = wind.wind;
  if (wind.map_address == 0) return;
  now.map = {static_cast<std::uint32_t>(wind.map_address), static_cast<std::uint32_t>(wind.map_address >> 32)};
  now.map_size = {blows.map_width, blows.map_height};
  const double eye[2] = {eye_m.x - wind.origin_m.x, eye_m.z - wind.origin_m.z};
  now.map_first = {static_cast<float>(blows.map_min[0] - eye[0]), static_cast<float>(blows.map_min[1] - eye[1])};
  now.map_places_per_m = {static_cast<float>((blows.map_width - 1) / (blows.map_max[0] - blows.map_min[0])),
                          static_cast<float>((blows.map_height - 1) / (blows.map_max[1] - blows.map_min[1]))};
  now.max_load = max_wind_load(wind);
}

}  // namespace

float max_wind_load(const PlacedWind& wind) {
  return gpu::wind_load(level_speed_mps(wind.wind) + wind.max_map_mps);
}

float wind_reach_share(const WindField& field, float sphere_radius_m) {
  if (!(sphere_radius_m > 0.0f)) return 0.0f;
  const auto share = static_cast<float>(max_wind_move_m(field) / sphere_radius_m);
  // Rounded up, because it is a bound.
  return std::min(std::nextafter(share + gpu::kFlutterReach, HUGE_VALF), gpu::kMaxWindReach);
}

float max_wind_mps(std::span<const float> map) {
  float maximum = 0.0f;
  for (std::size_t i = 0; i + 1 < map.size(); i += 2) maximum = std::max(maximum, map[i] * map[i] + map[i + 1] * map[i + 1]);
  // Rounded up, because it is a bound.
  return std::nextafter(std::sqrt(maximum), HUGE_VALF);
}

gpu::WindNow wind_now(const PlacedWind& placed, const dvec3& eye_m) {
  const coppice_wind& wind = placed.wind;
  const double x = wind.direction[0], z = wind.direction[2], level = std::hypot(x, z);
  const bool blows = level_speed_mps(wind) > 0.0f;
  const double along_x = blows ? x / level : 1.0, along_z = blows ? z / level : 0.0;
  const double gusts_m = wind.gusts_m >= 0.0 ? wind.gusts_m : double{wind.speed} * wind.time_s;
  gpu::WindNow now{};
  now.direction = {static_cast<float>(along_x), 0.0f, static_cast<float>(along_z)};
  now.speed_mps = level_speed_mps(wind);
  now.load = now.max_load = gpu::wind_load(now.speed_mps);
  now.gustiness = wind.gustiness;
  now.time_s = static_cast<float>(std::fmod(wind.time_s, double{gpu::kWindPeriod_s}));
  for (std::size_t i = 0; i < kWaves.size(); ++i) {
    const Wave& wave = kWaves[i];
    const double k = kTurn / wave.length_m, c = std::cos(wave.turn_rad), s = std::sin(wave.turn_rad);
    const double k_x = k * (c * along_x - s * along_z), k_z = k * (s * along_x + c * along_z);
    const double phase = k_x * eye_m.x + k_z * eye_m.z - k * c * gusts_m;
    now.waves[i] = {static_cast<float>(k_x), static_cast<float>(k_z), static_cast<float>(std::remainder(phase, kTurn)), wave.share};
  }
  set_map(placed, eye_m, now);
  now.max_reach = placed.reach_share * now.max_load;
  return now;
}

void set_gusts(const PlacedWind& wind, const dvec3& place_m, coppice_gusts& gusts) {
  static_assert(gpu::kWindWaves == COPPICE_GUST_WAVES);
  const gpu::WindNow now = wind_now(wind, place_m);
  gusts.direction[0] = now.direction.x;
  gusts.direction[1] = now.direction.y;
  gusts.direction[2] = now.direction.z;
  gusts.load = now.load;
  gusts.gustiness = now.gustiness;
  for (std::size_t i = 0; i < COPPICE_GUST_WAVES; ++i) gusts.waves[i] = {now.waves[i].x, now.waves[i].y, now.waves[i].z, now.waves[i].w};
}

}  // namespace coppice
