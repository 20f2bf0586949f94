#pragma once

// How far what a merged leaf stands for is from it.

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// The outermost source vertices below a node: of a leaf all four, of a merged leaf at most 14, the farthest each way along seven axes.
using ReachPoints = std::vector<glm::vec3>;

ReachPoints reach_points(const Quad& quad);
/// Of two nodes' points those of their parent. Ties go to the first point, `first` before `second`.
ReachPoints merged_reach_points(const ReachPoints& first, const ReachPoints& second);

/// The largest of the points' squared distances to a quad's two triangles, m^2.
double squared_reach(const ReachPoints& points, const Quad& quad);

}  // namespace coppice::bake
