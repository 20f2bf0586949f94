#include "leaf_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace coppice {
namespace {

constexpr std::array<std::uint32_t, 6> kQuadIndices = {0, 1, 2, 0, 2, 3};

template <class T>
void put(unsigned char* vertex, std::uint32_t offset, const T& value) {
  if (offset != COPPICE_NONE) std::memcpy(vertex + offset, &value, sizeof value);
}

vec3 face_normal(const std::array<vec3, 4>& corners) {
  const vec3 face = cross(corners[2] - corners[0], corners[3] - corners[1]);
  const float area = length(face);
  return area > 0.0f ? face * (1.0f / area) : vec3(0.0f);
}

}  // namespace

std::string layout_problem(const coppice_leaf_layout& layout) {
  const std::uint32_t color_bytes = layout.color_format == COPPICE_LEAF_COLOR_FLOAT4 ? 16 : 4;
  if (layout.color_format != COPPICE_LEAF_COLOR_FLOAT4 && layout.color_format != COPPICE_LEAF_COLOR_UNORM8X4)
    return "color_format is not a coppice_leaf_color";
  if (layout.index_bytes != 2 && layout.index_bytes != 4) return "index_bytes is neither 2 nor 4";
  if (layout.vertex_bytes % 4 != 0) return "vertex_bytes is not a multiple of 4";
  struct Attribute {
    const char* name;
    std::uint32_t offset, bytes;
  };
  for (const auto& [name, offset, bytes] :
       {Attribute{"position", layout.position, 12}, Attribute{"normal", layout.normal, 12}, Attribute{"uv", layout.uv, 8},
        Attribute{"color", layout.color, color_bytes}, Attribute{"material", layout.material, 4}, Attribute{"along", layout.along, 4},
        Attribute{"sided", layout.sided, 4}}) {
    if (offset == COPPICE_NONE) continue;
    if (offset % 4 != 0) return std::string(name) + " is " + std::to_string(offset) + ": not a multiple of 4";
    if (bytes > layout.vertex_bytes || offset > layout.vertex_bytes - bytes)
      return std::string(name) + " is " + std::to_string(offset) + ": its " + std::to_string(bytes) + " bytes reach beyond vertex_bytes";
  }
  return {};
}

void LeafWriter::write_color(unsigned char* vertex, const PageNode& node, const coppice_file_material& material) const {
  if (layout_.color == COPPICE_NONE) return;
  std::array<float, 4> color{};
  std::copy_n(material.base_color, 3, color.begin());
  color[3] = static_cast<float>(node.opacity) / static_cast<float>(kOpaque);
  if (layout_.color_format == COPPICE_LEAF_COLOR_FLOAT4) return put(vertex, layout_.color, color);
  std::array<std::uint8_t, 4> bytes{};
  std::ranges::transform(color, bytes.begin(),
                         [](float value) { return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f))); });
  put(vertex, layout_.color, bytes);
}

void LeafWriter::write_indices() {
  auto* indices = static_cast<unsigned char*>(output_.indices) + std::size_t{leaf_count_} * kQuadIndices.size() * layout_.index_bytes;
  for (const std::uint32_t corner : kQuadIndices) {
    const std::uint32_t index = 4 * leaf_count_ + corner;
    const auto narrow = static_cast<std::uint16_t>(index);
    if (layout_.index_bytes == sizeof narrow)
      std::memcpy(indices, &narrow, sizeof narrow);
    else
      std::memcpy(indices, &index, sizeof index);
    indices += layout_.index_bytes;
  }
}

void LeafWriter::write(const PageNode& node) {
  const coppice_file_card& card = file_.cards[node.card];
  const coppice_file_material& material = file_.materials[card.material];
  std::array<vec3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = box_.at({node.corners[i][0], node.corners[i][1], node.corners[i][2]});
  const vec3 face = face_normal(corners);
  const ShadingNormals normals = unpack_normals(node.normals, {face.x, face.y, face.z});
  const vec3 axis(normals.axis[0], normals.axis[1], normals.axis[2]);
  const vec3 normal = !normals.is_sided && dot(axis, face) < 0.0f ? axis * -1.0f : axis;
  auto* vertex = static_cast<unsigned char*>(output_.vertices) + std::size_t{leaf_count_} * 4 * layout_.vertex_bytes;
  for (std::size_t i = 0; i < 4; ++i) {
    put(vertex, layout_.position, corners[i]);
    put(vertex, layout_.normal, normal);
    put(vertex, layout_.along, normals.along);
    put(vertex, layout_.sided, normals.is_sided ? 1.0f : 0.0f);
    put(vertex, layout_.uv, card.uv[i]);
    put(vertex, layout_.material, card.material);
    write_color(vertex, node, material);
    vertex += layout_.vertex_bytes;
  }
  write_indices();
  ++leaf_count_;
}

}  // namespace coppice
