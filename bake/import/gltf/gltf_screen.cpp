#include "gltf_screen.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "gltf_json.h"
#include "image_limits.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::json;

// Limits what accessors without a buffer view add up to: they are all zeros, so no bytes of the file vouch for their length. Sparse
// accessors use them.
constexpr std::uint64_t kMaxUnbackedCount = 1u << 16;
constexpr const char* kBasisu = "KHR_texture_basisu";
constexpr std::size_t kMaxNameBytes = 1024;
// tinygltf keeps whole numbers and sparse offsets in an int; Draco's ids are 32 bits.
constexpr std::uint64_t kMaxInt = 0x7fffffff;
// An element of a few bytes becomes up to 2 kB in tinygltf's model. These bounds keep that below 130 MB an array.
constexpr std::size_t kMaxElements = std::size_t{1} << 18, kMaxLargeElements = std::size_t{1} << 16;
constexpr std::size_t kMaxMorphs = 4096;  // the weights of a mesh are read for every node that shows it

// The numbers of glTF 2.0: `componentType` of accessors, `mode` of primitives.
enum ComponentType : std::uint64_t { kByte = 5120, kUnsignedByte, kShort, kUnsignedShort, kInt, kUnsignedInt, kFloat };
enum PrimitiveMode : std::uint64_t { kPoints, kLines, kLineLoop, kLineStrip, kTriangles, kTriangleStrip, kTriangleFan };

std::size_t component_bytes(std::uint64_t component_type) {
  constexpr std::array<std::size_t, 7> kBytes{1, 1, 2, 2, 0, 4, 4};  // glTF has no kInt
  return component_type >= kByte && component_type <= kFloat ? kBytes[component_type - kByte] : 0;
}

