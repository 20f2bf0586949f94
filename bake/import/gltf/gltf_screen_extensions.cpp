#include "gltf_screen_extensions.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "gltf_codes.h"
#include "gltf_draco.h"
#include "gltf_json.h"
#include "image_limits.h"

namespace coppice::bake {
namespace {

using namespace gltf_json;
using Mode = MeshoptView::Mode;
using Filter = MeshoptView::Filter;

/// tinygltf keeps whole numbers in an int; Draco's ids are 32 bits.
constexpr std::uint64_t kMaxId = 0x7fffffff;
constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

template <class Value, std::size_t N>
Result<Value> read_choice(const Json& object, const char* name, const std::string& place,
                          const std::array<std::pair<const char*, Value>, N>& choices) {
  COPPICE_TRY(text, read_text(object, name, place));
  for (const auto& [choice, value] : choices)
    if (text == choice) return value;
  return bad("unknown value", member(place, name) + " is '" + text.substr(0, 32) + "'");
}

Result<Mode> read_mode(const Json& extension, const std::string& place) {
  constexpr std::array<std::pair<const char*, Mode>, 3> kModes{
      {{"ATTRIBUTES", Mode::attributes}, {"TRIANGLES", Mode::triangles}, {"INDICES", Mode::indices}}};
  if (!extension.contains("mode")) return bad("missing member", member(place, "mode"));
  return read_choice(extension, "mode", place, kModes);
}

Result<Filter> read_filter(const Json& extension, const std::string& place) {
  constexpr std::array<std::pair<const char*, Filter>, 5> kFilters{{{"", Filter::none},
                                                                    {"NONE", Filter::none},
                                                                    {"OCTAHEDRAL", Filter::octahedral},
                                                                    {"QUATERNION", Filter::quaternion},
                                                                    {"EXPONENTIAL", Filter::exponential}}};
  COPPICE_TRY(text, read_text(extension, "filter", place));
  if (text == "COLOR")
    return Error{Status::unsupported, "meshopt filter not supported", Error::kNoOffset, member(place, "filter") + " is COLOR"};
  return read_choice(extension, "filter", place, kFilters);
}

/// Checks the extension's rules for the element size.
Result<void> check_meshopt_stride(const MeshoptView& view, const std::string& place) {
  const std::size_t stride = view.stride_bytes;
  const bool fits_mode = view.mode == Mode::attributes ? stride % 4 == 0 && stride >= 4 && stride <= 256 : stride == 2 || stride == 4;
  const std::string detail = member(place, "byteStride") + " is " + std::to_string(stride);
  if (!fits_mode) return bad("stride does not fit the mode", detail);
  if (view.mode != Mode::attributes && view.filter != Filter::none) return bad("indices have no filter", member(place, "filter"));
  if ((view.filter == Filter::octahedral && stride != 4 && stride != 8) || (view.filter == Filter::quaternion && stride != 8))
    return bad("stride does not fit the filter", detail);
  return {};
}

/// Checks where the coded bytes are, and that they can code so much.
Result<void> check_meshopt_bytes(const MeshoptView& view, const Json& extension, const std::string& place,
                                 std::span<const ScreenedBuffer> buffers) {
  COPPICE_TRY(buffer, require_index(extension, "buffer", place, buffers.size()));
  if (buffers[buffer].is_fallback) return bad("compressed data in a fallback buffer", member(place, "buffer"));
  COPPICE_TRY(offset, read_integer(extension, "byteOffset", place, 0));
  COPPICE_TRY(bytes, require_integer(extension, "byteLength", place));
  if (bytes == 0 || offset > buffers[buffer].bytes || bytes > buffers[buffer].bytes - offset)
    return bad("compressed view runs past the end of its buffer", place + ": " + std::to_string(offset) + " + " + std::to_string(bytes) +
                                                                      " of " + std::to_string(buffers[buffer].bytes) + " bytes");
  if (!meshopt_is_plausible(view.mode, view.count, view.stride_bytes, bytes))
    return bad("more elements than so many bytes can code",
               member(place, "count") + " is " + std::to_string(view.count) + " in " + std::to_string(bytes) + " bytes");
  return {};
}

constexpr std::array<std::string_view, 18> kKnownExtensions{"KHR_mesh_quantization",
                                                            "KHR_draco_mesh_compression",
                                                            "EXT_meshopt_compression",
                                                            "KHR_meshopt_compression",
                                                            "EXT_mesh_gpu_instancing",
                                                            kLevelsExtension,
                                                            "KHR_texture_transform",
                                                            "EXT_texture_webp",
                                                            "KHR_texture_basisu",
                                                            "KHR_materials_pbrSpecularGlossiness",
                                                            "KHR_materials_variants",
                                                            "KHR_materials_unlit",
                                                            "KHR_materials_emissive_strength",
                                                            "KHR_materials_diffuse_transmission",
                                                            "KHR_materials_transmission",
                                                            "KHR_materials_*",
                                                            "KHR_lights_punctual",
                                                            "KHR_xmp_json_ld"};

}  // namespace

std::span<const std::string_view> known_extensions() {
  return kKnownExtensions;
}

bool is_supported_extension(std::string_view name) {
  return std::ranges::any_of(kKnownExtensions, [&](std::string_view known) {
    return known.ends_with('*') ? name.starts_with(known.substr(0, known.size() - 1)) : name == known;
  });
}

Result<void> check_draco(const Json& primitive, const std::string& place, std::size_t view_count) {
  COPPICE_TRY(extension, find_extension(primitive, kDracoExtension, place));
  if (extension == nullptr) return {};
  const std::string where = extension_place(place, kDracoExtension);
  const auto mode = primitive.value("mode", std::uint64_t{gltf_code::kTriangles});
  if (mode != gltf_code::kTriangles && mode != gltf_code::kTriangleStrip)
    return bad("compressed primitive of neither triangles nor strips", member(place, "mode"));
  COPPICE_CHECK(require_index(*extension, "bufferView", where, view_count));
  COPPICE_TRY(attributes, find_object(*extension, "attributes", where));
  if (attributes == nullptr || !attributes->contains("POSITION")) return bad("missing member", member(where, "attributes.POSITION"));
  const std::string attributes_place = member(where, "attributes");
  for (const auto& attribute : attributes->items()) {
    const std::string name = attribute.key().substr(0, 64);
    COPPICE_TRY(id, require_integer(*attributes, attribute.key().c_str(), attributes_place));
    if (id > kMaxId) return bad("Draco attribute id out of range", member(attributes_place, name.c_str()));
    if (!primitive["attributes"].contains(attribute.key()))
      return bad("compressed attribute that the primitive does not have", member(attributes_place, name.c_str()));
  }
  return {};
}

bool is_draco_attribute(const Json& primitive, const std::string& name) {
  const auto extensions = primitive.find("extensions");
  if (extensions == primitive.end()) return false;
  const auto draco = extensions->find(kDracoExtension);
  return draco != extensions->end() && (*draco)["attributes"].contains(name);
}

Result<std::optional<MeshoptView>> read_meshopt(const Json& view, const std::string& place, std::size_t index,
                                                std::span<const ScreenedBuffer> buffers) {
  for (const char* name : kMeshoptExtensions) {
    COPPICE_TRY(extension, find_extension(view, name, place));
    if (extension == nullptr) continue;
    const std::string where = extension_place(place, name);
    MeshoptView result;
    result.view = index;
    result.extension = name;
    COPPICE_TRY(mode, read_mode(*extension, where));
    COPPICE_TRY(filter, read_filter(*extension, where));
    COPPICE_TRY(count, require_integer(*extension, "count", where));
    COPPICE_TRY(stride, require_integer(*extension, "byteStride", where));
    result.mode = mode;
    result.filter = filter;
    result.count = count;
    result.stride_bytes = stride;
    COPPICE_CHECK(check_meshopt_stride(result, where));
    if (count == 0 || (mode == Mode::triangles && count % 3 != 0))
      return bad("count is no number of triangles or elements", member(where, "count") + " is " + std::to_string(count));
    COPPICE_CHECK(check_meshopt_bytes(result, *extension, where, buffers));
    COPPICE_TRY(parent_stride, read_integer(view, "byteStride", place, stride));
    if (parent_stride != stride) return bad("stride differs from that of the extension", member(place, "byteStride"));
    COPPICE_TRY(parent_bytes, require_integer(view, "byteLength", place));
    if (count > std::numeric_limits<std::uint64_t>::max() / stride || parent_bytes != count * stride)
      return bad("length is not count times stride of the extension", member(place, "byteLength") + " is " + std::to_string(parent_bytes) +
                                                                          ", " + std::to_string(count) + " times " +
                                                                          std::to_string(stride));
    return std::optional(result);
  }
  return std::optional<MeshoptView>();
}

Result<void> check_texture_transform(const Json& texture_info, const std::string& place) {
  constexpr const char* kName = "KHR_texture_transform";
  COPPICE_TRY(extension, find_extension(texture_info, kName, place));
  if (extension == nullptr) return {};
  const std::string where = extension_place(place, kName);
  COPPICE_CHECK(check_numbers(*extension, "offset", where, 2));
  COPPICE_CHECK(check_numbers(*extension, "scale", where, 2));
  const auto rotation = extension->find("rotation");
  if (rotation != extension->end() && !rotation->is_number()) return bad("not a number", member(where, "rotation"));
  COPPICE_TRY(set, read_integer(*extension, "texCoord", where, 0));
  return set <= kMaxId ? Result<void>() : bad("index out of range", member(where, "texCoord"));
}

Result<void> check_webp(const Json& texture, const std::string& place, std::size_t image_count) {
  constexpr const char* kName = "EXT_texture_webp";
  COPPICE_TRY(extension, find_extension(texture, kName, place));
  if (extension == nullptr) return {};
  return check_index(*extension, "source", extension_place(place, kName), image_count);
}

Result<void> check_basisu_fallback(const Json& texture, const std::string& place) {
  COPPICE_TRY(basisu, find_extension(texture, "KHR_texture_basisu", place));
  COPPICE_TRY(webp, find_extension(texture, "EXT_texture_webp", place));
  if (basisu == nullptr || webp != nullptr || texture.contains("source")) return {};
  return Error{Status::unsupported, kKtxImage, Error::kNoOffset, extension_place(place, "KHR_texture_basisu")};
}

Result<void> check_specular_glossiness(const Json& material, const std::string& place, std::size_t texture_count) {
  COPPICE_TRY(extension, find_extension(material, kSpecularGlossiness, place));
  if (extension == nullptr) return {};
  const std::string where = extension_place(place, kSpecularGlossiness);
  COPPICE_CHECK(check_numbers(*extension, "diffuseFactor", where, 4));
  const auto glossiness = extension->find("glossinessFactor");
  if (glossiness != extension->end() && !glossiness->is_number()) return bad("not a number", member(where, "glossinessFactor"));
  COPPICE_TRY(texture, find_object(*extension, "diffuseTexture", where));
  if (texture == nullptr) return {};
  COPPICE_CHECK(check_index(*texture, "index", member(where, "diffuseTexture"), texture_count));
  return check_texture_transform(*texture, member(where, "diffuseTexture"));
}

void take_specular_glossiness(Json& material) {
  const auto extensions = material.find("extensions");
  if (extensions == material.end() || !extensions->contains(kSpecularGlossiness)) return;
  const Json& extension = (*extensions)[kSpecularGlossiness];
  Json pbr = {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0 - extension.value("glossinessFactor", 1.0)}};
  if (extension.contains("diffuseFactor")) pbr["baseColorFactor"] = extension["diffuseFactor"];
  if (extension.contains("diffuseTexture")) pbr["baseColorTexture"] = extension["diffuseTexture"];
  material["pbrMetallicRoughness"] = std::move(pbr);
}

