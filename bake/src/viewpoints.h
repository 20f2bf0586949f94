#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// An orthographic camera on the sphere of directions; pixels are square, the image holds the bounding sphere exactly.
struct Viewpoint {
  glm::vec3 direction{0.0f};  ///< unit, from the plant's centre towards the camera
  glm::vec3 right{0.0f};      ///< unit, image +x
  glm::vec3 up{0.0f};         ///< unit, image -y (rows go down)
};

/// Bounds of leaf quads: sphere about the box centre.
Sphere bounding_sphere(const Foliage& foliage);

/// `count` viewpoints: 20 are the vertices of a regular dodecahedron (the paper's), any other count a Fibonacci sphere.
/// errors  invalid_argument: count is 0 or over 1024
Result<std::vector<Viewpoint>> viewpoints(std::uint32_t count);

}  // namespace coppice::bake
