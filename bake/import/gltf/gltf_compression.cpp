#include "gltf_compression.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include "gltf_accessor.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

Error failed(Status status, const char* what, std::string place) {
  return Error{status, what, Error::kNoOffset, std::move(place)};
}

/// Compressed views that share bytes could make any number of copies of them. Together they may code at most the bytes that there are.
std::size_t bytes_of_buffers(const tinygltf::Model& model) {
  std::size_t bytes = 0;
  for (const tinygltf::Buffer& buffer : model.buffers) bytes += buffer.data.size();
  return bytes;
}

using Mode = MeshoptView::Mode;
using Filter = MeshoptView::Filter;

Error bad(Status status, const char* what, const MeshoptView& view, const std::string& more = {}) {
  return failed(status, what, "bufferViews[" + std::to_string(view.view) + "].extensions." + view.extension + more);
}

/// How a mode is coded. The high half of a coded view's first byte names the mode, the low half the coding's version.
struct Coding {
  unsigned code = 0, newest_version = 0;
  int (*decode)(void*, std::size_t, std::size_t, const unsigned char*, std::size_t) = nullptr;
};

Coding coding_of(Mode mode) {
  if (mode == Mode::attributes) return {0xa0, 0, meshopt_decodeVertexBuffer};
  if (mode == Mode::triangles) return {0xe0, 1, meshopt_decodeIndexBuffer};
  return {0xd0, 1, meshopt_decodeIndexSequence};
}

Result<std::vector<unsigned char>> decode(const MeshoptView& view, std::span<const unsigned char> coded) {
  const Coding coding = coding_of(view.mode);
  if (coded.empty() || (coded[0] & 0xf0u) != coding.code) return bad(Status::bad_file, "bytes are not of the view's mode", view, ".mode");
  const unsigned version = coded[0] & 0x0fu;
  if (version > coding.newest_version)
    return bad(Status::unsupported, "newer version of the meshopt coding", view, ": version " + std::to_string(version));
  std::vector<unsigned char> bytes(view.count * view.stride_bytes);
  if (coding.decode(bytes.data(), view.count, view.stride_bytes, coded.data(), coded.size()) != 0)
    return bad(Status::bad_file, "damaged meshopt data", view);
  if (view.filter == Filter::octahedral) meshopt_decodeFilterOct(bytes.data(), view.count, view.stride_bytes);
  if (view.filter == Filter::quaternion) meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride_bytes);
  if (view.filter == Filter::exponential) meshopt_decodeFilterExp(bytes.data(), view.count, view.stride_bytes);
  return bytes;
}

// Plants take 2 to 20 bytes a triangle, a regular grid a few bits.
constexpr std::uint64_t kMaxFacesPerByte = 16;
constexpr std::uint64_t kMaxPointsPerByte = 16;
// Limit for the decoded bytes of all attributes together.
constexpr std::uint64_t kMaxAttributeBytesPerByte = 512;
constexpr std::uint16_t kBitstreamVersion = DRACO_BITSTREAM_VERSION(2, 2);

/// Draco sizes its arrays by counts at the start of a stream, before it has read the data that fills them. This looks at those counts
/// first, at the two places where Draco lets a derived class in, and stops decoding if so few bytes cannot hold so much.
template <class Decoder>
class BoundedDecoder final : public Decoder {
 public:
  /// refusal  gets the reason if the decoder stops
  BoundedDecoder(std::uint64_t coded_bytes, Error& refusal) : coded_bytes_(coded_bytes), refusal_(refusal) {}

 protected:
  bool DecodeConnectivity() override {
    if (this->bitstream_version() != kBitstreamVersion) return refuse(Status::unsupported, "Draco bitstream other than 2.2", {});
    draco::DecoderBuffer ahead = *this->buffer();
    std::uint32_t first = 0, second = 0;
    if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead)) return false;
    constexpr bool kFacesFirst = std::is_same_v<Decoder, draco::MeshSequentialDecoder>;
    const std::uint32_t faces = kFacesFirst ? first : second, points = kFacesFirst ? second : first;
    if (faces > kMaxFacesPerByte * coded_bytes_ || points > kMaxPointsPerByte * coded_bytes_)
      return refuse(Status::bad_file, "Draco counts too large for its bytes",
                    formatted("%u triangles and %u vertices in %ju bytes", faces, points, std::uintmax_t{coded_bytes_}));
    return Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const draco::PointCloud& cloud = *this->point_cloud();
    std::uint64_t point_bytes = 0;
    for (std::int32_t i = 0; i < cloud.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *cloud.attribute(i);
      // Draco decodes integers in 32 bits each before it narrows them.
      const int component_bytes = std::max(4, draco::DataTypeLength(attribute.data_type()));
      point_bytes += static_cast<std::uint64_t>(attribute.num_components()) * static_cast<std::uint64_t>(component_bytes);
    }
    if (point_bytes * cloud.num_points() > kMaxAttributeBytesPerByte * coded_bytes_)
      return refuse(Status::bad_file, "Draco attributes too large for their bytes",
                    std::to_string(point_bytes) + " bytes for each of " + std::to_string(cloud.num_points()) + " vertices");
    return Decoder::DecodeAllAttributes();
  }

 private:
  bool refuse(Status status, const char* what, std::string detail) {
    refusal_ = failed(status, what, std::move(detail));
    return false;
  }

  std::uint64_t coded_bytes_;
  Error& refusal_;
};

