#include "odd_plants.h"

#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "gltf_write.h"
#include "plant_grower.h"

namespace coppice::bake::test {
namespace {

/// Triangles a blob: 20, 80, 320.
OddPlant low_poly_tree(const std::string& name, std::uint32_t blob_count, std::uint32_t steps, const std::string& crown_name,
                       const std::string& trunk_name) {
  Grower grow(name, 0);
  grow.paint(trunk_name, kBrown).rod({0, 0, 0}, {0, 1.5f, 0}, 0.12f, 6);
  grow.paint(crown_name, kGreen);
  for (std::uint32_t i = 0; i < blob_count; ++i) {
    const float angle = kGoldenAngle * static_cast<float>(i), out = i == 0 ? 0.0f : 0.55f;
    grow.blob({out * std::cos(angle), 2.0f + 0.2f * static_cast<float>(i % 3), out * std::sin(angle)},
              glm::vec3(blob_count == 1 ? 1.1f : 0.7f), steps, 0.1f);
  }
  return grow.facets().take();
}

OddPlant palette_tree() {
  Grower grow("tree_of_one_palette", 0);
  grow.paint("colormap", kGrey).rod({0, 0, 0}, {0, 1.5f, 0}, 0.12f, 6);
  for (std::uint32_t i = 0; i < 3; ++i) grow.blob({0.5f * static_cast<float>(i) - 0.5f, 1.9f, 0}, glm::vec3(0.6f), 1, 0.1f);
  return grow.facets().take();
}

OddPlant blob_shrub() {
  Grower grow("shrub_of_blobs", 0);
  grow.paint("Leaves", kGreen);
  for (std::uint32_t i = 0; i < 24; ++i) {
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 0.2f + 0.05f * static_cast<float>(i));
    grow.blob(0.6f * out, glm::vec3(0.22f), 1, 0.1f);
  }
  return grow.facets().take();
}

OddPlant cone_conifer(const std::string& name, const std::string& material, bool is_open = false) {
  Grower grow(name, 0);
  grow.paint("", kBrown).rod({0, 0, 0}, {0, 1.0f, 0}, 0.1f, 6);
  grow.paint(material, kGreen);
  for (std::uint32_t i = 0; i < 4; ++i) {
    const glm::vec3 low(0, 0.6f + 0.6f * static_cast<float>(i), 0);
    const float radius_m = 0.9f - 0.18f * static_cast<float>(i);
    if (is_open)
      grow.lathe({low, low + kUp}, {radius_m, 0.0f}, 8);
    else
      grow.cone(low, low + kUp, radius_m, 8);
  }
  return grow.facets().take();
}

/// Half balls, open below.
OddPlant dome_tree() {
  Grower grow("tree_of_open_domes", 0);
  grow.paint("", kBrown).rod({0, 0, 0}, {0, 1.2f, 0}, 0.12f, 6);
  grow.paint("Leaves", kGreen);
  for (std::uint32_t i = 0; i < 5; ++i) {
    const glm::vec3 at = (i == 0 ? 0.0f : 0.6f) * round_about(kGoldenAngle * static_cast<float>(i), 0.0f) + 1.2f * kUp;
    grow.lathe({at, at + 0.35f * kUp, at + 0.6f * kUp, at + 0.7f * kUp}, {0.7f, 0.6f, 0.35f, 0.0f}, 10);
  }
  return grow.facets().take();
}

void add_cactus_body(Grower& grow) {
  grow.paint("Cactus", kGreen);
  grow.lathe({{0, 0, 0}, {0, 0.1f, 0}, {0, 1.3f, 0}, {0, 1.5f, 0}, {0, 1.55f, 0}}, {0.18f, 0.2f, 0.2f, 0.12f, 0.0f}, 16);
  grow.lathe({{0.15f, 0.7f, 0}, {0.45f, 0.75f, 0}, {0.5f, 1.1f, 0}, {0.5f, 1.15f, 0}}, {0.08f, 0.1f, 0.1f, 0.0f}, 12);
}

enum class Spines { none, cards, cones };
OddPlant cactus(const std::string& name, Spines spines) {
  Grower grow(name, spines == Spines::cards ? 300 : 0);
  add_cactus_body(grow);
  if (spines != Spines::none) grow.paint("", kGrey);
  for (std::uint32_t i = 0; i < 300 && spines != Spines::none; ++i) {
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 0.2f);
    const glm::vec3 at = glm::vec3(0.2f, 0.0f, 0.2f) * out + 0.0043f * static_cast<float>(i) * kUp;
    if (spines == Spines::cards)
      grow.card(at + 0.02f * out, 0.001f * any_across(out), 0.02f * out);
    else
      grow.cone(at, at + 0.04f * out, 0.002f, 4);
  }
  return grow.take();
}

