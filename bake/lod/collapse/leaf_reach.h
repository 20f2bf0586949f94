#pragma once

// The distance between a merged leaf and the ends of the leaves that it replaces.

#include "plant.h"

namespace coppice::bake {

/// The outermost source vertices below a node: all four for a leaf, at most 14 for a merged leaf, the farthest each way along seven axes.
using ReachPoints = std::vector<glm::vec3>;

inline ReachPoints reach_points(const Quad& quad) {
  return {quad.begin(), quad.end()};
}
/// Selects the parent's points from those of two nodes. Ties go to the first point, `first` before `second`.
ReachPoints merged_reach_points(const ReachPoints& first, const ReachPoints& second);

/// The largest of the points' squared distances to a quad's two triangles, m^2.
double squared_reach(const ReachPoints& points, const Quad& quad);

}  // namespace coppice::bake
