// Where places of plants were in the frame before. After bindings.glsl and coppice_light.h.

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstanceArray { Instance at[]; };

// world: a place of the instance, here and now. Of one that came with this frame: as if it had stood there
vec3 world_before(Instance instance, vec3 world) {
  if (instance.before == 0 || instance.before == kCame) return world;
  Instance then = InstanceArray(view.moved).at[instance.before - 1];
  vec3 foot = from_eye(unpack_cell(instance.cell_xy, instance.cell_z_bias), instance.position);
  vec3 object = rotate(vec4(-instance.rotation.xyz, instance.rotation.w), world - foot) / instance.scale;
  return world_from_object(then, object);
}
