#pragma once

// The pictures every quality figure is computed from. On purpose nothing here is shared with the baker's item buffers: another camera
// (perspective), another way to decide which pixels a triangle covers (rays against planes, in floating point), its own alpha test, its
// own shading. The baker cannot grade itself.

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kEvaluationCameraCount = 24;
inline constexpr std::uint32_t kEvaluationSizePx = 256;
inline constexpr std::uint32_t kMaxEvaluationSizePx = 4096;
inline constexpr float kEvaluationWhite = 255.0f;
/// Cameras stand at so many radii of the bounding sphere from its centre.
inline constexpr double kEvaluationDistanceRadii = 3.0;
inline constexpr double kMaxViewDistanceRadii = 1000.0;

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

/// Looks at the sphere's centre from so many radii away (more than 1) in a unit direction; the field of view just holds the sphere.
EvaluationCamera evaluation_camera(const glm::dvec3& direction, const Sphere& sphere, double distance_radii = kEvaluationDistanceRadii);

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

inline constexpr std::uint32_t kEvaluationSunCount = 8;
/// Unit vectors towards the suns of a day, none of which a method has seen: sun i has the height (i + 1/2) / 8 and goes round by the golden
/// angle.
std::vector<glm::dvec3> evaluation_suns();

/// One of the frames that an engine's temporal antialiasing takes the mean of.
struct EvaluationFrame {
  std::uint32_t index = 0;    ///< which random samples leaves of less than full opacity get
  glm::dvec2 jitter_px{0.0};  ///< how far from its centre a pixel is sampled, right and down
};

inline constexpr std::uint32_t kTemporalFrameCount = 16;
/// Jitters are Halton's of bases 2 and 3, from the first on, less a half.
std::vector<EvaluationFrame> temporal_frames();

/// Whether a leaf covers a sample: u < opacity, where u in [0, 1) is a hash of leaf and pixel, and from frame to frame goes on by the
/// golden ratio. So any 16 frames in a row cover a pixel within about 1/16 of opacity, and leaves are independent of each other.
bool covers_sample(float opacity, std::uint32_t leaf, std::uint32_t pixel, std::uint32_t frame);

/// A picture before it is lit: what each pixel shows.
struct UnlitPicture {
  /// A normal that a surface shows the camera, and its share of what is seen.
  struct Facet {
    glm::dvec3 normal{0.0};
    double share = 1.0;
  };
  struct Surface {
    double albedo = 1.0;       ///< linear
    bool is_textured = false;  ///< pixels have albedos of their own
    std::uint32_t first_facet = 0, facet_count = 0;
  };
  std::uint32_t size_px = 0;
  std::vector<Surface> surfaces;
  std::vector<Facet> facets;
  std::vector<std::uint32_t> pixel_surfaces;  ///< [size_px^2], rows top to bottom; kNone: the white background
  std::vector<float> pixel_albedos;           ///< [size_px^2] of textured surfaces
};

/// Draws a level: one ray through each pixel's centre, moved by the frame's jitter, the nearest surface in front of the camera that is no
/// hole there. Both sides of a triangle are seen, flat shaded, the normal on the camera's side. Holes are those of the nearest texel, uvs
/// repeat. Of equal depths the first triangle wins. A leaf is seen where covers_sample says so. A voxel is one leaf, seen with the opacity
/// 1 - exp(-a t / v), t the ray's way through it, v its volume and a its leaves' area as seen from the camera.
/// looks  one per material; every index of the mesh within its arrays, shades none or one for two triangles (asserted)
UnlitPicture render_unlit(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera, std::uint32_t size_px,
                          const EvaluationFrame& frame = {});

/// The picture under a sun, as lambert_luminance has it.
EvaluationImage lit_picture(const UnlitPicture& picture, const glm::dvec3& sun);

/// Both, under evaluation_sun().
EvaluationImage render_evaluation(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px);
EvaluationImage render_evaluation(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px);

/// Luminance of the mean of temporal_frames(), as a display shows them one after the other. [size_px^2]
std::vector<float> render_temporal_mean(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                        std::uint32_t size_px);

}  // namespace coppice::bake
