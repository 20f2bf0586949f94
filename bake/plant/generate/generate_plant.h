#pragma once

#include <cstdint>
#include <string_view>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// Grows one of the paper's three plants: `corylus` (hazel, 386 leaves), `willow` (4,456), `juniper` (13,162). Its two materials are
/// `leaves` and `wood`. The same species and seed give the same plant.
/// errors  invalid_argument: no such species (the three are listed)
Result<Plant> generate_plant(std::string_view species, std::uint64_t seed);

}  // namespace coppice::bake
