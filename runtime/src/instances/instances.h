#pragma once

// All placed plants: the CPU's copy of the device's instance buffer, and the handles of the engine.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "cells.h"
#include "coppice/coppice.h"
#include "coppice_instance.h"
#include "coppice_light.h"
#include "coppice_shared.h"
#include "hooks.h"
#include "instance_blocks.h"
#include "place_sort.h"
#include "result.h"
#include "select.h"

namespace coppice::gpu {

/// Number of slots that are uploaded together when one changes.
inline constexpr std::uint32_t kDirtyBlockSlots = 64;

/// Capacity once there is an instance.
inline constexpr std::uint32_t kFirstSlots = 1024;

coppice_placement default_placement();

/// An engine's placements, in records of its size: fields that they lack have defaults, bytes beyond ours are ignored.
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

/// The scale in the sense of coppice_placement.
inline float signed_scale(const Instance& instance) {
  return instance.rotation.w < 0.0f ? -instance.scale : instance.scale;
}

/// The place of its foot, from the world's first origin, m.
inline dvec3 place_of(const Instance& instance) {
  return world_place({unpack_cell(instance.cell_xy, instance.cell_z_bias), instance.position});
}

/// A rotation, then a translation.
struct Pose {
  dvec3 position{0, 0, 0};
  vec4 rotation{0, 0, 0, 1};  ///< unit quaternion
};
/// Returns the world placement of a thing whose placement is relative to a space at the pose.
coppice_placement placed_in(const Pose& pose, const coppice_placement& placement);
Pose inverse(const Pose& pose);

/// A plant and its place; the place does not count from the origin.
struct PlacedInstance {
  coppice_placement placement{};
  std::uint32_t plant = 0;  ///< kNoPlant: the place is empty
};

/// Instances that were added together: a list of blocks.
struct InstanceTile {
  static constexpr std::uint32_t kNoBlock = 0xffffffffu;
  std::uint32_t first_block = kNoBlock;
  std::uint32_t block_count = 0;  ///< one block for each kDirtyBlockSlots instances, the last one partly used
};

/// The content of a slot: the tile of its instance, and the instance's number in the tile.
struct TileMember {
  static constexpr std::uint32_t kNoTile = 0xffffffffu;
  std::uint32_t tile = kNoTile;  ///< as passed to add_tile; kNoTile: an instance with a handle
  std::uint32_t number = 0;
};

/// A run of slots.
struct SlotRange {
  std::uint32_t first = 0, count = 0;
};

/// Notes which blocks of kDirtyBlockSlots slots have changed. Only flags between the first and the last changed block are read, so a frame
/// without a change costs nothing.
class DirtySlots {
 public:
  /// Returns a copy for another number of slots. errors  out_of_memory: the allocator hook
  [[nodiscard]] Result<DirtySlots> resized(const coppice_allocator& allocator, std::uint32_t slot_count) const;

  void mark(SlotRange range);
  void mark(std::uint32_t slot) {
    const std::uint32_t block = slot / kDirtyBlockSlots;
    flags_[block] = 1;
    first_ = std::min(first_, block);
    end_ = std::max(end_, block + 1);
  }
  /// Returns the first run of changed blocks and marks it clean; empty if there is none. It may end behind the last slot used.
  SlotRange take();
  [[nodiscard]] std::size_t bytes() const { return flags_.bytes(); }

 private:
  HookArray<std::uint8_t> flags_;
  std::uint32_t first_ = 0xffffffffu, end_ = 0;  ///< blocks outside are clean
};

/// Slots are assigned in blocks of kDirtyBlockSlots. A block holds either instances with handles, which were added one by one, or those of
/// one tile, so instances in a block are near each other and come and go together. An empty block can become either kind. Instances with
/// handles change their slots: begin_frame sorts them by their places.
class InstanceTable {
  struct Arrays;

 public:
  InstanceTable() = default;
  /// Makes an empty table without memory. max_instances: <= kMaxHandleIndex. context_tag: for its handles
  InstanceTable(const coppice_allocator& allocator, std::uint32_t max_instances, std::uint32_t context_tag = 0)
      : allocator_(allocator), max_instances_(max_instances), context_tag_(context_tag) {}

  /// Number of slots that the arrays hold.
  [[nodiscard]] std::uint32_t capacity() const { return static_cast<std::uint32_t>(arrays_.instances.size()); }
  /// Number of slots needed to add this many instances with handles, or as a tile. errors  out_of_memory: more than max_instances, or than
  /// the others leave
  [[nodiscard]] Result<std::uint32_t> slots_for(std::size_t added) const;
  [[nodiscard]] Result<std::uint32_t> slots_for_tile(std::size_t added) const;
  /// Returns at least slot_count, and more if the arrays must grow, so that they seldom do.
  [[nodiscard]] std::uint32_t roomy(std::uint32_t slot_count) const;
  /// Bytes that resized() allocates; 0 if it need not.
  [[nodiscard]] std::uint64_t growth_bytes(std::uint32_t slot_count) const;
  /// Bytes of the arrays that become smaller with fewer slots.
  [[nodiscard]] static std::uint64_t slot_bytes(std::uint32_t slot_count);
  /// Returns a copy of the arrays for slot_count slots, >= min_capacity(), for take(). errors  out_of_memory: the allocator hook
  [[nodiscard]] Result<Arrays> resized(std::uint32_t slot_count) const;
  /// Forgets empty blocks of slots at the end. Returns the least number of slots that the arrays can have; 0 without an instance
  std::uint32_t min_capacity();
  /// Before: nothing has changed since resized().
  void take(Arrays&& arrays) { arrays_ = std::move(arrays); }
  /// Does both if needed. errors  out_of_memory: the allocator hook; nothing has changed
  Result<void> reserve(std::uint32_t slot_count);

