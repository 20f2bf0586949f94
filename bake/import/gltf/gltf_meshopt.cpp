#include "gltf_meshopt.h"

#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include "gltf_accessor.h"

namespace coppice::bake {
namespace {

using Mode = MeshoptView::Mode;
using Filter = MeshoptView::Filter;

Error bad(Status status, const char* what, const MeshoptView& view, const std::string& more = {}) {
  return Error{status, what, Error::kNoOffset, "bufferViews[" + std::to_string(view.view) + "].extensions." + view.extension + more};
}

/// How a mode is coded. The high half of a coded view's first byte names the mode, the low half the coding's version.
struct Coding {
  unsigned code = 0, newest_version = 0;
  int (*decode)(void*, std::size_t, std::size_t, const unsigned char*, std::size_t) = nullptr;
};

Coding coding_of(Mode mode) {
  switch (mode) {
    case Mode::attributes:
      return {0xa0, 0, meshopt_decodeVertexBuffer};
    case Mode::triangles:
      return {0xe0, 1, meshopt_decodeIndexBuffer};
    case Mode::indices:
      break;
  }
  return {0xd0, 1, meshopt_decodeIndexSequence};
}

void apply_filter(const MeshoptView& view, std::vector<unsigned char>& bytes) {
  if (view.filter == Filter::octahedral) meshopt_decodeFilterOct(bytes.data(), view.count, view.stride_bytes);
  if (view.filter == Filter::quaternion) meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride_bytes);
  if (view.filter == Filter::exponential) meshopt_decodeFilterExp(bytes.data(), view.count, view.stride_bytes);
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
  apply_filter(view, bytes);
  return bytes;
}

}  // namespace

bool meshopt_is_plausible(Mode mode, std::uint64_t count, std::uint64_t stride_bytes, std::uint64_t coded_bytes) {
  // A triangle takes at least a byte, and so does an index; 64 equal attribute bytes fit in one byte.
  if (mode == Mode::triangles) return count / 3 <= coded_bytes;
  if (mode == Mode::indices) return count <= coded_bytes;
  return count / 64 <= coded_bytes / stride_bytes;
}

Result<void> decode_meshopt_views(tinygltf::Model& model, const std::vector<MeshoptView>& views) {
  // Views that share bytes could make any number of copies of them. Together they may code at most the bytes that there are.
  std::size_t bytes_left = 0;
  for (const tinygltf::Buffer& buffer : model.buffers) bytes_left += buffer.data.size();
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

}  // namespace coppice::bake
