#include "gltf_materials.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <tiny_gltf.h>

#include "atomic_file.h"
#include "gltf_accessor.h"
#include "image_decode.h"
#include "image_limits.h"
#include "normal_map.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

// Replaces BLEND: half covered counts as covered.
constexpr float kBlendCutoff = 0.5f;

float clamped(double value, float fallback) {
  if (!std::isfinite(value)) return fallback;
  return static_cast<float>(std::clamp(value, 0.0, 1.0));
}

float alpha_cutoff(const tinygltf::Material& source, std::vector<std::string>& warnings) {
  if (source.alphaMode == "MASK") return clamped(source.alphaCutoff, kBlendCutoff);
  if (source.alphaMode != "BLEND") return 0.0f;
  warnings.push_back("material '" + source.name.substr(0, 64) + "' blends; it is drawn with an alpha mask at 0.5 instead");
  return kBlendCutoff;
}

/// With an image the mask compares base_color.a * texel with the cutoff. This moves the factor into the cutoff, so that readers of the
/// texel alone see the same holes.
void fold_alpha(Material& material, std::vector<std::string>& warnings) {
  if (material.image == kNone || material.alpha_cutoff == 0.0f) return;
  if (material.base_color.a < material.alpha_cutoff)
    warnings.push_back("material '" + material.name.substr(0, 64) + "' is wholly transparent: its base colour's alpha is below the cutoff");
  material.alpha_cutoff = material.base_color.a > 0.0f ? std::min(1.0f, material.alpha_cutoff / material.base_color.a) : 1.0f;
  material.base_color.a = 1.0f;
}

/// Finds the model's image of a texture; kNone if there is none.
std::uint32_t image_of(const tinygltf::Model& model, int texture) {
  if (texture < 0) return kNone;
  const tinygltf::Texture& found = model.textures.at(static_cast<std::size_t>(texture));
  if (const auto webp = found.extensions.find("EXT_texture_webp"); webp != found.extensions.end() && webp->second.Has("source"))
    return static_cast<std::uint32_t>(webp->second.Get("source").GetNumberAsInt());
  return found.source < 0 ? kNone : static_cast<std::uint32_t>(found.source);
}

/// Says why a texture has no image that is read; empty if it has one.
std::string lack_of_image(const tinygltf::Model& model, int texture) {
  if (texture < 0 || image_of(model, texture) != kNone) return {};
  std::string line = "textures[" + std::to_string(texture) + "] has no image";
  for (const auto& [name, value] : model.textures.at(static_cast<std::size_t>(texture)).extensions)
    if (line.size() < 256) line += ", " + (name == "KHR_texture_basisu" ? std::string(kKtxImage) : name.substr(0, 64) + " is not read");
  return line;
}

double number_or(const tinygltf::Value& object, const std::string& name, double fallback) {
  return object.Has(name) ? object.Get(name).GetNumberAsDouble() : fallback;
}

glm::dvec2 pair_or(const tinygltf::Value& object, const std::string& name, double fallback) {
  if (!object.Has(name)) return glm::dvec2(fallback);
  const tinygltf::Value& pair = object.Get(name);
  return {pair.Get(0).GetNumberAsDouble(), pair.Get(1).GetNumberAsDouble()};
}

/// Reads the mapping of a tinygltf::TextureInfo or NormalTextureInfo.
template <class Info>
TextureUvs uvs_of(const Info& info) {
  TextureUvs uvs;
  uvs.set = static_cast<std::uint32_t>(std::max(info.texCoord, 0));
  const auto transform = info.extensions.find("KHR_texture_transform");
  if (transform == info.extensions.end()) return uvs;
  const tinygltf::Value& members = transform->second;
  if (members.Has("texCoord")) uvs.set = static_cast<std::uint32_t>(members.Get("texCoord").GetNumberAsInt());
  const double angle_rad = number_or(members, "rotation", 0.0);
  const glm::dvec2 scale = pair_or(members, "scale", 1.0);
  uvs.is_transformed = true;
  uvs.offset = pair_or(members, "offset", 0.0);
  // The angle is counter-clockwise as one looks at the image, with v pointing down.
  uvs.linear = glm::dmat2(scale.x * std::cos(angle_rad), -scale.x * std::sin(angle_rad), scale.y * std::sin(angle_rad),
                          scale.y * std::cos(angle_rad));
  return uvs;
}

Result<std::vector<std::uint8_t>> read_image_file(const std::string& uri, const std::string& place, const ImageFolder& folder) {
  const auto file = resolve_reference(folder.path, uri, place, folder.outside);
  std::error_code error;
  const bool is_too_large = file && std::filesystem::file_size(*file, error) > kMaxImageFileBytes && !error;
  Result<std::vector<std::uint8_t>> bytes = std::vector<std::uint8_t>();
  if (!is_too_large || folder.on_read) bytes = file ? read_file(*file, kMaxImageFileBytes) : file.error();
  if (folder.on_read) folder.on_read(uri, bytes ? std::span<const std::uint8_t>(*bytes) : std::span<const std::uint8_t>());
  if (is_too_large) return Error{Status::unsupported, "image file over 1 GiB", Error::kNoOffset, place + ": " + uri.substr(0, 256)};
  return bytes;
}

