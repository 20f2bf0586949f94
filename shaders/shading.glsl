// Light shared by leaves and wood. Per vertex: a leaf is a few pixels wide, so that a fragment has nothing to add but its texture.

vec3 ambient_light(vec3 normal) { return mix(view.ground_color, view.sky_color, 0.5 + 0.5 * normal.y); }

// 1: unobscured by fog.
float transmittance(vec3 world) {
  float optical_depth = view.fog_density * distance(world, view.camera_position);
  return exp(-optical_depth * optical_depth);
}

// Leaf vertices fill a box; the ellipsoid in it stands for the crown.
struct Crown {
  vec3 center;
  vec3 radii;
};

Crown crown_of(Plant plant) {
  vec3 half_box = 0.5 * float(plant.quantised_max) * plant.box_step;
  return Crown(plant.box_min + half_box, max(half_box, vec3(1e-3)));
}

// Share of the sun that reaches a point through the foliage between it and the crown's surface. All in object space.
float sun_through_crown(Crown crown, vec3 p, vec3 sun) {
  vec3 q = (p - crown.center) / crown.radii;
  vec3 d = sun / crown.radii;
  float a = dot(d, d);
  float b = dot(q, d);
  float c = dot(q, q) - 1.0;
  float way = (-b + sqrt(max(b * b - a * c, 0.0))) / a;   // to the far side, in object units
  float depth = max(way, 0.0) * sqrt(a);                  // in radii: 0 on the lit side, 2 behind
  return 0.18 + 0.82 * exp(-1.5 * depth);
}

// Share of the sky seen from inside the crown.
float sky_through_crown(Crown crown, vec3 p) {
  vec3 q = (p - crown.center) / crown.radii;
  return mix(0.35, 1.0, smoothstep(0.25, 1.15, length(q) + 0.35 * q.y));
}

// Light and dark, warm and cool: a value that follows the leaf's stalk (quantised in the leaf box), so that it survives a change of cut.
vec3 variation(Crown crown, Plant plant, uvec3 stalk) {
  vec3 place_in_crown = (plant.box_min + plant.box_step * vec3(stalk) - crown.center) / crown.radii;
  uvec3 cell = uvec3(ivec3(floor(place_in_crown * 4.0)) + 16);
  uint tuft = coppice_hash(cell.x + cell.y * 64u + cell.z * 4096u);
  uint leaf = coppice_hash(stalk.x + stalk.y * 16384u ^ stalk.z * 747796405u);
  float a = float(tuft >> 16) / 65535.0 - 0.5;
  float b = float(leaf >> 16) / 65535.0 - 0.5;
  float c = float(leaf & 0xffffu) / 65535.0 - 0.5;
  return (1.0 + 0.16 * a + 0.30 * b) * vec3(1.0 + 0.16 * c, 1.0, 1.0 - 0.14 * c);
}

// Light of a leaf at one of its vertices, two-sided, with the sun shining through. crown_normals: Material's. Object space: `middle` of the
// leaf, or near it; the vertex; `face`, the leaf's normal there, of any length and either side.
vec3 leaf_light(Crown crown, Instance instance, float crown_normals, vec3 middle, vec3 vertex, vec3 face) {
  vec3 outward = (middle - crown.center) / (crown.radii * crown.radii);
  outward = normalize(outward + vec3(0.0, 1e-4, 0.0));
  face = dot(face, face) > 1e-20 ? normalize(face) : outward;
  // The side that looks out of the crown; neither, little by little, where a leaf's curl passes from one to the other.
  float side = clamp(4.0 * dot(face, outward), -1.0, 1.0);
  vec3 normal = rotate(instance.rotation, normalize(mix(side * face, outward, max(crown_normals, 1e-3))));

  vec3 sun_object = rotate(vec4(-instance.rotation.xyz, instance.rotation.w), view.sun_direction);
  float sun = sun_through_crown(crown, vertex, sun_object);
  float facing = dot(normal, view.sun_direction);
  float front = max(0.0, 0.2 + 0.8 * facing);
  vec3 world_face = rotate(instance.rotation, face);
  float eye_side = dot(world_face, view.camera_position - world_from_object(instance, vertex)) < 0.0 ? -1.0 : 1.0;
  float through = max(0.0, -eye_side * dot(world_face, view.sun_direction));
  vec3 direct = view.sun_color * sun * (front + 0.45 * through * vec3(1.0, 1.15, 0.35));
  return direct + ambient_light(normal) * sky_through_crown(crown, vertex);
}

// Light of wood at a point of it. Object space; normal: unit.
vec3 wood_light(Crown crown, Instance instance, vec3 position, vec3 object_normal) {
  vec3 normal = rotate(instance.rotation, object_normal);
  vec3 sun_object = rotate(vec4(-instance.rotation.xyz, instance.rotation.w), view.sun_direction);
  vec3 direct = view.sun_color * sun_through_crown(crown, position, sun_object) * max(0.0, dot(normal, view.sun_direction));
  return direct + ambient_light(normal) * sky_through_crown(crown, position);
}

// The inverse of convert.cpp's octahedral().
vec3 octahedral_normal(uint packed) {
  vec2 e = unpackSnorm2x16(packed);
  vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
  float fold = max(-n.z, 0.0);
  n.xy -= fold * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
  return normalize(n);
}
