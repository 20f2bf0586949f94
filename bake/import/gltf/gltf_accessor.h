#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

// Accessors of a model from load_gltf as plain arrays: strides, component types, normalised integers and sparse values resolved.
// `accessor` is an index in range. errors  bad_file: another shape than asked for, or a sparse index beyond the accessor; unsupported:
// a component type that glTF does not allow for what is read.

Result<std::vector<glm::vec3>> read_vec3(const tinygltf::Model& model, int accessor);
Result<std::vector<glm::vec2>> read_vec2(const tinygltf::Model& model, int accessor);
Result<std::vector<glm::vec4>> read_vec4(const tinygltf::Model& model, int accessor);
/// A VEC4, or a VEC3 with 1 as its fourth: colours.
Result<std::vector<glm::vec4>> read_colors(const tinygltf::Model& model, int accessor);
/// The first component of each element, of whatever shape. errors  also of 64-bit numbers
Result<std::vector<float>> read_first_components(const tinygltf::Model& model, int accessor);
/// Vertex indices, widened.
Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& model, int accessor);

/// The bytes of a buffer view from `offset` on, which is in range.
std::span<const std::uint8_t> view_bytes(const tinygltf::Model& model, int view, std::size_t offset);

/// "accessors[3]", for messages.
std::string accessor_place(int accessor);

}  // namespace coppice::bake
