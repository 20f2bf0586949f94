#include "instances.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "check.h"
#include "handle.h"

namespace coppice::gpu {
namespace {

static_assert(kDirtyBlockSlots == 64, "a bit of Block::used each");

static_assert(InstanceSphere::kNoPlant == kNoPlant);

/// Effort of sorting in a frame, about 0.1 ms, and number of blocks that end_growth looks at. What they change fits the staging ring.
constexpr std::int32_t kSortEffort = 8192;
constexpr std::uint32_t kSweptBlocks = 64;

/// Seeds are as wide as the bits beside a plant.
constexpr std::uint32_t kSeedMask = (1u << (32 - kPlantBits)) - 1;

/// Copies as many elements as `to` has then.
template <class T>
Result<void> copy_resized(const HookArray<T>& from, const coppice_allocator& allocator, std::size_t count, HookArray<T>& to) {
  COPPICE_CHECK(allocate_into(to, allocator, count));
  std::ranges::copy(from.span().first(std::min(from.size(), count)), to.data());
  return {};
}

constexpr std::size_t block_count(std::size_t slot_count, std::uint32_t block_slots) {
  return (slot_count + block_slots - 1) / block_slots;
}

Error too_many(std::uint32_t maximum) {
  return {Status::out_of_memory, "more instances than max_instances, or than this device holds", Error::kNoOffset, std::to_string(maximum)};
}

/// quaternion: about unit length
dvec3 rotated(const vec4& quaternion, const dvec3& v) {
  const double x = quaternion.x, y = quaternion.y, z = quaternion.z, w = quaternion.w;
  const double length_2 = x * x + y * y + z * z + w * w;
  const dvec3 axis{x, y, z}, t = cross(axis, v) * (2.0 / length_2);
  return v + t * w + cross(axis, t);
}

/// Product of two quaternions, unit.
vec4 product(const vec4& a, const vec4& b) {
  const vec3 axis = a.w * b.xyz() + b.w * a.xyz() + cross(a.xyz(), b.xyz());
  const vec4 turned{axis, a.w * b.w - dot(a.xyz(), b.xyz())};
  return turned * inversesqrt(dot(turned.xyz(), turned.xyz()) + turned.w * turned.w);
}

/// Returns Instance::rotation: the sign of w, which otherwise has no meaning, mirrors a plant. mirrored: by its scale
vec4 instance_rotation(const float (&rotation)[4], bool mirrored) {
  constexpr float kMinW = 1e-12f;
  const vec4 unit{rotation[0], rotation[1], rotation[2], std::copysign(std::max(std::abs(rotation[3]), kMinW), rotation[3])};
  return std::signbit(unit.w) == mirrored ? unit : unit * -1.0f;
}

/// The inverse of write(), from the world's first origin.
coppice_placement placement_of(const Instance& instance) {
  const dvec3 place = place_of(instance);
  const vec3 tint = tint_of(instance);
  coppice_placement placement{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    placement.position[axis] = place[axis];
    placement.tint[axis] = tint[axis];
  }
  placement.scale = signed_scale(instance);
  const float rotation[4] = {instance.rotation.x, instance.rotation.y, instance.rotation.z, instance.rotation.w};
  std::ranges::copy(rotation, placement.rotation);
  placement.user_data = instance.user_data;
  placement.layer_mask = instance.layer_mask;
  placement.lod_bias = lod_bias_of(instance);
  placement.leaf_share = leaf_share_of(instance);
  return placement;
}

/// True if both are at the same place.
bool stands_alike(const Instance& a, const Instance& b) {
  return a.position == b.position && a.scale == b.scale && a.rotation == b.rotation && a.cell_xy == b.cell_xy &&
         (a.cell_z_bias & 0xffffu) == (b.cell_z_bias & 0xffffu);
}

}  // namespace

coppice_placement placed_in(const Pose& pose, const coppice_placement& placement) {
  const dvec3 place = pose.position + rotated(pose.rotation, dvec3(placement.position));
  const float* r = placement.rotation;
  const vec4 turned = product(pose.rotation, {r[0], r[1], r[2], r[3]});
  coppice_placement placed = placement;
  for (std::size_t axis = 0; axis < 3; ++axis) placed.position[axis] = place[axis];
  const float rotation[4] = {turned.x, turned.y, turned.z, turned.w};
  std::ranges::copy(rotation, placed.rotation);
  return placed;
}

Pose inverse(const Pose& pose) {
  const vec4 back{-pose.rotation.x, -pose.rotation.y, -pose.rotation.z, pose.rotation.w};
  return {rotated(back, pose.position) * -1.0, back};
}

coppice_placement default_placement() {
  coppice_placement placement{};
  placement.scale = placement.rotation[3] = placement.leaf_share = 1.0f;
  std::ranges::fill(placement.tint, 1.0f);
  placement.layer_mask = COPPICE_ALL_LAYERS;
  return placement;
}

coppice_placement PlacementRecords::operator[](std::size_t index) const {
  coppice_placement placement = default_placement();
  std::memcpy(&placement, static_cast<const std::byte*>(first) + index * stride, std::min(stride, sizeof placement));
  return placement;
}

Result<DirtySlots> DirtySlots::resized(const coppice_allocator& allocator, std::uint32_t slot_count) const {
  DirtySlots copy;
  const auto count = static_cast<std::uint32_t>(block_count(slot_count, kDirtyBlockSlots));
  COPPICE_CHECK(copy_resized(flags_, allocator, count, copy.flags_));
  copy.first_ = first_;
  copy.end_ = std::min(end_, count);
  return copy;
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

std::uint64_t InstanceTable::Arrays::bytes() const {
  return instances.bytes() + spheres.bytes() + owners.bytes() + handles.bytes() + blocks.bytes() + freed_blocks.bytes() + bounds.bytes() +
         moved.bytes() + dirty.bytes() + told.bytes() + unbounded.bytes();
}

Result<InstanceTable::Arrays> InstanceTable::resized(std::uint32_t slot_count) const {
  Arrays larger;
  const auto enlarge = [&](auto& to, const auto& from, std::uint32_t block_slots) -> Result<void> {
    return copy_resized(from, allocator_, block_count(slot_count, block_slots), to);
  };
  COPPICE_CHECK(enlarge(larger.instances, arrays_.instances, 1));
  COPPICE_CHECK(enlarge(larger.spheres, arrays_.spheres, 1));
  COPPICE_CHECK(enlarge(larger.owners, arrays_.owners, 1));
  // Handles stay when slots go: one must not come to life again.
  COPPICE_CHECK(copy_resized(arrays_.handles, allocator_, std::max<std::size_t>(slot_count, arrays_.handles.size()), larger.handles));
  COPPICE_CHECK(enlarge(larger.blocks, arrays_.blocks, kDirtyBlockSlots));
  COPPICE_CHECK(enlarge(larger.freed_blocks, arrays_.freed_blocks, kDirtyBlockSlots));
  COPPICE_CHECK(enlarge(larger.bounds, arrays_.bounds, kInstanceBlockSlots));
  COPPICE_CHECK(enlarge(larger.moved, arrays_.moved, kMovedShare));
  COPPICE_CHECK(move_into(larger.told, arrays_.told.resized(allocator_, slot_count)));
  COPPICE_CHECK(move_into(larger.dirty, arrays_.dirty.resized(allocator_, slot_count)));
  COPPICE_CHECK(move_into(larger.unbounded, arrays_.unbounded.resized(allocator_, slot_count)));
  for (Instance& instance : larger.instances.span().subspan(std::min(slot_count, capacity())))
    instance.plant_seed = pack_plant(kNoPlant, 0);
  if (const std::uint32_t rest = slot_count % kDirtyBlockSlots; rest > 0)
    larger.blocks[slot_count / kDirtyBlockSlots].used = ~std::uint64_t{0} << rest;
  return larger;
}

std::uint64_t InstanceTable::growth_bytes(std::uint32_t slot_count) const {
  return slot_count <= capacity() ? 0 : slot_bytes(slot_count) + slot_count * sizeof(HandleEntry);
}

std::uint64_t InstanceTable::slot_bytes(std::uint32_t slot_count) {
  return slot_count * std::uint64_t{sizeof(Instance) + sizeof(InstanceSphere) + sizeof(std::uint32_t)} +
         block_count(slot_count, kDirtyBlockSlots) * (sizeof(Block) + sizeof(std::uint32_t) + 3 * sizeof(std::uint8_t)) +
         block_count(slot_count, kMovedShare) * sizeof(Instance) + block_count(slot_count, kInstanceBlockSlots) * sizeof(InstanceBounds);
}

Result<void> InstanceTable::reserve(std::uint32_t slot_count) {
  if (slot_count <= capacity()) return {};
  COPPICE_TRY(larger, resized(roomy(slot_count)));
  take(std::move(larger));
  return {};
}

std::uint32_t InstanceTable::roomy(std::uint32_t slot_count) const {
  return roomy_count({.now = capacity(), .needed = slot_count, .first = kFirstSlots, .maximum = max_instances_, .step = kDirtyBlockSlots});
}

std::uint32_t InstanceTable::min_capacity() {
  if (count_ == 0) moved_count_ = 0;
  const auto is_empty = [this](const Block& block) { return block.used == 0 && !block.is_tile(); };
  while (block_end_ > 0 && is_empty(arrays_.blocks[block_end_ - 1])) --block_end_;
  const auto freed = arrays_.freed_blocks.span().first(freed_block_count_);
  freed_block_count_ -=
      static_cast<std::uint32_t>(std::ranges::remove_if(freed, [this](std::uint32_t block) { return block >= block_end_; }).size());
  if (slot_count_ > block_end_ * kDirtyBlockSlots) {
    slot_count_ = block_end_ * kDirtyBlockSlots;
    sort_ = {};
    unsorted_ = true;
  }
  return std::min(
      std::max(block_end_, static_cast<std::uint32_t>(block_count(moved_count_ * kMovedShare, kDirtyBlockSlots))) * kDirtyBlockSlots,
      capacity());
}

Result<std::uint32_t> InstanceTable::slots_for(std::size_t added) const {
  const std::size_t freed = std::size_t{free_slot_count_} + std::size_t{freed_block_count_} * kDirtyBlockSlots;
  const std::size_t used_slots = std::min<std::size_t>(max_instances_, std::size_t{block_end_} * kDirtyBlockSlots);
  const std::size_t fresh = added - std::min(added, freed);
  if (fresh > max_instances_ - used_slots) return too_many(max_instances_);
  return static_cast<std::uint32_t>(
      std::min<std::size_t>(max_instances_, used_slots + block_count(fresh, kDirtyBlockSlots) * kDirtyBlockSlots));
}

Result<std::uint32_t> InstanceTable::slots_for_tile(std::size_t added) const {
  const std::size_t blocks = block_count(added, kDirtyBlockSlots);
  if (blocks > free_block_count()) return too_many(max_instances_);
  const std::size_t fresh = blocks - std::min<std::size_t>(blocks, freed_block_count_);
  return static_cast<std::uint32_t>(std::min<std::size_t>(max_instances_, (block_end_ + fresh) * kDirtyBlockSlots));
}

Result<void> InstanceTable::reserve_plants(std::uint32_t count) {
  return count <= plants_.size() ? Result<void>() : move_into(plants_, enlarged_copy(plants_, allocator_, count));
}

void InstanceTable::set_plant_sphere(std::uint32_t plant, std::span<const float, 3> center, float radius_m) {
  PlantInstances& of = plants_[plant];
  of = {of.count, vec3(center), radius_m, true};
  replace_plant(plant, plant);
}

std::uint32_t InstanceTable::free_block_count() const {
  // The last block is usable only if it is whole: a tile's blocks all have the same size.
  const std::uint32_t whole = max_instances_ / kDirtyBlockSlots;
  return freed_block_count_ + (whole - std::min(whole, block_end_));
}

Result<void> InstanceTable::add(std::uint32_t plant, const PlacementRecords& placements, std::span<coppice_instance> handles) {
  COPPICE_TRY(slot_count, slots_for(placements.count));
  COPPICE_CHECK(reserve(slot_count));
  for (std::size_t i = 0; i < placements.count; ++i) {
    const std::uint32_t slot = take_slot();
    write(slot, plant, placements[i], origin_);
    if (!handles.empty()) handles[i] = handle_at(slot);
  }
  return {};
}

Result<InstanceTile> InstanceTable::add_tile(std::uint32_t name, std::span<const PlacedInstance> instances) {
  COPPICE_TRY(slot_count, slots_for_tile(instances.size()));
  COPPICE_CHECK(reserve(slot_count));
  InstanceTile tile;
  for (std::size_t first = 0; first < instances.size(); first += kDirtyBlockSlots) {
    const auto members = instances.subspan(first, std::min<std::size_t>(kDirtyBlockSlots, instances.size() - first));
    const std::uint32_t index = take_block();
    Block& block = arrays_.blocks[index];
    block.tile = name;
    block.first_number = static_cast<std::uint32_t>(first);
    block.next = std::exchange(tile.first_block, index);
    ++tile.block_count;
    for (std::uint32_t i = 0; i < members.size(); ++i) set_member(index * kDirtyBlockSlots + i, members[i]);
  }
  return tile;
}

std::uint32_t InstanceTable::member_slot(const InstanceTile& tile, std::uint32_t number) const {
  std::uint32_t block = tile.first_block;  // the last block of the tile
  while (number < arrays_.blocks[block].first_number) block = arrays_.blocks[block].next;
  return block * kDirtyBlockSlots + number - arrays_.blocks[block].first_number;
}

TileMember InstanceTable::member_at(std::uint32_t slot) const {
  const Block& block = arrays_.blocks[slot / kDirtyBlockSlots];
  return {block.tile, block.first_number + slot % kDirtyBlockSlots};
}

PlacedInstance InstanceTable::placed_at(std::uint32_t slot) const {
  return {placement_of(arrays_.instances[slot]), plant_at(slot)};
}

void InstanceTable::set_member(std::uint32_t slot, const PlacedInstance& placed) {
  Block& block = arrays_.blocks[slot / kDirtyBlockSlots];
  COPPICE_ASSERT(block.is_tile());
  if (plant_at(slot) != kNoPlant) remove_slot(slot);
  if (placed.plant == kNoPlant) return;
  block.used |= std::uint64_t{1} << slot % kDirtyBlockSlots;
  // The same in every run of a program, whichever slots the tile has.
  const TileMember member = member_at(slot);
  arrays_.instances[slot].plant_seed = pack_plant(kNoPlant, (lod::coppice_hash(member.tile) + member.number) & kSeedMask);
  write(slot, placed.plant, placed.placement, {0, 0, 0});
}

void InstanceTable::grow_tile(const InstanceTile& tile, std::uint32_t frames) {
  for (std::uint32_t block = tile.first_block; block != kNoBlock; block = arrays_.blocks[block].next) {
    COPPICE_ASSERT(arrays_.blocks[block].is_tile());
    for (std::uint64_t left = arrays_.blocks[block].used; left != 0; left &= left - 1)
      start_growth(block * kDirtyBlockSlots + static_cast<std::uint32_t>(std::countr_zero(left)), frames);
  }
}

void InstanceTable::grow(coppice_instance handle, std::uint32_t frames) {
  COPPICE_ASSERT(is_live(handle));
  start_growth(slot_of(handle), frames);
}

void InstanceTable::move_tile(const InstanceTile& tile, const Pose& first, const Pose& then) {
  for (std::uint32_t block = tile.first_block; block != kNoBlock; block = arrays_.blocks[block].next) {
    COPPICE_ASSERT(arrays_.blocks[block].is_tile());
    for (std::uint64_t left = arrays_.blocks[block].used; left != 0; left &= left - 1) {
      const std::uint32_t slot = block * kDirtyBlockSlots + static_cast<std::uint32_t>(std::countr_zero(left));
      // A tile is left empty once its plants have closed.
      if (plant_at(slot) == kNoPlant) continue;
      write(slot, plant_at(slot), placed_in(then, placed_in(first, placement_of(arrays_.instances[slot]))), {0, 0, 0});
    }
  }
}

void InstanceTable::remove_tile(const InstanceTile& tile) {
  for (std::uint32_t index = tile.first_block; index != kNoBlock;) {
    Block& block = arrays_.blocks[index];
    COPPICE_ASSERT(block.is_tile());
    for (; block.used != 0; block.used &= block.used - 1)
      clear_slot(index * kDirtyBlockSlots + static_cast<std::uint32_t>(std::countr_zero(block.used)));
    block.tile = TileMember::kNoTile;
    arrays_.freed_blocks[freed_block_count_++] = index;
    index = block.next;
  }
}

// Returns the block that was freed last, so that the range that is uploaded and culled stays short.
std::uint32_t InstanceTable::take_block() {
  return freed_block_count_ > 0 ? arrays_.freed_blocks[--freed_block_count_] : block_end_++;
}

void InstanceTable::link(std::uint32_t block) {
  arrays_.blocks[block].previous = kNoBlock;
  arrays_.blocks[block].next = first_partial_;
  if (first_partial_ != kNoBlock) arrays_.blocks[first_partial_].previous = block;
  first_partial_ = block;
}

void InstanceTable::unlink(std::uint32_t block) {
  const Block& linked = arrays_.blocks[block];
  if (linked.previous != kNoBlock) arrays_.blocks[linked.previous].next = linked.next;
  if (linked.next != kNoBlock) arrays_.blocks[linked.next].previous = linked.previous;
  if (first_partial_ == block) first_partial_ = linked.next;
}

std::uint32_t InstanceTable::take_slot() {
  if (first_partial_ == kNoBlock) {
    const std::uint32_t block = take_block();
    free_slot_count_ += static_cast<std::uint32_t>(std::popcount(~arrays_.blocks[block].used));
    link(block);
  }
  const std::uint32_t block = first_partial_;
  const auto place = static_cast<std::uint32_t>(std::countr_one(arrays_.blocks[block].used));
  arrays_.blocks[block].used |= std::uint64_t{1} << place;
  --free_slot_count_;
  if (arrays_.blocks[block].used == ~std::uint64_t{0}) unlink(block);
  const std::uint32_t slot = block * kDirtyBlockSlots + place;
  const std::uint32_t index = free_index_ != kNoIndex ? std::exchange(free_index_, arrays_.handles[free_index_].slot) : index_end_++;
  arrays_.handles[index].slot = slot;
  arrays_.owners[slot] = index;
  arrays_.instances[slot].plant_seed = pack_plant(kNoPlant, index & kSeedMask);
  return slot;
}

coppice_instance InstanceTable::handle_of(std::uint32_t index) const {
  return pack_handle({HandleKind::instance, context_tag_, arrays_.handles[index].generation, index});
}

std::uint32_t InstanceTable::slot_of(coppice_instance handle) const {
  return arrays_.handles[unpack_handle(handle).index].slot;
}

bool InstanceTable::is_live(coppice_instance handle) const {
  const std::uint32_t index = unpack_handle(handle).index;
  if (index >= index_end_ || handle != handle_of(index)) return false;
  // An index without an instance has no slot, but the next such index.
  const std::uint32_t slot = arrays_.handles[index].slot;
  return slot < slot_count_ && arrays_.owners[slot] == index && plant_at(slot) != kNoPlant &&
         !arrays_.blocks[slot / kDirtyBlockSlots].is_tile();
}

void InstanceTable::move(coppice_instance handle, const coppice_placement& placement) {
  COPPICE_ASSERT(is_live(handle));
  const std::uint32_t slot = slot_of(handle);
  write(slot, plant_at(slot), placement, origin_);
}

void InstanceTable::remove(coppice_instance handle) {
  COPPICE_ASSERT(is_live(handle));
  remove_slot(slot_of(handle));
}

void InstanceTable::remove_plant(std::uint32_t plant) {
  for (std::uint32_t slot = 0; slot < slot_count_ && plant_count(plant) > 0; ++slot)
    if (plant_at(slot) == plant) remove_slot(slot);
  plants_[plant] = {};
}

void InstanceTable::replace_plant(std::uint32_t from, std::uint32_t to) {
  std::uint32_t left = plant_count(from);
  for (std::uint32_t slot = 0; slot < slot_count_ && left > 0; ++slot) {
    const Instance& instance = arrays_.instances[slot];
    if (plant_at(slot) != from) continue;
    --left;
    write(slot, to, placement_of(instance), {0, 0, 0});
    --plants_[from].count;
    ++plants_[to].count;
  }
}

SlotRange InstanceTable::take_dirty() {
  const SlotRange range = arrays_.dirty.take();
  return {range.first, std::min(range.count, slot_count_ - std::min(range.first, slot_count_))};
}

void InstanceTable::update_bounds() {
  const std::span<const InstanceSphere> slots = spheres();
  for (SlotRange range = arrays_.unbounded.take(); range.count > 0; range = arrays_.unbounded.take()) {
    const std::uint32_t end = std::min(range.first + range.count, slot_count_);
    for (std::uint32_t from = range.first; from < end; from += kInstanceBlockSlots)
      arrays_.bounds[from / kInstanceBlockSlots] = instance_bounds(slots.subspan(from, std::min(kInstanceBlockSlots, end - from)));
  }
}

void InstanceTable::mark_changed(std::uint32_t slot) {
  arrays_.dirty.mark(slot);
  arrays_.unbounded.mark(slot);
}

void InstanceTable::write(std::uint32_t slot, std::uint32_t plant, const coppice_placement& placement, const dvec3& origin) {
  Instance& instance = arrays_.instances[slot];
  const Instance then = instance;
  PlantInstances& of = plants_[plant];
  const bool is_new = plant_at(slot) == kNoPlant;
  if (is_new) {
    ++count_;
    ++of.count;
    if (slot >= slot_count_) {
      // The GPU may have former instances in slots that min_capacity() has given up.
      const SlotRange fresh{slot_count_, slot + 1 - slot_count_};
      arrays_.dirty.mark(fresh);
      arrays_.unbounded.mark(fresh);
      slot_count_ = slot + 1;
    }
  }
  const CellPlace at = cell_place(dvec3(placement.position) + origin);
  const uint bias = half_of(placement.lod_bias);
  instance.position = at.place;
  instance.cell_xy = pack_cell_xy(at.cell);
  instance.cell_z_bias = (static_cast<uint>(at.cell.z) & 0xffffu) | bias << 16u;
  instance.scale = std::abs(placement.scale);
  instance.rotation = instance_rotation(placement.rotation, placement.scale < 0.0f);
  instance.tint_xy = packHalf2x16({placement.tint[0], placement.tint[1]});
  instance.tint_z_share = packHalf2x16({placement.tint[2], placement.leaf_share});
  instance.layer_mask = placement.layer_mask;
  instance.user_data = placement.user_data;

  const PlaceCode code(arrays_.spheres[slot].center_m);
  instance.plant_seed = pack_plant(of.known ? plant : kNoPlant, seed_of(instance));
  arrays_.spheres[slot] = {.center_m = world_place(at) + dvec3(oriented(instance.rotation, instance.scale * of.center)),
                           .radius_m = of.radius_m * instance.scale,
                           .plant = plant,
                           .layer_mask = placement.layer_mask,
                           .threshold_share = std::exp2(of_half(bias))};
  if (!arrays_.blocks[slot / kDirtyBlockSlots].is_tile() && (is_new || code != PlaceCode(arrays_.spheres[slot].center_m))) unsorted_ = true;
  note_motion(slot, then);
  mark_changed(slot);
}

// An instance that grows up goes on with it; one that was not shown begins.
void InstanceTable::note_motion(std::uint32_t slot, const Instance& then) {
  const Instance& instance = arrays_.instances[slot];
  const bool was_shown = plant_of(then) != kNoPlant, grows = has_growth(then.before);
  if (grows && !was_shown) return start_growth(slot, then.before >> 16u & kMaxGrowthFrames);
  if (!was_shown) return tell_before(slot, kCame);
  if (grows && grown_share(then.before, frame_) < 1.0f) return;
  if ((then.before != 0 && !grows) || stands_alike(then, instance)) return;
  const bool room = moved_count_ < max_moved(capacity());
  if (room) {
    arrays_.moved[moved_count_] = then;
    arrays_.moved[moved_count_++].before = 0;
  }
  tell_before(slot, room ? moved_count_ : kCame);
}

void InstanceTable::start_growth(std::uint32_t slot, std::uint32_t frames) {
  arrays_.instances[slot].before = pack_growth(frames, frame_);
  arrays_.blocks[slot / kDirtyBlockSlots].grows = true;
  grown_frame_ = std::max(grown_frame_, frame_ + frames);
  arrays_.dirty.mark(slot);
}

void InstanceTable::begin_frame() {
  ++frame_;
  end_growth();
  sort_some();
}

// Blocks take turns. The GPU knows when an instance has grown up; this only keeps it from growing again when 16 bits of frames are over.
void InstanceTable::end_growth() {
  for (std::uint32_t i = 0; i < std::min(kSweptBlocks, block_end_); ++i) {
    if (swept_block_ >= block_end_) swept_block_ = 0;
    if (arrays_.blocks[swept_block_].grows) end_growth(swept_block_);
    ++swept_block_;
  }
}

void InstanceTable::end_growth(std::uint32_t index) {
  Block& block = arrays_.blocks[index];
  block.grows = false;
  for (std::uint64_t left = block.used; left != 0; left &= left - 1) {
    const std::uint32_t slot = index * kDirtyBlockSlots + static_cast<std::uint32_t>(std::countr_zero(left));
    if (slot >= slot_count_) break;
    Instance& instance = arrays_.instances[slot];
    if (!has_growth(instance.before)) continue;
    if (plant_of(instance) == kNoPlant || grown_share(instance.before, frame_) < 1.0f) {
      block.grows = true;
      continue;
    }
    instance.before = 0;
    arrays_.dirty.mark(slot);
  }
}

/// What PlaceSort sees of the table: the slots of instances with handles.
struct InstanceTable::SortedSlots {
  InstanceTable& table;

  [[nodiscard]] std::uint64_t used(std::uint32_t block) const {
    const Block& of = table.arrays_.blocks[block];
    return of.is_tile() ? 0 : of.used;
  }
  [[nodiscard]] bool is_used(std::uint32_t slot) const { return (used(slot / kDirtyBlockSlots) >> slot % kDirtyBlockSlots & 1u) != 0; }
  [[nodiscard]] std::uint32_t after(std::uint32_t slot) const {
    const std::uint64_t left = used(slot / kDirtyBlockSlots) >> slot % kDirtyBlockSlots;
    return left != 0 ? slot + static_cast<std::uint32_t>(std::countr_zero(left)) : (slot / kDirtyBlockSlots + 1) * kDirtyBlockSlots;
  }
  [[nodiscard]] std::uint32_t before(std::uint32_t slot) const {
    const std::uint64_t left = used(slot / kDirtyBlockSlots) << (kDirtyBlockSlots - 1 - slot % kDirtyBlockSlots);
    return left != 0 ? slot + 1 - static_cast<std::uint32_t>(std::countl_zero(left)) : slot / kDirtyBlockSlots * kDirtyBlockSlots;
  }
  [[nodiscard]] PlaceCode code(std::uint32_t slot) const { return PlaceCode(table.arrays_.spheres[slot].center_m); }
  void swap(std::uint32_t a, std::uint32_t b) { table.swap_slots(a, b); }
};

void InstanceTable::sort_some() {
  if (sort_.is_done()) {
    if (!std::exchange(unsorted_, false)) return;
    sort_.begin(slot_count_);
  }
  SortedSlots slots{*this};
  sort_.run(slots, kSortEffort);
}

void InstanceTable::swap_slots(std::uint32_t a, std::uint32_t b) {
  std::swap(arrays_.instances[a], arrays_.instances[b]);
  std::swap(arrays_.spheres[a], arrays_.spheres[b]);
  std::swap(arrays_.owners[a], arrays_.owners[b]);
  for (const std::uint32_t slot : {a, b}) {
    arrays_.handles[arrays_.owners[slot]].slot = slot;
    const std::uint32_t before = arrays_.instances[slot].before;
    if (has_growth(before))
      arrays_.blocks[slot / kDirtyBlockSlots].grows = true;
    else if (before != 0)
      arrays_.told.mark(slot);
    mark_changed(slot);
  }
}

void InstanceTable::tell_before(std::uint32_t slot, std::uint32_t before) {
  arrays_.instances[slot].before = before;
  arrays_.told.mark(slot);
}

void InstanceTable::forget_moves() {
  moved_count_ = 0;
  for (SlotRange range = arrays_.told.take(); range.count > 0; range = arrays_.told.take()) {
    range.count = std::min(range.count, slot_count_ - std::min(range.first, slot_count_));
    for (Instance& instance : arrays_.instances.span().subspan(range.first, range.count))
      if (!has_growth(instance.before)) instance.before = 0;
    arrays_.dirty.mark(range);
  }
}

void InstanceTable::clear_slot(std::uint32_t slot) {
  --plants_[plant_at(slot)].count;
  --count_;
  arrays_.instances[slot].plant_seed = pack_plant(kNoPlant, 0);
  arrays_.instances[slot].before = 0;
  arrays_.spheres[slot].plant = InstanceSphere::kNoPlant;
  mark_changed(slot);
}

void InstanceTable::remove_slot(std::uint32_t slot) {
  clear_slot(slot);
  const std::uint32_t index = slot / kDirtyBlockSlots;
  Block& block = arrays_.blocks[index];
  const bool was_full = block.used == ~std::uint64_t{0};
  block.used &= ~(std::uint64_t{1} << slot % kDirtyBlockSlots);
  if (block.is_tile()) return;  // remove_tile frees the block
  const std::uint32_t handle = arrays_.owners[slot];
  ++arrays_.handles[handle].generation;
  arrays_.handles[handle].slot = std::exchange(free_index_, handle);
  ++free_slot_count_;
  if (was_full) link(index);
  if (block.used != 0) return;
  unlink(index);
  free_slot_count_ -= kDirtyBlockSlots;
  arrays_.freed_blocks[freed_block_count_++] = index;
}

}  // namespace coppice::gpu