  static constexpr std::uint64_t kPlantBytes = 24;
  /// Reserves memory for this many plants, kPlantBytes each; plants passed below are among them. errors  out_of_memory: the allocator hook;
  /// nothing has changed
  Result<void> reserve_plants(std::uint32_t count);
  /// Sets the bounding sphere of a plant's model, object space. Before, the plant's instances are kept, but the GPU sees none.
  void set_plant_sphere(std::uint32_t plant, std::span<const float, 3> center, float radius_m);

  /// placements  [n], checked by the caller. handles: [n] out, or empty. errors  as slots_for and reserve; none is added
  Result<void> add(std::uint32_t plant, const PlacementRecords& placements, std::span<coppice_instance> handles);
  /// Adds instances that come and go together. tile: the name that member_at() returns. errors  as slots_for_tile and reserve; none is
  /// added
  Result<InstanceTile> add_tile(std::uint32_t tile, std::span<const PlacedInstance> instances);
  /// slot: of a tile, here and below. number: of the instance in add_tile
  [[nodiscard]] std::uint32_t member_slot(const InstanceTile& tile, std::uint32_t number) const;
  [[nodiscard]] TileMember member_at(std::uint32_t slot) const;
  [[nodiscard]] PlacedInstance placed_at(std::uint32_t slot) const;
  void set_member(std::uint32_t slot, const PlacedInstance& placed);
  /// Sets the origin of placements with handles; those of tiles do not count from it.
  void set_origin(const dvec3& origin) { origin_ = origin; }
  [[nodiscard]] const dvec3& origin() const { return origin_; }
  /// Lets a tile's instances, or one with a handle, grow up about their feet in the next frames. frames: 1 to kMaxGrowthFrames
  void grow_tile(const InstanceTile& tile, std::uint32_t frames);
  void grow(coppice_instance handle, std::uint32_t frames);
  static constexpr std::uint32_t kMaxGrowthFrames = 255;
  /// True if an instance has not grown up yet.
  [[nodiscard]] bool is_growing() const { return frame_ < grown_frame_; }
  /// The share of its size that the instance in a slot has in this frame; spheres() have all of it.
  [[nodiscard]] float grown_share_at(std::uint32_t slot) const { return grown_share(arrays_.instances[slot].before, frame_); }
  /// Number of frames that have begun: View::frame.
  [[nodiscard]] std::uint32_t frame() const { return frame_; }
  /// Moves a tile's instances by one pose, and then by another.
  void move_tile(const InstanceTile& tile, const Pose& first, const Pose& then);
  void remove_tile(const InstanceTile& tile);
  /// Number of blocks that max_instances leaves for tiles.
  [[nodiscard]] std::uint32_t free_block_count() const;
  /// False for an instance of a tile, because those have no handles.
  [[nodiscard]] bool is_live(coppice_instance handle) const;
  /// handle: a live one (asserted).
  void move(coppice_instance handle, const coppice_placement& placement);
  void remove(coppice_instance handle);
  void remove_plant(std::uint32_t plant);
  /// Turns all instances of `from` into instances of `to`, at their places.
  void replace_plant(std::uint32_t from, std::uint32_t to);

  /// Begins a frame: instances grow, and some of those with handles are sorted. Takes a bounded time, whatever has changed.
  void begin_frame();
  /// True if instances with handles lie in the order of their places.
  [[nodiscard]] bool is_sorted() const { return !unsorted_ && sort_.is_done(); }

  [[nodiscard]] std::span<const Instance> slots() const { return arrays_.instances.span().first(slot_count_); }
  /// Returns the handle in a slot of slots(), which is not empty; 0 for an instance of a tile.
  [[nodiscard]] coppice_instance handle_at(std::uint32_t slot) const {
    return arrays_.blocks[slot / kDirtyBlockSlots].is_tile() ? 0 : handle_of(arrays_.owners[slot]);
  }
  [[nodiscard]] std::span<const InstanceSphere> spheres() const { return arrays_.spheres.span().first(slot_count_); }
  /// Their bounds are those of the last update_bounds().
  [[nodiscard]] InstanceBlocks blocks() const {
    return {spheres(), arrays_.bounds.span().first((slot_count_ + kInstanceBlockSlots - 1) / kInstanceBlockSlots)};
  }
  /// Updates the bounds of blocks with changed instances.
  void update_bounds();
  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] std::uint32_t plant_count(std::uint32_t plant) const { return plant < plants_.size() ? plants_[plant].count : 0; }
  [[nodiscard]] std::uint64_t bytes() const { return arrays_.bytes() + plants_.bytes(); }

