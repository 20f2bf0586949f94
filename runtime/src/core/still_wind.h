#pragma once

#include "coppice/format.h"

namespace coppice {

/// The WIND of a plant that wind does not move, or whose WIND is unknown.
inline constexpr coppice_file_wind kStillWind{0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f, {0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, 0u};

}  // namespace coppice
