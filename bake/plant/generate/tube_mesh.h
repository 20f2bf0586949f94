#pragma once

#include <cstdint>
#include <span>

#include "plant.h"

namespace coppice::bake {

/// Metres of bark that one repeat of the texture covers.
inline constexpr float kBarkTileM = 0.4f;

/// Appends a tube round a polyline: rings of `side_count` + 1 vertices (the seam is doubled for its texture coordinate), smooth normals,
/// closed by a point where the last radius is 0 and open at the first. Bark u runs round in whole repeats, v along, both about kBarkTileM a
/// repeat.
/// points  at least two, no two neighbours equal
/// radii   one per point, > 0 but for the last
void append_tube(Mesh& mesh, std::span<const glm::vec3> points, std::span<const float> radii, std::uint32_t side_count,
                 std::uint32_t material);

}  // namespace coppice::bake
