#include "gltf_document.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <tiny_gltf.h>

#include "atomic_file.h"
#include "gltf_compression.h"
#include "gltf_pose.h"
#include "gltf_screen.h"
#include "image_limits.h"
#include "text_bytes.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

// One process looks at all plants: what is hostile shall not fill its memory.
constexpr std::uint64_t kMostOutlinedBytes = std::uint64_t{32} << 20;
constexpr std::size_t kGlbHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::uint32_t kJsonChunk = 0x4e4f534a, kBinChunk = 0x004e4942;

Error damaged(const char* what, std::uint64_t offset = Error::kNoOffset) {
  return Error{Status::bad_file, what, offset};
}

/// The two parts of a glTF, whichever file they came from.
struct Parts {
  std::string_view json;
  std::optional<std::span<const std::uint8_t>> bin;
};

std::uint32_t read_u32(std::span<const std::uint8_t> bytes, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

Result<Parts> split_glb(std::span<const std::uint8_t> file) {
  if (file.size() < kGlbHeaderBytes + kChunkHeaderBytes) return damaged("truncated GLB: shorter than its header", file.size());
  if (read_u32(file, 4) != 2) return Error{Status::unsupported, "GLB version other than 2", 4};
  const std::uint32_t length = read_u32(file, 8);
  if (length > file.size())
    return Error{Status::bad_file, "truncated GLB: its header promises more bytes", 8,
                 formatted("%u promised, %zu there", length, file.size())};
  file = file.first(length);
  if (file.size() < kGlbHeaderBytes + kChunkHeaderBytes) return damaged("GLB length shorter than its header", 8);
  Parts parts;
  std::size_t at = kGlbHeaderBytes;
  for (int chunk = 0; chunk < 2 && file.size() - at >= kChunkHeaderBytes; ++chunk) {
    const std::uint32_t bytes = read_u32(file, at);
    const std::uint32_t type = read_u32(file, at + 4);
    if (bytes > file.size() - at - kChunkHeaderBytes) return damaged("GLB chunk runs past the end of the file", at);
    const auto content = file.subspan(at + kChunkHeaderBytes, bytes);
    if (chunk == 0 && type != kJsonChunk) return damaged("the first GLB chunk is not JSON", at + 4);
    if (chunk == 0) parts.json = as_text(content);
    if (chunk == 1 && type == kBinChunk && bytes > 0) parts.bin = content;
    at += kChunkHeaderBytes + bytes;
  }
  return parts;
}

Result<Parts> split(std::span<const std::uint8_t> file) {
  if (file.empty()) return damaged("the file is empty");
  const std::string_view text = as_text(file);
  if (text.starts_with("glTF")) return split_glb(file);
  if (text.starts_with(kGitLfsPointer)) return damaged(kIsGitLfsPointer);
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  Parts parts;
  parts.json = text.substr(text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
  const std::size_t first = parts.json.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || parts.json[first] != '{') return damaged("not a glTF: neither a GLB header nor a JSON object");
  return parts;
}

/// What is loaded, which files that may take, and who hears of them.
struct Source {
  Parts parts;
  std::filesystem::path folder;
  OutsideFiles outside;
  const ReadObserver& on_read;
};

/// The base64 text of a data URI; nothing for any other URI.
std::optional<std::string_view> base64_of(std::string_view uri) {
  constexpr std::string_view kMark = ";base64,";
  constexpr std::size_t kMaxHeaderChars = 128;
  const std::size_t mark = uri.find(kMark);
  if (!uri.starts_with("data:") || mark > kMaxHeaderChars) return {};
  return uri.substr(mark + kMark.size());
}

/// Empty if the text is not base64.
std::vector<std::uint8_t> decoded(std::string_view base64) {
  std::vector<std::uint8_t> bytes;
  // tinygltf knows few media types. The bytes say what they are.
  std::string media_type;
  tinygltf::DecodeDataURI(&bytes, media_type, "data:application/octet-stream;base64," + std::string(base64), 0, false);
  return bytes;
}

Result<std::vector<std::uint8_t>> load_buffer(const ScreenedBuffer& buffer, const std::string& place, const Source& source) {
  if (buffer.is_fallback) return std::vector<std::uint8_t>();
  if (!buffer.uri) {
    const auto chunk = source.parts.bin->first(buffer.bytes);
    return std::vector<std::uint8_t>(chunk.begin(), chunk.end());
  }
  const auto cannot_load = [&](const std::string& why) {
    return Error{Status::io, "cannot load a buffer", Error::kNoOffset, place + ": " + why};
  };
  std::vector<std::uint8_t> bytes;
  if (buffer.uri->starts_with("data:")) {
    bytes = decoded(base64_of(*buffer.uri).value_or(""));
    if (bytes.empty()) return cannot_load("not base64");
  } else {
    COPPICE_TRY(path, resolve_reference(source.folder, *buffer.uri, place, source.outside));
    auto file = read_file(path, buffer.bytes);  // it may be longer
    if (!file) return cannot_load(file.error().message());
    bytes = *std::move(file);
    if (source.on_read) source.on_read(*buffer.uri, bytes);
  }
  if (as_text(bytes).starts_with(kGitLfsPointer)) return cannot_load(kIsGitLfsPointer);
  if (bytes.size() == buffer.bytes) return bytes;
  return cannot_load(std::to_string(bytes.size()) + " bytes instead of " + std::to_string(buffer.bytes));
}

/// Files of images are read when they are used, but no file outside the folder may be named.
Result<tinygltf::Image> make_image(const ScreenedImage& screened, const std::string& place, const Source& source) {
  tinygltf::Image image;
  image.name = screened.name;
  image.bufferView = screened.view;
  if (screened.view >= 0) return image;
  if (const auto base64 = base64_of(screened.uri)) {
    image.image = decoded(*base64);
    if (image.image.empty()) return Error{Status::bad_file, "not base64", Error::kNoOffset, place};
    return image;
  }
  image.uri = screened.uri;
  if (image.uri.starts_with("data:")) return image;
  const auto file = resolve_reference(source.folder, image.uri, place, source.outside);
  // A missing image is an error only where it is used.
  if (!file && file.error().status != Status::io) return file.error();
  return image;
}

Result<void> parse(const std::string& json, tinygltf::Model& model) {
  if (json.size() > kMaxGltfBytes) return damaged("JSON over 4 GiB");
  std::string message, warning;
  try {
    if (tinygltf::TinyGLTF().LoadASCIIFromString(&model, &message, &warning, json.data(), static_cast<unsigned>(json.size()), ""))
      return {};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    message = error.what();
  }
  constexpr std::size_t kMaxChars = 160;
  return Error{Status::bad_file, "not a glTF that tinygltf can read", Error::kNoOffset,
               message.substr(0, std::min(message.find('\n'), kMaxChars))};
}

Result<ModelPointer> load_screened(const ScreenedGltf& screened, const Source& source) {
  ModelPointer model(new tinygltf::Model);
  COPPICE_CHECK(parse(screened.json, *model));
  for (std::size_t i = 0; i < screened.buffers.size(); ++i)
    COPPICE_CHECK(
        move_into(model->buffers.emplace_back().data, load_buffer(screened.buffers[i], "buffers[" + std::to_string(i) + "].uri", source)));
  for (std::size_t i = 0; i < screened.images.size(); ++i) {
    COPPICE_TRY(image, make_image(screened.images[i], "images[" + std::to_string(i) + "].uri", source));
    model->images.push_back(std::move(image));
  }
  COPPICE_CHECK(decode_meshopt_views(*model, screened.meshopt_views));
  COPPICE_CHECK(decode_draco_primitives(*model));
  // No more is known of animations than that there are any.
  if (screened.has_animations) model->animations.emplace_back();
  COPPICE_CHECK(apply_rest_pose(*model));
  return model;
}

/// Formats that Blender reads, with the operator that does it.
constexpr std::pair<std::string_view, std::string_view> kOtherFormats[] = {
    {".obj", "wm.obj_import"},     {".fbx", "import_scene.fbx"},  {".usd", "wm.usd_import"},
    {".usda", "wm.usd_import"},    {".usdc", "wm.usd_import"},    {".usdz", "wm.usd_import"},
    {".dae", "wm.collada_import"}, {".abc", "wm.alembic_import"}, {".blend", "wm.open_mainfile"}};

}  // namespace

