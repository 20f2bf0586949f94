// Sums over a frame. An addition to a sum of two words uses the wrap of the low word as the carry, because 64-bit atomics are an optional
// feature.
// After bindings.glsl.

layout(set = 0, binding = 9, scalar) buffer CounterBuffer { Counters counters; };

#define COPPICE_COUNT(sum, value) \
  { \
    if ((value) > 0 && atomicAdd(counters.sum[0], value) > 0xffffffffu - (value)) atomicAdd(counters.sum[1], 1); \
  }
