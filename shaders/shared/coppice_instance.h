// The packed words of an Instance. This text compiles as GLSL and as C++ (namespace coppice::gpu).
//
// In a shader after bindings.glsl.

#ifndef COPPICE_INSTANCE_H
#define COPPICE_INSTANCE_H

#include "coppice_lod.h"
#include "coppice_shared.h"

#ifdef __cplusplus
namespace coppice::gpu {
#endif

COPPICE_FN uint pack_plant(uint plant, uint seed) {
  return plant | seed << kPlantBits;
}
/// kNoPlant in an empty slot.
COPPICE_FN uint plant_of(Instance instance) {
  return instance.plant_seed & kNoPlant;
}
/// The number that an instance's random choices are made of. It keeps it when it changes its slot.
COPPICE_FN uint seed_of(Instance instance) {
  return instance.plant_seed >> kPlantBits;
}

/// frames: 1 to 255. frame: View::frame of the frame before the first, 16 bits of it
COPPICE_FN uint pack_growth(uint frames, uint frame) {
  return kGrows | frames << 16u | (frame & 0xffffu);
}
/// True for Instance::before of an instance that grows up, or has grown up a while ago.
COPPICE_FN bool has_growth(uint before) {
  return (before & kGrows) != 0u && before != kCame;
}
/// The share of its size that an instance has. before: Instance's. frame: View's, or its low 16 bits
COPPICE_FN float grown_share(uint before, uint frame) {
  if (!has_growth(before)) return 1.0f;
  float frames = float(before >> 16u & 0xffu);
  return min(max(float((frame - before) & 0xffffu), 1.0f), frames) / frames;
}

#ifdef __cplusplus
}  // namespace coppice::gpu
#endif

#endif