std::string conversion_advice(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const auto& [name, operation] : kOtherFormats)
    if (extension == name)
      return "convert with: blender --background --factory-startup --python-expr \"import bpy; bpy.ops.wm.read_homefile(use_empty=True); "
             "bpy.ops." +
             std::string(operation) + "(filepath='" + path.filename().string() + "'); bpy.ops.export_scene.gltf(filepath='" +
             path.stem().string() + ".glb')\"";
  return {};
}

void DeleteModel::operator()(tinygltf::Model* model) const {
  delete model;
}

Result<GltfOutline> outline_gltf(const std::filesystem::path& path, std::uint64_t max_source_triangles) {
  COPPICE_TRY(bytes, read_gltf_text(path, kMostOutlinedBytes));
  const CostLimit limit{max_source_triangles > 0 ? max_source_triangles : kMaxSourceTriangles};
  COPPICE_TRY(screened, screen_gltf(gltf_text(bytes), kMaxGltfBytes, limit));
  GltfOutline outline{screened.triangles, std::move(screened.references), {}};
  for (const GltfReference& reference : outline.references) outline.files.push_back(named_file(path.parent_path(), reference.uri));
  return outline;
}

std::vector<std::filesystem::path> files_of_gltf(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> files{path};
  if (const auto outline = outline_gltf(path)) files.insert(files.end(), outline->files.begin(), outline->files.end());
  return files;
}

Result<ModelPointer> load_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& folder, OutsideFiles outside,
                                     const CostLimit& limit, const ReadObserver& on_read) {
  COPPICE_TRY(parts, split(file));
  std::optional<std::uint64_t> bin_bytes;
  if (parts.bin) bin_bytes = parts.bin->size();
  COPPICE_TRY(screened, screen_gltf(parts.json, bin_bytes, limit));
  return load_screened(screened, {parts, folder.empty() ? "." : folder, outside, on_read});
}

Result<ModelPointer> load_gltf(const std::filesystem::path& path, OutsideFiles outside, const CostLimit& limit,
                               const ReadObserver& on_read) {
  std::error_code error;
  if (const auto bytes = std::filesystem::file_size(path, error); !error && bytes > kMaxGltfBytes)
    return Error{Status::unsupported, "a glTF over 4 GiB", Error::kNoOffset, std::to_string(bytes) + " bytes"};
  COPPICE_TRY(file, read_file(path));
  if (const std::string how = conversion_advice(path); !how.empty())
    return Error{Status::unsupported, "not a glTF", Error::kNoOffset, path.string() + ": " + how};
  if (on_read) on_read({}, file);
  return load_gltf_bytes(file, path.parent_path(), outside, limit, on_read);
}

}  // namespace coppice::bake