std::size_t component_count(const std::string& type) {
  constexpr std::array<std::pair<std::string_view, std::size_t>, 7> kTypes{
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
  for (const auto& [name, count] : kTypes)
    if (type == name) return count;
  return 0;
}

std::string range_text(std::uint64_t offset, std::uint64_t bytes, std::uint64_t of_bytes) {
  return ": " + std::to_string(offset) + " + " + std::to_string(bytes) + " of " + std::to_string(of_bytes) + " bytes";
}

/// Whether `count` elements, at least one, `stride` bytes apart from `offset` on, fit into a view of `view_bytes`.
bool fits(std::uint64_t count, std::uint64_t element_bytes, std::uint64_t stride, std::uint64_t offset, std::uint64_t view_bytes) {
  if (offset > view_bytes || view_bytes - offset < element_bytes) return false;
  return count - 1 <= (view_bytes - offset - element_bytes) / stride;
}

// The checks of extensions. Every extension may be absent.

using Mode = MeshoptView::Mode;
using Filter = MeshoptView::Filter;

template <class Value, std::size_t N>
Result<Value> read_choice(const JsonObject& object, const char* name, const std::pair<const char*, Value> (&choices)[N]) {
  COPPICE_TRY(text, object.text(name));
  for (const auto& [choice, value] : choices)
    if (text == choice) return value;
  return object.bad("unknown value", name, " is '" + text.substr(0, 32) + "'");
}

constexpr std::pair<const char*, Mode> kModes[] = {
    {"ATTRIBUTES", Mode::attributes}, {"TRIANGLES", Mode::triangles}, {"INDICES", Mode::indices}};
constexpr std::pair<const char*, Filter> kFilters[] = {{"", Filter::none},
                                                       {"NONE", Filter::none},
                                                       {"OCTAHEDRAL", Filter::octahedral},
                                                       {"QUATERNION", Filter::quaternion},
                                                       {"EXPONENTIAL", Filter::exponential}};

/// Checks the extension's rules for the element size.
Result<void> check_meshopt_stride(const MeshoptView& view, const JsonObject& extension) {
  const std::size_t stride = view.stride_bytes;
  const bool fits_mode = view.mode == Mode::attributes ? stride % 4 == 0 && stride >= 4 && stride <= 256 : stride == 2 || stride == 4;
  if (!fits_mode) return extension.bad("stride does not fit the mode", "byteStride", stride);
  if (view.mode != Mode::attributes && view.filter != Filter::none) return extension.bad("indices have no filter", "filter");
  if ((view.filter == Filter::octahedral && stride != 4 && stride != 8) || (view.filter == Filter::quaternion && stride != 8))
    return extension.bad("stride does not fit the filter", "byteStride", stride);
  return {};
}

/// Checks where the coded bytes are, and that they can code so much.
Result<void> check_meshopt_bytes(const MeshoptView& view, const JsonObject& extension, std::span<const ScreenedBuffer> buffers) {
  COPPICE_TRY(buffer, extension.index("buffer", buffers.size()));
  if (buffers[buffer].is_fallback) return extension.bad("compressed data in a fallback buffer", "buffer");
  COPPICE_TRY(offset, extension.integer("byteOffset", 0));
  COPPICE_TRY(bytes, extension.integer("byteLength"));
  const std::uint64_t buffer_bytes = buffers[buffer].bytes;
  if (bytes == 0 || offset > buffer_bytes || bytes > buffer_bytes - offset)
    return extension.bad("compressed view runs past the end of its buffer", "", range_text(offset, bytes, buffer_bytes));
  if (meshopt_is_plausible(view.mode, view.count, view.stride_bytes, bytes)) return {};
  return extension.bad("more elements than so many bytes can code", "count",
                       " is " + std::to_string(view.count) + " in " + std::to_string(bytes) + " bytes");
}

Result<MeshoptView> read_meshopt(const JsonObject& extension, std::span<const ScreenedBuffer> buffers) {
  MeshoptView view;
  if (!extension.has("mode")) return extension.bad("missing member", "mode");
  COPPICE_CHECK(move_into(view.mode, read_choice(extension, "mode", kModes)));
  if (extension.json().value("filter", Json()) == "COLOR")
    return Error{Status::unsupported, "meshopt filter not supported", Error::kNoOffset, extension.place("filter") + " is COLOR"};
  COPPICE_CHECK(move_into(view.filter, read_choice(extension, "filter", kFilters)));
  COPPICE_CHECK(move_into(view.count, extension.integer("count")));
  COPPICE_CHECK(move_into(view.stride_bytes, extension.integer("byteStride")));
  COPPICE_CHECK(check_meshopt_stride(view, extension));
  if (view.count == 0 || (view.mode == Mode::triangles && view.count % 3 != 0))
    return extension.bad("count is no number of triangles or elements", "count", view.count);
  COPPICE_CHECK(check_meshopt_bytes(view, extension, buffers));
  return view;
}

/// Checks KHR_draco_mesh_compression of a primitive whose attributes have been checked.
Result<void> check_draco(const JsonObject& primitive, std::size_t view_count) {
  COPPICE_TRY(extension, primitive.extension(kDracoExtension));
  if (!extension) return {};
  COPPICE_TRY(mode, primitive.integer("mode", kTriangles));
  if (mode != kTriangles && mode != kTriangleStrip) return primitive.bad("compressed primitive of neither triangles nor strips", "mode");
  COPPICE_CHECK(extension->index("bufferView", view_count));
  COPPICE_TRY(attributes, extension->object("attributes"));
  if (!attributes || !attributes->has("POSITION")) return extension->bad("missing member", "attributes.POSITION");
  return attributes->for_each_name([&](const std::string& name) -> Result<void> {
    COPPICE_TRY(id, attributes->integer(name));
    if (id > kMaxInt) return attributes->bad("Draco attribute id out of range", name.substr(0, 64));
    if (primitive.json()["attributes"].contains(name)) return {};
    return attributes->bad("compressed attribute that the primitive does not have", name.substr(0, 64));
  });
}

/// Whether KHR_draco_mesh_compression codes that attribute of a checked primitive.
bool is_draco_attribute(const JsonObject& primitive, const std::string& name) {
  const auto extension = primitive.extension(kDracoExtension);
  return extension && *extension && (**extension).json()["attributes"].contains(name);
}

/// Takes EXT_meshopt_compression or KHR_meshopt_compression of buffer view number `index`, which then is a view of its coded bytes; nothing
/// if it has neither.
/// errors  unsupported: a filter of KHR_meshopt_compression that is not in EXT_meshopt_compression
Result<std::optional<MeshoptView>> take_meshopt(const JsonObject& view, std::size_t index, std::span<const ScreenedBuffer> buffers) {
  for (const char* name : kMeshoptExtensions) {
    COPPICE_TRY(extension, view.extension(name));
    if (!extension) continue;
    COPPICE_TRY(result, read_meshopt(*extension, buffers));
    result.view = index;
    result.extension = name;
    COPPICE_TRY(view_stride, view.integer("byteStride", result.stride_bytes));
    if (view_stride != result.stride_bytes) return view.bad("stride differs from that of the extension", "byteStride");
    COPPICE_TRY(view_bytes, view.integer("byteLength"));
    if (result.count > std::numeric_limits<std::uint64_t>::max() / result.stride_bytes || view_bytes != result.count * result.stride_bytes)
      return view.bad(
          "length is not count times stride of the extension", "byteLength",
          " is " + std::to_string(view_bytes) + ", " + std::to_string(result.count) + " times " + std::to_string(result.stride_bytes));
    const Json& coded = extension->json();
    view.json().update(
        {{"buffer", coded["buffer"]}, {"byteOffset", coded.value("byteOffset", std::uint64_t{0})}, {"byteLength", coded["byteLength"]}});
    return std::optional(result);
  }
  return std::optional<MeshoptView>();
}

/// Checks a textureInfo, with KHR_texture_transform.
Result<void> check_texture_info(const JsonObject& texture_info, std::size_t texture_count) {
  COPPICE_CHECK(texture_info.check_index("index", texture_count));
  COPPICE_TRY(transform, texture_info.extension("KHR_texture_transform"));
  if (!transform) return {};
  COPPICE_CHECK(transform->check_numbers("offset", 2));
  COPPICE_CHECK(transform->check_numbers("scale", 2));
  COPPICE_CHECK(transform->check_number("rotation"));
  COPPICE_TRY(set, transform->integer("texCoord", 0));
  return set <= kMaxInt ? Result<void>() : transform->bad("index out of range", "texCoord");
}

/// Checks KHR_materials_pbrSpecularGlossiness of a material and writes its values as pbrMetallicRoughness: diffuse becomes the base colour,
/// roughness is 1 - glossiness.
Result<void> take_specular_glossiness(const JsonObject& material, std::size_t texture_count) {
  COPPICE_TRY(extension, material.extension("KHR_materials_pbrSpecularGlossiness"));
  if (!extension) return {};
  COPPICE_CHECK(extension->check_numbers("diffuseFactor", 4));
  COPPICE_CHECK(extension->check_number("glossinessFactor"));
  COPPICE_TRY(texture, extension->object("diffuseTexture"));
  if (texture) COPPICE_CHECK(check_texture_info(*texture, texture_count));
  Json pbr = {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0 - extension->json().value("glossinessFactor", 1.0)}};
  if (extension->has("diffuseFactor")) pbr["baseColorFactor"] = extension->json()["diffuseFactor"];
  if (texture) pbr["baseColorTexture"] = texture->json();
  material.json()["pbrMetallicRoughness"] = std::move(pbr);
  return {};
}

