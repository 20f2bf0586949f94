#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "odd_plants.h"
#include "seeded_random.h"

namespace coppice::bake::test {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kGoldenAngle = 2.399963f;
inline const glm::vec3 kUp(0.0f, 1.0f, 0.0f);
inline const glm::vec4 kGreen(0.12f, 0.35f, 0.06f, 1.0f), kBrown(0.22f, 0.12f, 0.05f, 1.0f), kGrey(0.4f, 0.4f, 0.4f, 1.0f),
    kRed(0.6f, 0.05f, 0.08f, 1.0f);

/// Which way a blade grows from where, how wide it is and how far it hangs over.
struct Blade {
  glm::vec3 root{0.0f}, along{0.0f, 1.0f, 0.0f};
  float length_m = 0.3f, width_m = 0.02f, bend = 0.5f;  ///< bend: angle between root and tip, rad
  std::uint32_t segment_count = 3;
};

inline glm::vec3 round_about(float angle, float rise) {
  return glm::normalize(glm::vec3(std::cos(angle), rise, std::sin(angle)));
}

inline glm::vec3 any_across(const glm::vec3& along) {
  return glm::normalize(glm::cross(along, std::abs(along.y) < 0.95f ? kUp : glm::vec3(1.0f, 0.0f, 0.0f)));
}

/// Grows a plant out of shapes. Every shape has vertices of its own unless it says otherwise.
class Grower {
 public:
  Grower(std::string name, std::uint32_t leaf_count) : random_(7) {
    plant_.name = std::move(name);
    plant_.leaf_count = leaf_count;
  }

  /// What follows has this material.
  Grower& paint(const std::string& name, const glm::vec4& color) {
    Material material;
    material.name = name;
    material.base_color = color;
    plant_.materials.push_back(material);
    return *this;
  }

  std::uint32_t vertex(const glm::vec3& position) {
    Mesh& mesh = plant_.soup.mesh;
    mesh.positions.push_back(position);
    mesh.normals.push_back(kUp);
    mesh.uvs.emplace_back(0.0f);
    plant_.soup.vertex_instances.push_back(0);
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    plant_.soup.mesh.indices.insert(plant_.soup.mesh.indices.end(), {a, b, c});
    plant_.soup.mesh.triangle_materials.push_back(static_cast<std::uint32_t>(plant_.materials.size() - 1));
  }

  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }

  /// Rings of `side_count` points about the axis, open where a radius is above 0 and closed where it is 0.
  void lathe(const std::vector<glm::vec3>& centers, const std::vector<float>& radii, std::uint32_t side_count);

  void tube(const glm::vec3& from, const glm::vec3& to, float radius_m, std::uint32_t side_count = 6) {
    lathe({from, to}, {radius_m, 0.7f * radius_m}, side_count);
  }

  /// Closed at both ends.
  void rod(const glm::vec3& from, const glm::vec3& to, float radius_m, std::uint32_t side_count = 8) {
    lathe({from, from, to, to}, {0.0f, radius_m, radius_m, 0.0f}, side_count);
  }

  void cone(const glm::vec3& base, const glm::vec3& tip, float radius_m, std::uint32_t side_count) {
    lathe({base, base, tip}, {0.0f, radius_m, 0.0f}, side_count);
  }

  /// An icosphere, 20 triangles times 4 a step, its points moved by up to `rough` of the radius.
  void blob(const glm::vec3& center, const glm::vec3& radii_m, std::uint32_t steps, float rough = 0.0f);

  void box(const glm::vec3& low, const glm::vec3& high);

  void card(const glm::vec3& center, const glm::vec3& half_across, const glm::vec3& half_along) {
    quad(vertex(center - half_across - half_along), vertex(center + half_across - half_along), vertex(center + half_across + half_along),
         vertex(center - half_across + half_along));
  }

  /// A strip of quads that ends in a triangle. root: vertices to begin at; it gets its own where there are none.
  void blade(const Blade& of, std::array<std::uint32_t, 2> root = {kNone, kNone});

  /// A pointed leaf of `side_count` triangles round its middle, cupped.
  void leaf(const glm::vec3& stalk, const glm::vec3& along, float length_m, float width_m, std::uint32_t side_count = 8);

  /// A closed leaf as thick as a third of its width: rings of four points between a stalk and a tip.
  void thick_leaf(const glm::vec3& stalk, const glm::vec3& along, float length_m, float width_m);

  float between(float low, float high) { return low + (high - low) * static_cast<float>(random_.uniform()); }

  /// Every triangle gets vertices of its own, as low-poly models have for their facets.
  Grower& facets();

  OddPlant take();

 private:
  OddPlant plant_;
  SeededRandom random_;
};

}  // namespace coppice::bake::test
