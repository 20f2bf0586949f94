// A wood LoD is a Draco edgebreaker mesh; leaf meshes have one attribute more. The connectivity part of the stream states how many
// triangles and which attributes follow. check_wood_header walks that far by itself, and passes the stream to Draco only if it matches
// FORMAT.md and the counts in the front of the file. Those counts then bound what Draco allocates.

#include "wood_codec.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>

#include <draco/compression/decode.h>

#include "coppice/format.h"
#include "draco_header.h"
#include "wood_header.h"

namespace coppice {

namespace {

Error bad_wood(const char* what, std::string detail = {}) {
  return {Status::bad_file, what, Error::kNoOffset, std::move(detail)};
}

/// An attribute with an entry for every point, or null.
const draco::PointAttribute* find_attribute(const draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data_type,
                                            std::uint8_t components) {
  for (std::int32_t id = 0; id < mesh.num_attributes(); ++id) {
    const draco::PointAttribute* attribute = mesh.attribute(id);
    if (attribute->attribute_type() != type || attribute->data_type() != data_type || attribute->num_components() != components) continue;
    for (draco::PointIndex point(0); point < mesh.num_points(); ++point)
      if (attribute->mapped_index(point) >= static_cast<std::uint32_t>(attribute->size())) return nullptr;
    return attribute;
  }
  return nullptr;
}

bool is_finite(const WoodVertex& vertex) {
  const auto finite = [](float value) { return std::isfinite(value); };
  return std::ranges::all_of(vertex.position, finite) && std::ranges::all_of(vertex.normal, finite) &&
         std::ranges::all_of(vertex.uv, finite);
}

Result<WoodMesh> copy_mesh(const draco::Mesh& mesh, const WoodShape& shape, const coppice_allocator& allocator) {
  if (mesh.num_points() != shape.vertex_count || mesh.num_faces() != shape.triangle_count)
    return bad_wood("wood counts", std::to_string(mesh.num_points()) + " vertices, " + std::to_string(mesh.num_faces()) + " triangles");
  const auto* positions = find_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3);
  const auto* normals = find_attribute(mesh, draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3);
  const auto* uvs = find_attribute(mesh, draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, 2);
  const auto* materials = find_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 1);
  const auto* stalks = shape.has_stalks ? find_attribute(mesh, draco::GeometryAttribute::GENERIC, draco::DT_UINT16, 3) : nullptr;
  if (positions == nullptr || normals == nullptr || uvs == nullptr || materials == nullptr || shape.has_stalks != (stalks != nullptr))
    return bad_wood("wood attribute");
  WoodMesh result;
  COPPICE_CHECK(allocate_into(result.vertices, allocator, shape.vertex_count));
  COPPICE_CHECK(allocate_into(result.indices, allocator, std::size_t{shape.triangle_count} * 3));
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    WoodVertex& vertex = result.vertices[point.value()];
    positions->GetMappedValue(point, vertex.position.data());
    normals->GetMappedValue(point, vertex.normal.data());
    uvs->GetMappedValue(point, vertex.uv.data());
    std::uint8_t material = 0;
    materials->GetMappedValue(point, &material);
    vertex.material = material;
    if (material >= shape.materials.size()) return bad_wood("wood material", std::to_string(material));
    if (!shape.has_stalks && (shape.materials[material].flags & COPPICE_MATERIAL_LEAF_MESH_ONLY) != 0)
      return bad_wood("wood material", std::to_string(material) + ", which only leaf meshes show");
    if (!is_finite(vertex)) return bad_wood("wood vertex", "not a finite number");
    if (stalks != nullptr) stalks->GetMappedValue(point, vertex.stalk.data());
    if (std::ranges::any_of(vertex.stalk, [](std::uint16_t q) { return q > COPPICE_QUANTISED_MAX; }))
      return bad_wood("leaf mesh stalk", "outside the leaf box");
  }
  std::uint32_t* next = result.indices.data();
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& corner : mesh.face(face)) {
      if (corner.value() >= shape.vertex_count) return bad_wood("wood index", std::to_string(corner.value()));
      *next++ = corner.value();
    }
  return result;
}

Result<WoodMesh> decode(std::span<const std::uint8_t> bytes, const WoodShape& shape, const coppice_allocator& allocator) {
  COPPICE_CHECK(check_wood_header(bytes, shape));
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
  if (!mesh.ok()) return bad_wood("wood Draco stream", mesh.status().error_msg_string());
  if (buffer.remaining_size() != 0) return bad_wood("wood length");
  return copy_mesh(*mesh.value(), shape, allocator);
}

}  // namespace

Result<WoodMesh> decode_wood(std::span<const std::uint8_t> bytes, const WoodShape& shape, const coppice_allocator& allocator) {
  try {
    return decode(bytes, shape, allocator);
  } catch (const std::bad_alloc&) {
    return Error{Status::out_of_memory, "wood"};
  } catch (...) {
    return bad_wood("wood Draco stream");
  }
}

}  // namespace coppice
