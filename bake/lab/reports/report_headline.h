#pragma once

#include <string>
#include <vector>

#include "evaluate.h"

namespace coppice::bake {

/// Says the figures in sentences for a person: where the first method has the smallest error, by how much, and which method is lower
/// elsewhere; how much foliage it shows; how long it takes. About `default` if it was measured, else about the first method. Empty for a
/// report without methods or levels.
std::vector<std::string> evaluation_headline(const EvaluationReport& report);

}  // namespace coppice::bake
