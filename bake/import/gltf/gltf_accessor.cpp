#include "gltf_accessor.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <utility>

#include <tiny_gltf.h>

namespace coppice::bake {
namespace {

Error bad(const char* what, int accessor, const std::string& more = {}) {
  return Error{Status::bad_file, what, Error::kNoOffset, accessor_place(accessor) + more};
}

Error no_such_attribute(int accessor) {
  return Error{Status::unsupported, "vertex attribute of 32-bit integers", Error::kNoOffset, accessor_place(accessor)};
}

std::size_t component_bytes(int component_type) {
  return static_cast<std::size_t>(std::max(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(component_type)), 0));
}

template <class T>
T load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Converts a normalised integer (glTF 2.0, 3.11): c / 255, max(c / 127, -1), and so on.
template <class T>
float to_float(T value, bool normalized) {
  if (!normalized) return static_cast<float>(value);
  const auto unit = static_cast<float>(value) / static_cast<float>(std::numeric_limits<T>::max());
  return std::max(unit, -1.0f);
}

float load_float(const unsigned char* bytes, int component_type, bool normalized) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_BYTE) return to_float(load<std::int8_t>(bytes), normalized);
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return to_float(load<std::uint8_t>(bytes), normalized);
  if (component_type == TINYGLTF_COMPONENT_TYPE_SHORT) return to_float(load<std::int16_t>(bytes), normalized);
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return to_float(load<std::uint16_t>(bytes), normalized);
  return load<float>(bytes);
}

std::uint32_t load_index(const unsigned char* bytes, int component_type) {
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return load<std::uint8_t>(bytes);
  if (component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return load<std::uint16_t>(bytes);
  return load<std::uint32_t>(bytes);
}

/// Calls store(element, bytes) for every element the accessor defines: first those of its buffer view, then the sparse ones over them.
template <class Store>
Result<void> visit_elements(const tinygltf::Model& model, int accessor_index, std::size_t element_bytes, const Store& store) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
  if (accessor.bufferView >= 0) {
    const std::size_t declared_stride = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView)).byteStride;
    const std::size_t stride = declared_stride != 0 ? declared_stride : element_bytes;
    const auto bytes = view_bytes(model, accessor.bufferView, accessor.byteOffset);
    for (std::size_t i = 0; i < accessor.count; ++i) store(i, bytes.data() + i * stride);
  }
  if (!accessor.sparse.isSparse) return {};
  const auto& sparse = accessor.sparse;
  const auto indices = view_bytes(model, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset));
  const auto values = view_bytes(model, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset));
  const std::size_t index_bytes = component_bytes(sparse.indices.componentType);
  for (std::size_t i = 0; i < static_cast<std::size_t>(sparse.count); ++i) {
    const std::uint32_t element = load_index(indices.data() + i * index_bytes, sparse.indices.componentType);
    if (element >= accessor.count) return bad("sparse index beyond the accessor", accessor_index);
    store(element, values.data() + i * element_bytes);
  }
  return {};
}

/// Appends an accessor of values as they lie in memory; returns its index.
template <class Value>
int append_values(tinygltf::Model& model, std::span<const Value> values, int type, int component_type) {
  tinygltf::Accessor accessor;
  accessor.type = type;
  accessor.componentType = component_type;
  accessor.count = values.size();
  const auto* const bytes = reinterpret_cast<const unsigned char*>(values.data());
  return add_accessor(model, std::move(accessor), {bytes, bytes + values.size_bytes()});
}

}  // namespace

std::span<const std::uint8_t> view_bytes(const tinygltf::Model& model, int view_index, std::size_t offset) {
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(view_index));
  const std::span<const std::uint8_t> buffer(model.buffers.at(static_cast<std::size_t>(view.buffer)).data);
  return buffer.subspan(view.byteOffset, view.byteLength).subspan(offset);
}

template <class Vector>
Result<std::vector<Vector>> read_vectors(const tinygltf::Model& model, int accessor_index) {
  constexpr std::array<const char*, 3> kOthers{"not a VEC2", "not a VEC3", "not a VEC4"};
  static_assert(TINYGLTF_TYPE_VEC2 == 2 && TINYGLTF_TYPE_VEC3 == 3 && TINYGLTF_TYPE_VEC4 == 4);
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
  if (accessor.type != Vector::length()) return bad(kOthers[std::size_t{Vector::length()} - 2], accessor_index);
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) return no_such_attribute(accessor_index);
  const std::size_t scalar_bytes = component_bytes(accessor.componentType);
  std::vector<Vector> values(accessor.count, Vector(0.0f));
  COPPICE_CHECK(
      visit_elements(model, accessor_index, scalar_bytes * std::size_t{Vector::length()}, [&](std::size_t i, const unsigned char* bytes) {
        for (int c = 0; c < Vector::length(); ++c)
          values[i][c] = load_float(bytes + static_cast<std::size_t>(c) * scalar_bytes, accessor.componentType, accessor.normalized);
      }));
  return values;
}
template Result<std::vector<glm::vec2>> read_vectors(const tinygltf::Model&, int);
template Result<std::vector<glm::vec3>> read_vectors(const tinygltf::Model&, int);
template Result<std::vector<glm::vec4>> read_vectors(const tinygltf::Model&, int);

Result<std::vector<glm::vec3>> read_positions(const tinygltf::Model& model, int accessor) {
  COPPICE_TRY(positions, read_vectors<glm::vec3>(model, accessor));
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (!is_finite(positions[i])) return bad("position is not finite", accessor, " element " + std::to_string(i));
  return positions;
}

