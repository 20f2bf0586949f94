#pragma once

// The pictures every quality figure is computed from. On purpose nothing here is shared with the baker's item buffers: another camera
// (perspective), another way to decide which pixels a triangle covers (rays against planes, in floating point), its own alpha test, its
// own shading. The baker cannot grade itself.

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kEvaluationCameraCount = 24;
inline constexpr std::uint32_t kEvaluationSizePx = 256;
inline constexpr std::uint32_t kMaxEvaluationSizePx = 4096;
inline constexpr float kEvaluationWhite = 255.0f;
/// Cameras stand at so many radii of the bounding sphere from its centre.
inline constexpr double kEvaluationDistanceRadii = 3.0;

/// A perspective camera with square pixels. right x up = -forward.
struct EvaluationCamera {
  glm::dvec3 position{0.0};
  glm::dvec3 right{0.0}, up{0.0}, forward{0.0};  ///< unit; rows go down along -up
  double tan_half_view = 0.0;                    ///< of half the field of view, the same both ways
};

/// Box centre of a mesh's vertices, and the farthest of them from it. Radius 0 without vertices.
Sphere evaluation_sphere(const Mesh& mesh);

/// `count` unit vectors, uniform on the sphere. Always the same ones.
std::vector<glm::dvec3> evaluation_directions(std::uint32_t count);

/// Looks at the sphere's centre from kEvaluationDistanceRadii away in a unit direction; the field of view just holds the sphere.
EvaluationCamera evaluation_camera(const glm::dvec3& direction, const Sphere& sphere);

/// Which colour a pixel shows.
enum class SurfaceColour {
  mean,      ///< one a material: simplifiers are compared by where they put leaves, not by what is painted on them
  textured,  ///< what the image shows there, of the mip level whose texels are about a pixel wide on the triangle
};

/// An image's albedo where it is no hole, at a power-of-two reduction. Texel (x, y) is the mean of those of the image whose coordinates,
/// shifted right by the level, are (x, y).
struct AlbedoMip {
  std::uint32_t width = 0;
  std::vector<float> albedo;  ///< [width * height]; 0 where all of them are holes
};

/// What a material looks like: its colour, and holes.
struct SurfaceLook {
  double albedo = 1.0;          ///< linear luminance: base colour times the mean of the image's texels that are no holes
  std::vector<AlbedoMip> mips;  ///< [level], the image's size and every halving of it, rounded up, to 1 x 1; empty: `albedo` everywhere
  bool all_holes = false;       ///< masked, without an image, base_color.a < alpha_cutoff
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> holes;  ///< [width * height] rows top to bottom, 1 where base_color.a * alpha < alpha_cutoff; empty: none
};

/// One look per material.
/// errors  invalid_argument: a material names an image that is not there, or whose bytes are not width * height * 4
Result<std::vector<SurfaceLook>> surface_looks(const std::vector<Material>& materials, const std::vector<Image>& images,
                                               SurfaceColour colour = SurfaceColour::mean);

/// A square picture on white, rows top to bottom.
struct EvaluationImage {
  std::uint32_t size_px = 0;
  std::vector<float> luminance;        ///< [size_px^2] 0..255, sRGB encoded as a display would show it
  std::vector<std::uint8_t> coverage;  ///< [size_px^2] 1 where foliage is seen
};

/// Luminance 0..255 of a surface of linear luminance `albedo` whose unit normal, on the side that is seen, is `normal`: Lambert, lit by
/// a fixed sun and a constant ambient light,  albedo * (0.35 + 0.65 max(0, n . sun)).
float lambert_luminance(double albedo, const glm::dvec3& normal);

/// Unit vector towards the fixed sun.
glm::dvec3 evaluation_sun();

/// Draws a mesh: one ray through each pixel's centre, the nearest triangle in front of the camera that is no hole there. Both sides of a
/// triangle are seen, flat shaded, the normal on the camera's side. Holes are those of the nearest texel, uvs repeat. Of equal depths the
/// first triangle wins. looks  one per material; every index of the mesh within its arrays (asserted)
EvaluationImage render_evaluation(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px);

}  // namespace coppice::bake
