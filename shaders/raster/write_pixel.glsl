// Writes one pixel of the rasteriser's picture. After raster.glsl.
// COPPICE_INT64 is defined for devices with 64-bit atomics. Without them everything is rasterised twice: first only the depth key, then the
// name where the key is still the leaf's.

const uint kDepth = 0;
const uint kName = 1;
const uint kCount = 2;  // for COPPICE_DEBUG_OVERDRAW: counts draws instead of writing a name
layout(constant_id = 2) const uint kPass = kDepth;  // kDepth or kCount with COPPICE_INT64

#ifdef COPPICE_INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
layout(set = 1, binding = 0, scalar) buffer PixelBuffer { uint64_t pixels[]; };
#endif

void write_pixel(uint pixel, float key, uint name) {
  uint bits = floatBitsToUint(max(key, 1e-30));
  if (kPass == kCount) {
    atomicMax(picture[2 * pixel + 1], bits);
    atomicAdd(picture[2 * pixel], 1);
    return;
  }
#ifdef COPPICE_INT64
  // Most pixels are hidden, and a load is cheaper than an atomic.
  if (picture_word(2 * pixel + 1) <= bits) atomicMax(pixels[pixel], uint64_t(bits) << 32 | uint64_t(name));
#else
  if (kPass == kDepth) {
    // A name that an earlier pass wrote belongs to something farther away now.
    if (atomicMax(picture[2 * pixel + 1], bits) < bits) picture[2 * pixel] = 0;
  } else if (picture[2 * pixel + 1] == bits) atomicMax(picture[2 * pixel], name);
#endif
}
