#pragma once

#include <memory>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// Distance of a point from the branch that bears it: from the nearest vertex of the wood, or point along one of its long edges. Without
/// wood, from the vertical axis through the middle of the foliage's box. Calls may overlap.
class BranchDistance {
 public:
  explicit BranchDistance(const Plant& plant);
  ~BranchDistance();
  BranchDistance(const BranchDistance&) = delete;
  BranchDistance& operator=(const BranchDistance&) = delete;

  /// The branch's nearest point: the wood bears a leaf there if the leaf's stalk is at `point`.
  [[nodiscard]] glm::vec3 nearest_point(const glm::vec3& point) const;
  [[nodiscard]] float distance_m(const glm::vec3& point) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;  ///< null without wood
  glm::vec3 axis_{0.0f};
};

}  // namespace coppice::bake
