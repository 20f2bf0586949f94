#pragma once

// Renders the images from which every quality figure is computed. It deliberately shares nothing with the baker's item buffers: it has
// another camera (perspective), another way to decide which pixels a triangle covers (rays against planes, in floating point), and its own
// alpha test. The baker cannot grade itself. What it shares is light on leaves (leaf_shade.h): the text that the renderer runs.

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "leaf_shade.h"
#include "level.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

inline constexpr std::uint32_t kEvaluationCameraCount = 24;
inline constexpr std::uint32_t kEvaluationSizePx = 256;
inline constexpr std::uint32_t kMaxEvaluationSizePx = 4096;
inline constexpr float kEvaluationWhite = 255.0f;
/// Distance of the cameras from the centre of the bounding sphere, in radii.
inline constexpr double kEvaluationDistanceRadii = 3.0;
inline constexpr double kMaxViewDistanceRadii = 1000.0;

/// A perspective camera with square pixels. right x up = -forward.
struct EvaluationCamera {
  glm::dvec3 position{0.0};
  glm::dvec3 right{0.0}, up{0.0}, forward{0.0};  ///< unit; rows go down along -up
  double tan_half_view = 0.0;                    ///< half the field of view, the same both ways
};

/// A sphere about the centre of the box of a mesh's vertices, through the farthest vertex. Radius 0 without vertices.
Sphere evaluation_sphere(const Mesh& mesh);

/// `count` unit vectors, uniform on the sphere, always the same.
std::vector<glm::dvec3> evaluation_directions(std::uint32_t count);

/// A camera that looks at the sphere's centre in a unit direction, from a distance of more than one radius. Its field of view just holds
/// the sphere.
EvaluationCamera evaluation_camera(const glm::dvec3& direction, const Sphere& sphere, double distance_radii = kEvaluationDistanceRadii);

/// Which colour a pixel shows.
enum class SurfaceColour {
  mean,      ///< one per material: compares where simplifiers put leaves, not what is painted on them
  textured,  ///< the image's texel there, from the mip level whose texels are about a pixel wide on the triangle
};

/// An image's albedo outside its holes, at a power-of-two reduction. Texel (x, y) is the mean of the image's texels whose coordinates,
/// shifted right by the level, are (x, y).
struct AlbedoMip {
  std::uint32_t width = 0;
  std::vector<float> albedo;  ///< [width * height]; 0 if all of a texel are holes
};

/// The appearance of a material: its colour, and holes.
struct SurfaceLook {
  double albedo = 1.0;          ///< linear luminance: base colour times the mean of the image's texels outside holes
  std::vector<AlbedoMip> mips;  ///< [level] the image's size and every halving of it, rounded up, to 1 x 1; empty: `albedo` everywhere
  bool all_holes = false;       ///< masked, without an image, base_color.a < alpha_cutoff
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> holes;  ///< [width * height] rows top to bottom, 1 where base_color.a * alpha < alpha_cutoff; empty: none
};

/// One look per material.
/// errors  invalid_argument: a material names an image that is not there, or whose bytes are not width * height * 4
Result<std::vector<SurfaceLook>> surface_looks(const std::vector<Material>& materials, const std::vector<Image>& images,
                                               SurfaceColour colour = SurfaceColour::mean);

/// A square image, rows top to bottom.
struct EvaluationImage {
  std::uint32_t size_px = 0;
  std::vector<float> luminance;        ///< [size_px^2] 0..255, sRGB encoded as a display would show it
  std::vector<std::uint8_t> coverage;  ///< [size_px^2] 1 where foliage is visible
};

/// Unit vector towards the fixed sun.
glm::dvec3 evaluation_sun();

inline constexpr std::uint32_t kEvaluationSunCount = 8;
/// Unit vectors towards the suns of a day, which no method knows: sun i has the height (i + 1/2) / 8 and turns by the golden angle.
std::vector<glm::dvec3> evaluation_suns();

