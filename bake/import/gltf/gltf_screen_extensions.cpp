#include "gltf_screen_extensions.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "gltf_codes.h"
#include "gltf_draco.h"
#include "image_limits.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::json;
using Mode = MeshoptView::Mode;
using Filter = MeshoptView::Filter;

/// tinygltf keeps whole numbers in an int; Draco's ids are 32 bits.
constexpr std::uint64_t kMaxId = 0x7fffffff;

template <class Value, std::size_t N>
Result<Value> read_choice(const JsonObject& object, const char* name, const std::array<std::pair<const char*, Value>, N>& choices) {
  COPPICE_TRY(text, object.text(name));
  for (const auto& [choice, value] : choices)
    if (text == choice) return value;
  return object.bad("unknown value", name, " is '" + text.substr(0, 32) + "'");
}

Result<Mode> read_mode(const JsonObject& extension) {
  constexpr std::array<std::pair<const char*, Mode>, 3> kModes{
      {{"ATTRIBUTES", Mode::attributes}, {"TRIANGLES", Mode::triangles}, {"INDICES", Mode::indices}}};
  return extension.has("mode") ? read_choice(extension, "mode", kModes) : extension.bad("missing member", "mode");
}

Result<Filter> read_filter(const JsonObject& extension) {
  constexpr std::array<std::pair<const char*, Filter>, 5> kFilters{{{"", Filter::none},
                                                                    {"NONE", Filter::none},
                                                                    {"OCTAHEDRAL", Filter::octahedral},
                                                                    {"QUATERNION", Filter::quaternion},
                                                                    {"EXPONENTIAL", Filter::exponential}}};
  COPPICE_TRY(text, extension.text("filter"));
  if (text == "COLOR")
    return Error{Status::unsupported, "meshopt filter not supported", Error::kNoOffset, extension.place("filter") + " is COLOR"};
  return read_choice(extension, "filter", kFilters);
}

/// Checks the extension's rules for the element size.
Result<void> check_meshopt_stride(const MeshoptView& view, const JsonObject& extension) {
  const std::size_t stride = view.stride_bytes;
  const bool fits_mode = view.mode == Mode::attributes ? stride % 4 == 0 && stride >= 4 && stride <= 256 : stride == 2 || stride == 4;
  const std::string more = " is " + std::to_string(stride);
  if (!fits_mode) return extension.bad("stride does not fit the mode", "byteStride", more);
  if (view.mode != Mode::attributes && view.filter != Filter::none) return extension.bad("indices have no filter", "filter");
  if ((view.filter == Filter::octahedral && stride != 4 && stride != 8) || (view.filter == Filter::quaternion && stride != 8))
    return extension.bad("stride does not fit the filter", "byteStride", more);
  return {};
}

/// Checks where the coded bytes are, and that they can code so much.
Result<void> check_meshopt_bytes(const MeshoptView& view, const JsonObject& extension, std::span<const ScreenedBuffer> buffers) {
  COPPICE_TRY(buffer, extension.index("buffer", buffers.size()));
  if (buffers[buffer].is_fallback) return extension.bad("compressed data in a fallback buffer", "buffer");
  COPPICE_TRY(offset, extension.integer("byteOffset", 0));
  COPPICE_TRY(bytes, extension.integer("byteLength"));
  if (bytes == 0 || offset > buffers[buffer].bytes || bytes > buffers[buffer].bytes - offset)
    return extension.bad(
        "compressed view runs past the end of its buffer", "",
        ": " + std::to_string(offset) + " + " + std::to_string(bytes) + " of " + std::to_string(buffers[buffer].bytes) + " bytes");
  if (meshopt_is_plausible(view.mode, view.count, view.stride_bytes, bytes)) return {};
  return extension.bad("more elements than so many bytes can code", "count",
                       " is " + std::to_string(view.count) + " in " + std::to_string(bytes) + " bytes");
}

Result<MeshoptView> read_meshopt(const JsonObject& extension, std::span<const ScreenedBuffer> buffers) {
  MeshoptView view;
  COPPICE_CHECK(move_into(view.mode, read_mode(extension)));
  COPPICE_CHECK(move_into(view.filter, read_filter(extension)));
  COPPICE_CHECK(move_into(view.count, extension.integer("count")));
  COPPICE_CHECK(move_into(view.stride_bytes, extension.integer("byteStride")));
  COPPICE_CHECK(check_meshopt_stride(view, extension));
  if (view.count == 0 || (view.mode == Mode::triangles && view.count % 3 != 0))
    return extension.bad("count is no number of triangles or elements", "count", " is " + std::to_string(view.count));
  COPPICE_CHECK(check_meshopt_bytes(view, extension, buffers));
  return view;
}

}  // namespace

