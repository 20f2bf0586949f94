#pragma once

#include <string>
#include <vector>

#include "evaluate.h"

namespace coppice::bake {

/// What the figures say, in sentences for a person: where the first method has the least error, by how much, and who is lower where it has
/// not; how much foliage it shows; how long it takes. About `default` when it was measured, else about the first method. Empty for a report
/// without methods or levels.
std::vector<std::string> evaluation_headline(const EvaluationReport& report);

}  // namespace coppice::bake
