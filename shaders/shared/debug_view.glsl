// Colours for coppice_camera.debug_view; coppice.h says what they mean. After bindings.glsl. An instance's colour is computed when it is
// culled and stored by its slot; draws show it instead of light.

// Goes from blue, 0, through green to red, 1.
vec3 ramp(float share) {
  float at = 2.0 * clamp(share, 0.0, 1.0);
  return vec3(max(at - 1.0, 0.0), 1.0 - abs(at - 1.0), max(1.0 - at, 0.0)) + 0.03;
}

vec3 debug_color(uint slot) { return unpackUnorm4x8(DebugColorArray(view.debug_colors).at[slot]).rgb; }

// Colours for parts that the hardware draws, in views that show who draws a part.
const vec3 kHardwareLeaves = vec3(1.0, 0.4, 0.05);
const vec3 kHardwareWood = vec3(0.1, 0.3, 0.9);
const vec3 kNotCounted = vec3(0.15);
