#pragma once

// An open scene of a context: tiles that come become instances, plants are opened for them.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bounded_list.h"
#include "coppice/coppice.h"
#include "instances.h"
#include "scene_stream.h"
#include "select.h"

namespace coppice {

class Context;

/// Thread: as its context.
class OpenScene {
 public:
  /// context: outlives this object. errors  as coppice_scene_open, logged already
  static Result<std::unique_ptr<OpenScene>> open(Context& context, const char* path, const gpu::Pose& pose);
  /// Takes its instances and plants away. Not needed where the context goes too.
  void close();

  /// views: of the frame. scene_count: that share instances and memory
  void begin_frame(std::span<const LodView> views, std::uint64_t frame_number, std::uint64_t streaming_ns, std::uint32_t scene_count);
  void move(const gpu::Pose& pose);

  void fill_info(coppice_scene_info& info) const;
  /// False: the scene has no such species.
  bool fill_info(std::uint32_t species, coppice_scene_plant_info& info) const;
  [[nodiscard]] SceneStats stats() const { return stream_->stats(); }

 private:
  struct Opening {
    std::uint32_t species = 0;
    coppice_plant plant = 0;
  };
  /// A tile whose plants grow up, and their share of the full size in kGrowFrames-ths.
  struct Growing {
    std::uint32_t tile = 0, share = 1;
  };

  OpenScene(Context& context, const gpu::Pose& pose) : context_(context), pose_(pose) {}
  Result<void> allocate();
  /// Starts to open plants that are wanted, and takes over those that are.
  void open_species(std::uint64_t frame_number);
  /// False: there is no memory for it now.
  bool place_tile(const ReadyTile& ready);
  void remove_tile(std::uint32_t tile);
  void grow_tiles();

  Context& context_;
  gpu::Pose pose_;  ///< of the scene's space
  std::unique_ptr<SceneStream> stream_;
  std::vector<SceneEye> eyes_;               ///< scratch
  HookArray<gpu::InstanceTile> tiles_;       ///< [tile]
  std::uint32_t block_count_ = 0;            ///< of all tiles
  HookArray<coppice_plant> plants_;          ///< [species] 0: not open
  BoundedList<gpu::PlacedInstance> placed_;  ///< scratch: at most a tile's
  BoundedList<Opening> opening_;
  BoundedList<Growing> growing_;
  std::uint64_t species_frame_ = 0;  ///< no plant is opened before
  std::uint32_t species_tries_ = 0;  ///< of the next one
  std::uint64_t taken_bytes_ = 0;    ///< from the ledger
};

}  // namespace coppice
