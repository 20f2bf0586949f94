#include "collapse.h"

#include <algorithm>

namespace coppice::bake {

std::vector<std::uint32_t> level_leaf_counts(std::uint32_t leaf_count) {
  std::vector<std::uint32_t> counts;
  for (const std::uint64_t thousandths : {800u, 600u, 400u, 200u, 100u, 50u, 25u})
    counts.push_back(std::max(1u, static_cast<std::uint32_t>(leaf_count * thousandths / 1000)));
  return counts;
}

}  // namespace coppice::bake