  /// Places, at the last forget_moves(), of instances that have moved since then; Instance::before is an index into it.
  [[nodiscard]] std::span<const Instance> moved() const { return arrays_.moved.span().first(moved_count_); }
  /// Call it after a frame's upload: what has moved or was added counts as still from the next frame on. If more instances than one slot in
  /// kMovedShare move at once, the rest count as added.
  void forget_moves();
  static constexpr std::uint32_t kMovedShare = 8;
  [[nodiscard]] static std::uint32_t max_moved(std::uint32_t slot_count) { return (slot_count + kMovedShare - 1) / kMovedShare; }

  /// Returns the first run of slots to upload and marks it clean; empty if there is none.
  SlotRange take_dirty();
  /// Undoes take_dirty for a range that could not be uploaded.
  void mark_dirty(SlotRange range) { arrays_.dirty.mark(range); }

 private:
  struct Block {
    std::uint64_t used = 0;  ///< a bit per slot; slots that do not exist count as used
    /// Links blocks without a tile that have both used and free slots; `next` also links a tile's blocks.
    std::uint32_t previous = kNoBlock, next = kNoBlock;
    // For a tile's block: TileMember of the first slot.
    std::uint32_t tile = TileMember::kNoTile, first_number = 0;
    bool grows = false;  ///< an instance may have pack_growth in Instance::before

    [[nodiscard]] bool is_tile() const { return tile != TileMember::kNoTile; }
  };
  static constexpr std::uint32_t kNoBlock = InstanceTile::kNoBlock;
  /// What a handle's index names.
  struct HandleEntry {
    std::uint32_t slot = 0;  ///< of an index without an instance: the next such index, or kNoIndex
    std::uint32_t generation = 0;
  };
  static constexpr std::uint32_t kNoIndex = 0xffffffffu;
  /// All arrays by slot, by block of slots or by index of a handle.
  struct Arrays {
    HookArray<Instance> instances;
    HookArray<InstanceSphere> spheres;
    HookArray<std::uint32_t> owners;  ///< index of the handle of the instance in the slot
    HookArray<HandleEntry> handles;   ///< by index of a handle, as many as slots
    HookArray<Block> blocks;
    HookArray<std::uint32_t> freed_blocks;  ///< [freed_block_count_] a stack of blocks that were used and are empty now
    HookArray<InstanceBounds> bounds;       ///< per kInstanceBlockSlots slots
    HookArray<Instance> moved;              ///< [moved_count_]
    DirtySlots dirty;                       ///< since the last upload
    DirtySlots told;                        ///< blocks of which some slots have Instance::before
    DirtySlots unbounded;                   ///< since the last update_bounds()

    [[nodiscard]] std::uint64_t bytes() const;
  };
  struct PlantInstances {
    std::uint32_t count = 0;
    vec3 center{};  ///< centre of the model's sphere
    float radius_m = 0;
    bool known = false;  ///< the sphere is known
  };

  static_assert(sizeof(PlantInstances) == kPlantBytes);
  /// The plant in a slot, also if the GPU does not see it; kNoPlant if the slot is empty.
  [[nodiscard]] std::uint32_t plant_at(std::uint32_t slot) const { return arrays_.spheres[slot].plant; }
  /// origin: the one that the placement counts from
  void write(std::uint32_t slot, std::uint32_t plant, const coppice_placement& placement, const dvec3& origin);
  [[nodiscard]] coppice_instance handle_of(std::uint32_t index) const;
  [[nodiscard]] std::uint32_t slot_of(coppice_instance handle) const;
  std::uint32_t take_slot();
  std::uint32_t take_block();
  void link(std::uint32_t block);
  void unlink(std::uint32_t block);
  void clear_slot(std::uint32_t slot);
  void remove_slot(std::uint32_t slot);
  void mark_changed(std::uint32_t slot);
  void tell_before(std::uint32_t slot, std::uint32_t before);
  /// Sets Instance::before. then: the content of the slot before it was written
  void note_motion(std::uint32_t slot, const Instance& then);
  void start_growth(std::uint32_t slot, std::uint32_t frames);
  void end_growth();
  void end_growth(std::uint32_t block);
  struct SortedSlots;
  void sort_some();
  void swap_slots(std::uint32_t a, std::uint32_t b);

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
  std::uint32_t free_slot_count_ = 0;       ///< slots in that list
  std::uint32_t free_index_ = kNoIndex;     ///< list of indices of handles that were used
  std::uint32_t index_end_ = 0;             ///< indices from here on were never used
  std::uint32_t frame_ = 0, grown_frame_ = 0;
  std::uint32_t swept_block_ = 0;  ///< the next block for end_growth
  bool unsorted_ = false;          ///< instances with handles have come or moved since the last sort began
  PlaceSort sort_;
};

}  // namespace coppice::gpu
