#include "wind_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "file_fields.h"

namespace coppice {
namespace {

using Node = coppice_file_wind_node;
using Cell = std::array<std::uint32_t, 3>;

/// Length of a sway, or of a difference of two, -1..1.
double length(int sway_cos, int sway_sin) {
  return std::sqrt(double(sway_cos * sway_cos + sway_sin * sway_sin)) / 127.0;
}

std::size_t node_index(std::uint32_t side, const Cell& at) {
  return at[0] + std::size_t{side} * (at[1] + std::size_t{side} * at[2]);
}

/// Maximum slopes of lean and sway in a cell.
struct Slopes {
  double lean_per_m = 0.0, sway_per_m = 0.0;
};

/// Slopes along one axis: the largest difference along the cell's four edges over the length. Inside the cell the derivative of a trilinear
/// field is a mean of these four.
Slopes axis_slopes(const WindField& field, const Cell& cell, std::size_t axis, double edge_m) {
  Slopes maximum;
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    if ((corner >> axis & 1) != 0) continue;
    const auto node = [&](std::uint32_t bits) -> const Node& {
      return field.nodes[node_index(field.head.node_side, {cell[0] + (bits & 1), cell[1] + (bits >> 1 & 1), cell[2] + (bits >> 2 & 1)})];
    };
    const Node &from = node(corner), &to = node(corner | 1u << axis);
    maximum.lean_per_m = std::max(maximum.lean_per_m, std::abs(to.lean - from.lean) / 255.0 / edge_m);
    maximum.sway_per_m = std::max(maximum.sway_per_m, length(to.sway_cos - from.sway_cos, to.sway_sin - from.sway_sin) / edge_m);
  }
  return maximum;
}

double cell_growth(const WindField& field, const Cell& cell) {
  const coppice_file_wind& head = field.head;
  const std::uint32_t cells = head.node_side - 1;
  double lean_squared = 0.0, sway_squared = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double edge_m = (double{head.box_max[axis]} - head.box_min[axis]) / cells;
    const Slopes slopes = axis_slopes(field, cell, axis, edge_m);
    lean_squared += slopes.lean_per_m * slopes.lean_per_m;
    sway_squared += slopes.sway_per_m * slopes.sway_per_m;
  }
  return head.lean_m * std::sqrt(lean_squared) + head.sway_m * std::sqrt(sway_squared);
}

struct NamedField {
  const char* name;
  float value, minimum, maximum;
  std::size_t offset;
};

}  // namespace

double wind_fall_m(const coppice_file_wind& head) {
  return 2.0 / 3.0 * head.bend_m * head.bend_m / head.height_m;
}

float wind_height_share(const coppice_file_wind& head, float y_m) {
  return std::clamp((y_m - head.base_y_m) / head.height_m, 0.0f, 1.0f);
}

WindSample sample_wind(const WindField& field, const float (&position)[3]) {
  const coppice_file_wind& head = field.head;
  if (head.node_side == 0) return {};
  Cell cell;
  std::array<float, 3> inside;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float share = (position[axis] - head.box_min[axis]) / (head.box_max[axis] - head.box_min[axis]);
    const float at = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(head.node_side - 1);
    cell[axis] = std::min(static_cast<std::uint32_t>(at), head.node_side - 2);
    inside[axis] = at - static_cast<float>(cell[axis]);
  }
  WindSample sample;
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    float weight = 1.0f;
    Cell at = cell;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t bit = corner >> axis & 1;
      at[axis] += bit;
      weight *= bit != 0 ? inside[axis] : 1.0f - inside[axis];
    }
    const Node& node = field.nodes[node_index(head.node_side, at)];
    sample.lean += weight * static_cast<float>(node.lean) / 255.0f;
    sample.sway_cos += weight * static_cast<float>(node.sway_cos) / 127.0f;
    sample.sway_sin += weight * static_cast<float>(node.sway_sin) / 127.0f;
  }
  return sample;
}

double max_wind_move_m(const WindField& field) {
  double most_m = 0.0;
  for (const Node& node : field.nodes)
    most_m = std::max(most_m, field.head.lean_m * (node.lean / 255.0) + field.head.sway_m * length(node.sway_cos, node.sway_sin));
  return field.head.bend_m + wind_fall_m(field.head) + most_m;
}

