#pragma once

// What a simplifier makes of a plant at one number of leaves: what the evaluation draws and measures.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// How a leaf is shown beside its material.
struct LeafShade {
  float opacity = 1.0f;     ///< in (0, 1]: the share of its samples, by pixel and frame, that it covers
  float brightness = 1.0f;  ///< >= 0, times its lit colour, linear
};

/// A needle as a line: a ribbon about an axis that always turns to the camera, lit as the mean over its roll.
struct Needle {
  glm::vec3 from{0.0f}, to{0.0f};  ///< m
  float width_m = 0.0f;
  std::uint32_t material = 0;  ///< shown in its mean colour
};

inline constexpr std::size_t kVoxelNormalCount = 9;
/// Unit vectors that stand for a leaf's normal on either side: the axes, and the diagonals of the planes that they span.
const std::array<glm::dvec3, kVoxelNormalCount>& voxel_normals();

/// An axis-aligned cube filled evenly with small leaves.
struct Voxel {
  glm::vec3 center{0.0f};  ///< m
  float half_m = 0.0f;
  std::uint32_t material = 0;                      ///< shown in its mean colour
  std::array<float, kVoxelNormalCount> area_m2{};  ///< of the leaves inside, by the nearest of voxel_normals()
};

struct Level {
  Mesh mesh;
  /// Shade i is that of triangles 2i and 2i + 1, a leaf's; empty: every leaf is opaque and as bright as its material.
  std::vector<LeafShade> shades = {};
  std::vector<Needle> needles = {};
  std::vector<Voxel> voxels = {};
};

/// Triangles for surface distances: the mesh, each needle as a ribbon, and of each voxel the three squares through its middle.
Mesh level_surface(const Level& level);

/// Of all leaves: triangles, needles and what voxels are filled with. m^2
double level_area_m2(const Level& level);

/// A method's levels under one choice of its parameters.
struct Variant {
  std::string parameters;     ///< for a person: "angle .5"; empty of a method without
  std::vector<Level> levels;  ///< one per leaf count asked for
};

}  // namespace coppice::bake
