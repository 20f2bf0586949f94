// Writes a surface to the view's attachments, as their contents require. After bindings.glsl and shading.glsl.

#include "contents.glsl"
#include "engine_surface.glsl"

// Separate variables: those without an attachment are removed when the view's pipeline is built (shader_words.h).
layout(location = 0) out vec4 out_color_0;
layout(location = 1) out vec4 out_color_1;
layout(location = 2) out vec4 out_color_2;
layout(location = 3) out vec4 out_color_3;
layout(location = 4) out vec4 out_color_4;
layout(location = 5) out vec4 out_color_5;
layout(location = 6) out vec4 out_color_6;
layout(location = 7) out vec4 out_color_7;

// A place on a plant.
struct SurfacePlace {
  vec3 world;
  uint user_data;
  vec2 pixel;   // in the picture, not in the attachments
  vec3 before;  // the place in the frame before: clip x, y and w
  bool came;    // its instance came with this frame
  uint plant;
  bool is_wood;
};

// True if surfaces need their instance's plant or user_data.
bool needs_names() { return has_content(kContentUser) || view.has_overrides != 0 || kHasEngineSurface; }

// What the engine changes about a surface: the plant's override, then its own function.
CoppiceSurface engine_surface(CoppiceSurface surface, SurfacePlace place) {
  vec4 parameters = vec4(0.0);
  if (view.has_overrides != 0) {
    MaterialOverride changed = plants[place.plant].material_override;
    float roughness = place.is_wood ? changed.wood_roughness : changed.leaf_roughness;
    surface.albedo *= place.is_wood ? changed.wood_tint : changed.leaf_tint;
    if (roughness >= 0.0) surface.roughness = roughness;
    if (!place.is_wood && changed.translucency >= 0.0) surface.translucency = changed.translucency;
    parameters = changed.parameters;
  }
  coppice_engine_surface(surface, CoppiceSurfacePlace(place.world, parameters, place.user_data, place.is_wood));
  return surface;
}

vec4 lit_content(CoppiceSurface surface, vec3 world) {
  CoppiceLight light = CoppiceLight(view.sun_direction, view.sun_color, view.sky_color, view.ground_color);
  vec3 radiance = coppice_lit(surface, toward_eye(world), light);
  return vec4(mix(view.fog_color, radiance, transmittance(world)), 1.0);
}

vec4 velocity_content(SurfacePlace place) {
  // A place behind the eye was not in the picture.
  if (place.before.z <= 0.0) return vec4(0.0, 0.0, 1.0, 0.0);
  vec2 before = view.half_size_px * (place.before.xy / place.before.z + 1.0);
  return vec4(place.pixel - before, place.came ? 1.0 : 0.0, 0.0);
}

vec4 content_of(uint content, CoppiceSurface surface, SurfacePlace place) {
  if (content == kContentLit) return lit_content(surface, place.world);
  if (content == kContentAlbedo) return coppice_albedo_content(surface);
  if (content == kContentNormal) return coppice_normal_content(surface);
  if (content == kContentLight) return coppice_light_content(surface);
  if (content == kContentUser) return unpackUnorm4x8(place.user_data);
  if (content == kContentVelocity) return velocity_content(place);
  return vec4(0.0);
}

// One attachment after the other, so that a driver knows each one's content when it compiles.
#define COPPICE_CONTENT(i) (kContents >> (4 * i) & 15u)
#define COPPICE_EACH(write) \
  write(0); \
  write(1); \
  write(2); \
  write(3); \
  write(4); \
  write(5); \
  write(6); \
  write(7)

#define COPPICE_WRITE(i) out_color_##i = content_of(COPPICE_CONTENT(i), surface, place)
void write_surface(CoppiceSurface surface, SurfacePlace place) {
  surface = engine_surface(surface, place);
  COPPICE_EACH(COPPICE_WRITE);
}

// The outputs of a debug view: the colour replaces light, or the albedo. Motion is as ever; all else is 0.
vec4 debug_content(uint content, vec3 color, SurfacePlace place) {
  if (content == kContentVelocity) return velocity_content(place);
  return content == kContentLit || content == kContentAlbedo ? vec4(color, 1.0) : vec4(0.0);
}
#define COPPICE_WRITE_DEBUG(i) out_color_##i = debug_content(COPPICE_CONTENT(i), color, place)
void write_color(vec3 color, SurfacePlace place) { COPPICE_EACH(COPPICE_WRITE_DEBUG); }
