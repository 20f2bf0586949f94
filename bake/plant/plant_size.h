#pragma once

#include <array>
#include <string>

#include "plant.h"

namespace coppice::bake {

/// Width (x), height (y) and depth (z) of leaves and wood, metres.
std::array<double, 3> plant_size_m(const Plant& plant);

/// Writes a size as "5.31 m high, 3.1 x 3.2 m wide".
std::string size_text(const std::array<double, 3>& size_m);

/// Warns of a plant larger than 120 m or smaller than 1 cm, with the unit that its file may be in; empty for any other.
/// metres_per_unit  the unit in which the file was read
std::string size_warning(const std::array<double, 3>& size_m, double metres_per_unit);

}  // namespace coppice::bake
