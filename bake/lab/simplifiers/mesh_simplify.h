#pragma once

// The general mesh simplifiers that a user would use first: meshoptimizer on the leaf quads as one indexed mesh.

#include <cstdint>

#include "plant.h"

namespace coppice::bake {

enum class MeshSimplifier {
  /// meshopt_simplify: edge collapse by quadrics, target error 1 (the mesh's whole extent). It may stop before the target.
  collapse,
  /// meshopt_simplifySloppy, target error 1: vertices clustered on a grid, so that pieces join.
  sloppy,
};

/// Simplifies to at most triangle_count triangles, if the simplifier gets that far. Vertices stay the mesh's; a triangle shows the material
/// of its first corner's triangle. Triangles with corners in one place are left out, since they draw nothing.
/// mesh  each vertex used by triangles of one material
Mesh simplify_mesh(const Mesh& mesh, std::uint32_t triangle_count, MeshSimplifier simplifier);

}  // namespace coppice::bake
