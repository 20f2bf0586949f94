#pragma once

#include "frame_wind.h"
#include "hooks.h"
#include "uploads.h"

namespace coppice::gpu {

/// The maps of wind velocities (coppice_wind.map) of this frame and of the one before, in two halves of a buffer that alternate.
class WindMaps {
 public:
  /// device: outlives this object
  WindMaps(Device& device, const coppice_allocator& allocator) : device_(device), allocator_(allocator) {}
  ~WindMaps() { release_copy(); }
  WindMaps(const WindMaps&) = delete;
  WindMaps& operator=(const WindMaps&) = delete;

  /// Copies the frame's map, if any, and sets the addresses of both. errors  out_of_memory: the frame has no map
  Result<void> begin_frame(FrameWind& wind);
  /// maps: SceneBuffers::wind_maps, large enough. errors  out_of_memory, device_lost
  Result<void> upload(Uploads& uploads, const Buffer& maps);

 private:
  Result<void> copy_map(const coppice_wind& wind);
  void release_copy();

  Device& device_;
  coppice_allocator allocator_;
  HookArray<float> copy_;    ///< the frame's map, until it is uploaded; counted in the ledger
  std::uint32_t place_ = 0;  ///< the frame's half, below kWindMaps
  bool is_uploaded_ = false;
};

}  // namespace coppice::gpu
