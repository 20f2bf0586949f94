// Wood and leaf meshes with a normal map, lit from four sides; under validation.

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "normal_map.h"
#include "random_tree.h"
#include "renderer_scene.h"

namespace coppice::test::relief_test {

constexpr std::uint32_t kSidePx = 64;

class ReliefTest : public VulkanTest {};

/// A normal map of one colour.
bake::Image flat_map(const glm::vec3& normal) {
  bake::Image map{4, 4, std::vector<std::uint8_t>(64), true};
  for (std::size_t i = 0; i < map.rgba.size(); i += 4) bake::write_normal(normal, std::span<std::uint8_t, 4>(map.rgba.data() + i, 4));
  return map;
}

/// In front of the leaves, facing +z; small, so that light per vertex is that of its middle. As glTF has it, u grows to the right and v
/// downwards.
bake::Mesh wall(std::uint32_t material) {
  bake::Mesh mesh;
  mesh.positions = {{-0.2f, -0.2f, 2.0f}, {0.2f, -0.2f, 2.0f}, {0.2f, 0.2f, 2.0f}, {-0.2f, 0.2f, 2.0f}};
  mesh.uvs = {{0.0f, 1.0f}, {1.0f, 1.0f}, {1.0f, 0.0f}, {0.0f, 0.0f}};
  mesh.normals.assign(4, {0.0f, 0.0f, 1.0f});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  mesh.triangle_materials = {material, material};
  return mesh;
}

enum class Surface { wood, leaf };

bake::BakedPlant walled_plant(Surface surface) {
  const bool leaf = surface == Surface::leaf;
  bake::BakedPlant plant =
      random_plant({.leaf_count = 8, .seed = 4, .wood_lod_count = leaf ? 0u : 1u, .texture_side = 0, .leaf_mesh_count = leaf ? 1u : 0u});
  const std::uint32_t material = leaf ? 2 : 1;
  plant.materials[material].base_color = glm::vec4(glm::vec3(0.2f), 1.0f);
  if (leaf) {
    bake::LeafMeshPart& part = plant.leaf_meshes.parts[0];
    part = {wall(material), std::vector<glm::vec3>(4, part.stalks[0])};
  } else {
    plant.wood.lods[0] = wall(material);
  }
  return plant;
}

/// Green of the picture's middle with the sun 53 degrees off the wall's normal, to the right or upwards. mirrored: left and right
int lit(const VulkanDevice& gpu, bake::BakedPlant plant, const glm::vec3* map_normal, const glm::vec3& sun, bool mirrored = false) {
  if (map_normal != nullptr) {
    for (bake::Material& material : plant.materials) material.normal_map = static_cast<std::uint32_t>(plant.images.size());
    plant.images.push_back(flat_map(*map_normal));
  }
  coppice_placement placement = placement_at();
  if (mirrored) {
    placement.scale = -1.0f;
    std::ranges::copy(std::array{1.0f, 0.0f, 0.0f, 0.0f}, placement.rotation);
  }
  RendererScene scene(gpu, 64);
  scene.place(scene.add_plant(decoded_plant(plant)), {placement});
  Shot view = make_view({.eye_m = {0.0f, 0.0f, 5.0f}, .width_px = kSidePx, .error_px = 0.01f});
  std::copy_n(&sun.x, 3, view.light.sun_direction);
  return scene.draw(view).picture.at(kSidePx / 2, kSidePx / 2)[1];
}

TEST_F(ReliefTest, AMirroredPlantHasItMirrored) {
  const glm::vec3 from_right(0.8f, 0.0f, 0.6f), from_left(-0.8f, 0.0f, 0.6f), right(0.6f, 0.0f, 0.8f);
  for (const Surface surface : {Surface::wood, Surface::leaf})
    for (const glm::vec3* map_normal : {static_cast<const glm::vec3*>(nullptr), &right})
      EXPECT_NEAR(lit(gpu(), walled_plant(surface), map_normal, from_left, true), lit(gpu(), walled_plant(surface), map_normal, from_right),
                  1)
          << (surface == Surface::wood ? "wood" : "leaf");
}

TEST_F(ReliefTest, WhatLeansTowardsTheSunIsBrighter) {
  const glm::vec3 from_right(0.8f, 0.0f, 0.6f), from_above(0.0f, 0.8f, 0.6f);
  const glm::vec3 right(0.6f, 0.0f, 0.8f), left(-0.6f, 0.0f, 0.8f), up(0.0f, 0.6f, 0.8f), down(0.0f, -0.6f, 0.8f);
  for (const Surface surface : {Surface::wood, Surface::leaf}) {
    const auto shade = [&](const glm::vec3* map_normal, const glm::vec3& sun) {
      return lit(gpu(), walled_plant(surface), map_normal, sun);
    };
    const char* name = surface == Surface::wood ? "wood" : "leaf";
    const int plain = shade(nullptr, from_right);
    EXPECT_GT(shade(&right, from_right), plain + 5) << name;
    EXPECT_LT(shade(&left, from_right), plain - 5) << name;
    EXPECT_GT(shade(&up, from_above), plain + 5) << name;
    EXPECT_LT(shade(&down, from_above), plain - 5) << name;
    // Across the light both sides see the sun alike, but more or less sky.
    EXPECT_NEAR(shade(&up, from_right), shade(&down, from_right), 15) << name;
  }
}

TEST_F(ReliefTest, AFlatMapChangesNothing) {
  const glm::vec3 straight(0.0f, 0.0f, 1.0f), sun(0.8f, 0.0f, 0.6f);
  for (const Surface surface : {Surface::wood, Surface::leaf})
    EXPECT_NEAR(lit(gpu(), walled_plant(surface), &straight, sun), lit(gpu(), walled_plant(surface), nullptr, sun), 2);
}

}  // namespace coppice::test::relief_test
