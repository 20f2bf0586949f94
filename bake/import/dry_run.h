#pragma once

// What `coppice bake --dry-run` shows of a plant.

#include <cstdint>
#include <string>
#include <vector>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// The table that `coppice bake --dry-run` prints: a line for each material with its triangles, pieces, classes and what they became, and
/// below it its largest classes, each with its reason. Totals come last.
std::string parts_table(const Plant& plant);

/// Draws a picture that shows wrong guesses about leaves at a glance: the plant from the front, the right and above, side by side, on
/// white. Wood is brown. Each leaf has its own green between yellow and blue, so that leaves that were split or joined show too. Alpha
/// masks are honoured.
/// returns  a PNG file of RGB, 3 kPreviewSizePx wide and kPreviewSizePx high; the same bytes for any number of threads
/// errors  internal: the picture cannot be encoded
Result<std::vector<std::uint8_t>> render_leaf_preview_png(const Plant& plant);

inline constexpr std::uint32_t kPreviewSizePx = 640;

}  // namespace coppice::bake
