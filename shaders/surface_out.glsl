// What wood.vert and leaf_mesh.vert hand on: the lit colour to plant.frag or, with COPPICE_RELIEF, what relief.frag lights.

#ifdef COPPICE_RELIEF
layout(location = 0) out vec3 out_albedo;
layout(location = 4) out vec3 out_position;  // object space, m
layout(location = 5) out vec3 out_normal;    // object space
layout(location = 6) flat out uvec2 out_slot_material;
#else
layout(location = 0) out vec3 out_light;
layout(location = 4) out vec3 out_back_light;  // where the back is seen
#endif
layout(location = 1) out float out_transmittance;
layout(location = 2) out vec2 out_uv;
layout(location = 3) flat out float out_alpha_cutoff;
