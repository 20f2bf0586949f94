#version 460
#extension GL_GOOGLE_include_directive : require

// Leaves and wood triangles of few pixels: each a disc of its projected area about its middle, at one depth. Sunlight through the crown
// and fog are those of the cluster's middle.
// reads     view, instances, plants, lists, splat_items; clusters and splats by address
// writes    picture
// dispatch  indirect, from the round's splats stage; recorded by coppice::gpu::LeafRaster::record

#include "raster_extensions.glsl"
#include "bindings.glsl"
#include "shading.glsl"
#include "raster.glsl"
#include "radiance.glsl"
#include "write_pixel.glsl"

layout(local_size_x_id = 1) in;

// What the leaves of a cluster share, directions in object space.
struct Placed {
  vec3 origin, x, y, z;  // (px * w, px * w, w) of a splat's place: origin + q.x * x + q.y * y + q.z * z
  vec3 sun, up, eye;
  vec3 sunlight;   // what reaches the cluster through the crown
  vec3 tint;
  float size_px;   // of a splat of size 1, times w
  float clear;     // share of light that fog lets through
  bool wood;
};

Placed place(uint item, RasterCluster cluster) {
  Instance instance = instances[slot_of(item)];
  RasterList list = lists[instance.plant * kRasterLists + list_of(item)];
  Plant plant = plants[instance.plant];
  vec4 to_object = vec4(-instance.rotation.xyz, instance.rotation.w);
  Placed placed;
  placed.wood = list_of(item) >= kRasterLevels;
  placed.origin = screen_point(world_from_object(instance, list.box_min));
  placed.x = screen_direction(rotate(instance.rotation, vec3(instance.scale * list.splat_step.x, 0.0, 0.0)));
  placed.y = screen_direction(rotate(instance.rotation, vec3(0.0, instance.scale * list.splat_step.y, 0.0)));
  placed.z = screen_direction(rotate(instance.rotation, vec3(0.0, 0.0, instance.scale * list.splat_step.z)));
  placed.sun = rotate(to_object, view.sun_direction);
  placed.up = rotate(to_object, vec3(0.0, 1.0, 0.0));
  vec3 world = world_from_object(instance, cluster.center);
  placed.eye = rotate(to_object, normalize(view.camera_position - world));
  placed.sunlight = view.sun_color * sun_through_crown(crown_of(plant), cluster.center, placed.sun);
  placed.clear = transmittance(world);
  placed.tint = placed.wood ? vec3(1.0) : instance.tint;
  placed.size_px = list.splat_size_m / 65535.0 * instance.scale * view.focal_px;
  return placed;
}

uint splat_radiance(Placed placed, RasterSplat splat, vec3 normal, vec3 face) {
  vec4 look = unpackUnorm4x8(splat.look);
  float facing = dot(normal, placed.sun);
  float front = placed.wood ? max(0.0, facing) : max(0.0, 0.2 + 0.8 * facing);
  float through = placed.wood ? 0.0 : max(0.0, -sign(dot(face, placed.eye)) * dot(face, placed.sun));
  vec3 light = placed.sunlight * (front + 0.45 * through * vec3(1.0, 1.15, 0.35)) +
               mix(view.ground_color, view.sky_color, 0.5 + 0.5 * dot(normal, placed.up)) * look.a;
  vec3 albedo = kMaxSplatAlbedo * look.rgb * look.rgb * placed.tint;
  return pack_radiance(mix(view.fog_color, albedo * light, placed.clear));
}

void raster_splat(Placed placed, RasterSplat splat) {
  vec3 at = placed.origin + float(splat.xy & 0xffffu) * placed.x + float(splat.xy >> 16) * placed.y +
            float(splat.z_size & 0xffffu) * placed.z;
  float inverse_w = 1.0 / at.z;
  vec4 folded = unpackSnorm4x8(splat.normals);
  vec3 normal = unfold(folded.xy), face = unfold(folded.zw);
  // Of a disc of the same area; the eye sees a tilted leaf narrower.
  float radius_px = inversesqrt(3.14159265) * placed.size_px * float(splat.z_size >> 16) * inverse_w * sqrt(max(abs(dot(face, placed.eye)), 0.02));
  vec2 middle = at.xy * inverse_w;
  vec2 size = vec2(push.width_px, push.height_px);
  ivec2 low = ivec2(ceil(clamp(middle - radius_px, vec2(0.0), size) - 0.5));
  ivec2 high = ivec2(ceil(clamp(middle + radius_px, vec2(0.0), size) - 0.5));
  bool seen = at.z > view.near_m && low.x < high.x && low.y < high.y;
  uint radiance = splat_radiance(placed, splat, normal, face);
  float key = depth_key(inverse_w);
  // Its end at the bottom: no turn of the loop is in vain.
  ivec2 pixel = low;
  bool more = seen;
  do {
    vec2 off = vec2(pixel) + 0.5 - middle;
    if (more && dot(off, off) < radius_px * radius_px) write_pixel(uint(pixel.y) * push.width_px + uint(pixel.x), key, radiance);
    ++pixel.x;
    if (pixel.x >= high.x) pixel = ivec2(low.x, pixel.y + 1);
    more = seen && pixel.y < high.y;
  } while (more);
}

void main() {
  uint count = min(rounds[push.round].splats.count, kWorkCapacity);
  for (uint i = gl_WorkGroupID.x * kWorkPerGroup; i < count; i += gl_NumWorkGroups.x * kWorkPerGroup)
    for (uint j = i; j < min(i + kWorkPerGroup, count); ++j) {
      uvec2 work = splat_items[j];
      Instance instance = instances[slot_of(work.x)];
      RasterList list = lists[instance.plant * kRasterLists + list_of(work.x)];
      RasterCluster cluster = RasterClusterArray(list.clusters).at[work.y];
      Placed placed = place(work.x, cluster);
      uint splat = gl_LocalInvocationIndex;
      do {
        if (splat < cluster.splat_count) raster_splat(placed, RasterSplatArray(list.splats).at[cluster.first_splat + splat]);
        splat += gl_WorkGroupSize.x;
      } while (splat < cluster.splat_count);
    }
}
