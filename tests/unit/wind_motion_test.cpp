// How wind moves places of plants: coppice_wind.h and the numbers that a frame gives it.

#include "frame_wind.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "still_wind.h"

namespace coppice::wind_motion_test {

using namespace gpu;

/// A plant of 10 m with a random field, behind an empty table.
class WindMotion : public testing::Test {
 protected:
  WindMotion() : random_(7), words_(kWindWord) {
    coppice_file_wind head = kStillWind;
    head.height_m = 10.0f;
    head.bend_m = 2.0f;
    head.lean_m = 0.1f;
    head.sway_m = 0.08f;
    head.stem_period_s = 3.0f;
    head.branch_period_s = 0.9f;
    const float low[3] = {-4, 0, -4}, high[3] = {4, 10, 4};
    std::copy_n(low, 3, head.box_min);
    std::copy_n(high, 3, head.box_max);
    head.node_side = 4;
    nodes_.resize(64);
    for (coppice_file_wind_node& node : nodes_) {
      // As long as sways can be: 1.4.
      const auto sway = [&] { return static_cast<std::int8_t>(random_() % 2 == 0 ? 127 : -127); };
      node = {static_cast<std::uint8_t>(random_() % 256), sway(), sway(), 0};
    }
    field_ = {head, nodes_};
    words_.resize(kWindWord + wind_word_count(field_));
    pack_wind(field_, std::span(words_).subspan(kWindWord));
    table_.words = words_.data();
  }