/// Light on a leaf in the pictures of kEvaluationLights: its mean cosine c gives the luminance 0.2 + 0.6 c, 0..1 as a display would show
/// it, to a leaf of the reference's mean colour. Leaves of other colours have it in proportion to their albedos, as a display would show
/// them. So a ground of luminance 0.3 is as bright as leaves, whatever their colour.
struct EvaluationLight {
  const char* name;    ///< in reports
  float translucency;  ///< the share of the sun on a leaf's back that shines through
};
inline constexpr std::array kEvaluationLights{EvaluationLight{"one-sided", 0.0f}, EvaluationLight{"shining through", kTranslucency}};
/// Luminances behind the leaves, 0..1 as a display would show them: dark, as bright as leaves, white.
inline constexpr std::array kEvaluationGrounds{0.0, 0.3, 1.0};
inline constexpr std::size_t kLightingCount = kEvaluationLights.size() * kEvaluationGrounds.size();
/// Unit vectors towards the high and the low sun under which each light is measured: 60 and 17 degrees above the horizon.
std::array<glm::dvec3, 2> evaluation_light_suns();

/// One of the frames that an engine's temporal antialiasing averages.
struct EvaluationFrame {
  std::uint32_t index = 0;    ///< selects the random samples of leaves with less than full opacity
  glm::dvec2 jitter_px{0.0};  ///< offset of a pixel's sample from its centre, right and down
};

inline constexpr std::uint32_t kTemporalFrameCount = 16;
/// Frames whose jitters are Halton's sequence of bases 2 and 3 from its first element, minus a half.
std::vector<EvaluationFrame> temporal_frames();

/// Whether a leaf covers a sample: u < opacity. u in [0, 1) is a hash of leaf and pixel that advances by the golden ratio each frame. So
/// any 16 consecutive frames cover a pixel within about 1/16 of opacity, and leaves are independent of each other.
bool covers_sample(float opacity, std::uint32_t leaf, std::uint32_t pixel, std::uint32_t frame);

/// An image before it is lit: the surface at each pixel.
struct UnlitImage {
  /// Leaves that a surface stands for, and their share of its visible area.
  struct Facet {
    ShadingNormals normals;
    glm::vec3 to_viewer{0.0f};  ///< unit
    double share = 1.0;
  };
  struct Surface {
    double albedo = 1.0;       ///< linear
    bool is_textured = false;  ///< pixels have their own albedos
    std::uint32_t first_facet = 0, facet_count = 0;
  };
  std::uint32_t size_px = 0;
  std::vector<Surface> surfaces;
  std::vector<Facet> facets;
  std::vector<std::uint32_t> pixel_surfaces;  ///< [size_px^2], rows top to bottom; kNone: the ground
  std::vector<float> pixel_albedos;           ///< [size_px^2] for pixels with textured surfaces
};

/// Draws a level. It casts one ray through each pixel's centre, moved by the frame's jitter, to the nearest surface in front of the camera
/// that is no hole there. Triangles show both sides, each in one light. Holes are those of the nearest texel, uvs repeat. At equal
/// depths the first triangle wins. covers_sample decides where a leaf shows. A voxel is one leaf with the opacity 1 - exp(-a t / v), where
/// t is the length of the ray in it, v its volume and a its leaves' area as seen from the camera.
/// looks  one per material; every index of the mesh is within its arrays, normals are none or one a triangle (asserted)
UnlitImage render_unlit(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera, std::uint32_t size_px,
                        const EvaluationFrame& frame = {});

/// Lights the image by a sun, with lambert_luminance of leaf_shade.h and kTranslucency, on white.
EvaluationImage lit_image(const UnlitImage& unlit, const glm::dvec3& sun);

/// Lights the image's leaves as EvaluationLight says.
/// mean_tone  the mean of tone_sum over the reference's images, above 0
/// ground     what the other pixels have, 0..255
/// returns    [size_px^2] luminance 0..255
std::vector<float> leaf_luminances(const UnlitImage& unlit, const glm::dvec3& sun, float translucency, double mean_tone, float ground);

/// A sum over pixels with foliage of their albedos, 0..1 as a display would show them.
struct ToneSum {
  double sum = 0.0;
  std::size_t pixel_count = 0;
};
ToneSum tone_sum(const UnlitImage& unlit);

/// Renders and lights under evaluation_sun().
EvaluationImage render_evaluation(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px);
EvaluationImage render_evaluation(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px);

/// Luminance of the mean of temporal_frames(), as a display shows them in sequence. [size_px^2]
std::vector<float> render_temporal_mean(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                        std::uint32_t size_px);

}  // namespace coppice::bake
