// Pieces of a material (leaves, and connected triangles of wood) are sorted into bins by mean colour, leaves apart from wood. Bins nearest
// in colour are joined until the rest differ clearly. Bins whose parts of the image overlap so much that each would need a copy are joined
// too: that is one bark with light and dark places.

#include "material_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "coppice/format.h"
#include "srgb.h"
#include "texture_regions.h"
#include "texture_shown.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

/// Mean colours nearer than this, 0..1 in sRGB, count as one: for pieces of one kind, and for leaves beside wood.
constexpr double kAlikePieces = 32.0 / 255.0, kAlikeParts = 12.0 / 255.0;
/// Maximum number of parts of one material.
constexpr std::size_t kMaxParts = 8;
/// Maximum number of bins that are compared; the smallest of more join the nearest of these.
constexpr std::size_t kMaxBins = 128;
/// Minimum share of a material's area that is worth a material of its own.
constexpr double kMinShare = 0.002;
/// Maximum texels of all parts' regions together, relative to the whole's: for pieces of one kind, and for leaves beside wood.
constexpr double kMaxPieceTexels = 1.5, kMaxPartTexels = 2.0;
/// Maximum number of a plant's materials after the split: cards take more.
constexpr std::size_t kMaxMaterials = COPPICE_MAX_MATERIALS / 2;

enum Kind : std::size_t { kLeaf, kWood };

/// A part of a material's surface.
struct Surface {
  ColorSum texels;          ///< without tint
  glm::dvec3 tint_m2{0.0};  ///< tint times area
  double area_m2 = 0.0;     ///< includes holes
  UvBounds bounds;

  [[nodiscard]] glm::dvec3 tint() const { return area_m2 > 0.0 ? tint_m2 / area_m2 : glm::dvec3(1.0); }
  [[nodiscard]] glm::dvec3 color() const { return texels.mean() * tint(); }
  void add(const Surface& other) {
    texels.add(other.texels);
    tint_m2 += other.tint_m2;
    area_m2 += other.area_m2;
    bounds.add(other.bounds);
  }
};

/// Pieces of one material and about one colour. They are of one kind until leaves and wood are joined.
struct Bin {
  Kind kind = kLeaf;
  Surface surface;
  std::array<std::vector<std::size_t>, 2> pieces;  ///< by kind

  void add(const Bin& other) {
    surface.add(other.surface);
    for (std::size_t k = 0; k < 2; ++k) pieces[k].insert(pieces[k].end(), other.pieces[k].begin(), other.pieces[k].end());
  }
};

/// [triangle] the piece that it belongs to.
using Pieces = std::vector<std::size_t>;

Pieces leaf_pieces(const Plant& plant) {
  Pieces pieces(plant.foliage.triangle_materials.size(), 0);
  for (std::size_t i = 0; i < plant.leaves.size(); ++i)
    std::fill_n(pieces.begin() + std::ptrdiff_t{plant.leaves[i].first_triangle}, plant.leaves[i].triangle_count, i);
  return pieces;
}

Pieces wood_pieces(const Mesh& wood) {
  UnionFind sets(wood.positions.size());
  for (std::size_t i = 0; i < wood.indices.size(); i += 3)
    for (std::size_t k = 1; k < 3; ++k) sets.join(wood.indices[i], wood.indices[i + k]);
  Pieces pieces;
  for (std::size_t i = 0; i < wood.indices.size(); i += 3) pieces.push_back(sets.find(wood.indices[i]));
  return pieces;
}

/// What the triangles of each piece show, by material and piece.
using PieceSurfaces = std::map<std::pair<std::uint32_t, std::size_t>, Surface>;

