#pragma once

// What has been baked, as a picture for a person who looks through many plants: a bad bake is seen at a glance.

#include <cstdint>
#include <span>
#include <vector>

#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kNearPicturePx = 224;
inline constexpr std::uint32_t kFarPicturePx = 64;

/// On the left the plant near, with all that its file has, kNearPicturePx square. On the right, at the foot of a column kFarPicturePx wide,
/// the plant as it is drawn where it is so small: the coarsest cut and wood with an error of at most 2 px there, by the file's own tables.
/// From the front and a little above, lit by one sun, textured.
/// file  a .coppice file
/// returns  a WebP file. The same for any number of threads
/// errors  those of unpack; internal: the picture cannot be encoded
Result<std::vector<std::uint8_t>> baked_picture(std::span<const std::uint8_t> file);

}  // namespace coppice::bake
