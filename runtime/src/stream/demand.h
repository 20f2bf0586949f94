#pragma once

// What the view asks of each plant: how many instances show it at what size. The streamer turns it into wants and priorities.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "coppice/coppice.h"
#include "instance_blocks.h"
#include "select.h"

namespace coppice {

/// Instances by projected size: bin b holds sizes [2^(b/2), 2^((b+1)/2)) px, the first and last bin what lies beyond.
inline constexpr std::uint32_t kSizeBinCount = 28;

/// One plant's demand in one view.
struct PlantDemand {
  float max_size_px = 0.0f;                      ///< of the largest instance in view, where wind may move it into it too; 0: none
  std::array<float, kSizeBinCount> instances{};  ///< weight per bin: 1 for an instance in view, kOutsideWeight for one outside
};

/// Views are taken together in at most so many lots, each with one threshold: see StreamLens.
inline constexpr std::size_t kMostLenses = 4;
/// By lens; none where there is no view.
using LensViews = std::array<std::optional<LodView>, kMostLenses>;

/// An instance outside the view counts this much, at half its size: turning the head should find it half ready.
inline constexpr float kOutsideWeight = 0.1f;

/// Whether a projection's last row is that of an orthographic one.
inline bool is_parallel(std::span<const float, 16> clip_from_view) {
  return clip_from_view[11] == 0.0f && clip_from_view[15] > 0.0f;
}

/// From coppice_camera's matrices (column-major). origin_m: what its coordinates count from. error  invalid_argument: the matrices are no
/// view, or error_px <= 0
Result<LodView> demand_view(const coppice_camera& camera, const dvec3& origin_m = {0, 0, 0});

/// Size, px, that stands for a bin: its upper end, so that no instance is taken for smaller than it is.
float size_bin_px(std::uint32_t bin);

/// Overwrites demands (indexed by InstanceSphere::plant). A block that is far away compared with its own size, and wholly in or out of
/// view, counts as a whole: its instances all stand at its centre, for max_size_px at its nearest point, and where they are of one plant
/// they are all of their mean radius. Other blocks' instances count one by one.
void measure_demand(const InstanceBlocks& instances, const LodView& view, std::span<PlantDemand> demands);

/// The same of blocks [first_block, end_block) alone, on top of what demands holds. end_block may lie beyond the last.
void add_demand(const InstanceBlocks& instances, std::size_t first_block, std::size_t end_block, const LodView& view,
                std::span<PlantDemand> demands);

}  // namespace coppice