PieceSurfaces piece_surfaces(const Plant& plant, const Mesh& mesh, const Pieces& pieces) {
  PieceSurfaces surfaces;
  auto last = surfaces.end();  // a piece's triangles follow each other
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const std::uint32_t material = mesh.triangle_materials[t];
    const std::pair place(material, pieces[t]);
    if (last == surfaces.end() || last->first != place) last = surfaces.try_emplace(place).first;
    Surface& surface = last->second;
    const UvTriangle uvs = triangle_uvs(mesh, t);
    const double area_m2 = triangle_area_m2(mesh, t);
    surface.texels.add(triangle_color(plant.materials[material], plant.images, uvs, area_m2));
    surface.tint_m2 += area_m2 * (mesh.triangle_tints.empty() ? glm::dvec3(1.0) : glm::dvec3(mesh.triangle_tints[t]));
    surface.area_m2 += area_m2;
    for (const glm::vec2& uv : uvs) surface.bounds.add(uv);
  }
  return surfaces;
}

/// A bin of colours: sixteen steps a channel, as a display shows it.
std::array<int, 3> color_key(const glm::dvec3& linear) {
  std::array<int, 3> key{};
  for (std::size_t c = 0; c < 3; ++c)
    key[c] = static_cast<int>(std::clamp(15.999f * srgb_from_linear(static_cast<float>(linear[static_cast<int>(c)])), 0.0f, 15.0f));
  return key;
}

/// Difference of two bins in colour. A bin that shows nothing but holes is like any other.
double difference(const Bin& a, const Bin& b) {
  if (!(a.surface.texels.area_m2 > 0.0 && b.surface.texels.area_m2 > 0.0)) return 0.0;
  return color_difference(a.surface.color(), b.surface.color());
}

void join(std::vector<Bin>& bins, std::size_t into, std::size_t from) {
  bins[into].add(bins[from]);
  bins.erase(bins.begin() + static_cast<std::ptrdiff_t>(from));
}

/// The two bins that are nearest in colour, of one kind or of any kind; equal numbers if there are none.
struct Pair {
  std::size_t first = 0, second = 0;
  double difference = std::numeric_limits<double>::infinity();
};
Pair nearest_pair(const std::vector<Bin>& bins, bool any_kind) {
  Pair best;
  for (std::size_t i = 0; i < bins.size(); ++i)
    for (std::size_t j = i + 1; j < bins.size(); ++j) {
      if (!any_kind && bins[i].kind != bins[j].kind) continue;
      const double gap = difference(bins[i], bins[j]);
      if (gap < best.difference) best = {i, j, gap};
    }
  return best;
}

/// Joins a bin into the one of its kind that is nearest in colour; false if there is none.
bool join_nearest(std::vector<Bin>& bins, std::size_t from) {
  std::size_t best = from;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (i == from || bins[i].kind != bins[from].kind) continue;
    const double gap = difference(bins[i], bins[from]);
    if (gap >= smallest) continue;
    smallest = gap;
    best = i;
  }
  if (best == from) return false;
  join(bins, best, from);
  return true;
}

void join_lightest(std::vector<Bin>& bins) {
  std::ranges::stable_sort(bins, {}, [](const Bin& bin) { return -bin.surface.area_m2; });
  double all_m2 = 0.0;
  for (const Bin& bin : bins) all_m2 += bin.surface.area_m2;
  for (std::size_t i = bins.size(); i-- > 0;)
    if (i >= kMaxBins || bins[i].surface.area_m2 < kMinShare * all_m2) join_nearest(bins, i);
}

/// The texels of all bins' regions together; regions that bins can share count once.
double texels_of(const std::vector<Bin>& bins, const Image& image) {
  std::vector<std::pair<TextureRegion, glm::dvec3>> regions;
  double sum = 0.0;
  for (const Bin& bin : bins) {
    const TextureRegion region = texture_region(bin.surface.bounds, image);
    const glm::dvec3 color = bin.surface.texels.mean();
    const bool shared = std::ranges::any_of(regions, [&](const auto& other) {
      return other.first.first == region.first && other.first.last == region.last && color_difference(other.second, color) <= kAlikeParts;
    });
    if (shared) continue;
    regions.emplace_back(region, color);
    sum += static_cast<double>(region.texels());
  }
  return sum;
}

