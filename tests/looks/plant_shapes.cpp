#include "plant_shapes.h"

#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace coppice::test {
namespace {

int add_texture(GltfBuilder& builder, std::span<const std::uint8_t> png) {
  builder.json["images"].push_back({{"bufferView", builder.add_view(png)}, {"mimeType", "image/png"}});
  builder.json["textures"].push_back({{"source", builder.json["images"].size() - 1}});
  return static_cast<int>(builder.json["textures"].size()) - 1;
}

}  // namespace

void add_tube(Shape& shape, const Tube& tube) {
  const glm::vec3 axis = glm::normalize(tube.to - tube.from);
  const glm::vec3 aside = glm::normalize(glm::cross(axis, std::abs(axis.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0)));
  const glm::vec3 other = glm::cross(axis, aside);
  const auto first = static_cast<std::uint32_t>(shape.positions.size());
  for (std::uint32_t side = 0; side <= tube.sides; ++side) {
    const float share = static_cast<float>(side) / static_cast<float>(tube.sides), angle = 6.2831853f * share;
    const glm::vec3 out = std::cos(angle) * aside + std::sin(angle) * other;
    for (const float along : {0.0f, 1.0f}) {
      shape.positions.push_back(glm::mix(tube.from, tube.to, along) + glm::mix(tube.from_radius_m, tube.to_radius_m, along) * out);
      shape.normals.push_back(out);
      shape.uvs.push_back(glm::mix(tube.uvs.low, tube.uvs.high, glm::vec2(share, 1.0f - along)));
    }
    if (side == tube.sides) break;
    const std::uint32_t low = first + 2 * side;
    for (const std::uint32_t corner : {0u, 1u, 2u, 2u, 1u, 3u}) shape.indices.push_back(low + corner);
  }
}

void add_card(Shape& shape, const glm::vec3& corner, const glm::vec3& right, const glm::vec3& up, const UvBox& uvs) {
  const auto first = static_cast<std::uint32_t>(shape.positions.size());
  const glm::vec3 normal = glm::normalize(glm::cross(right, up));
  for (const glm::vec2& at : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
    shape.positions.push_back(corner + at.x * right + at.y * up);
    shape.normals.push_back(normal);
    shape.uvs.push_back(glm::mix(uvs.low, uvs.high, glm::vec2(at.x, 1.0f - at.y)));
  }
  for (const std::uint32_t index : {0u, 1u, 2u, 0u, 2u, 3u}) shape.indices.push_back(first + index);
}

std::vector<std::uint8_t> painted_png(int width, int height, const std::function<Rgba(float u, float v)>& paint) {
  std::vector<std::uint8_t> rgba;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Rgba texel =
          paint((static_cast<float>(x) + 0.5f) / static_cast<float>(width), (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
      rgba.insert(rgba.end(), texel.begin(), texel.end());
    }
  return encode_png(rgba, width, height);
}

Rgba normal_texel(const glm::vec3& normal) {
  const glm::vec3 packed = glm::round(127.5f * (glm::normalize(normal) + 1.0f));
  return {static_cast<std::uint8_t>(packed.x), static_cast<std::uint8_t>(packed.y), static_cast<std::uint8_t>(packed.z), 255};
}

int add_surface(GltfBuilder& builder, const Surface& surface) {
  const int index = builder.add_material(surface.name);
  nlohmann::json& material = builder.json["materials"][static_cast<std::size_t>(index)];
  material["doubleSided"] = true;
  const glm::vec4& color = surface.base_color;
  material["pbrMetallicRoughness"]["baseColorFactor"] = {color.r, color.g, color.b, color.a};
  if (!surface.image.empty()) material["pbrMetallicRoughness"]["baseColorTexture"]["index"] = add_texture(builder, surface.image);
  if (!surface.normal_map.empty()) material["normalTexture"]["index"] = add_texture(builder, surface.normal_map);
  if (surface.alpha_cutoff > 0.0f) {
    material["alphaMode"] = "MASK";
    material["alphaCutoff"] = surface.alpha_cutoff;
  }
  return index;
}

int add_shape(GltfBuilder& builder, const Shape& shape, int material, const std::string& node_name) {
  const nlohmann::json attributes{{"POSITION", builder.add_positions(shape.positions)},
                                  {"NORMAL", builder.add_positions(shape.normals)},
                                  {"TEXCOORD_0", builder.add_uvs(shape.uvs)}};
  const int indices = builder.add_indices(shape.indices);
  nlohmann::json members = nlohmann::json::object();
  if (!node_name.empty()) members["name"] = node_name;
  return builder.add_node(builder.add_mesh(attributes, indices, material), members);
}

}  // namespace coppice::test
