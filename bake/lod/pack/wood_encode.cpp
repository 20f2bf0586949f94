#include "wood_encode.h"

#include <algorithm>
#include <cmath>

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include "bounds.h"

namespace coppice::bake {
namespace {

Error bad_mesh(const char* what) {
  return {Status::invalid_argument, what};
}

Result<void> check_mesh(const Mesh& mesh, std::uint32_t material_count) {
  const std::size_t vertex_count = mesh.positions.size();
  if (mesh.normals.size() != vertex_count || mesh.uvs.size() != vertex_count) return bad_mesh("wood: attribute arrays differ in length");
  if (mesh.indices.size() != mesh.triangle_materials.size() * 3) return bad_mesh("wood: index count is not 3 a triangle");
  if (mesh.triangle_materials.size() > COPPICE_MAX_WOOD_TRIANGLES) return bad_mesh("wood: over COPPICE_MAX_WOOD_TRIANGLES");
  for (std::uint32_t index : mesh.indices)
    if (index >= vertex_count) return bad_mesh("wood: index out of range");
  for (std::uint32_t material : mesh.triangle_materials)
    if (material >= material_count || material >= COPPICE_MAX_MATERIALS) return bad_mesh("wood: no such material");
  for (std::size_t i = 0; i < vertex_count; ++i) {
    float sum = mesh.uvs[i].x + mesh.uvs[i].y;
    for (int axis = 0; axis < 3; ++axis) sum += mesh.positions[i][axis] + mesh.normals[i][axis];
    if (!std::isfinite(sum)) return bad_mesh("wood: a number is not finite");
  }
  return {};
}

bool is_degenerate(const Mesh& mesh, std::size_t triangle) {
  const auto [a, b, c] = at_corners(mesh.positions, mesh.indices, 3 * triangle);
  return a == b || b == c || c == a;
}

template <class Source>
void add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data_type, std::uint8_t components,
                   Source source) {
  draco::GeometryAttribute description;
  description.Init(type, nullptr, components, data_type, false, components * draco::DataTypeLength(data_type), 0);
  const int id = mesh.AddAttribute(description, true, mesh.num_points());
  for (std::uint32_t point = 0; point < mesh.num_points(); ++point) {
    const auto value = source(point);
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(point), &value);
  }
}

/// Fills in one point per corner. Draco then merges equal values and equal points, which recovers the connectivity.
/// stalks  empty for wood
void fill(draco::Mesh& target, const Mesh& mesh, std::span<const QuantisedPoint> stalks) {
  std::vector<std::uint32_t> triangles;
  for (std::uint32_t triangle = 0; triangle < mesh.triangle_materials.size(); ++triangle)
    if (!is_degenerate(mesh, triangle)) triangles.push_back(triangle);
  const auto vertex_of = [&](std::uint32_t corner) { return mesh.indices[3 * triangles[corner / 3] + corner % 3]; };
  target.set_num_points(static_cast<std::uint32_t>(3 * triangles.size()));
  target.SetNumFaces(triangles.size());
  for (std::uint32_t face = 0; face < triangles.size(); ++face)
    target.SetFace(draco::FaceIndex(face), {draco::PointIndex(3 * face), draco::PointIndex(3 * face + 1), draco::PointIndex(3 * face + 2)});
  using Attribute = draco::GeometryAttribute;
  add_attribute(target, Attribute::POSITION, draco::DT_FLOAT32, 3, [&](auto corner) { return mesh.positions[vertex_of(corner)]; });
  add_attribute(target, Attribute::NORMAL, draco::DT_FLOAT32, 3, [&](auto corner) { return mesh.normals[vertex_of(corner)]; });
  add_attribute(target, Attribute::TEX_COORD, draco::DT_FLOAT32, 2, [&](auto corner) { return mesh.uvs[vertex_of(corner)]; });
  add_attribute(target, Attribute::GENERIC, draco::DT_UINT8, 1,
                [&](auto corner) { return static_cast<std::uint8_t>(mesh.triangle_materials[triangles[corner / 3]]); });
  if (!stalks.empty())
    add_attribute(target, Attribute::GENERIC, draco::DT_UINT16, 3, [&](auto corner) { return stalks[vertex_of(corner)]; });
  target.DeduplicateAttributeValues();
  target.DeduplicatePointIds();
}

struct AttributeBits {
  int position = 14, normal = 10, uv = 12;
};

Result<std::vector<std::uint8_t>> compress(const draco::Mesh& mesh, const AttributeBits& bits) {
  draco::ExpertEncoder encoder(mesh);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetEncodingSubmethod(draco::MESH_EDGEBREAKER_STANDARD_ENCODING);
  encoder.SetSpeedOptions(3, 5);
  encoder.SetAttributeQuantization(0, bits.position);
  encoder.SetAttributeQuantization(1, bits.normal);
  encoder.SetAttributeQuantization(2, bits.uv);
  draco::EncoderBuffer buffer;
  if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok())
    return Error{Status::internal, "wood encoder", Error::kNoOffset, status.error_msg_string()};
  return std::vector<std::uint8_t>(buffer.data(), buffer.data() + buffer.size());
}

/// Draco spreads its steps over the range of the uvs: so many more bits keep them at 1/4096 of the image.
int extra_uv_bits(const Mesh& mesh) {
  const glm::vec2 extent = box_of(mesh.uvs).extent();
  constexpr int kMaxExtraBits = 8;
  int extra = 0;
  while (extra < kMaxExtraBits && std::ldexp(1.0f, extra) < std::max(extent.x, extent.y)) ++extra;
  return extra;
}

Result<EncodedWood> encode(const Mesh& mesh, std::span<const QuantisedPoint> stalks, std::uint32_t material_count,
                           const AttributeBits& bits) {
  COPPICE_CHECK(check_mesh(mesh, material_count));
  draco::Mesh points;
  fill(points, mesh, stalks);
  EncodedWood result;
  if (points.num_faces() == 0) return result;
  COPPICE_CHECK(move_into(result.bytes, compress(points, bits)));
  // Draco may split vertices, so only decoding tells the counts.
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(result.bytes.data()), result.bytes.size());
  draco::Decoder decoder;
  const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return Error{Status::internal, "wood encoder", Error::kNoOffset, decoded.status().error_msg_string()};
  result.vertex_count = decoded.value()->num_points();
  result.triangle_count = decoded.value()->num_faces();
  return result;
}

}  // namespace

Result<EncodedWood> encode_wood(const Mesh& mesh, std::uint32_t material_count) {
  return encode(mesh, {}, material_count, {});
}

Result<EncodedWood> encode_leaf_mesh(const Mesh& mesh, std::span<const QuantisedPoint> stalks, std::uint32_t material_count,
                                     int position_bits) {
  if (stalks.size() != mesh.positions.size()) return bad_mesh("leaf mesh: a stalk per vertex is missing");
  AttributeBits bits;
  bits.position = position_bits;
  bits.uv += extra_uv_bits(mesh);
  return encode(mesh, stalks, material_count, bits);
}

}  // namespace coppice::bake