/// Checks EXT_mesh_gpu_instancing of a node. counts  elements of each accessor
Result<void> check_instancing(const JsonObject& node, std::span<const std::uint64_t> counts) {
  COPPICE_TRY(extension, node.extension("EXT_mesh_gpu_instancing"));
  if (!extension) return {};
  COPPICE_TRY(attributes, extension->object("attributes"));
  if (!attributes || attributes->json().empty()) return extension->bad("missing member", "attributes");
  std::string first_name;
  std::uint64_t first_count = 0;
  return attributes->for_each_name([&](const std::string& name) -> Result<void> {
    COPPICE_TRY(accessor, attributes->index(name, counts.size()));
    if (first_count == 0) {
      first_name = name.substr(0, 64);
      first_count = counts[accessor];
    }
    if (counts[accessor] == first_count) return {};
    return attributes->bad(
        "instance attributes of unequal length", "",
        ": " + name.substr(0, 64) + " has " + std::to_string(counts[accessor]) + ", " + first_name + " " + std::to_string(first_count));
  });
}

struct View {
  std::uint64_t bytes = 0;
  std::uint64_t stride = 0;  ///< 0: tightly packed
};

/// Checks one document; each check relies on the earlier ones. What tinygltf would not understand becomes plain glTF.
class Screen {
 public:
  Screen(Json& root, std::optional<std::uint64_t> bin_chunk_bytes, const CostLimit& limit)
      : root_(root, ""), bin_chunk_bytes_(bin_chunk_bytes), limit_(limit) {}

