#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace coppice::bake {

/// Vertices closer than this share of the bounding box's diagonal are one: what rounding separates (10 um on a 10 m tree), while leaves
/// that merely touch are drawn further apart.
inline constexpr float kWeldTolerance = 1e-6f;

/// For each position the smallest index among the positions it is one with: equal ones, and those within kWeldTolerance of one that came
/// before and stands for itself. Only vertices of the same group are welded.
/// groups  [positions.size()]
std::vector<std::uint32_t> weld(std::span<const glm::vec3> positions, std::span<const std::uint32_t> groups);

}  // namespace coppice::bake
