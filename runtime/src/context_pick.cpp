// Finds what a ray hits first.

#include <algorithm>
#include <cstring>
#include <vector>

#include "context.h"
#include "convert.h"
#include "cut_nodes.h"
#include "pick.h"

namespace coppice {
namespace {

/// Maximum leaves of the cut that is tested: a cut as coarse as its crown takes some microseconds.
constexpr std::uint32_t kMaxPickedLeaves = 512;

/// An instance whose sphere the ray enters.
struct Candidate {
  float entry_m = 0;
  std::uint32_t slot = 0;
};

vec3 divided(const vec3& v, const vec3& by) {
  const auto safe = [](float of, float to) { return to > 0.0f ? of / to : of; };
  return {safe(v.x, by.x), safe(v.y, by.y), safe(v.z, by.z)};
}

/// The ray in coordinates q, where positions are low + step * q; a box that is flat along an axis has a single q there.
Ray quantised_ray(const Ray& ray, const vec3& low, const vec3& step) {
  return {divided(ray.origin - low, step), divided(ray.direction, step)};
}

vec3 point(const QuantisedPoint& q) {
  return {float(q[0]), float(q[1]), float(q[2])};
}

}  // namespace

coppice_hit Context::pick(const coppice_ray& asked) const {
  const dvec3 from_m = dvec3(asked.origin) + origin();
  const vec3 direction(asked.direction);
  const InstanceBlocks blocks = instances_.blocks();
  const auto entry_of = [&](const dvec3& center_m, float radius_m) {
    const float entry_m = sphere_entry({{0, 0, 0}, direction}, (center_m - from_m).rounded(), radius_m);
    return entry_m <= asked.max_distance_m ? entry_m : kMissed;
  };
  std::vector<Candidate> candidates;
  for (std::size_t block = 0; block < blocks.bounds.size(); ++block) {
    const InstanceBounds& bounds = blocks.bounds[block];
    if (bounds.radius_m < 0.0f || entry_of(bounds.center_m, bounds.radius_m) == kMissed) continue;
    const std::size_t first = block * kInstanceBlockSlots, end = std::min(first + kInstanceBlockSlots, blocks.slots.size());
    for (std::size_t slot = first; slot < end; ++slot) {
      const InstanceSphere& sphere = blocks.slots[slot];
      if (plant_of(instances_.slots()[slot]) == gpu::kNoPlant || (sphere.layer_mask & asked.layer_mask) == 0) continue;
      const float entry_m = entry_of(sphere.center_m, sphere.radius_m);
      if (entry_m != kMissed) candidates.push_back({entry_m, static_cast<std::uint32_t>(slot)});
    }
  }
  std::ranges::sort(candidates, {}, [](const Candidate& of) { return std::pair(of.entry_m, of.slot); });

  coppice_hit hit{.struct_size = sizeof(coppice_hit)};
  float nearest_m = kMissed;
  std::uint32_t nearest_slot = 0;
  for (const Candidate& candidate : candidates) {
    if (candidate.entry_m >= nearest_m) break;
    const PlantHit found = hit_of(candidate.slot, {from_m + dvec3(direction) * double{candidate.entry_m}, direction, asked.boxes != 0});
    const float distance_m = candidate.entry_m + found.t_m;
    if (found.kind == COPPICE_HIT_NOTHING || distance_m >= nearest_m || distance_m > asked.max_distance_m) continue;
    nearest_m = distance_m;
    nearest_slot = candidate.slot;
    hit.kind = found.kind;
  }
  if (hit.kind == COPPICE_HIT_NOTHING) return hit;
  const gpu::Instance& instance = instances_.slots()[nearest_slot];
  hit.plant = plant_at(plant_of(instance));
  hit.instance = instances_.handle_at(nearest_slot);
  hit.tree = tree_at(nearest_slot);
  const dvec3 place = dvec3(asked.origin) + dvec3(direction) * double{nearest_m};
  std::memcpy(hit.position, &place, sizeof hit.position);
  hit.distance_m = nearest_m;
  hit.user_data = instance.user_data;
  return hit;
}

Context::PlantHit Context::hit_of(std::uint32_t slot, const PickRay& from) const {
  const gpu::Instance& instance = instances_.slots()[slot];
  const std::uint32_t file = plant_of(instance);
  // Near the plant floats are as precise as doubles.
  const vec4 to_object{-instance.rotation.x, -instance.rotation.y, -instance.rotation.z, instance.rotation.w};
  const Ray ray{gpu::oriented(to_object, (from.start_m - place_of(instance)).rounded()) * (1.0f / instance.scale),
                gpu::oriented(to_object, from.direction) * (1.0f / instance.scale)};
  const PlantBox& box = streamer_->box(file);
  const vec3 low(box.low), high(box.high);
  PlantHit hit{.t_m = box_entry(ray, low, high)};
  if (hit.t_m == kMissed) return hit;
  if (from.boxes) {
    hit.kind = COPPICE_HIT_BOX;
    return hit;
  }
  hit.t_m = kMissed;
  const auto nearer = [&hit](float t_m, coppice_hit_kind kind) {
    if (t_m < hit.t_m) hit = {kind, t_m};
  };
  const Ray in_wood = quantised_ray(ray, low, (high - low) * (1.0f / kBoxSteps));
  for (const BoxTriangle& triangle : streamer_->coarse_wood(file))
    nearer(triangle_hit(in_wood, {point(triangle[0]), point(triangle[1]), point(triangle[2])}), COPPICE_HIT_WOOD);
  if (gpu::leaf_share_of(instance) == 0.0f) return hit;
  const gpu::LeafBox leaves = gpu::leaf_box(gpu::gpu_plant(this->file(file).plant));
  const Ray in_crown = quantised_ray(ray, leaves.min, leaves.step);
  for_each_leaf(*streamer_, file, std::min(streamer_->state(file).resident_leaf_count, kMaxPickedLeaves), [&](const PageNode& node) {
    const vec3 a = point(node.corners[0]), b = point(node.corners[1]), c = point(node.corners[2]), d = point(node.corners[3]);
    nearer(std::min(triangle_hit(in_crown, {a, b, c}), triangle_hit(in_crown, {a, c, d})), COPPICE_HIT_CROWN);
  });
  return hit;
}

}  // namespace coppice
