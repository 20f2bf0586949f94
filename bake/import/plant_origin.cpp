#include "plant_origin.h"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

using Box = PointBox<glm::dvec3>;

Box box_above(const Mesh& mesh, Box box) {
  for (const glm::vec3& position : mesh.positions) box.add(position);
  return box;
}

double largest(const glm::dvec3& size) {
  return std::max({size.x, size.y, size.z});
}

/// How far a point lies from the box, along each axis.
glm::dvec3 gap_to(const Box& box, const glm::dvec3& point) {
  return glm::max(glm::max(box.low - point, point - box.high), 0.0);
}

/// Whether a plant with this gap to its origin stands elsewhere. Stems lean and vines start beside their foot; crowns hang above theirs,
/// and hanging plants below.
bool is_outside(const glm::dvec3& gap, const Box& box) {
  constexpr double kBeside = 0.1, kAbove = 1.0;
  const double size = largest(box.extent());
  return std::max(gap.x, gap.z) > kBeside * size || gap.y > kAbove * size;
}

glm::dvec3 foot_of(const Plant& plant, const Box& box) {
  constexpr double kSlice = 0.15, kHighestFoot = 0.5;
  const Box wood = box_above(plant.wood, {});
  // Twigs alone, without a stem, are no foot.
  const bool has_stem = !plant.wood.positions.empty() && wood.low.y <= box.low.y + kHighestFoot * box.extent().y;
  const Box& all = has_stem ? wood : box;
  Box slice;
  for (const Mesh* mesh : {&plant.wood, &plant.foliage})
    if (mesh == &plant.wood || !has_stem)
      for (const glm::vec3& position : mesh->positions)
        if (position.y <= all.low.y + kSlice * all.extent().y) slice.add(position);
  return {0.5 * (slice.low.x + slice.high.x), all.low.y, 0.5 * (slice.low.z + slice.high.z)};
}

void move(Plant& plant, const glm::dvec3& by) {
  if (by == glm::dvec3(0.0)) return;
  for (Mesh* mesh : {&plant.wood, &plant.foliage})
    for (glm::vec3& position : mesh->positions) position = glm::vec3(glm::dvec3(position) + by);
}

}  // namespace

std::string place_origin(Plant& plant, const glm::dvec3& anchor, Origin origin) {
  const Box box = box_above(plant.foliage, box_above(plant.wood, {}));
  const glm::dvec3 gap = gap_to(box, -anchor);
  const bool outside = is_outside(gap, box);
  glm::dvec3 target = -anchor;
  if (origin == Origin::foot || (origin == Origin::automatic && outside)) target = foot_of(plant, box);
  if (origin == Origin::center) target = 0.5 * (box.low + box.high);
  move(plant, -target);
  if (!outside || origin == Origin::foot || origin == Origin::center) return {};
  const double gap_m = glm::length(gap);
  const std::string line = "the plant stands " + formatted(gap_m < 1e4 ? "%.4g" : "%.0f", gap_m) + " m from its origin";
  return line +
         (origin == Origin::keep ? " (--origin foot or center moves it)" : ": the origin is moved to its foot (--origin keep leaves it)");
}

}  // namespace coppice::bake
