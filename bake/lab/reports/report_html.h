#pragma once

#include <string>

#include "evaluate.h"

namespace coppice::bake {

/// The file of `coppice evaluate --html`: one page with figures, pictures (where the report has them), style, script and charting library.
/// It loads nothing, and its content security policy makes the browser see to that. A number that is not finite is null.
std::string evaluation_html(const EvaluationReport& report);

}  // namespace coppice::bake
