#include "held_out_error.h"

#include <cmath>

#include <glm/geometric.hpp>

#include "alpha_mask.h"
#include "bounds.h"
#include "viewpoints.h"

namespace coppice::test {
namespace {

constexpr std::uint32_t kSizePx = 256;
constexpr float kWhite = 255.0f;

/// Mean linear luminance of what a material shows.
float albedo_of(const bake::Material& material, const std::vector<bake::Image>& images) {
  const glm::vec3 factor(material.base_color);
  if (material.image == bake::kNone) return glm::dot(factor, glm::vec3(0.2126f, 0.7152f, 0.0722f));
  glm::dvec3 sum(0.0);
  double count = 0.0;
  const std::vector<std::uint8_t>& rgba = images[material.image].rgba;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    if (static_cast<float>(rgba[i + 3]) / 255.0f * material.base_color.a < material.alpha_cutoff) continue;
    for (int c = 0; c < 3; ++c) sum[c] += std::pow(rgba[i + static_cast<std::size_t>(c)] / 255.0, 2.2);
    ++count;
  }
  return count == 0.0 ? 0.0f : glm::dot(glm::vec3(sum / count) * factor, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

float shade(const bake::Quad& quad, float albedo) {
  const glm::vec3 light = glm::normalize(glm::vec3(-0.5f, 0.7f, 0.3f));
  const glm::vec3 normal = glm::cross(quad[2] - quad[0], quad[3] - quad[1]);
  const float length = glm::length(normal);
  const float cosine = length > 0.0f ? std::abs(glm::dot(normal, light)) / length : 0.0f;
  return kWhite * std::pow(std::min(1.0f, albedo * (0.3f + 0.7f * cosine)), 1.0f / 2.2f);
}

/// Sum of squared differences of the two images, averaged over blocks of side_px.
double squared_error(const std::vector<float>& a, const std::vector<float>& b, std::uint32_t side_px) {
  double total = 0.0;
  for (std::uint32_t top = 0; top < kSizePx; top += side_px) {
    for (std::uint32_t left = 0; left < kSizePx; left += side_px) {
      double difference = 0.0;
      for (std::uint32_t y = top; y < top + side_px; ++y)
        for (std::uint32_t x = left; x < left + side_px; ++x) difference += double{a[y * kSizePx + x]} - double{b[y * kSizePx + x]};
      difference /= double(side_px) * side_px;
      total += difference * difference;
    }
  }
  return total * side_px * side_px / (double(kSizePx) * kSizePx);
}

}  // namespace

HeldOutViews::HeldOutViews(const bake::Foliage& source, const bake::Plant& plant)
    : masks_(*bake::alpha_masks(plant.materials, plant.images)) {
  for (const bake::Material& material : plant.materials) albedo_.push_back(albedo_of(material, plant.images));
  const bake::Sphere sphere = bake::bounding_sphere(source);
  // A rotation by the unit quaternion (1, 2, 3, 4) / sqrt(30).
  const std::vector<bake::Viewpoint> views = *bake::viewpoints(24);
  for (const bake::Viewpoint& view : views) {
    const glm::vec3 axis(2.0f, 3.0f, 4.0f);
    const glm::vec3 t = glm::cross(axis, view.direction) * (2.0f / 30.0f);
    const glm::vec3 turned = view.direction + t * 1.0f + glm::cross(axis, t);
    projections_.push_back(bake::make_projection(bake::viewpoint_towards(glm::normalize(turned)), sphere, kSizePx));
    source_.push_back(render(source, projections_.back()));
  }
}

HeldOutViews::Picture HeldOutViews::render(const bake::Foliage& foliage, const bake::Projection& projection) const {
  Picture picture{std::vector<float>(std::size_t{kSizePx} * kSizePx, kWhite), 0};
  std::vector<std::uint32_t> depths(picture.luminance.size(), 0xffffffffu);
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf) {
    const bake::Card& card = foliage.card_table[foliage.cards[leaf]];
    const float value = shade(foliage.quads[leaf], albedo_[card.material]);
    bake::rasterise_leaf(bake::project(projection, foliage.quads[leaf]), card, masks_[card.material], kSizePx,
                         [&](const bake::QuadFragment& fragment) {
                           const auto pixel = static_cast<std::size_t>(fragment.y) * kSizePx + static_cast<std::size_t>(fragment.x);
                           if (fragment.depth >= depths[pixel]) return;
                           if (depths[pixel] == 0xffffffffu) ++picture.covered_px;
                           depths[pixel] = fragment.depth;
                           picture.luminance[pixel] = value;
                         });
  }
  return picture;
}

HeldOutErrors HeldOutViews::errors_of(const bake::Foliage& cut) const {
  HeldOutErrors sums;
  double covered = 0.0, source_covered = 0.0;
  for (std::size_t v = 0; v < projections_.size(); ++v) {
    const Picture picture = render(cut, projections_[v]);
    sums.rmse_256 += squared_error(picture.luminance, source_[v].luminance, 1);
    sums.rmse_64 += squared_error(picture.luminance, source_[v].luminance, 4);
    sums.rmse_16 += squared_error(picture.luminance, source_[v].luminance, 16);
    covered += picture.covered_px;
    source_covered += source_[v].covered_px;
  }
  const auto root = [&](double sum) { return std::sqrt(sum / static_cast<double>(projections_.size())); };
  return {root(sums.rmse_256), root(sums.rmse_64), root(sums.rmse_16), covered / source_covered};
}

}  // namespace coppice::test
