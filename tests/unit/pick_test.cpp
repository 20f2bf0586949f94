// What a ray hits: the geometry against slower and plainer versions of itself, and coppice_pick against every triangle of a plant.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "abi.h"
#include "host.h"
#include "instances.h"
#include "pick.h"

namespace coppice::test::pick_test {

class Rays {
 public:
  vec3 place(float reach) { return {number(reach), number(reach), number(reach)}; }
  vec3 direction() {
    for (;;) {
      const vec3 v = place(1.0f);
      if (const float size = length(v); size > 0.1f && size < 1.0f) return v * (1.0f / size);
    }
  }
  float number(float reach) { return std::uniform_real_distribution<float>(-reach, reach)(generator_); }

 private:
  std::mt19937 generator_{7};
};

/// The first of many steps along the ray that is inside.
template <class Inside>
float first_step(const Ray& ray, const Inside& inside) {
  constexpr float kStep = 0.002f;
  for (int i = 0; i < 5000; ++i)
    if (const float t = kStep * static_cast<float>(i); inside(ray.origin + ray.direction * t)) return t;
  return kMissed;
}

TEST(Pick, EntersSpheresAndBoxesWhereStepsAlongTheRayDo) {
  Rays random;
  int hits = 0;
  for (int i = 0; i < 1000; ++i) {
    const Ray ray{random.place(2.0f), random.direction()};
    const vec3 center = random.place(1.5f);
    const float sphere = sphere_entry(ray, center, 0.7f);
    const float stepped = first_step(ray, [&](const vec3& p) { return distance(p, center) <= 0.7f; });
    if (stepped != kMissed) {
      EXPECT_NEAR(sphere, stepped, 0.0025f);
      ++hits;
    }
    const vec3 low = center - vec3(0.3f, 0.6f, 0.9f), high = center + vec3(0.3f, 0.6f, 0.9f);
    const float box = box_entry(ray, low, high);
    const float box_stepped = first_step(ray, [&](const vec3& p) { return clamp(p, low, high) == p; });
    EXPECT_TRUE(box_stepped == kMissed || std::abs(box - box_stepped) < 0.0025f);
    EXPECT_TRUE(box != kMissed || box_stepped == kMissed);
    EXPECT_TRUE(sphere != kMissed || stepped == kMissed);
  }
  EXPECT_GT(hits, 30);
}

TEST(Pick, AFlatBoxAndARayAlongAnAxisAreHit) {
  const Ray down{{0.5f, 3.0f, 0.5f}, {0, -1, 0}};
  EXPECT_EQ(box_entry(down, {0, 1, 0}, {1, 1, 1}), 2.0f);
  EXPECT_EQ(box_entry(down, {2, 1, 0}, {3, 1, 1}), kMissed);
  EXPECT_EQ(box_entry(down, {0, 4, 0}, {1, 5, 1}), kMissed) << "behind it";
  EXPECT_EQ(box_entry(down, {0, 2, 0}, {1, 5, 1}), 0.0f) << "from within";
  EXPECT_EQ(sphere_entry(down, {0.5f, 2.5f, 0.5f}, 1.0f), 0.0f);
  EXPECT_EQ(sphere_entry(down, {0.5f, 5.0f, 0.5f}, 1.0f), kMissed);
}

TEST(Pick, TrianglesAreHitFromBothSidesAndNotBeside) {
  Rays random;
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const std::array<vec3, 3> triangle{random.place(1.0f), random.place(1.0f), random.place(1.0f)};
    const Ray ray{random.place(2.0f), random.direction()};
    const float t = triangle_hit(ray, triangle);
    EXPECT_EQ(triangle_hit(ray, {triangle[2], triangle[1], triangle[0]}) == kMissed, t == kMissed);
    if (t == kMissed) continue;
    ++hits;
    // Where it hits, the three triangles to the corners are as large as the whole.
    const vec3 place = ray.origin + ray.direction * t;
    const auto area = [](const vec3& a, const vec3& b, const vec3& c) { return 0.5f * length(cross(b - a, c - a)); };
    float parts = 0;
    for (std::size_t k = 0; k < 3; ++k) parts += area(place, triangle[k], triangle[(k + 1) % 3]);
    EXPECT_NEAR(parts, area(triangle[0], triangle[1], triangle[2]), 2e-4f);
  }
  EXPECT_GT(hits, 100);
}

