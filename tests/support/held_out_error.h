#pragma once

#include <cstdint>
#include <vector>

#include "alpha_mask.h"
#include "plant.h"
#include "visibility.h"

namespace coppice::test {

/// Root mean square luminance differences, 0..255, of images of 256 px and of the same box-filtered to 64 and 16 px; foliage pixels
/// relative to the source's.
struct HeldOutErrors {
  double rmse_256 = 0.0, rmse_64 = 0.0, rmse_16 = 0.0;
  double coverage = 0.0;
};

/// A plant seen from 24 viewpoints that the baker does not use, under a light that it does not use: what a cut is judged by.
class HeldOutViews {
 public:
  HeldOutViews(const bake::Foliage& source, const bake::Plant& plant);
  [[nodiscard]] HeldOutErrors errors_of(const bake::Foliage& cut) const;

 private:
  struct Picture {
    std::vector<float> luminance;  ///< 256 x 256
    std::uint32_t covered_px = 0;
  };
  [[nodiscard]] Picture render(const bake::Foliage& foliage, const bake::Projection& projection) const;

  std::vector<bake::AlphaMask> masks_;
  std::vector<float> albedo_;  ///< [material] linear luminance
  std::vector<bake::Projection> projections_;
  std::vector<Picture> source_;
};

}  // namespace coppice::test