  Result<ScreenedGltf> check() {
    COPPICE_CHECK(check_asset());
    COPPICE_CHECK(check_required_extensions());
    for (const Section& section : kSections) COPPICE_CHECK(check_length(section));
    find_fallback_buffers();
    parents_.assign(length("nodes"), length("nodes"));
    for (const Section& section : kSections)
      COPPICE_CHECK(root_.for_each(section.name, [&](const JsonObject& object) { return (this->*section.check)(object); }));
    COPPICE_CHECK(root_.check_index("scene", length("scenes")));
    COPPICE_CHECK(move_into(screened_.triangles, check_cost(root_.json(), meshes_, counts_, limit_)));
    return std::move(screened_);
  }

 private:
  struct Section {
    const char* name;
    std::size_t max_count;
    Result<void> (Screen::*check)(const JsonObject&);
  };
  static const std::array<Section, 10> kSections;

  [[nodiscard]] std::size_t length(const char* name) const {
    const auto found = root_.json().find(name);
    return found != root_.json().end() && found->is_array() ? found->size() : 0;
  }

  Result<void> check_asset() const {
    const auto asset = root_.object("asset");
    if (!asset || !*asset) return root_.bad("missing member", "asset");
    const auto version = (**asset).text("version");
    if (!version || !(**asset).has("version")) return (**asset).bad("missing member", "version");
    if (version->starts_with("2.")) return {};
    return Error{Status::unsupported, "glTF version other than 2", Error::kNoOffset, "asset.version is " + version->substr(0, 16)};
  }

  Result<void> check_required_extensions() {
    const auto required = root_.json().find("extensionsRequired");
    if (required == root_.json().end()) return {};
    if (!required->is_array()) return root_.bad("not an array", "extensionsRequired");
    for (const Json& name : *required) {
      if (!name.is_string()) return root_.bad("not a string", "extensionsRequired");
      const auto text = name.get<std::string>();
      if (!is_supported_extension(text))
        return Error{Status::unsupported, "required extension not supported", Error::kNoOffset,
                     "extensionsRequired: " + text.substr(0, 80)};
      requires_basisu_ = requires_basisu_ || text == kBasisu;
    }
    return {};
  }

  static Result<void> check_name(const JsonObject& object) {
    const auto name = object.json().find("name");
    if (name == object.json().end() || !name->is_string()) return {};
    const std::size_t bytes = name->get_ref<const std::string&>().size();
    if (bytes <= kMaxNameBytes) return {};
    return Error{Status::unsupported, "name too long", Error::kNoOffset,
                 object.place("name") + " has " + std::to_string(bytes) + " bytes, at most " + std::to_string(kMaxNameBytes)};
  }

  [[nodiscard]] Result<void> check_length(const Section& section) const {
    const std::size_t count = length(section.name);
    if (count <= section.max_count) return {};
    return Error{Status::unsupported, "too many elements", Error::kNoOffset,
                 std::string(section.name) + " has " + std::to_string(count) + ", at most " + std::to_string(section.max_count) +
                     " are read; instances take EXT_mesh_gpu_instancing"};
  }

  /// Finds fallback buffers: a buffer says that it is one, or it has no bytes and only compressed views use it. Runs before all checks.
  void find_fallback_buffers() {
    is_fallback_.assign(length("buffers"), false);
    for (std::size_t i = 0; i < is_fallback_.size(); ++i)
      for (const char* name : kMeshoptExtensions)
        if (const auto extension = JsonObject(root_.json()["buffers"][i], "").extension(name); extension && *extension)
          if ((**extension).json().value("fallback", Json()) == true) is_fallback_[i] = true;
    for (std::size_t i = 0; i < length("bufferViews"); ++i)
      for (const char* name : kMeshoptExtensions) {
        const JsonObject view(root_.json()["bufferViews"][i], "");
        if (const auto extension = view.extension(name); !extension || !*extension) continue;
        const auto buffer = view.index("buffer", is_fallback_.size());
        if (!buffer || (*buffer == 0 && bin_chunk_bytes_)) continue;
        if (!root_.json()["buffers"][*buffer].contains("uri")) is_fallback_[*buffer] = true;
      }
  }