coppice_ray ray_of(const std::array<double, 3>& origin, const vec3& direction) {
  auto ray = struct_defaults<coppice_ray>();
  std::ranges::copy(origin, ray.origin);
  for (std::size_t axis = 0; axis < 3; ++axis) ray.direction[axis] = direction[axis];
  return ray;
}

coppice_hit pick(Host& host, const coppice_ray& ray) {
  auto hit = struct_defaults<coppice_hit>();
  EXPECT_EQ(coppice_pick(host.context(), &ray, &hit), COPPICE_OK) << coppice_last_error(host.context());
  return hit;
}

/// Triangles of a plant's leaves and wood, object space, of doubles.
struct Triangles {
  std::vector<std::array<dvec3, 3>> leaves, wood;
};

double brute_hit(const std::vector<std::array<dvec3, 3>>& triangles, const dvec3& origin, const dvec3& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : triangles) {
    const dvec3 normal = cross(b - a, c - a);
    const double t = dot(a - origin, normal) / dot(direction, normal);
    const dvec3 place = origin + direction * t;
    const bool inside =
        dot(cross(b - a, place - a), normal) >= 0 && dot(cross(c - b, place - b), normal) >= 0 && dot(cross(a - c, place - c), normal) >= 0;
    if (inside && t >= 0 && t < nearest) nearest = t;
  }
  return nearest;
}

Triangles triangles_of(Host& host) {
  Triangles triangles;
  auto layout = struct_defaults<coppice_leaf_layout>();
  layout.vertex_bytes = sizeof(float[3]);
  layout.position = 0;
  auto output = struct_defaults<coppice_leaf_output>();
  EXPECT_EQ(coppice_write_leaves(host.context(), 0, 512.0f, &layout, &output), COPPICE_OK);
  std::vector<std::array<float, 3>> vertices(output.vertex_count);
  std::vector<std::uint32_t> indices(output.index_count);
  output.vertices = vertices.data();
  output.indices = indices.data();
  output.vertex_capacity = output.vertex_count;
  output.index_capacity = output.index_count;
  EXPECT_EQ(coppice_write_leaves(host.context(), 0, 512.0f, &layout, &output), COPPICE_OK);
  const auto place = [&](std::uint32_t index) { return dvec3(vec3(std::span<const float, 3>(vertices[index]))); };
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3)
    triangles.leaves.push_back({place(indices[i]), place(indices[i + 1]), place(indices[i + 2])});
  for (const std::array<vec3, 3>& triangle : host.wood)
    triangles.wood.push_back({dvec3(triangle[0]), dvec3(triangle[1]), dvec3(triangle[2])});
  return triangles;
}

class PickAtScale : public testing::TestWithParam<float> {};
INSTANTIATE_TEST_SUITE_P(Scale, PickAtScale, testing::Values(1.7f, -1.7f));

