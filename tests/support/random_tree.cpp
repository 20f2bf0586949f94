#include "random_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <tuple>

#include <glm/geometric.hpp>

namespace coppice::test {

namespace {

/// Uniform in [0, 1); std::uniform_real_distribution differs between libraries.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  float unit() { return static_cast<float>(engine_() >> 8) * 0x1p-24f; }
  float between(float low, float high) { return low + (high - low) * unit(); }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(engine_() % count); }
  glm::vec3 in_ball() {
    for (;;) {
      const float x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
      const glm::vec3 point(x, y, z);
      if (glm::dot(point, point) <= 1.0f) return point;
    }
  }

 private:
  std::mt19937 engine_;
};

std::uint32_t morton_code(glm::vec3 in_ball) {
  std::uint32_t code = 0;
  for (int bit = 9; bit >= 0; --bit)
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<std::uint32_t>((in_ball[axis] * 0.5f + 0.5f) * 1023.0f);
      code = code << 1 | (cell >> bit & 1u);
    }
  return code;
}

using Corners = std::array<std::uint32_t, 4>;

/// The farthest two of the eight vertices, then twice the one farthest from those chosen; in ring order.
Corners merge_corners(const std::vector<glm::vec3>& vertices, const Corners& first, const Corners& second) {
  std::array<std::uint32_t, 8> all{};
  std::ranges::copy(first, all.begin());
  std::ranges::copy(second, all.begin() + 4);
  const auto distance = [&](std::size_t a, std::size_t b) { return glm::distance(vertices[all[a]], vertices[all[b]]); };
  std::vector<std::size_t> chosen{0, 1};
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = a + 1; b < 8; ++b)
      if (distance(a, b) > distance(chosen[0], chosen[1])) chosen = {a, b};
  while (chosen.size() < 4) {
    float best_sum = -1.0f;
    std::size_t best = 0;
    for (std::size_t candidate = 0; candidate < 8; ++candidate) {
      if (std::ranges::find(chosen, candidate) != chosen.end()) continue;
      float sum = 0.0f;
      for (const std::size_t corner : chosen) sum += distance(candidate, corner);
      if (sum > best_sum) std::tie(best_sum, best) = std::pair(sum, candidate);
    }
    chosen.push_back(best);
  }
  return {all[chosen[0]], all[chosen[2]], all[chosen[1]], all[chosen[3]]};
}

/// Merges neighbours in `line` (leaf ids along a curve) in random order; result i is id leaf_count + i.
std::vector<std::pair<std::uint32_t, std::uint32_t>> random_merges(std::vector<std::uint32_t> line, Random& random) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> merges;
  auto next_id = static_cast<std::uint32_t>(line.size());
  while (line.size() > 1) {
    const std::uint32_t at = random.below(static_cast<std::uint32_t>(line.size()) - 1);
    merges.push_back({std::min(line[at], line[at + 1]), std::max(line[at], line[at + 1])});
    line[at] = next_id++;
    line.erase(line.begin() + at + 1);
  }
  return merges;
}

bake::Image disc_image(std::uint32_t side, Random& random) {
  bake::Image image{side, side, {}};
  const float centre = static_cast<float>(side - 1) * 0.5f, radius = static_cast<float>(side) * 0.4f;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      const bool inside = std::hypot(static_cast<float>(x) - centre, static_cast<float>(y) - centre) <= radius;
      const auto green = static_cast<std::uint8_t>(120 + random.below(80));
      const std::array<std::uint8_t, 4> texel = {static_cast<std::uint8_t>(inside ? 60 : 0), inside ? green : std::uint8_t{0}, 30,
                                                 static_cast<std::uint8_t>(inside ? 255 : 0)};
      image.rgba.insert(image.rgba.end(), texel.begin(), texel.end());
    }
  return image;
}

bake::ErrorTable plausible_errors(std::uint32_t leaf_count) {
  bake::ErrorTable table;
  for (std::uint32_t level = 0; level < 6; ++level) {
    const auto leaves = static_cast<std::uint32_t>(std::pow(static_cast<double>(leaf_count), level / 5.0));
    if (table.leaf_counts.empty() || leaves > table.leaf_counts.back()) table.leaf_counts.push_back(leaves);
  }
  if (table.leaf_counts.back() != leaf_count) table.leaf_counts.push_back(leaf_count);
  table.sizes_px = {16.0f, 64.0f, 256.0f};
  for (std::uint32_t leaves : table.leaf_counts)
    for (float size : table.sizes_px)
      table.error_px.push_back(leaves == leaf_count ? 0.0f : size / std::sqrt(static_cast<float>(leaves)) * 0.1f);
  return table;
}

