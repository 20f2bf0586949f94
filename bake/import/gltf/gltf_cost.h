#pragma once

// What an import will take, told from a document alone. The measure is the triangle: everything that a few bytes of a document can ask for
// many times counts as so many triangles as take its memory.

#include <cstdint>
#include <span>

#include <nlohmann/json_fwd.hpp>

#include "result.h"

namespace coppice::bake {

/// The memory that counts as a triangle: an import takes 600 to 900 bytes for one of three vertices.
inline constexpr std::uint64_t kBytesOfATriangle = 1024;
/// No plant has more triangles: 3 * 2^25 vertices still have 32-bit numbers.
inline constexpr std::uint32_t kMaxSourceTriangles = 1u << 25;

struct CostLimit {
  std::uint64_t max_triangles = 0;  ///< 0: as many as usable_memory_bytes() holds, at most kMaxSourceTriangles
  bool places_only = false;         ///< meshes are not read, only where they stand: each instance counts as one triangle

  [[nodiscard]] std::uint64_t triangles() const;
};

/// What a mesh takes. All sums in this file stay at the largest number when they overflow.
struct MeshCost {
  std::uint64_t triangles = 0;             ///< in each place that it stands; a primitive counts as at least one
  std::uint64_t lines = 0;                 ///< triangles that its lines become, wherever it stands
  std::uint64_t vertices = 0, values = 0;  ///< of all primitives: vertices, and vertices times attributes

  /// Adds a checked primitive. counts  [accessors]. returns  the primitive's triangles
  std::uint64_t add(const nlohmann::json& primitive, std::span<const std::uint64_t> counts);
};

/// Sums up what the default scene of a checked document takes: triangles in all their places, posed vertices, matrices of skins, and
/// buffers that are files, which many buffers may share.
/// meshes  [meshes]; counts  [accessors]
/// returns  the triangles in all their places
/// errors   unsupported: the sum is above the limit; `detail` has it, the limit and the largest part with its place
Result<std::uint64_t> check_cost(const nlohmann::json& document, std::span<const MeshCost> meshes, std::span<const std::uint64_t> counts,
                                 const CostLimit& limit);

}  // namespace coppice::bake
