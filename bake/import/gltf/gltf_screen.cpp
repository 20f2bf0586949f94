#include "gltf_screen.h"

#include <algorithm>
#include <array>
#include <utility>

#include <nlohmann/json.hpp>

#include "gltf_codes.h"
#include "gltf_draco.h"
#include "gltf_json.h"
#include "gltf_screen_extensions.h"

namespace coppice::bake {
namespace {

using namespace gltf_json;

// Limits accessors without a buffer view: they are all zeros, so no bytes of the file vouch for their length. Sparse accessors use them.
constexpr std::uint64_t kMaxUnbackedCount = 1u << 20;
// tinygltf keeps indices and sparse offsets in an int.
constexpr std::uint64_t kMaxInt = 0x7fffffff;

/// An element of a few bytes becomes up to 2 kB in tinygltf's model. These bounds keep that below 130 MB an array.
struct ArrayLimit {
  const char* name;
  std::size_t max_count;
};
constexpr std::size_t kMaxElements = std::size_t{1} << 18, kMaxLargeElements = std::size_t{1} << 16;
constexpr std::array<ArrayLimit, 9> kArrayLimits{{{"nodes", kMaxElements},
                                                  {"meshes", kMaxElements},
                                                  {"accessors", kMaxElements},
                                                  {"bufferViews", kMaxElements},
                                                  {"buffers", kMaxLargeElements},
                                                  {"images", kMaxLargeElements},
                                                  {"textures", kMaxLargeElements},
                                                  {"materials", kMaxLargeElements},
                                                  {"scenes", kMaxLargeElements}}};

std::size_t component_bytes(std::uint64_t component_type) {
  switch (component_type) {
    case gltf_code::kByte:
    case gltf_code::kUnsignedByte:
      return 1;
    case gltf_code::kShort:
    case gltf_code::kUnsignedShort:
      return 2;
    case gltf_code::kUnsignedInt:
    case gltf_code::kFloat:
      return 4;
    default:
      return 0;
  }
}

std::size_t component_count(const std::string& type) {
  constexpr std::array<std::pair<std::string_view, std::size_t>, 7> kTypes{
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
  for (const auto& [name, count] : kTypes)
    if (type == name) return count;
  return 0;
}

/// Whether `count` elements, `stride` bytes apart from `offset` on, fit into a view of `view_bytes`.
bool fits(std::uint64_t count, std::uint64_t element_bytes, std::uint64_t stride, std::uint64_t offset, std::uint64_t view_bytes) {
  if (count == 0) return offset <= view_bytes;
  if (offset > view_bytes || view_bytes - offset < element_bytes) return false;
  return count - 1 <= (view_bytes - offset - element_bytes) / stride;
}

struct View {
  std::uint64_t bytes = 0;
  std::uint64_t stride = 0;  ///< 0: tightly packed
};

/// Checks one document; each check relies on the earlier ones.
class Screen {
 public:
  Screen(const Json& root, std::optional<std::uint64_t> bin_chunk_bytes) : root_(root), bin_chunk_bytes_(bin_chunk_bytes) {}

  Result<void> check() {
    COPPICE_CHECK(check_asset());
    COPPICE_CHECK(check_required_extensions());
    COPPICE_CHECK(check_lengths());
    find_fallback_buffers();
    COPPICE_CHECK(
        for_each_object(root_, "buffers", "", [this](const Json& o, const std::string& place) { return check_buffer(o, place); }));
    COPPICE_CHECK(
        for_each_object(root_, "bufferViews", "", [this](const Json& o, const std::string& place) { return check_view(o, place); }));
    COPPICE_CHECK(
        for_each_object(root_, "accessors", "", [this](const Json& o, const std::string& place) { return check_accessor(o, place); }));
    COPPICE_CHECK(for_each_object(root_, "images", "", [this](const Json& o, const std::string& place) { return check_image(o, place); }));
    COPPICE_CHECK(
        for_each_object(root_, "textures", "", [this](const Json& o, const std::string& place) { return check_texture(o, place); }));
    COPPICE_CHECK(
        for_each_object(root_, "materials", "", [this](const Json& o, const std::string& place) { return check_material(o, place); }));
    COPPICE_CHECK(for_each_object(root_, "meshes", "", [this](const Json& o, const std::string& place) { return check_mesh(o, place); }));
    COPPICE_CHECK(for_each_object(root_, "nodes", "", [this](const Json& o, const std::string& place) { return check_node(o, place); }));
    COPPICE_CHECK(check_node_trees());
    return check_scenes();
  }
  [[nodiscard]] const std::vector<ScreenedBuffer>& buffers() const { return buffers_; }
  [[nodiscard]] const std::vector<MeshoptView>& meshopt_views() const { return meshopt_views_; }

 private:
  [[nodiscard]] std::size_t length(const char* name) const {
    const auto found = root_.find(name);
    return found != root_.end() && found->is_array() ? found->size() : 0;
  }

  Result<void> check_asset() const {
    const auto asset = root_.find("asset");
    if (asset == root_.end() || !asset->is_object()) return bad("missing member", "asset");
    const auto version = asset->find("version");
    if (version == asset->end() || !version->is_string()) return bad("missing member", "asset.version");
    const auto text = version->get<std::string>();
    if (text.starts_with("2.")) return {};
    return Error{Status::unsupported, "glTF version other than 2", Error::kNoOffset, "asset.version is " + text.substr(0, 16)};
  }

  Result<void> check_required_extensions() const {
    const auto required = root_.find("extensionsRequired");
    if (required == root_.end()) return {};
    if (!required->is_array()) return bad("not an array", "extensionsRequired");
    for (const Json& name : *required) {
      if (!name.is_string()) return bad("not a string", "extensionsRequired");
      const auto text = name.get<std::string>();
      if (!is_supported_extension(text))
        return Error{Status::unsupported, "required extension not supported", Error::kNoOffset,
                     "extensionsRequired: " + text.substr(0, 80)};
    }
    return {};
  }

  [[nodiscard]] bool is_required(std::string_view extension) const {
    const auto required = root_.find("extensionsRequired");
    return required != root_.end() && std::ranges::find(*required, extension) != required->end();
  }

  Result<void> check_lengths() const {
    for (const ArrayLimit& limit : kArrayLimits)
      if (length(limit.name) > limit.max_count)
        return Error{Status::unsupported, "too many elements", Error::kNoOffset,
                     std::string(limit.name) + " has " + std::to_string(length(limit.name)) + ", at most " +
                         std::to_string(limit.max_count) + " are read; instances take EXT_mesh_gpu_instancing"};
    return {};
  }

  /// Finds fallback buffers: a buffer says that it is one, or it has no bytes and only compressed views use it. Runs before all checks.
  void find_fallback_buffers() {
    is_fallback_.assign(length("buffers"), false);
    for (std::size_t i = 0; i < is_fallback_.size(); ++i)
      for (const char* name : kMeshoptExtensions)
        if (const auto extension = find_extension(root_["buffers"][i], name, ""); extension && *extension != nullptr)
          if (const auto flag = (*extension)->find("fallback"); flag != (*extension)->end() && *flag == true) is_fallback_[i] = true;
    for (std::size_t i = 0; i < length("bufferViews"); ++i)
      for (const char* name : kMeshoptExtensions) {
        const Json& view = root_["bufferViews"][i];
        if (const auto extension = find_extension(view, name, ""); !extension || *extension == nullptr) continue;
        const auto buffer = read_integer(view, "buffer", "", is_fallback_.size());
        if (!buffer || *buffer >= is_fallback_.size() || (*buffer == 0 && bin_chunk_bytes_)) continue;
        if (!root_["buffers"][*buffer].contains("uri")) is_fallback_[*buffer] = true;
      }
  }

  Result<void> check_buffer(const Json& buffer, const std::string& place) {
    COPPICE_TRY(bytes, require_integer(buffer, "byteLength", place));
    if (bytes == 0) return bad("empty buffer", member(place, "byteLength"));
    const bool is_fallback = is_fallback_[buffers_.size()];
    const auto uri = buffer.find("uri");
    if (uri == buffer.end() && !is_fallback) {
      if (!bin_chunk_bytes_ || !buffers_.empty()) return bad("missing member", member(place, "uri"));
      if (bytes > *bin_chunk_bytes_)
        return bad("buffer longer than the BIN chunk",
                   member(place, "byteLength") + " is " + std::to_string(bytes) + " of " + std::to_string(*bin_chunk_bytes_));
    } else if (uri != buffer.end() && !uri->is_string()) {
      return bad("not a string", member(place, "uri"));
    }
    buffers_.push_back(ScreenedBuffer{bytes, is_fallback});
    return {};
  }

  Result<void> check_view(const Json& view, const std::string& place) {
    COPPICE_TRY(buffer, require_index(view, "buffer", place, buffers_.size()));
    COPPICE_TRY(offset, read_integer(view, "byteOffset", place, 0));
    COPPICE_TRY(bytes, require_integer(view, "byteLength", place));
    COPPICE_TRY(stride, read_integer(view, "byteStride", place, 0));
    const std::uint64_t buffer_bytes = buffers_[buffer].bytes;
    if (offset > buffer_bytes || bytes > buffer_bytes - offset)
      return bad("buffer view runs past the end of its buffer",
                 place + ": " + std::to_string(offset) + " + " + std::to_string(bytes) + " of " + std::to_string(buffer_bytes) + " bytes");
    if (bytes == 0) return bad("empty buffer view", member(place, "byteLength"));
    if (stride > 252 || stride % 4 != 0) return bad("stride not a multiple of 4 up to 252", member(place, "byteStride"));
    COPPICE_TRY(meshopt, read_meshopt(view, place, views_.size(), buffers_));
    if (meshopt) meshopt_views_.push_back(*meshopt);
    if (!meshopt && buffers_[buffer].is_fallback) return bad("view of a fallback buffer is not compressed", member(place, "buffer"));
    views_.push_back(View{bytes, stride});
    return {};
  }

  Result<void> check_accessor(const Json& accessor, const std::string& place) {
    COPPICE_TRY(component_type, require_integer(accessor, "componentType", place));
    const std::uint64_t scalar_bytes = component_bytes(component_type);
    if (scalar_bytes == 0) return bad("unknown component type", member(place, "componentType") + " is " + std::to_string(component_type));
    const auto type = accessor.find("type");
    if (type == accessor.end() || !type->is_string()) return bad("missing member", member(place, "type"));
    const std::uint64_t element_bytes = scalar_bytes * component_count(type->get<std::string>());
    if (element_bytes == 0) return bad("unknown type", member(place, "type") + " is " + type->get<std::string>().substr(0, 16));
    COPPICE_TRY(count, require_integer(accessor, "count", place));
    if (count == 0) return bad("empty accessor", member(place, "count"));
    COPPICE_TRY(offset, read_integer(accessor, "byteOffset", place, 0));
    COPPICE_CHECK(check_index(accessor, "bufferView", place, views_.size()));
    COPPICE_CHECK(check_sparse(accessor, place, count, element_bytes));
    counts_.push_back(count);
    if (!accessor.contains("bufferView")) return {};
    return check_range(views_[accessor["bufferView"].get<std::size_t>()], count, element_bytes, offset, place);
  }

  static Result<void> check_range(const View& view, std::uint64_t count, std::uint64_t element_bytes, std::uint64_t offset,
                                  const std::string& place) {
    if (view.stride != 0 && view.stride < element_bytes) return bad("elements overlap: stride shorter than one", place);
    if (fits(count, element_bytes, view.stride != 0 ? view.stride : element_bytes, offset, view.bytes)) return {};
    return bad("accessor runs past the end of its buffer view", place + ": count " + std::to_string(count) + ", byteOffset " +
                                                                    std::to_string(offset) + ", view of " + std::to_string(view.bytes) +
                                                                    " bytes");
  }

  Result<void> check_sparse(const Json& accessor, const std::string& accessor_place, std::uint64_t accessor_count,
                            std::uint64_t element_bytes) const {
    COPPICE_TRY(sparse, find_object(accessor, "sparse", accessor_place));
    if (sparse == nullptr) return {};
    const std::string place = member(accessor_place, "sparse");
    COPPICE_TRY(count, require_integer(*sparse, "count", place));
    if (count == 0 || count > accessor_count) return bad("sparse count out of range", member(place, "count"));
    const std::array<const char*, 2> names{"indices", "values"};
    for (const char* name : names) {
      const auto part = sparse->find(name);
      const std::string where = member(place, name);
      if (part == sparse->end() || !part->is_object()) return bad("missing member", where);
      COPPICE_TRY(view, require_index(*part, "bufferView", where, views_.size()));
      COPPICE_TRY(offset, read_integer(*part, "byteOffset", where, 0));
      if (offset > kMaxInt) return bad("offset too large", member(where, "byteOffset"));
      std::uint64_t bytes = element_bytes;
      if (name == names[0]) {
        COPPICE_TRY(component_type, require_integer(*part, "componentType", where));
        if (component_type != gltf_code::kUnsignedByte && component_type != gltf_code::kUnsignedShort &&
            component_type != gltf_code::kUnsignedInt)
          return bad("unknown component type", member(where, "componentType"));
        bytes = component_bytes(component_type);
      }
      COPPICE_CHECK(check_range(View{views_[view].bytes, 0}, count, bytes, offset, where));
    }
    return {};
  }

  /// Limits the length of accessors that are read and that no bytes of the file back. The index has been checked.
  [[nodiscard]] Result<void> check_backed(std::size_t accessor) const {
    if (counts_[accessor] <= kMaxUnbackedCount || root_["accessors"][accessor].contains("bufferView")) return {};
    return bad("accessor without a buffer view is too long",
               member(element("accessors", accessor), "count") + " is " + std::to_string(counts_[accessor]));
  }

  Result<void> check_image(const Json& image, const std::string& place) const {
    if (image.contains("uri") == image.contains("bufferView")) return bad("needs either uri or bufferView", place);
    if (image.contains("uri") && !image["uri"].is_string()) return bad("not a string", member(place, "uri"));
    return check_index(image, "bufferView", place, views_.size());
  }

  Result<void> check_texture(const Json& texture, const std::string& place) const {
    COPPICE_CHECK(check_index(texture, "source", place, length("images")));
    if (is_required("KHR_texture_basisu")) COPPICE_CHECK(check_basisu_fallback(texture, place));
    return check_webp(texture, place, length("images"));
  }

  Result<void> check_material(const Json& material, const std::string& place) const {
    COPPICE_CHECK(check_specular_glossiness(material, place, length("textures")));
    COPPICE_TRY(pbr, find_object(material, "pbrMetallicRoughness", place));
    if (pbr == nullptr) return {};
    const std::string where = member(place, "pbrMetallicRoughness");
    COPPICE_CHECK(check_numbers(*pbr, "baseColorFactor", where, 4));
    COPPICE_TRY(texture, find_object(*pbr, "baseColorTexture", where));
    if (texture == nullptr) return {};
    COPPICE_CHECK(check_index(*texture, "index", member(where, "baseColorTexture"), length("textures")));
    return check_texture_transform(*texture, member(where, "baseColorTexture"));
  }

  Result<void> check_mesh(const Json& mesh, const std::string& place) const {
    return for_each_object(mesh, "primitives", place,
                           [this](const Json& primitive, const std::string& where) { return check_primitive(primitive, where); });
  }

  Result<void> check_primitive(const Json& primitive, const std::string& place) const {
    COPPICE_TRY(mode, read_integer(primitive, "mode", place, gltf_code::kTriangles));
    if (mode > gltf_code::kTriangleFan) return bad("unknown mode", member(place, "mode") + " is " + std::to_string(mode));
    COPPICE_CHECK(check_index(primitive, "indices", place, length("accessors")));
    COPPICE_CHECK(check_index(primitive, "material", place, length("materials")));
    const auto attributes = primitive.find("attributes");
    const std::string where = member(place, "attributes");
    if (attributes == primitive.end() || !attributes->is_object()) return bad("missing member", where);
    for (const auto& attribute : attributes->items())
      COPPICE_CHECK(check_index(*attributes, attribute.key().c_str(), where, length("accessors")));
    if (mode >= gltf_code::kTriangles && !attributes->contains("POSITION"))
      return bad("triangles without positions", member(where, "POSITION"));
    COPPICE_CHECK(check_draco(primitive, place, views_.size()));
    // Attributes that Draco codes are not read from their accessors.
    for (const auto& attribute : attributes->items())
      if (!is_draco_attribute(primitive, attribute.key())) COPPICE_CHECK(check_backed(attribute.value().get<std::size_t>()));
    if (primitive.contains("indices") && !is_draco_attribute(primitive, "POSITION"))
      COPPICE_CHECK(check_backed(primitive["indices"].get<std::size_t>()));
    return {};
  }

  Result<void> check_node(const Json& node, const std::string& place) const {
    COPPICE_CHECK(check_index(node, "mesh", place, length("meshes")));
    COPPICE_CHECK(check_indices(node, "children", place, length("nodes")));
    COPPICE_CHECK(check_numbers(node, "matrix", place, 16));
    COPPICE_CHECK(check_numbers(node, "translation", place, 3));
    COPPICE_CHECK(check_numbers(node, "rotation", place, 4));
    COPPICE_CHECK(check_numbers(node, "scale", place, 3));
    COPPICE_CHECK(check_instancing(node, place, counts_));
    COPPICE_TRY(levels, find_extension(node, kLevelsExtension, place));
    if (levels != nullptr) COPPICE_CHECK(check_indices(*levels, "ids", extension_place(place, kLevelsExtension), length("nodes")));
    if (const auto instancing = find_extension(node, "EXT_mesh_gpu_instancing", place); instancing && *instancing != nullptr)
      for (const auto& attribute : (**instancing)["attributes"].items()) COPPICE_CHECK(check_backed(attribute.value().get<std::size_t>()));
    return {};
  }

  /// Every node has at most one parent, and following parents ends: then a walk from any root ends too, and meets each node once.
  Result<void> check_node_trees() {
    const std::size_t count = length("nodes");
    parents_.assign(count, count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto children = root_["nodes"][i].find("children");
      if (children == root_["nodes"][i].end()) continue;
      for (const Json& child : *children) {
        std::size_t& parent = parents_[child.get<std::size_t>()];
        if (parent != count) return bad("node has two parents", element("nodes", child.get<std::size_t>()));
        parent = i;
      }
    }
    std::vector<std::size_t> seen_from(count, count);
    for (std::size_t start = 0; start < count; ++start)
      for (std::size_t i = start; i != count && seen_from[i] == count; i = parents_[i]) {
        seen_from[i] = start;
        if (parents_[i] != count && seen_from[parents_[i]] == start) return bad("node is its own ancestor", element("nodes", i));
      }
    return {};
  }

  Result<void> check_scenes() const {
    const std::size_t node_count = length("nodes");
    COPPICE_CHECK(check_index(root_, "scene", "", length("scenes")));
    return for_each_object(root_, "scenes", "", [&](const Json& scene, const std::string& place) -> Result<void> {
      COPPICE_CHECK(check_indices(scene, "nodes", place, node_count));
      std::vector<bool> listed(node_count, false);
      for (const Json& node : scene.value("nodes", Json::array())) {
        const auto index = node.get<std::size_t>();
        const std::string where = member(place, "nodes") + ": " + std::to_string(index);
        if (listed[index]) return bad("node listed twice", where);
        if (parents_[index] != node_count) return bad("scene lists a node that is another's child", where);
        listed[index] = true;
      }
      return {};
    });
  }

  const Json& root_;
  std::optional<std::uint64_t> bin_chunk_bytes_;
  std::vector<bool> is_fallback_;  ///< [buffers]
  std::vector<ScreenedBuffer> buffers_;
  std::vector<View> views_;
  std::vector<MeshoptView> meshopt_views_;
  std::vector<std::uint64_t> counts_;  ///< [accessors]
  std::vector<std::size_t> parents_;   ///< [nodes] the number of nodes for a root
};

/// Names the media type by the bytes themselves, since tinygltf knows a few types only.
void normalise_data_uri(Json& object) {
  constexpr std::string_view kMark = ";base64,";
  constexpr std::size_t kMaxHeaderChars = 128;
  const auto uri = object.find("uri");
  if (uri == object.end()) return;
  const auto& text = uri->get_ref<const std::string&>();
  const std::size_t mark = text.find(kMark);
  if (!text.starts_with("data:") || mark > kMaxHeaderChars) return;
  *uri = "data:application/octet-stream;base64," + text.substr(mark + kMark.size());
}

/// Drops values that tinygltf would keep at 152 bytes each: those of `extras` and of extensions.
void drop_unread_values(Json& value) {
  constexpr std::array<std::string_view, 7> kRead{
      "KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_mesh_gpu_instancing",
      "KHR_texture_transform",      "EXT_texture_webp",        kLevelsExtension};
  if (value.is_object()) {
    value.erase("extras");
    if (const auto extensions = value.find("extensions"); extensions != value.end() && extensions->is_object())
      for (const auto& extension : extensions->items())
        if (std::find(kRead.begin(), kRead.end(), extension.key()) == kRead.end()) extension.value() = Json::object();
  }
  if (value.is_structured())
    for (Json& inner : value) drop_unread_values(inner);
}

/// Rewrites the document for tinygltf: compressed views become views of their coded bytes, fallback buffers one byte that no view needs,
/// and so on.
std::vector<std::uint64_t> rewrite(Json& root, const Screen& screen) {
  for (const MeshoptView& view : screen.meshopt_views()) {
    Json& target = root["bufferViews"][view.view];
    const Json coded = target["extensions"][view.extension];
    target["buffer"] = coded["buffer"];
    target["byteOffset"] = coded.value("byteOffset", std::uint64_t{0});
    target["byteLength"] = coded["byteLength"];
  }
  std::vector<std::uint64_t> buffer_bytes;
  for (std::size_t i = 0; i < screen.buffers().size(); ++i) {
    const ScreenedBuffer& buffer = screen.buffers()[i];
    if (buffer.is_fallback) root["buffers"][i] = {{"byteLength", 1}, {"uri", "data:application/octet-stream;base64,AA=="}};
    buffer_bytes.push_back(buffer.is_fallback ? 1 : buffer.bytes);
  }
  // Coded indices come with the coded attributes, but tinygltf insists that indices have bytes.
  if (const auto meshes = root.find("meshes"); meshes != root.end())
    for (Json& mesh : *meshes)
      if (const auto primitives = mesh.find("primitives"); primitives != mesh.end())
        for (Json& primitive : *primitives)
          if (is_draco_attribute(primitive, "POSITION")) primitive.erase("indices");
  for (const char* name : {"buffers", "images"})
    if (const auto objects = root.find(name); objects != root.end())
      for (Json& object : *objects) normalise_data_uri(object);
  if (const auto materials = root.find("materials"); materials != root.end())
    for (Json& material : *materials) take_specular_glossiness(material);
  for (const char* unread : {"animations", "skins", "cameras", "samplers", "extensions"}) root.erase(unread);
  drop_unread_values(root);
  return buffer_bytes;
}

}  // namespace

Result<ScreenedGltf> screen_gltf(std::string_view json, std::optional<std::uint64_t> bin_chunk_bytes) {
  COPPICE_TRY(root, parse(json));
  if (!root.is_object()) return bad("not a JSON object", "the document");
  Screen screen(root, bin_chunk_bytes);
  COPPICE_CHECK(screen.check());
  ScreenedGltf screened;
  screened.meshopt_views = screen.meshopt_views();
  screened.buffer_bytes = rewrite(root, screen);
  screened.references = find_references(root);
  screened.json = root.dump(-1, ' ', false, Json::error_handler_t::replace);
  return screened;
}

}  // namespace coppice::bake
