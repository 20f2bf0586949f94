#include "instances.h"

#include <algorithm>

#include "check.h"

namespace coppice::gpu {
namespace {

constexpr std::uint32_t kNoSlot = 0xffffffffu;

std::uint32_t slot_of(coppice_instance handle) {
  return static_cast<std::uint32_t>(handle & 0xffffffffu) - 1;
}
std::uint32_t generation_of(coppice_instance handle) {
  return static_cast<std::uint32_t>(handle >> 32);
}

vec3 rotate(const vec4& q, const vec3& v) {
  const vec3 t{2 * (q.y * v.z - q.z * v.y), 2 * (q.z * v.x - q.x * v.z), 2 * (q.x * v.y - q.y * v.x)};
  return {v.x + q.w * t.x + q.y * t.z - q.z * t.y, v.y + q.w * t.y + q.z * t.x - q.x * t.z, v.z + q.w * t.z + q.x * t.y - q.y * t.x};
}

}  // namespace

Result<DirtySlots> DirtySlots::create(const coppice_allocator& allocator, std::uint32_t slot_count) {
  DirtySlots slots;
  COPPICE_CHECK(allocate_into(slots.flags_, allocator, (slot_count + kDirtyBlockSlots - 1) / kDirtyBlockSlots));
  return slots;
}

void DirtySlots::mark(SlotRange range) {
  if (range.count == 0) return;
  const std::uint32_t first = range.first / kDirtyBlockSlots, end = (range.first + range.count - 1) / kDirtyBlockSlots + 1;
  std::ranges::fill(flags_.span().subspan(first, end - first), std::uint8_t{1});
  first_ = std::min(first_, first);
  end_ = std::max(end_, end);
}

SlotRange DirtySlots::take() {
  while (first_ < end_ && flags_[first_] == 0) ++first_;
  const std::uint32_t first = first_;
  while (first_ < end_ && flags_[first_] != 0) flags_[first_++] = 0;
  const SlotRange range{first * kDirtyBlockSlots, (first_ - first) * kDirtyBlockSlots};
  if (first_ < end_) return range;
  first_ = 0xffffffffu;
  end_ = 0;
  return range;
}

Result<InstanceTable> InstanceTable::create(const coppice_allocator& allocator, std::uint32_t max_instances, std::uint32_t max_plants) {
  InstanceTable table;
  COPPICE_TRY(instances, HookArray<Instance>::allocate(allocator, max_instances));
  COPPICE_TRY(spheres, HookArray<InstanceSphere>::allocate(allocator, max_instances));
  COPPICE_TRY(slots, HookArray<Slot>::allocate(allocator, max_instances));
  COPPICE_TRY(bounds, HookArray<InstanceBounds>::allocate(allocator, (max_instances + kInstanceBlockSlots - 1) / kInstanceBlockSlots));
  COPPICE_TRY(dirty, DirtySlots::create(allocator, max_instances));
  COPPICE_TRY(unbounded, DirtySlots::create(allocator, max_instances));
  table.instances_ = std::move(instances);
  table.spheres_ = std::move(spheres);
  table.slots_ = std::move(slots);
  table.bounds_ = std::move(bounds);
  table.dirty_ = std::move(dirty);
  table.unbounded_ = std::move(unbounded);
  table.plant_counts_.resize(max_plants);
  table.plant_spheres_.resize(max_plants);
  return table;
}

void InstanceTable::set_plant_sphere(std::uint32_t plant, const float center[3], float radius_m) {
  plant_spheres_[plant] = {{center[0], center[1], center[2]}, radius_m};
}

std::size_t InstanceTable::bytes() const {
  return instances_.bytes() + spheres_.bytes() + slots_.bytes() + bounds_.bytes() + dirty_.bytes() + unbounded_.bytes();
}

Result<void> InstanceTable::add(std::uint32_t plant, std::span<const coppice_placement> placements, std::span<coppice_instance> handles) {
  if (placements.size() > instances_.size() - count_)
    return Error{Status::out_of_memory, "more instances than max_instances", Error::kNoOffset, std::to_string(instances_.size())};
  for (std::size_t i = 0; i < placements.size(); ++i) {
    std::uint32_t slot = first_free_;
    if (slot != kNoSlot)
      first_free_ = slots_[slot].next_free;
    else
      slot = slot_count_++;
    write(slot, plant, placements[i]);
    if (!handles.empty()) handles[i] = std::uint64_t{slots_[slot].generation} << 32 | (slot + 1);
  }
  count_ += static_cast<std::uint32_t>(placements.size());
  plant_counts_[plant] += static_cast<std::uint32_t>(placements.size());
  return {};
}

bool InstanceTable::is_live(coppice_instance handle) const {
  const std::uint32_t slot = slot_of(handle);
  return slot < slot_count_ && slots_[slot].generation == generation_of(handle) && instances_[slot].plant != kNoPlant;
}

void InstanceTable::move(coppice_instance handle, const coppice_placement& placement) {
  COPPICE_ASSERT(is_live(handle));
  write(slot_of(handle), instances_[slot_of(handle)].plant, placement);
}

void InstanceTable::remove(coppice_instance handle) {
  COPPICE_ASSERT(is_live(handle));
  remove_slot(slot_of(handle));
}

void InstanceTable::remove_plant(std::uint32_t plant) {
  for (std::uint32_t slot = 0; slot < slot_count_ && plant_counts_[plant] > 0; ++slot)
    if (instances_[slot].plant == plant) remove_slot(slot);
}

SlotRange InstanceTable::take_dirty() {
  const SlotRange range = dirty_.take();
  return {range.first, std::min(range.count, slot_count_ - std::min(range.first, slot_count_))};
}

void InstanceTable::update_bounds() {
  const std::span<const InstanceSphere> slots = spheres();
  for (SlotRange range = unbounded_.take(); range.count > 0; range = unbounded_.take()) {
    const std::uint32_t end = std::min(range.first + range.count, slot_count_);
    for (std::uint32_t from = range.first; from < end; from += kInstanceBlockSlots)
      bounds_[from / kInstanceBlockSlots] = instance_bounds(slots.subspan(from, std::min(kInstanceBlockSlots, end - from)));
  }
}

void InstanceTable::mark_changed(std::uint32_t slot) {
  dirty_.mark({slot, 1});
  unbounded_.mark({slot, 1});
}

void InstanceTable::write(std::uint32_t slot, std::uint32_t plant, const coppice_placement& placement) {
  Instance& instance = instances_[slot];
  instance.position = {placement.position[0], placement.position[1], placement.position[2]};
  instance.scale = placement.scale;
  instance.rotation = {placement.rotation[0], placement.rotation[1], placement.rotation[2], placement.rotation[3]};
  instance.tint = {placement.tint[0], placement.tint[1], placement.tint[2]};
  instance.plant = plant;

  const Sphere& sphere = plant_spheres_[plant];
  const vec3 scaled{sphere.center[0] * placement.scale, sphere.center[1] * placement.scale, sphere.center[2] * placement.scale};
  const vec3 center = rotate(instance.rotation, scaled);
  spheres_[slot] = {.center_m = {center.x + instance.position.x, center.y + instance.position.y, center.z + instance.position.z},
                    .radius_m = sphere.radius_m * placement.scale,
                    .plant = plant};
  mark_changed(slot);
}

void InstanceTable::remove_slot(std::uint32_t slot) {
  --plant_counts_[instances_[slot].plant];
  --count_;
  instances_[slot].plant = kNoPlant;
  spheres_[slot].plant = InstanceSphere::kNoPlant;
  ++slots_[slot].generation;
  slots_[slot].next_free = first_free_;
  first_free_ = slot;
  mark_changed(slot);
}

}  // namespace coppice::gpu
