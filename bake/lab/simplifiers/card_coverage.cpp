#include "card_coverage.h"

#include "visibility.h"

namespace coppice::bake {
namespace {

constexpr int kSteps = 16;

template <class Point, class Corners>
Point bilinear(const Corners& corners, double s, double t) {
  return (1.0 - t) * ((1.0 - s) * Point(corners[0]) + s * Point(corners[1])) + t * ((1.0 - s) * Point(corners[3]) + s * Point(corners[2]));
}

}  // namespace

glm::dvec2 card_point(const Card& card, double s, double t) {
  return bilinear<glm::dvec2>(card.uv, s, t);
}

glm::dvec3 quad_point(const Quad& quad, double s, double t) {
  return bilinear<glm::dvec3>(quad, s, t);
}

Result<std::vector<double>> card_coverage(const std::vector<Card>& cards, const std::vector<Material>& materials,
                                          const std::vector<Image>& images) {
  COPPICE_TRY(masks, alpha_masks(materials, images));
  std::vector<double> coverage;
  for (const Card& card : cards) {
    int covered = 0;
    for (int y = 0; y < kSteps; ++y)
      for (int x = 0; x < kSteps; ++x)
        if (!masks[card.material].is_hole(card_point(card, (x + 0.5) / kSteps, (y + 0.5) / kSteps))) ++covered;
    coverage.push_back(static_cast<double>(covered) / (kSteps * kSteps));
  }
  return coverage;
}

}  // namespace coppice::bake
