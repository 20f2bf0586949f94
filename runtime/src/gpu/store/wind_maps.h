#pragma once

#include "frame_wind.h"
#include "hooks.h"
#include "uploads.h"

namespace coppice::gpu {

/// The maps of wind velocities (coppice_wind.map) of this frame and of the one before: two places of a buffer, in turns.
class WindMaps {
 public:
  /// device: outlives this object
  WindMaps(Device& device, const coppice_allocator& allocator) : device_(device), allocator_(allocator) {}
  ~WindMaps() { give_copy(); }
  WindMaps(const WindMaps&) = delete;
  WindMaps& operator=(const WindMaps&) = delete;

  /// Copies the frame's map, if any, and sets the addresses of both. errors  out_of_memory: the frame has no map
  Result<void> begin_frame(FrameWind& wind);
  /// maps: SceneBuffers::wind_maps, with room. errors  out_of_memory, device_lost
  Result<void> upload(Uploads& uploads, const Buffer& maps);

 private:
  Result<void> take(const coppice_wind& wind);
  void give_copy();

  Device& device_;
  coppice_allocator allocator_;
  HookArray<float> copy_;    ///< of the frame's, until it is uploaded; counted in the ledger
  std::uint32_t place_ = 0;  ///< of the frame's, below kWindMaps
  bool is_uploaded_ = false;
};

}  // namespace coppice::gpu
