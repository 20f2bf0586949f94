// Wood that simplifiers lose: canes thinner than a pixel. Without it leaves hang in the air.

#include <map>
#include <string_view>

#include "looks_case.h"
#include "wood_plants.h"

namespace coppice::test {
namespace {

void add_mesh(GltfBuilder& builder, const bake::Mesh& mesh, std::string_view name) {
  std::map<std::uint32_t, Shape> shapes;  // by material
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    Shape& shape = shapes[mesh.triangle_materials[i / 3]];
    if (shape.positions.empty()) shape.positions = mesh.positions, shape.normals = mesh.normals, shape.uvs = mesh.uvs;
    shape.indices.push_back(mesh.indices[i]);
  }
  for (const auto& [material, shape] : shapes) add_shape(builder, shape, static_cast<int>(material), std::string(name));
}

GltfBuilder grown(std::string_view name, bool has_wood) {
  GltfBuilder builder;
  for (const bake::test::WoodPlant& wood : bake::test::wood_plants()) {
    if (wood.name != name) continue;
    const bake::Plant plant = wood.grow();
    for (const bake::Material& material : plant.materials) add_surface(builder, {.name = material.name, .base_color = material.base_color});
    add_mesh(builder, plant.foliage, "leaves");
    if (has_wood) add_mesh(builder, plant.wood, "wood");
  }
  return builder;
}

LooksCase thin_wood(const char* name) {
  return {.name = name,
          .plant = [name] { return grown(name, true); },
          .defect = [name] { return grown(name, false); },
          .bake = {.view_count = 4},
          .sizes_px = {120, 60}};
}

INSTANTIATE_TEST_SUITE_P(ThinWood, LooksTest, testing::Values(thin_wood("bamboo"), thin_wood("baubles")), looks_name);

}  // namespace
}  // namespace coppice::test
