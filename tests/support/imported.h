#pragma once

// What the importer makes of glTF files that tests build in memory.

#include <cstddef>
#include <initializer_list>
#include <string_view>

#include <gtest/gtest.h>

#include "gltf_builder.h"
#include "import_gltf.h"
#include "mentions.h"
#include "results.h"

namespace coppice::test {

inline Result<bake::Plant> import_built(const GltfBuilder& builder, const bake::ImportOptions& options = {}) {
  return bake::import_gltf_bytes(builder.glb(), "plant.glb", options);
}

/// Throws std::runtime_error where the file is refused.
inline bake::Plant imported(const GltfBuilder& builder, const bake::ImportOptions& options = {}) {
  return must(import_built(builder, options));
}

/// The import warns once, and names each of the tokens.
inline void expect_warning(const bake::Plant& plant, std::initializer_list<std::string_view> tokens) {
  ASSERT_EQ(plant.warnings.size(), 1u);
  EXPECT_TRUE(mentions(plant.warnings[0], tokens));
}

/// A corner of a mesh's triangles, by its place in the indices.
inline glm::vec3 corner(const bake::Mesh& mesh, std::size_t i) {
  return mesh.positions.at(mesh.indices.at(i));
}

inline void expect_near(const glm::vec3& actual, const glm::vec3& expected, float tolerance = 1e-5f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], tolerance) << "component " << c;
}

}  // namespace coppice::test
