#include "leaf_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "alpha_mask.h"

namespace coppice::bake {
namespace {

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

}  // namespace

CardFrame card_frame(const Quad& quad) {
  const glm::dvec3 corner(quad[3]), x = glm::dvec3(quad[2]) - corner, y = glm::dvec3(quad[0]) - corner;
  return {corner, x / glm::dot(x, x), y / glm::dot(y, y), glm::cross(y, x)};
}

void LeafCanvas::draw(std::size_t triangle) {
  const Mesh& mesh = plant_.foliage;
  const Material& material = plant_.materials[mesh.triangle_materials[triangle]];
  const std::array corners = at_corners(mesh.positions, mesh.indices, 3 * triangle);
  const std::array uvs = at_corners(mesh.uvs, mesh.indices, 3 * triangle);
  std::array<glm::dvec3, 3> at;
  for (std::size_t i = 0; i < 3; ++i) at[i] = frame_.at(glm::dvec3(corners[i]), size_);
  const double area = cross(at[1] - at[0], at[2] - at[0]);
  if (area == 0.0) return;
  const auto [first_x, last_x] = range({at[0].x, at[1].x, at[2].x}, size_);
  const auto [first_y, last_y] = range({at[0].y, at[1].y, at[2].y}, size_);
  for (std::int32_t y = first_y; y <= last_y; ++y)
    for (std::int32_t x = first_x; x <= last_x; ++x) {
      const glm::dvec3 point(x + 0.5, y + 0.5, 0.0);
      const glm::dvec3 weight =
          glm::dvec3(cross(at[1] - point, at[2] - point), cross(at[2] - point, at[0] - point), cross(at[0] - point, at[1] - point)) / area;
      if (weight.x < 0.0 || weight.y < 0.0 || weight.z < 0.0) continue;
      const double height = weight.x * at[0].z + weight.y * at[1].z + weight.z * at[2].z;
      const std::size_t sample = static_cast<std::size_t>(y) * size_ + static_cast<std::size_t>(x);
      if (height <= heights_[sample]) continue;
      const glm::dvec2 uv = weight.x * glm::dvec2(uvs[0]) + weight.y * glm::dvec2(uvs[1]) + weight.z * glm::dvec2(uvs[2]);
      const glm::vec4 texel = color_at(material, plant_.images, uv);
      if (material.alpha_cutoff > 0.0f && texel.a < material.alpha_cutoff) continue;
      heights_[sample] = height;
      texels_[sample] = glm::vec4(glm::vec3(texel), 1.0f);
    }
}

}  // namespace coppice::bake
