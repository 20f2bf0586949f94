#include "merge_cost.h"

#include "tree.h"

namespace coppice::bake {

double MergeCost::at(std::uint8_t opacity_steps) const {
  const double o = static_cast<double>(opacity_steps) / kOpaque;
  return constant + (opacity + opacity2 * o) * o;
}

std::uint8_t MergeCost::best_opacity() const {
  std::uint8_t best = 1;
  for (std::uint8_t steps = 2; steps <= kOpaque; ++steps)
    if (at(steps) < at(best)) best = steps;
  return best;
}

}  // namespace coppice::bake
