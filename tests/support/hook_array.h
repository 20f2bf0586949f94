#pragma once

// Arrays of the allocator hook as tests make them, of what they have.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "hooks.h"

namespace coppice::test {

template <class T>
HookArray<T> hook_array(const std::vector<T>& values) {
  HookArray<T> array = *HookArray<T>::allocate(default_allocator(), values.size());
  std::ranges::copy(values, array.begin());
  return array;
}

template <class T>
HookArray<HookBuffer> hook_arrays(const T& buffers) {
  HookArray<HookBuffer> arrays = *HookArray<HookBuffer>::allocate(default_allocator(), buffers.size());
  std::ranges::transform(buffers, arrays.begin(), [](const auto& buffer) { return hook_array(std::vector(buffer.begin(), buffer.end())); });
  return arrays;
}

template <class T>
HookArray<T> copied(const HookArray<T>& array) {
  return *enlarged_copy(array, default_allocator(), array.size());
}

}  // namespace coppice::test
