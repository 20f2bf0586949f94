#include "collapse.h"

#include <algorithm>
#include <string>

namespace coppice::bake {

Result<void> check_candidate_count(const CollapseOptions& options) {
  if (options.candidate_count >= 1 && options.candidate_count <= kMaxCandidateCount) return {};
  return Error{Status::invalid_argument, "number of candidates is not between 1 and 4096", Error::kNoOffset,
               std::to_string(options.candidate_count)};
}

std::vector<std::uint32_t> level_leaf_counts(std::uint32_t leaf_count) {
  std::vector<std::uint32_t> counts;
  for (const std::uint64_t thousandths : {800u, 600u, 400u, 200u, 100u, 50u, 25u})
    counts.push_back(std::max(1u, static_cast<std::uint32_t>(leaf_count * thousandths / 1000)));
  return counts;
}

}  // namespace coppice::bake
