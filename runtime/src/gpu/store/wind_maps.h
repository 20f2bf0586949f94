#pragma once

#include <cstdint>

#include "frame_wind.h"
#include "garbage.h"
#include "hooks.h"
#include "uploads.h"

namespace coppice::gpu {

/// The maps of wind velocities (coppice_wind.map) of this frame and of the one before, where shaders find them. Without maps nothing is
/// allocated, nor copied.
class WindMaps {
 public:
  /// device, garbage: outlive this object
  WindMaps(Device& device, Garbage& garbage, const coppice_allocator& allocator)
      : device_(device), garbage_(garbage), allocator_(allocator) {}
  /// The GPU must be done with everything.
  ~WindMaps();
  WindMaps(const WindMaps&) = delete;
  WindMaps& operator=(const WindMaps&) = delete;

  /// Copies the frame's map and sets the addresses of both. Where memory is short the log says so, and the frame has no map.
  void begin_frame(FrameWind& wind);
  /// errors  out_of_memory, device_lost
  Result<void> upload(Uploads& uploads);

 private:
  Result<void> take(const coppice_wind& wind);
  void give_copy();

  Device& device_;
  Garbage& garbage_;
  coppice_allocator allocator_;
  Buffer now_, before_;
  HookArray<float> copy_;     ///< of the frame's, until it is uploaded; counted in the ledger
  bool is_uploaded_ = false;  ///< now_ holds its map
};

}  // namespace coppice::gpu