using DracoMesh = std::unique_ptr<draco::Mesh>;

/// Throws whatever Draco throws, and bad_alloc.
Result<DracoMesh> decode_stream(std::span<const unsigned char> coded, const std::string& place) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(coded.data()), coded.size());
  draco::DecoderBuffer ahead = buffer;
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&ahead, &header).ok()) return failed(Status::bad_file, "not Draco data", place);
  if (header.encoder_type != draco::TRIANGULAR_MESH) return failed(Status::unsupported, "Draco data that is not a mesh", place);

  Error refusal{Status::ok};
  std::unique_ptr<draco::MeshDecoder> decoder;
  if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
    decoder = std::make_unique<BoundedDecoder<draco::MeshSequentialDecoder>>(coded.size(), refusal);
  else if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
    decoder = std::make_unique<BoundedDecoder<draco::MeshEdgebreakerDecoder>>(coded.size(), refusal);
  else
    return failed(Status::bad_file, "unknown Draco method", place);
  auto mesh = std::make_unique<draco::Mesh>();
  const draco::Status status = decoder->Decode(draco::DecoderOptions(), &buffer, mesh.get());
  if (refusal.status != Status::ok) return at_place(place, refusal);
  if (!status.ok()) return failed(Status::bad_file, "damaged Draco data", place);
  return mesh;
}

Result<DracoMesh> decode_view(const tinygltf::Model& model, int view_index, const std::string& place) {
  try {
    return decode_stream(view_bytes(model, view_index, 0), place);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return failed(Status::bad_file, "damaged Draco data", place);
  }
}

/// Returns glTF's componentType; 0 if glTF has none.
int component_type(draco::DataType type) {
  if (type == draco::DT_INT8) return TINYGLTF_COMPONENT_TYPE_BYTE;
  if (type == draco::DT_UINT8) return TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
  if (type == draco::DT_INT16) return TINYGLTF_COMPONENT_TYPE_SHORT;
  if (type == draco::DT_UINT16) return TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  if (type == draco::DT_UINT32) return TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  return type == draco::DT_FLOAT32 ? TINYGLTF_COMPONENT_TYPE_FLOAT : 0;
}

Result<int> add_indices(tinygltf::Model& model, const draco::Mesh& mesh, const std::string& place) {
  std::vector<std::uint32_t> indices;
  indices.reserve(std::size_t{mesh.num_faces()} * 3);
  for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face)
    for (const draco::PointIndex& corner : mesh.face(face)) {
      const std::uint32_t index = corner.value();
      if (index >= mesh.num_points())
        return failed(Status::bad_file, "Draco index beyond the vertices",
                      place + formatted(": triangle %u has %u of %u", face.value(), index, mesh.num_points()));
      indices.push_back(index);
    }
  return add_uint32(model, indices);
}

/// declared  the file's description of the attribute: Draco does not know whether it is normalised
Result<int> add_attribute(tinygltf::Model& model, const draco::Mesh& mesh, std::uint32_t id, int declared, const std::string& place) {
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id);
  if (attribute == nullptr) return failed(Status::bad_file, "Draco attribute id not in the data", place + " is " + std::to_string(id));
  tinygltf::Accessor accessor;
  accessor.componentType = component_type(attribute->data_type());
  const int components = attribute->num_components();
  if (accessor.componentType == 0 || components < 1 || components > 4)
    return failed(Status::unsupported, "Draco attribute of a type that glTF does not have", place);
  constexpr std::array<int, 5> kTypes{0, TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
  accessor.type = kTypes[static_cast<std::size_t>(components)];
  accessor.count = mesh.num_points();
  accessor.normalized = model.accessors.at(static_cast<std::size_t>(declared)).normalized;
  const auto value_bytes = static_cast<std::size_t>(draco::DataTypeLength(attribute->data_type())) * static_cast<std::size_t>(components);
  std::vector<unsigned char> bytes(accessor.count * value_bytes);
  for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex value = attribute->mapped_index(point);
    if (value >= static_cast<std::uint32_t>(attribute->size())) return failed(Status::bad_file, "damaged Draco data", place);
    std::memcpy(bytes.data() + point.value() * value_bytes, attribute->GetAddress(value), value_bytes);
  }
  return add_accessor(model, std::move(accessor), std::move(bytes));
}

