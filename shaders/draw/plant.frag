#version 460
#extension GL_GOOGLE_include_directive : require

// Wood and leaf meshes: texture, alpha test; with COPPICE_DEPTH, for shadow maps, no colour.
// reads     view, instances; base_color
// writes    what surface.glsl says
// draws     of wood.vert and leaf_mesh.vert, in coppice::gpu::ViewRecorder::record_draw. Surfaces without texture keep early depth
//           tests.

#include "bindings.glsl"
#include "surface_in.glsl"

void main() {
  vec3 albedo = textured_albedo();
#ifndef COPPICE_DEPTH
  if (view.debug_view != 0) write_color(albedo, surface_place());
  else write_surface(surface_here(albedo), surface_place());
#endif
}