  Result<void> check_buffer(const JsonObject& buffer) {
    COPPICE_TRY(bytes, buffer.integer("byteLength"));
    if (bytes == 0) return buffer.bad("empty buffer", "byteLength");
    std::vector<ScreenedBuffer>& buffers = screened_.buffers;
    ScreenedBuffer found{bytes, is_fallback_[buffers.size()], {}};
    if (buffer.has("uri")) {
      COPPICE_TRY(uri, buffer.text("uri"));
      found.uri = std::move(uri);
    } else if (!found.is_fallback) {
      if (!bin_chunk_bytes_ || !buffers.empty()) return buffer.bad("missing member", "uri");
      if (bytes > *bin_chunk_bytes_)
        return buffer.bad("buffer longer than the BIN chunk", "byteLength",
                          " is " + std::to_string(bytes) + " of " + std::to_string(*bin_chunk_bytes_));
    }
    buffers.push_back(std::move(found));
    return {};
  }

  Result<void> check_view(const JsonObject& view) {
    const std::vector<ScreenedBuffer>& buffers = screened_.buffers;
    COPPICE_TRY(buffer, view.index("buffer", buffers.size()));
    COPPICE_TRY(offset, view.integer("byteOffset", 0));
    COPPICE_TRY(bytes, view.integer("byteLength"));
    COPPICE_TRY(stride, view.integer("byteStride", 0));
    const std::uint64_t buffer_bytes = buffers[buffer].bytes;
    if (offset > buffer_bytes || bytes > buffer_bytes - offset)
      return view.bad("buffer view runs past the end of its buffer", "", range_text(offset, bytes, buffer_bytes));
    if (bytes == 0) return view.bad("empty buffer view", "byteLength");
    if (stride > 252 || stride % 4 != 0) return view.bad("stride not a multiple of 4 up to 252", "byteStride");
    COPPICE_TRY(meshopt, take_meshopt(view, views_.size(), buffers));
    if (meshopt) screened_.meshopt_views.push_back(*meshopt);
    if (!meshopt && buffers[buffer].is_fallback) return view.bad("view of a fallback buffer is not compressed", "buffer");
    views_.push_back(View{bytes, stride});
    return {};
  }

  Result<void> check_accessor(const JsonObject& accessor) {
    COPPICE_TRY(component_type, accessor.integer("componentType"));
    const std::uint64_t scalar_bytes = component_bytes(component_type);
    if (scalar_bytes == 0) return accessor.bad("unknown component type", "componentType", component_type);
    const auto type = accessor.text("type");
    if (!type || !accessor.has("type")) return accessor.bad("missing member", "type");
    const std::uint64_t element_bytes = scalar_bytes * component_count(*type);
    if (element_bytes == 0) return accessor.bad("unknown type", "type", " is " + type->substr(0, 16));
    COPPICE_TRY(count, accessor.integer("count"));
    if (count == 0) return accessor.bad("empty accessor", "count");
    COPPICE_TRY(offset, accessor.integer("byteOffset", 0));
    COPPICE_CHECK(accessor.check_index("bufferView", views_.size()));
    COPPICE_CHECK(check_sparse(accessor, count, element_bytes));
    counts_.push_back(count);
    if (!accessor.has("bufferView")) return {};
    return check_range(accessor, views_[accessor.json()["bufferView"].get<std::size_t>()], count, element_bytes, offset);
  }

  static Result<void> check_range(const JsonObject& object, const View& view, std::uint64_t count, std::uint64_t element_bytes,
                                  std::uint64_t offset) {
    if (view.stride != 0 && view.stride < element_bytes) return object.bad("elements overlap: stride shorter than one");
    if (fits(count, element_bytes, view.stride != 0 ? view.stride : element_bytes, offset, view.bytes)) return {};
    return object.bad("accessor runs past the end of its buffer view", "",
                      ": count " + std::to_string(count) + ", byteOffset " + std::to_string(offset) + ", view of " +
                          std::to_string(view.bytes) + " bytes");
  }

