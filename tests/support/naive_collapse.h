#pragma once

// Algorithm 1 with nothing clever: everything is rendered again for every candidate, and I(V,L) is summed over all outcomes every time.
// Shared with the baker: which pixels a quad covers and how deep (raster.h, visibility.h), and the rounding of one outcome's information
// (outcome_information). Restated here from the documented rules: item buffers, areas, cells, candidates, Fig. 3, cards, ties.

#include <cstdint>
#include <map>
#include <vector>

#include "alpha_mask.h"
#include "collapse.h"
#include "mutual_information.h"
#include "visibility.h"

namespace coppice::test {

struct NaiveLeaf {
  bake::Quad quad{};
  std::uint32_t card = 0;
};

/// The live leaves by id.
using NaivePlant = std::map<std::uint32_t, NaiveLeaf>;

struct NaiveScene {
  bake::Foliage source;
  std::vector<bake::AlphaMask> masks;
  std::vector<bake::Viewpoint> views;
  bake::CollapseOptions options;
};

/// Areas in every view, px, by leaf id; every live leaf has an entry.
struct NaiveAreas {
  std::map<std::uint32_t, std::vector<std::uint32_t>> leaves;
  std::vector<std::uint32_t> background;
};

NaivePlant source_plant(const NaiveScene& scene);
NaiveAreas render_areas(const NaiveScene& scene, const NaivePlant& plant);

struct NaiveInformation {
  std::map<std::uint32_t, bake::FixedBits> leaves;
  bake::FixedBits sum = 0;
};
NaiveInformation information_of(const NaiveScene& scene, const NaiveAreas& areas);

/// Equation (7) in plain floating point, straight from the definitions.
double information_by_definition(const NaiveScene& scene, const NaiveAreas& areas);

/// Replaces a merge's two leaves by its result, whose id is given.
NaivePlant merged_plant(const NaivePlant& plant, const bake::Merge& merge, std::uint32_t result);

/// The whole sequence.
bake::CollapseSequence naive_collapse(const NaiveScene& scene);

}  // namespace coppice::test
