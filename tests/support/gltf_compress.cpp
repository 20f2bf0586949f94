#include "gltf_compress.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <stdexcept>

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>
#include <webp/encode.h>

namespace coppice::test {
namespace {

/// Values of one type and length, one a point.
struct DracoAttribute {
  draco::GeometryAttribute::Type type;
  draco::DataType data_type;
  int components;
  std::size_t value_bytes;
  const void* values;
};

void add_attribute(draco::Mesh& mesh, const DracoAttribute& description) {
  draco::GeometryAttribute attribute;
  attribute.Init(description.type, nullptr, static_cast<std::uint8_t>(description.components), description.data_type,
                 description.type == draco::GeometryAttribute::COLOR, static_cast<std::int64_t>(description.value_bytes), 0);
  const int id = mesh.AddAttribute(attribute, true, mesh.num_points());
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                          static_cast<const char*>(description.values) + i * description.value_bytes);
}

std::vector<unsigned> as_indices(const std::vector<std::uint8_t>& bytes, int stride) {
  std::vector<unsigned> indices(bytes.size() / static_cast<std::size_t>(stride), 0);
  for (std::size_t i = 0; i < indices.size(); ++i)
    std::memcpy(&indices[i], &bytes[i * static_cast<std::size_t>(stride)], static_cast<std::size_t>(stride));
  return indices;
}

}  // namespace

std::vector<std::uint8_t> encode_draco(const DracoMesh& source) {
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(source.positions.size()));
  for (const auto& triangle : source.triangles)
    mesh.AddFace({draco::PointIndex(triangle[0]), draco::PointIndex(triangle[1]), draco::PointIndex(triangle[2])});
  add_attribute(mesh, {draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, sizeof(glm::vec3), source.positions.data()});
  if (!source.uvs.empty())
    add_attribute(mesh, {draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, 2, sizeof(glm::vec2), source.uvs.data()});
  if (!source.colors.empty()) add_attribute(mesh, {draco::GeometryAttribute::COLOR, draco::DT_UINT8, 4, 4, source.colors.data()});

  draco::Encoder encoder;
  encoder.SetEncodingMethod(source.edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING);
  if (source.position_bits > 0) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, source.position_bits);
  draco::EncoderBuffer buffer;
  if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) throw std::runtime_error("Draco cannot encode");
  return {buffer.data(), buffer.data() + buffer.size()};
}

nlohmann::json& add_draco(GltfBuilder& builder, nlohmann::json& primitive, const std::vector<std::uint8_t>& coded,
                          const nlohmann::json& ids) {
  builder.json["extensionsRequired"].push_back("KHR_draco_mesh_compression");
  nlohmann::json& extension = primitive["extensions"]["KHR_draco_mesh_compression"];
  extension = {{"bufferView", builder.add_view(coded)}, {"attributes", ids}};
  return extension;
}

std::vector<std::uint8_t> encode_meshopt(const std::vector<std::uint8_t>& values, const MeshoptCoding& coding) {
  std::vector<std::uint8_t> coded;
  std::size_t bytes = 0;
  if (coding.mode == "ATTRIBUTES") {
    const auto stride = static_cast<std::size_t>(coding.stride);
    const std::size_t count = values.size() / stride;
    coded.resize(meshopt_encodeVertexBufferBound(count, stride));
    bytes = meshopt_encodeVertexBuffer(coded.data(), coded.size(), values.data(), count, stride);
  } else {
    const std::vector<unsigned> indices = as_indices(values, coding.stride);
    if (coding.mode == "TRIANGLES") {
      coded.resize(meshopt_encodeIndexBufferBound(indices.size(), 1u << 16));
      bytes = meshopt_encodeIndexBuffer(coded.data(), coded.size(), indices.data(), indices.size());
    } else {
      coded.resize(meshopt_encodeIndexSequenceBound(indices.size(), 1u << 16));
      bytes = meshopt_encodeIndexSequence(coded.data(), coded.size(), indices.data(), indices.size());
    }
  }
  if (bytes == 0) throw std::runtime_error("meshoptimizer cannot encode");
  coded.resize(bytes);
  return coded;
}

nlohmann::json& compress_view(GltfBuilder& builder, int view, const MeshoptCoding& coding) {
  const auto index = static_cast<std::size_t>(view);
  const auto offset = builder.json["bufferViews"][index]["byteOffset"].get<std::size_t>();
  const auto bytes = builder.json["bufferViews"][index]["byteLength"].get<std::size_t>();
  const auto first = builder.bin.begin() + static_cast<std::ptrdiff_t>(offset);
  const std::vector<std::uint8_t> plain(first, first + static_cast<std::ptrdiff_t>(bytes));
  std::fill(first, first + static_cast<std::ptrdiff_t>(bytes), std::uint8_t{0xee});

  const int coded_view = builder.add_view(encode_meshopt(plain, coding));
  const nlohmann::json coded = builder.json["bufferViews"].back();
  builder.json["bufferViews"].erase(static_cast<std::size_t>(coded_view));
  nlohmann::json& target = builder.json["bufferViews"][index];
  target["buffer"] = 1;
  target["byteOffset"] = builder.fallback_bytes;
  builder.fallback_bytes += bytes;
  builder.json["extensionsRequired"].push_back(coding.extension);
  nlohmann::json& extension = target["extensions"][coding.extension];
  extension = {{"buffer", 0},
               {"byteOffset", coded["byteOffset"]},
               {"byteLength", coded["byteLength"]},
               {"byteStride", coding.stride},
               {"count", bytes / static_cast<std::size_t>(coding.stride)},
               {"mode", coding.mode}};
  if (coding.filter != "NONE") extension["filter"] = coding.filter;
  return extension;
}

std::vector<std::uint8_t> webp(int width, int height, std::array<std::uint8_t, 4> rgba) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < width * height; ++i) pixels.insert(pixels.end(), rgba.begin(), rgba.end());
  std::uint8_t* encoded = nullptr;
  const std::size_t bytes = WebPEncodeLosslessRGBA(pixels.data(), width, height, 4 * width, &encoded);
  std::vector<std::uint8_t> file(encoded, encoded + bytes);
  WebPFree(encoded);
  return file;
}

}  // namespace coppice::test
