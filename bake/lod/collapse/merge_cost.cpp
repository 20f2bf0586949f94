#include "merge_cost.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tree.h"

namespace coppice::bake {

double MergeCost::at(std::uint8_t fade) const {
  const double o = static_cast<double>(opacity_of(fade)) / kOpaque;
  const double s = o * static_cast<double>(displayed_brightness(brightness_of(fade)));
  return constant + (opacity + opacity2 * o + both * s) * o + (light + light2 * s) * s;
}

std::uint8_t MergeCost::best_fade(std::uint8_t brightest) const {
  std::uint8_t best = kNoFade;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::uint8_t steps = 1; steps <= kOpaque; ++steps) {
    // At a fixed opacity the error is a parabola in brightness.
    const double o = static_cast<double>(steps) / kOpaque;
    const double brightness = light2 > 0.0 ? -(light + both * o) / (2.0 * light2 * o) : 1.0;
    const double step = std::clamp(std::round(brightness * 16.0 - 8.0), 0.0, static_cast<double>(brightest));
    const std::uint8_t fade = fade_of(steps, static_cast<std::uint8_t>(step));
    const double cost = at(fade);
    if (cost < lowest) lowest = cost, best = fade;
  }
  return best;
}

}  // namespace coppice::bake
