#include "gltf_document.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <tiny_gltf.h>

#include "atomic_file.h"
#include "gltf_codes.h"
#include "gltf_draco.h"
#include "gltf_meshopt.h"
#include "gltf_screen.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kGlbHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;
constexpr std::uint32_t kBinChunk = 0x004e4942;

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
  if (length > file.size()) {
    Error error = damaged("truncated GLB: its header promises more bytes", 8);
    error.detail = std::to_string(length) + " promised, " + std::to_string(file.size()) + " there";
    return error;
  }
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
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  Parts parts;
  parts.json = text.substr(text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0);
  const std::size_t first = parts.json.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || parts.json[first] != '{') return damaged("not a glTF: neither a GLB header nor a JSON object");
  return parts;
}

void append_u32(std::vector<std::uint8_t>& bytes, std::size_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

void append_chunk(std::vector<std::uint8_t>& glb, std::uint32_t type, std::span<const std::uint8_t> content, std::uint8_t padding) {
  const std::size_t padded_bytes = (content.size() + 3) / 4 * 4;
  append_u32(glb, padded_bytes);
  append_u32(glb, type);
  glb.insert(glb.end(), content.begin(), content.end());
  glb.resize(glb.size() + padded_bytes - content.size(), padding);
}

/// Builds a .glb round the screened JSON, with sizes that tinygltf accepts.
std::vector<std::uint8_t> assemble_glb(std::string_view json, std::span<const std::uint8_t> bin) {
  std::vector<std::uint8_t> glb;
  glb.reserve(kGlbHeaderBytes + 2 * kChunkHeaderBytes + json.size() + bin.size() + 8);
  for (const char c : std::string_view("glTF")) glb.push_back(static_cast<std::uint8_t>(c));
  append_u32(glb, 2);
  append_u32(glb, 0);
  append_chunk(glb, kJsonChunk, bytes_of(json), ' ');
  append_chunk(glb, kBinChunk, bin, 0);
  const auto length = static_cast<std::uint32_t>(glb.size());
  std::memcpy(glb.data() + 8, &length, sizeof length);
  return glb;
}

/// What the file callbacks know about the load in progress.
struct LoadState {
  std::vector<std::filesystem::path> buffer_files;  ///< empty paths for buffers that are in the document
  const tinygltf::Model* model = nullptr;
  const std::vector<std::uint64_t>* buffer_bytes = nullptr;

  /// Index of the buffer that is being loaded: tinygltf loads buffers first and in order.
  [[nodiscard]] std::size_t next_buffer() const { return model->buffers.size(); }
};

/// tinygltf looks for a file under several names. find_files knows the right one, so any name will do. Images are read when they are used.
bool is_buffer_file(const std::string&, void* user) {
  const auto& state = *static_cast<const LoadState*>(user);
  return state.next_buffer() < state.buffer_files.size();
}

std::string keep_name(const std::string& name, void*) {
  return name;
}

/// A file may be longer than its buffer, but tinygltf insists on equality.
bool read_buffer(std::vector<unsigned char>* bytes, std::string* error, const std::string&, void* user) {
  const auto& state = *static_cast<const LoadState*>(user);
  Result<std::vector<std::uint8_t>> file = read_file(state.buffer_files[state.next_buffer()], (*state.buffer_bytes)[state.next_buffer()]);
  if (!file) {
    *error = file.error().message();
    return false;
  }
  *bytes = *std::move(file);
  return true;
}

// tinygltf dictates the parameters.
// NOLINTNEXTLINE(readability-function-size)
bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes, int size, void*) {
  // Bytes that are in a buffer stay there: any number of images may share a view.
  if (image->bufferView < 0) image->image.assign(bytes, bytes + std::max(size, 0));
  image->as_is = true;
  return true;
}

/// Takes one line: tinygltf's messages have several and may quote a whole data URI.
std::string first_line(const std::string& text) {
  constexpr std::size_t kMaxChars = 160;
  return text.substr(0, std::min(text.find('\n'), kMaxChars));
}

/// Names what could not be loaded: tinygltf stops at the first such buffer, then at the first such image.
Error load_error(const tinygltf::Model& model, const ScreenedGltf& screened, const std::string& message) {
  const std::size_t buffer = model.buffers.size();
  if (buffer < screened.buffer_bytes.size())
    return Error{Status::io, "cannot load a buffer", Error::kNoOffset,
                 "buffers[" + std::to_string(buffer) + "].uri: " + first_line(message)};
  const std::size_t image = model.images.size();
  if (message.starts_with("Failed to decode 'uri' for image"))
    return Error{Status::bad_file, "not base64", Error::kNoOffset, "images[" + std::to_string(image) + "].uri"};
  return Error{Status::bad_file, "not a glTF that tinygltf can read", Error::kNoOffset, first_line(message)};
}

