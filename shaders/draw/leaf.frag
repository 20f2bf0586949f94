#version 460
#extension GL_GOOGLE_include_directive : require

// Leaf quads: transparency, texture, alpha test; with COPPICE_DEPTH, for shadow maps, no colour.
// reads     view, instances; base_color
// writes    what surface.glsl says
// draws     of leaf.vert, in coppice::gpu::ViewRecorder::record_draw. Quads with neither texture nor transparency keep early depth tests.

#define COPPICE_QUADS
#include "bindings.glsl"
#include "surface_in.glsl"
#include "coppice_transparency.h"

layout(constant_id = 2) const uint kTransparent = 1;

void main() {
  vec3 albedo = textured_albedo();
  uvec2 pixel = pixel_in_picture();
  if (kTransparent != 0 && !shows_pixel(in_ids.z, pixel.x, pixel.y)) discard;
#ifndef COPPICE_DEPTH
  if (view.debug_view != 0) write_color(albedo, surface_place());
  else write_surface(surface_here(albedo), surface_place());
#endif
}
