#pragma once

#include <string>
#include <vector>

#include "evaluate.h"

namespace coppice::bake {

/// The file of `coppice evaluate --json`: keys as in bake/lab/README.md, two spaces of indent, a newline at the end. Numbers that are not
/// finite are null.
std::string evaluation_json(const EvaluationReport& report);

/// The file for several plants: {"plants": [...]}, each as in evaluation_json.
std::string evaluations_json(const std::vector<EvaluationReport>& reports);

/// The file of `coppice evaluate --html`: one page with figures, pictures (if the report has any), style, script and charting library. It
/// loads nothing, and its content security policy makes the browser enforce that. Numbers that are not finite are null.
std::string evaluation_html(const EvaluationReport& report);

/// Checks the paper's claim: at how many levels `mi` has the lower error in close views. One line for a report in the paper's set-up with
/// both of its methods; empty for others.
std::string paper_claim(const EvaluationReport& report);

/// A table for a terminal: one block per level, one row per method, a star at the smallest of each error.
std::string evaluation_table(const EvaluationReport& report);

/// Says the figures in sentences for a person: where the first method has the smallest error, by how much, and which method is lower
/// elsewhere; how much foliage it shows; how long it takes. About `default` if it was measured, else about the first method. Empty for a
/// report without methods or levels.
std::vector<std::string> evaluation_headline(const EvaluationReport& report);

}  // namespace coppice::bake
