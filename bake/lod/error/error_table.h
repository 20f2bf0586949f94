#pragma once

#include "plant.h"
#include "progress.h"
#include "result.h"

namespace coppice::bake {

/// Renders about 24 cuts of the tree and the source at 512 px from six viewpoints that the collapse did not use, box-filters both down to
/// each size, and tabulates the error in pixels: size_px * rmse / 180 of colour over the image (ARCHITECTURE.md, "Error table"), or, where
/// that is larger and the cut has few leaves, coverage_error_px of the share by which coverage differs. A running maximum from the finest
/// level down makes it monotone. Parallel over views; the result does not depend on it.
/// plant   tree, card_table, materials, images and sphere are read
/// errors  invalid_argument: a material names an image that is not there
Result<ErrorTable> measure_error_table(const BakedPlant& plant, const ProgressFunction& progress);

}  // namespace coppice::bake
