#pragma once

#include <vector>

#include "hooks.h"

namespace coppice::bake {

template <class T>
std::vector<T> to_vector(const HookArray<T>& array) {
  return {array.begin(), array.end()};
}

}  // namespace coppice::bake
