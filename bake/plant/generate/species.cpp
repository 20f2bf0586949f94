#include "species.h"

#include <initializer_list>
#include <type_traits>

#include "check.h"

// Parameter tables of the three plants. Shapes follow the plants' habit (Corylus avellana: many arching stems from one stool, broad toothed
// leaves; Salix babylonica: short trunk, arching limbs, curtains of hanging twigs; Juniperus communis: a dense flame of ascending branches,
// awl-shaped needles in threes). Leaves are two to seven times as long as botany has them: the paper's leaf counts must cover a full crown.

namespace coppice::bake {
namespace {

/// A row of a table: the values of one parameter in all columns, which are levels from the ground up, or species.
template <class Column, class T>
void set(std::vector<Column>& columns, T Column::*parameter, std::type_identity_t<std::initializer_list<T>> values) {
  COPPICE_ASSERT(values.size() == columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) columns[i].*parameter = values.begin()[i];
}

std::vector<StemLevel> hazel_levels() {
  std::vector<StemLevel> levels(3);  // stems, branches, twigs
  set(levels, &StemLevel::spacing_m, {0.2f, 0.25f, 0.21f});
  set(levels, &StemLevel::min_count, {8, 6, 1});
  set(levels, &StemLevel::max_count, {8, 12, 4});
  set(levels, &StemLevel::first_fraction, {0.0f, 0.1f, 0.3f});
  set(levels, &StemLevel::last_fraction, {1.0f, 0.93f, 0.85f});
  set(levels, &StemLevel::length_m, {3.0f, 0.68f, 0.28f});
  set(levels, &StemLevel::length_spread, {0.1f, 0.2f, 0.2f});
  set(levels, &StemLevel::length_profile, {{1.1f, 1.02f, 0.92f, 0.8f}, {0.8f, 1.0f, 1.0f, 0.65f}, {1.0f, 1.0f, 0.8f, 0.6f}});
  set(levels, &StemLevel::angle_first_deg, {6.0f, 62.0f, 55.0f});
  set(levels, &StemLevel::angle_last_deg, {19.0f, 50.0f, 45.0f});
  set(levels, &StemLevel::angle_spread_deg, {3.0f, 8.0f, 8.0f});
  set(levels, &StemLevel::light, {0.0f, 0.4f, 0.3f});
  set(levels, &StemLevel::lift_first_per_m, {0.1f, 0.5f, 0.4f});
  set(levels, &StemLevel::lift_last_per_m, {-0.3f, -0.1f, 0.0f});
  set(levels, &StemLevel::wander_deg, {2.5f, 7.0f, 9.0f});
  set(levels, &StemLevel::segment_count, {12, 6, 3});
  set(levels, &StemLevel::radius_ratio, {0.026f, 0.5f, 0.6f});
  set(levels, &StemLevel::min_radius_m, {0.002f, 0.005f, 0.003f});
  set(levels, &StemLevel::tip_radius_fraction, {0.2f, 0.25f, 0.25f});
  set(levels, &StemLevel::side_count, {7, 5, 3});
  set(levels, &StemLevel::leaves_per_m, {1.3f, 1.0f, 1.0f});
  set(levels, &StemLevel::leaf_first_fraction, {0.85f, 0.5f, 0.4f});
  return levels;
}

Species hazel() {
  Species species{.name = "corylus", .leaf_count = 386, .root_depth_m = 0.06f, .root_flare = 0.35f, .min_height_m = 0.2f};
  species.height_m = 3.0f;
  species.crown_centre_fraction = 0.35f;
  species.leaf_color = {0.105f, 0.225f, 0.04f};
  species.wood_color = {0.16f, 0.11f, 0.07f};
  species.levels = hazel_levels();
  species.outline.midrib_z = {0.0f, 0.17f, 0.36f, 0.56f, 0.78f, 1.0f};
  species.outline.rim_xz = {{0.13f, 0.01f},  {0.29f, 0.06f}, {0.41f, 0.2f},   {0.395f, 0.27f}, {0.48f, 0.41f},  {0.44f, 0.475f},
                            {0.475f, 0.61f}, {0.4f, 0.66f},  {0.365f, 0.78f}, {0.255f, 0.80f}, {0.175f, 0.89f}, {0.075f, 0.92f}};
  species.outline.fold = 0.2f;
  species.outline.arch = 0.14f;
  species.outline.ripple = 0.012f;
  species.paint = {.width_px = 128, .height_px = 128, .side_vein_count = 8, .side_vein_slope = 0.75f, .vein_width = 0.016f};
  return species;
}

std::vector<StemLevel> willow_levels() {
  std::vector<StemLevel> levels(4);  // trunk, limbs, branches, twigs
  set(levels, &StemLevel::spacing_m, {0.0f, 0.26f, 0.36f, 0.3f});
  set(levels, &StemLevel::min_count, {1, 12, 3, 2});
  set(levels, &StemLevel::max_count, {1, 18, 8, 6});
  set(levels, &StemLevel::first_fraction, {0.0f, 0.4f, 0.35f, 0.2f});
  set(levels, &StemLevel::last_fraction, {1.0f, 0.98f, 1.0f, 1.0f});
  set(levels, &StemLevel::length_m, {5.4f, 2.7f, 1.1f, 2.9f});
  set(levels, &StemLevel::length_spread, {0.05f, 0.08f, 0.2f, 0.25f});
  set(levels, &StemLevel::length_profile,
      {{1.0f, 1.0f, 1.0f, 1.0f}, {0.85f, 1.0f, 0.95f, 0.65f}, {1.0f, 1.0f, 0.9f, 0.7f}, {1.0f, 1.0f, 1.0f, 1.0f}});
  set(levels, &StemLevel::angle_first_deg, {0.0f, 55.0f, 55.0f, 50.0f});
  set(levels, &StemLevel::angle_last_deg, {4.0f, 25.0f, 25.0f, 30.0f});
  set(levels, &StemLevel::angle_spread_deg, {2.0f, 8.0f, 8.0f, 8.0f});
  set(levels, &StemLevel::light, {0.0f, 0.15f, 0.15f, 0.0f});
  set(levels, &StemLevel::lift_first_per_m, {0.06f, 0.3f, 0.1f, -2.0f});
  set(levels, &StemLevel::lift_last_per_m, {0.05f, -0.9f, -1.0f, -2.6f});
  set(levels, &StemLevel::wander_deg, {3.5f, 5.0f, 6.0f, 4.0f});
  set(levels, &StemLevel::segment_count, {14, 10, 5, 8});
  set(levels, &StemLevel::radius_ratio, {0.24f, 0.5f, 0.55f, 0.5f});
  set(levels, &StemLevel::min_radius_m, {0.002f, 0.02f, 0.008f, 0.004f});
  set(levels, &StemLevel::tip_radius_fraction, {0.2f, 0.25f, 0.25f, 0.25f});
  set(levels, &StemLevel::side_count, {12, 7, 5, 3});
  set(levels, &StemLevel::leaves_per_m, {0.0f, 0.6f, 0.9f, 1.0f});
  set(levels, &StemLevel::leaf_first_fraction, {0.0f, 0.5f, 0.35f, 0.03f});
  return levels;
}

Species weeping_willow() {
  Species species{.name = "willow", .leaf_count = 4456, .root_depth_m = 0.15f, .root_flare = 0.6f, .min_height_m = 0.6f};
  species.height_m = 7.6f;
  species.crown_centre_fraction = 0.6f;
  species.leaf_color = {0.155f, 0.265f, 0.055f};
  species.wood_color = {0.115f, 0.092f, 0.068f};
  species.levels = willow_levels();
  species.outline.midrib_z = {0.0f, 0.45f, 1.0f};
  species.outline.rim_xz = {{0.06f, 0.14f}, {0.085f, 0.42f}, {0.05f, 0.76f}};
  species.outline.fold = 0.3f;
  species.outline.arch = 0.12f;
  species.paint = {.width_px = 32, .height_px = 128, .side_vein_count = 0, .side_vein_slope = 0.0f, .vein_width = 0.008f};
  return species;
}

std::vector<StemLevel> juniper_levels() {
  std::vector<StemLevel> levels(3);  // trunks, branches, twigs
  set(levels, &StemLevel::spacing_m, {0.08f, 0.085f, 0.08f});
  set(levels, &StemLevel::min_count, {3, 20, 3});
  set(levels, &StemLevel::max_count, {3, 50, 10});
  set(levels, &StemLevel::first_fraction, {0.0f, 0.03f, 0.25f});
  set(levels, &StemLevel::last_fraction, {1.0f, 0.97f, 0.92f});
  set(levels, &StemLevel::length_m, {3.4f, 0.78f, 0.34f});
  set(levels, &StemLevel::length_spread, {0.06f, 0.18f, 0.25f});
  set(levels, &StemLevel::length_profile, {{1.1f, 1.0f, 0.9f, 0.8f}, {0.75f, 1.0f, 0.8f, 0.3f}, {0.9f, 1.0f, 0.9f, 0.6f}});
  set(levels, &StemLevel::angle_first_deg, {1.0f, 58.0f, 48.0f});
  set(levels, &StemLevel::angle_last_deg, {4.5f, 30.0f, 36.0f});
  set(levels, &StemLevel::angle_spread_deg, {1.5f, 8.0f, 8.0f});
  set(levels, &StemLevel::light, {0.0f, 0.25f, 0.3f});
  set(levels, &StemLevel::lift_first_per_m, {0.25f, 0.5f, 0.6f});
  set(levels, &StemLevel::lift_last_per_m, {0.2f, 0.8f, 0.4f});
  set(levels, &StemLevel::wander_deg, {3.0f, 5.0f, 6.0f});
  set(levels, &StemLevel::segment_count, {12, 6, 3});
  set(levels, &StemLevel::radius_ratio, {0.04f, 0.42f, 0.55f});
  set(levels, &StemLevel::min_radius_m, {0.002f, 0.005f, 0.0025f});
  set(levels, &StemLevel::tip_radius_fraction, {0.12f, 0.25f, 0.25f});
  set(levels, &StemLevel::side_count, {7, 4, 3});
  set(levels, &StemLevel::leaves_per_m, {1.0f, 1.0f, 1.0f});
  set(levels, &StemLevel::leaf_first_fraction, {0.88f, 0.3f, 0.1f});
  return levels;
}

Species common_juniper() {
  Species species{.name = "juniper", .leaf_count = 13162, .root_depth_m = 0.06f, .root_flare = 0.4f, .min_height_m = 0.06f};
  species.height_m = 3.8f;
  species.crown_centre_fraction = 0.3f;
  species.leaf_color = {0.075f, 0.15f, 0.075f};
  species.wood_color = {0.14f, 0.085f, 0.05f};
  species.levels = juniper_levels();
  species.outline.midrib_z = {0.0f, 1.0f};
  species.outline.rim_xz = {{0.08f, 0.17f}};
  species.outline.fold = 0.5f;
  return species;
}

/// How the leaves of all species stand, in the order of all_species().
std::vector<LeafHabit> leaf_habits() {
  std::vector<LeafHabit> habits(3);
  set(habits, &LeafHabit::length_m, {0.272f, 0.4f, 0.135f});
  set(habits, &LeafHabit::length_spread, {0.2f, 0.2f, 0.25f});
  set(habits, &LeafHabit::tip_scale, {0.9f, 0.65f, 0.7f});
  set(habits, &LeafHabit::width_spread, {0.08f, 0.15f, 0.15f});
  set(habits, &LeafHabit::whorl_count, {1, 1, 3});
  set(habits, &LeafHabit::angle_deg, {62.0f, 42.0f, 47.0f});
  set(habits, &LeafHabit::angle_spread_deg, {12.0f, 12.0f, 10.0f});
  set(habits, &LeafHabit::gravity, {0.3f, 0.35f, 0.0f});
  set(habits, &LeafHabit::up_weight, {0.3f, 0.3f, 0.5f});
  set(habits, &LeafHabit::out_weight, {0.85f, 0.9f, 0.5f});
  set(habits, &LeafHabit::jitter, {0.5f, 0.5f, 0.3f});
  set(habits, &LeafHabit::petiole_m, {0.05f, 0.02f, 0.0f});
  set(habits, &LeafHabit::petiole_radius_m, {0.0022f, 0.0022f, 0.002f});
  return habits;
}

}  // namespace

std::span<const Species> all_species() {
  static const std::vector<Species> all = [] {
    std::vector<Species> species{hazel(), weeping_willow(), common_juniper()};
    const std::vector<LeafHabit> habits = leaf_habits();
    for (std::size_t i = 0; i < species.size(); ++i) species[i].habit = habits[i];
    return species;
  }();
  return all;
}

}  // namespace coppice::bake
