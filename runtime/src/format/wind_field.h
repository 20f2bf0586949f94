#pragma once

// How wind moves a plant: a stem that bends, and a small grid of what leans and sways beyond that. FORMAT.md, "WIND".

#include <cstddef>
#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "result.h"

namespace coppice {

/// A plant's wind, as a file has it. Refers to the nodes.
struct WindField {
  coppice_file_wind head{};
  std::span<const coppice_file_wind_node> nodes;  ///< [head.node_side^3] x fastest, then y, then z
};

/// What the grid says of a place, as shares of lean_m and sway_m.
struct WindSample {
  float lean = 0.0f;      ///< 0..1
  float sway_cos = 0.0f;  ///< -1..1
  float sway_sin = 0.0f;  ///< -1..1
};

/// Nodes of a grid of so many a side.
inline std::size_t wind_node_count(std::uint32_t node_side) {
  return std::size_t{node_side} * node_side * node_side;
}

/// The share of the plant's height at y_m, 0..1: its square, times bend_m, is how far the stem bends there.
float wind_height_share(const coppice_file_wind& head, float y_m);

/// The grid at a place, object space, m: trilinear between nodes, of the box's nearest point outside the box; zeros without a grid.
/// field  that check_wind_field takes
WindSample sample_wind(const WindField& field, const float (&position)[3]);

/// How far full wind moves any point at most, m: bend_m + lean_m lean + sway_m |sway| of the node where that is largest.
double most_wind_move_m(const WindField& field);

/// The most by which full wind moves two points against each other, as a share of their distance: a bound on the sum of the three terms'
/// gradients, cell by cell, as FORMAT.md has it.
double most_wind_growth(const WindField& field);

/// at  of WIND in the file. errors  bad_file: the first field outside its range
Result<void> check_wind_head(const coppice_file_wind& head, std::uint64_t at);

/// The nodes, and what they and the head say together; the head has passed check_wind_head and nodes are as many as it says.
/// errors  bad_file: a node's field, or more than COPPICE_MAX_WIND_MOVE of the radius or COPPICE_MAX_WIND_GROWTH
Result<void> check_wind_field(const WindField& field, double sphere_radius_m, std::uint64_t at);

}  // namespace coppice
