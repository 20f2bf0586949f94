// Cards are what a quad shows in place of a leaf's mesh. Every leaf has its own rectangle, so in the rectangle's coordinates leaves of one
// species are alike, however they are turned, scaled or stretched. Leaves are compared only by a small image of each in those coordinates
// (its sketch), never by their meshes.

#include "leaf_cards.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "alpha_mask.h"
#include "bounds.h"
#include "leaf_normals.h"
#include "leaf_quads.h"
#include "parallel_for.h"
#include "srgb.h"

namespace coppice::bake {
namespace {

/// Sides of a card image, and of a material's atlas.
constexpr std::uint32_t kMinCardSide_px = 64, kMaxCardSide_px = 256, kMaxAtlasSide_px = 512;
constexpr std::uint32_t kCardSamples = 4;
constexpr std::uint32_t kHoldSide_px = 64;
constexpr std::uint32_t kSketchSide_px = 8;
constexpr std::uint32_t kSketchSamples = 4;
/// Root mean square difference of two sketches, 0..255, below which one image serves both leaves.
constexpr double kAlike = 16.0;
constexpr int kRefinements = 4;
/// Minimum coverage of a quad by its leaf: a leaf with less was fitted edge-on and would be lost.
constexpr float kMinCoverage = 0.02f;
constexpr float kCardCutoff = 0.5f;
/// How a leaf's outline is measured: samples on each side, and directions.
constexpr std::uint32_t kOutlineSide = 32;
constexpr int kDirections = 16;
/// Maximum error of a flat leaf's fullness: samples miss parts of its edge.
constexpr double kNoise = 0.03;
/// The fullness of a ball: a disc shows half of its area on average, a ball all of it.
constexpr double kMaxFull = 2.0;

/// Maps plant space to a card's image: column and row in samples, and height above its plane.
struct CardFrame {
  glm::dvec3 origin{0.0}, column_per_m{0.0}, row_per_m{0.0}, normal{0.0};
  [[nodiscard]] glm::dvec3 at(const glm::dvec3& point, double size) const {
    const glm::dvec3 arm = point - origin;
    return {glm::dot(arm, column_per_m) * size, glm::dot(arm, row_per_m) * size, glm::dot(arm, normal)};
  }
};

/// The frame of a quad's image: its left edge is the stalk's (corners 3, 0), its rows run from corner 3 to 2.
CardFrame card_frame(const Quad& quad) {
  const glm::dvec3 corner(quad[3]), x = glm::dvec3(quad[2]) - corner, y = glm::dvec3(quad[0]) - corner;
  return {corner, x / glm::dot(x, x), y / glm::dot(y, y), glm::cross(y, x)};
}

/// The material's linear colour and alpha at a texture coordinate.
glm::vec4 color_at(const Material& material, const std::vector<Image>& images, const glm::dvec2& uv) {
  if (material.image == kNone) return material.base_color;
  const std::uint8_t* const texel = texel_at(images[material.image], uv);
  return material.base_color * glm::vec4(linear_color(texel), static_cast<float>(texel[3]) / 255.0f);
}

double cross(const glm::dvec3& a, const glm::dvec3& b) {
  return a.x * b.y - a.y * b.x;
}

/// Samples whose centres lie between the smallest and the largest of three coordinates.
std::array<std::int32_t, 2> range(const std::array<double, 3>& values, std::uint32_t size) {
  const auto [low, high] = std::minmax({values[0], values[1], values[2]});
  const double last = static_cast<double>(size) - 1.0;
  return {static_cast<std::int32_t>(std::clamp(std::ceil(low - 0.5), 0.0, last + 1.0)),
          static_cast<std::int32_t>(std::clamp(std::floor(high - 0.5), -1.0, last))};
}

/// [size * size] The leaf's topmost texel at each sample of a card's image; alpha is 0 where there is none.
std::vector<glm::vec4> draw_samples(const Plant& plant, const LeafRange& leaf, const CardFrame& frame, std::uint32_t size) {
  const Mesh& mesh = plant.foliage;
  std::vector<double> heights(std::size_t{size} * size, -std::numeric_limits<double>::infinity());
  std::vector<glm::vec4> texels(heights.size(), glm::vec4(0.0f));
  for (std::size_t triangle = leaf.first_triangle; triangle < std::size_t{leaf.first_triangle} + leaf.triangle_count; ++triangle) {
    const Material& material = plant.materials[mesh.triangle_materials[triangle]];
    const std::array corners = at_corners(mesh.positions, mesh.indices, 3 * triangle);
    const std::array uvs = at_corners(mesh.uvs, mesh.indices, 3 * triangle);
    std::array<glm::dvec3, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = frame.at(glm::dvec3(corners[i]), size);
    const double area = cross(at[1] - at[0], at[2] - at[0]);
    if (area == 0.0) continue;
    const auto [first_x, last_x] = range({at[0].x, at[1].x, at[2].x}, size);
    const auto [first_y, last_y] = range({at[0].y, at[1].y, at[2].y}, size);
    for (std::int32_t y = first_y; y <= last_y; ++y)
      for (std::int32_t x = first_x; x <= last_x; ++x) {
        const glm::dvec3 point(x + 0.5, y + 0.5, 0.0);
        const glm::dvec3 weight =
            glm::dvec3(cross(at[1] - point, at[2] - point), cross(at[2] - point, at[0] - point), cross(at[0] - point, at[1] - point)) /
            area;
        if (weight.x < 0.0 || weight.y < 0.0 || weight.z < 0.0) continue;
        const double height = weight.x * at[0].z + weight.y * at[1].z + weight.z * at[2].z;
        const std::size_t sample = static_cast<std::size_t>(y) * size + static_cast<std::size_t>(x);
        if (height <= heights[sample]) continue;
        const glm::dvec2 uv = weight.x * glm::dvec2(uvs[0]) + weight.y * glm::dvec2(uvs[1]) + weight.z * glm::dvec2(uvs[2]);
        const glm::vec4 texel = color_at(material, plant.images, uv);
        if (material.alpha_cutoff > 0.0f && texel.a < material.alpha_cutoff) continue;
        heights[sample] = height;
        texels[sample] = glm::vec4(glm::vec3(texel), 1.0f);
      }
  }
  return texels;
}

using Sketch = std::array<std::uint8_t, 4 * std::size_t{kSketchSide_px} * kSketchSide_px>;

/// The part of the quad's rectangle between two points of its image, which may lie outside of it.
Quad crop(const Quad& quad, const glm::dvec2& low, const glm::dvec2& high) {
  const glm::dvec3 corner(quad[3]), x = glm::dvec3(quad[2]) - corner, y = glm::dvec3(quad[0]) - corner;
  const auto at = [&](double column, double row) { return glm::vec3(corner + column * x + row * y); };
  return {at(low.x, high.y), at(high.x, high.y), at(high.x, low.y), at(low.x, low.y)};
}

/// The rectangle in the quad's plane, along the quad's sides, that holds exactly what the leaf shows: a leaf may reach back beyond its
/// stalk, and its texture may leave most of its mesh empty.
Quad hold_leaf(const Plant& plant, const LeafRange& leaf, const Quad& quad) {
  const Mesh& mesh = plant.foliage;
  const CardFrame frame = card_frame(quad);
  PointBox<glm::dvec2> box;
  for (const std::uint32_t vertex : leaf_indices(mesh, leaf)) box.add(glm::dvec2(frame.at(glm::dvec3(mesh.positions[vertex]), 1.0)));
  const Quad held = crop(quad, box.low, box.high);
  const auto materials = std::span(mesh.triangle_materials).subspan(leaf.first_triangle, leaf.triangle_count);
  const bool is_masked = std::ranges::any_of(materials, [&](std::uint32_t material) {
    return plant.materials[material].alpha_cutoff > 0.0f && plant.materials[material].image != kNone;
  });
  if (!is_masked) return held;
  const std::vector<glm::vec4> samples = draw_samples(plant, leaf, card_frame(held), kHoldSide_px);
  PointBox<glm::uvec2> shown;
  for (std::uint32_t y = 0; y < kHoldSide_px; ++y)
    for (std::uint32_t x = 0; x < kHoldSide_px; ++x)
      if (samples[std::size_t{y} * kHoldSide_px + x].a != 0.0f) shown.add({x, y});
  if (shown.low.x > shown.high.x) return held;
  return crop(held, glm::dvec2(shown.low) / double{kHoldSide_px}, glm::dvec2(shown.high + 1u) / double{kHoldSide_px});
}

float coverage(const Sketch& sketch) {
  std::uint32_t sum = 0;
  for (std::size_t i = 3; i < sketch.size(); i += 4) sum += sketch[i];
  return static_cast<float>(sum) / (255.0f * kSketchSide_px * kSketchSide_px);
}

Sketch sketch_leaf(const Plant& plant, const LeafRange& leaf, const Quad& quad) {
  const CardImage image = draw_leaf(plant, leaf, quad, kSketchSide_px, kSketchSamples);
  Sketch sketch{};
  for (std::size_t i = 0; i < image.texels.size(); ++i)
    for (int c = 0; c < 4; ++c)
      sketch[4 * i + static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255.0f * image.texels[i][c]));
  return sketch;
}

std::uint32_t squared_difference(const Sketch& a, const Sketch& b) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const int step = int{a[i]} - int{b[i]};
    sum += static_cast<std::uint32_t>(step * step);
  }
  return sum;
}

