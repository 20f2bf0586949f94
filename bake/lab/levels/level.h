#pragma once

// A simplifier's result for a plant at one number of leaves. The evaluation draws and measures it.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"

namespace coppice::bake {

/// How a leaf's look differs from its material's.
struct LeafShade {
  float opacity = 1.0f;     ///< in (0, 1]: the share of samples, over pixels and frames, that the leaf covers
  float brightness = 1.0f;  ///< >= 0; a linear factor of its lit colour
};

/// A needle as a line: a ribbon about an axis. It always turns to the camera and is lit by the mean over its roll.
struct Needle {
  glm::vec3 from{0.0f}, to{0.0f};  ///< m
  float width_m = 0.0f;
  std::uint32_t material = 0;  ///< its mean colour shows
};

inline constexpr std::size_t kVoxelNormalCount = 9;
/// Unit vectors that approximate a leaf's normal, on either side: the axes, and the diagonals of the planes that they span.
const std::array<glm::dvec3, kVoxelNormalCount>& voxel_normals();

/// An axis-aligned cube filled evenly with small leaves.
struct Voxel {
  glm::vec3 center{0.0f};  ///< m
  float half_m = 0.0f;
  std::uint32_t material = 0;                      ///< its mean colour shows
  std::array<float, kVoxelNormalCount> area_m2{};  ///< area of the leaves inside, by the nearest of voxel_normals()
};

struct Level {
  Mesh mesh;
  /// [leaf] the shade of its triangles 2i and 2i + 1; empty: every leaf is opaque and as bright as its material.
  std::vector<LeafShade> shades = {};
  std::vector<Needle> needles = {};
  std::vector<Voxel> voxels = {};
};

/// Triangles for surface distances: the mesh, a ribbon for each needle, and for each voxel the three squares through its centre.
Mesh level_surface(const Level& level);

/// Area of all leaves: triangles, needles and the contents of voxels, m^2.
double level_area_m2(const Level& level);

/// A method's levels for one choice of its parameters.
struct Variant {
  std::string parameters;     ///< for a person: "angle .5"; empty for a method without parameters
  std::vector<Level> levels;  ///< one per requested leaf count
};

}  // namespace coppice::bake