  float between(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  vec3 place() { return {between(-5.0f, 5.0f), between(-1.0f, 11.0f), between(-5.0f, 5.0f)}; }
  vec4 rotation() {
    const float x = between(-1, 1), y = between(-1, 1), z = between(-1, 1), w = between(-1, 1),
                r = inversesqrt(x * x + y * y + z * z + w * w);
    return {x * r, y * r, z * r, w * r};
  }
  vec4 rotation_about_up() {
    const float turn = between(-3.1f, 3.1f);
    return {0.0f, std::sin(turn), 0.0f, std::cos(turn)};
  }
  [[nodiscard]] PlantWind plant() const { return plant_wind(table_); }
  [[nodiscard]] WindPlace at(const vec3& p) const {
    WindGradient unused;
    return wind_place(table_, plant(), p, unused);
  }
  static coppice_wind blowing(float speed, double time_s) {
    return {.struct_size = sizeof(coppice_wind),
            .direction = {0.6f, 0.0f, 0.8f},
            .speed = speed,
            .gustiness = 0.7f,
            .time_s = time_s,
            .gusts_m = -1.0};
  }

  std::mt19937 random_;
  std::vector<coppice_file_wind_node> nodes_;
  WindField field_;
  std::vector<std::uint32_t> words_;
  lod::CoppiceTable table_{};
};

TEST_F(WindMotion, TheGridIsTheFiles) {
  for (int i = 0; i < 1000; ++i) {
    const vec3 p = place();
    const float position[3] = {p.x, p.y, p.z};
    const WindSample expected = sample_wind(field_, position);
    const WindPlace actual = at(p);
    EXPECT_NEAR(actual.grid.x, expected.lean, 1e-5f);
    EXPECT_NEAR(actual.grid.y, expected.sway_cos, 1e-5f);
    EXPECT_NEAR(actual.grid.z, expected.sway_sin, 1e-5f);
    const float s = wind_height_share(field_.head, p.y);
    EXPECT_NEAR(actual.bend.x, s * s, 1e-5f);
    EXPECT_NEAR(actual.bend.y, s * s * s, 1e-5f);
  }
}

TEST_F(WindMotion, GradientsAreThoseOfTheField) {
  for (int i = 0; i < 1000; ++i) {
    const vec3 p = place();
    constexpr float kStep_m = 1e-2f;
    WindGradient gradient;
    const WindPlace here = wind_place(table_, plant(), p, gradient);
    const Sway sway = sway_of(wind_now({blowing(20, 3)}, {0, 0, 0}), plant(), {0, 0, 0, 1}, {1, 2, 3}, {1, 2, 3});
    const vec3 grow[3] = {grid_offset(gradient.grid_x, sway), grid_offset(gradient.grid_y, sway) + bend_offset(gradient.bend_y, sway),
                          grid_offset(gradient.grid_z, sway)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      vec3 next = p;
      next[axis] += kStep_m;
      if ((p.y < 10.0f) != (next.y < 10.0f)) continue;  // the bend ends with the plant
      const vec3 difference = wind_offset(at(next), sway) - wind_offset(here, sway);
      // Where a cell, or the box, ends between the two the gradient is that of one side.
      EXPECT_LE(length(difference - grow[axis] * kStep_m), 0.1f * kStep_m);
    }
  }
}

/// At any wind, place, time and turn, and no further in a storm than in a gale.
TEST_F(WindMotion, NothingIsMovedBeyondTheReach) {
  float furthest = 0;
  for (int i = 0; i < 20000; ++i) {
    const WindNow now =
        wind_now({blowing(between(0.0f, 100.0f), std::abs(between(0.0f, 1e6f)))}, {between(-1e4f, 1e4f), 0, between(-1e4f, 1e4f)});
    const Sway sway = sway_of(now, plant(), rotation(), {between(-300, 300), 0, between(-300, 300)}, place());
    const float moved = length(wind_offset(at(place()), sway)), reach = now.load * plant().reach_m;
    EXPECT_LE(moved, reach * 1.0001f);
    EXPECT_LE(reach, max_wind_move_m(field_) * 1.0001);
    furthest = std::max(furthest, moved);
  }
  EXPECT_GT(furthest, 0.2f) << "it moves";
  EXPECT_EQ(kMaxWindReach, static_cast<float>(COPPICE_MAX_WIND_MOVE));
}

/// A stem that stands upright, in the strongest wind and at its most bent.
TEST_F(WindMotion, StemsKeepTheirLength) {
  coppice_file_wind head = field_.head;
  head.bend_m = static_cast<float>(COPPICE_MAX_WIND_BEND) * head.height_m;
  head.node_side = 0;
  pack_wind({head, {}}, std::span(words_).subspan(kWindWord));
  float farthest_m = 0.0f;
  for (int moment = 0; moment < 50; ++moment) {
    const Sway sway = sway_of(wind_now({blowing(25, 0.37 * moment)}, {0, 0, 0}), plant(), rotation_about_up(), {0, 0, 0}, place());
    constexpr int kPieces = 200;
    float length_m = 0.0f;
    vec3 before = wind_offset(at({0, 0, 0}), sway);
    for (int i = 1; i <= kPieces; ++i) {
      const float y = 10.0f * static_cast<float>(i) / kPieces;
      const vec3 here = vec3{0, y, 0} + wind_offset(at({0, y, 0}), sway);
      EXPECT_GT(here.y, before.y) << "it does not fold";
      length_m += length(here - before);
      before = here;
    }
    EXPECT_NEAR(length_m, 10.0f, 0.08f);
    farthest_m = std::max(farthest_m, std::hypot(before.x, before.z));
  }
  EXPECT_GT(farthest_m, 3.0f);
}

TEST_F(WindMotion, StillAirMovesNothingAtAll) {
  for (int i = 0; i < 100; ++i) {
    const WindNow now = wind_now({blowing(0, double{between(0.0f, 1e6f)})}, {0, 0, 0});
    const vec3 offset = wind_offset(at(place()), sway_of(now, plant(), rotation(), place(), place()));
    EXPECT_EQ(offset.x, 0.0f);
    EXPECT_EQ(offset.y, 0.0f);
    EXPECT_EQ(offset.z, 0.0f);
    EXPECT_EQ(now.load * plant().reach_m, 0.0f);
  }
}

TEST_F(WindMotion, PlantsBendWithTheWindHoweverTheyAreTurned) {
  for (int i = 0; i < 100; ++i) {
    const vec4 turn = rotation();
    const Sway sway = sway_of(wind_now({blowing(8, double{between(0.0f, 1e5f)})}, {0, 0, 0}), plant(), turn, place(), place());
    for (const vec3& moved : {sway.bend, sway.lean}) {
      EXPECT_GT(length(moved), 0.0f);
      EXPECT_NEAR(dot(oriented(turn, moved), vec3{0.6f, 0.0f, 0.8f}), length(moved), 1e-4f * length(moved));
    }
  }
}

/// A plant stands in the same gust whoever looks; and in the one that was a second before where the wind was then.
TEST_F(WindMotion, GustsAreOfTheWorldAndTravel) {
  double worst = 0, most = 0;
  for (int i = 0; i < 200; ++i) {
    const dvec3 foot{5e5 + double{between(-1e3f, 1e3f)}, 0, -3e5 + double{between(-1e3f, 1e3f)}};
    const double time_s = double{between(0.0f, 1e5f)};
    const coppice_wind wind = blowing(8, time_s);
    const auto lean_at = [&](const dvec3& where, const dvec3& eye, const coppice_wind& then) {
      return length(sway_of(wind_now({then}, eye), plant(), {0, 0, 0, 1}, (where - eye).rounded(), {0, 0, 0}).lean);
    };
    const dvec3 eye{foot.x + double{between(-500, 500)}, 20, foot.z + double{between(-500, 500)}}, other{foot.x, 0, foot.z};
    const double here = lean_at(foot, eye, wind);
    worst = std::max(worst, std::abs(here - lean_at(foot, other, wind)));
    most = std::max(most, here);
  }
  EXPECT_LT(worst, 1e-3 * most);
  // Along the wind, at its speed, the gust's longest wave keeps its phase.
  const WindNow now = wind_now({blowing(8, 10)}, {0, 0, 0}), later = wind_now({blowing(8, 11)}, {0.6 * 8, 0, 0.8 * 8});
  EXPECT_NEAR(std::remainder(now.waves[0].z - later.waves[0].z, 6.2831853f), 0.0f, 1e-3f);
}

/// A map of random velocities, up to `max_mps` along each axis, over 60 m by 40 m about a corner of the world.
class WindMap : public WindMotion {
 protected:
  static constexpr std::uint32_t kColumns = 7, kRows = 5;
  PlacedWind with_map(float speed, float max_mps) {
    map_.resize(std::size_t{2} * kColumns * kRows);
    for (float& each : map_) each = between(-max_mps, max_mps);
    coppice_wind wind = blowing(speed, 3);
    wind.map = map_.data();
    wind.map_width = kColumns;
    wind.map_height = kRows;
    wind.map_min[0] = 1000.0, wind.map_max[0] = 1060.0;
    wind.map_min[1] = -500.0, wind.map_max[1] = -460.0;
    return {.wind = wind,
            .origin_m = {2e5, 0, 1e5},
            .max_map_mps = max_wind_mps(map_),
            .map_address = reinterpret_cast<std::uintptr_t>(map_.data())};
  }
  /// What the map adds at a place of the engine's coordinates.
  [[nodiscard]] dvec3 added_at(double x, double z) const {
    const double column = (x - 1000.0) / 10.0, row = (z + 500.0) / 10.0;
    dvec3 sum(0, 0, 0);
    for (std::uint32_t i = 0; i < kColumns * kRows; ++i) {
      const double near_x = 1.0 - std::abs(column - i % kColumns), near_z = 1.0 - std::abs(row - i / kColumns);
      const double share = std::max(near_x, 0.0) * std::max(near_z, 0.0);
      sum = sum + dvec3(share * double{map_[2 * std::size_t{i}]}, 0.0, share * double{map_[2 * std::size_t{i} + 1]});
    }
    return sum;
  }
  static vec3 foot_of(double x, double z, const dvec3& eye) { return (dvec3(2e5 + x, 0, 1e5 + z) - eye).rounded(); }

