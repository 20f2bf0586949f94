#include "leaf_scale.h"

#include "quad_merge.h"

namespace coppice::bake {

Quad scaled_quad(const Quad& quad, double factor) {
  const glm::dvec3 centroid = quad_centroid(quad);
  Quad scaled{};
  for (std::size_t i = 0; i < 4; ++i) scaled[i] = glm::vec3(centroid + factor * (glm::dvec3(quad[i]) - centroid));
  return scaled;
}

}  // namespace coppice::bake
