#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace coppice::bake {

/// Why a part of a file does not belong to the plant.
enum class LeftReason : std::uint8_t { none, not_chosen, collision, coarser_level, billboard, ground, other_variant };

/// What a file holds: its variants, and what is left out beside them.
struct SourceContents {
  struct Variant {
    std::string name;
    std::uint64_t triangles = 0;
    std::array<double, 3> size_m{};
  };
  struct Left {
    LeftReason reason = LeftReason::none;
    std::string name;
    std::uint64_t triangles = 0;
  };
  std::vector<Variant> variants;  ///< empty where there was nothing to choose from
  std::uint32_t taken = 0;        ///< index of the variant that is the plant
  std::vector<Left> left;         ///< levels, billboards and the like of all variants
};

}  // namespace coppice::bake
