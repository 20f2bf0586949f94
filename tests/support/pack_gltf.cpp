#include "pack_gltf.h"

#include <cmath>
#include <numbers>

#include "seeded_random.h"

namespace coppice::test {

void Shape::add_quad(const std::array<glm::vec3, 4>& corners) {
  const auto first = static_cast<std::uint32_t>(positions.size());
  positions.insert(positions.end(), corners.begin(), corners.end());
  for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + i);
}

Shape post(float height, float width, glm::vec3 foot, glm::vec3 lean, int rings) {
  Shape shape;
  const std::array<glm::vec3, 4> square{{{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}}};
  const auto ring = [&](int i, std::size_t corner) {
    const float share = static_cast<float>(i) / static_cast<float>(rings);
    return foot + share * (glm::vec3(0, height, 0) + lean) + (0.5f - 0.3f * share) * width * square.at(corner % 4);
  };
  for (int i = 0; i < rings; ++i)
    for (std::size_t c = 0; c < 4; ++c) shape.add_quad({ring(i, c), ring(i, c + 1), ring(i + 1, c + 1), ring(i + 1, c)});
  return shape;
}

Shape leaves(int count, glm::vec3 centre, glm::vec3 radii, float size, std::uint64_t seed) {
  bake::SeededRandom random(seed);
  const auto share = [&] { return 2.0f * static_cast<float>(random.uniform()) - 1.0f; };
  Shape shape;
  while (static_cast<int>(shape.positions.size()) < 4 * count) {
    const glm::vec3 at(share(), share(), share());
    if (at.x * at.x + at.y * at.y + at.z * at.z > 1.0f) continue;
    const glm::vec3 a = size * glm::vec3(share(), share(), share()), b = size * glm::vec3(share(), share(), share());
    if (std::abs(a.x * b.y - a.y * b.x) < 0.1f * size * size) continue;
    const glm::vec3 corner = centre + at * radii;
    shape.add_quad({corner, corner + a, corner + a + b, corner + b});
  }
  return shape;
}

Shape crossed_quads(float height, float width, int count) {
  Shape shape;
  for (int i = 0; i < count; ++i) {
    const float angle = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(count);
    const glm::vec3 across = 0.5f * width * glm::vec3(std::cos(angle), 0, std::sin(angle)), up(0, height, 0);
    shape.add_quad({-across, across, across + up, up - across});
  }
  return shape;
}

Shape plate(float width) {
  Shape shape;
  const float half = 0.5f * width;
  shape.add_quad({glm::vec3(-half, -0.01f, -half), {half, -0.01f, -half}, {half, -0.01f, half}, {-half, -0.01f, half}});
  return shape;
}

int Pack::material(const std::string& name) {
  const auto [found, is_new] = materials.try_emplace(name, 0);
  if (!is_new) return found->second;
  found->second = file.add_material(name);
  auto& json = file.json["materials"][static_cast<std::size_t>(found->second)];
  const bool is_leaf = name.find("eaf") != std::string::npos || name.find("eaves") != std::string::npos || name == "card";
  if (is_leaf) json["alphaMode"] = "MASK";
  if (is_leaf) file.set_texture(found->second, striped_png(8, {40, 120, 30, 255}, {40, 120, 30, 0}));
  return found->second;
}

int Pack::mesh(const Parts& parts, const std::string& name) {
  nlohmann::json json;
  for (const auto& [material_name, shape] : parts)
    json["primitives"].push_back({{"attributes", {{"POSITION", file.add_positions(shape.positions)}}},
                                  {"indices", file.add_indices(shape.indices)},
                                  {"material", material(material_name)}});
  if (!name.empty()) json["name"] = name;
  file.json["meshes"].push_back(json);
  return static_cast<int>(file.json["meshes"].size()) - 1;
}

int Pack::node(const std::string& name, int mesh_index, glm::vec3 at, int parent) {
  nlohmann::json node{{"name", name}, {"translation", {at.x, at.y, at.z}}};
  if (mesh_index >= 0) node["mesh"] = mesh_index;
  if (parent < 0) return file.add_node(mesh_index, node);
  file.json["nodes"].push_back(node);
  const int index = static_cast<int>(file.json["nodes"].size()) - 1;
  file.node(parent)["children"].push_back(index);
  return index;
}

Parts trunk_part(float height, std::uint64_t seed) {
  return {{"bark", post(0.8f * height, 0.06f * height + 0.001f * static_cast<float>(seed))}};
}
Parts crown_part(int count, float height, std::uint64_t seed) {
  return {{"leaf", leaves(count, {0, 0.65f * height, 0}, {0.28f * height, 0.33f * height, 0.28f * height}, 0.03f * height, seed)}};
}
Parts tree(int count, float height, std::uint64_t seed) {
  return {trunk_part(height, seed)[0], crown_part(count, height, seed)[0]};
}

}  // namespace coppice::test
