#pragma once

#include <cstdint>
#include <vector>

#include "wood_codec.h"

namespace coppice::test {

/// A mesh that a test makes, vertex by vertex.
struct MadeMesh {
  std::vector<WoodVertex> vertices;
  std::vector<std::uint32_t> indices;

  operator WoodSpan() const { return {vertices, indices}; }
};

}  // namespace coppice::test
