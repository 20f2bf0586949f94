#pragma once

// How far a picture of a plant is from the reference, in measures that say what a person sees first: wrong colours, a plant that is fatter
// or thinner, as a whole or its trunk, and pieces that hang in the air.

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "picture.h"

namespace coppice::test {

/// The mean of pictures of one view, each moved by part of a pixel.
struct MeanPicture {
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<glm::vec4> texels;  ///< rows top to bottom; as displayed, 0..255, on the background; alpha: how much of it is plant, 0..1
};

struct LooksDifference {
  std::uint32_t blocks = 0;  ///< 8 x 8 px each, at least a quarter plant in the reference
  double wrong_blocks = 0;   ///< share of them whose mean is off by more than 6 % of 255 in a channel; 0 of none
  double coverage = 0;       ///< what the plant covers, by what it covers in the reference
  double wrong_rows = 0;     ///< share of its rows, but for two, that cover less than half as much as in the reference, or over twice
  double largest_piece = 0;  ///< share of the plant that its largest 8-connected piece holds
  double reference_largest_piece = 0;
};

/// Pictures of the same size, of which the reference shows something; else throws std::runtime_error.
LooksDifference compare_looks(const MeanPicture& reference, const MeanPicture& picture);

/// At most 5 % of the blocks, or two, are wrong, and 10 % of the rows; coverage is off by at most 6 %, and the largest piece by 5 %.
bool looks_alike(const LooksDifference& difference);

/// Linear light as displayed, 0..255.
glm::vec3 displayed(const glm::vec3& light);

/// The mean light of the plant's pixels, as displayed, 0..255. The first pixel must be background.
glm::vec3 mean_color(const MeanPicture& picture);

/// Root mean squared difference of displayed luminance on another background, over pixels that show the plant in either picture.
double rmse_on(const MeanPicture& reference, const MeanPicture& picture, const glm::vec3& background);

/// One line.
std::string describe(const LooksDifference& difference);

/// Reference, picture and their difference four times as strong, side by side; pixels of small pictures are enlarged.
Picture side_by_side(const MeanPicture& reference, const MeanPicture& picture);

}  // namespace coppice::test
