#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/common.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <glm/vector_relational.hpp>

#include "result.h"

namespace tinygltf {
struct Accessor;
class Model;
}  // namespace tinygltf

namespace coppice::bake {

// Reads accessors of a model from load_gltf as plain arrays: resolves strides, component types, normalised integers and sparse values.
// `accessor` is an index in range.
// errors  bad_file: another shape than asked for, or a sparse index beyond the accessor; unsupported: a component type that glTF does not
//         allow for what is read

/// Reads vectors of as many components as a Vector has: glm::vec2, glm::vec3 or glm::vec4.
template <class Vector>
Result<std::vector<Vector>> read_vectors(const tinygltf::Model& model, int accessor);
/// errors  bad_file also: a component that is not finite
Result<std::vector<glm::vec3>> read_positions(const tinygltf::Model& model, int accessor);
/// Reads the vertices of a primitive in order: its indices or, for accessor -1, all of them. errors  bad_file also: an index beyond them
Result<std::vector<std::uint32_t>> read_vertex_order(const tinygltf::Model& model, int accessor, std::size_t vertex_count);
/// Appends an accessor of the same form that holds these elements of another; returns its index.
Result<int> add_copy_of_elements(tinygltf::Model& model, int accessor, std::span<const std::uint32_t> elements);
/// Reads colours: a VEC4, or a VEC3 with 1 as its fourth component.
Result<std::vector<glm::vec4>> read_colors(const tinygltf::Model& model, int accessor);
/// Reads the first component of each element, of whatever shape. errors  unsupported also: 64-bit numbers
Result<std::vector<float>> read_first_components(const tinygltf::Model& model, int accessor);
/// Reads matrices of floats. errors  unsupported also: other numbers
Result<std::vector<glm::mat4>> read_mat4(const tinygltf::Model& model, int accessor);
/// Reads vertex indices, widened to 32 bits.
Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& model, int accessor);

/// The bytes of a buffer view from `offset` on. The offset is in range.
std::span<const std::uint8_t> view_bytes(const tinygltf::Model& model, int view, std::size_t offset);

/// Appends an accessor with a buffer and a view of its own; returns its index.
int add_accessor(tinygltf::Model& model, tinygltf::Accessor accessor, std::vector<unsigned char> bytes);
int add_vec3(tinygltf::Model& model, std::span<const glm::vec3> values);
int add_uint32(tinygltf::Model& model, std::span<const std::uint32_t> values);

/// Whether no component is infinite or NaN.
template <glm::length_t Length, class Number>
bool is_finite(const glm::vec<Length, Number>& v) {
  return !glm::any(glm::isnan(v)) && !glm::any(glm::isinf(v));
}

/// Names an accessor or a primitive in messages: "accessors[3]", "meshes[2].primitives[0]".
std::string accessor_place(int accessor);
std::string primitive_place(std::size_t mesh, std::size_t primitive);
/// The error with the place in front of its detail.
Error at_place(const std::string& place, Error error);

}  // namespace coppice::bake
