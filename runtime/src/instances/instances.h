#pragma once

// Every placed plant: the CPU's copy of the device's instance buffer, and the handles the engine holds.

#include <cstdint>
#include <span>
#include <vector>

#include "cells.h"
#include "coppice/coppice.h"
#include "coppice_light.h"
#include "coppice_shared.h"
#include "hooks.h"
#include "instance_blocks.h"
#include "result.h"
#include "select.h"

namespace coppice::gpu {

/// Slots whose change is uploaded together.
inline constexpr std::uint32_t kDirtyBlockSlots = 64;

/// That there is room for once there is an instance.
inline constexpr std::uint32_t kFirstSlots = 1024;

coppice_placement default_placement();

/// Placements of an engine, in records of its size: what they lack has its default, what they have beyond is not looked at.
struct PlacementRecords {
  const void* first = nullptr;
  std::size_t stride = 0, count = 0;

  PlacementRecords(const coppice_placement* of_engine, std::size_t stride_bytes, std::size_t how_many)
      : first(of_engine), stride(stride_bytes), count(how_many) {}
  PlacementRecords(std::span<const coppice_placement> whole) : PlacementRecords(whole.data(), sizeof(coppice_placement), whole.size()) {}
  PlacementRecords(const std::vector<coppice_placement>& whole) : PlacementRecords(std::span(whole)) {}
  coppice_placement operator[](std::size_t index) const;
};

inline uint pack_cell_xy(const ivec3& cell) {
  return (static_cast<uint>(cell.x) & 0xffffu) | static_cast<uint>(cell.y) << 16u;
}

/// As coppice_placement has it.
inline float signed_scale(const Instance& instance) {
  return instance.rotation.w < 0.0f ? -instance.scale : instance.scale;
}

/// Of its foot, from the world's first origin, m.
inline dvec3 place_of(const Instance& instance) {
  return world_place({unpack_cell(instance.cell_xy, instance.cell_z_bias), instance.position});
}

/// A rotation, then a translation.
struct Pose {
  dvec3 position{0, 0, 0};
  vec4 rotation{0, 0, 0, 1};  ///< unit quaternion
};
/// The placement of what stands so in a space that stands at the pose.
coppice_placement placed_in(const Pose& pose, const coppice_placement& placement);
Pose inverse(const Pose& pose);

/// A plant's place and which it is; the place does not count from the origin.
struct PlacedInstance {
  coppice_placement placement{};
  std::uint32_t plant = 0;  ///< kNoPlant: none stands there
};

/// Instances that were added together: a list of blocks.
struct InstanceTile {
  static constexpr std::uint32_t kNoBlock = 0xffffffffu;
  std::uint32_t first_block = kNoBlock;
  std::uint32_t block_count = 0;  ///< one for each kDirtyBlockSlots of them, or part of it
};

/// What is in a slot: of which tile, and the how many-th of its instances.
struct TileMember {
  static constexpr std::uint32_t kNoTile = 0xffffffffu;
  std::uint32_t tile = kNoTile;  ///< as add_tile was told; kNoTile: an instance by handle
  std::uint32_t number = 0;
};

/// A run of slots.
struct SlotRange {
  std::uint32_t first = 0, count = 0;
};

/// Which blocks of kDirtyBlockSlots slots have changed. Nothing is looked at between the first and the last of them but their flags, so
/// that a frame without a change costs nothing.
class DirtySlots {
 public:
  /// The same with room for more slots. errors  out_of_memory: the allocator hook
  [[nodiscard]] Result<DirtySlots> enlarged(const coppice_allocator& allocator, std::uint32_t slot_count) const;

  void mark(SlotRange range);
  /// The first run of changed blocks, marked clean; empty when there is none. It may end behind the last slot used.
  SlotRange take();
  [[nodiscard]] std::size_t bytes() const { return flags_.bytes(); }

 private:
  HookArray<std::uint8_t> flags_;
  std::uint32_t first_ = 0xffffffffu, end_ = 0;  ///< blocks outside are clean
};

/// Slots are given out in blocks of kDirtyBlockSlots, which hold either instances that were added one by one, by handle, or those of one
/// tile: what lies in a block is then near each other and comes and goes together. An empty block can become either.
class InstanceTable {
  struct Arrays;

 public:
  InstanceTable() = default;
  /// Empty, and without memory. max_instances: <= kMaxHandleIndex. context_tag: of its handles
  InstanceTable(const coppice_allocator& allocator, std::uint32_t max_instances, std::uint32_t context_tag = 0)
      : allocator_(allocator), max_instances_(max_instances), context_tag_(context_tag) {}

