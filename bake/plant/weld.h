#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace coppice::bake {

/// Vertices closer than this share of the bounding box's diagonal (10 um on a 10 m tree) are one. Rounding separates vertices by less;
/// modellers keep leaves that merely touch further apart.
inline constexpr float kWeldTolerance = 1e-6f;

/// Finds for each position the smallest index among the positions that it is welded to: equal ones, and those within kWeldTolerance of an
/// earlier one that stands for itself. Only vertices of the same group are welded.
/// groups  [positions.size()]
std::vector<std::uint32_t> weld(std::span<const glm::vec3> positions, std::span<const std::uint32_t> groups);

}  // namespace coppice::bake
