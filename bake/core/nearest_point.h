#pragma once

// Only modules that link nanoflann include this.

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>
#include <nanoflann.hpp>

namespace coppice::bake {

/// Finds the nearest of at least one point. Calls may overlap.
template <class Real>
class NearestPoint {
  using Point = glm::vec<3, Real>;

 public:
  /// leaf_points  how many points the tree's leaves may have
  NearestPoint(std::vector<Point> points, std::size_t leaf_points)
      : cloud_{std::move(points)}, index_(3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(leaf_points)) {}
  NearestPoint(const NearestPoint&) = delete;
  NearestPoint& operator=(const NearestPoint&) = delete;

  [[nodiscard]] std::uint32_t to(const Point& place) const {
    std::uint32_t nearest = 0;
    Real squared_m2 = 0;
    index_.knnSearch(&place.x, 1, &nearest, &squared_m2);
    return nearest;
  }
  [[nodiscard]] const Point& point(std::uint32_t index) const { return cloud_.points[index]; }

 private:
  // nanoflann requires these names.
  struct Cloud {
    std::vector<Point> points;
    [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
    [[nodiscard]] Real kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<int>(axis)]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };

  Cloud cloud_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<Real, Cloud>, Cloud, 3, std::uint32_t> index_;
};

}  // namespace coppice::bake
