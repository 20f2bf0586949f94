#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gltf_triangles.h"
#include "plant.h"
#include "triangle_soup.h"

namespace coppice::bake::test {

/// How the lobes of a leaf touch: all in its stalk point; each the next in a corner; in a corner and the stalk point; along an edge.
enum class LobeContact { stalk, corner, two_points, edge };
/// Lobes differ; those left and right of the middle mirror each other; all are equal.
enum class LobeForm { own, mirrored, equal };
/// A strip of three triangles; a closed pyramid of six over a flat rhomb; four triangles in the middle, strips beside it.
enum class LobeShape { strip, pyramid, unlike };
enum class LobeSides { one, both, repeated, both_with_own_vertices };
enum class LobeVertices { per_lobe, per_leaf, per_triangle };
enum class LobeOrder { consecutive, by_lobe, shuffled, interleaved };
enum class TwigForm { none, strips, prisms };
enum class PotForm { none, round, facets };
/// Triangles without area: with equal corners; with three corners in a line, which fill T-junctions; both.
enum class Degenerate { none, collapsed, slivers, both };

/// A plant whose leaves are made of lobes that hardly touch. Deterministic.
struct LobedPlant {
  std::string name;
  std::uint32_t lobe_count = 3;
  LobeContact contact = LobeContact::stalk;
  LobeForm form = LobeForm::own;
  LobeSides sides = LobeSides::one;
  LobeVertices vertices = LobeVertices::per_lobe;
  LobeOrder order = LobeOrder::consecutive;
  TwigForm twigs = TwigForm::none;  ///< five segments each, for six leaves, in the leaves' material
  bool twigs_bear = false;          ///< leaves touch their twig
  PotForm pot = PotForm::none;
  Degenerate degenerate = Degenerate::none;
  bool has_uvs = false;
  bool has_names = true;
  LobeShape shape = LobeShape::strip;
  bool instanced_twigs = false;  ///< all twigs are alike: leaves, their sizes, bends and directions
  bool shuffled_triangles = false;
  bool are_leaves = false;  ///< each lobe is a leaf of its own, with all of the image: whorls, pairs, compound leaves. Equal or mirrored
  double step = 0.7;        ///< angle between neighbouring lobes, rad
  double cone = 0.0;        ///< angle of the lobes to their common plane, rad
  double bend = 0.0;        ///< each leaf bends by its own amount, up to so many radians over its length
  double touching = 0.0;    ///< share of leaves whose tip is a point of the leaf before
  double step_m = 0.0;      ///< positions are rounded to multiples
  std::uint32_t leaf_count = 900;  ///< a multiple of 6
  std::uint32_t seed = 1;
  [[nodiscard]] std::uint32_t true_leaf_count() const { return are_leaves ? leaf_count * lobe_count : leaf_count; }
};

struct GrownPlant {
  TriangleSoup soup;
  std::vector<Material> materials;  ///< leaves and twigs, trunk, pot; grey
};

GrownPlant grow(const LobedPlant& plant);

/// The variations that tests go through.
std::vector<LobedPlant> lobed_plants();

}  // namespace coppice::bake::test
