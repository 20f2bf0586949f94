#pragma once

#include <string>

#include "plant.h"

namespace coppice::bake {

/// The table that `coppice bake --dry-run` prints: a line for each material with its triangles, pieces, classes and what they became, and
/// below it its largest classes, each with its reason. Totals come last.
std::string parts_table(const Plant& plant);

}  // namespace coppice::bake
