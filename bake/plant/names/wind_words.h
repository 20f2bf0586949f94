#pragma once

#include <string_view>

namespace coppice::bake {

/// Whether a mesh or material is named after wind: one of its words is "wind", "sway", "bend" or "flutter".
bool names_wind(std::string_view name);

}  // namespace coppice::bake