  [[nodiscard]] Result<void> check_sparse(const JsonObject& accessor, std::uint64_t accessor_count, std::uint64_t element_bytes) const {
    COPPICE_TRY(sparse, accessor.object("sparse"));
    if (!sparse) return {};
    COPPICE_TRY(count, sparse->integer("count"));
    if (count == 0 || count > accessor_count || count > kMaxInt) return sparse->bad("sparse count out of range", "count");
    for (const std::string_view name : {"indices", "values"}) {
      const auto part = sparse->object(std::string(name));
      if (!part || !*part) return sparse->bad("missing member", std::string(name));
      COPPICE_TRY(view, (**part).index("bufferView", views_.size()));
      COPPICE_TRY(offset, (**part).integer("byteOffset", 0));
      if (offset > kMaxInt) return (**part).bad("offset too large", "byteOffset");
      std::uint64_t bytes = element_bytes;
      if (name == "indices") {
        COPPICE_TRY(component_type, (**part).integer("componentType"));
        if (component_type != kUnsignedByte && component_type != kUnsignedShort && component_type != kUnsignedInt)
          return (**part).bad("unknown component type", "componentType");
        bytes = component_bytes(component_type);
      }
      COPPICE_CHECK(check_range(**part, View{views_[view].bytes, 0}, count, bytes, offset));
    }
    return {};
  }

  [[nodiscard]] bool is_backed(std::size_t accessor) const { return root_.json()["accessors"][accessor].contains("bufferView"); }

  /// Limits the elements that are read and that no bytes of the file back, each time that they are used. The index has been checked.
  Result<void> check_backed(std::size_t accessor) {
    if (is_backed(accessor)) return {};
    if (counts_[accessor] <= kMaxUnbackedCount - unbacked_) return unbacked_ += counts_[accessor], Result<void>();
    return root_.bad("accessors without a buffer view are too long", "accessors",
                     "[" + std::to_string(accessor) + "].count is " + std::to_string(counts_[accessor]) + ", " + std::to_string(unbacked_) +
                         " before it, at most " + std::to_string(kMaxUnbackedCount));
  }

  Result<void> check_image(const JsonObject& image) {
    if (image.has("uri") == image.has("bufferView")) return image.bad("needs either uri or bufferView");
    COPPICE_TRY(uri, image.text("uri"));
    COPPICE_CHECK(image.check_index("bufferView", views_.size()));
    const auto name = image.text("name");
    screened_.images.push_back({name ? *name : "", std::move(uri), image.json().value("bufferView", -1)});
    return {};
  }

  Result<void> check_texture(const JsonObject& texture) {
    COPPICE_CHECK(texture.check_index("source", length("images")));
    COPPICE_TRY(basisu, requires_basisu_ ? texture.extension(kBasisu) : std::optional<JsonObject>());
    COPPICE_TRY(webp, texture.extension("EXT_texture_webp"));
    if (webp) return webp->check_index("source", length("images"));
    if (!basisu || texture.has("source")) return {};
    return Error{Status::unsupported, kKtxImage, Error::kNoOffset, basisu->place()};
  }

  Result<void> check_material(const JsonObject& material) {
    COPPICE_TRY(pbr, material.object("pbrMetallicRoughness"));
    if (pbr) {
      COPPICE_CHECK(pbr->check_numbers("baseColorFactor", 4));
      COPPICE_TRY(texture, pbr->object("baseColorTexture"));
      if (texture) COPPICE_CHECK(check_texture_info(*texture, length("textures")));
    }
    return take_specular_glossiness(material, length("textures"));
  }

  Result<void> check_mesh(const JsonObject& mesh) {
    COPPICE_CHECK(check_name(mesh));  // every node that shows it gets a copy
    COPPICE_CHECK(check_morph_weights(mesh));
    meshes_.emplace_back();
    return mesh.for_each("primitives", [this](const JsonObject& primitive) { return check_primitive(primitive); });
  }

  /// A mesh, and a node too, has a weight for each morph target.
  static Result<void> check_morph_weights(const JsonObject& object) {
    if (!object.has("weights")) return {};
    const std::size_t count = object.json()["weights"].size();
    if (count <= kMaxMorphs) return object.check_numbers("weights", count);
    return Error{Status::unsupported, "more than 4096 morph weights", Error::kNoOffset, object.place("weights")};
  }