/// What a material uses an image for.
struct ImageUse {
  enum Kind : std::uint8_t { masked_color, color, normals } kind = color;
  float normal_scale = 0.0f;  ///< only for normal maps
  auto operator<=>(const ImageUse&) const = default;
};

/// Reads and decodes an image. ignored_mask  as for decode_image
Result<Image> read_image(const tinygltf::Model& model, std::uint32_t index, ImageUse use, const ImageFolder& folder, bool& ignored_mask) {
  const tinygltf::Image& source = model.images.at(index);
  const std::string place = "images[" + std::to_string(index) + "]";
  std::vector<std::uint8_t> file;
  std::span<const std::uint8_t> bytes = source.image;
  if (source.bufferView >= 0) {
    bytes = view_bytes(model, source.bufferView, 0);
  } else if (!source.uri.empty() && !source.uri.starts_with("data:")) {
    COPPICE_CHECK(move_into(file, read_image_file(source.uri, place + ".uri", folder)));
    bytes = file;
  }
  Result<Image> image = decode_image(bytes, use.kind == ImageUse::normals ? COPPICE_MAX_TEXTURE_SIDE : kMaxImageSide_px,
                                     use.kind == ImageUse::masked_color ? ImageAlpha::mask : ImageAlpha::ignored, &ignored_mask);
  if (image) return image;
  const std::string name = source.uri.empty() ? source.name : source.uri;
  const std::string named = name.empty() ? place : place + " '" + name.substr(0, 64) + "'";
  const Error& error = image.error();
  return Error{error.status, error.what, Error::kNoOffset, error.detail.empty() ? named : named + ": " + error.detail};
}

/// Computes normalize((texel * 2 - 1) * (scale, scale, 1)), as glTF says. Large maps are reduced here, since a decoder would mix texels as
/// if they were colours.
Image normal_map_from(Image image, float scale) {
  image.is_normal_map = true;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const auto texel = std::span<std::uint8_t, 4>(image.rgba.data() + i, 4);
    write_normal(normal_of(texel) * glm::vec3(scale, scale, 1.0f), texel);
  }
  return normal_map_within(std::move(image), kMaxImageSide_px);
}

/// The normal map's scale; 1 if the file's is not above 0.
float normal_scale_of(const tinygltf::Material& source) {
  const auto scale = static_cast<float>(source.normalTexture.scale);
  return std::isfinite(scale) && scale > 0.0f ? scale : 1.0f;
}

/// Returns kNone, with a warning, for a normal map that would need texture coordinates of its own.
std::uint32_t normal_map_of(const tinygltf::Model& model, const tinygltf::Material& source, std::vector<std::string>& warnings) {
  const tinygltf::NormalTextureInfo& info = source.normalTexture;
  const tinygltf::TextureInfo& color = source.pbrMetallicRoughness.baseColorTexture;
  if (std::string line = lack_of_image(model, info.index); !line.empty()) warnings.push_back(std::move(line));
  const std::uint32_t image = image_of(model, info.index);
  if (image == kNone || color.index < 0 || uvs_of(info) == uvs_of(color)) return image;
  warnings.push_back("material '" + source.name.substr(0, 64) +
                     "': its normal map is left out, since its texture coordinates differ from the base colour's");
  return kNone;
}

/// Images in order of first use.
struct ImageTaker {
  const tinygltf::Model& model;
  const ImageFolder& folder;
  std::map<std::pair<std::uint32_t, ImageUse>, std::uint32_t> taken;  ///< by the model's image
  std::vector<Image> images;
  std::multimap<std::size_t, std::uint32_t> by_hash;  ///< images by their texels
  std::set<std::uint32_t> ignored_masks;              ///< the model's images that opaque materials show, and whose alpha looks like a mask
  std::uint64_t bytes = 0;                            ///< of all that were decoded, equal ones too

  /// Returns the image's number in `images`; kNone for kNone.
  Result<std::uint32_t> take(std::uint32_t index, ImageUse use) {
    if (index == kNone) return kNone;
    if (const auto found = taken.find({index, use}); found != taken.end()) return found->second;
    bool ignored_mask = false;
    COPPICE_TRY(image, read_image(model, index, use, folder, ignored_mask));
    if (use.kind == ImageUse::normals) image = normal_map_from(std::move(image), use.normal_scale);
    bytes += image.rgba.size();
    if (bytes / kBytesOfATriangle > folder.max_triangles)
      return Error{Status::unsupported, "more images than are read", Error::kNoOffset,
                   "images[" + std::to_string(index) + "]: " + std::to_string(bytes / kBytesOfATriangle) +
                       " triangles would take as much memory as the images, at most " + std::to_string(folder.max_triangles) +
                       " (--max-source-triangles)"};
    const std::uint32_t number = add(std::move(image));
    taken.emplace(std::pair{index, use}, number);
    if (ignored_mask && use.kind == ImageUse::color) ignored_masks.insert(index);
    return number;
  }

