#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

struct DeleteModel {
  void operator()(tinygltf::Model* model) const;
};
using ModelPointer = std::unique_ptr<tinygltf::Model, DeleteModel>;

/// Reads a .gltf with the files beside it, or a .glb. In the result every index is in range and every accessor lies within its buffer
/// (gltf_screen.h); nothing is compressed any more (gltf_draco.h, gltf_meshopt.h). Images are the files' bytes, not decoded; an image file
/// that is missing is empty. errors  io: the file, or one it refers to, cannot be read; bad_file, unsupported: `detail` names the place
Result<ModelPointer> load_gltf(const std::filesystem::path& path);

/// The same of bytes in memory; `folder` holds the files they refer to.
Result<ModelPointer> load_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& folder);

}  // namespace coppice::bake
