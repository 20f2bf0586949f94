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
  vec3 half_box = 0.5 * float(16383) * plant.box_step;
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