  Result<void> check_skin(const JsonObject& skin) {
    COPPICE_CHECK(skin.check_indices("joints", length("nodes")));
    if (!skin.has("joints") || skin.json()["joints"].empty()) return skin.bad("missing member", "joints");
    COPPICE_CHECK(skin.check_index("inverseBindMatrices", counts_.size()));
    if (!skin.has("inverseBindMatrices")) return {};
    const auto matrices = skin.json()["inverseBindMatrices"].get<std::size_t>();
    if (counts_[matrices] < skin.json()["joints"].size()) return skin.bad("fewer matrices than joints", "inverseBindMatrices");
    return check_backed(matrices);
  }

  Result<void> check_primitive(const JsonObject& primitive) {
    COPPICE_TRY(mode, primitive.integer("mode", kTriangles));
    if (mode > kTriangleFan) return primitive.bad("unknown mode", "mode", mode);
    COPPICE_CHECK(primitive.check_index("indices", length("accessors")));
    COPPICE_CHECK(primitive.check_index("material", length("materials")));
    const auto attributes = primitive.object("attributes");
    if (!attributes || !*attributes) return primitive.bad("missing member", "attributes");
    const JsonObject& members = **attributes;
    COPPICE_CHECK(members.for_each_name([&](const std::string& name) { return members.check_index(name, length("accessors")); }));
    if (mode >= kTriangles && !members.has("POSITION")) return members.bad("triangles without positions", "POSITION");
    COPPICE_CHECK(check_draco(primitive, views_.size()));
    COPPICE_CHECK(primitive.for_each("targets", [&](const JsonObject& target) {
      return target.for_each_name([&](const std::string& name) { return target.check_index(name, counts_.size()); });
    }));
    const std::uint64_t triangles = meshes_.back().add(primitive.json(), counts_);
    if (is_draco_attribute(primitive, "POSITION")) {
      // Coded indices come with the coded positions, but tinygltf insists that indices have bytes. The decoder compares what they were.
      primitive.json().erase("indices");
      primitive.json()["extensions"][kDracoExtension]["triangles"] = std::min(triangles, kMaxInt);
      return {};
    }
    // Other attributes are not read unless they are as long as the positions.
    if (members.has("POSITION")) COPPICE_CHECK(check_backed(members.json()["POSITION"].get<std::size_t>()));
    return primitive.has("indices") ? check_backed(primitive.json()["indices"].get<std::size_t>()) : Result<void>();
  }

  /// Every node has at most one parent. The last node completes the trees.
  Result<void> check_node(const JsonObject& node) {
    COPPICE_CHECK(node.check_index("mesh", length("meshes")));
    COPPICE_CHECK(node.check_index("skin", length("skins")));
    COPPICE_CHECK(check_morph_weights(node));
    COPPICE_CHECK(node.check_indices("children", length("nodes")));
    constexpr std::pair<const char*, std::size_t> kNumbers[] = {{"matrix", 16}, {"translation", 3}, {"rotation", 4}, {"scale", 3}};
    for (const auto& [name, count] : kNumbers) COPPICE_CHECK(node.check_numbers(name, count));
    COPPICE_CHECK(check_instancing(node, counts_));
    COPPICE_TRY(levels, node.extension(kLevelsExtension));
    if (levels) COPPICE_CHECK(levels->check_indices("ids", length("nodes")));
    COPPICE_TRY(visibility, node.extension(kVisibilityExtension));
    if (visibility && visibility->has("visible") && !visibility->json()["visible"].is_boolean())
      return visibility->bad("neither true nor false", "visible");
    COPPICE_TRY(instancing, node.extension("EXT_mesh_gpu_instancing"));
    // All have one length, for which the bytes of any vouch.
    if (instancing)
      if (const Json& attributes = instancing->json()["attributes"];
          std::ranges::none_of(attributes, [this](const Json& accessor) { return is_backed(accessor.get<std::size_t>()); }))
        COPPICE_CHECK(check_backed(attributes.begin()->get<std::size_t>()));
    for (const Json& child : node.json().value("children", Json::array())) {
      std::size_t& parent = parents_[child.get<std::size_t>()];
      if (parent != parents_.size()) return bad_node("node has two parents", child.get<std::size_t>());
      parent = node_count_;
    }
    return ++node_count_ < parents_.size() ? Result<void>() : check_ancestors();
  }

