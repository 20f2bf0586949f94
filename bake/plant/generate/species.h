#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

namespace coppice::bake {

/// How the stems of one branching level grow: level 0 rises from the ground, the others from the level below.
struct StemLevel {
  float spacing_m = 1.0f;                             ///< between children along the parent; level 0: radius of the ring the stems stand on
  std::uint32_t min_count = 1, max_count = 1000;      ///< per parent; level 0: how many stems, drawn from [min, max]
  float first_fraction = 0.0f, last_fraction = 1.0f;  ///< part of the parent that bears children
  float length_m = 1.0f;
  float length_spread = 0.15f;  ///< +- this fraction of the length
  /// Length factor at the first, the 1/3, the 2/3 and the last child position (level 0: from the inner to the outer stems): the crown's
  /// outline.
  std::array<float, 4> length_profile{1.0f, 1.0f, 1.0f, 1.0f};
  float angle_first_deg = 45.0f, angle_last_deg = 45.0f;  ///< from the parent's axis, at the first and the last child position
  float angle_spread_deg = 8.0f;
  float light = 0.0f;                                     ///< weight of the way up and out of the crown in a stem's first direction
  float lift_first_per_m = 0.0f, lift_last_per_m = 0.0f;  ///< pull upwards (negative: weight downwards) at the stem's start and end
  float wander_deg = 4.0f;                                ///< random turn at every segment
  std::uint32_t segment_count = 6;
  float radius_ratio = 0.6f;  ///< relative to the parent's radius where the stem starts; level 0: radius in metres
  float min_radius_m = 0.002f;
  float tip_radius_fraction = 0.25f;  ///< relative to the stem's first radius, just before the pointed end
  std::uint32_t side_count = 4;
  float leaves_per_m = 0.0f;         ///< relative density: the total is scaled to the species' exact leaf count
  float leaf_first_fraction = 0.0f;  ///< leaves stand from here to the tip
};

/// A leaf's outline in units of its length: x to the side, y along the upper surface's normal, z from stalk (0) to tip (1).
struct LeafOutline {
  std::vector<float> midrib_z;               ///< ascending, first 0, last 1
  std::vector<std::array<float, 2>> rim_xz;  ///< one side, from stalk to tip, z ascending
  float fold = 0.0f;                         ///< height gained per unit of distance from the midrib: a V along it
  float arch = 0.0f;                         ///< how far the tip bends down
  float ripple = 0.0f;                       ///< rim points alternate by this much up and down
};

/// How leaves stand on their twig.
struct LeafHabit {
  float length_m = 0.1f;
  float length_spread = 0.2f;  ///< +- this fraction of the length
  float tip_scale = 0.8f;      ///< length factor at the twig's tip, where leaves are young
  float width_spread = 0.1f;
  std::uint32_t whorl_count = 1;  ///< leaves at one node: 1 gives a golden-angle spiral, k gives k around, turned half a step each node
  float angle_deg = 50.0f;        ///< from the twig's axis
  float angle_spread_deg = 10.0f;
  float gravity = 0.0f;                       ///< pull of the tip downwards
  float up_weight = 1.0f, out_weight = 0.5f;  ///< the direction the upper surface turns to: towards the light
  float jitter = 0.2f;                        ///< randomness of that direction
  float petiole_m = 0.0f;                     ///< 0: the leaf sits on the twig
  float petiole_radius_m = 0.002f;
};

/// How the leaf's image is painted. There is none if it has no texels: a needle of two triangles is its own quad.
struct LeafPaint {
  std::uint32_t width_px = 0, height_px = 0;
  std::uint32_t side_vein_count = 0;                             ///< on each side
  float side_vein_slope = 0.0f;                                  ///< way along the leaf per way to the rim
  float vein_width = 0.01f;                                      ///< leaf lengths
  glm::vec3 blade{0.8f, 0.83f, 0.78f}, vein{1.0f, 1.0f, 0.86f};  ///< linear factors of the leaf colour
};

/// All parameters of one species. Colours are linear.
struct Species {
  std::string_view name;
  std::uint32_t leaf_count = 0;
  float root_depth_m = 0.1f;           ///< how far the stems reach below the ground, for slopes
  float root_flare = 0.5f;             ///< radius gained at the ground, as a fraction
  float min_height_m = 0.1f;           ///< stems end here on their way down
  float crown_centre_fraction = 0.5f;  ///< share of the height where "out of the crown" starts
  float height_m = 1.0f;               ///< nominal
  std::vector<StemLevel> levels;
  LeafOutline outline;
  LeafHabit habit;
  LeafPaint paint;
  glm::vec3 leaf_color{0.1f, 0.2f, 0.05f}, wood_color{0.2f, 0.15f, 0.1f};
};

/// All species, in the order of the paper's Table I.
std::span<const Species> all_species();

}  // namespace coppice::bake
