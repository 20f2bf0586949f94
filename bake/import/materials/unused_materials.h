#pragma once

#include "plant.h"

namespace coppice::bake {

/// Drops materials that no card, leaf mesh or wood uses, and images that no material uses, and renumbers the rest.
void drop_unused_materials(BakedPlant& plant);

}  // namespace coppice::bake