  /// Following parents ends: then a walk from any root ends too, and meets each node once.
  [[nodiscard]] Result<void> check_ancestors() const {
    const std::size_t count = parents_.size();
    std::vector<std::size_t> seen_from(count, count);
    for (std::size_t start = 0; start < count; ++start)
      for (std::size_t i = start; i != count && seen_from[i] == count; i = parents_[i]) {
        seen_from[i] = start;
        if (parents_[i] != count && seen_from[parents_[i]] == start) return bad_node("node is its own ancestor", i);
      }
    return {};
  }

  [[nodiscard]] Error bad_node(const char* what, std::size_t node) const {
    return root_.bad(what, "nodes", "[" + std::to_string(node) + "]");
  }

  Result<void> check_scene(const JsonObject& scene) {
    COPPICE_CHECK(scene.check_indices("nodes", parents_.size()));
    std::vector<bool> listed(parents_.size(), false);
    for (const Json& node : scene.json().value("nodes", Json::array())) {
      const auto index = node.get<std::size_t>();
      if (listed[index]) return scene.bad("node listed twice", "nodes", ": " + std::to_string(index));
      if (parents_[index] != parents_.size())
        return scene.bad("scene lists a node that is another's child", "nodes", ": " + std::to_string(index));
      listed[index] = true;
    }
    return {};
  }

  JsonObject root_;
  std::optional<std::uint64_t> bin_chunk_bytes_;
  CostLimit limit_;
  ScreenedGltf screened_;
  bool requires_basisu_ = false;
  std::vector<bool> is_fallback_;  ///< [buffers]
  std::vector<View> views_;
  std::vector<std::uint64_t> counts_;  ///< [accessors]
  std::uint64_t unbacked_ = 0;         ///< elements so far that no bytes of the file back
  std::vector<MeshCost> meshes_;
  std::vector<std::size_t> parents_;  ///< [nodes] the number of nodes for a root
  std::size_t node_count_ = 0;        ///< how many have been checked
};

// In the order in which they are checked.
const std::array<Screen::Section, 10> Screen::kSections{{{"buffers", kMaxLargeElements, &Screen::check_buffer},
                                                         {"bufferViews", kMaxElements, &Screen::check_view},
                                                         {"accessors", kMaxElements, &Screen::check_accessor},
                                                         {"images", kMaxLargeElements, &Screen::check_image},
                                                         {"textures", kMaxLargeElements, &Screen::check_texture},
                                                         {"materials", kMaxLargeElements, &Screen::check_material},
                                                         {"meshes", kMaxElements, &Screen::check_mesh},
                                                         {"skins", kMaxLargeElements, &Screen::check_skin},
                                                         {"nodes", kMaxElements, &Screen::check_node},
                                                         {"scenes", kMaxLargeElements, &Screen::check_scene}}};

/// Drops values that tinygltf would keep at 152 bytes each: those of `extras` and of extensions that are not read.
void drop_unread_values(Json& value) {
  if (value.is_object()) {
    value.erase("extras");
    if (const auto extensions = value.find("extensions"); extensions != value.end() && extensions->is_object())
      for (const auto& extension : extensions->items())
        if (std::ranges::find(kReadExtensions, extension.key()) == kReadExtensions.end()) extension.value() = Json::object();
  }
  if (value.is_structured())
    for (Json& inner : value) drop_unread_values(inner);
}

}  // namespace

bool is_supported_extension(std::string_view name) {
  const auto is_known = [&](std::string_view known) {
    return known.ends_with('*') ? name.starts_with(known.substr(0, known.size() - 1)) : name == known;
  };
  return std::ranges::any_of(kReadExtensions, is_known) || std::ranges::any_of(kOtherExtensions, is_known);
}

Result<ScreenedGltf> screen_gltf(std::string_view json, std::optional<std::uint64_t> bin_chunk_bytes, const CostLimit& limit) {
  COPPICE_TRY(root, parse_gltf_json(json));
  if (!root.is_object()) return Error{Status::bad_file, "not a JSON object", Error::kNoOffset, "the document"};
  COPPICE_TRY(screened, Screen(root, bin_chunk_bytes, limit).check());
  screened.has_animations = root.contains("animations") && !root["animations"].empty();
  screened.references = find_references(root);
  for (const char* unread : {"buffers", "images", "animations", "cameras", "samplers", "extensions"}) root.erase(unread);
  drop_unread_values(root);
  screened.json = root.dump(-1, ' ', false, Json::error_handler_t::replace);
  return screened;
}

}  // namespace coppice::bake
