#pragma once

// Parts that several families' trees share.

#include <cstdint>

#include "plant_shapes.h"

namespace coppice::test {

/// A trunk of 3 m with six stout branches.
Shape bare_tree();

/// A trunk of 2.6 m that forks into two boughs, all one surface, as a skin modifier makes it.
Shape forked_tree(float foot_radius_m);

/// Cards of 26 x 39 cm, evenly in a crown of 2.4 m about 2.6 m up, in every direction.
Shape crown_of_cards(std::uint32_t count);

/// The same, their stalks in two rows up a stem from `low_m` to `high_m`.
Shape leaves_up_a_stem(std::uint32_t count, float low_m, float high_m);

/// An oval green leaf with a midrib; the rest is a hole, as green as the leaf.
Rgba oval_leaf(float u, float v);

/// Brown, with lighter and darker furrows.
Rgba furrowed_bark(float u, float v);

}  // namespace coppice::test
