#include "tube_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "check.h"
#include "skeleton.h"

namespace coppice::bake {
namespace {

struct Ring {
  glm::vec3 center{0.0f};
  glm::vec3 tangent{0.0f};
  CrossAxes axes{};
  float radius = 0.0f;
  float slope = 0.0f;  ///< change of the radius per metre: tilts the normals of a taper
  float v = 0.0f;
};

glm::vec3 tangent_at(std::span<const glm::vec3> points, std::size_t i) {
  const glm::vec3 in = i > 0 ? glm::normalize(points[i] - points[i - 1]) : glm::vec3(0.0f);
  const glm::vec3 out = i + 1 < points.size() ? glm::normalize(points[i + 1] - points[i]) : glm::vec3(0.0f);
  const glm::vec3 sum = in + out;
  return glm::length(sum) > 1e-3f ? glm::normalize(sum) : out;
}

/// Carries the cross axes along without twist: projects the previous ones into the new plane.
CrossAxes carried(const CrossAxes& previous, const glm::vec3& tangent) {
  const glm::vec3 first = previous.first - glm::dot(previous.first, tangent) * tangent;
  if (glm::length(first) < 1e-3f) return cross_axes(tangent);
  const glm::vec3 unit = glm::normalize(first);
  return {unit, glm::cross(tangent, unit)};
}

void append_ring(Mesh& mesh, const Ring& ring, std::uint32_t side_count, float u_repeats) {
  for (std::uint32_t side = 0; side <= side_count; ++side) {
    // The seam's two vertices are one position to the last bit.
    const float turn = static_cast<float>(side % side_count) / static_cast<float>(side_count);
    const float angle = 2.0f * std::numbers::pi_v<float> * turn;
    const glm::vec3 radial = std::cos(angle) * ring.axes.first + std::sin(angle) * ring.axes.second;
    mesh.positions.push_back(ring.center + ring.radius * radial);
    mesh.normals.push_back(glm::normalize(radial - ring.slope * ring.tangent));
    mesh.uvs.push_back({u_repeats * static_cast<float>(side) / static_cast<float>(side_count), ring.v});
  }
}

/// The band between two rings of a tube, which are named by their first vertices.
struct Band {
  std::uint32_t lower = 0, upper = 0;
  std::uint32_t side_count = 0;
  bool is_pointed = false;  ///< the upper ring is a point
};

void append_band(Mesh& mesh, const Band& band, std::uint32_t material) {
  for (std::uint32_t side = 0; side < band.side_count; ++side) {
    const std::uint32_t a = band.lower + side, b = band.upper + side;
    mesh.indices.insert(mesh.indices.end(), {a, a + 1, b});
    mesh.triangle_materials.push_back(material);
    if (band.is_pointed) continue;
    mesh.indices.insert(mesh.indices.end(), {a + 1, b + 1, b});
    mesh.triangle_materials.push_back(material);
  }
}

}  // namespace

void append_tube(Mesh& mesh, std::span<const glm::vec3> points, std::span<const float> radii, std::uint32_t side_count,
                 std::uint32_t material) {
  COPPICE_ASSERT(points.size() >= 2 && radii.size() == points.size() && side_count >= 3);
  const float girth_m = 2.0f * std::numbers::pi_v<float> * radii.front();
  const float u_repeats = std::max(1.0f, std::round(girth_m / kBarkTileM));
  Ring ring;
  std::uint32_t previous = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ring.center = points[i];
    ring.tangent = tangent_at(points, i);
    ring.axes = i == 0 ? cross_axes(ring.tangent) : carried(ring.axes, ring.tangent);
    ring.radius = radii[i];
    const std::size_t from = i > 0 ? i - 1 : 0;
    const float run_m = glm::distance(points[from], points[from + 1]);
    ring.slope = (radii[from + 1] - radii[from]) / run_m;
    if (i > 0) ring.v += run_m / kBarkTileM;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    append_ring(mesh, ring, side_count, u_repeats);
    if (i > 0) append_band(mesh, {previous, first, side_count, radii[i] == 0.0f}, material);
    previous = first;
  }
}

}  // namespace coppice::bake
