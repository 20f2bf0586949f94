#pragma once

#include <cstdint>

#include "plant.h"

namespace coppice::test {

/// Leaf quads of a plausible crown: parallelograms of like size at random places and angles in a sphere. Same arguments, same leaves,
/// on every platform.
bake::Foliage random_foliage(std::uint32_t leaf_count, std::uint32_t seed, std::uint32_t card_count = 2);

/// A valid tree over `foliage` in refinement order: neighbours along a space-filling curve merge in random order, each into four of its
/// eight vertices (Fig. 3 of the paper).
bake::Tree random_tree(const bake::Foliage& foliage, std::uint32_t seed);

/// A tapered open tube along +Y, 2 m long: rings of `sides` faces. sides >= 3, rings >= 2.
bake::Mesh tube(std::uint32_t sides, std::uint32_t rings, std::uint32_t material);

/// How nodes show, their opacity and normals:
enum class Looks : std::uint8_t {
  plain,   ///< all like opaque source leaves without normals of their own
  smooth,  ///< those that are replaced a step or two from their parent, without sides
  sided,   ///< the same, but with sides, and normals of source leaves are along or against an axis that is their parent's or near it
  noise,   ///< anyhow; normals of source leaves, too
};
void set_looks(bake::Tree& tree, Looks looks, std::uint32_t seed);

/// Normals with the axis made as coarse as files have it with their along.
std::uint16_t coarse_enough(std::uint16_t normals);

struct RandomPlantOptions {
  std::uint32_t leaf_count = 100;
  std::uint32_t seed = 1;
  std::uint32_t card_count = 2;
  std::uint32_t wood_lod_count = 2;
  std::uint32_t texture_side = 8;     ///< 0: no texture
  std::uint32_t leaf_mesh_count = 0;  ///< parts
  Looks looks = Looks::plain;
};

/// A complete plant over random_tree: two materials, a stem of tapered rings as wood, an error table. With leaf meshes each leaf is its
/// quad with the middle raised, four triangles of a third material with a texture of its own; their error reaches 2 px at 400 px.
bake::BakedPlant random_plant(const RandomPlantOptions& options);

}  // namespace coppice::test
