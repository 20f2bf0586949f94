#include "wind_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "wind_field.h"

namespace coppice::bake {
namespace {

/// Share of the limits that is used: rounding to bytes and floats may take the rest.
constexpr double kMargin = 0.999;
constexpr int kMaxSmoothings = 16;

/// A node before it becomes bytes: lean, and the sway's two phases, as shares.
struct Node {
  glm::dvec3 shares{0.0};
  double weight = 0.0;  ///< summed over the points round it
};

class Nodes {
 public:
  explicit Nodes(const WindTarget& target)
      : low_(glm::make_vec3(target.head.box_min)),
        high_(glm::make_vec3(target.head.box_max)),
        hangs_(target.hangs),
        side_(target.head.node_side),
        nodes_(wind_node_count(side_)) {}

  void add(const WindPoint& point) {
    const glm::dvec3 at = glm::clamp((glm::dvec3(point.position) - low_) / (high_ - low_), 0.0, 1.0) * static_cast<double>(side_ - 1);
    const glm::uvec3 cell = glm::min(glm::uvec3(at), glm::uvec3(side_ - 2));
    const glm::dvec3 inside = at - glm::dvec3(cell);
    const double lean = point.lean;
    const glm::dvec3 shares(lean, lean * point.phase_cos, lean * point.phase_sin);
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const std::uint32_t x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
      const double weight =
          point.weight * (x != 0 ? inside.x : 1.0 - inside.x) * (y != 0 ? inside.y : 1.0 - inside.y) * (z != 0 ? inside.z : 1.0 - inside.z);
      Node& node = nodes_[index(cell.x + x, cell.y + y, cell.z + z)];
      node.shares += weight * shares;
      node.weight += weight;
    }
  }

  /// Turns sums into means. Nodes without near points get the mean of their neighbours, from the known ones outwards.
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
        const auto mean = mean_round(i, nodes_, [&](std::size_t other) { return bool{is_known[other]}; });
        if (!mean) continue;
        nodes_[i].shares = *mean;
        next[i] = true;
      }
      is_known = std::move(next);
    }
    hold();
  }

  /// Moves each node half way to the mean of its neighbours.
  void smooth() {
    const std::vector<Node> before = nodes_;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      nodes_[i].shares = 0.5 * (before[i].shares + *mean_round(i, before, [](std::size_t) { return true; }));
    hold();
  }

  [[nodiscard]] std::span<const Node> all() const { return nodes_; }

 private:
  [[nodiscard]] std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return x + std::size_t{side_} * (y + std::size_t{side_} * z);
  }

  /// The mean of those neighbours of a node that count; nothing if none does.
  template <class Counts>
  [[nodiscard]] std::optional<glm::dvec3> mean_round(std::size_t i, const std::vector<Node>& nodes, const Counts& counts) const {
    glm::dvec3 sum(0.0);
    double count = 0.0;
    const auto add_one = [&](std::size_t other) {
      if (!counts(other)) return;
      sum += nodes[other].shares;
      count += 1.0;
    };
    std::size_t stride = 1;
    for (int axis = 0; axis < 3; ++axis, stride *= side_) {
      const std::size_t at = i / stride % side_;
      if (at > 0) add_one(i - stride);
      if (at + 1 < side_) add_one(i + stride);
    }
    if (count == 0.0) return {};
    return sum / count;
  }

  /// Stops all motion where the plant is held.
  void hold() {
    for (std::uint32_t z = 0; z < side_; ++z)
      for (std::uint32_t x = 0; x < side_; ++x) nodes_[index(x, hangs_ ? side_ - 1 : 0, z)].shares = glm::dvec3(0.0);
  }

  glm::dvec3 low_, high_;  ///< the field's box
  bool hangs_;
  std::uint32_t side_;
  std::vector<Node> nodes_;
};

bool keeps_limits(const Wind& wind, double radius_m) {
  const WindField field{wind.head, wind.nodes};
  return max_wind_move_m(field) <= kMargin * COPPICE_MAX_WIND_MOVE * radius_m &&
         max_wind_growth(field) <= kMargin * COPPICE_MAX_WIND_GROWTH;
}