  std::vector<float> map_;
};

TEST_F(WindMap, IsLinearBetweenItsPlacesAndNothingBeyond) {
  const dvec3 eye{2e5 + 1020.0, 10.0, 1e5 - 470.0};
  for (const float speed : {0.0f, 6.0f}) {
    const PlacedWind wind = with_map(speed, 8.0f);
    const WindNow now = wind_now(wind, eye);
    for (int i = 0; i < 2000; ++i) {
      const double x = double{between(990.0f, 1070.0f)}, z = double{between(-510.0f, -450.0f)};
      const WindHere here = wind_here(now, foot_of(x, z, eye));
      const bool on_map = x >= 1000.0 && x <= 1060.0 && z >= -500.0 && z <= -460.0;
      const dvec3 expected = (on_map ? added_at(x, z) : dvec3(0, 0, 0)) + dvec3(0.6, 0, 0.8) * double{speed};
      const double speed_mps = std::hypot(expected.x, expected.z);
      EXPECT_NEAR(here.load, wind_load(static_cast<float>(speed_mps)), 1e-4f);
      if (speed_mps > 0.1 && on_map) {
        EXPECT_NEAR(here.direction.x, expected.x / speed_mps, 2e-3);
        EXPECT_NEAR(here.direction.z, expected.z / speed_mps, 2e-3);
      }
      if (!on_map) {
        EXPECT_EQ(here.load, wind_load(speed));
      }
    }
    // At its first and at its last place, to which it reaches.
    for (const std::size_t place : {std::size_t{0}, std::size_t{kColumns} * kRows - 1}) {
      const double share = place == 0 ? 1e-4 : 1.0 - 1e-4;
      const WindHere here = wind_here(now, foot_of(1000.0 + 60.0 * share, -500.0 + 40.0 * share, eye));
      const float x = map_[2 * place] + 0.6f * speed, z = map_[2 * place + 1] + 0.8f * speed;
      EXPECT_NEAR(here.load, wind_load(std::sqrt(x * x + z * z)), 1e-3f);
    }
  }
}

TEST_F(WindMap, NothingIsMovedBeyondTheReach) {
  for (int i = 0; i < 300; ++i) {
    const dvec3 eye{2e5 + 1030.0, 0, 1e5 - 480.0};
    const PlacedWind wind = with_map(between(0.0f, 30.0f), between(0.0f, 100.0f));
    const WindNow now = wind_now(wind, eye);
    EXPECT_LE(now.max_load, 1.0f);
    EXPECT_EQ(now.max_load, max_wind_load(wind));
    for (int j = 0; j < 60; ++j) {
      const vec3 foot = foot_of(double{between(995.0f, 1065.0f)}, double{between(-505.0f, -455.0f)}, eye);
      const Sway sway = sway_of(now, plant(), rotation(), foot, place());
      EXPECT_LE(sway.load, now.max_load * 1.0001f);
      EXPECT_LE(length(wind_offset(at(place()), sway)), now.max_load * plant().reach_m * 1.0001f);
    }
  }
}

/// The same bits: where no map is, where it adds nothing, and where it was asked for and is not there.
TEST_F(WindMap, OfNothingChangesNothing) {
  const dvec3 eye{2e5 + 1030.0, 0, 1e5 - 480.0};
  PlacedWind with = with_map(9.0f, 0.0f);
  PlacedWind without = with, absent = with_map(9.0f, 5.0f);
  without.wind.map = nullptr;
  without.map_address = 0;
  absent.map_address = 0;
  for (int i = 0; i < 100; ++i) {
    const vec3 foot = foot_of(double{between(995.0f, 1065.0f)}, double{between(-505.0f, -455.0f)}, eye), p = place();
    const auto offset = [&](const PlacedWind& wind) {
      return wind_offset(at(p), sway_of(wind_now(wind, eye), plant(), {0, 0, 0, 1}, foot, {1, 2, 3}));
    };
    std::ranges::fill(map_, 0.0f);
    EXPECT_EQ(offset(with), offset(without));
    EXPECT_EQ(offset(absent), offset(without));
  }
}

/// A wind that picks up: its gusts go on from where they are, and without gusts_m are those of a wind that always blew so.
TEST_F(WindMotion, GustsGoOnWhenTheSpeedChanges) {
  coppice_wind steady = blowing(8, 600), faster = blowing(8.1f, 600);
  const gpu::WindNow then = wind_now({.wind = steady}, {}), jumped = wind_now({.wind = faster}, {});
  EXPECT_GT(std::abs(then.waves[0].z - jumped.waves[0].z), 1.0f);
  steady.gusts_m = 8.0 * 600;
  faster.gusts_m = steady.gusts_m + 8.1 / 60;
  const gpu::WindNow same = wind_now({.wind = steady}, {}), next = wind_now({.wind = faster}, {});
  EXPECT_EQ(same.waves[0].z, then.waves[0].z);
  EXPECT_LT(std::abs(next.waves[0].z - then.waves[0].z), 0.02f);
}

TEST_F(WindMotion, FrequenciesFitIntoThePeriod) {
  const double whole = double{kWindPeriod_s} * double{plant().branch_hz};
  EXPECT_NEAR(whole, std::round(whole), 1e-4);
  EXPECT_NEAR(1.0 / double{plant().branch_hz}, 0.9, 0.01);
}

TEST_F(WindMotion, HostsAreToldTheGustsThatPlantsBendBy) {
  const PlacedWind wind{.wind = blowing(9.0f, 12.5)};
  const dvec3 eye{100, 2, -50}, asked{80, 0, -45};
  const WindNow now = wind_now(wind, eye);
  coppice_gusts gusts{};
  set_gusts(wind, asked, gusts);
  for (int i = 0; i < 30; ++i) {
    const vec3 foot{between(-60, 60), 0, between(-60, 60)};
    const float x = foot.x + static_cast<float>(eye.x - asked.x), z = foot.z + static_cast<float>(eye.z - asked.z);
    float g = 0.0f;
    for (const coppice_gust_wave& wave : gusts.waves) g += wave.share * std::sin(wave.x * x + wave.z * z + wave.phase);
    const float load = gusts.load * (1.0f - gusts.gustiness * (0.5f - 0.5f * g));
    const Sway sway = sway_of(now, plant(), {0, 0, 0, 1}, foot, {0, 0, 0});
    EXPECT_NEAR(sway.lean.x, 0.1f * load * gusts.direction[0], 1e-5f);
    EXPECT_NEAR(sway.lean.z, 0.1f * load * gusts.direction[2], 1e-5f);
  }
}

}  // namespace coppice::wind_motion_test