/// Clusters of sketches; the medoid's leaf is drawn for all of its cluster.
struct Clusters {
  std::vector<std::size_t> medoids;        ///< indices of sketches
  std::vector<std::uint32_t> cluster_of;   ///< [sketch count] index into medoids
  std::vector<std::uint32_t> differences;  ///< [sketch count] difference to the medoid
};

void assign(const std::vector<Sketch>& sketches, Clusters& clusters) {
  parallel_for(
      sketches.size(),
      [&](std::size_t i) {
        clusters.differences[i] = std::numeric_limits<std::uint32_t>::max();
        for (std::uint32_t m = 0; m < clusters.medoids.size(); ++m) {
          const std::uint32_t difference = squared_difference(sketches[i], sketches[clusters.medoids[m]]);
          if (difference >= clusters.differences[i]) continue;
          clusters.differences[i] = difference;
          clusters.cluster_of[i] = m;
        }
      },
      256);
}

/// The sketch nearest to the mean of a cluster; the first of equals.
std::size_t medoid(const std::vector<Sketch>& sketches, const Clusters& clusters, std::uint32_t cluster) {
  std::vector<std::size_t> members;
  for (std::size_t i = 0; i < sketches.size(); ++i)
    if (clusters.cluster_of[i] == cluster) members.push_back(i);
  if (members.empty()) return clusters.medoids[cluster];  // the same sketch is another medoid
  Sketch mean{};
  for (std::size_t k = 0; k < mean.size(); ++k) {
    std::uint64_t sum = members.size() / 2;
    for (const std::size_t i : members) sum += sketches[i][k];
    mean[k] = static_cast<std::uint8_t>(sum / members.size());
  }
  return *std::ranges::min_element(members, {}, [&](std::size_t i) { return squared_difference(sketches[i], mean); });
}