/// The largest factor in [low, high] with which `of(factor)` keeps the limits; `low` if none does.
template <class WindOf>
double largest_factor(double low, double high, double radius_m, const WindOf& of) {
  if (keeps_limits(of(high), radius_m)) return high;
  for (int step = 0; step < 16; ++step) {
    const double middle = 0.5 * (low + high);
    (keeps_limits(of(middle), radius_m) ? low : high) = middle;
  }
  return low;
}

/// Stores leans as bytes; the largest becomes 255, which stands for head.lean_m.
void store_leans(std::span<const Node> nodes, Wind& wind) {
  double largest = 0.0;
  for (const Node& node : nodes) largest = std::max(largest, node.shares.x);
  wind.head.lean_m = static_cast<float>(wind.head.lean_m * largest);
  for (std::size_t i = 0; i < nodes.size() && largest > 0.0; ++i)
    wind.nodes[i].lean = static_cast<std::uint8_t>(std::lround(255.0 * nodes[i].shares.x / largest));
}

void store_sways(std::span<const Node> nodes, Wind& wind) {
  double largest = 0.0;
  for (const Node& node : nodes) largest = std::max({largest, std::abs(node.shares.y), std::abs(node.shares.z)});
  wind.head.sway_m = static_cast<float>(wind.head.sway_m * largest);
  for (std::size_t i = 0; i < nodes.size() && largest > 0.0; ++i) {
    wind.nodes[i].sway_cos = static_cast<std::int8_t>(std::lround(127.0 * nodes[i].shares.y / largest));
    wind.nodes[i].sway_sin = static_cast<std::int8_t>(std::lround(127.0 * nodes[i].shares.z / largest));
  }
}

/// Lean or sway, smoothed and scaled.
struct Fitted {
  Nodes nodes;
  double share = 0.0;
};

/// Smooths so often that the field, scaled to half of the limits, differs least from what is asked for.
/// part   1 for each component of `shares` that counts
/// store  stores lean or sway
Fitted fit(const Nodes& asked, const WindTarget& target, const glm::dvec3& part, void (*store)(std::span<const Node>, Wind&)) {
  Fitted best{asked};
  double smallest = std::numeric_limits<double>::infinity();
  Nodes nodes = asked;
  for (int pass = 0; pass <= kMaxSmoothings; ++pass) {
    if (pass > 0) nodes.smooth();
    const double share = largest_factor(0.0, 1.0, target.radius_m, [&](double factor) {
      Wind wind{target.head, std::vector<coppice_file_wind_node>(nodes.all().size())};
      wind.head.lean_m = wind.head.sway_m = static_cast<float>(2.0 * factor * target.head.lean_m);
      store(nodes.all(), wind);
      return wind;
    });
    double miss = 0.0;
    for (std::size_t i = 0; i < nodes.all().size(); ++i) {
      const glm::dvec3 off = part * (share * nodes.all()[i].shares - asked.all()[i].shares);
      miss += asked.all()[i].weight * glm::dot(off, off);
    }
    if (miss >= smallest) continue;
    smallest = miss;
    best = {nodes, share};
  }
  return best;
}

}  // namespace

Wind wind_grid(const std::vector<WindPoint>& points, const WindTarget& target) {
  Nodes asked(target);
  for (const WindPoint& point : points) asked.add(point);
  asked.finish();
  const Fitted lean = fit(asked, target, {1.0, 0.0, 0.0}, store_leans), sway = fit(asked, target, {0.0, 1.0, 1.0}, store_sways);
  // Lean and sway are not steepest in the same place, so both together may grow.
  const auto both = [&](double factor) {
    Wind wind{target.head, std::vector<coppice_file_wind_node>(asked.all().size())};
    wind.head.lean_m = static_cast<float>(target.head.lean_m * std::min(factor * lean.share, 1.0));
    wind.head.sway_m = static_cast<float>(target.head.sway_m * std::min(factor * sway.share, 1.0));
    store_leans(lean.nodes.all(), wind);
    store_sways(sway.nodes.all(), wind);
    return wind;
  };
  return both(largest_factor(1.0, 2.0, target.radius_m, both));
}

}  // namespace coppice::bake