  /// Returns the image's number. An equal image is shared: most images that are taken with and without a mask have no holes.
  std::uint32_t add(Image image) {
    const std::size_t hash = std::hash<std::string_view>()(as_text(image.rgba));
    for (auto [other, end] = by_hash.equal_range(hash); other != end; ++other)
      if (const Image& known = images[other->second];
          known.width == image.width && known.is_normal_map == image.is_normal_map && known.rgba == image.rgba)
        return other->second;
    const auto number = static_cast<std::uint32_t>(images.size());
    by_hash.emplace(hash, number);
    images.push_back(std::move(image));
    return number;
  }
};

/// Warns of a base colour whose texture names no image. errors  unsupported: it names one in a form that is not read
Result<void> check_base_color(const tinygltf::Model& model, std::uint32_t material, std::vector<std::string>& warnings) {
  const int texture = model.materials.at(material).pbrMetallicRoughness.baseColorTexture.index;
  const std::string line = lack_of_image(model, texture);
  if (line.empty()) return {};
  if (!model.textures.at(static_cast<std::size_t>(texture)).extensions.empty())
    return Error{Status::unsupported, "a base colour is not read", Error::kNoOffset, line};
  warnings.push_back(line);
  return {};
}

}  // namespace

Material convert_material(const tinygltf::Model& model, std::uint32_t index, std::vector<std::string>& warnings) {
  Material material;
  if (index == kNone) {
    material.name = "default";
    material.double_sided = false;
    return material;
  }
  const tinygltf::Material& source = model.materials.at(index);
  const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
  material.name = source.name;
  for (int c = 0; c < 4 && pbr.baseColorFactor.size() == 4; ++c)
    material.base_color[c] = clamped(pbr.baseColorFactor[static_cast<std::size_t>(c)], 1.0f);
  material.image = image_of(model, pbr.baseColorTexture.index);
  material.alpha_cutoff = alpha_cutoff(source, warnings);
  fold_alpha(material, warnings);
  material.roughness = clamped(pbr.roughnessFactor, 1.0f);
  material.double_sided = source.doubleSided;
  material.normal_map = normal_map_of(model, source, warnings);
  return material;
}

TextureUvs texture_uvs(const tinygltf::Model& model, std::uint32_t index) {
  if (index == kNone) return {};
  const tinygltf::Material& material = model.materials.at(index);
  const tinygltf::TextureInfo& color = material.pbrMetallicRoughness.baseColorTexture;
  return color.index < 0 ? uvs_of(material.normalTexture) : uvs_of(color);
}

Result<std::vector<Image>> take_images(const tinygltf::Model& model, std::span<const std::uint32_t> sources,
                                       std::vector<Material>& materials, const ImageFolder& folder, std::vector<std::string>& warnings) {
  ImageTaker taker{model, folder, {}, {}, {}, {}, 0};
  std::vector<std::uint32_t> color_images;  // the model's
  for (std::size_t i = 0; i < materials.size(); ++i) {
    Material& material = materials[i];
    color_images.push_back(material.image);
    if (sources[i] != kNone) COPPICE_CHECK(check_base_color(model, sources[i], warnings));
    const ImageUse use{material.alpha_cutoff > 0.0f ? ImageUse::masked_color : ImageUse::color};
    COPPICE_CHECK(move_into(material.image, taker.take(material.image, use)));
    if (material.normal_map == kNone) continue;
    const Result<std::uint32_t> map = taker.take(material.normal_map, {ImageUse::normals, normal_scale_of(model.materials.at(sources[i]))});
    if (!map && (map.error().status == Status::out_of_memory || taker.bytes / kBytesOfATriangle > folder.max_triangles)) return map.error();
    const std::string line = map ? "" : "a normal map is left out: " + map.error().message();
    if (!map && std::ranges::find(warnings, line) == warnings.end()) warnings.push_back(line);
    material.normal_map = map ? *map : kNone;
  }
  for (std::size_t i = 0; i < materials.size(); ++i)
    if (materials[i].alpha_cutoff == 0.0f && taker.ignored_masks.count(color_images[i]) > 0 &&
        taker.taken.count({color_images[i], {ImageUse::masked_color}}) == 0)  // with it, it is an atlas of leaves and of wood
      warnings.push_back("material '" + materials[i].name.substr(0, 64) +
                         "' is opaque, but its image has transparent parts: if they are holes, its alphaMode should be MASK");
  return std::move(taker.images);
}

}  // namespace coppice::bake
