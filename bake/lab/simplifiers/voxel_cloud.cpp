#include "voxel_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "card_coverage.h"
#include "quad_merge.h"
#include "united_leaf.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

constexpr int kFlakeSteps = 8;
constexpr std::uint32_t kMaxCells = 1024;  // ten bits

struct Flake {
  glm::dvec3 point{0.0};
  float area_m2 = 0.0f;
  std::uint32_t normal = 0, material = 0;
};

std::uint32_t nearest_normal(const glm::dvec3& normal) {
  std::uint32_t best = 0;
  for (std::uint32_t i = 1; i < kVoxelNormalCount; ++i)
    if (std::abs(glm::dot(voxel_normals()[i], normal)) > std::abs(glm::dot(voxel_normals()[best], normal))) best = i;
  return best;
}

Result<std::vector<Flake>> flakes_of(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images) {
  COPPICE_TRY(masks, alpha_masks(materials, images));
  std::vector<Flake> flakes;
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) {
    const Quad& quad = foliage.quads[leaf];
    const Card& card = foliage.card_table[foliage.cards[leaf]];
    Flake flake{{}, static_cast<float>(quad_area(quad) / (kFlakeSteps * kFlakeSteps)), nearest_normal(quad_normal(quad)), card.material};
    for (int y = 0; y < kFlakeSteps; ++y)
      for (int x = 0; x < kFlakeSteps; ++x) {
        const double s = (x + 0.5) / kFlakeSteps, t = (y + 0.5) / kFlakeSteps;
        if (masks[card.material].is_hole(card_point(card, s, t))) continue;
        flake.point = quad_point(quad, s, t);
        flakes.push_back(flake);
      }
  }
  return flakes;
}

struct Box {
  glm::dvec3 low{0.0};
  double side_m = 0.0;
};

Box box_of(const Foliage& foliage) {
  glm::dvec3 low(foliage.quads[0][0]), high = low;
  for (const Quad& quad : foliage.quads)
    for (const glm::vec3& corner : quad) {
      low = glm::min(low, glm::dvec3(corner));
      high = glm::max(high, glm::dvec3(corner));
    }
  const glm::dvec3 size = high - low;
  return {low, std::max({size.x, size.y, size.z})};
}

/// Makes voxels in the order of cells, whatever the order of flakes. A voxel shows the material with most of its area.
std::vector<Voxel> voxels_of(const std::vector<Flake>& flakes, const Box& box, std::uint32_t cells) {
  struct Cell {
    std::array<float, kVoxelNormalCount> area_m2{};
    std::map<std::uint32_t, float> by_material;
  };
  std::map<std::array<std::uint32_t, 3>, Cell> filled;
  for (const Flake& flake : flakes) {
    std::array<std::uint32_t, 3> place{};
    for (int axis = 0; axis < 3; ++axis)
      place[static_cast<std::size_t>(axis)] =
          std::min(cells - 1, static_cast<std::uint32_t>(std::max(0.0, (flake.point[axis] - box.low[axis]) / box.side_m * cells)));
    Cell& cell = filled[place];
    cell.area_m2[flake.normal] += flake.area_m2;
    cell.by_material[flake.material] += flake.area_m2;
  }
  const double side_m = box.side_m / cells;
  std::vector<Voxel> voxels;
  for (const auto& [place, cell] : filled) {
    Voxel voxel{glm::vec3(box.low + side_m * (glm::dvec3(place[0], place[1], place[2]) + 0.5)), static_cast<float>(0.5 * side_m), 0,
                cell.area_m2};
    const auto largest = std::ranges::max_element(cell.by_material, {}, [](const auto& item) { return item.second; });
    voxel.material = largest->first;
    voxels.push_back(voxel);
  }
  return voxels;
}

/// Fills the finest grid with at most `max_count` voxels; one voxel if there is none.
std::vector<Voxel> finest(const std::vector<Flake>& flakes, const Box& box, std::uint32_t max_count) {
  std::uint32_t low = 1, high = kMaxCells;
  std::vector<Voxel> best = voxels_of(flakes, box, 1);
  while (low < high) {
    const std::uint32_t middle = (low + high + 1) / 2;
    std::vector<Voxel> voxels = voxels_of(flakes, box, middle);
    if (voxels.size() > max_count) {
      high = middle - 1;
    } else {
      low = middle;
      best = std::move(voxels);
    }
  }
  return best;
}

}  // namespace

Result<std::vector<Voxel>> fill_voxels(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                       std::uint32_t cells) {
  COPPICE_TRY(flakes, flakes_of(foliage, materials, images));
  return voxels_of(flakes, box_of(foliage), cells);
}

Result<std::vector<Variant>> voxel_cloud(const Foliage& foliage, const std::vector<Material>& materials, const std::vector<Image>& images,
                                         const std::vector<std::uint32_t>& leaf_counts) {
  COPPICE_TRY(flakes, flakes_of(foliage, materials, images));
  const Box box = box_of(foliage);
  std::vector<std::vector<Voxel>> clouds;
  clouds.reserve(leaf_counts.size());
  for (const std::uint32_t count : leaf_counts)
    clouds.push_back(finest(flakes, box, static_cast<std::uint32_t>(std::uint64_t{count} * kLeafBytes / kVoxelBytes)));
  std::vector<Variant> variants;
  for (const float share : {0.25f, 0.35f, 0.5f, 0.7f, 0.85f, 1.0f, 1.25f}) {
    Variant variant{"area x " + std::to_string(share).substr(0, 4), {}};
    for (std::vector<Voxel> voxels : clouds) {
      for (Voxel& voxel : voxels)
        for (float& area : voxel.area_m2) area *= share;
      variant.levels.push_back(Level{{}, {}, {}, std::move(voxels)});
    }
    variants.push_back(std::move(variant));
  }
  return variants;
}

}  // namespace coppice::bake
