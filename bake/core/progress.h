#pragma once

#include <functional>

namespace coppice::bake {

/// Called from the calling thread, some hundred times, with a fraction in [0, 1] that never falls.
using ProgressFunction = std::function<void(double fraction)>;

}  // namespace coppice::bake