  /// Slots that there are arrays for.
  [[nodiscard]] std::uint32_t capacity() const { return static_cast<std::uint32_t>(arrays_.instances.size()); }
  /// Slots that it takes to add so many instances by handle, or as a tile. errors  out_of_memory: more than max_instances, or than the
  /// others leave room for
  [[nodiscard]] Result<std::uint32_t> slots_for(std::size_t added) const;
  [[nodiscard]] Result<std::uint32_t> slots_for_tile(std::size_t added) const;
  /// At least so many slots, and where capacity() is less, so many that it need not grow often.
  [[nodiscard]] std::uint32_t roomy(std::uint32_t slot_count) const;
  /// What enlarged() allocates: 0 where there is room.
  [[nodiscard]] std::uint64_t growth_bytes(std::uint32_t slot_count) const;
  /// A copy of the arrays with room for so many slots, > capacity(), for take(). errors  out_of_memory: the allocator hook
  [[nodiscard]] Result<Arrays> enlarged(std::uint32_t slot_count) const;
  /// Nothing has changed since enlarged().
  void take(Arrays&& arrays) { arrays_ = std::move(arrays); }
  /// Both, as far as there is need. errors  out_of_memory: the allocator hook; nothing has changed
  Result<void> reserve(std::uint32_t slot_count);

  static constexpr std::uint64_t kPlantBytes = 24;
  /// Room for so many plants, kPlantBytes each: below, a plant is one of them. errors  out_of_memory: the allocator hook; nothing has
  /// changed
  Result<void> reserve_plants(std::uint32_t count);
  /// Bounding sphere of a plant's model, object space. Before it is known the plant's instances are kept, but are none to the GPU.
  void set_plant_sphere(std::uint32_t plant, std::span<const float, 3> center, float radius_m);

  /// placements  [n], checked by the caller. handles: [n] out, or empty. errors  as slots_for and reserve; none is added
  Result<void> add(std::uint32_t plant, const PlacementRecords& placements, std::span<coppice_instance> handles);
  /// Adds instances that go together. tile: what member_at() calls it. errors  as slots_for_tile and reserve; none is added
  Result<InstanceTile> add_tile(std::uint32_t tile, std::span<const PlacedInstance> instances);
  /// slot: of a tile, here and below. number: of add_tile's instances
  [[nodiscard]] std::uint32_t member_slot(const InstanceTile& tile, std::uint32_t number) const;
  [[nodiscard]] TileMember member_at(std::uint32_t slot) const;
  [[nodiscard]] PlacedInstance placed_at(std::uint32_t slot) const;
  void set_member(std::uint32_t slot, const PlacedInstance& placed);
  /// What placements by handle count from; those of tiles do not.
  void set_origin(const dvec3& origin) { origin_ = origin; }
  [[nodiscard]] const dvec3& origin() const { return origin_; }
  /// Multiplies the scale of a tile's instances, about their feet.
  void scale_tile(const InstanceTile& tile, float factor);
  /// Moves a tile's instances by a pose, and then by another.
  void move_tile(const InstanceTile& tile, const Pose& first, const Pose& then);
  void remove_tile(const InstanceTile& tile);
  /// Blocks that max_instances leaves for tiles.
  [[nodiscard]] std::uint32_t free_block_count() const;
  /// False for an instance of a tile: those have no handles.
  [[nodiscard]] bool is_live(coppice_instance handle) const;
  /// handle: a live one (asserted).
  void move(coppice_instance handle, const coppice_placement& placement);
  void remove(coppice_instance handle);
  void remove_plant(std::uint32_t plant);
  /// All instances of `from` become instances of `to`, where they stand.
  void replace_plant(std::uint32_t from, std::uint32_t to);

  [[nodiscard]] std::span<const Instance> slots() const { return arrays_.instances.span().first(slot_count_); }
  /// Of what is in a slot of slots(); 0 for an instance of a tile. It is not empty
  [[nodiscard]] coppice_instance handle_at(std::uint32_t slot) const {
    return arrays_.blocks[slot / kDirtyBlockSlots].is_tile() ? 0 : handle_of(slot);
  }
  [[nodiscard]] std::span<const InstanceSphere> spheres() const { return arrays_.spheres.span().first(slot_count_); }
  /// Bounds as of the last update_bounds().
  [[nodiscard]] InstanceBlocks blocks() const {
    return {spheres(), arrays_.bounds.span().first((slot_count_ + kInstanceBlockSlots - 1) / kInstanceBlockSlots)};
  }
  /// Brings the bounds of blocks with changed instances up to date.
  void update_bounds();
  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] std::uint32_t plant_count(std::uint32_t plant) const { return plant < plants_.size() ? plants_[plant].count : 0; }
  [[nodiscard]] std::uint64_t bytes() const { return arrays_.bytes() + plants_.bytes(); }

