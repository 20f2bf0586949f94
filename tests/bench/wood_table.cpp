// wood_table [FOLDER]  what becomes of the wood of the generated plants with difficult wood: triangles of each LoD and their share of the
// source's projected area, by material. Writes the plants to FOLDER as glTF, for the baker.

#include <cstdio>
#include <filesystem>
#include <map>

#include "gltf_write.h"
#include "wood_lods.h"
#include "wood_pieces.h"
#include "wood_plants.h"

namespace {

using coppice::bake::Mesh;
using coppice::bake::Plant;

/// By material, m2, mean over all directions.
std::map<std::uint32_t, double> projected_m2(const Mesh& mesh) {
  std::map<std::uint32_t, double> areas;
  for (const coppice::bake::WoodPiece& piece : coppice::bake::split_wood(mesh)) areas[piece.material] += piece.projected_m2;
  return areas;
}

void print_lods(const Plant& plant) {
  const auto source = projected_m2(plant.wood);
  for (const coppice::bake::WoodLevel& level : coppice::bake::wood_levels(plant.wood))
    for (const Mesh& lod : level) {
      std::printf("  %6zu triangles", lod.triangle_materials.size());
      auto areas = projected_m2(lod);
      for (const auto& [material, area] : source) std::printf("  %s %.2f", plant.materials[material].name.c_str(), areas[material] / area);
      std::printf(&lod == &level.front() ? "\n" : "  (lost)\n");
    }
}

}  // namespace

int main(int argc, char** argv) {
  for (const coppice::bake::test::WoodPlant& wood : coppice::bake::test::wood_plants()) {
    const Plant plant = wood.grow();
    std::printf("%s: %zu leaves\n", plant.name.c_str(), plant.leaves.size());
    print_lods(plant);
    if (argc < 2) continue;
    const auto file = std::filesystem::path(argv[1]) / (plant.name + ".glb");
    const auto written = coppice::bake::write_glb(file, {{"leaves", &plant.foliage}, {"wood", &plant.wood}}, plant.materials, plant.images);
    if (written) continue;
    std::fprintf(stderr, "wood_table: %s\n", written.error().message().c_str());
    return 1;
  }
  return 0;
}