/// A decoded buffer view and the accessors made of it.
struct DecodedView {
  DracoMesh mesh;
  int indices = -1;
  std::map<std::uint32_t, int> attributes;  ///< by Draco's unique id
};

class Decoding {
 public:
  explicit Decoding(tinygltf::Model& model) : model_(model), bytes_left_(bytes_of_buffers(model)) {}

  Result<void> replace(tinygltf::Primitive& primitive, const std::string& place) {
    const auto extension = primitive.extensions.find(kDracoExtension);
    if (extension == primitive.extensions.end()) return {};
    const std::string where = place + ".extensions." + kDracoExtension;
    COPPICE_TRY(view, decoded(extension->second.Get("bufferView").GetNumberAsInt(), where));
    const std::uint64_t faces = view->mesh->num_faces(), points = view->mesh->num_points();
    // The screen has compared what the accessors say with the limit (gltf_cost.h). Without indices of its own a primitive says nothing of
    // Draco's: a closed surface has two triangles for each vertex.
    const auto said = static_cast<std::uint64_t>(extension->second.Get("triangles").GetNumberAsInt()) * (primitive.indices < 0 ? 6 : 1);
    if (std::max(faces, (points + 2) / 3) > said)
      return failed(Status::bad_file, "Draco data holds more than the primitive's accessors",
                    where + formatted(": %ju triangles, %ju vertices", std::uintmax_t{faces}, std::uintmax_t{points}));
    if (view->indices < 0) COPPICE_CHECK(move_into(view->indices, add_indices(model_, *view->mesh, where)));
    const tinygltf::Value& ids = extension->second.Get("attributes");
    for (const std::string& name : ids.Keys()) {
      const auto id = static_cast<std::uint32_t>(ids.Get(name).GetNumberAsInt());
      int& declared = primitive.attributes.at(name);
      const auto [accessor, is_new] = view->attributes.try_emplace(id, -1);
      const std::string attribute_place = where + ".attributes." + name.substr(0, 64);
      if (is_new) COPPICE_CHECK(move_into(accessor->second, add_attribute(model_, *view->mesh, id, declared, attribute_place)));
      declared = accessor->second;
    }
    primitive.indices = view->indices;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    return {};
  }

 private:
  /// Decodes a view once, however many primitives share it.
  Result<DecodedView*> decoded(int view_index, const std::string& place) {
    const auto [found, is_new] = views_.try_emplace(view_index);
    if (is_new) {
      const std::size_t bytes = model_.bufferViews.at(static_cast<std::size_t>(view_index)).byteLength;
      if (bytes > bytes_left_) return failed(Status::bad_file, "compressed views share their bytes", place);
      bytes_left_ -= bytes;
      COPPICE_CHECK(move_into(found->second.mesh, decode_view(model_, view_index, place)));
    }
    return &found->second;
  }

  tinygltf::Model& model_;
  std::size_t bytes_left_;
  std::map<int, DecodedView> views_;
};

}  // namespace

bool meshopt_is_plausible(Mode mode, std::uint64_t count, std::uint64_t stride_bytes, std::uint64_t coded_bytes) {
  // A triangle takes at least a byte, and so does an index; 64 equal attribute bytes fit in one byte.
  if (mode == Mode::triangles) return count / 3 <= coded_bytes;
  if (mode == Mode::indices) return count <= coded_bytes;
  return count / 64 <= coded_bytes / stride_bytes;
}

Result<void> decode_meshopt_views(tinygltf::Model& model, const std::vector<MeshoptView>& views) {
  std::size_t bytes_left = bytes_of_buffers(model);
  for (const MeshoptView& view : views) {
    tinygltf::BufferView& target = model.bufferViews.at(view.view);
    if (target.byteLength > bytes_left) return bad(Status::bad_file, "compressed views share their bytes", view);
    bytes_left -= target.byteLength;
    COPPICE_TRY(bytes, decode(view, view_bytes(model, static_cast<int>(view.view), 0)));
    target.buffer = static_cast<int>(model.buffers.size());
    target.byteOffset = 0;
    target.byteLength = bytes.size();
    model.buffers.emplace_back().data = std::move(bytes);
  }
  return {};
}

Result<void> decode_draco_primitives(tinygltf::Model& model) {
  Decoding decoding(model);
  for (std::size_t m = 0; m < model.meshes.size(); ++m)
    for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p)
      COPPICE_CHECK(decoding.replace(model.meshes[m].primitives[p], primitive_place(m, p)));
  return {};
}

}  // namespace coppice::bake
