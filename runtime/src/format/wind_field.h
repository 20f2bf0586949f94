#pragma once

// How wind moves a plant: a bending stem, and a small grid of how far places lean and sway. FORMAT.md, "WIND".

#include <cstddef>
#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "result.h"

namespace coppice {

/// A plant's wind in the file. Refers to the nodes.
struct WindField {
  coppice_file_wind head{};
  std::span<const coppice_file_wind_node> nodes;  ///< [head.node_side^3] x fastest, then y, then z
};

/// The grid's values at a place, as shares of lean_m and sway_m.
struct WindSample {
  float lean = 0.0f;      ///< 0..1
  float sway_cos = 0.0f;  ///< -1..1
  float sway_sin = 0.0f;  ///< -1..1
};

/// Number of nodes of a grid.
inline std::size_t wind_node_count(std::uint32_t node_side) {
  return std::size_t{node_side} * node_side * node_side;
}

/// Share of the plant's height at y_m, 0..1. The stem bends by its square times bend_m.
float wind_height_share(const coppice_file_wind& head, float y_m);

/// How far the top comes down in full wind, m, since the stem keeps its length; lower places by the cube of their share of the height.
double wind_fall_m(const coppice_file_wind& head);

/// Samples the grid at a place, object space, m: trilinear between nodes; a place outside the box has the values of the box's nearest
/// point; zeros without a grid.
/// field  checked by check_wind_field
WindSample sample_wind(const WindField& field, const float (&position)[3]);

/// Maximum distance that full wind moves any point, m: bend_m + fall + lean_m lean + sway_m |sway|, at the node where that is largest.
double max_wind_move_m(const WindField& field);

/// Maximum motion of two points against each other by lean and sway in full wind, as a share of their distance: a bound on the sum of their
/// gradients, cell by cell, as FORMAT.md says.
double max_wind_growth(const WindField& field);

/// at  offset of WIND in the file. errors  bad_file: the first field outside its range
Result<void> check_wind_head(const coppice_file_wind& head, std::uint64_t at);

/// Checks the nodes, and nodes and head together. before: the head has passed check_wind_head, and the number of nodes is right
/// errors  bad_file: a node's field, or more than COPPICE_MAX_WIND_BEND of the height, COPPICE_MAX_WIND_MOVE of the radius or
///         COPPICE_MAX_WIND_GROWTH
Result<void> check_wind_field(const WindField& field, double sphere_radius_m, std::uint64_t at);

}  // namespace coppice
