#pragma once

#include <ostream>
#include <string_view>
#include <vector>

#include "plant.h"

namespace coppice::bake::test {

/// A plant whose wood is thin, many, or both: what simplifiers lose first.
struct WoodPlant {
  std::string_view name;
  Plant (*grow)();  ///< same plant every time
};

inline void PrintTo(const WoodPlant& each, std::ostream* out) {
  *out << each.name;
}

/// bamboo: culms of internodes that do not touch, fine twigs, all leaves high up; flowers: a head on each thin stem; baubles: a decorated
/// conifer; cactus: a ribbed body with spines, no leaves; oak_foot: a trunk with buttresses and rough bark; snow_pine: caps on boughs.
std::vector<WoodPlant> wood_plants();

}  // namespace coppice::bake::test
