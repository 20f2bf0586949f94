#pragma once

// How far two surfaces are apart: what the tool Metro reports (Cignoni, Rocchini, Scopigno 1998), sampled from one surface, exact to the
// other.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// Squared distance of a point to a triangle, edges and corners included; the triangle may have no area. m^2
double squared_distance_to_triangle(const glm::dvec3& point, const std::array<glm::dvec3, 3>& triangle);

/// A bounding volume hierarchy over a mesh's triangles. Calls may overlap.
class TriangleTree {
 public:
  explicit TriangleTree(const Mesh& mesh);

  /// Exact squared distance to the nearest triangle, m^2; infinite without triangles.
  [[nodiscard]] double squared_distance(const glm::dvec3& point) const;

 private:
  struct Box {
    glm::dvec3 low{0.0}, high{0.0};
  };
  struct Node {
    Box box;
    std::uint32_t first = 0;  ///< of a leaf its first triangle, else its first child; the second follows it
    std::uint32_t count = 0;  ///< triangles of a leaf; 0: not a leaf
  };

  void split(std::uint32_t node, std::uint32_t depth, std::vector<std::uint32_t>& order,
             const std::vector<std::array<glm::dvec3, 3>>& source);
  [[nodiscard]] static double squared_distance_to_box(const glm::dvec3& point, const Box& box);

  std::vector<Node> nodes_;
  std::vector<std::array<glm::dvec3, 3>> triangles_;
};

/// Points on a surface: every vertex in use, and points spread evenly over its area.
struct SurfaceSamples {
  std::vector<glm::dvec3> vertices;  ///< ascending by vertex index, each once
  std::vector<glm::dvec3> points;    ///< each stands for the same share of the area; empty for a surface without area
};

/// point_count  points; the same mesh gives the same ones
SurfaceSamples sample_surface(const Mesh& mesh, std::uint32_t point_count);

struct SurfaceDistance {
  double max_m = 0.0;
  double mean_m = 0.0;
};

/// From the samples to the surface: the maximum over vertices and points, the mean over points (over vertices when there are none).
/// Infinite when either is empty. Parallel; the result does not depend on it.
SurfaceDistance distance_to_surface(const SurfaceSamples& from, const TriangleTree& to);

/// Hausdorff's: the larger of the two directions, of both figures.
SurfaceDistance symmetric_distance(const SurfaceDistance& forward, const SurfaceDistance& backward);

/// Sum of the areas of the triangles, m^2.
double surface_area_m2(const Mesh& mesh);

}  // namespace coppice::bake