  /// Where those that have moved since the last forget_moves() were then; Instance::before names one.
  [[nodiscard]] std::span<const Instance> moved() const { return arrays_.moved.span().first(moved_count_); }
  /// A frame has been uploaded: from the next on what has moved or come stands still. Whoever moves more of them at once than one slot in
  /// kMovedShare: the others count as come.
  void forget_moves();
  static constexpr std::uint32_t kMovedShare = 8;
  [[nodiscard]] static std::uint32_t most_moved(std::uint32_t slot_count) { return (slot_count + kMovedShare - 1) / kMovedShare; }

  /// The first run of slots to upload, marked clean; empty when there is none.
  SlotRange take_dirty();
  /// Undoes take_dirty for a range that could not be uploaded.
  void mark_dirty(SlotRange range) { arrays_.dirty.mark(range); }

 private:
  struct Block {
    std::uint64_t used = 0;  ///< bit per slot; slots that do not exist count as used
    /// Of blocks that are not a tile's and have both used and free slots; next also of a tile's.
    std::uint32_t previous = kNoBlock, next = kNoBlock;
    // Of a tile's blocks: TileMember of the first slot.
    std::uint32_t tile = TileMember::kNoTile, first_number = 0;

    [[nodiscard]] bool is_tile() const { return tile != TileMember::kNoTile; }
  };
  static constexpr std::uint32_t kNoBlock = InstanceTile::kNoBlock;
  /// Everything by slot or by block of slots.
  struct Arrays {
    HookArray<Instance> instances;
    HookArray<InstanceSphere> spheres;
    HookArray<std::uint32_t> generations;
    HookArray<Block> blocks;
    HookArray<std::uint32_t> freed_blocks;  ///< [freed_block_count_] a stack of blocks that were used and are empty
    HookArray<InstanceBounds> bounds;       ///< per kInstanceBlockSlots slots
    HookArray<Instance> moved;              ///< [moved_count_]
    DirtySlots dirty;                       ///< since the last upload
    DirtySlots told;                        ///< some of which have Instance::before
    DirtySlots unbounded;                   ///< since the last update_bounds()

    [[nodiscard]] std::uint64_t bytes() const;
  };
  struct PlantInstances {
    std::uint32_t count = 0;
    vec3 center{};  ///< of the model's sphere
    float radius_m = 0;
    bool known = false;  ///< the sphere is
  };

  static_assert(sizeof(PlantInstances) == kPlantBytes);
  /// Also of what the GPU does not see; kNoPlant where the slot is empty.
  [[nodiscard]] std::uint32_t plant_of(std::uint32_t slot) const { return arrays_.spheres[slot].plant; }
  /// origin: what the placement counts from
  void write(std::uint32_t slot, std::uint32_t plant, const coppice_placement& placement, const dvec3& origin);
  [[nodiscard]] coppice_instance handle_of(std::uint32_t slot) const;
  std::uint32_t take_slot();
  std::uint32_t take_block();
  void link(std::uint32_t block);
  void unlink(std::uint32_t block);
  void clear_slot(std::uint32_t slot);
  void remove_slot(std::uint32_t slot);
  void mark_changed(std::uint32_t slot);
  void tell_before(std::uint32_t slot, std::uint32_t before);

  coppice_allocator allocator_{};
  Arrays arrays_;
  HookArray<PlantInstances> plants_;
  dvec3 origin_{0, 0, 0};
  std::uint32_t max_instances_ = 0;
  std::uint32_t context_tag_ = 0;
  std::uint32_t slot_count_ = 0;  ///< slots ever used
  std::uint32_t count_ = 0;
  std::uint32_t moved_count_ = 0;
  std::uint32_t freed_block_count_ = 0;
  std::uint32_t block_end_ = 0;             ///< blocks from here on were never used
  std::uint32_t first_partial_ = kNoBlock;  ///< list of blocks with free slots
  std::uint32_t free_slot_count_ = 0;       ///< in that list
};

}  // namespace coppice::gpu
