// libFuzzer: any bytes are refused with a named error or import as a plant whose parts fit together. Files that the bytes refer to are
// looked for in a folder that is not there. The checks trap, so that a wrong answer is found like a crash. So does one that costs too much:
// a second or 512 MiB to tell what the document will cost, or that much memory to read a document that is to cost little.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "check.h"
#include "fresh_memory.h"
#include "gltf_document.h"
#include "gltf_screen.h"
#include "import_gltf.h"

namespace {

const coppice::bake::ImportOptions kLittle{.max_source_triangles = 1u << 14};

void check_mesh(const coppice::bake::Mesh& mesh, std::size_t material_count) {
  COPPICE_ASSERT(mesh.indices.size() == 3 * mesh.triangle_materials.size());
  COPPICE_ASSERT(mesh.normals.size() == mesh.positions.size() && mesh.uvs.size() == mesh.positions.size());
  for (const std::uint32_t index : mesh.indices) COPPICE_ASSERT(index < mesh.positions.size());
  for (const std::uint32_t material : mesh.triangle_materials) COPPICE_ASSERT(material < material_count);
  for (const glm::vec3& position : mesh.positions)
    COPPICE_ASSERT(std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z));
  for (const glm::vec2& uv : mesh.uvs) COPPICE_ASSERT(std::isfinite(uv.x) && std::isfinite(uv.y));
}

void check_plant(const coppice::bake::Plant& plant) {
  check_mesh(plant.foliage, plant.materials.size());
  check_mesh(plant.wood, plant.materials.size());
  COPPICE_ASSERT(!plant.leaves.empty() || !plant.wood.indices.empty());
  std::size_t next_triangle = 0;
  for (const coppice::bake::LeafRange& leaf : plant.leaves) {
    COPPICE_ASSERT(leaf.first_triangle == next_triangle && leaf.triangle_count > 0);
    next_triangle += leaf.triangle_count;
  }
  COPPICE_ASSERT(next_triangle == plant.foliage.triangle_materials.size());
  for (const coppice::bake::Material& material : plant.materials) {
    COPPICE_ASSERT(material.image == coppice::bake::kNone || material.image < plant.images.size());
    for (int c = 0; c < 4; ++c) COPPICE_ASSERT(material.base_color[c] >= 0.0f && material.base_color[c] <= 1.0f);
  }
}

/// Pictures hold what the file says, whatever was in the memory that they lie in.
void check_pictures(const coppice::bake::Plant& plant, std::span<const std::uint8_t> file) {
  if (plant.images.empty()) return;
  coppice::test::fill_fresh_memory(0xc3);
  const auto again = coppice::bake::import_gltf_bytes(file, "no_such_folder/fuzz.glb", kLittle);
  COPPICE_ASSERT(again && again->images.size() == plant.images.size());
  for (std::size_t i = 0; i < plant.images.size(); ++i) COPPICE_ASSERT(again->images[i].rgba == plant.images[i].rgba);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  coppice::test::fill_fresh_memory(0x55);
  const std::span file(data, size);
  coppice::test::check_cost(
      1.0, [&] { static_cast<void>(coppice::bake::screen_gltf(coppice::bake::gltf_text(file), coppice::bake::kMaxGltfBytes)); });
  coppice::Result<coppice::bake::Plant> plant = coppice::Error{coppice::Status::internal};
  coppice::test::check_cost(60.0, [&] { plant = coppice::bake::import_gltf_bytes(file, "no_such_folder/fuzz.glb", kLittle); });
  if (plant) {
    check_plant(*plant);
    check_pictures(*plant, {data, size});
  } else {
    COPPICE_ASSERT(plant.error().message().find("fuzz.glb") != std::string::npos);
  }
  return 0;
}
