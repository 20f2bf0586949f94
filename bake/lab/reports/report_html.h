#pragma once

#include <string>

#include "evaluate.h"

namespace coppice::bake {

/// The file of `coppice evaluate --html`: one page with figures, pictures (if the report has any), style, script and charting library. It
/// loads nothing, and its content security policy makes the browser enforce that. Numbers that are not finite are null.
std::string evaluation_html(const EvaluationReport& report);

}  // namespace coppice::bake