/// At most a step away.
std::uint32_t near_step(std::uint32_t step, std::uint32_t largest, Random& random) {
  return std::min(std::max(step + random.below(3), 1u) - 1, largest);
}

std::uint16_t random_normals(Random& random) {
  const auto side = static_cast<NormalSide>(random.below(4));
  const std::uint32_t u = random.below(kAxisSteps + 1), v = random.below(kAxisSteps + 1), along = random.below(kAlongSteps + 1);
  return side == NormalSide::own_quad ? kFlatNormals : coarse_enough(pack_normals(u, v, along, side));
}

std::uint16_t near_normals(std::uint16_t normals, bool is_source, bool is_sided, Random& random) {
  NormalSide side = NormalSide::either;
  if (is_sided) {
    const bool is_same = random.below(8) > 0 && side_of(normals) != NormalSide::own_quad && side_of(normals) != NormalSide::either;
    side = is_same ? side_of(normals) : random.below(2) == 0 ? NormalSide::along : NormalSide::against;
  }
  const std::uint32_t u = near_step(axis_step_of(normals, 0), kAxisSteps, random),
                      v = near_step(axis_step_of(normals, 1), kAxisSteps, random);
  const std::uint32_t along = near_step(along_step_of(normals), kAlongSteps, random);
  return coarse_enough(pack_normals(u, v, is_source ? kAlongSteps : along, side));
}

/// Adds a leaf: a flat pyramid over its quad.
void add_leaf_mesh(bake::LeafMeshPart& part, const bake::Quad& quad, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(part.mesh.positions.size());
  const glm::vec3 across = glm::cross(quad[2] - quad[0], quad[3] - quad[1]);
  const glm::vec3 normal = glm::normalize(across);
  part.mesh.positions.insert(part.mesh.positions.end(), quad.begin(), quad.end());
  part.mesh.positions.push_back(0.25f * (quad[0] + quad[1] + quad[2] + quad[3]) + 0.2f * std::sqrt(glm::length(across)) * normal);
  part.mesh.uvs.insert(part.mesh.uvs.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5f, 0.5f}});
  for (std::uint32_t corner = 0; corner < 5; ++corner) {
    part.mesh.normals.push_back(normal);
    part.stalks.push_back(quad[0]);
  }
  for (std::uint32_t side = 0; side < 4; ++side) {
    part.mesh.indices.insert(part.mesh.indices.end(), {first + side, first + (side + 1) % 4, first + 4});
    part.mesh.triangle_materials.push_back(material);
  }
}

bake::LeafMeshes leaf_meshes_of(const bake::Foliage& foliage, std::uint32_t part_count, std::uint32_t material,
                                const std::vector<float>& sizes_px) {
  bake::LeafMeshes meshes;
  meshes.parts.resize(part_count);
  for (std::uint32_t leaf = 0; leaf < foliage.leaf_count(); ++leaf)
    add_leaf_mesh(meshes.parts[std::uint64_t{leaf} * part_count / foliage.leaf_count()], foliage.quads[leaf], material);
  for (const float size_px : sizes_px) meshes.error_px.push_back(size_px / 200.0f);
  return meshes;
}

/// A grid of two nodes a side that says something else at each, within the limits.
bake::Wind random_wind(float radius_m, Random& random) {
  bake::Wind wind;
  coppice_file_wind& head = wind.head;
  head.base_y_m = -radius_m;
  head.height_m = 2.0f * radius_m;
  head.bend_m = head.lean_m = head.sway_m = 0.01f * radius_m;
  for (int axis = 0; axis < 3; ++axis) head.box_min[axis] = -radius_m, head.box_max[axis] = radius_m;
  head.node_side = 2;
  for (int i = 0; i < 8; ++i)
    wind.nodes.push_back({static_cast<std::uint8_t>(random.between(0.0f, 255.0f)), static_cast<std::int8_t>(random.between(1.0f, 127.0f)),
                          static_cast<std::int8_t>(random.between(-127.0f, 127.0f)), 0});
  return wind;
}

}  // namespace