OddPlant box_hedge() {
  Grower grow("hedge_box", 0);
  grow.paint("hedge", kGreen).box({-2, 0, -0.4f}, {2, 1.2f, 0.4f});
  return grow.facets().take();
}

OddPlant mushroom() {
  Grower grow("mushroom", 0);
  grow.paint("", kGrey).lathe({{0, 0, 0}, {0, 0.1f, 0}, {0, 0.1f, 0}, {0, 0.14f, 0}, {0, 0.16f, 0}}, {0.02f, 0.015f, 0.07f, 0.05f, 0.0f},
                              12);
  return grow.take();
}

OddPlant rock() {
  Grower grow("rock", 0);
  grow.paint("", kGrey).blob({0, 0.3f, 0}, {0.6f, 0.35f, 0.5f}, 2, 0.12f);
  return grow.facets().take();
}

void add_dead_branches(Grower& grow, const glm::vec3& from, const glm::vec3& along, float length_m, std::uint32_t depth) {
  const glm::vec3 to = from + length_m * along;
  grow.tube(from, to, 0.04f * length_m);
  for (std::uint32_t i = 0; i < 3 && depth > 0; ++i) {
    const glm::vec3 side = round_about(grow.between(0.0f, 2.0f * kPi), 0.3f);
    add_dead_branches(grow, from + (0.4f + 0.3f * static_cast<float>(i)) * (to - from), glm::normalize(along + side), 0.55f * length_m,
                      depth - 1);
  }
}

OddPlant dead_tree() {
  Grower grow("dead_tree", 0);
  grow.paint("", kGrey);
  add_dead_branches(grow, {0, 0, 0}, kUp, 2.0f, 3);
  return grow.take();
}

OddPlant log(const std::string& name, const glm::vec3& to, float radius_m) {
  Grower grow(name, 0);
  grow.paint("", kBrown).rod({0, 0, 0}, to, radius_m, 14);
  return grow.facets().take();
}

// ---- Rosettes

/// A plant of closed leaves, a third as thick as wide.
OddPlant succulent(const std::string& name, std::uint32_t count, float length_m, float width_m) {
  Grower grow(name, count);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < count; ++i) {
    const float share = static_cast<float>(i) / static_cast<float>(count);
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 0.2f + 2.0f * share);
    grow.thick_leaf(0.02f * out + 0.001f * static_cast<float>(i) * kUp, out, length_m * (1.0f - 0.6f * share),
                    width_m * (1.0f - 0.5f * share));
  }
  return grow.take();
}

/// Blades round a point, from the outermost to the steepest. own_vertices: off, all of a clump's blades begin at the points of a ring.
OddPlant rosette(const std::string& name, const std::vector<std::uint32_t>& segment_counts, const Blade& like, bool own_vertices) {
  const auto count = static_cast<std::uint32_t>(segment_counts.size());
  Grower grow(name, count);
  grow.paint("", kGrey);
  std::vector<std::uint32_t> ring;
  for (std::uint32_t i = 0; i < count && !own_vertices; ++i)
    ring.push_back(grow.vertex(0.01f * round_about(2.0f * kPi * static_cast<float>(i) / static_cast<float>(count), 0.0f)));
  for (std::uint32_t i = 0; i < count; ++i) {
    Blade blade = like;
    const float angle = 2.0f * kPi * (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
    blade.along = round_about(angle, 1.0f + grow.between(0.0f, 2.0f));
    blade.root = 0.01f * round_about(angle, 0.0f);
    blade.length_m *= grow.between(0.7f, 1.0f);
    blade.segment_count = segment_counts[i];
    grow.blade(blade, own_vertices ? std::array{kNone, kNone} : std::array{ring[i], ring[(i + 1) % count]});
  }
  return grow.take();
}

/// Every blade is one triangle, or two back to back.
OddPlant triangle_grass(const std::string& name, bool has_backs) {
  Grower grow(name, 20);
  grow.paint("grass", kGreen);
  for (std::uint32_t i = 0; i < 20; ++i) {
    const glm::vec3 foot = 0.03f * std::sqrt(static_cast<float>(i)) * round_about(kGoldenAngle * static_cast<float>(i), 0.0f);
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 2.0f), across = 0.015f * any_across(out);
    const std::uint32_t a = grow.vertex(foot - across), b = grow.vertex(foot + across), tip = grow.vertex(foot + 0.4f * out);
    grow.triangle(a, b, tip);
    if (has_backs) grow.triangle(b, a, tip);
  }
  return grow.take();
}

