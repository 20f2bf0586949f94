#version 460
#extension GL_GOOGLE_include_directive : require

// Wood and leaf meshes with a normal map: as plant.frag, but each fragment has its own normal and light.
// reads     view, instances, plants, shadow_maps; materials and crown light by address; base_color, normal_map
// writes    what surface.glsl says
// draws     of wood.vert and leaf_mesh.vert with COPPICE_RELIEF, in coppice::gpu::ViewRecorder::record_draw

#include "bindings.glsl"
#include "surface_in.glsl"

layout(set = 2, binding = 0) uniform sampler2D normal_map;

layout(location = 6) in vec3 in_position;

// Turns the normal map's vector out of the frame of the texture coordinates, which derivatives give (Schueler, Normal Mapping Without
// Precomputed Tangents, ShaderX 5). `y` of a map points against v. Works for either side of the surface and any direction of the
// framebuffer's axes.
vec3 mapped_normal(vec3 normal) {
  vec2 stored = 2.0 * texture(normal_map, in_uv_occlusion_roughness.xy).ag - 1.0;
  vec3 position_x = dFdx(in_position), position_y = dFdy(in_position);
  vec2 uv_x = dFdx(in_uv_occlusion_roughness.xy), uv_y = dFdy(in_uv_occlusion_roughness.xy);
  vec3 across_y = cross(position_y, normal), across_x = cross(normal, position_x);
  vec3 along_u = across_y * uv_x.x + across_x * uv_y.x;
  vec3 along_v = across_y * uv_x.y + across_x * uv_y.y;
  float longest = max(dot(along_u, along_u), dot(along_v, along_v));
  if (longest < 1e-30) return normal;
  float scale = sign(dot(position_x, across_y)) * inversesqrt(longest);
  float out_of_surface = sqrt(max(0.0, 1.0 - dot(stored, stored)));
  return normalize(scale * (along_u * stored.x - along_v * stored.y) + normal * out_of_surface);
}

void main() {
  vec3 normal = mapped_normal(normalize(in_normal_along.xyz)), world = in_world_sun.xyz;
  vec3 albedo = textured_albedo();
  if (view.debug_view != 0) {
    write_color(albedo, surface_place());
    return;
  }
  Instance instance = instance_at(in_ids.x);
  Plant plant = plants[plant_of(instance)];
  Crown crown = crown_of(plant);
  LeafLight light = LeafLight(crown_light_at(plant.crown_light, crown, in_position), sun_past_others(instance, plant, world));
  CoppiceSurface surface;
  if (kLeaf != 0) {
    Material material = MaterialArray(plant.materials).at[in_ids.y];
    surface = leaf_surface(instance, light, in_world(instance, LeafNormals(normal, 1.0, material.sided_normals)), world);
  } else {
    surface = wood_surface(instance, light, oriented(instance.rotation, is_front() ? normal : -normal));
  }
  surface.albedo = albedo;
  surface.roughness = in_uv_occlusion_roughness.w;
  write_surface(surface, surface_place());
}
