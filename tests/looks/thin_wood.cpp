// Wood that simplifiers lose: canes thinner than a pixel. Without it leaves hang in the air.

#include <map>
#include <string_view>

#include "looks_case.h"
#include "wood_plants.h"

namespace coppice::test::thin_wood {

void add_mesh(GltfBuilder& builder, const bake::Mesh& mesh, std::string_view name) {
  std::map<std::uint32_t, Shape> shapes;  // by material
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    Shape& shape = shapes[mesh.triangle_materials[i / 3]];
    if (shape.positions.empty()) shape.positions = mesh.positions, shape.normals = mesh.normals, shape.uvs = mesh.uvs;
    shape.indices.push_back(mesh.indices[i]);
  }
  for (const auto& [material, shape] : shapes) add_shape(builder, shape, static_cast<int>(material), std::string(name));
}

/// The triangles of a mesh whose first corner is below a height.
bake::Mesh below(bake::Mesh mesh, float height_m) {
  std::vector<std::uint32_t> indices, materials;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    if (mesh.positions[mesh.indices[i]].y >= height_m) continue;
    indices.insert(indices.end(), &mesh.indices[i], &mesh.indices[i] + 3);
    materials.push_back(mesh.triangle_materials[i / 3]);
  }
  mesh.indices = std::move(indices);
  mesh.triangle_materials = std::move(materials);
  return mesh;
}

/// The wood of it that is below a height.
GltfBuilder grown(std::string_view name, float wood_height_m) {
  GltfBuilder builder;
  for (const bake::test::WoodPlant& wood : bake::test::wood_plants()) {
    if (wood.name != name) continue;
    const bake::Plant plant = wood.grow();
    for (const bake::Material& material : plant.materials) add_surface(builder, {.name = material.name, .base_color = material.base_color});
    add_mesh(builder, plant.foliage, "leaves");
    add_mesh(builder, below(plant.wood, wood_height_m), "wood");
  }
  return builder;
}

/// lost_above_m: of the wood, in the defect
LooksCase thin_wood(const char* name, float lost_above_m) {
  return {.name = name, .plant = [=] { return grown(name, 1e9f); }, .defect = [=] { return grown(name, lost_above_m); }};
}

/// At 30 px its ornaments are half a pixel, and some are lost.
LooksCase baubles() {
  LooksCase conifer = thin_wood("baubles", 0);
  conifer.sizes_px = {480, 240, 120, 60};
  return conifer;
}

INSTANTIATE_TEST_SUITE_P(ThinWood, LooksTest,
                         testing::Values(thin_wood("bamboo", 0), baubles(), thin_wood("cactus", 0.6f), thin_wood("oak_foot", 0)),
                         looks_name);

}  // namespace coppice::test::thin_wood