OddPlant crossed_grass() {
  Grower grow("three_crossed_cards", 3);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const float angle = kPi * static_cast<float>(i) / 3.0f;
    grow.card({0, 0.25f, 0}, 0.25f * round_about(angle, 0.0f), 0.25f * kUp);
  }
  return grow.take();
}

// ---- Leaves on stems

/// A rachis with teeth on either side, all of one surface.
void add_welded_frond(Grower& grow, const glm::vec3& along, std::uint32_t pair_count) {
  const glm::vec3 across = any_across(along);
  std::array<std::uint32_t, 2> before{};
  for (std::uint32_t k = 0; k < 2 * pair_count; ++k) {
    const float reach_m = 0.15f - 0.005f * static_cast<float>(k);
    const glm::vec3 at = 0.025f * static_cast<float>(k) * along + 0.02f * along;
    const std::array<std::uint32_t, 2> here{grow.vertex(at - 0.005f * across), grow.vertex(at + 0.005f * across)};
    if (k > 0) grow.quad(before[0], before[1], here[1], here[0]);
    if (k % 2 == 1) {
      grow.triangle(before[0], here[0], grow.vertex(at - reach_m * across));
      grow.triangle(before[1], grow.vertex(at + reach_m * across), here[1]);
    }
    before = here;
  }
}

enum class Fronds { strips, leaflets, welded };
OddPlant fern(const std::string& name, Fronds form) {
  constexpr std::uint32_t kFronds = 8, kPairs = 12;
  Grower grow(name, form == Fronds::leaflets ? kFronds * kPairs * 2 : kFronds);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < kFronds; ++i) {
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 0.8f), across = any_across(out);
    if (form == Fronds::strips) {
      grow.blade({.root = 0.02f * out, .along = out, .length_m = 0.6f, .width_m = 0.2f, .bend = 1.0f, .segment_count = 5});
      continue;
    }
    if (form == Fronds::welded) {
      add_welded_frond(grow, out, kPairs);
      continue;
    }
    for (std::uint32_t k = 0; k < kPairs; ++k)
      for (const float side : {-1.0f, 1.0f}) {
        const glm::vec3 at = (0.05f * static_cast<float>(k) + 0.02f) * out + 0.004f * side * across;
        grow.leaf(at, glm::normalize(side * across + 0.3f * out), 0.15f - 0.01f * static_cast<float>(k), 0.03f, 6);
      }
    grow.tube({0, 0, 0}, 0.6f * out, 0.003f, 4);
  }
  return grow.take();
}

void add_flower(Grower& grow, const glm::vec3& foot, std::uint32_t petal_count, float height_m) {
  const glm::vec3 head = foot + height_m * kUp;
  grow.tube(foot, head, 0.006f, 5);
  grow.blob(head, glm::vec3(0.02f), 1);
  for (std::uint32_t i = 0; i < petal_count; ++i) {
    const glm::vec3 out = round_about(2.0f * kPi * static_cast<float>(i) / static_cast<float>(petal_count), 0.3f);
    grow.leaf(head + 0.022f * out, out, 0.06f, 0.03f);
  }
  for (std::uint32_t i = 0; i < 2; ++i)
    grow.blade({.root = foot + 0.01f * round_about(3.0f * static_cast<float>(i), 0.0f),
                .along = round_about(3.0f * static_cast<float>(i), 1.5f),
                .length_m = 0.6f * height_m,
                .width_m = 0.04f,
                .bend = 0.7f,
                .segment_count = 4});
}

/// Its petals; beside them two blades as long as half the plant are wood.
OddPlant flower() {
  Grower grow("flower", 12);
  grow.paint("", kRed);
  add_flower(grow, {0, 0, 0}, 12, 0.4f);
  return grow.take();
}

OddPlant tulip_field() {
  Grower grow("tulip_field", 60 * 8);
  grow.paint("Tulip", kRed);
  for (std::uint32_t i = 0; i < 60; ++i)
    add_flower(grow, {0.15f * static_cast<float>(i % 10), 0, 0.15f * static_cast<float>(i / 10)}, 6, 0.3f + grow.between(0.0f, 0.1f));
  return grow.take();
}