/// Far from where coordinates began, turned, scaled and mirrored: every hit is one of the plant's triangles, as doubles find it.
TEST_P(PickAtScale, HitsTheNearestTriangleOfCrownAndWood) {
  constexpr std::array kPlace{3.0e6, 40.0, -2.0e6};
  const float scale = GetParam();
  Host host;
  const coppice_plant plant = host.open("two_pages.coppice");
  auto placement = gpu::default_placement();
  std::ranges::copy(kPlace, placement.position);
  placement.scale = scale;
  placement.rotation[1] = placement.rotation[3] = std::sqrt(0.5f);  // a quarter turn: object's x is the world's -z
  coppice_instance instance = 0;
  ASSERT_EQ(coppice_instances_add(host.context(), plant, &placement, sizeof placement, 1, &instance), COPPICE_OK);
  host.camera().view_from_world[12] = -kPlace[0];
  host.camera().view_from_world[13] = -kPlace[1];
  host.camera().view_from_world[14] = -kPlace[2] - 5.0;
  host.settle();
  const Triangles triangles = triangles_of(host);
  ASSERT_EQ(triangles.leaves.size(), 1024u);
  ASSERT_FALSE(triangles.wood.empty());
  const auto to_object = [](const dvec3& v) { return dvec3{-v.z, v.y, v.x}; };
  const coppice_plant_info info = host.info(plant);
  Rays random;
  int crowns = 0, woods = 0, misses = 0;
  for (int i = 0; i < 600; ++i) {
    const vec3 from = random.direction() * (3.0f * 1.7f * info.sphere_radius);
    const vec3 direction = normalize(random.place(info.sphere_radius) - from);
    const coppice_hit hit = pick(host, ray_of({kPlace[0] + from.x, kPlace[1] + from.y, kPlace[2] + from.z}, direction));
    const dvec3 origin = to_object(dvec3(from)) * (1.0 / scale), along = to_object(dvec3(direction)) * (1.0 / scale);
    const double leaf = brute_hit(triangles.leaves, origin, along), wood = brute_hit(triangles.wood, origin, along);
    if (hit.kind == COPPICE_HIT_NOTHING) {
      ++misses;
      EXPECT_EQ(std::min(leaf, wood), std::numeric_limits<double>::infinity());
      EXPECT_EQ(hit.instance, 0u);
      continue;
    }
    EXPECT_EQ(hit.instance, instance);
    EXPECT_EQ(hit.plant, plant);
    EXPECT_NEAR(hit.distance_m, std::min(leaf, wood), 1e-3);
    EXPECT_EQ(hit.kind, leaf < wood ? COPPICE_HIT_CROWN : COPPICE_HIT_WOOD);
    EXPECT_NEAR(hit.position[0], kPlace[0] + from.x + direction.x * hit.distance_m, 1e-4);
    (hit.kind == COPPICE_HIT_CROWN ? crowns : woods) += 1;
  }
  EXPECT_GT(crowns, 50);
  EXPECT_GT(woods, 5);
  EXPECT_GT(misses, 20);
}

TEST(PickRuntime, TakesTheNearestOfManyWithinItsReachAndLayers) {
  Host host;
  const coppice_plant plant = host.open("wood_and_texture.coppice");
  const coppice_plant_info info = host.info(plant);
  const double middle = 0.5 * static_cast<double>(info.box_min[1] + info.box_max[1]) - 1.0;  // Host::add stands them at -1
  std::vector<coppice_instance> row;
  for (int i = 0; i < 200; ++i) row.push_back(host.add(plant, 0, -10.0f * static_cast<float>(i + 1)));
  host.frame();
  coppice_ray ray = ray_of({0, middle, 0}, {0, 0, -1});
  ray.boxes = COPPICE_TRUE;
  coppice_hit hit = pick(host, ray);
  EXPECT_EQ(hit.kind, COPPICE_HIT_BOX);
  EXPECT_EQ(hit.instance, row[0]);
  EXPECT_NEAR(hit.distance_m, 10.0f - info.box_max[2], 1e-4f);
  ray.max_distance_m = 5.0f;
  EXPECT_EQ(pick(host, ray).kind, COPPICE_HIT_NOTHING);
  ray.max_distance_m = 1e9f;
  ray.origin[2] = -95.0;
  EXPECT_EQ(pick(host, ray).instance, row[9]);
  ray.direction[2] = 1.0f;
  EXPECT_EQ(pick(host, ray).instance, row[8]) << "backwards";
  ray.direction[2] = -1.0f;
  ASSERT_EQ(coppice_instances_remove(host.context(), &row[9], 1), COPPICE_OK);
  EXPECT_EQ(pick(host, ray).instance, row[10]) << "what is removed is gone at once";

  auto placement = gpu::default_placement();
  placement.position[1] = -1.0;
  placement.position[2] = -110.0;
  placement.layer_mask = 4;
  placement.user_data = 77;
  ASSERT_EQ(coppice_instances_move(host.context(), &row[10], &placement, sizeof placement, 1), COPPICE_OK);
  EXPECT_EQ(pick(host, ray).user_data, 77u);
  ray.layer_mask = ~4u;
  EXPECT_EQ(pick(host, ray).instance, row[11]);

  // The origin moves along: the same ray in other numbers.
  const double origin[3] = {0, 0, -95.0};
  ASSERT_EQ(coppice_set_origin(host.context(), origin), COPPICE_OK);
  ray.origin[2] = 0.0;
  hit = pick(host, ray);
  EXPECT_EQ(hit.instance, row[11]);
  EXPECT_NEAR(hit.position[2], -25.0 + static_cast<double>(info.box_max[2]), 1e-4);
}