double max_wind_growth(const WindField& field) {
  const std::uint32_t cells = std::max(field.head.node_side, 1u) - 1;
  double maximum = 0.0;
  for (std::uint32_t z = 0; z < cells; ++z)
    for (std::uint32_t y = 0; y < cells; ++y)
      for (std::uint32_t x = 0; x < cells; ++x) maximum = std::max(maximum, cell_growth(field, {x, y, z}));
  return maximum;
}

Result<void> check_wind_head(const coppice_file_wind& head, std::uint64_t at) {
  constexpr float kMaximum = 3.402823466e38f;  // bounds finite values
  constexpr float kMinExtent_m = 1e-30f;       // shaders divide by it
  const NamedField fields[] = {
      {"wind base_y_m", head.base_y_m, -kMaximum, kMaximum, offsetof(coppice_file_wind, base_y_m)},
      {"wind height_m", head.height_m, 0.0f, kMaximum, offsetof(coppice_file_wind, height_m)},
      {"wind bend_m", head.bend_m, 0.0f, kMaximum, offsetof(coppice_file_wind, bend_m)},
      {"wind lean_m", head.lean_m, 0.0f, kMaximum, offsetof(coppice_file_wind, lean_m)},
      {"wind sway_m", head.sway_m, 0.0f, kMaximum, offsetof(coppice_file_wind, sway_m)},
      {"wind stem_period_s", head.stem_period_s, COPPICE_MIN_WIND_PERIOD_S, COPPICE_MAX_WIND_PERIOD_S,
       offsetof(coppice_file_wind, stem_period_s)},
      {"wind branch_period_s", head.branch_period_s, COPPICE_MIN_WIND_PERIOD_S, COPPICE_MAX_WIND_PERIOD_S,
       offsetof(coppice_file_wind, branch_period_s)},
  };
  for (const NamedField& field : fields)
    if (!(field.value >= field.minimum && field.value <= field.maximum))
      return bad_field(field.name, at + field.offset, "outside its range");
  if (!(head.height_m >= kMinExtent_m)) return bad_field("wind height_m", at + offsetof(coppice_file_wind, height_m), "not 1e-30 or more");
  for (int axis = 0; axis < 3; ++axis) {
    const float low = head.box_min[axis], high = head.box_max[axis];
    if (!std::isfinite(low) || !std::isfinite(high) || !std::isfinite(high - low) || !(high - low >= kMinExtent_m))
      return bad_field("wind box", at + offsetof(coppice_file_wind, box_min), "not a finite box of 1e-30 m or more on every axis");
  }
  const std::uint32_t side = head.node_side;
  if (side != 0 && side != 2 && side != 4 && side != 8)
    return bad_field("wind node_side", at + offsetof(coppice_file_wind, node_side), std::to_string(side) + " is not 0, 2, 4 or 8");
  if (side == 0 && (head.lean_m > 0.0f || head.sway_m > 0.0f))
    return bad_field("wind lean_m", at + offsetof(coppice_file_wind, lean_m), "lean or sway without a grid");
  return {};
}

Result<void> check_wind_field(const WindField& field, double sphere_radius_m, std::uint64_t at) {
  for (std::size_t i = 0; i < field.nodes.size(); ++i) {
    const std::uint64_t node_at = at + sizeof(coppice_file_wind) + i * sizeof(Node);
    const Node& node = field.nodes[i];
    if (node.sway_cos < -127 || node.sway_sin < -127) return bad_field("wind node sway", node_at + offsetof(Node, sway_cos), "-128");
    if (node.reserved != 0) return bad_field("wind node reserved", node_at + offsetof(Node, reserved), "must be zero");
  }
  if (!(field.head.bend_m <= COPPICE_MAX_WIND_BEND * field.head.height_m))
    return bad_field("wind bend", at + offsetof(coppice_file_wind, bend_m),
                     std::to_string(field.head.bend_m) + " m, more than 0.4 height_m");
  if (const double move_m = max_wind_move_m(field); !(move_m <= COPPICE_MAX_WIND_MOVE * sphere_radius_m))
    return bad_field("wind move", at + offsetof(coppice_file_wind, bend_m),
                     std::to_string(move_m) + " m, more than 0.8 of the sphere's radius");
  if (const double growth = max_wind_growth(field); !(growth <= COPPICE_MAX_WIND_GROWTH))
    return bad_field("wind growth", at + offsetof(coppice_file_wind, bend_m), std::to_string(growth) + " is more than 0.08");
  return {};
}

}  // namespace coppice
