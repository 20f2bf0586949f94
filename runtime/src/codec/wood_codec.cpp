// A wood LoD is a Draco edgebreaker mesh; leaf meshes have one attribute more. The connectivity part of the stream states how many
// triangles and which attributes follow. check_wood_header walks that far by itself, and passes the stream to Draco only if it matches
// FORMAT.md and the counts in the front of the file. Those counts then bound what Draco allocates.

#include "wood_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <optional>
#include <string>

#include <draco/attributes/geometry_attribute.h>
#include <draco/compression/decode.h>

#include "coppice/format.h"
#include "draco_header.h"

namespace coppice {

namespace {

constexpr std::uint32_t kMaxAttributes = 5;

/// Reads forward; after the end it stays failed and returns zeros.
class Cursor {
 public:
  explicit Cursor(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] std::size_t at() const { return at_; }

  std::uint8_t byte() {
    if (failed_ || at_ == bytes_.size()) return fail();
    return bytes_[at_++];
  }

  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const std::uint8_t next = byte();
      value |= static_cast<std::uint64_t>(next & 0x7f) << shift;
      if ((next & 0x80) == 0) return value;
    }
    return fail();
  }

  void skip(std::uint64_t count) {
    if (failed_ || count > bytes_.size() - at_)
      fail();
    else
      at_ += static_cast<std::size_t>(count);
  }

 private:
  std::uint8_t fail() {
    failed_ = true;
    return 0;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

Error bad_at(const Cursor& cursor, const char* what, const std::string& detail = {}) {
  return {Status::bad_file, what, Error::kNoOffset,
          "byte " + std::to_string(cursor.at()) + " of the chunk" + (detail.empty() ? "" : ", ") + detail};
}

/// Checks Draco's prefix, the traversal kind and the counts; leaves the cursor behind them.
Result<void> check_counts(Cursor& cursor, std::uint64_t byte_count, const WoodShape& shape, std::uint32_t& attribute_data_count) {
  for (std::uint8_t expected : draco_header::kPrefix)
    if (cursor.byte() != expected || cursor.failed()) return bad_at(cursor, "wood Draco header");
  if (cursor.byte() != 0) return bad_at(cursor, "wood traversal");  // standard traversal: every triangle takes at least a bit
  const std::uint64_t vertices = cursor.varint(), triangles = cursor.varint();
  attribute_data_count = cursor.byte();
  const std::uint64_t symbols = cursor.varint(), split_symbols = cursor.varint();
  if (cursor.failed()) return bad_at(cursor, "wood Draco header", "cut off");
  if (triangles != shape.triangle_count || triangles > COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE * byte_count)
    return bad_at(cursor, "wood triangle count", std::to_string(triangles));
  if (vertices > shape.vertex_count || symbols > triangles || split_symbols > symbols)
    return bad_at(cursor, "wood vertex count", std::to_string(vertices));
  if (attribute_data_count > kMaxAttributes) return bad_at(cursor, "wood attribute count", std::to_string(attribute_data_count));
  return {};
}

/// Skips split events, symbols, start faces and attribute seams; each states its length.
Result<void> skip_connectivity(Cursor& cursor, std::uint32_t attribute_data_count, std::uint32_t triangle_count) {
  const std::uint64_t split_events = cursor.varint();
  if (split_events > triangle_count) return bad_at(cursor, "wood split events", std::to_string(split_events));
  for (std::uint64_t i = 0; i < 2 * split_events && !cursor.failed(); ++i) cursor.varint();
  cursor.skip((split_events + 7) / 8);
  cursor.skip(cursor.varint());
  for (std::uint32_t coder = 0; coder < 1 + attribute_data_count; ++coder) {
    cursor.byte();
    cursor.skip(cursor.varint());
  }
  if (cursor.failed()) return bad_at(cursor, "wood connectivity", "cut off");
  return {};
}

/// Index of an attribute descriptor in FORMAT.md's list; the last one, the stalk, is only for leaf meshes.
std::optional<std::size_t> known_attribute(const std::array<std::uint8_t, 5>& descriptor, bool has_stalks, std::uint8_t& decoder) {
  struct Known {
    int type, data_type, components;
    std::uint8_t decoder;
  };
  static constexpr std::array<Known, kMaxAttributes> kKnown = {{
      {draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, draco_header::kQuantizationDecoder},
      {draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3, draco_header::kNormalsDecoder},
      {draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, 2, draco_header::kQuantizationDecoder},
      {draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 1, draco_header::kIntegerDecoder},
      {draco::GeometryAttribute::GENERIC, draco::DT_UINT16, 3, draco_header::kIntegerDecoder},
  }};
  for (std::size_t i = 0; i < kKnown.size() - (has_stalks ? 0 : 1); ++i) {
    const auto expected = draco_header::attribute({kKnown[i].type, kKnown[i].data_type, kKnown[i].components, descriptor[4]});
    if (descriptor != expected) continue;
    decoder = kKnown[i].decoder;
    return i;
  }
  return std::nullopt;
}

/// Checks the attributes of one decoder; each must be known and new.
Result<void> check_attributes(Cursor& cursor, bool has_stalks, std::array<bool, kMaxAttributes>& seen) {
  const std::uint64_t count = cursor.varint();
  if (count == 0 || count > seen.size()) return bad_at(cursor, "wood attribute count", std::to_string(count));
  std::array<std::uint8_t, kMaxAttributes> decoders{};
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::uint8_t, 5> descriptor{};
    for (std::uint8_t& byte : descriptor) byte = cursor.byte();
    const auto known = known_attribute(descriptor, has_stalks, decoders[i]);
    if (!known || seen[*known]) return bad_at(cursor, "wood attribute");
    seen[*known] = true;
  }
  for (std::size_t i = 0; i < count; ++i)
    if (cursor.byte() != decoders[i]) return bad_at(cursor, "wood attribute coding");
  return {};
}

/// Walks a Draco edgebreaker stream up to its attributes without allocating. Checks that the triangle count is that of the shape and within
/// COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE, and that the attributes are exactly position, normal, uv and material, and for leaf meshes also the
/// stalk.
/// errors  bad_file: the field, and where in the chunk
Result<void> check_wood_header(std::span<const std::uint8_t> bytes, const WoodShape& shape) {
  Cursor cursor(bytes);
  std::uint32_t attribute_data_count = 0;
  COPPICE_CHECK(check_counts(cursor, bytes.size(), shape, attribute_data_count));
  COPPICE_CHECK(skip_connectivity(cursor, attribute_data_count, shape.triangle_count));
  const std::uint32_t decoder_count = cursor.byte();
  if (decoder_count == 0 || decoder_count > kMaxAttributes) return bad_at(cursor, "wood attribute count", std::to_string(decoder_count));
  cursor.skip(3 * decoder_count);  // each decoder's connectivity, element and traversal
  std::array<bool, kMaxAttributes> seen{};
  seen.back() = !shape.has_stalks;
  for (std::uint32_t decoder = 0; decoder < decoder_count; ++decoder) COPPICE_CHECK(check_attributes(cursor, shape.has_stalks, seen));
  if (cursor.failed() || !std::ranges::all_of(seen, [](bool found) { return found; }))
    return bad_at(cursor, "wood attribute", "one is missing");
  return {};
}

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
