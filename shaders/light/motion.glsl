// Places of plants in the frame before. After bindings.glsl and coppice_light.h.

#ifndef COPPICE_MOTION_GLSL
#define COPPICE_MOTION_GLSL

// The instance as it stood in the frame before. One that came with this frame counts as unmoved
Instance instance_before(Instance instance) {
  if (instance.before == 0 || instance.before == kCame) return instance;
  uint place = instance.before - 1;
  return unpacked_instance(moved_texel(place, 0), moved_texel(place, 1), moved_texel(place, 2), moved_texel(place, 3));
}

// object: the place in the frame before, in the instance's object space
vec3 world_before(Instance instance, vec3 object) { return world_from_object(instance_before(instance), object); }

#endif