Result<void> check_instancing(const Json& node, const std::string& place, std::span<const std::uint64_t> counts) {
  constexpr const char* kName = "EXT_mesh_gpu_instancing";
  COPPICE_TRY(extension, find_extension(node, kName, place));
  if (extension == nullptr) return {};
  const std::string where = extension_place(place, kName);
  COPPICE_TRY(attributes, find_object(*extension, "attributes", where));
  if (attributes == nullptr || attributes->empty()) return bad("missing member", member(where, "attributes"));
  std::string first_name;
  std::uint64_t first_count = 0;
  for (const auto& attribute : attributes->items()) {
    const std::string attributes_place = member(where, "attributes");
    COPPICE_TRY(accessor, require_index(*attributes, attribute.key().c_str(), attributes_place, counts.size()));
    const std::string name = attribute.key().substr(0, 64);
    if (first_name.empty()) {
      first_name = name;
      first_count = counts[accessor];
    }
    if (counts[accessor] == first_count) continue;
    std::string detail = attributes_place;
    detail.append(": ").append(name).append(" has ").append(std::to_string(counts[accessor]));
    detail.append(", ").append(first_name).append(" ").append(std::to_string(first_count));
    return bad("instance attributes of unequal length", detail);
  }
  return {};
}

}  // namespace coppice::bake
