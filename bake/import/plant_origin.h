#pragma once

#include <cstdint>
#include <string>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// What becomes the origin of a plant: engines place, turn and scale plants about it.
enum class Origin : std::uint8_t {
  automatic,  ///< the file's, or the foot if that lies outside the plant (is_outside in plant_origin.cpp)
  keep,       ///< the file's
  foot,       ///< the middle of the wood's lowest part, without wood the leaves', at its lowest point
  center,     ///< the middle of the plant's box
};

/// Moves leaves and wood so that the origin is where `origin` says.
/// anchor  the place of the plant's (0, 0, 0) in the file, metres: plants far off their origin are read relative to one near them, as
///         floats would round their vertices
/// returns  one line with the distance if the file's origin lies outside the plant and the caller did not choose another; else empty
std::string place_origin(Plant& plant, const glm::dvec3& anchor, Origin origin);

}  // namespace coppice::bake
