#pragma once

// How the normals of leaves lie: sums over their surface, which a merge adds, and their rounding to core/tree.h's 16 bits.

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

namespace coppice::bake {

/// Sums by area over a leaf's surface, m^2. Exactly additive but for the rounding of doubles, whose order the merges fix.
struct NormalSum {
  std::array<double, 6> second{};  ///< the sum of n n^T: xx, yy, zz, xy, xz, yz
  glm::dvec3 first{0.0};           ///< the sum of those n whose side an artist chose

  [[nodiscard]] double area_m2() const { return second[0] + second[1] + second[2]; }
  NormalSum& operator+=(const NormalSum& other);
  [[nodiscard]] NormalSum operator+(const NormalSum& other) const { return NormalSum(*this) += other; }
  [[nodiscard]] NormalSum operator*(double factor) const;
};

/// The sums of a piece whose normals lie about one. normal  unit; is_sided  whether light comes to the normal's side alone; along  0..1,
/// how far they lie along it: 1 if it is flat
NormalSum normal_sum(const glm::dvec3& normal, double area_m2, bool is_sided = false, double along = 1.0);

/// The sums of a quad, whichever side is lit: those of its two triangles.
NormalSum quad_normal_sum(const std::array<glm::vec3, 4>& quad);

/// Rounds to core/tree.h's bits. The axis is the eigenvector of the second moment whose other two eigenvalues differ least; of equals the
/// one with the larger eigenvalue. Without area it is kFlatNormals.
/// usual_axis  unit; it is the axis if it is within 8 degrees of it. Pages guess it, so that it takes few bits.
std::uint16_t node_normals(const NormalSum& sum, const glm::dvec3& usual_axis = glm::dvec3(0.0));

}  // namespace coppice::bake
