// What FORMAT.md leaves to Draco: sections 10 and 12.

#include <algorithm>
#include <cmath>
#include <memory>

#include <draco/compression/decode.h>

#include "naive_reader.h"

namespace coppice::test {
namespace {

using Bytes = std::span<const std::uint8_t>;

template <class T, std::size_t count>
std::array<T, count> value_at(const draco::PointAttribute& attribute, draco::PointIndex point) {
  std::array<T, count> value{};
  attribute.GetMappedValue(point, value.data());
  return value;
}

struct MeshAttributes {
  const draco::PointAttribute *position = nullptr, *normal = nullptr, *uv = nullptr, *material = nullptr, *stalk = nullptr;
};

/// Those whose statements check_stated_attributes has checked.
MeshAttributes attributes_of(const draco::Mesh& mesh) {
  const auto named = [&](draco::GeometryAttribute::Type type) { return mesh.GetNamedAttribute(type); };
  MeshAttributes found{named(draco::GeometryAttribute::POSITION), named(draco::GeometryAttribute::NORMAL),
                       named(draco::GeometryAttribute::TEX_COORD)};
  for (int i = 0; i < mesh.NumNamedAttributes(draco::GeometryAttribute::GENERIC); ++i) {
    const draco::PointAttribute* attribute = mesh.GetNamedAttribute(draco::GeometryAttribute::GENERIC, i);
    (attribute->num_components() == 1 ? found.material : found.stalk) = attribute;
  }
  return found;
}

NaiveVertex vertex_at(const MeshAttributes& attributes, draco::PointIndex point, std::size_t material_count) {
  NaiveVertex vertex;
  vertex.position = value_at<float, 3>(*attributes.position, point);
  vertex.normal = value_at<float, 3>(*attributes.normal, point);
  vertex.uv = value_at<float, 2>(*attributes.uv, point);
  vertex.material = value_at<std::uint8_t, 1>(*attributes.material, point)[0];
  for (const float value : vertex.position) naive_must(std::isfinite(value), "a position is not finite");
  for (const float value : vertex.uv) naive_must(std::isfinite(value), "a texture coordinate is not finite");
  const std::array<float, 3>& n = vertex.normal;
  naive_must(std::abs(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 1.0f) < 1e-2f, "a normal is not of unit length");
  naive_must(vertex.material < material_count, "material");
  if (attributes.stalk != nullptr) {
    std::ranges::copy(value_at<std::uint16_t, 3>(*attributes.stalk, point), vertex.stalk.begin());
    for (const std::uint32_t coordinate : vertex.stalk) naive_must(coordinate <= 16383, "stalk");
  }
  return vertex;
}

/// Draco's varint.
std::uint64_t number(NaiveBytes& bytes) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    const std::uint64_t next = bytes.u8();
    value |= (next & 0x7f) << shift;
    if (next < 0x80) return value;
  }
  throw NaiveRefusal("a number that does not end");
}

/// What one attribute of the table looks like in the chunk: type, data type, components, normalised; and its coding.
struct KnownAttribute {
  std::array<std::uint8_t, 4> descriptor;
  std::uint32_t coding;
};
constexpr std::array<KnownAttribute, 5> kKnownAttributes = {
    {{{0, 9, 3, 0}, 2}, {{1, 9, 3, 0}, 3}, {{3, 9, 2, 0}, 2}, {{4, 2, 1, 0}, 1}, {{4, 4, 3, 0}, 1}}};

/// The attributes of each decoder, as stated before the coded data.
void check_stated_attributes(NaiveBytes& bytes, bool has_stalks) {
  const std::size_t expected = has_stalks ? 5 : 4;
  std::array<bool, 5> seen{};
  const std::uint32_t decoder_count = bytes.u8();
  naive_must(decoder_count >= 1 && decoder_count <= 5, "attribute decoders");
  bytes.take(std::size_t{3} * decoder_count);
  for (std::uint32_t decoder = 0; decoder < decoder_count; ++decoder) {
    const std::uint64_t count = number(bytes);
    naive_must(count >= 1 && count <= 5, "a decoder's attributes");
    std::vector<std::uint32_t> codings;
    for (std::uint64_t i = 0; i < count; ++i) {
      const Bytes descriptor = bytes.take(4);
      bytes.u8();
      const auto known = std::find_if(kKnownAttributes.begin(), kKnownAttributes.begin() + static_cast<std::ptrdiff_t>(expected),
                                      [&](const KnownAttribute& a) { return std::ranges::equal(a.descriptor, descriptor); });
      const auto index = static_cast<std::size_t>(known - kKnownAttributes.begin());
      naive_must(index < expected && !seen[index], "an attribute that is none of the table's, or twice");
      seen[index] = true;
      codings.push_back(known->coding);
    }
    for (const std::uint32_t coding : codings) naive_must(bytes.u8() == coding, "an attribute's coding");
  }
  for (std::size_t i = 0; i < expected; ++i) naive_must(seen[i], "an attribute is missing");
}

/// What a mesh states before its coded data, of which only the lengths are looked at.
void check_mesh_head(Bytes mesh, std::uint32_t vertex_count, std::uint32_t triangle_count, bool has_stalks) {
  constexpr std::array<std::uint8_t, 12> kHead = {0x44, 0x52, 0x41, 0x43, 0x4f, 2, 2, 1, 1, 0, 0, 0};
  NaiveBytes bytes(mesh);
  naive_must(std::ranges::equal(bytes.take(kHead.size()), kHead), "the mesh's Draco header");
  naive_must(number(bytes) <= vertex_count, "vertices as coded");
  naive_must(number(bytes) == triangle_count, "triangles");
  const std::uint32_t attribute_data = bytes.u8();
  naive_must(attribute_data <= 5, "attribute data");
  const std::uint64_t symbols = number(bytes), split_symbols = number(bytes), split_events = number(bytes);
  naive_must(symbols <= triangle_count && split_symbols <= symbols && split_events <= triangle_count, "symbols or split events");
  for (std::uint64_t i = 0; i < 2 * split_events; ++i) number(bytes);
  bytes.take(static_cast<std::size_t>((split_events + 7) / 8));
  bytes.take(static_cast<std::size_t>(number(bytes)));
  for (std::uint32_t i = 0; i < 1 + attribute_data; ++i) {
    bytes.u8();
    bytes.take(static_cast<std::size_t>(number(bytes)));
  }
  check_stated_attributes(bytes, has_stalks);
}

}  // namespace

NaiveMesh read_naive_mesh(Bytes bytes, std::uint32_t vertex_count, std::uint32_t triangle_count, bool has_stalks,
                          std::size_t material_count) {
  check_mesh_head(bytes, vertex_count, triangle_count, has_stalks);
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  naive_must(decoded.ok(), "Draco refuses the mesh");
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  naive_must(buffer.remaining_size() == 0, "bytes after the mesh's Draco data");
  naive_must(mesh->num_points() == vertex_count && mesh->num_faces() == triangle_count, "the mesh's counts");
  const MeshAttributes attributes = attributes_of(*mesh);
  NaiveMesh read;
  read.vertex_count = vertex_count;
  for (std::uint32_t face = 0; face < triangle_count; ++face) {
    for (const draco::PointIndex& point : mesh->face(draco::FaceIndex(face)))
      read.corners.push_back(vertex_at(attributes, point, material_count));
    const std::size_t first = std::size_t{3} * face;
    for (std::size_t i = 1; i < 3; ++i)
      naive_must(read.corners[first].material == read.corners[first + i].material, "a triangle of two materials");
  }
  return read;
}

}  // namespace coppice::test
