#pragma once

#include <array>
#include <string>

#include "plant.h"

namespace coppice::bake {

/// Width (x), height (y) and depth (z) of leaves and wood.
std::array<double, 3> plant_size_m(const Plant& plant);

/// "5.31 m high, 3.1 x 3.2 m wide"
std::string size_text(const std::array<double, 3>& size_m);

/// What to say of a plant that is larger than 120 m or smaller than 1 cm, with the unit that its file may be in; empty for any other.
/// metres_per_unit  by which it was read
std::string size_warning(const std::array<double, 3>& size_m, double metres_per_unit);

}  // namespace coppice::bake
