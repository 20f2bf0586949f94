#pragma once

#include <string_view>

namespace coppice::bake {

/// Whether a mesh or material is called after wind: a word of its own is "wind", "sway", "bend" or "flutter".
bool names_wind(std::string_view name);

}  // namespace coppice::bake
