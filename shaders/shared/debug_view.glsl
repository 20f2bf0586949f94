// Colours for coppice_camera.debug_view; coppice.h says what they mean. After bindings.glsl. An instance's is worked out where it is culled
// and kept by its slot; what draws it shows that and no light.

// From blue, 0, by green to red, 1.
vec3 ramp(float share) {
  float at = 2.0 * clamp(share, 0.0, 1.0);
  return vec3(max(at - 1.0, 0.0), 1.0 - abs(at - 1.0), max(1.0 - at, 0.0)) + 0.03;
}

vec3 debug_color(uint slot) { return unpackUnorm4x8(DebugColorArray(view.debug_colors).at[slot]).rgb; }

// What the hardware draws, where who draws a part of a plant counts and not how.
const vec3 kHardwareLeaves = vec3(1.0, 0.4, 0.05);
const vec3 kHardwareWood = vec3(0.1, 0.3, 0.9);
const vec3 kNotCounted = vec3(0.15);
