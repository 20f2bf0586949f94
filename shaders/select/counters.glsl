// Sums over a frame, and how to add to one of two words: 64-bit atomics are an optional feature, the low word's wrap is the carry.
// After bindings.glsl.

layout(set = 0, binding = 9, scalar) buffer CounterBuffer { Counters counters; };

#define COPPICE_COUNT(sum, value) \
  { \
    if ((value) > 0 && atomicAdd(counters.sum[0], value) > 0xffffffffu - (value)) atomicAdd(counters.sum[1], 1); \
  }
