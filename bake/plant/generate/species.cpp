#include "species.h"

// Parameter tables of the three plants. Shapes follow the plants' habit (Corylus avellana: many arching stems from one stool, broad toothed
// leaves; Salix babylonica: short trunk, arching limbs, curtains of hanging twigs; Juniperus communis: a dense flame of ascending branches,
// awl-shaped needles in threes). Leaves are two to seven times as long as botany has them: the paper's leaf counts must cover a full crown.

namespace coppice::bake {
namespace {

std::vector<StemLevel> hazel_levels() {
  StemLevel stems{.spacing_m = 0.2f, .min_count = 8, .max_count = 8};
  stems.length_m = 3.0f;
  stems.length_spread = 0.1f;
  stems.length_profile = {1.1f, 1.02f, 0.92f, 0.8f};
  stems.angle_first_deg = 6.0f;
  stems.angle_last_deg = 19.0f;
  stems.angle_spread_deg = 3.0f;
  stems.lift_first_per_m = 0.1f;
  stems.lift_last_per_m = -0.3f;
  stems.wander_deg = 2.5f;
  stems.segment_count = 12;
  stems.radius_ratio = 0.026f;
  stems.tip_radius_fraction = 0.2f;
  stems.side_count = 7;
  stems.leaves_per_m = 1.3f;
  stems.leaf_first_fraction = 0.85f;

  StemLevel branches{.spacing_m = 0.25f, .min_count = 6, .max_count = 12, .first_fraction = 0.1f, .last_fraction = 0.93f};
  branches.length_m = 0.68f;
  branches.length_spread = 0.2f;
  branches.length_profile = {0.8f, 1.0f, 1.0f, 0.65f};
  branches.angle_first_deg = 62.0f;
  branches.angle_last_deg = 50.0f;
  branches.light = 0.4f;
  branches.lift_first_per_m = 0.5f;
  branches.lift_last_per_m = -0.1f;
  branches.wander_deg = 7.0f;
  branches.segment_count = 6;
  branches.radius_ratio = 0.5f;
  branches.min_radius_m = 0.005f;
  branches.side_count = 5;
  branches.leaves_per_m = 1.0f;
  branches.leaf_first_fraction = 0.5f;

  StemLevel twigs{.spacing_m = 0.21f, .min_count = 1, .max_count = 4, .first_fraction = 0.3f, .last_fraction = 0.85f};
  twigs.length_m = 0.28f;
  twigs.length_spread = 0.2f;
  twigs.length_profile = {1.0f, 1.0f, 0.8f, 0.6f};
  twigs.angle_first_deg = 55.0f;
  twigs.light = 0.3f;
  twigs.lift_first_per_m = 0.4f;
  twigs.wander_deg = 9.0f;
  twigs.segment_count = 3;
  twigs.min_radius_m = 0.003f;
  twigs.side_count = 3;
  twigs.leaves_per_m = 1.0f;
  twigs.leaf_first_fraction = 0.4f;
  return {stems, branches, twigs};
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
  species.habit.length_m = 0.272f;
  species.habit.tip_scale = 0.9f;
  species.habit.width_spread = 0.08f;
  species.habit.angle_deg = 62.0f;
  species.habit.angle_spread_deg = 12.0f;
  species.habit.gravity = 0.3f;
  species.habit.up_weight = 0.3f;
  species.habit.out_weight = 0.85f;
  species.habit.jitter = 0.5f;
  species.habit.petiole_m = 0.05f;
  species.habit.petiole_radius_m = 0.0022f;
  species.paint = {.width_px = 128, .height_px = 128, .side_vein_count = 8, .side_vein_slope = 0.75f, .vein_width = 0.016f};
  return species;
}

std::vector<StemLevel> willow_levels() {
  StemLevel trunk{.spacing_m = 0.0f, .min_count = 1, .max_count = 1};
  trunk.length_m = 5.4f;
  trunk.length_spread = 0.05f;
  trunk.angle_first_deg = 0.0f;
  trunk.angle_last_deg = 4.0f;
  trunk.angle_spread_deg = 2.0f;
  trunk.lift_first_per_m = 0.06f;
  trunk.lift_last_per_m = 0.05f;
  trunk.wander_deg = 3.5f;
  trunk.segment_count = 14;
  trunk.radius_ratio = 0.24f;
  trunk.tip_radius_fraction = 0.2f;
  trunk.side_count = 12;

  StemLevel limbs{.spacing_m = 0.26f, .min_count = 12, .max_count = 18, .first_fraction = 0.4f, .last_fraction = 0.98f};
  limbs.length_m = 2.7f;
  limbs.length_spread = 0.08f;
  limbs.length_profile = {0.85f, 1.0f, 0.95f, 0.65f};
  limbs.angle_first_deg = 55.0f;
  limbs.angle_last_deg = 25.0f;
  limbs.light = 0.15f;
  limbs.lift_first_per_m = 0.3f;
  limbs.lift_last_per_m = -0.9f;
  limbs.wander_deg = 5.0f;
  limbs.segment_count = 10;
  limbs.radius_ratio = 0.5f;
  limbs.min_radius_m = 0.02f;
  limbs.side_count = 7;
  limbs.leaves_per_m = 0.6f;
  limbs.leaf_first_fraction = 0.5f;

  StemLevel branches{.spacing_m = 0.36f, .min_count = 3, .max_count = 8, .first_fraction = 0.35f, .last_fraction = 1.0f};
  branches.length_m = 1.1f;
  branches.length_spread = 0.2f;
  branches.length_profile = {1.0f, 1.0f, 0.9f, 0.7f};
  branches.angle_first_deg = 55.0f;
  branches.angle_last_deg = 25.0f;
  branches.light = 0.15f;
  branches.lift_first_per_m = 0.1f;
  branches.lift_last_per_m = -1.0f;
  branches.wander_deg = 6.0f;
  branches.segment_count = 5;
  branches.radius_ratio = 0.55f;
  branches.min_radius_m = 0.008f;
  branches.side_count = 5;
  branches.leaves_per_m = 0.9f;
  branches.leaf_first_fraction = 0.35f;

  StemLevel twigs{.spacing_m = 0.3f, .min_count = 2, .max_count = 6, .first_fraction = 0.2f, .last_fraction = 1.0f};
  twigs.length_m = 2.9f;
  twigs.length_spread = 0.25f;
  twigs.angle_first_deg = 50.0f;
  twigs.angle_last_deg = 30.0f;
  twigs.lift_first_per_m = -2.0f;
  twigs.lift_last_per_m = -2.6f;
  twigs.segment_count = 8;
  twigs.radius_ratio = 0.5f;
  twigs.min_radius_m = 0.004f;
  twigs.side_count = 3;
  twigs.leaves_per_m = 1.0f;
  twigs.leaf_first_fraction = 0.03f;
  return {trunk, limbs, branches, twigs};
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
  species.habit.length_m = 0.4f;
  species.habit.tip_scale = 0.65f;
  species.habit.width_spread = 0.15f;
  species.habit.angle_deg = 42.0f;
  species.habit.angle_spread_deg = 12.0f;
  species.habit.gravity = 0.35f;
  species.habit.up_weight = 0.3f;
  species.habit.out_weight = 0.9f;
  species.habit.jitter = 0.5f;
  species.habit.petiole_m = 0.02f;
  species.habit.petiole_radius_m = 0.0022f;
  species.paint = {.width_px = 32, .height_px = 128, .side_vein_count = 0, .side_vein_slope = 0.0f, .vein_width = 0.008f};
  return species;
}

std::vector<StemLevel> juniper_levels() {
  StemLevel trunks{.spacing_m = 0.08f, .min_count = 3, .max_count = 3};
  trunks.length_m = 3.4f;
  trunks.length_spread = 0.06f;
  trunks.length_profile = {1.1f, 1.0f, 0.9f, 0.8f};
  trunks.angle_first_deg = 1.0f;
  trunks.angle_last_deg = 4.5f;
  trunks.angle_spread_deg = 1.5f;
  trunks.lift_first_per_m = 0.25f;
  trunks.lift_last_per_m = 0.2f;
  trunks.wander_deg = 3.0f;
  trunks.segment_count = 12;
  trunks.radius_ratio = 0.04f;
  trunks.tip_radius_fraction = 0.12f;
  trunks.side_count = 7;
  trunks.leaves_per_m = 1.0f;
  trunks.leaf_first_fraction = 0.88f;

  StemLevel branches{.spacing_m = 0.085f, .min_count = 20, .max_count = 50, .first_fraction = 0.03f, .last_fraction = 0.97f};
  branches.length_m = 0.78f;
  branches.length_spread = 0.18f;
  branches.length_profile = {0.75f, 1.0f, 0.8f, 0.3f};
  branches.angle_first_deg = 58.0f;
  branches.angle_last_deg = 30.0f;
  branches.light = 0.25f;
  branches.lift_first_per_m = 0.5f;
  branches.lift_last_per_m = 0.8f;
  branches.wander_deg = 5.0f;
  branches.segment_count = 6;
  branches.radius_ratio = 0.42f;
  branches.min_radius_m = 0.005f;
  branches.side_count = 4;
  branches.leaves_per_m = 1.0f;
  branches.leaf_first_fraction = 0.3f;

  StemLevel twigs{.spacing_m = 0.08f, .min_count = 3, .max_count = 10, .first_fraction = 0.25f, .last_fraction = 0.92f};
  twigs.length_m = 0.34f;
  twigs.length_spread = 0.25f;
  twigs.length_profile = {0.9f, 1.0f, 0.9f, 0.6f};
  twigs.angle_first_deg = 48.0f;
  twigs.angle_last_deg = 36.0f;
  twigs.light = 0.3f;
  twigs.lift_first_per_m = 0.6f;
  twigs.lift_last_per_m = 0.4f;
  twigs.wander_deg = 6.0f;
  twigs.segment_count = 3;
  twigs.radius_ratio = 0.55f;
  twigs.min_radius_m = 0.0025f;
  twigs.side_count = 3;
  twigs.leaves_per_m = 1.0f;
  twigs.leaf_first_fraction = 0.1f;
  return {trunks, branches, twigs};
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
  species.habit.length_m = 0.135f;
  species.habit.length_spread = 0.25f;
  species.habit.tip_scale = 0.7f;
  species.habit.width_spread = 0.15f;
  species.habit.whorl_count = 3;
  species.habit.angle_deg = 47.0f;
  species.habit.up_weight = 0.5f;
  species.habit.jitter = 0.3f;
  return species;
}

}  // namespace

std::span<const Species> all_species() {
  static const std::array<Species, 3> species{hazel(), weeping_willow(), common_juniper()};
  return species;
}

}  // namespace coppice::bake
