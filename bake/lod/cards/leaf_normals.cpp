#include "leaf_normals.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "parallel_for.h"

namespace coppice::bake {
namespace {

/// Sums by area of the faces round each vertex: what an exporter writes where nobody chose normals.
std::vector<glm::dvec3> smooth_normals(const Mesh& mesh) {
  std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const std::array<glm::vec3, 3> corners = at_corners(mesh.positions, mesh.indices, i);
    const glm::dvec3 across = glm::cross(glm::dvec3(corners[1] - corners[0]), glm::dvec3(corners[2] - corners[0]));
    for (std::size_t k = 0; k < 3; ++k) sums[mesh.indices[i + k]] += across;
  }
  return sums;
}

/// A leaf's triangle. In a cut that was exported it stands for many leaves (Mesh::vertex_alongs).
struct Facet {
  glm::dvec3 face{0.0};    ///< unit, or 0 without area
  glm::dvec3 normal{0.0};  ///< the mean of its vertices', unit, or `face`
  double area_m2 = 0.0;
  double along = 1.0;
  bool is_sided = false;
};

Facet facet_of(const Mesh& mesh, std::size_t triangle) {
  const std::array<glm::vec3, 3> corners = at_corners(mesh.positions, mesh.indices, 3 * triangle);
  const std::array<glm::vec3, 3> normals = at_corners(mesh.normals, mesh.indices, 3 * triangle);
  const glm::dvec3 across = glm::cross(glm::dvec3(corners[1] - corners[0]), glm::dvec3(corners[2] - corners[0]));
  const glm::dvec3 sum = glm::dvec3(normals[0]) + glm::dvec3(normals[1]) + glm::dvec3(normals[2]);
  const double twice_m2 = glm::length(across), length = glm::length(sum);
  Facet facet;
  if (!(twice_m2 > 0.0)) return facet;
  facet.face = across / twice_m2;
  facet.normal = length > 1e-3 ? sum / length : facet.face;
  facet.area_m2 = 0.5 * twice_m2;
  if (!mesh.vertex_alongs.empty()) {
    const float along = mesh.vertex_alongs[mesh.indices[3 * triangle]];
    facet.along = std::abs(static_cast<double>(along));
    facet.is_sided = std::signbit(along);
  }
  return facet;
}

template <class Visit>
void for_each_facet(const Mesh& foliage, const LeafRange& leaf, Visit&& visit) {
  for (std::size_t t = leaf.first_triangle; t < std::size_t{leaf.first_triangle} + leaf.triangle_count; ++t) visit(t, facet_of(foliage, t));
}

}  // namespace

void find_sided_normals(Plant& plant) {
  const Mesh& foliage = plant.foliage;
  if (!foliage.vertex_alongs.empty()) {  // a cut that was exported says it leaf by leaf
    for (std::size_t t = 0; t < foliage.triangle_materials.size(); ++t)
      if (std::signbit(foliage.vertex_alongs[foliage.indices[3 * t]])) plant.materials[foliage.triangle_materials[t]].sided_normals = true;
    return;
  }
  // Normals that smooth a bent leaf lie within some 30 degrees of its faces; of a folded one farther, but near the sum of the faces.
  constexpr double kMinAgreement = 0.8;
  const std::vector<glm::dvec3> smooth = smooth_normals(foliage);
  const auto smoothness = [&](std::size_t t) {
    double worst = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = foliage.indices[3 * t + k];
      const double length = glm::length(smooth[vertex]);
      // Where the faces cancel the importer, or an exporter, made up a normal.
      if (length > 0.0) worst = std::min(worst, std::abs(glm::dot(glm::dvec3(foliage.normals[vertex]), smooth[vertex])) / length);
    }
    return worst;
  };
  std::vector<double> agreement(plant.materials.size(), 0.0), area_m2(plant.materials.size(), 0.0);
  for (const LeafRange& leaf : plant.leaves)
    for_each_facet(plant.foliage, leaf, [&](std::size_t t, const Facet& facet) {
      const std::uint32_t material = foliage.triangle_materials[t];
      agreement[material] += facet.area_m2 * std::max(std::abs(glm::dot(facet.normal, facet.face)), smoothness(t));
      area_m2[material] += facet.area_m2;
    });
  for (std::size_t m = 0; m < plant.materials.size(); ++m) {
    if (plant.materials[m].sided_normals || !(agreement[m] < kMinAgreement * area_m2[m])) continue;
    plant.materials[m].sided_normals = true;
    plant.warnings.push_back("material '" + plant.materials[m].name +
                             "': the normals of its leaves are not those of their faces; they are lit by them, on one side");
  }
}

void turn_normals_to_crown(Plant& plant, float share) {
  if (!(share > 0.0f) || plant.leaves.empty()) return;
  const auto [low, high] = box_of(plant.foliage.positions);
  const glm::vec3 center = 0.5f * (low + high), radii = glm::max(0.5f * (high - low), glm::vec3(1e-3f));
  for (std::size_t i = 0; i < plant.foliage.positions.size(); ++i) {
    glm::vec3& normal = plant.foliage.normals[i];
    const glm::vec3 outward = glm::normalize((plant.foliage.positions[i] - center) / (radii * radii) + glm::vec3(0.0f, 1e-4f, 0.0f));
    // The leaf's side that faces out of the crown; in between, where its curl passes from one to the other, neither.
    const float side = std::clamp(4.0f * glm::dot(normal, outward), -1.0f, 1.0f);
    const glm::vec3 turned = side * (1.0f - share) * normal + share * outward;
    normal = glm::dot(turned, turned) > 1e-12f ? glm::normalize(turned) : outward;
  }
  for (const std::uint32_t material : plant.foliage.triangle_materials) plant.materials[material].sided_normals = true;
}

void add_leaf_normals(const Plant& plant, Foliage& foliage) {
  constexpr std::uint32_t kMinFlatAlongStep = 12;  // a smaller share along the axis is a leaf that is bent so much that its light shows it
  const std::size_t count = plant.leaves.size();
  foliage.normal_sums.assign(count, {});
  foliage.normals.assign(count, kFlatNormals);
  parallel_for(count, [&](std::size_t leaf) {
    bool is_sided = false;
    for_each_facet(plant.foliage, plant.leaves[leaf], [&](std::size_t t, const Facet& facet) {
      const bool sided = facet.is_sided || plant.materials[plant.foliage.triangle_materials[t]].sided_normals;
      is_sided |= sided;
      if (!(facet.area_m2 > 0.0)) return;
      const bool is_whole = plant.foliage.vertex_alongs.empty() && !sided;
      foliage.normal_sums[leaf] += normal_sum(is_whole ? facet.face : facet.normal, facet.area_m2, sided, facet.along);
    });
    const Quad& quad = foliage.quads[leaf];
    const glm::dvec3 spine(quad[1] + quad[2] - quad[0] - quad[3]);  // about what a leaf is folded, as a rule
    const double length = glm::length(spine);
    const std::uint16_t normals = node_normals(foliage.normal_sums[leaf], is_sided || length == 0.0 ? glm::dvec3(0.0) : spine / length);
    const bool is_merged = !plant.foliage.vertex_alongs.empty();
    if (is_sided || is_merged || along_step_of(normals) < kMinFlatAlongStep) {
      foliage.normals[leaf] = normals;
      return;
    }
    // The quad's normal, and the leaf's area, which counts for bent leaves too.
    const NormalSum own = quad_normal_sum(quad);
    if (own.area_m2() > 0.0) foliage.normal_sums[leaf] = own * (foliage.normal_sums[leaf].area_m2() / own.area_m2());
  });
}

}  // namespace coppice::bake
