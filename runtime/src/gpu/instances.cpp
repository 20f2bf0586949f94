#include "instances.h"

#include <algorithm>
#include <array>
#include <bit>

#include "check.h"
#include "coppice_light.h"
#include "handle.h"

namespace coppice::gpu {
namespace {

static_assert(kDirtyBlockSlots == 64, "a bit of Block::used each");

std::uint32_t slot_of(coppice_instance handle) {
  return unpack_handle(handle).index;
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

Result<InstanceTable> InstanceTable::create(const coppice_allocator& allocator, std::uint32_t max_instances, std::uint32_t max_plants,
                                            std::uint32_t context_tag) {
  InstanceTable table;
  table.context_tag_ = context_tag;
  COPPICE_TRY(instances, HookArray<Instance>::allocate(allocator, max_instances));
  COPPICE_TRY(spheres, HookArray<InstanceSphere>::allocate(allocator, max_instances));
  COPPICE_TRY(generations, HookArray<std::uint32_t>::allocate(allocator, max_instances));
  const std::uint32_t block_count = (max_instances + kDirtyBlockSlots - 1) / kDirtyBlockSlots;
  COPPICE_TRY(blocks, HookArray<Block>::allocate(allocator, block_count));
  COPPICE_TRY(freed_blocks, HookArray<std::uint32_t>::allocate(allocator, block_count));
  COPPICE_TRY(bounds, HookArray<InstanceBounds>::allocate(allocator, (max_instances + kInstanceBlockSlots - 1) / kInstanceBlockSlots));
  COPPICE_TRY(dirty, DirtySlots::create(allocator, max_instances));
  COPPICE_TRY(unbounded, DirtySlots::create(allocator, max_instances));
  table.instances_ = std::move(instances);
  table.spheres_ = std::move(spheres);
  table.generations_ = std::move(generations);
  table.blocks_ = std::move(blocks);
  table.freed_blocks_ = std::move(freed_blocks);
  for (Instance& instance : table.instances_.span()) instance.plant = kNoPlant;
  if (const std::uint32_t rest = max_instances % kDirtyBlockSlots; rest > 0)
    table.blocks_[block_count - 1].used = ~std::uint64_t{0} << rest;
  table.bounds_ = std::move(bounds);
  table.dirty_ = std::move(dirty);
  table.unbounded_ = std::move(unbounded);
  table.plant_counts_.resize(max_plants);
  table.plant_spheres_.resize(max_plants);
  return table;
}

void InstanceTable::set_plant_sphere(std::uint32_t plant, std::span<const float, 3> center, float radius_m) {
  plant_spheres_[plant] = {vec3(center), radius_m, true};
  replace_plant(plant, plant);
}

std::uint64_t InstanceTable::bytes_for(std::uint32_t max_instances) {
  const auto blocks_of = [&](std::uint64_t slots) { return (max_instances + slots - 1) / slots; };
  return max_instances * std::uint64_t{sizeof(Instance) + sizeof(InstanceSphere) + sizeof(std::uint32_t)} +
         blocks_of(kDirtyBlockSlots) * (sizeof(Block) + sizeof(std::uint32_t) + 2 * sizeof(std::uint8_t)) +
         blocks_of(kInstanceBlockSlots) * sizeof(InstanceBounds);
}

std::size_t InstanceTable::bytes() const {
  return instances_.bytes() + spheres_.bytes() + generations_.bytes() + blocks_.bytes() + freed_blocks_.bytes() + bounds_.bytes() +
         dirty_.bytes() + unbounded_.bytes();
}

std::uint32_t InstanceTable::free_block_count() const {
  // The last one only if it is whole: a tile's blocks are all alike.
  const auto whole = static_cast<std::uint32_t>(instances_.size() / kDirtyBlockSlots);
  return freed_block_count_ + (whole - std::min(whole, block_end_));
}

Result<void> InstanceTable::add(std::uint32_t plant, std::span<const coppice_placement> placements, std::span<coppice_instance> handles) {
  const std::size_t unused = instances_.size() - std::min<std::size_t>(instances_.size(), std::size_t{block_end_} * kDirtyBlockSlots);
  if (placements.size() > std::size_t{free_slot_count_} + std::size_t{freed_block_count_} * kDirtyBlockSlots + unused)
    return Error{Status::out_of_memory, "more instances than max_instances", Error::kNoOffset, std::to_string(instances_.size())};
  for (std::size_t i = 0; i < placements.size(); ++i) {
    const std::uint32_t slot = take_slot();
    write(slot, plant, placements[i]);
    if (!handles.empty()) handles[i] = handle_of(slot);
  }
  return {};
}

Result<void> InstanceTable::add_tile(std::span<const PlacedInstance> instances, std::vector<std::uint32_t>& blocks) {
  blocks.clear();
  if ((instances.size() + kDirtyBlockSlots - 1) / kDirtyBlockSlots > free_block_count())
    return Error{Status::out_of_memory, "more instances than max_instances", Error::kNoOffset, std::to_string(instances_.size())};
  for (std::size_t first = 0; first < instances.size(); first += kDirtyBlockSlots) {
    const auto members = instances.subspan(first, std::min<std::size_t>(kDirtyBlockSlots, instances.size() - first));
    const std::uint32_t block = take_block();
    blocks.push_back(block);
    blocks_[block].tile = true;
    for (std::uint32_t i = 0; i < members.size(); ++i) {
      blocks_[block].used |= std::uint64_t{1} << i;
      write(block * kDirtyBlockSlots + i, members[i].plant, members[i].placement);
    }
  }
  return {};
}

void InstanceTable::scale_tile(std::span<const std::uint32_t> blocks, float factor) {
  for (const std::uint32_t block : blocks) {
    COPPICE_ASSERT(blocks_[block].tile);
    for (std::uint64_t left = blocks_[block].used; left != 0; left &= left - 1) {
      const std::uint32_t slot = block * kDirtyBlockSlots + static_cast<std::uint32_t>(std::countr_zero(left));
      Instance& instance = instances_[slot];
      InstanceSphere& sphere = spheres_[slot];
      instance.scale *= factor;
      sphere.radius_m *= factor;
      sphere.center_m = instance.position + factor * (sphere.center_m - instance.position);
    }
    mark_changed(block * kDirtyBlockSlots);
  }
}

void InstanceTable::remove_tile(std::span<const std::uint32_t> blocks) {
  for (const std::uint32_t block : blocks) {
    COPPICE_ASSERT(blocks_[block].tile);
    for (; blocks_[block].used != 0; blocks_[block].used &= blocks_[block].used - 1)
      clear_slot(block * kDirtyBlockSlots + static_cast<std::uint32_t>(std::countr_zero(blocks_[block].used)));
    blocks_[block].tile = false;
    freed_blocks_[freed_block_count_++] = block;
  }
}

// The block that was freed last, so that what is uploaded and culled stays short.
std::uint32_t InstanceTable::take_block() {
  return freed_block_count_ > 0 ? freed_blocks_[--freed_block_count_] : block_end_++;
}

void InstanceTable::link(std::uint32_t block) {
  blocks_[block].previous = kNoBlock;
  blocks_[block].next = first_partial_;
  if (first_partial_ != kNoBlock) blocks_[first_partial_].previous = block;
  first_partial_ = block;
}

void InstanceTable::unlink(std::uint32_t block) {
  const Block& linked = blocks_[block];
  if (linked.previous != kNoBlock) blocks_[linked.previous].next = linked.next;
  if (linked.next != kNoBlock) blocks_[linked.next].previous = linked.previous;
  if (first_partial_ == block) first_partial_ = linked.next;
}

std::uint32_t InstanceTable::take_slot() {
  if (first_partial_ == kNoBlock) {
    const std::uint32_t block = take_block();
    free_slot_count_ += static_cast<std::uint32_t>(std::popcount(~blocks_[block].used));
    link(block);
  }
  const std::uint32_t block = first_partial_;
  const auto place = static_cast<std::uint32_t>(std::countr_one(blocks_[block].used));
  blocks_[block].used |= std::uint64_t{1} << place;
  --free_slot_count_;
  if (blocks_[block].used == ~std::uint64_t{0}) unlink(block);
  return block * kDirtyBlockSlots + place;
}

coppice_instance InstanceTable::handle_of(std::uint32_t slot) const {
  return pack_handle({HandleKind::instance, context_tag_, generations_[slot], slot});
}

bool InstanceTable::is_live(coppice_instance handle) const {
  const std::uint32_t slot = slot_of(handle);
  return slot < slot_count_ && handle == handle_of(slot) && plant_of(slot) != kNoPlant && !blocks_[slot / kDirtyBlockSlots].tile;
}

void InstanceTable::move(coppice_instance handle, const coppice_placement& placement) {
  COPPICE_ASSERT(is_live(handle));
  write(slot_of(handle), plant_of(slot_of(handle)), placement);
}

void InstanceTable::remove(coppice_instance handle) {
  COPPICE_ASSERT(is_live(handle));
  remove_slot(slot_of(handle));
}

void InstanceTable::remove_plant(std::uint32_t plant) {
  for (std::uint32_t slot = 0; slot < slot_count_ && plant_counts_[plant] > 0; ++slot)
    if (plant_of(slot) == plant) remove_slot(slot);
  plant_spheres_[plant] = {};
}

void InstanceTable::replace_plant(std::uint32_t from, std::uint32_t to) {
  std::uint32_t left = plant_counts_[from];
  for (std::uint32_t slot = 0; slot < slot_count_ && left > 0; ++slot) {
    const Instance& instance = instances_[slot];
    if (plant_of(slot) != from) continue;
    --left;
    write(slot, to,
          {{instance.position.x, instance.position.y, instance.position.z},
           instance.scale,
           {instance.rotation.x, instance.rotation.y, instance.rotation.z, instance.rotation.w},
           {instance.tint.x, instance.tint.y, instance.tint.z}});
    --plant_counts_[from];
    ++plant_counts_[to];
  }
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
  if (plant_of(slot) == kNoPlant) {
    ++count_;
    ++plant_counts_[plant];
    slot_count_ = std::max(slot_count_, slot + 1);
  }
  instance.position = vec3(placement.position);
  instance.scale = placement.scale;
  instance.rotation = {placement.rotation[0], placement.rotation[1], placement.rotation[2], placement.rotation[3]};
  instance.tint = vec3(placement.tint);

  const Sphere& sphere = plant_spheres_[plant];
  instance.plant = sphere.known ? plant : kNoPlant;
  spheres_[slot] = {.center_m = world_from_object(instance, sphere.center), .radius_m = sphere.radius_m * placement.scale, .plant = plant};
  mark_changed(slot);
}

void InstanceTable::clear_slot(std::uint32_t slot) {
  --plant_counts_[plant_of(slot)];
  --count_;
  instances_[slot].plant = kNoPlant;
  spheres_[slot].plant = InstanceSphere::kNoPlant;
  ++generations_[slot];
  mark_changed(slot);
}

void InstanceTable::remove_slot(std::uint32_t slot) {
  clear_slot(slot);
  const std::uint32_t index = slot / kDirtyBlockSlots;
  Block& block = blocks_[index];
  const bool was_full = block.used == ~std::uint64_t{0};
  block.used &= ~(std::uint64_t{1} << slot % kDirtyBlockSlots);
  if (block.tile) return;  // remove_tile frees the block
  ++free_slot_count_;
  if (was_full) link(index);
  if (block.used != 0) return;
  unlink(index);
  free_slot_count_ -= kDirtyBlockSlots;
  freed_blocks_[freed_block_count_++] = index;
}

}  // namespace coppice::gpu
