#pragma once

#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// [card] The share of it that is no hole, sampled at 16 x 16 points.
/// errors  those of alpha_masks
Result<std::vector<double>> card_coverage(const std::vector<Card>& cards, const std::vector<Material>& materials,
                                          const std::vector<Image>& images);

/// Where a quad's card shows (s, t), both in [0, 1], s from corner 0 to 1 and t from 0 to 3: bilinear. quad_point is the same for its
/// corners in space.
glm::dvec2 card_point(const Card& card, double s, double t);
glm::dvec3 quad_point(const Quad& quad, double s, double t);

}  // namespace coppice::bake
