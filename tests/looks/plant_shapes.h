#pragma once

// What plants are made of in code: tubes and cards with texture coordinates and normals, and materials with painted images.

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "gltf_builder.h"

namespace coppice::test {

struct Shape {
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec2> uvs;
  std::vector<std::uint32_t> indices;
};

/// A part of an image: v grows downwards.
struct UvBox {
  glm::vec2 low{0.0f}, high{1.0f};
};

/// Open at both ends. u goes round it, v up.
struct Tube {
  glm::vec3 from{0.0f}, to{0.0f, 1.0f, 0.0f};
  float from_radius_m = 0.1f, to_radius_m = 0.05f;
  std::uint32_t sides = 10;
  UvBox uvs;
};
void add_tube(Shape& shape, const Tube& tube);

/// A rectangle: the image stands upright with its lower left corner at `corner`, its height along `up` and its width along `right`.
void add_card(Shape& shape, const glm::vec3& corner, const glm::vec3& right, const glm::vec3& up, const UvBox& uvs = {});

using Rgba = std::array<std::uint8_t, 4>;
/// A PNG of what `paint` says at the middle of each texel, u and v in 0..1.
std::vector<std::uint8_t> painted_png(int width, int height, const std::function<Rgba(float u, float v)>& paint);
/// A normal map's texel.
Rgba normal_texel(const glm::vec3& normal);

struct Surface {
  std::string name;
  glm::vec4 base_color{1.0f};                 ///< linear
  std::vector<std::uint8_t> image = {};       ///< PNG; none: base_color alone
  std::vector<std::uint8_t> normal_map = {};  ///< likewise
  float alpha_cutoff = 0.0f;                  ///< 0: opaque
};
/// Double-sided. Returns the material.
int add_surface(GltfBuilder& builder, const Surface& surface);

/// As a mesh of its own on a node of its own. Returns the node.
int add_shape(GltfBuilder& builder, const Shape& shape, int material, const std::string& node_name = {});

}  // namespace coppice::test