/// Starts with one cluster, and adds one for the sketch least like its medoid until all are alike. Then medoids move to the middle of their
/// clusters.
Clusters cluster_sketches(const std::vector<Sketch>& sketches) {
  Clusters clusters{{0}, std::vector<std::uint32_t>(sketches.size(), 0), std::vector<std::uint32_t>(sketches.size(), 0)};
  clusters.medoids[0] = medoid(sketches, clusters, 0);
  assign(sketches, clusters);
  const double alike = kAlike * kAlike * Sketch{}.size();
  while (clusters.medoids.size() < kMaxCardImages) {
    const auto farthest = std::max_element(clusters.differences.begin(), clusters.differences.end());
    if (*farthest < alike) break;
    clusters.medoids.push_back(static_cast<std::size_t>(farthest - clusters.differences.begin()));
    assign(sketches, clusters);
  }
  for (int round = 0; round < kRefinements && clusters.medoids.size() > 1; ++round) {
    std::vector<std::size_t> moved;
    for (std::uint32_t m = 0; m < clusters.medoids.size(); ++m) moved.push_back(medoid(sketches, clusters, m));
    if (moved == clusters.medoids) break;
    clusters.medoids = moved;
    assign(sketches, clusters);
  }
  return clusters;
}

/// Whether the quad equals the leaf: each corner is one of the leaf's points.
bool is_exact(const Mesh& mesh, const LeafRange& leaf, const Quad& quad) {
  return std::ranges::all_of(quad, [&](const glm::vec3& corner) {
    return std::ranges::any_of(leaf_indices(mesh, leaf), [&](std::uint32_t vertex) { return mesh.positions[vertex] == corner; });
  });
}

