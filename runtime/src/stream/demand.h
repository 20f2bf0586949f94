#pragma once

// Measures a view's demand for each plant: how many instances show it at which size. The streamer turns it into requests with priorities.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "coppice/coppice.h"
#include "instance_blocks.h"
#include "select.h"

namespace coppice {

/// Instances by projected size: bin b holds sizes [2^(b/2), 2^((b+1)/2)) px; the first and last bin also hold all smaller and larger ones.
inline constexpr std::uint32_t kSizeBinCount = 28;

/// A view's demand for one plant.
struct PlantDemand {
  float max_size_px = 0.0f;                      ///< size of the largest instance that is in view, or that wind may move into it; 0: none
  std::array<float, kSizeBinCount> instances{};  ///< weight per bin: 1 for an instance in view, kOutsideWeight for one outside
};

/// Maximum number of view groups; each has one threshold: see ViewGroup.
inline constexpr std::size_t kMaxViewGroups = 4;
/// Indexed by view group; none if the group has no view.
using GroupViews = std::array<std::optional<LodView>, kMaxViewGroups>;

/// Weight of an instance outside the view, which counts at half its size. Its plant is then half loaded when the head turns.
inline constexpr float kOutsideWeight = 0.1f;

/// True if a projection's last row is that of an orthographic one.
inline bool is_parallel(std::span<const float, 16> clip_from_view) {
  return clip_from_view[11] == 0.0f && clip_from_view[15] > 0.0f;
}

/// Makes a view from coppice_camera's matrices (column-major). origin_m: what its coordinates count from. errors  invalid_argument: the
/// matrices are no view, or error_px <= 0
Result<LodView> demand_view(const coppice_camera& camera, const dvec3& origin_m = {0, 0, 0});

/// The size, px, that represents a bin: its upper end, so that no instance is underestimated.
float size_bin_px(std::uint32_t bin);

/// Overwrites demands (indexed by InstanceSphere::plant). A block whose distance is large compared with its size, and that is entirely in
/// or out of view, is measured as a whole: its instances stand at its centre, or at its nearest point for max_size_px, and have their mean
/// radius if they are of one plant. Instances of other blocks are measured one by one.
void measure_demand(const InstanceBlocks& instances, const LodView& view, std::span<PlantDemand> demands);

/// Adds the demand of blocks [first_block, end_block) alone. end_block may lie beyond the last.
void add_demand(const InstanceBlocks& instances, std::size_t first_block, std::size_t end_block, const LodView& view,
                std::span<PlantDemand> demands);

}  // namespace coppice
