#pragma once

#include <string>

#include "plant.h"

namespace coppice::bake {

/// What `coppice bake --dry-run` prints: a line for each material with its triangles, pieces, classes and what they became; under it its
/// largest classes, each with its reason. Ends with the totals.
std::string parts_table(const Plant& plant);

}  // namespace coppice::bake