bake::Foliage random_foliage(std::uint32_t leaf_count, std::uint32_t seed, std::uint32_t card_count) {
  Random random(seed);
  bake::Foliage foliage;
  for (std::uint32_t card = 0; card < card_count; ++card) {
    const float low = static_cast<float>(card) / static_cast<float>(card_count),
                high = static_cast<float>(card + 1) / static_cast<float>(card_count);
    foliage.card_table.push_back({0, {glm::vec2(low, 1), glm::vec2(low, 0), glm::vec2(high, 0), glm::vec2(high, 1)}});
  }
  const float size = 0.8f / std::cbrt(static_cast<float>(leaf_count));
  for (std::uint32_t leaf = 0; leaf < leaf_count; ++leaf) {
    const glm::vec3 stalk = random.in_ball();
    const glm::vec3 along = glm::normalize(random.in_ball() + glm::vec3(0.0f, 0.1f, 0.0f));
    const glm::vec3 across = glm::normalize(glm::cross(along, glm::vec3(along.y, along.z, -along.x) + glm::vec3(0.01f, 0.02f, 0.03f)));
    const glm::vec3 length = along * size * random.between(0.8f, 1.2f), half = across * size * random.between(0.2f, 0.3f);
    foliage.quads.push_back({stalk - half, stalk - half + length, stalk + half + length, stalk + half});
    foliage.cards.push_back(random.below(card_count));
  }
  return foliage;
}

bake::Tree random_tree(const bake::Foliage& foliage, std::uint32_t seed) {
  Random random(seed ^ 0x5eedu);
  const std::uint32_t leaf_count = foliage.leaf_count(), split_count = leaf_count - 1;
  std::vector<std::uint32_t> line(leaf_count);
  std::iota(line.begin(), line.end(), 0u);
  std::ranges::stable_sort(line, {}, [&](std::uint32_t leaf) { return morton_code(glm::clamp(foliage.quads[leaf][0], -1.0f, 1.0f)); });
  const auto merges = random_merges(line, random);

  bake::Tree tree;
  std::vector<Corners> corners(2 * leaf_count - 1);
  std::vector<std::uint32_t> cards(foliage.cards);
  for (std::uint32_t leaf = 0; leaf < leaf_count; ++leaf) {
    corners[leaf] = {4 * leaf, 4 * leaf + 1, 4 * leaf + 2, 4 * leaf + 3};
    tree.vertices.insert(tree.vertices.end(), foliage.quads[leaf].begin(), foliage.quads[leaf].end());
  }
  for (std::uint32_t i = 0; i < split_count; ++i) {
    corners[leaf_count + i] = merge_corners(tree.vertices, corners[merges[i].first], corners[merges[i].second]);
    cards.push_back(cards[merges[i].first]);
  }
  tree.nodes.resize(2 * leaf_count - 1);
  tree.node_split.assign(2 * leaf_count - 1, bake::kNone);
  tree.node_source.assign(2 * leaf_count - 1, bake::kNone);
  std::vector<std::uint32_t> node_of(2 * leaf_count - 1, 0);
  for (std::uint32_t split = 0; split < split_count; ++split) {
    const std::uint32_t merge = split_count - 1 - split;
    tree.split_parent.push_back(node_of[leaf_count + merge]);
    tree.node_split[tree.split_parent.back()] = split;
    node_of[merges[merge].first] = 2 * split + 1;
    node_of[merges[merge].second] = 2 * split + 2;
  }
  for (std::uint32_t id = 0; id < 2 * leaf_count - 1; ++id) {
    tree.nodes[node_of[id]] = {corners[id], cards[id]};
    if (id < leaf_count) tree.node_source[node_of[id]] = id;
  }
  return tree;
}

std::uint16_t coarse_enough(std::uint16_t normals) {
  const std::uint32_t along = along_step_of(normals), bits = axis_bits(along);
  const auto step = [&](std::size_t which) { return axis_step_from(axis_step_of(normals, which) >> (kAxisBits - bits), bits); };
  return pack_normals(step(0), step(1), along, side_of(normals));
}

