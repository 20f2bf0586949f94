#pragma once

#include "options.h"

namespace forest {

/// Shows or renders the forest the options describe. Returns the exit code. errors  Failure
int run(const Options& options);

}  // namespace forest
