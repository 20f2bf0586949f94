#pragma once

// Projected areas by occlusion queries, the paper's own way: a view's leaves are drawn for their depth, then each leaf once more, and the
// device counts the samples in which it has that depth. This takes N_l + 1 passes a view, and one that counts the background.
//
// Item buffers give the same areas, except where a device rounds differently (a corner by 1/256 px, a texture coordinate at the edge of a
// texel) and where depths tie: a pixel of an item buffer has one leaf, a query counts every leaf of the smallest depth. The same driver
// gives the same areas; another driver may give others.

#include <memory>

#include "area_request.h"
#include "plant.h"
#include "progress.h"
#include "result.h"
#include "viewpoints.h"

namespace coppice::bake {

struct AreaDevice;  // area_device.h

/// Names the device that measures in one line: device, driver and its version.
/// errors  those of open_area_device
Result<std::string> area_device_name();

/// Measures areas on a Vulkan device, in the views of one plant. One thread at a time.
class OcclusionAreas {
 public:
  /// The views and cards to measure; copied. Views are over bounding_sphere(shown.foliage), as for item buffers.
  struct Scene {
    const ShownFoliage& shown;
    const std::vector<Viewpoint>& views;
    std::uint32_t resolution_px = 0;  ///< 1 .. kMaxResolutionPx
  };

  /// Uses the first suitable device. errors  those of open_area_device, alpha_masks and measure
  static Result<std::unique_ptr<OcclusionAreas>> create(const Scene& scene);
  static Result<std::unique_ptr<OcclusionAreas>> create(const Scene& scene, std::unique_ptr<AreaDevice> device);
  virtual ~OcclusionAreas() = default;

  /// The device's area_device_name().
  [[nodiscard]] virtual const std::string& device_name() const = 0;

  /// A MeasureAreas. Blocks until the device has counted.
  /// progress  may be empty
  /// errors  device_lost, out_of_memory, internal: the device failed
  virtual Result<void> measure(const AreaRequest& request, std::span<std::uint32_t> areas_px, const ProgressFunction& progress) = 0;
};

}  // namespace coppice::bake
