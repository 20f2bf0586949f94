#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gltf_cost.h"
#include "gltf_references.h"
#include "result.h"

namespace tinygltf {
class Model;
}

namespace coppice::bake {

/// The header of a .glb holds its size in 32 bits.
inline constexpr std::uint64_t kMaxGltfBytes = 0xffffffff;

struct DeleteModel {
  void operator()(tinygltf::Model* model) const;
};
using ModelPointer = std::unique_ptr<tinygltf::Model, DeleteModel>;

/// Says how to make a glTF of a file in another format, known by its name: Blender's command line. Empty if Blender does not read it.
std::string conversion_advice(const std::filesystem::path& path);

/// What the JSON of a file says of an import.
struct GltfOutline {
  std::uint64_t triangles = 0;  ///< ScreenedGltf::triangles
  std::vector<GltfReference> references;
  std::vector<std::filesystem::path> files;  ///< that they name, whether there or not
};

/// Reads the JSON of a .gltf or .glb and checks it. The bytes of a .glb's other chunk are not looked at.
/// max_source_triangles  0: kMaxSourceTriangles. This machine's memory is no limit: another may bake the plant
/// errors  those of read_file and screen_gltf; a document with over 32 MiB of JSON counts as damaged
Result<GltfOutline> outline_gltf(const std::filesystem::path& path, std::uint64_t max_source_triangles = 0);

/// A file with those that it refers to, whether these are there or not: what a command that reads it must not write to. The file alone
/// where outline_gltf refuses it.
std::vector<std::filesystem::path> files_of_gltf(const std::filesystem::path& path);

/// Reads a .gltf with the files beside it, or a .glb. In the result every index is in range, every accessor lies within its buffer
/// (gltf_screen.h), nothing is compressed any more (gltf_compression.h), and skins and morphs are applied (gltf_pose.h). Images that are
/// data URIs hold their bytes, not decoded; other images have a view or a file, which is in the folder unless `outside` allows others.
/// A document over the limit is refused before any of its files is read.
/// on_read  may be empty
/// errors  io: the file, or a buffer's, cannot be read; bad_file, unsupported: `detail` names the place; invalid_argument: see
///         resolve_reference
Result<ModelPointer> load_gltf(const std::filesystem::path& path, OutsideFiles outside, const CostLimit& limit,
                               const ReadObserver& on_read = {});

/// Does the same for bytes in memory. folder  holds the files that they refer to
Result<ModelPointer> load_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& folder, OutsideFiles outside,
                                     const CostLimit& limit, const ReadObserver& on_read = {});

}  // namespace coppice::bake