/// The area of the leaf's outline, seen along `direction`.
double outline_m2(const Plant& plant, const LeafRange& leaf, const glm::dvec3& direction, const glm::dvec3& side) {
  const glm::dvec3 x = glm::normalize(side - glm::dot(side, direction) * direction), y = glm::cross(direction, x);
  PointBox<glm::dvec2> box;
  for (const std::uint32_t vertex : leaf_indices(plant.foliage, leaf)) {
    const glm::dvec3 point(plant.foliage.positions[vertex]);
    box.add({glm::dot(point, x), glm::dot(point, y)});
  }
  const glm::dvec2 size = box.extent();
  if (!(size.x > 0.0 && size.y > 0.0)) return 0.0;  // a line from there
  const CardFrame frame{box.low.x * x + box.low.y * y, x / size.x, y / size.y, direction};
  const auto count =
      std::ranges::count_if(draw_samples(plant, leaf, frame, kOutlineSide), [](const glm::vec4& texel) { return texel.a > 0.0f; });
  return size.x * size.y * static_cast<double>(count) / (kOutlineSide * kOutlineSide);
}

/// A square image of tiles whose sides are powers of two: as long as a mip level has a texel per tile, no texel mixes two of them.
struct Atlas {
  std::uint32_t tiles_per_side = 1, tile_px = 0;
  Image image;
  [[nodiscard]] glm::uvec2 origin_px(std::uint32_t tile) const {
    return tile_px * glm::uvec2(tile % tiles_per_side, tile / tiles_per_side);
  }
};

/// source_px  a leaf's length in its own image, texels
Atlas make_atlas(std::uint32_t image_count, std::uint32_t source_px) {
  Atlas atlas;
  while (atlas.tiles_per_side * atlas.tiles_per_side < image_count) atlas.tiles_per_side *= 2;
  const std::uint32_t max_px = std::min(kMaxCardSide_px, kMaxAtlasSide_px / atlas.tiles_per_side);
  atlas.tile_px = std::clamp(std::bit_ceil(source_px), kMinCardSide_px, max_px);
  const std::uint32_t side_px = atlas.tiles_per_side * atlas.tile_px;
  atlas.image = {side_px, side_px, std::vector<std::uint8_t>(4 * std::size_t{side_px} * side_px, 0)};
  return atlas;
}

/// The longer side of what the leaf shows of its material's image, px; kMinCardSide_px without an image.
std::uint32_t source_side_px(const Plant& plant, const LeafRange& leaf, const Material& material) {
  if (material.image == kNone) return kMinCardSide_px;
  PointBox<glm::vec2> box;
  for (const std::uint32_t vertex : leaf_indices(plant.foliage, leaf)) box.add(plant.foliage.uvs[vertex]);
  const Image& image = plant.images[material.image];
  const glm::vec2 size_px = glm::clamp(box.extent(), 0.0f, 1.0f) * glm::vec2(image.width, image.height);
  return static_cast<std::uint32_t>(std::ceil(std::max(size_px.x, size_px.y)));
}

