// What every shader of the demo knows about the frame; the same text in C++ and GLSL. Vectors of four only: std140 adds no padding.
#ifdef __cplusplus
#pragma once

#include <glm/glm.hpp>

namespace forest {
using glm::mat4;
using glm::vec4;
#endif

struct FrameUniforms {
  mat4 clip_from_world;
  mat4 world_from_clip;
  mat4 clip_from_world_before;  // the frame before's
  vec4 eye;                     // xyz position, m; w time, s
  vec4 sun_direction;           // xyz unit, towards the sun; w time of the frame before, s
  vec4 sun_color;               // linear radiance; w 1: plants are shown in the colours of a debug view
  vec4 sky_color;               // ambient from above; w moves what is sampled at random, another in each frame that is averaged
  vec4 ground_color;            // ambient from below; w 1: there is forest beyond what is planted
  vec4 fog;                     // rgb colour, w density 1/m
  mat4 shadows[3];              // clip_from_world of the shadow maps, the finest first
  mat4 sky_map;                 // matrix of the map from above
  vec4 ground;                  // x half side of the ground map, m; y exposure; zw size of what is enlarged to the picture, px
  vec4 leaf_color;              // the mean of the leaves of all plants
  vec4 drawn_px;                // xy size of the pane
  vec4 gusts[4];                // coppice_gusts about the origin: direction x and z, load, gustiness; then its waves
  vec4 gusts_before[4];         // in the frame before
};

#ifdef __cplusplus
static_assert(sizeof(FrameUniforms) == 7 * 64 + 17 * 16);
}  // namespace forest
#endif
