#include "wood_plants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <glm/geometric.hpp>

#include "seeded_random.h"
#include "tube_mesh.h"

namespace coppice::bake::test {
namespace {

constexpr float kTurn = 2.0f * std::numbers::pi_v<float>;
constexpr float kGoldenAngle = 2.39996f;

float between(SeededRandom& random, float low, float high) {
  return low + (high - low) * static_cast<float>(random.uniform());
}

glm::vec3 around(float turn) {
  return {std::cos(turn), 0.0f, std::sin(turn)};
}

std::uint32_t add_material(Plant& plant, const char* name, const glm::vec3& color) {
  plant.materials.push_back({.name = name, .base_color = glm::vec4(color, 1.0f)});
  return static_cast<std::uint32_t>(plant.materials.size() - 1);
}

void add_stem(Plant& plant, const glm::vec3& foot, const glm::vec3& tip, const std::array<float, 2>& radii, std::uint32_t sides,
              std::uint32_t material) {
  append_tube(plant.wood, std::array{foot, tip}, radii, sides, material);
}

/// A rhomb with a fold along its middle.
void add_leaf(Plant& plant, const glm::vec3& stalk, const glm::vec3& along, float width_m, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(plant.foliage.positions.size());
  plant.leaves.push_back({static_cast<std::uint32_t>(plant.foliage.triangle_materials.size()), 2});
  glm::vec3 across = glm::cross(along, glm::vec3(0.0f, 1.0f, 0.0f));
  across = glm::length(across) > 1e-4f * glm::length(along) ? glm::normalize(across) : glm::vec3(1.0f, 0.0f, 0.0f);
  const glm::vec3 normal = glm::normalize(glm::cross(across, along)), middle = stalk + 0.45f * along + 0.1f * width_m * normal;
  for (const auto& [point, uv] : {std::pair{stalk, glm::vec2(0.5f, 1.0f)},
                                  {middle + 0.5f * width_m * across, glm::vec2(1.0f, 0.5f)},
                                  {stalk + along, glm::vec2(0.5f, 0.0f)},
                                  {middle - 0.5f * width_m * across, glm::vec2(0.0f, 0.5f)}}) {
    plant.foliage.positions.push_back(point);
    plant.foliage.normals.push_back(normal);
    plant.foliage.uvs.push_back(uv);
  }
  for (const std::uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) plant.foliage.indices.push_back(first + corner);
  plant.foliage.triangle_materials.insert(plant.foliage.triangle_materials.end(), 2, material);
}

/// A closed body of revolution about +y: rings of radius profile(t) at y = t * height, t from 0 to 1, times ripple(turn).
template <class Profile, class Ripple>
void add_body(Plant& plant, const glm::vec3& foot, float height_m, const std::array<std::uint32_t, 2>& rings_sides, std::uint32_t material,
              Profile&& profile, Ripple&& ripple) {
  const auto [rings, sides] = rings_sides;
  Mesh& wood = plant.wood;
  const auto first = static_cast<std::uint32_t>(wood.positions.size());
  for (std::uint32_t ring = 0; ring <= rings; ++ring)
    for (std::uint32_t side = 0; side < sides; ++side) {
      const float t = static_cast<float>(ring) / static_cast<float>(rings),
                  turn = kTurn * static_cast<float>(side) / static_cast<float>(sides);
      wood.positions.push_back(foot + glm::vec3(0.0f, t * height_m, 0.0f) + profile(t) * ripple(turn, t) * around(turn));
      wood.normals.push_back(glm::normalize(around(turn) + glm::vec3(0.0f, 2.0f * t - 1.0f, 0.0f)));
      wood.uvs.emplace_back(turn / kTurn, t);
    }
  for (std::uint32_t ring = 0; ring < rings; ++ring)
    for (std::uint32_t side = 0; side < sides; ++side) {
      const std::uint32_t a = first + ring * sides + side, b = first + ring * sides + (side + 1) % sides, c = a + sides, d = b + sides;
      wood.indices.insert(wood.indices.end(), {a, c, b, b, c, d});
      wood.triangle_materials.insert(wood.triangle_materials.end(), 2, material);
    }
}

float no_ripple(float, float) {
  return 1.0f;
}

void add_ball(Plant& plant, const glm::vec3& center, float radius_m, float flatness, std::uint32_t material) {
  add_body(
      plant, center - glm::vec3(0.0f, flatness * radius_m, 0.0f), 2.0f * flatness * radius_m, {8, 12}, material,
      [&](float t) { return radius_m * std::sin(0.5f * kTurn * std::clamp(t, 0.01f, 0.99f)); }, no_ripple);
}

Plant bamboo() {
  constexpr int kCulms = 30, kInternodes = 14;
  Plant plant{.name = "bamboo"};
  SeededRandom random(1);
  const std::uint32_t green = add_material(plant, "leaves", {0.12f, 0.3f, 0.05f}),
                      cane = add_material(plant, "cane", {0.35f, 0.33f, 0.08f});
  for (int culm = 0; culm < kCulms; ++culm) {
    const glm::vec3 foot = 0.12f * std::sqrt(static_cast<float>(culm)) * around(kGoldenAngle * static_cast<float>(culm));
    const glm::vec3 lean = 0.12f * foot + glm::vec3(0.0f, between(random, 0.36f, 0.46f), 0.0f);  // per internode
    for (int node = 0; node < kInternodes; ++node) {
      const auto n = static_cast<float>(node);
      const glm::vec3 bottom = foot + (n + 0.01f) * lean + 0.008f * n * n * foot,
                      top = foot + (n + 0.99f) * lean + 0.008f * (n + 1) * (n + 1) * foot;
      const float radius_m = 0.02f * (1.0f - 0.055f * n);
      add_stem(plant, bottom, top, {radius_m, 0.95f * radius_m}, 10, cane);
      for (int twig = 0; node > 5 && twig < 3; ++twig) {
        const glm::vec3 way = 0.45f * around(between(random, 0.0f, kTurn)) + glm::vec3(0.0f, 0.2f, 0.0f);
        add_stem(plant, top, top + way, {0.003f, 0.001f}, 4, cane);
        for (int leaf = 0; leaf < 6; ++leaf)
          add_leaf(plant, top + way * between(random, 0.5f, 1.0f),
                   0.16f * around(between(random, 0.0f, kTurn)) - glm::vec3(0.0f, 0.06f, 0.0f), 0.022f, green);
      }
    }
  }
  return plant;
}

Plant flowers() {
  Plant plant{.name = "flowers"};
  SeededRandom random(2);
  const std::uint32_t petal = add_material(plant, "petals", {0.7f, 0.15f, 0.3f}), stem = add_material(plant, "stem", {0.1f, 0.25f, 0.04f}),
                      heart = add_material(plant, "heart", {0.6f, 0.4f, 0.02f});
  for (int i = 0; i < 14; ++i) {
    const glm::vec3 foot = 0.03f * std::sqrt(static_cast<float>(i)) * around(kGoldenAngle * static_cast<float>(i));
    std::vector<glm::vec3> points;
    const glm::vec3 lean = 0.6f * foot + 0.02f * around(between(random, 0.0f, kTurn));
    const float height_m = between(random, 0.45f, 0.6f);
    for (int k = 0; k <= 8; ++k) {
      const float t = static_cast<float>(k) / 8.0f;
      points.push_back(foot + lean * (t * t * 2.0f) + glm::vec3(0.0f, height_m * t, 0.0f));
    }
    append_tube(plant.wood, points, std::vector<float>(points.size(), 0.002f), 8, stem);
    add_ball(plant, points.back(), 0.012f, 0.6f, heart);
    for (int k = 0; k < 16; ++k)
      add_leaf(plant, points.back(), 0.05f * around(kTurn * static_cast<float>(k) / 16.0f) + glm::vec3(0.0f, 0.01f, 0.0f), 0.014f, petal);
  }
  return plant;
}

/// Trunk, and whorls of boughs with needles. Returns points on the boughs.
std::vector<glm::vec3> add_conifer(Plant& plant, SeededRandom& random, const std::array<std::uint32_t, 2>& bark_needles) {
  const auto [bark, needles] = bark_needles;
  std::vector<glm::vec3> places;
  add_stem(plant, {0, 0, 0}, {0, 8, 0}, {0.16f, 0.02f}, 12, bark);
  for (int bough = 0; bough < 90; ++bough) {
    const float height_m = 1.0f + 6.7f * static_cast<float>(bough) / 90.0f, length_m = 0.32f * (8.6f - height_m);
    const glm::vec3 foot(0, height_m, 0),
        way = length_m * (around(kGoldenAngle * static_cast<float>(bough)) - glm::vec3(0.0f, 0.15f, 0.0f));
    add_stem(plant, foot, foot + way, {0.03f, 0.008f}, 6, bark);
    for (int k = 0; k < 36; ++k) {
      const glm::vec3 place = foot + way * between(random, 0.25f, 1.0f);
      add_leaf(plant, place, 0.3f * way / length_m + 0.22f * around(between(random, 0.0f, kTurn)), 0.05f, needles);
      if (k % 12 == 0) places.push_back(place);
    }
  }
  return places;
}

Plant baubles() {
  Plant plant{.name = "baubles"};
  SeededRandom random(3);
  const std::uint32_t needles = add_material(plant, "needles", {0.05f, 0.15f, 0.05f}),
                      bark = add_material(plant, "bark", {0.15f, 0.09f, 0.05f});
  const std::array balls{add_material(plant, "bauble_red", {0.7f, 0.02f, 0.02f}), add_material(plant, "bauble_gold", {0.7f, 0.5f, 0.05f})};
  for (const glm::vec3& place : add_conifer(plant, random, {bark, needles}))
    add_ball(plant, place - glm::vec3(0.0f, 0.1f, 0.0f), 0.07f, 1.0f, balls[random.below(2)]);
  return plant;
}

Plant snow_pine() {
  Plant plant{.name = "snow_pine"};
  SeededRandom random(4);
  const std::uint32_t needles = add_material(plant, "needles", {0.04f, 0.12f, 0.05f}),
                      bark = add_material(plant, "bark", {0.15f, 0.09f, 0.05f}), snow = add_material(plant, "snow", {0.85f, 0.87f, 0.9f});
  for (const glm::vec3& place : add_conifer(plant, random, {bark, needles}))
    add_ball(plant, place + glm::vec3(0.0f, 0.06f, 0.0f), between(random, 0.1f, 0.2f), 0.3f, snow);
  return plant;
}

Plant cactus() {
  Plant plant{.name = "cactus"};
  SeededRandom random(5);
  const std::uint32_t flesh = add_material(plant, "cactus_bark", {0.1f, 0.28f, 0.1f}),
                      spine = add_material(plant, "spine", {0.75f, 0.7f, 0.5f});
  constexpr float kHeight_m = 1.2f, kRadius_m = 0.16f;
  const auto profile = [](float t) { return kRadius_m * std::sqrt(std::max(1.0f - std::pow(2.0f * t - 1.0f, 6.0f), 0.01f)); };
  add_body(plant, {0, 0, 0}, kHeight_m, {40, 48}, flesh, profile, [](float turn, float) { return 1.0f + 0.08f * std::cos(12.0f * turn); });
  for (int i = 0; i < 1500; ++i) {
    const float t = between(random, 0.03f, 0.99f), turn = kTurn * static_cast<float>(random.below(12)) / 12.0f;
    const glm::vec3 foot = glm::vec3(0.0f, t * kHeight_m, 0.0f) + 1.06f * profile(t) * around(turn);
    const glm::vec3 way =
        0.05f * glm::normalize(around(turn + between(random, -0.8f, 0.8f)) + glm::vec3(0.0f, between(random, -0.6f, 0.6f), 0.0f));
    add_stem(plant, foot, foot + way, {0.0012f, 0.0f}, 3, spine);
  }
  return plant;
}

void grow_bough(Plant& plant, SeededRandom& random, const glm::vec3& foot, const glm::vec3& way, float radius_m, int depth) {
  std::vector<glm::vec3> points{foot};
  for (int k = 1; k <= 4; ++k)
    points.push_back(foot + way * (0.25f * static_cast<float>(k)) +
                     (k == 4 ? 0.0f : 0.06f * glm::length(way)) * around(between(random, 0.0f, kTurn)));
  const std::array<float, 5> radii{radius_m, 0.9f * radius_m, 0.75f * radius_m, 0.6f * radius_m, 0.45f * radius_m};
  append_tube(plant.wood, points, radii, depth == 0 ? 4 : 8, 1);
  for (int k = 0; k < (depth == 0 ? 8 : 5); ++k) {
    const glm::vec3 from = points[1 + static_cast<std::size_t>(k) % 4];
    const glm::vec3 turned =
        glm::normalize(way) + 0.9f * glm::normalize(glm::vec3(between(random, -1, 1), between(random, -0.3f, 1), between(random, -1, 1)));
    if (depth == 0)
      add_leaf(plant, from, 0.22f * glm::normalize(turned), 0.1f, 0);
    else
      grow_bough(plant, random, from, 0.6f * glm::length(way) * glm::normalize(turned), 0.45f * radius_m, depth - 1);
  }
}

Plant oak_foot() {
  Plant plant{.name = "oak_foot"};
  SeededRandom random(6);
  add_material(plant, "leaves", {0.1f, 0.22f, 0.05f});
  const std::uint32_t bark = add_material(plant, "bark", {0.2f, 0.15f, 0.1f});
  const auto profile = [](float t) { return 0.35f + 0.6f * std::exp(-9.0f * t); };
  add_body(plant, {0, 0, 0}, 3.0f, {120, 96}, bark, profile, [&](float turn, float t) {
    return 1.0f + 0.35f * std::exp(-8.0f * t) * std::cos(5.0f * turn) + between(random, -0.02f, 0.02f);
  });
  for (int i = 0; i < 9; ++i)
    grow_bough(plant, random, {0.0f, 2.4f + 0.07f * static_cast<float>(i), 0.0f},
               2.6f * glm::normalize(around(kGoldenAngle * static_cast<float>(i)) + glm::vec3(0.0f, 0.7f, 0.0f)), 0.14f, 3);
  return plant;
}

}  // namespace

std::vector<WoodPlant> wood_plants() {
  return {{"bamboo", bamboo}, {"flowers", flowers},   {"baubles", baubles},
          {"cactus", cactus}, {"oak_foot", oak_foot}, {"snow_pine", snow_pine}};
}

}  // namespace coppice::bake::test