/// Writes a leaf's image into the atlas in sRGB, its colours relative to `base_color`. Holes get the leaf's mean colour, for readers that
/// filter without weighting by alpha.
void paste(const CardImage& image, const glm::vec4& base_color, std::uint32_t tile, Atlas& atlas) {
  const glm::vec4 sum = std::accumulate(image.texels.begin(), image.texels.end(), glm::vec4(0.0f));
  const glm::uvec2 origin = atlas.origin_px(tile);
  for (std::uint32_t y = 0; y < image.side_px; ++y)
    for (std::uint32_t x = 0; x < image.side_px; ++x) {
      const glm::vec4& texel = image.texels[std::size_t{y} * image.side_px + x];
      const glm::vec4 colour = texel.a > 0.0f ? texel / texel.a : sum / std::max(sum.a, 1e-6f);
      std::uint8_t* rgba = atlas.image.rgba.data() + 4 * (std::size_t{origin.y + y} * atlas.image.width + origin.x + x);
      for (int c = 0; c < 3; ++c) {
        const float share = base_color[c] > 0.0f ? std::clamp(colour[c] / base_color[c], 0.0f, 1.0f) : 1.0f;
        rgba[c] = static_cast<std::uint8_t>(std::lround(255.0f * srgb_from_linear(share)));
      }
      rgba[3] = static_cast<std::uint8_t>(std::lround(255.0f * texel.a));
    }
}

/// The tile's uvs for the quad's corners, half a texel inside, so that no filter reaches the neighbour.
Card tile_card(std::uint32_t material, const Atlas& atlas, std::uint32_t tile) {
  const glm::vec2 size(static_cast<float>(atlas.image.width));
  const glm::vec2 low = (glm::vec2(atlas.origin_px(tile)) + 0.5f) / size;
  const glm::vec2 high = (glm::vec2(atlas.origin_px(tile) + atlas.tile_px) - 0.5f) / size;
  return {material, {{{low.x, high.y}, {high.x, high.y}, {high.x, low.y}, {low.x, low.y}}}};
}

struct DrawnLeaves {
  std::vector<std::size_t> leaves;
  std::vector<Sketch> sketches;
};

/// [cluster] The mean fullness of some of its leaves, spread over it: leaves that look alike bend alike.
std::vector<double> mean_fullness(const Plant& plant, const DrawnLeaves& drawn, const Clusters& clusters,
                                  std::span<const FittedLeaf> fitted) {
  constexpr std::size_t kMaxLeaves = 16;
  std::vector<std::vector<std::size_t>> members(clusters.medoids.size());
  for (std::size_t i = 0; i < drawn.leaves.size(); ++i) members[clusters.cluster_of[i]].push_back(drawn.leaves[i]);
  std::vector<double> means;
  for (const std::vector<std::size_t>& leaves : members) {
    const std::size_t count = std::min(leaves.size(), kMaxLeaves);
    double sum = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t leaf = leaves[k * leaves.size() / count];
      sum += fullness(plant, plant.leaves[leaf], fitted[leaf].quad);
    }
    means.push_back(count > 0 ? sum / static_cast<double>(count) : 1.0);
  }
  return means;
}

Quad scaled(const Quad& quad, double scale) {
  const glm::vec3 middle = 0.25f * (quad[0] + quad[1] + quad[2] + quad[3]);
  Quad result;
  for (std::size_t k = 0; k < 4; ++k) result[k] = middle + static_cast<float>(scale) * (quad[k] - middle);
  return result;
}

void draw_material(Plant& plant, std::uint32_t material, const DrawnLeaves& drawn, std::span<FittedLeaf> fitted) {
  const Clusters clusters = cluster_sketches(drawn.sketches);
  Material card_material = plant.materials[material];
  const std::size_t first = drawn.leaves[clusters.medoids[0]];
  Atlas atlas = make_atlas(static_cast<std::uint32_t>(clusters.medoids.size()), source_side_px(plant, plant.leaves[first], card_material));
  for (std::uint32_t tile = 0; tile < clusters.medoids.size(); ++tile) {
    const std::size_t leaf = drawn.leaves[clusters.medoids[tile]];
    paste(draw_leaf(plant, plant.leaves[leaf], fitted[leaf].quad, atlas.tile_px, kCardSamples), card_material.base_color, tile, atlas);
  }
  card_material.image = static_cast<std::uint32_t>(plant.images.size());
  card_material.alpha_cutoff = kCardCutoff;
  card_material.base_color.a = 1.0f;
  card_material.normal_map = kNone;
  const auto number = static_cast<std::uint32_t>(plant.materials.size());
  const std::vector<double> means = mean_fullness(plant, drawn, clusters, fitted);
  for (std::size_t i = 0; i < drawn.leaves.size(); ++i) {
    FittedLeaf& leaf = fitted[drawn.leaves[i]];
    leaf.card = tile_card(number, atlas, clusters.cluster_of[i]);
    leaf.quad = scaled(leaf.quad, std::sqrt(means[clusters.cluster_of[i]]));
  }
  plant.materials.push_back(std::move(card_material));
  plant.images.push_back(std::move(atlas.image));
}