void set_looks(bake::Tree& tree, Looks looks, std::uint32_t seed) {
  if (looks == Looks::plain) return;
  Random random(seed ^ 0xfadeu);
  std::vector<std::uint32_t> parents(tree.nodes.size(), 0);
  for (std::uint32_t split = 0; split < tree.split_parent.size(); ++split)
    parents[2 * split + 1] = parents[2 * split + 2] = tree.split_parent[split];
  for (std::size_t node = 0; node < tree.nodes.size(); ++node) {
    const bool is_source = tree.node_split[node] == bake::kNone, is_noise = looks == Looks::noise, is_sided = looks == Looks::sided;
    const bake::Tree::Node& parent = tree.nodes[parents[node]];
    const std::uint8_t opacity = static_cast<std::uint8_t>(1 + (is_noise ? random.below(16) : near_step(parent.opacity - 1u, 15, random)));
    const std::uint16_t normals = is_noise ? random_normals(random) : near_normals(parent.normals, is_source, is_sided, random);
    if (!is_source) tree.nodes[node].opacity = opacity;
    if (!is_source || is_noise || is_sided) tree.nodes[node].normals = normals;
  }
}

bake::Mesh tube(std::uint32_t sides, std::uint32_t rings, std::uint32_t material) {
  bake::Mesh mesh;
  for (std::uint32_t ring = 0; ring < rings; ++ring)
    for (std::uint32_t side = 0; side <= sides; ++side) {
      const float along = static_cast<float>(ring) / static_cast<float>(rings - 1),
                  around = static_cast<float>(side) / static_cast<float>(sides);
      const float angle = around * 6.2831853f, radius = 0.1f * (1.0f - 0.8f * along);
      const glm::vec3 outward(std::cos(angle), 0.0f, std::sin(angle));
      mesh.positions.push_back(outward * radius + glm::vec3(0.0f, 2.0f * along - 1.5f, 0.0f));
      mesh.normals.push_back(outward);
      mesh.uvs.emplace_back(around, along);
    }
  for (std::uint32_t ring = 0; ring + 1 < rings; ++ring)
    for (std::uint32_t side = 0; side < sides; ++side) {
      const std::uint32_t a = ring * (sides + 1) + side, b = a + sides + 1;
      mesh.indices.insert(mesh.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
      mesh.triangle_materials.insert(mesh.triangle_materials.end(), {material, material});
    }
  return mesh;
}

bake::BakedPlant random_plant(const RandomPlantOptions& options) {
  Random random(options.seed + 77);
  const bake::Foliage foliage = random_foliage(options.leaf_count, options.seed, options.card_count);
  bake::BakedPlant plant;
  plant.name = "random";
  plant.metric = 1;
  plant.tree = random_tree(foliage, options.seed);
  set_looks(plant.tree, options.looks, options.seed);
  plant.card_table = foliage.card_table;
  const bool textured = options.texture_side > 0;
  plant.materials.push_back({"leaves", glm::vec4(1.0f), textured ? 0 : bake::kNone, textured ? 0.5f : 0.0f, 0.8f, true});
  plant.materials.push_back({"wood", glm::vec4(0.4f, 0.3f, 0.2f, 1.0f), bake::kNone, 0.0f, 0.9f, false});
  if (textured) plant.images.push_back(disc_image(options.texture_side, random));
  plant.errors = plausible_errors(options.leaf_count);
  if (options.leaf_mesh_count > 0) {
    plant.leaf_meshes = leaf_meshes_of(foliage, options.leaf_mesh_count, 2, plant.errors.sizes_px);
    plant.materials.push_back({"leaf meshes", glm::vec4(1.0f), textured ? 1 : bake::kNone, textured ? 0.5f : 0.0f, 0.8f, true});
    if (textured) plant.images.push_back(disc_image(options.texture_side, random));
  }
  for (std::uint32_t lod = 0; lod < options.wood_lod_count; ++lod) {
    plant.wood.lods.push_back(tube(lod == 0 ? 8 : 4, lod == 0 ? 6 : 3, 1));
    for (const float size_px : plant.errors.sizes_px) plant.wood.error_px.push_back(size_px * 0.05f * static_cast<float>(lod + 1));
  }
  const auto hold = [&](const std::vector<glm::vec3>& vertices) {
    for (const glm::vec3& vertex : vertices) plant.sphere.radius = std::max(plant.sphere.radius, glm::length(vertex));
  };
  hold(plant.tree.vertices);
  for (const bake::Mesh& lod : plant.wood.lods) hold(lod.positions);
  for (const bake::LeafMeshPart& part : plant.leaf_meshes.parts) hold(part.mesh.positions);
  if (options.leaf_count > 1) plant.wind = random_wind(plant.sphere.radius, random);
  return plant;
}

}  // namespace coppice::test