/// Finds the files of the buffers, and checks those of images.
Result<std::vector<std::filesystem::path>> find_files(const ScreenedGltf& screened, const std::filesystem::path& folder,
                                                      OutsideFiles outside) {
  std::vector<std::filesystem::path> buffer_files(screened.buffer_bytes.size());
  for (const GltfReference& reference : screened.references) {
    const std::string place = reference.place();
    const auto file = resolve_reference(folder, reference.uri, place, outside);
    // A missing image is an error only where it is used.
    if (!file && (reference.is_buffer || file.error().status != Status::io)) return file.error();
    if (reference.is_buffer) buffer_files[reference.index] = *file;
  }
  return buffer_files;
}

Result<ModelPointer> parse(const Parts& parts, const ScreenedGltf& screened, const std::filesystem::path& folder, OutsideFiles outside) {
  ModelPointer model(new tinygltf::Model);
  COPPICE_TRY(buffer_files, find_files(screened, folder, outside));
  LoadState state{std::move(buffer_files), model.get(), &screened.buffer_bytes};
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(keep_encoded, nullptr);
  loader.SetFsCallbacks({is_buffer_file, keep_name, read_buffer, nullptr, &state});
  std::string message, warning;
  bool loaded = false;
  try {
    if (parts.bin) {
      const std::vector<std::uint8_t> glb = assemble_glb(screened.json, *parts.bin);
      if (glb.size() > gltf_code::kMaxFileBytes) return damaged("GLB over 4 GiB");
      loaded = loader.LoadBinaryFromMemory(model.get(), &message, &warning, glb.data(), static_cast<unsigned>(glb.size()), folder.string());
    } else {
      if (screened.json.size() > gltf_code::kMaxFileBytes) return damaged("JSON over 4 GiB");
      loaded = loader.LoadASCIIFromString(model.get(), &message, &warning, screened.json.data(),
                                          static_cast<unsigned>(screened.json.size()), folder.string());
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    message = error.what();
  }
  if (!loaded) return load_error(*model, screened, message);
  for (std::size_t i = 0; i < screened.buffer_bytes.size(); ++i)
    if (model->buffers.at(i).data.size() < screened.buffer_bytes[i]) return damaged("buffer shorter than its byteLength");
  return model;
}

/// Formats that Blender reads, with the operator that does it.
struct OtherFormat {
  std::string_view extension, import;
};
constexpr std::array<OtherFormat, 9> kOtherFormats{{{".obj", "wm.obj_import"},
                                                    {".fbx", "import_scene.fbx"},
                                                    {".usd", "wm.usd_import"},
                                                    {".usda", "wm.usd_import"},
                                                    {".usdc", "wm.usd_import"},
                                                    {".usdz", "wm.usd_import"},
                                                    {".dae", "wm.collada_import"},
                                                    {".abc", "wm.alembic_import"},
                                                    {".blend", "wm.open_mainfile"}}};

}  // namespace

std::string conversion_advice(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const OtherFormat& format : kOtherFormats)
    if (extension == format.extension)
      return "convert with: blender --background --factory-startup --python-expr \"import bpy; bpy.ops.wm.read_homefile(use_empty=True); "
             "bpy.ops." +
             std::string(format.import) + "(filepath='" + path.filename().string() + "'); bpy.ops.export_scene.gltf(filepath='" +
             path.stem().string() + ".glb')\"";
  return {};
}

void DeleteModel::operator()(tinygltf::Model* model) const {
  delete model;
}

Result<ModelPointer> load_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& folder, OutsideFiles outside) {
  COPPICE_TRY(parts, split(file));
  std::optional<std::uint64_t> bin_bytes;
  if (parts.bin) bin_bytes = parts.bin->size();
  COPPICE_TRY(screened, screen_gltf(parts.json, bin_bytes));
  COPPICE_TRY(model, parse(parts, screened, folder.empty() ? "." : folder, outside));
  COPPICE_CHECK(decode_meshopt_views(*model, screened.meshopt_views));
  COPPICE_CHECK(decode_draco_primitives(*model));
  return model;
}

Result<ModelPointer> load_gltf(const std::filesystem::path& path, OutsideFiles outside) {
  std::error_code error;
  if (const auto bytes = std::filesystem::file_size(path, error); !error && bytes > gltf_code::kMaxFileBytes)
    return Error{Status::unsupported, "a glTF over 4 GiB", Error::kNoOffset, std::to_string(bytes) + " bytes"};
  COPPICE_TRY(file, read_file(path));
  if (const std::string how = conversion_advice(path); !how.empty())
    return Error{Status::unsupported, "not a glTF", Error::kNoOffset, path.string() + ": " + how};
  return load_gltf_bytes(file, path.parent_path(), outside);
}

}  // namespace coppice::bake
