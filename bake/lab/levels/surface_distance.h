#pragma once

// Distance of two surfaces, as the tool Metro reports it (Cignoni, Rocchini, Scopigno 1998): sampled on one surface, exact to the other.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// Squared distance from a point to a triangle with its edges and corners, m^2. The triangle may have no area.
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
    std::uint32_t first = 0;  ///< a leaf's first triangle, else the first child; the second child follows it
    std::uint32_t count = 0;  ///< triangles of a leaf; 0: not a leaf
  };

  void split(std::uint32_t node, std::uint32_t depth, std::vector<std::uint32_t>& order,
             const std::vector<std::array<glm::dvec3, 3>>& source);
  [[nodiscard]] static double squared_distance_to_box(const glm::dvec3& point, const Box& box);
  /// Lowers `best` to the squared distance of the triangles below a node, if that is smaller.
  void lower(double& best, const glm::dvec3& point, std::uint32_t index, double box_distance) const;

  std::vector<Node> nodes_;
  std::vector<std::array<glm::dvec3, 3>> triangles_;
};

/// Points on a surface: every vertex in use, and points spread evenly over its area.
struct SurfaceSamples {
  std::vector<glm::dvec3> vertices;  ///< ascending by vertex index, each once
  std::vector<glm::dvec3> points;    ///< each stands for the same share of the area; empty if the surface has no area
};

/// Samples a mesh. The same mesh gives the same points. point_count  how many points
SurfaceSamples sample_surface(const Mesh& mesh, std::uint32_t point_count);

struct SurfaceDistance {
  double max_m = 0.0;
  double mean_m = 0.0;
};

/// Distance from the samples to the surface: the maximum over vertices and points, the mean over points (over vertices if there are none).
/// Infinite if either is empty. Parallel; the result does not depend on it.
SurfaceDistance distance_to_surface(const SurfaceSamples& from, const TriangleTree& to);

/// Hausdorff's distance: both figures are the larger of the two directions.
SurfaceDistance symmetric_distance(const SurfaceDistance& forward, const SurfaceDistance& backward);

double surface_area_m2(const Mesh& mesh);

}  // namespace coppice::bake