bool is_supported_extension(std::string_view name) {
  return std::ranges::any_of(kKnownExtensions, [&](std::string_view known) {
    return known.ends_with('*') ? name.starts_with(known.substr(0, known.size() - 1)) : name == known;
  });
}

Result<void> check_draco(const JsonObject& primitive, std::size_t view_count) {
  COPPICE_TRY(extension, primitive.extension(kDracoExtension));
  if (!extension) return {};
  COPPICE_TRY(mode, primitive.integer("mode", gltf_code::kTriangles));
  if (mode != gltf_code::kTriangles && mode != gltf_code::kTriangleStrip)
    return primitive.bad("compressed primitive of neither triangles nor strips", "mode");
  COPPICE_CHECK(extension->index("bufferView", view_count));
  COPPICE_TRY(attributes, extension->object("attributes"));
  if (!attributes || !attributes->has("POSITION")) return extension->bad("missing member", "attributes.POSITION");
  return attributes->for_each_name([&](const std::string& name) -> Result<void> {
    COPPICE_TRY(id, attributes->integer(name));
    if (id > kMaxId) return attributes->bad("Draco attribute id out of range", name.substr(0, 64));
    if (primitive.json()["attributes"].contains(name)) return {};
    return attributes->bad("compressed attribute that the primitive does not have", name.substr(0, 64));
  });
}

bool is_draco_attribute(const JsonObject& primitive, const std::string& name) {
  const auto extension = primitive.extension(kDracoExtension);
  return extension && *extension && (**extension).json()["attributes"].contains(name);
}

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
      return view.bad("length is not count times stride of the extension", "byteLength",
                      " is " + std::to_string(view_bytes) + ", " + std::to_string(result.count) + " times " +
                          std::to_string(result.stride_bytes));
    const Json& coded = extension->json();
    view.json().update(
        {{"buffer", coded["buffer"]}, {"byteOffset", coded.value("byteOffset", std::uint64_t{0})}, {"byteLength", coded["byteLength"]}});
    return std::optional(result);
  }
  return std::optional<MeshoptView>();
}

Result<void> check_texture_transform(const JsonObject& texture_info) {
  COPPICE_TRY(transform, texture_info.extension("KHR_texture_transform"));
  if (!transform) return {};
  COPPICE_CHECK(transform->check_numbers("offset", 2));
  COPPICE_CHECK(transform->check_numbers("scale", 2));
  COPPICE_CHECK(transform->check_number("rotation"));
  COPPICE_TRY(set, transform->integer("texCoord", 0));
  return set <= kMaxId ? Result<void>() : transform->bad("index out of range", "texCoord");
}

Result<void> check_webp(const JsonObject& texture, std::size_t image_count) {
  COPPICE_TRY(webp, texture.extension("EXT_texture_webp"));
  return webp ? webp->check_index("source", image_count) : Result<void>();
}

Result<void> check_basisu_fallback(const JsonObject& texture) {
  COPPICE_TRY(basisu, texture.extension("KHR_texture_basisu"));
  COPPICE_TRY(webp, texture.extension("EXT_texture_webp"));
  if (!basisu || webp || texture.has("source")) return {};
  return Error{Status::unsupported, kKtxImage, Error::kNoOffset, basisu->place()};
}

Result<void> take_specular_glossiness(const JsonObject& material, std::size_t texture_count) {
  COPPICE_TRY(extension, material.extension("KHR_materials_pbrSpecularGlossiness"));
  if (!extension) return {};
  COPPICE_CHECK(extension->check_numbers("diffuseFactor", 4));
  COPPICE_CHECK(extension->check_number("glossinessFactor"));
  COPPICE_TRY(texture, extension->object("diffuseTexture"));
  if (texture) {
    COPPICE_CHECK(texture->check_index("index", texture_count));
    COPPICE_CHECK(check_texture_transform(*texture));
  }
  Json pbr = {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0 - extension->json().value("glossinessFactor", 1.0)}};
  if (extension->has("diffuseFactor")) pbr["baseColorFactor"] = extension->json()["diffuseFactor"];
  if (texture) pbr["baseColorTexture"] = texture->json();
  material.json()["pbrMetallicRoughness"] = std::move(pbr);
  return {};
}

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
    return attributes->bad("instance attributes of unequal length", "",
                           ": " + name.substr(0, 64) + " has " + std::to_string(counts[accessor]) + ", " + first_name + " " +
                               std::to_string(first_count));
  });
}

}  // namespace coppice::bake
