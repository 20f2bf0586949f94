#pragma once

#include "collapse.h"
#include "plant.h"

namespace coppice::bake {

/// Renders about 24 cuts of the tree and the source at 512 px from six viewpoints, box-filters both down to each size, and tabulates the error in
/// pixels: size_px * rmse / 255 of luminance over the image (ARCHITECTURE.md, "error table"). Made monotone by a running
/// maximum from the finest level down.
ErrorTable measure_error_table(const Tree& tree, const std::vector<Card>& card_table, const std::vector<Material>& materials,
                               const std::vector<Image>& images, const ProgressFunction& progress);

}  // namespace coppice::bake
