#include "baked_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <webp/encode.h>
#include <glm/geometric.hpp>

#include "alpha_mask.h"
#include "leaf_shade.h"
#include "plant.h"
#include "plant_painter.h"
#include "srgb.h"
#include "tree.h"
#include "tree_order.h"
#include "unpack.h"
#include "viewpoints.h"

namespace coppice::bake {
namespace {

constexpr std::uint32_t kNearSamples = 3, kFarSamples = 6;  ///< a pixel and side
constexpr float kThreshold_px = 2.0f;                       ///< the runtime's default
constexpr float kWebpQuality = 80.0f;
constexpr glm::vec3 kBackground(0.68f, 0.74f, 0.8f);  ///< linear: white flowers are seen before it, and dark needles
constexpr float kAmbient = 0.4f;

/// The column of a table for a size, the next larger one where it lies between two: no finer than what is drawn there.
std::size_t column_of(const ErrorTable& errors, float size_px) {
  const auto found = std::ranges::lower_bound(errors.sizes_px, size_px);
  return static_cast<std::size_t>(std::min(found, errors.sizes_px.end() - 1) - errors.sizes_px.begin());
}

/// A plant with as many of its leaves as are to be seen.
class Picture {
 public:
  Picture(const BakedPlant& plant, std::uint32_t size_px, std::uint32_t samples)
      : plant_(plant),
        size_px_(size_px),
        samples_(samples),
        view_(viewpoint_towards(glm::normalize(glm::vec3(0.4f, 0.25f, 1.0f)))),
        sun_(glm::normalize(glm::vec3(0.9f, 1.1f, 0.6f))),
        painter_(plant.materials, plant.images, view_, plant.sphere, size_px * samples, kBackground) {}

  /// Wood lets no light through.
  void draw_wood(const Mesh& mesh) {
    for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
      const PaintedTriangle triangle = painted_triangle(mesh, t);
      paint(triangle, light(face_normals(triangle), 0.0f), kOpaque, t);
    }
  }

  /// Leaves as they were modelled.
  void draw_leaves(const Mesh& mesh) {
    for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
      const PaintedTriangle triangle = painted_triangle(mesh, t);
      ShadingNormals normals = face_normals(triangle);
      if (plant_.materials[triangle.material].sided_normals) {
        const auto& [a, b, c] = at_corners(mesh.normals, mesh.indices, 3 * t);
        normals = {axis_along(a + b + c), 1.0f, true};
      }
      paint(triangle, light(normals, kTranslucency), kOpaque, t);
    }
  }

  void draw_cut(std::uint32_t leaf_count) {
    const Tree& tree = plant_.tree;
    for (std::uint32_t node = 0; node < 2 * leaf_count - 1; ++node) {
      if (tree.node_split[node] < leaf_count - 1) continue;
      const Card& card = plant_.card_table[tree.nodes[node].card];
      const float leaf_light = light(shading_normals(tree.nodes[node].normals, node_quad(tree, node)), kTranslucency);
      for (const std::array<std::size_t, 3>& corners : {std::array<std::size_t, 3>{0, 1, 2}, std::array<std::size_t, 3>{0, 2, 3}}) {
        PaintedTriangle triangle;
        for (std::size_t k = 0; k < 3; ++k) {
          triangle.points[k] = tree.vertices[tree.nodes[node].vertices[corners[k]]];
          triangle.uvs[k] = card.uv[corners[k]];
        }
        triangle.material = card.material;
        paint(triangle, leaf_light, tree.nodes[node].opacity, node);
      }
    }
  }

  /// Into the picture, whose rows hold `width` pixels, from (x, y) on.
  void copy(std::vector<std::uint8_t>& rgb, std::size_t width, std::size_t x, std::size_t y) const {
    const std::vector<glm::vec3> colors = shrunk_picture(painter_.colors(), size_px_ * samples_, samples_);
    for (std::size_t row = 0; row < size_px_; ++row)
      for (std::size_t column = 0; column < size_px_; ++column)
        for (int c = 0; c < 3; ++c)
          rgb[3 * ((y + row) * width + x + column) + static_cast<std::size_t>(c)] =
              static_cast<std::uint8_t>(std::lround(255.0f * srgb_from_linear(std::min(colors[row * size_px_ + column][c], 1.0f))));
  }

 private:
  /// Unit, or 0.
  static std::array<float, 3> axis_along(const glm::vec3& direction) {
    const float length = glm::length(direction);
    const glm::vec3 axis = length > 0.0f ? direction / length : glm::vec3(0.0f);
    return {axis.x, axis.y, axis.z};
  }