Result<std::vector<std::uint32_t>> read_vertex_order(const tinygltf::Model& model, int accessor, std::size_t vertex_count) {
  if (accessor < 0) {
    std::vector<std::uint32_t> order(vertex_count);
    std::iota(order.begin(), order.end(), 0u);
    return order;
  }
  COPPICE_TRY(order, read_indices(model, accessor));
  for (std::size_t i = 0; i < order.size(); ++i)
    if (order[i] >= vertex_count)
      return bad("index beyond the vertices", accessor,
                 " element " + std::to_string(i) + " is " + std::to_string(order[i]) + " of " + std::to_string(vertex_count));
  return order;
}

Result<int> add_copy_of_elements(tinygltf::Model& model, int accessor, std::span<const std::uint32_t> elements) {
  const tinygltf::Accessor& source = model.accessors.at(static_cast<std::size_t>(accessor));
  const std::size_t bytes = component_bytes(source.componentType) *
                            static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(source.type)));
  std::vector<std::uint8_t> all(source.count * bytes, 0), copied;
  COPPICE_CHECK(visit_elements(model, accessor, bytes,
                               [&](std::size_t i, const unsigned char* element) { std::copy_n(element, bytes, all.data() + i * bytes); }));
  for (const std::uint32_t i : elements) copied.insert(copied.end(), all.data() + i * bytes, all.data() + (i + 1) * bytes);
  tinygltf::Accessor copy;
  copy.type = source.type;
  copy.componentType = source.componentType;
  copy.normalized = source.normalized;
  copy.count = elements.size();
  return add_accessor(model, std::move(copy), std::move(copied));
}

Result<std::vector<glm::vec4>> read_colors(const tinygltf::Model& model, int accessor) {
  if (model.accessors.at(static_cast<std::size_t>(accessor)).type == TINYGLTF_TYPE_VEC4) return read_vectors<glm::vec4>(model, accessor);
  COPPICE_TRY(rgb, read_vectors<glm::vec3>(model, accessor));
  std::vector<glm::vec4> colors(rgb.size());
  for (std::size_t i = 0; i < rgb.size(); ++i) colors[i] = glm::vec4(rgb[i], 1.0f);
  return colors;
}

Result<std::vector<float>> read_first_components(const tinygltf::Model& model, int accessor_index) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
  const bool is_vector = accessor.type >= TINYGLTF_TYPE_VEC2 && accessor.type <= TINYGLTF_TYPE_VEC4;
  if (accessor.type != TINYGLTF_TYPE_SCALAR && !is_vector) return bad("neither a SCALAR nor a vector", accessor_index);
  const int type = accessor.componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_FLOAT && (type < TINYGLTF_COMPONENT_TYPE_BYTE || type > TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT))
    return no_such_attribute(accessor_index);
  const std::size_t components = is_vector ? static_cast<std::size_t>(accessor.type) : 1;
  std::vector<float> values(accessor.count, 0.0f);
  COPPICE_CHECK(visit_elements(model, accessor_index, component_bytes(type) * components, [&](std::size_t i, const unsigned char* bytes) {
    values[i] = load_float(bytes, type, accessor.normalized);
  }));
  return values;
}

Result<std::vector<glm::mat4>> read_mat4(const tinygltf::Model& model, int accessor_index) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
  if (accessor.type != TINYGLTF_TYPE_MAT4) return bad("not a MAT4", accessor_index);
  if (accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
    return Error{Status::unsupported, "matrices of other numbers than floats", Error::kNoOffset, accessor_place(accessor_index)};
  std::vector<glm::mat4> values(accessor.count, glm::mat4(1.0f));
  COPPICE_CHECK(visit_elements(model, accessor_index, sizeof(glm::mat4),
                               [&](std::size_t i, const unsigned char* bytes) { values[i] = load<glm::mat4>(bytes); }));
  return values;
}

Result<std::vector<std::uint32_t>> read_indices(const tinygltf::Model& model, int accessor_index) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
  if (accessor.type != TINYGLTF_TYPE_SCALAR) return bad("indices are not a SCALAR", accessor_index);
  const int type = accessor.componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    return bad("indices are not unsigned integers", accessor_index);
  std::vector<std::uint32_t> indices(accessor.count, 0);
  COPPICE_CHECK(visit_elements(model, accessor_index, component_bytes(type),
                               [&](std::size_t i, const unsigned char* bytes) { indices[i] = load_index(bytes, type); }));
  return indices;
}

int add_accessor(tinygltf::Model& model, tinygltf::Accessor accessor, std::vector<unsigned char> bytes) {
  tinygltf::BufferView view;
  view.buffer = static_cast<int>(model.buffers.size());
  view.byteLength = bytes.size();
  model.buffers.emplace_back().data = std::move(bytes);
  accessor.bufferView = static_cast<int>(model.bufferViews.size());
  model.bufferViews.push_back(std::move(view));
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size()) - 1;
}

int add_vec3(tinygltf::Model& model, std::span<const glm::vec3> values) {
  return append_values(model, values, TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT);
}

int add_uint32(tinygltf::Model& model, std::span<const std::uint32_t> values) {
  return append_values(model, values, TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
}

std::string accessor_place(int accessor) {
  return "accessors[" + std::to_string(accessor) + "]";
}

std::string primitive_place(std::size_t mesh, std::size_t primitive) {
  return "meshes[" + std::to_string(mesh) + "].primitives[" + std::to_string(primitive) + "]";
}

Error at_place(const std::string& place, Error error) {
  error.detail = error.detail.empty() ? place : place + ": " + error.detail;
  return error;
}

}  // namespace coppice::bake
