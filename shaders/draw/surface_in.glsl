// What fragment shaders get from surface_out.glsl, and the texture of a draw. After bindings.glsl.

layout(constant_id = 0) const uint kTextured = 1;
layout(constant_id = 1) const uint kLeaf = 0;  // else wood

layout(set = 1, binding = 0) uniform sampler2D base_color;

layout(location = 0) in vec3 in_color;
layout(location = 1) in float in_transmittance;
layout(location = 2) in vec2 in_uv;
layout(location = 3) flat in float in_alpha_cutoff;

// Whether a triangle's corners run counter-clockwise to the viewer, whichever way y of the picture points.
bool is_front() { return gl_FrontFacing == (view.is_mirrored == 0); }

// Discards holes.
vec3 textured(vec3 color) {
  if (kTextured == 0) return color;
  vec4 texel = texture(base_color, in_uv);
  if (texel.a < in_alpha_cutoff) discard;
  return view.debug_view == 0 ? color * texel.rgb : color;
}

vec4 fogged(vec3 color) { return vec4(mix(view.fog_color, color, in_transmittance), 1.0); }
