// The engine's own change to each surface, compiled in if CMake's COPPICE_ENGINE_SURFACE names a file that defines
// `void coppice_engine_surface(inout CoppiceSurface surface, CoppiceSurfacePlace place)`. It runs for every pixel of both renderers, after
// the plant's override and before light and attachments. After coppice_surface.glsl.

struct CoppiceSurfacePlace {
  vec3 world;       // from the eye, axes of the world, m
  vec4 parameters;  // coppice_material_override.parameters
  uint user_data;   // coppice_placement.user_data
  bool is_wood;
};

#ifdef COPPICE_HAS_ENGINE_SURFACE
const bool kHasEngineSurface = true;
#include "coppice_engine_surface.glsl"
#else
const bool kHasEngineSurface = false;
void coppice_engine_surface(inout CoppiceSurface surface, CoppiceSurfacePlace place) {}
#endif
