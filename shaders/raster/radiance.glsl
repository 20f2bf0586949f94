// Linear radiance in one word, as VK_FORMAT_E5B9G9R9_UFLOAT_PACK32 has it: 9 bits of each colour and an exponent that they share. A step is
// 1/256 to 1/512 of the brightest colour, however bright that is.

const float kMaxRadiance = 65408.0;    // 511 / 512 of 2^16
const float kLeastRadiance = 1.526e-5; // 2^-16: what is darker shares its exponent

uint pack_radiance(vec3 radiance) {
  vec3 colors = clamp(radiance, vec3(0.0), vec3(kMaxRadiance));
  float brightest = max(max(colors.x, colors.y), max(colors.z, kLeastRadiance));
  // Of the power of two above the brightest colour once that is rounded, plus 15: 0 to 31.
  int exponent = (floatBitsToInt(brightest * 1.001) >> 23) - 111;
  uvec3 steps = uvec3(colors * intBitsToFloat((151 - exponent) << 23) + 0.5);
  return uint(exponent) << 27 | steps.z << 18 | steps.y << 9 | steps.x;
}

vec3 unpack_radiance(uint word) {
  return vec3(word & 511u, word >> 9 & 511u, word >> 18 & 511u) * intBitsToFloat((int(word >> 27) + 103) << 23);
}
