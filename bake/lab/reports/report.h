#pragma once

#include <string>
#include <vector>

#include "evaluate.h"

namespace coppice::bake {

/// The file of `coppice evaluate --json`: keys as in bake/README.md, two spaces of indent, a newline at the end. A number that is not
/// finite is null.
std::string evaluation_json(const EvaluationReport& report);

/// Of several plants: {"plants": [...]}, each as evaluation_json has it.
std::string evaluations_json(const std::vector<EvaluationReport>& reports);

/// In the paper's set-up, of reports that have both of its methods: at how many of the levels `mi` has the lower error close up, the
/// paper's claim. One line; empty of others.
std::string paper_claim(const EvaluationReport& report);

/// A table for a terminal: one block per level, one row per method, the least of each error marked with a star.
std::string evaluation_table(const EvaluationReport& report);

}  // namespace coppice::bake
