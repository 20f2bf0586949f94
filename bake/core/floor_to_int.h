#pragma once

namespace coppice::bake {

/// Rounds down like std::floor, without the library call that baseline x86-64 makes of it.
/// value  must fit
template <class Integer>
[[nodiscard]] inline Integer floor_to_int(double value) {
  const auto truncated = static_cast<Integer>(value);
  return truncated - (static_cast<double>(truncated) > value ? 1 : 0);
}

}  // namespace coppice::bake
