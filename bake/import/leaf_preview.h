#pragma once

#include <cstdint>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// A picture in which a wrong guess about leaves is seen at a glance: the plant from the front, from the right and from above, side by
/// side, wood in brown and each leaf in a green of its own, between yellow and blue, so that leaves that were split or joined are seen too.
/// Alpha masks are honoured. On white.
/// returns a PNG file of RGB, 3 kPreviewSizePx wide and kPreviewSizePx high. The same bytes for any number of threads.
/// errors  internal: the picture cannot be encoded
Result<std::vector<std::uint8_t>> render_leaf_preview_png(const Plant& plant);

inline constexpr std::uint32_t kPreviewSizePx = 640;

}  // namespace coppice::bake
