// Linear radiance in one word: the square roots of red, green (11 bits) and blue (10 bits). At a fiftieth of white a step is 3 %, finer
// than one of eight bits in sRGB.

const float kMaxRadiance = 16.0;

uint pack_radiance(vec3 radiance) {
  vec3 root = sqrt(clamp(radiance * (1.0 / kMaxRadiance), 0.0, 1.0));
  uvec3 steps = uvec3(root * vec3(2047.0, 2047.0, 1023.0) + 0.5);
  return steps.x << 21 | steps.y << 10 | steps.z;
}

vec3 unpack_radiance(uint word) {
  vec3 root = vec3(word >> 21, word >> 10 & 2047u, word & 1023u) * (1.0 / vec3(2047.0, 2047.0, 1023.0));
  return kMaxRadiance * root * root;
}
