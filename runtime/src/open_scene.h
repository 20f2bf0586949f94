#pragma once

// An open scene of a context: turns tiles into instances and opens the plants that they need.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bounded_list.h"
#include "coppice/coppice.h"
#include "instances.h"
#include "scene_stream.h"
#include "select.h"
#include "tree_changes.h"

namespace coppice {

class Context;

/// A change of trees. plant and placements are for replaced trees, as in coppice_scene_replace.
struct TreeEdit {
  coppice_tree_state state = COPPICE_TREE_AS_IN_FILE;
  coppice_plant plant = 0;
  gpu::PlacementRecords placements{nullptr, 0, 0};
};

/// A box in world space, from its first origin.
struct WorldBox {
  dvec3 low{0, 0, 0}, high{0, 0, 0};
};

/// The destination of a query's trees.
struct TreeOutput {
  coppice_scene scene = 0;
  std::span<coppice_scene_tree> trees;
  std::uint32_t count = 0;  ///< may exceed the capacity
  std::uint32_t missing_tiles = 0;
};

/// Thread: as its context.
class OpenScene {
 public:
  /// context: outlives this object. index: the scene's, < COPPICE_MAX_SCENES. errors  as coppice_scene_open, logged already
  static Result<std::unique_ptr<OpenScene>> open(Context& context, std::uint32_t index, const char* path, const gpu::Pose& pose);
  /// Removes its instances and closes its plants. Not needed if the context is destroyed too.
  void close();

  /// views: the frame's. scene_count: number of scenes that share instances and memory
  void begin_frame(std::span<const LodView> views, std::uint64_t frame_number, std::uint64_t streaming_ns, std::uint32_t scene_count);
  void move(const gpu::Pose& pose);

  void fill_info(coppice_scene_info& info) const;
  /// False: the scene has no such species.
  bool fill_info(std::uint32_t species, coppice_scene_plant_info& info) const;
  void retry_failed() { stream_->retry_failed(); }
  [[nodiscard]] SceneStats stats() const { return stream_->stats(); }
  /// True if all tiles in demand are resident.
  [[nodiscard]] bool is_settled() const { return begun_ && stats().missing_tiles == 0; }

  /// The name of a scene's tile in InstanceTable::member_at().
  struct TileName {
    std::uint32_t scene = 0, tile = 0;
  };
  static TileName tile_name(std::uint32_t packed) { return {packed / COPPICE_MAX_SCENE_TILES, packed % COPPICE_MAX_SCENE_TILES}; }
  /// Empty if the file has the tree.
  [[nodiscard]] std::string tree_problem(const coppice_scene_tree& tree) const;
  /// Reserves memory for changes of this many trees. errors  out_of_memory
  Result<void> reserve_changes(std::size_t count);
  /// Changes the trees of `scene`. trees: present in the file; reserve_changes has reserved the memory. edit.placements: [trees]
  void change_trees(coppice_scene scene, std::span<const coppice_scene_tree> trees, const TreeEdit& edit);
  void query(const WorldBox& box, TreeOutput& out) const;
  /// The placement counts from the world's first origin.
  [[nodiscard]] coppice_tree_info tree_info(std::uint32_t tile, std::uint32_t number) const;

 private:
  struct Opening {
    std::uint32_t species = 0;
    coppice_plant plant = 0;
  };

  OpenScene(Context& context, std::uint32_t index, const gpu::Pose& pose) : context_(context), index_(index), pose_(pose) {}
  Result<void> allocate();
  /// Starts to open plants in demand, and takes over those that are open.
  void open_species(std::uint64_t frame_number);
  /// False if memory is short now.
  bool place_tile(const ReadyTile& ready);
  void remove_tile(std::uint32_t tile);
  [[nodiscard]] bool is_resident(std::uint32_t tile) const { return tiles_[tile].block_count > 0; }
  /// tile: is_resident
  [[nodiscard]] std::uint32_t member_slot(std::uint32_t tile, std::uint32_t number) const;
  /// What a changed tree shows; its own plant is known.
  [[nodiscard]] gpu::PlacedInstance shown(const TreeChange& change) const;
  /// Adds the trees of a tile, and of those below it, that stand in the box.
  void query_tile(std::uint32_t tile, const WorldBox& box, TreeOutput& out) const;
  void query_member(std::uint32_t tile, std::uint32_t number, const WorldBox& box, TreeOutput& out) const;
  /// The bounds of a box in the scene's space.
  [[nodiscard]] WorldBox world_box(const vec3& low, const vec3& high) const;

  Context& context_;
  std::uint32_t index_ = 0;
  gpu::Pose pose_;  ///< pose of the scene's space
  std::unique_ptr<SceneStream> stream_;
  std::vector<SceneEye> eyes_;               ///< scratch
  HookArray<gpu::InstanceTile> tiles_;       ///< [tile]
  std::uint32_t block_count_ = 0;            ///< blocks of all tiles
  HookArray<coppice_plant> plants_;          ///< [species] 0: not open
  BoundedList<gpu::PlacedInstance> placed_;  ///< scratch: at most one tile's
  BoundedList<Opening> opening_;
  TreeChanges changes_;
  bool begun_ = false;                  ///< begin_frame has been called
  std::uint64_t species_frame_ = 0;     ///< no plant is opened before this frame
  std::uint32_t species_attempts_ = 0;  ///< attempts at the next one
  std::uint64_t reserved_bytes_ = 0;    ///< reserved from the ledger
};

}  // namespace coppice