void draw_leaf_cards(Plant& plant, std::span<FittedLeaf> fitted) {
  std::vector<Sketch> sketches(fitted.size());
  std::vector<std::uint8_t> is_drawn(fitted.size(), 0);
  parallel_for(
      fitted.size(),
      [&](std::size_t i) {
        if (is_exact(plant.foliage, plant.leaves[i], fitted[i].quad)) return;
        const Quad held = hold_leaf(plant, plant.leaves[i], fitted[i].quad);
        sketches[i] = sketch_leaf(plant, plant.leaves[i], held);
        if (coverage(sketches[i]) < kMinCoverage) return;
        fitted[i].quad = held;
        is_drawn[i] = 1;
      },
      16);
  std::vector<DrawnLeaves> by_material(plant.materials.size());
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    if (is_drawn[i] == 0) continue;
    by_material[fitted[i].card.material].leaves.push_back(i);
    by_material[fitted[i].card.material].sketches.push_back(sketches[i]);
  }
  for (std::uint32_t m = 0; m < by_material.size(); ++m) {
    if (by_material[m].leaves.empty()) continue;
    if (plant.materials.size() >= COPPICE_MAX_MATERIALS || plant.images.size() >= COPPICE_MAX_TEXTURES) return;
    draw_material(plant, m, by_material[m], fitted);
  }
}

}  // namespace

CardImage draw_leaf(const Plant& plant, const LeafRange& leaf, const Quad& quad, std::uint32_t side_px, std::uint32_t samples) {
  const std::uint32_t side = side_px * samples;
  const std::vector<glm::vec4> texels = draw_samples(plant, leaf, card_frame(quad), side);
  CardImage image{side_px, std::vector<glm::vec4>(std::size_t{side_px} * side_px, glm::vec4(0.0f))};
  const float share = 1.0f / static_cast<float>(samples * samples);
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x)
      image.texels[std::size_t{y / samples} * side_px + x / samples] += share * texels[std::size_t{y} * side + x];
  return image;
}

double fullness(const Plant& plant, const LeafRange& leaf, const Quad& quad) {
  const glm::dvec3 x = glm::normalize(glm::dvec3(quad[2]) - glm::dvec3(quad[3])),
                   normal = glm::normalize(glm::cross(x, glm::dvec3(quad[0]) - glm::dvec3(quad[3]))), y = glm::cross(normal, x);
  const double flat_m2 = outline_m2(plant, leaf, normal, x);
  double shown_m2 = 0.0, flat_shown_m2 = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    // Spreads directions evenly over the half sphere: equal steps of height, turned by the golden angle.
    const double height = (i + 0.5) / kDirections, turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double radius = std::sqrt(1.0 - height * height);
    const glm::dvec3 direction = radius * std::cos(turn) * x + radius * std::sin(turn) * y + height * normal;
    shown_m2 += outline_m2(plant, leaf, direction, x);
    flat_shown_m2 += flat_m2 * height;
  }
  if (!(flat_shown_m2 > 0.0)) return 1.0;
  const double ratio = shown_m2 / flat_shown_m2;
  return ratio < 1.0 + kNoise ? 1.0 : std::min(ratio, kMaxFull);
}

Result<Foliage> card_foliage(Plant& plant) {
  find_sided_normals(plant);
  COPPICE_TRY(fitted, fit_leaves(plant, LeafPlane::shown));
  draw_leaf_cards(plant, fitted);
  Foliage foliage = share_leaf_cards(fitted, plant.materials);
  add_leaf_normals(plant, foliage);
  return foliage;
}

}  // namespace coppice::bake
