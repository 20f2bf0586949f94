#include "plant_grower.h"

#include <algorithm>
#include <map>

namespace coppice::bake::test {

void Grower::lathe(const std::vector<glm::vec3>& centers, const std::vector<float>& radii, std::uint32_t side_count) {
  std::vector<std::vector<std::uint32_t>> rings;
  const glm::vec3 axis = glm::normalize(centers.back() - centers.front()), x = any_across(axis), y = glm::cross(axis, x);
  for (std::size_t i = 0; i < centers.size(); ++i) {
    std::vector<std::uint32_t> ring;
    const std::uint32_t tip = radii[i] > 0.0f ? kNone : vertex(centers[i]);
    for (std::uint32_t k = 0; k < side_count; ++k) {
      const float angle = 2.0f * kPi * static_cast<float>(k) / static_cast<float>(side_count);
      ring.push_back(tip != kNone ? tip : vertex(centers[i] + radii[i] * (std::cos(angle) * x + std::sin(angle) * y)));
    }
    rings.push_back(std::move(ring));
  }
  for (std::size_t i = 0; i + 1 < rings.size(); ++i)
    for (std::uint32_t k = 0; k < side_count; ++k) {
      const std::uint32_t next = (k + 1) % side_count;
      if (radii[i] > 0.0f) triangle(rings[i][k], rings[i][next], rings[i + 1][k]);
      if (radii[i + 1] > 0.0f) triangle(rings[i + 1][k], rings[i][next], rings[i + 1][next]);
    }
}

void Grower::box(const glm::vec3& low, const glm::vec3& high) {
  std::array<std::uint32_t, 8> corner{};
  for (std::uint32_t i = 0; i < 8; ++i)
    corner[i] = vertex({(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z});
  constexpr std::array<std::array<std::size_t, 4>, 6> kSides{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : kSides) quad(corner[a], corner[b], corner[c], corner[d]);
}

void Grower::blade(const Blade& of, std::array<std::uint32_t, 2> root) {
  glm::vec3 at = of.root, along = of.along;
  const glm::vec3 across = 0.5f * of.width_m * any_across(of.along), down = glm::cross(glm::normalize(across), along);
  std::uint32_t left = root[0] != kNone ? root[0] : vertex(at - across), right = root[1] != kNone ? root[1] : vertex(at + across);
  for (std::uint32_t i = 1; i <= of.segment_count; ++i) {
    const float angle = of.bend * static_cast<float>(i) / static_cast<float>(of.segment_count);
    along = std::cos(angle) * of.along - std::sin(angle) * down;
    at += of.length_m / static_cast<float>(of.segment_count) * along;
    if (i == of.segment_count) {
      triangle(left, right, vertex(at));
      return;
    }
    const float share = 1.0f - 0.6f * static_cast<float>(i) / static_cast<float>(of.segment_count);
    const std::uint32_t next_left = vertex(at - share * across), next_right = vertex(at + share * across);
    quad(left, right, next_right, next_left);
    left = next_left, right = next_right;
  }
}

void Grower::leaf(const glm::vec3& stalk, const glm::vec3& along, float length_m, float width_m, std::uint32_t side_count) {
  const glm::vec3 across = any_across(along), normal = glm::cross(across, along);
  const std::uint32_t middle = vertex(stalk + 0.5f * length_m * along - 0.05f * length_m * normal);
  std::vector<std::uint32_t> rim;
  for (std::uint32_t k = 0; k < side_count; ++k) {
    const float angle = 2.0f * kPi * static_cast<float>(k) / static_cast<float>(side_count);
    rim.push_back(vertex(stalk + 0.5f * length_m * (1.0f - std::cos(angle)) * along + 0.5f * width_m * std::sin(angle) * across));
  }
  for (std::uint32_t k = 0; k < side_count; ++k) triangle(middle, rim[k], rim[(k + 1) % side_count]);
}

Grower& Grower::facets() {
  Mesh& mesh = plant_.soup.mesh;
  std::vector<glm::vec3> positions;
  for (std::uint32_t& index : mesh.indices) {
    positions.push_back(mesh.positions[index]);
    index = static_cast<std::uint32_t>(positions.size() - 1);
  }
  mesh.positions = std::move(positions);
  mesh.normals.assign(mesh.positions.size(), kUp);
  mesh.uvs.assign(mesh.positions.size(), glm::vec2(0.0f));
  plant_.soup.vertex_instances.assign(mesh.positions.size(), 0);
  return *this;
}

OddPlant Grower::take() {
  Mesh& mesh = plant_.soup.mesh;
  std::vector<glm::vec3> sums(mesh.positions.size(), glm::vec3(0.0f));
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::uint32_t* t = &mesh.indices[i];
    const glm::vec3 normal = glm::cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    for (std::size_t k = 0; k < 3; ++k) sums[t[k]] += normal;
  }
  for (std::size_t i = 0; i < sums.size(); ++i)
    if (glm::length(sums[i]) > 0.0f) mesh.normals[i] = glm::normalize(sums[i]);
  return std::move(plant_);
}

void Grower::blob(const glm::vec3& center, const glm::vec3& radii_m, std::uint32_t steps, float rough) {
  const float g = 0.5f * (1.0f + std::sqrt(5.0f));
  std::vector<glm::vec3> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> faces{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (std::uint32_t step = 0; step < steps; ++step) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (is_new) points.push_back(points[a] + points[b]);
      return found->second;
    };
    for (glm::vec3& point : points) point = glm::normalize(point);
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  const auto first = static_cast<std::uint32_t>(plant_.soup.mesh.positions.size());
  for (const glm::vec3& point : points) vertex(center + radii_m * glm::normalize(point) * (1.0f + rough * between(-1.0f, 1.0f)));
  for (const auto& [a, b, c] : faces) triangle(first + a, first + b, first + c);
}

void Grower::thick_leaf(const glm::vec3& stalk, const glm::vec3& along, float length_m, float width_m) {
  constexpr std::array<float, 5> kAlong{0.1f, 0.3f, 0.55f, 0.75f, 0.9f}, kWidth{0.5f, 0.8f, 1.0f, 0.8f, 0.4f};
  const glm::vec3 across = any_across(along), normal = glm::cross(across, along);
  const std::uint32_t root = vertex(stalk), tip = vertex(stalk + length_m * along);
  std::array<std::uint32_t, 4> before{};
  for (std::size_t i = 0; i < kAlong.size(); ++i) {
    const glm::vec3 at = stalk + kAlong[i] * length_m * along, side = 0.5f * kWidth[i] * width_m * across,
                    up = 0.17f * kWidth[i] * width_m * normal;
    const std::array<std::uint32_t, 4> ring{vertex(at - side), vertex(at + up), vertex(at + side), vertex(at - up)};
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t next = (k + 1) % 4;
      if (i == 0) triangle(root, ring[k], ring[next]);
      if (i > 0) quad(before[k], ring[k], ring[next], before[next]);
      if (i + 1 == kAlong.size()) triangle(ring[k], tip, ring[next]);
    }
    before = ring;
  }
}

}  // namespace coppice::bake::test
