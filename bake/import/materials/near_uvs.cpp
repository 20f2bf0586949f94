#include "near_uvs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/common.hpp>

#include "bounds.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

// Textures along a trunk repeat less often than this.
constexpr float kFar = 64.0f;

bool is_far(const glm::vec2& uv) {
  return std::abs(uv.x) >= kFar || std::abs(uv.y) >= kFar;
}

}  // namespace

void bring_uvs_near_zero(Mesh& mesh, std::span<const LeafRange> leaves) {
  if (std::ranges::none_of(mesh.uvs, is_far)) return;
  UnionFind sets(mesh.uvs.size());
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    for (std::size_t k = 1; k < 3; ++k) sets.join(mesh.indices[i], mesh.indices[i + k]);
  for (const LeafRange& leaf : leaves)
    for (const std::uint32_t vertex : leaf_indices(mesh, leaf)) sets.join(leaf_indices(mesh, leaf)[0], vertex);
  std::vector<PointBox<glm::vec2>> boxes(mesh.uvs.size());
  for (std::uint32_t i = 0; i < mesh.uvs.size(); ++i) boxes[sets.find(i)].add(mesh.uvs[i]);
  for (std::uint32_t i = 0; i < mesh.uvs.size(); ++i) {
    const PointBox<glm::vec2>& box = boxes[sets.find(i)];
    const glm::vec2 middle = glm::floor(0.5f * box.low + 0.5f * box.high);
    if (is_far(middle)) mesh.uvs[i] -= middle;
  }
}

}  // namespace coppice::bake