  static ShadingNormals face_normals(const PaintedTriangle& triangle) {
    const auto& [a, b, c] = triangle.points;
    return {axis_along(glm::cross(b - a, c - a)), 1.0f, false};
  }

  [[nodiscard]] float light(const ShadingNormals& normals, float translucency) const {
    return kAmbient + (1.0f - kAmbient) * leaf_cosine(normals, sun_, view_.direction, translucency);
  }

  /// Whether a leaf of an opacity leaves a sample to what is behind it: the gaps between the leaves that it stands for.
  static bool is_gap(std::uint8_t opacity, std::size_t leaf, std::size_t sample) {
    const std::uint64_t hash = (leaf * 0x9e3779b97f4a7c15u) ^ (sample * 0xc2b2ae3d27d4eb4fu);
    return ((hash ^ (hash >> 29)) * 0xbf58476d1ce4e5b9u >> 60) < transparency_of(opacity);
  }

  void paint(const PaintedTriangle& triangle, float lit, std::uint8_t opacity, std::size_t leaf) {
    const Material& material = plant_.materials[triangle.material];
    const glm::vec3 factor = lit * glm::vec3(material.base_color);
    const Image* const image = material.image == kNone ? nullptr : &plant_.images[material.image];
    const auto color = [&](const glm::dvec2& uv) {
      if (image == nullptr) return factor;
      return factor * linear_color(texel_at(*image, uv));
    };
    painter_.paint(
        triangle, [&](std::size_t sample) { return is_gap(opacity, leaf, sample); }, color);
  }

  const BakedPlant& plant_;
  std::uint32_t size_px_, samples_;
  Viewpoint view_;
  glm::vec3 sun_;
  PlantPainter painter_;
};

void draw_near(const BakedPlant& plant, Picture& picture) {
  if (!plant.wood.lods.empty()) picture.draw_wood(plant.wood.lods.front());
  for (const LeafMeshPart& part : plant.leaf_meshes.parts) picture.draw_leaves(part.mesh);
  if (plant.leaf_meshes.parts.empty()) picture.draw_cut(plant.tree.leaf_count());
}

void draw_far(const BakedPlant& plant, Picture& picture) {
  const ErrorTable& errors = plant.errors;
  const std::size_t sizes = errors.sizes_px.size(), column = column_of(errors, static_cast<float>(kFarPicturePx));
  std::uint32_t leaf_count = plant.tree.leaf_count();
  for (std::size_t level = errors.leaf_counts.size(); level-- > 0;)
    if (errors.error_px[level * sizes + column] <= kThreshold_px) leaf_count = errors.leaf_counts[level];
  picture.draw_cut(leaf_count);
  std::size_t lod = plant.wood.lods.size();
  while (lod > 1 && plant.wood.error_px[(lod - 1) * sizes + column] > kThreshold_px) --lod;
  if (lod > 0) picture.draw_wood(plant.wood.lods[lod - 1]);
}

Result<std::vector<std::uint8_t>> webp_of(const std::vector<std::uint8_t>& rgb, std::size_t width, std::size_t height) {
  std::uint8_t* bytes = nullptr;
  const auto stride = static_cast<int>(3 * width);
  const std::size_t size = WebPEncodeRGB(rgb.data(), static_cast<int>(width), static_cast<int>(height), stride, kWebpQuality, &bytes);
  if (size == 0) return Error{Status::internal, "the picture of the baked plant cannot be encoded as WebP"};
  std::vector<std::uint8_t> file(bytes, bytes + size);
  WebPFree(bytes);
  return file;
}

}  // namespace

Result<std::vector<std::uint8_t>> baked_picture(std::span<const std::uint8_t> file) {
  COPPICE_TRY(plant, unpack(file));
  constexpr std::size_t kWidth = kNearPicturePx + kFarPicturePx, kHeight = kNearPicturePx;
  std::vector<std::uint8_t> rgb;
  for (std::size_t pixel = 0; pixel < kWidth * kHeight; ++pixel)
    for (int c = 0; c < 3; ++c) rgb.push_back(static_cast<std::uint8_t>(std::lround(255.0f * srgb_from_linear(kBackground[c]))));
  Picture near(plant, kNearPicturePx, kNearSamples), far(plant, kFarPicturePx, kFarSamples);
  draw_near(plant, near);
  draw_far(plant, far);
  near.copy(rgb, kWidth, 0, 0);
  far.copy(rgb, kWidth, kNearPicturePx, kNearPicturePx - kFarPicturePx);
  return webp_of(rgb, kWidth, kHeight);
}

}  // namespace coppice::bake
