#pragma once

// A simplifier's result for a plant at one number of leaves. The evaluation draws and measures it.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"
#include "tree.h"

namespace coppice::bake {

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
  Mesh mesh;  ///< triangles 2i and 2i + 1 are a leaf; its opacity is the share of samples, over pixels and frames, that it covers
  /// [triangle] How the normals lie of the leaves that the triangle stands for; empty: each triangle is flat and lit as it lies.
  std::vector<ShadingNormals> normals = {};
  std::vector<Needle> needles = {};
  std::vector<Voxel> voxels = {};
};

/// A mesh whose triangles are lit by the normals and alongs of their first corners; as they lie if the mesh has no alongs.
Level level_of(Mesh mesh);

/// Leaves as they were modelled. Triangles of materials with sided normals are lit by the mean of their corners' normals, on that side; the
/// others as they lie.
Level modelled_level(Mesh mesh, std::span<const Material> materials);

/// Unit; 0 for a triangle without area.
glm::dvec3 face_normal(const Mesh& mesh, std::size_t triangle);

/// Normals of a flat surface that has no front. normal  unit
ShadingNormals flat_normals(const glm::dvec3& normal);

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
