#include "wind_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "wind_field.h"

namespace coppice::bake {
namespace {

/// Of the limits: what rounding to bytes and floats may take.
constexpr double kMargin = 0.999;
constexpr int kMostSmoothings = 16;

/// A node before it is bytes: lean, and the sway's two phases, as shares.
struct Node {
  glm::dvec3 shares{0.0};
  double weight = 0.0;  ///< of the points round it
};

class Nodes {
 public:
  explicit Nodes(const WindTarget& target) : target_(target), side_(target.head.node_side), nodes_(wind_node_count(side_)) {}

  void add(const WindPoint& point) {
    std::array<std::uint32_t, 3> cell{};
    glm::dvec3 inside(0.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = target_.head.box_min[axis], high = target_.head.box_max[axis];
      const double at = std::clamp((point.position[static_cast<int>(axis)] - low) / (high - low), 0.0, 1.0) * (side_ - 1);
      cell[axis] = std::min(static_cast<std::uint32_t>(at), side_ - 2);
      inside[static_cast<int>(axis)] = at - cell[axis];
    }
    const double lean = point.lean;
    const glm::dvec3 shares(lean, lean * point.phase_cos, lean * point.phase_sin);
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const std::uint32_t x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      const double weight =
          point.weight * (x != 0 ? inside.x : 1.0 - inside.x) * (y != 0 ? inside.y : 1.0 - inside.y) * (z != 0 ? inside.z : 1.0 - inside.z);
      Node& node = nodes_[index(cell[0] + x, cell[1] + y, cell[2] + z)];
      node.shares += weight * shares;
      node.weight += weight;
    }
  }

  /// From sums to means; nodes that nothing is near get the mean of those next to them, from the known ones outwards.
  void finish() {
    std::vector<bool> is_known(nodes_.size());
    bool any = false;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      is_known[i] = nodes_[i].weight > 0.0;
      any = any || is_known[i];
      if (is_known[i]) nodes_[i].shares /= nodes_[i].weight;
    }
    while (any && std::ranges::find(is_known, false) != is_known.end()) {
      std::vector<bool> next = is_known;
      for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (is_known[i]) continue;
        glm::dvec3 sum(0.0);
        double count = 0.0;
        visit_neighbours(i, [&](std::size_t other) {
          if (!is_known[other]) return;
          sum += nodes_[other].shares;
          count += 1.0;
        });
        if (count == 0.0) continue;
        nodes_[i].shares = sum / count;
        next[i] = true;
      }
      is_known = std::move(next);
    }
    hold();
  }

  /// Each node half way to the mean of those next to it.
  void smooth() {
    const std::vector<Node> before = nodes_;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      glm::dvec3 sum(0.0);
      double count = 0.0;
      visit_neighbours(i, [&](std::size_t other) {
        sum += before[other].shares;
        count += 1.0;
      });
      nodes_[i].shares = 0.5 * (before[i].shares + sum / count);
    }
    hold();
  }

  /// As bytes, each kind's largest as large as bytes are.
  [[nodiscard]] Wind stored() const {
    double most_lean = 0.0, most_sway = 0.0;
    for (const Node& node : nodes_) {
      most_lean = std::max(most_lean, node.shares.x);
      most_sway = std::max({most_sway, std::abs(node.shares.y), std::abs(node.shares.z)});
    }
    Wind wind{target_.head, {}};
    wind.head.lean_m = static_cast<float>(target_.head.lean_m * most_lean);
    wind.head.sway_m = static_cast<float>(target_.head.sway_m * most_sway);
    const auto to_byte = [](double value, double most, double byte) { return most > 0.0 ? std::lround(byte * value / most) : 0L; };
    for (const Node& node : nodes_)
      wind.nodes.push_back({static_cast<std::uint8_t>(to_byte(node.shares.x, most_lean, 255.0)),
                            static_cast<std::int8_t>(to_byte(node.shares.y, most_sway, 127.0)),
                            static_cast<std::int8_t>(to_byte(node.shares.z, most_sway, 127.0)), 0});
    return wind;
  }

  /// How far points move in the mean, unscaled: what smoothing is to keep.
  [[nodiscard]] double mean_move_m() const {
    double sum = 0.0, weights = 0.0;
    for (const Node& node : nodes_) {
      const double sway = std::sqrt(node.shares.y * node.shares.y + node.shares.z * node.shares.z);
      sum += node.weight * (target_.head.lean_m * node.shares.x + target_.head.sway_m * sway);
      weights += node.weight;
    }
    return weights > 0.0 ? sum / weights : 0.0;
  }

 private:
  [[nodiscard]] std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return x + std::size_t{side_} * (y + std::size_t{side_} * z);
  }

  template <class Visit>
  void visit_neighbours(std::size_t i, const Visit& visit) const {
    std::size_t stride = 1;
    for (int axis = 0; axis < 3; ++axis, stride *= side_) {
      const std::size_t at = i / stride % side_;
      if (at > 0) visit(i - stride);
      if (at + 1 < side_) visit(i + stride);
    }
  }

  /// Nothing moves where the plant is held.
  void hold() {
    for (std::uint32_t z = 0; z < side_; ++z)
      for (std::uint32_t x = 0; x < side_; ++x) nodes_[index(x, target_.hangs ? side_ - 1 : 0, z)].shares = glm::dvec3(0.0);
  }

  const WindTarget& target_;
  std::uint32_t side_;
  std::vector<Node> nodes_;
};

WindField field_of(const Wind& wind) {
  return {wind.head, wind.nodes};
}

bool keeps_limits(const Wind& wind, double radius_m) {
  return most_wind_move_m(field_of(wind)) <= kMargin * COPPICE_MAX_WIND_MOVE * radius_m &&
         most_wind_growth(field_of(wind)) <= kMargin * COPPICE_MAX_WIND_GROWTH;
}

Wind scaled(Wind wind, double share) {
  wind.head.lean_m = static_cast<float>(wind.head.lean_m * share);
  wind.head.sway_m = static_cast<float>(wind.head.sway_m * share);
  return wind;
}

/// The largest share, up to 1, of lean and sway that keeps the limits.
double allowed_share(const Wind& wind, double radius_m) {
  if (keeps_limits(wind, radius_m)) return 1.0;
  double low = 0.0, high = 1.0;
  for (int step = 0; step < 16; ++step) {
    const double middle = 0.5 * (low + high);
    (keeps_limits(scaled(wind, middle), radius_m) ? low : high) = middle;
  }
  return low;
}

}  // namespace

Wind wind_grid(const std::vector<WindPoint>& points, const WindTarget& target) {
  Nodes nodes(target);
  for (const WindPoint& point : points) nodes.add(point);
  nodes.finish();
  Wind best;
  double most_m = -1.0;
  for (int pass = 0; pass <= kMostSmoothings; ++pass) {
    if (pass > 0) nodes.smooth();
    const Wind wind = nodes.stored();
    const double share = allowed_share(wind, target.radius_m), move_m = share * nodes.mean_move_m();
    if (move_m <= most_m) continue;
    most_m = move_m;
    best = scaled(wind, share);
  }
  return best;
}

}  // namespace coppice::bake
