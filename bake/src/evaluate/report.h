#pragma once

#include <string>

#include "evaluate.h"

namespace coppice::bake {

/// The file of `coppice evaluate --json`: keys as in bake/README.md, two spaces of indent, a newline at the end. A number that is not
/// finite is null.
std::string evaluation_json(const EvaluationReport& report);

/// A table for a terminal: one block per level, one row per method, the least of each error marked with a star.
std::string evaluation_table(const EvaluationReport& report);

}  // namespace coppice::bake
