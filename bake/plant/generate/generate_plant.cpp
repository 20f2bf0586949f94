#include "generate_plant.h"

#include <array>
#include <string>

#include "leaf_mesh.h"
#include "leaf_placement.h"
#include "seeded_random.h"
#include "skeleton.h"
#include "species.h"
#include "tube_mesh.h"

// Grows a plant in four steps, each a file pair in generate/: the skeleton of stems, the places of the leaves on it, tubes round the stems
// and petioles, and a copy of the species' leaf mesh at every place. species.cpp holds the numbers.

namespace coppice::bake {
namespace {

constexpr std::uint32_t kLeafMaterial = 0, kWoodMaterial = 1;

Error no_such_species(std::string_view name) {
  std::string detail = std::string(name) + " (there are:";
  for (const Species& species : all_species()) detail += " " + std::string(species.name);
  return Error{Status::invalid_argument, "no such plant", Error::kNoOffset, detail + ")"};
}

std::vector<Material> plant_materials(const Species& species) {
  Material leaves{.name = "leaves", .base_color = glm::vec4(species.leaf_color, 1.0f), .roughness = 0.75f};
  Material wood{.name = "wood", .base_color = glm::vec4(species.wood_color, 1.0f), .roughness = 0.95f, .double_sided = false};
  return {std::move(leaves), std::move(wood)};
}

Plant grow(const Species& species, std::uint64_t seed) {
  SeededRandom random(seed);
  SeededRandom stem_random = random.fork(), leaf_random = random.fork();
  const std::vector<Stem> stems = grow_skeleton(species, stem_random);
  const Mesh leaf = build_leaf(species.outline);
  const std::vector<PlacedLeaf> places = place_leaves(species, stems, leaf, leaf_random);

  Plant plant;
  plant.name = species.name;
  plant.materials = plant_materials(species);
  if (species.paint.width_px > 0) {
    plant.images.push_back(paint_leaf(species.outline, species.paint));
    plant.materials[kLeafMaterial].image = 0;
    plant.materials[kLeafMaterial].alpha_cutoff = kLeafAlphaCutoff;
  }
  for (const Stem& stem : stems) append_tube(plant.wood, stem.points, stem.radii, species.levels[stem.level].side_count, kWoodMaterial);
  const auto triangle_count = static_cast<std::uint32_t>(leaf.triangle_materials.size());
  for (const PlacedLeaf& place : places) {
    plant.leaves.push_back({static_cast<std::uint32_t>(plant.foliage.triangle_materials.size()), triangle_count});
    append_leaf(plant.foliage, leaf, place.pose, kLeafMaterial);
    if (species.habit.petiole_m == 0.0f) continue;
    // A petiole ends in a point at the leaf's stalk; it is wood, so that it never joins two leaves.
    const std::array<glm::vec3, 2> ends{place.petiole_start, place.pose.stalk};
    append_tube(plant.wood, ends, std::array<float, 2>{species.habit.petiole_radius_m, 0.0f}, 3, kWoodMaterial);
  }
  return plant;
}

}  // namespace

Result<Plant> generate_plant(std::string_view name, std::uint64_t seed) {
  for (const Species& species : all_species())
    if (species.name == name) return grow(species, seed);
  return no_such_species(name);
}

}  // namespace coppice::bake