/// Culms of five joints each, with leaves.
OddPlant bamboo() {
  Grower grow("bamboo", 10 * 40);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < 10; ++i) {
    const glm::vec3 foot = 0.3f * round_about(kGoldenAngle * static_cast<float>(i), 0.0f);
    for (std::uint32_t k = 0; k < 5; ++k)
      grow.rod(foot + 0.8f * static_cast<float>(k) * kUp, foot + (0.8f * static_cast<float>(k) + 0.78f) * kUp, 0.02f, 6);
    for (std::uint32_t k = 0; k < 40; ++k) {
      const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(k), grow.between(-0.5f, 0.5f));
      grow.blade({.root = foot + 0.03f * out + (1.5f + 0.06f * static_cast<float>(k)) * kUp,
                  .along = out,
                  .length_m = 0.2f,
                  .width_m = 0.02f,
                  .segment_count = 3});
    }
  }
  return grow.take();
}

OddPlant reeds() {
  Grower grow("reeds", 40);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < 40; ++i) {
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 8.0f);
    const glm::vec3 foot = 0.02f * std::sqrt(static_cast<float>(i)) * round_about(kGoldenAngle * static_cast<float>(i), 0.0f);
    grow.blade(
        {.root = foot, .along = out, .length_m = 2.0f * grow.between(0.7f, 1.0f), .width_m = 0.02f, .bend = 0.2f, .segment_count = 6});
  }
  grow.paint("", kBrown);
  for (std::uint32_t i = 0; i < 6; ++i) {
    const glm::vec3 foot = 0.1f * round_about(kGoldenAngle * static_cast<float>(i), 0.0f);
    grow.tube(foot, foot + 1.8f * kUp, 0.005f);
    grow.rod(foot + 1.6f * kUp, foot + 1.8f * kUp, 0.015f);
  }
  return grow.take();
}

OddPlant kelp() {
  Grower grow("kelp", 6 * 20);
  grow.paint("", kBrown);
  for (std::uint32_t i = 0; i < 6; ++i) {
    const glm::vec3 foot = 0.3f * round_about(kGoldenAngle * static_cast<float>(i), 0.0f);
    grow.tube(foot, foot + 4.0f * kUp, 0.01f);
    for (std::uint32_t k = 0; k < 20; ++k) {
      const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(k), 0.5f);
      grow.blade({.root = foot + 0.012f * out + 0.2f * static_cast<float>(k) * kUp,
                  .along = out,
                  .length_m = 0.5f,
                  .width_m = 0.08f,
                  .bend = 0.8f,
                  .segment_count = 6});
    }
  }
  return grow.take();
}

OddPlant ivy_on_a_wall() {
  Grower grow("ivy_on_a_wall", 500);
  grow.paint("", kGrey).box({-1.5f, 0, -0.2f}, {1.5f, 2.5f, 0});
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < 500; ++i) {
    const glm::vec3 at(grow.between(-1.4f, 1.4f), grow.between(0.05f, 2.4f), 0.01f + 0.00005f * static_cast<float>(i));
    grow.leaf(at, glm::normalize(glm::vec3(grow.between(-0.4f, 0.4f), -1.0f, 0.3f)), 0.09f, 0.08f, 10);
  }
  return grow.take();
}

OddPlant palm() {
  Grower grow("palm_of_strips", 9);
  grow.paint("", kBrown).tube({0, 0, 0}, {0, 3.0f, 0}, 0.12f, 8);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < 9; ++i) {
    const glm::vec3 out = round_about(2.0f * kPi * static_cast<float>(i) / 9.0f, 0.6f);
    grow.blade({.root = 3.0f * kUp + 0.05f * out, .along = out, .length_m = 2.0f, .width_m = 0.4f, .bend = 1.8f, .segment_count = 6});
  }
  return grow.facets().take();
}

OddPlant needle_pine() {
  Grower grow("pine_of_needle_cards", 200 * 3);
  grow.paint("", kBrown).tube({0, 0, 0}, {0, 4.0f, 0}, 0.1f, 8);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < 200; ++i) {
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 0.2f), across = any_across(out),
                    normal = glm::cross(out, across);
    const float height_m = 1.0f + 0.015f * static_cast<float>(i);
    const glm::vec3 at = height_m * kUp + 0.3f * (4.2f - height_m) * out;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const float angle = kPi * static_cast<float>(k) / 3.0f;
      grow.card(at, 0.1f * (std::cos(angle) * across + std::sin(angle) * normal), 0.2f * out);
    }
  }
  return grow.take();
}