/// Joins bins that would need copies of the same texels.
void join_overlapping(std::vector<Bin>& bins, const Image& image) {
  UvBounds whole;
  for (const Bin& bin : bins) whole.add(bin.surface.bounds);
  const auto whole_texels = static_cast<double>(texture_region(whole, image).texels());
  while (bins.size() > 1) {
    Pair pair = nearest_pair(bins, false);
    const bool kinds_only = pair.first == pair.second;
    if (texels_of(bins, image) <= (kinds_only ? kMaxPartTexels : kMaxPieceTexels) * whole_texels) return;
    if (kinds_only) pair = nearest_pair(bins, true);
    join(bins, pair.first, pair.second);
  }
}

/// Finds the parts of a material; one if it is not to be split.
std::vector<Bin> find_parts(std::vector<Bin> bins, const Material& material, const std::vector<Image>& images) {
  join_lightest(bins);
  for (Pair pair = nearest_pair(bins, false); pair.first != pair.second && (pair.difference < kAlikePieces || bins.size() > kMaxParts);
       pair = nearest_pair(bins, false))
    join(bins, pair.first, pair.second);
  for (Pair pair = nearest_pair(bins, true); pair.first != pair.second && pair.difference < kAlikeParts; pair = nearest_pair(bins, true))
    join(bins, pair.first, pair.second);
  if (material.image != kNone) join_overlapping(bins, images[material.image]);
  return bins;
}

/// [material] its pieces, in bins of one colour.
std::vector<std::vector<Bin>> bins_by_material(std::size_t material_count, const std::array<PieceSurfaces, 2>& surfaces) {
  std::vector<std::map<std::pair<Kind, std::array<int, 3>>, Bin>> sorted(material_count);
  for (const Kind kind : {kLeaf, kWood})
    for (const auto& [place, surface] : surfaces[kind]) {
      Bin& bin = sorted[place.first][{kind, color_key(surface.color())}];
      bin.kind = kind;
      bin.surface.add(surface);
      bin.pieces[kind].push_back(place.second);
    }
  std::vector<std::vector<Bin>> bins(material_count);
  for (std::size_t m = 0; m < sorted.size(); ++m)
    for (auto& [key, bin] : sorted[m]) bins[m].push_back(std::move(bin));
  return bins;
}

/// The new material of each piece, by material and piece.
using NewMaterials = std::map<std::pair<std::uint32_t, std::size_t>, std::uint32_t>;

void apply(const NewMaterials& materials, const Pieces& pieces, Mesh& mesh) {
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const auto found = materials.find({mesh.triangle_materials[t], pieces[t]});
    if (found != materials.end()) mesh.triangle_materials[t] = found->second;
  }
  mesh.triangle_tints.clear();
}

}  // namespace

void split_materials(Plant& plant) {
  const std::array<Pieces, 2> pieces{leaf_pieces(plant), wood_pieces(plant.wood)};
  const std::array<Mesh*, 2> meshes{&plant.foliage, &plant.wood};
  std::array<PieceSurfaces, 2> surfaces;
  for (const Kind kind : {kLeaf, kWood}) surfaces[kind] = piece_surfaces(plant, *meshes[kind], pieces[kind]);
  std::vector<std::vector<Bin>> bins = bins_by_material(plant.materials.size(), surfaces);
  std::array<NewMaterials, 2> new_materials;
  for (std::uint32_t m = 0; m < bins.size(); ++m) {
    const std::vector<Bin> parts = find_parts(std::move(bins[m]), plant.materials[m], plant.images);
    if (parts.size() < 2 || plant.materials.size() + parts.size() > kMaxMaterials) continue;
    const Material whole = plant.materials[m];
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::uint32_t number = i == 0 ? m : static_cast<std::uint32_t>(plant.materials.size());
      if (i > 0) plant.materials.push_back(whole);
      plant.materials[number].base_color = glm::vec4(glm::dvec4(whole.base_color) * glm::dvec4(parts[i].surface.tint(), 1.0));
      for (const Kind kind : {kLeaf, kWood})
        for (const std::size_t piece : parts[i].pieces[kind]) new_materials[kind][{m, piece}] = number;
    }
  }
  for (const Kind kind : {kLeaf, kWood}) apply(new_materials[kind], pieces[kind], *meshes[kind]);
}

}  // namespace coppice::bake
