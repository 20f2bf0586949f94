#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "gltf_triangles.h"
#include "plant.h"
#include "triangle_soup.h"

namespace coppice::bake::test {

/// A plant that is no tree of leaves on twigs: blobs, cacti, hedges, grass, ferns, dead wood. Deterministic.
struct OddPlant {
  std::string name;
  TriangleSoup soup;
  std::vector<Material> materials;
  std::uint32_t leaf_count = 0;  ///< that a person would count; 0 where all of it is wood
};

inline void PrintTo(const OddPlant& each, std::ostream* out) {
  *out << each.name;
}

/// More than forty of them, 0.3 to 5 m high. Most materials have no name that helps, none an image.
std::vector<OddPlant> odd_plants();

/// As a binary glTF file.
std::vector<std::uint8_t> encode(const OddPlant& plant);

}  // namespace coppice::bake::test