OddPlant card_hedge() {
  Grower grow("hedge_of_cards", 400);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < 400; ++i) {
    const glm::vec3 along = round_about(grow.between(0.0f, 6.0f), grow.between(-1.0f, 1.0f));
    grow.card({grow.between(-2.0f, 2.0f), grow.between(0.1f, 1.1f), grow.between(-0.4f, 0.4f)}, 0.1f * any_across(along), 0.1f * along);
  }
  return grow.take();
}

/// Large leaves on stalks: a house plant.
OddPlant monstera(std::uint32_t count) {
  Grower grow("monstera_" + std::to_string(count), count);
  grow.paint("", kBrown).lathe({{0, 0, 0}, {0, 0, 0}, {0, 0.25f, 0}, {0, 0.25f, 0}}, {0.0f, 0.12f, 0.16f, 0.0f}, 12);
  grow.paint("", kGreen);
  for (std::uint32_t i = 0; i < count; ++i) {
    const glm::vec3 out = round_about(kGoldenAngle * static_cast<float>(i), 1.5f),
                    head = 0.3f * kUp + (0.3f + 0.03f * static_cast<float>(i)) * out;
    grow.tube(0.2f * kUp + 0.02f * out, head, 0.008f, 5);
    grow.leaf(head + 0.001f * out, glm::normalize(out * glm::vec3(1, 0.1f, 1)), 0.3f, 0.25f, 14);
  }
  return grow.take();
}

}  // namespace

std::vector<OddPlant> odd_plants() {
  const Blade grass{.length_m = 0.4f, .width_m = 0.02f, .bend = 0.6f}, agave{.length_m = 0.8f, .width_m = 0.12f, .bend = 0.5f};
  return {low_poly_tree("tree_of_a_blob", 1, 1, "", ""),
          low_poly_tree("tree_of_three_blobs", 3, 0, "leafsGreen", "woodBark"),
          low_poly_tree("tree_of_five_blobs", 5, 2, "Leaves", "Trunk"),
          low_poly_tree("tree_of_five_blobs_unnamed", 5, 1, "", ""),
          palette_tree(),
          blob_shrub(),
          cone_conifer("conifer_of_cones", "Leaves"),
          cone_conifer("conifer_of_cones_unnamed", ""),
          cone_conifer("conifer_of_open_cones", "Leaves", true),
          dome_tree(),
          cactus("cactus", Spines::none),
          cactus("cactus_with_spine_cards", Spines::cards),
          cactus("cactus_with_spine_cones", Spines::cones),
          box_hedge(),
          card_hedge(),
          succulent("succulent", 40, 0.12f, 0.05f),
          succulent("aloe", 16, 0.5f, 0.08f),
          rosette("agave", std::vector<std::uint32_t>(24, 6), agave, true),
          mushroom(),
          rock(),
          dead_tree(),
          log("stump", {0, 0.5f, 0}, 0.3f),
          log("log", {2.0f, 0.3f, 0}, 0.25f),
          rosette("grass", std::vector<std::uint32_t>(12, 3), grass, true),
          rosette("grass_of_shared_roots", std::vector<std::uint32_t>(12, 3), grass, false),
          rosette("grass_of_unlike_blades", {2, 3, 4, 3, 2, 5, 4, 3, 2}, grass, true),
          rosette("grass_of_unlike_blades_and_shared_roots", {2, 3, 4, 3, 2, 5, 4, 3, 2}, grass, false),
          rosette("grass_of_five_blades", std::vector<std::uint32_t>(5, 4), grass, true),
          triangle_grass("grass_of_triangles", false),
          triangle_grass("grass_of_triangles_with_backs", true),
          crossed_grass(),
          fern("fern_of_strips", Fronds::strips),
          fern("fern_of_leaflets", Fronds::leaflets),
          fern("fern_of_welded_fronds", Fronds::welded),
          flower(),
          tulip_field(),
          bamboo(),
          reeds(),
          kelp(),
          ivy_on_a_wall(),
          palm(),
          needle_pine(),
          monstera(4),
          monstera(9)};
}

std::vector<std::uint8_t> encode(const OddPlant& plant) {
  const auto file = encode_glb({{plant.name, &plant.soup.mesh}}, plant.materials, {});
  return file ? *file : std::vector<std::uint8_t>{};
}

}  // namespace coppice::bake::test
