#pragma once

#include <cstdint>
#include <span>

#include <glm/vec2.hpp>

#include "bounds.h"
#include "plant.h"

namespace coppice::bake {

/// Bounds of some texture coordinates.
using UvBounds = PointBox<glm::dvec2>;

/// Texels [first, last) of an image.
struct TextureRegion {
  glm::uvec2 first{0}, last{0};
  [[nodiscard]] glm::uvec2 size() const { return last - first; }
  [[nodiscard]] std::uint64_t texels() const { return std::uint64_t{size().x} * size().y; }
};

/// The texels of an image that such coordinates show, with a margin of one texel. Along an axis on which they span several periods it is
/// all texels.
TextureRegion texture_region(const UvBounds& bounds, const Image& image);

/// Gives each material the part of its image that its triangles show, as an image of its own, and measures what they show of it
/// (Image::shown). Artists put bark, leaves and the white paper between them into one image. From afar, where a pixel is many texels, a
/// leaf must not take on bark and paper, nor a trunk the mean of everything.
///
/// A material gets an image of its own if that drops a quarter of the image or more, or if another material shows other colours of it;
/// normal maps are cut alike. Same plant, same result.
/// plant  foliage, wood, materials and images change; images that no material names any more are dropped
void cut_texture_regions(Plant& plant);

/// Moves texture coordinates that lie far from 0 near it by whole numbers. Textures repeat, so that all looks the same; but cards and the
/// file hold few places of a texture, for which thousands of repetitions are too many. The vertices of a leaf, and of triangles that share
/// some, move together.
void bring_uvs_near_zero(Mesh& mesh, std::span<const LeafRange> leaves);

/// Drops materials that no card, leaf mesh or wood uses, and images that no material uses, and renumbers the rest.
void drop_unused_materials(BakedPlant& plant);

}  // namespace coppice::bake
