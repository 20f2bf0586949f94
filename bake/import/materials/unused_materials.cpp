#include "unused_materials.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace coppice::bake {

void drop_unused_materials(BakedPlant& plant) {
  std::vector<std::uint32_t> material_number(plant.materials.size(), kNone), image_number(plant.images.size(), kNone);
  std::vector<bool> is_on_mesh(plant.materials.size(), false);
  const auto mark_mesh = [&](const Mesh& mesh) {
    for (const std::uint32_t material : mesh.triangle_materials) {
      material_number[material] = 0;
      is_on_mesh[material] = true;
    }
  };
  for (const Card& card : plant.card_table) material_number[card.material] = 0;
  for (const Mesh& lod : plant.wood.lods) mark_mesh(lod);
  for (const LeafMeshPart& part : plant.leaf_meshes.parts) mark_mesh(part.mesh);
  BakedPlant kept;
  for (std::size_t m = 0; m < plant.materials.size(); ++m) {
    if (material_number[m] == kNone) continue;
    if (!is_on_mesh[m]) plant.materials[m].normal_map = kNone;
    material_number[m] = static_cast<std::uint32_t>(kept.materials.size());
    Material& material = kept.materials.emplace_back(std::move(plant.materials[m]));
    for (std::uint32_t* used : {&material.image, &material.normal_map}) {
      if (*used == kNone) continue;
      std::uint32_t& image = image_number[*used];
      if (image == kNone) {
        image = static_cast<std::uint32_t>(kept.images.size());
        kept.images.push_back(std::move(plant.images[*used]));
      }
      *used = image;
    }
  }
  for (Card& card : plant.card_table) card.material = material_number[card.material];
  for (Mesh& lod : plant.wood.lods)
    for (std::uint32_t& material : lod.triangle_materials) material = material_number[material];
  for (LeafMeshPart& part : plant.leaf_meshes.parts)
    for (std::uint32_t& material : part.mesh.triangle_materials) material = material_number[material];
  plant.materials = std::move(kept.materials);
  plant.images = std::move(kept.images);
}

}  // namespace coppice::bake
