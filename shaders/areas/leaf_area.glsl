// The inputs of leaf_area.vert and leaf_area.frag. OcclusionAreas (bake/lod/areas/occlusion_areas.cpp) writes them and records the draws.
#extension GL_EXT_buffer_reference : require

struct Leaf {
  float corners[12];  // four of x, y, z: metres from the middle of the bounding sphere, divided by its radius
  float uvs[8];       // one for each corner
  uint mask;          // index of the mask
};
struct Mask {
  uint width, height;  // texels; 0: no holes
  uint first_word;     // its first word in the holes: a bit a texel, rows top to bottom, 1 for a hole
};

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Leaves { Leaf leaves[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Masks { Mask masks[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Holes { uint words[]; };
layout(push_constant) uniform Push {
  mat4 clip_from_sphere;
  Leaves leaves;
  Masks masks;
  Holes holes;
};
