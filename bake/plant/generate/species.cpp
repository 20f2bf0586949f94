#include "species.h"

#include <initializer_list>
#include <type_traits>

#include "check.h"

// Parameter tables of the three plants. Shapes follow the plants' habit (Corylus avellana: many arching stems from one stool, broad toothed
// leaves; Salix babylonica: short trunk, arching limbs, curtains of hanging twigs; Juniperus communis: a dense flame of ascending branches,
// awl-shaped needles in threes). Leaves are two to seven times as long as botany has them: the paper's leaf counts must cover a full crown.

namespace coppice::bake {
namespace {

template <class Part>
Part& part_of(Species& species) {
  if constexpr (std::is_same_v<Part, Species>)
    return species;
  else if constexpr (std::is_same_v<Part, LeafOutline>)
    return species.outline;
  else
    return species.habit;
}

/// A row of a table: the values of one parameter of all species.
template <class Part, class T>
void set(std::vector<Species>& all, T Part::*parameter, std::type_identity_t<std::initializer_list<T>> values) {
  COPPICE_ASSERT(values.size() == all.size());
  for (std::size_t i = 0; i < all.size(); ++i) part_of<Part>(all[i]).*parameter = values.begin()[i];
}

/// The same for stems: for each species its values at all levels, from the ground up.
template <class T>
void set_levels(std::vector<Species>& all, T StemLevel::*parameter,
                std::type_identity_t<std::initializer_list<std::initializer_list<T>>> values) {
  COPPICE_ASSERT(values.size() == all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::initializer_list<T> of = values.begin()[i];
    all[i].levels.resize(of.size());
    for (std::size_t level = 0; level < of.size(); ++level) all[i].levels[level].*parameter = of.begin()[level];
  }
}

std::vector<Species> make_species() {
  std::vector<Species> species(3);
  set(species, &Species::name, {"corylus", "willow", "juniper"});
  set(species, &Species::leaf_count, {386, 4456, 13162});
  set(species, &Species::root_depth_m, {0.06f, 0.15f, 0.06f});
  set(species, &Species::root_flare, {0.35f, 0.6f, 0.4f});
  set(species, &Species::min_height_m, {0.2f, 0.6f, 0.06f});
  set(species, &Species::crown_centre_fraction, {0.35f, 0.6f, 0.3f});
  set(species, &Species::height_m, {3.0f, 7.6f, 3.8f});
  set(species, &Species::leaf_color, {{0.105f, 0.225f, 0.04f}, {0.155f, 0.265f, 0.055f}, {0.075f, 0.15f, 0.075f}});
  set(species, &Species::wood_color, {{0.16f, 0.11f, 0.07f}, {0.115f, 0.092f, 0.068f}, {0.14f, 0.085f, 0.05f}});
  // Width and height, px; number and slope of the side veins; width of all veins.
  set(species, &Species::paint, {{128, 128, 8, 0.75f, 0.016f}, {32, 128, 0, 0.0f, 0.008f}, {}});
  set(species, &LeafOutline::midrib_z, {{0.0f, 0.17f, 0.36f, 0.56f, 0.78f, 1.0f}, {0.0f, 0.45f, 1.0f}, {0.0f, 1.0f}});
  species[0].outline.rim_xz = {{0.13f, 0.01f},  {0.29f, 0.06f}, {0.41f, 0.2f},   {0.395f, 0.27f}, {0.48f, 0.41f},  {0.44f, 0.475f},
                               {0.475f, 0.61f}, {0.4f, 0.66f},  {0.365f, 0.78f}, {0.255f, 0.80f}, {0.175f, 0.89f}, {0.075f, 0.92f}};
  species[1].outline.rim_xz = {{0.06f, 0.14f}, {0.085f, 0.42f}, {0.05f, 0.76f}};
  species[2].outline.rim_xz = {{0.08f, 0.17f}};
  set(species, &LeafOutline::fold, {0.2f, 0.3f, 0.5f});
  set(species, &LeafOutline::arch, {0.14f, 0.12f, 0.0f});
  set(species, &LeafOutline::ripple, {0.012f, 0.0f, 0.0f});
  set(species, &LeafHabit::length_m, {0.272f, 0.4f, 0.135f});
  set(species, &LeafHabit::length_spread, {0.2f, 0.2f, 0.25f});
  set(species, &LeafHabit::tip_scale, {0.9f, 0.65f, 0.7f});
  set(species, &LeafHabit::width_spread, {0.08f, 0.15f, 0.15f});
  set(species, &LeafHabit::whorl_count, {1, 1, 3});
  set(species, &LeafHabit::angle_deg, {62.0f, 42.0f, 47.0f});
  set(species, &LeafHabit::angle_spread_deg, {12.0f, 12.0f, 10.0f});
  set(species, &LeafHabit::gravity, {0.3f, 0.35f, 0.0f});
  set(species, &LeafHabit::up_weight, {0.3f, 0.3f, 0.5f});
  set(species, &LeafHabit::out_weight, {0.85f, 0.9f, 0.5f});
  set(species, &LeafHabit::jitter, {0.5f, 0.5f, 0.3f});
  set(species, &LeafHabit::petiole_m, {0.05f, 0.02f, 0.0f});
  set(species, &LeafHabit::petiole_radius_m, {0.0022f, 0.0022f, 0.002f});
  // The hazel's stems, branches and twigs; the willow's trunk, limbs, branches and twigs; the juniper's trunks, branches and twigs.
  set_levels(species, &StemLevel::spacing_m, {{0.2f, 0.25f, 0.21f}, {0.0f, 0.26f, 0.36f, 0.3f}, {0.08f, 0.085f, 0.08f}});
  set_levels(species, &StemLevel::min_count, {{8, 6, 1}, {1, 12, 3, 2}, {3, 20, 3}});
  set_levels(species, &StemLevel::max_count, {{8, 12, 4}, {1, 18, 8, 6}, {3, 50, 10}});
  set_levels(species, &StemLevel::first_fraction, {{0.0f, 0.1f, 0.3f}, {0.0f, 0.4f, 0.35f, 0.2f}, {0.0f, 0.03f, 0.25f}});
  set_levels(species, &StemLevel::last_fraction, {{1.0f, 0.93f, 0.85f}, {1.0f, 0.98f, 1.0f, 1.0f}, {1.0f, 0.97f, 0.92f}});
  set_levels(species, &StemLevel::length_m, {{3.0f, 0.68f, 0.28f}, {5.4f, 2.7f, 1.1f, 2.9f}, {3.4f, 0.78f, 0.34f}});
  set_levels(species, &StemLevel::length_spread, {{0.1f, 0.2f, 0.2f}, {0.05f, 0.08f, 0.2f, 0.25f}, {0.06f, 0.18f, 0.25f}});
  set_levels(species, &StemLevel::length_profile,
             {{{1.1f, 1.02f, 0.92f, 0.8f}, {0.8f, 1.0f, 1.0f, 0.65f}, {1.0f, 1.0f, 0.8f, 0.6f}},
              {{1.0f, 1.0f, 1.0f, 1.0f}, {0.85f, 1.0f, 0.95f, 0.65f}, {1.0f, 1.0f, 0.9f, 0.7f}, {1.0f, 1.0f, 1.0f, 1.0f}},
              {{1.1f, 1.0f, 0.9f, 0.8f}, {0.75f, 1.0f, 0.8f, 0.3f}, {0.9f, 1.0f, 0.9f, 0.6f}}});
  set_levels(species, &StemLevel::angle_first_deg, {{6.0f, 62.0f, 55.0f}, {0.0f, 55.0f, 55.0f, 50.0f}, {1.0f, 58.0f, 48.0f}});
  set_levels(species, &StemLevel::angle_last_deg, {{19.0f, 50.0f, 45.0f}, {4.0f, 25.0f, 25.0f, 30.0f}, {4.5f, 30.0f, 36.0f}});
  set_levels(species, &StemLevel::angle_spread_deg, {{3.0f, 8.0f, 8.0f}, {2.0f, 8.0f, 8.0f, 8.0f}, {1.5f, 8.0f, 8.0f}});
  set_levels(species, &StemLevel::light, {{0.0f, 0.4f, 0.3f}, {0.0f, 0.15f, 0.15f, 0.0f}, {0.0f, 0.25f, 0.3f}});
  set_levels(species, &StemLevel::lift_first_per_m, {{0.1f, 0.5f, 0.4f}, {0.06f, 0.3f, 0.1f, -2.0f}, {0.25f, 0.5f, 0.6f}});
  set_levels(species, &StemLevel::lift_last_per_m, {{-0.3f, -0.1f, 0.0f}, {0.05f, -0.9f, -1.0f, -2.6f}, {0.2f, 0.8f, 0.4f}});
  set_levels(species, &StemLevel::wander_deg, {{2.5f, 7.0f, 9.0f}, {3.5f, 5.0f, 6.0f, 4.0f}, {3.0f, 5.0f, 6.0f}});
  set_levels(species, &StemLevel::segment_count, {{12, 6, 3}, {14, 10, 5, 8}, {12, 6, 3}});
  set_levels(species, &StemLevel::radius_ratio, {{0.026f, 0.5f, 0.6f}, {0.24f, 0.5f, 0.55f, 0.5f}, {0.04f, 0.42f, 0.55f}});
  set_levels(species, &StemLevel::min_radius_m, {{0.002f, 0.005f, 0.003f}, {0.002f, 0.02f, 0.008f, 0.004f}, {0.002f, 0.005f, 0.0025f}});
  set_levels(species, &StemLevel::tip_radius_fraction, {{0.2f, 0.25f, 0.25f}, {0.2f, 0.25f, 0.25f, 0.25f}, {0.12f, 0.25f, 0.25f}});
  set_levels(species, &StemLevel::side_count, {{7, 5, 3}, {12, 7, 5, 3}, {7, 4, 3}});
  set_levels(species, &StemLevel::leaves_per_m, {{1.3f, 1.0f, 1.0f}, {0.0f, 0.6f, 0.9f, 1.0f}, {1.0f, 1.0f, 1.0f}});
  set_levels(species, &StemLevel::leaf_first_fraction, {{0.85f, 0.5f, 0.4f}, {0.0f, 0.5f, 0.35f, 0.03f}, {0.88f, 0.3f, 0.1f}});
  return species;
}

}  // namespace

std::span<const Species> all_species() {
  static const std::vector<Species> all = make_species();
  return all;
}

}  // namespace coppice::bake
