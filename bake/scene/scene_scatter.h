#pragma once

// Scatters plants over a square by density maps and a seed.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "result.h"
#include "scene_write.h"

namespace coppice::bake {

/// A grey image over the whole square; its first row is the far (-z) edge. White is dense, black is bare.
struct DensityMap {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> grey;  ///< [width * height] row by row
};

/// Decodes a PNG, or another form that decode_image reads; colours count by their luminance. errors  as decode_image
Result<DensityMap> decode_density_map(std::span<const std::uint8_t> bytes);

struct ScatterSpecies {
  float sphere_radius_m = 1.0f;
  const DensityMap* density = nullptr;  ///< null: equally dense everywhere
  std::string name = {};                ///< the name in messages
};

struct ScatterOptions {
  std::uint32_t seed = 1;
  float size_m = 1000.0f;  ///< side of the square, whose centre is the origin
  std::uint64_t count = 0;
  float spacing = 0.3f;  ///< minimum distance of two stems as a share of their summed crown radii; 0: none
  float scale_min = 0.75f, scale_max = 1.25f;
};

/// [species] The number of plants of each: in proportion to the means of their maps, with white for a species without a map. They sum up to
/// `count`.
std::vector<std::uint64_t> scatter_shares(std::span<const ScatterSpecies> species, std::uint64_t count);

/// Places exactly options.count plants at height 0. Each species gets its share (scatter_shares) if it fits; other species get the rest.
/// Species with wide crowns are placed first. A map says where its species stands, not how many there are compared with others. A species
/// is likelier where its noise is high, which makes groves; if no species has a map, another noise makes clearings. Same arguments, same
/// plants. Takes 32 bytes a plant.
/// progress  receives the share that is done; may be empty
/// errors  invalid_argument: they do not fit (`detail` says which species, how many of how many, and how far apart they have to stand),
///         every map is black, an option is out of range
Result<std::vector<ScenePlant>> scatter_plants(std::span<const ScatterSpecies> species, const ScatterOptions& options,
                                               const std::function<void(float)>& progress = {});

}  // namespace coppice::bake