TEST(PickRuntime, ACrownThatIsBareLetsTheRayThrough) {
  Host host;
  const coppice_plant plant = host.open("two_pages.coppice");
  const coppice_instance instance = host.add(plant, 0, -5);
  host.settle();
  Rays random;
  std::optional<coppice_ray> through_crown;
  for (int i = 0; i < 200 && !through_crown; ++i) {
    const coppice_ray ray = ray_of({0, -1, 0}, normalize(vec3(0, 0, -5) + random.place(1.0f)));
    if (pick(host, ray).kind == COPPICE_HIT_CROWN) through_crown = ray;
  }
  ASSERT_TRUE(through_crown);
  auto bare = gpu::default_placement();
  bare.position[1] = -1.0;
  bare.position[2] = -5.0;
  bare.leaf_share = 0.0f;
  ASSERT_EQ(coppice_instances_move(host.context(), &instance, &bare, sizeof bare, 1), COPPICE_OK);
  EXPECT_NE(pick(host, *through_crown).kind, COPPICE_HIT_CROWN);
  through_crown->boxes = COPPICE_TRUE;
  EXPECT_EQ(pick(host, *through_crown).kind, COPPICE_HIT_BOX);
}

TEST(PickRuntime, WrongRaysAreRefused) {
  Host host;
  auto hit = struct_defaults<coppice_hit>();
  const auto expect_refused = [&](const char* field, auto change) {
    coppice_ray ray = ray_of({0, 0, 0}, {0, 0, -1});
    change(ray);
    EXPECT_EQ(coppice_pick(host.context(), &ray, &hit), COPPICE_ERROR_INVALID_ARGUMENT) << field;
    EXPECT_NE(std::string(coppice_last_error(host.context())).find(field), std::string::npos) << coppice_last_error(host.context());
  };
  expect_refused("ray.origin[1]", [](coppice_ray& ray) { ray.origin[1] = NAN; });
  expect_refused("ray.direction", [](coppice_ray& ray) { ray.direction[0] = 1.0f; });
  expect_refused("ray.direction[2]", [](coppice_ray& ray) { ray.direction[2] = INFINITY; });
  expect_refused("ray.max_distance_m", [](coppice_ray& ray) { ray.max_distance_m = 0.0f; });
  expect_refused("ray.max_distance_m", [](coppice_ray& ray) { ray.max_distance_m = NAN; });
  expect_refused("ray.boxes", [](coppice_ray& ray) { ray.boxes = 2; });
  expect_refused("ray.reserved", [](coppice_ray& ray) { ray.reserved = 1; });
  expect_refused("ray.struct_size", [](coppice_ray& ray) { ray.struct_size = 3; });
  coppice_ray ray = ray_of({0, 0, 0}, {0, 0, -1});
  hit.struct_size = 0;
  EXPECT_EQ(coppice_pick(host.context(), &ray, &hit), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(coppice_pick(host.context(), nullptr, &hit), COPPICE_ERROR_INVALID_ARGUMENT);
}

}  // namespace coppice::test::pick_test
