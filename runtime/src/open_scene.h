#pragma once

// An open scene of a context: tiles that come become instances, plants are opened for them.

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

/// What becomes of trees: plant and placements are of replaced ones, as coppice_scene_replace has them.
struct TreeEdit {
  coppice_tree_state state = COPPICE_TREE_AS_IN_FILE;
  coppice_plant plant = 0;
  gpu::PlacementRecords placements{nullptr, 0, 0};
};

/// World space, from its first origin.
struct WorldBox {
  dvec3 low{0, 0, 0}, high{0, 0, 0};
};

/// Where the trees of a query go.
struct TreeOutput {
  coppice_scene scene = 0;
  std::span<coppice_scene_tree> trees;
  std::uint32_t count = 0;  ///< may be more
  std::uint32_t missing_tiles = 0;
};

/// Thread: as its context.
class OpenScene {
 public:
  /// context: outlives this object. index: of the scene's, < COPPICE_MAX_SCENES. errors  as coppice_scene_open, logged already
  static Result<std::unique_ptr<OpenScene>> open(Context& context, std::uint32_t index, const char* path, const gpu::Pose& pose);
  /// Takes its instances and plants away. Not needed where the context goes too.
  void close();

  /// views: of the frame. scene_count: that share instances and memory
  void begin_frame(std::span<const LodView> views, std::uint64_t frame_number, std::uint64_t streaming_ns, std::uint32_t scene_count);
  void move(const gpu::Pose& pose);

  void fill_info(coppice_scene_info& info) const;
  /// False: the scene has no such species.
  bool fill_info(std::uint32_t species, coppice_scene_plant_info& info) const;
  [[nodiscard]] SceneStats stats() const { return stream_->stats(); }
  /// Whether all tiles that are wanted are there, and their plants have grown up.
  [[nodiscard]] bool is_settled() const { return begun_ && stats().missing_tiles == 0 && growing_.empty(); }

  /// What InstanceTable::member_at() calls a tile of a scene.
  struct TileName {
    std::uint32_t scene = 0, tile = 0;
  };
  static TileName tile_name(std::uint32_t packed) { return {packed / COPPICE_MAX_SCENE_TILES, packed % COPPICE_MAX_SCENE_TILES}; }
  /// Empty: the file has the tree.
  [[nodiscard]] std::string tree_problem(const coppice_scene_tree& tree) const;
  /// Room for changes of so many trees. errors  out_of_memory
  Result<void> reserve_changes(std::size_t count);
  /// trees: those of `scene`, which the file has, are changed; reserve_changes has made room. edit.placements: [trees]
  void change_trees(coppice_scene scene, std::span<const coppice_scene_tree> trees, const TreeEdit& edit);
  void query(const WorldBox& box, TreeOutput& out) const;
  /// The placement counts from the world's first origin.
  [[nodiscard]] coppice_tree_info tree_info(std::uint32_t tile, std::uint32_t number) const;

 private:
  struct Opening {
    std::uint32_t species = 0;
    coppice_plant plant = 0;
  };
  /// A tile whose plants grow up, and their share of the full size in kGrowFrames-ths.
  struct Growing {
    std::uint32_t tile = 0, share = 1;
  };

  OpenScene(Context& context, std::uint32_t index, const gpu::Pose& pose) : context_(context), index_(index), pose_(pose) {}
  Result<void> allocate();
  /// Starts to open plants that are wanted, and takes over those that are.
  void open_species(std::uint64_t frame_number);
  /// False: there is no memory for it now.
  bool place_tile(const ReadyTile& ready);
  void remove_tile(std::uint32_t tile);
  void grow_tiles();
  void finish_growth(std::uint32_t tile);
  [[nodiscard]] bool is_resident(std::uint32_t tile) const { return tiles_[tile].block_count > 0; }
  /// tile: is_resident
  [[nodiscard]] std::uint32_t member_slot(std::uint32_t tile, std::uint32_t number) const;
  /// What a changed tree whose own is known shows.
  [[nodiscard]] gpu::PlacedInstance shown(const TreeChange& change) const;
  /// What of a tile and those below it stands in the box.
  void query_tile(std::uint32_t tile, const WorldBox& box, TreeOutput& out) const;
  void query_member(std::uint32_t tile, std::uint32_t number, const WorldBox& box, TreeOutput& out) const;
  /// Round a box of the scene's space.
  [[nodiscard]] WorldBox world_box(const vec3& low, const vec3& high) const;

  Context& context_;
  std::uint32_t index_ = 0;
  gpu::Pose pose_;  ///< of the scene's space
  std::unique_ptr<SceneStream> stream_;
  std::vector<SceneEye> eyes_;               ///< scratch
  HookArray<gpu::InstanceTile> tiles_;       ///< [tile]
  std::uint32_t block_count_ = 0;            ///< of all tiles
  HookArray<coppice_plant> plants_;          ///< [species] 0: not open
  BoundedList<gpu::PlacedInstance> placed_;  ///< scratch: at most a tile's
  BoundedList<Opening> opening_;
  BoundedList<Growing> growing_;
  TreeChanges changes_;
  bool begun_ = false;               ///< a frame has
  std::uint64_t species_frame_ = 0;  ///< no plant is opened before
  std::uint32_t species_tries_ = 0;  ///< of the next one
  std::uint64_t taken_bytes_ = 0;    ///< from the ledger
};

}  // namespace coppice
