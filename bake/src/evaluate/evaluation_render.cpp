// A ray caster that walks triangles. With the camera at the origin, the ray of a pixel is d = (x, y, 1) and the triangle a, b, c is hit
// where d . (b x c), d . (c x a) and d . (a x b) have the sign of a . (b x c); these three are also the corners' weights at the hit,
// perspective included, and depth is a . (b x c) over their sum. Nothing is divided by a corner's depth, so triangles may reach behind
// the camera. An edge shared by two triangles gives exactly opposite numbers in them: no pixel falls between.

#include "evaluation_render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "check.h"
#include "seeded_random.h"

namespace coppice::bake {
namespace {

constexpr std::uint64_t kDirectionSeed = 20070805;
constexpr double kAmbient = 0.35;

double linear_from_srgb(std::uint8_t value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double value) {
  return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

double luminance(const glm::dvec3& linear) {
  return glm::dot(linear, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// Sums over texels that are no holes.
struct AlbedoSums {
  std::uint32_t width = 0, height = 0;
  std::vector<double> sums;
  std::vector<std::uint32_t> counts;
};

AlbedoMip mean_albedo(const AlbedoSums& level) {
  AlbedoMip mip{level.width, std::vector<float>(level.sums.size(), 0.0f)};
  for (std::size_t i = 0; i < level.sums.size(); ++i)
    if (level.counts[i] > 0) mip.albedo[i] = static_cast<float>(level.sums[i] / level.counts[i]);
  return mip;
}

AlbedoSums halved(const AlbedoSums& level) {
  AlbedoSums half{(level.width + 1) / 2, (level.height + 1) / 2, {}, {}};
  half.sums.resize(std::size_t{half.width} * half.height);
  half.counts.resize(half.sums.size());
  for (std::size_t y = 0; y < level.height; ++y)
    for (std::size_t x = 0; x < level.width; ++x) {
      const std::size_t to = y / 2 * half.width + x / 2, from = y * level.width + x;
      half.sums[to] += level.sums[from];
      half.counts[to] += level.counts[from];
    }
  return half;
}

std::vector<AlbedoMip> albedo_mips(AlbedoSums level) {
  std::vector<AlbedoMip> mips{mean_albedo(level)};
  while (level.width > 1 || level.height > 1) {
    level = halved(level);
    mips.push_back(mean_albedo(level));
  }
  return mips;
}

Result<SurfaceLook> look_of(const Material& material, const std::vector<Image>& images, SurfaceColour colour) {
  SurfaceLook look;
  const glm::dvec3 factor(material.base_color);
  look.albedo = luminance(factor);
  const bool masked = material.alpha_cutoff > 0.0f;
  if (material.image == kNone) {
    look.all_holes = masked && material.base_color.a < material.alpha_cutoff;
    return look;
  }
  if (material.image >= images.size())
    return Error{Status::invalid_argument, "a material's image is out of range", Error::kNoOffset, material.name};
  const Image& image = images[material.image];
  const std::size_t texel_count = std::size_t{image.width} * image.height;
  if (texel_count == 0 || image.rgba.size() != 4 * texel_count)
    return Error{Status::invalid_argument, "an image's size and data disagree", Error::kNoOffset, material.name};

  if (masked) look.holes.resize(texel_count);
  look.width = image.width;
  look.height = image.height;
  AlbedoSums texels{image.width, image.height, {}, {}};
  if (colour == SurfaceColour::textured) {
    texels.sums.resize(texel_count);
    texels.counts.resize(texel_count);
  }
  glm::dvec3 sum(0.0);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < texel_count; ++i) {
    const std::uint8_t* rgba = image.rgba.data() + 4 * i;
    const bool hole = masked && material.base_color.a * static_cast<float>(rgba[3]) / 255.0f < material.alpha_cutoff;
    if (masked) look.holes[i] = hole ? 1 : 0;
    if (hole) continue;
    const glm::dvec3 linear(linear_from_srgb(rgba[0]), linear_from_srgb(rgba[1]), linear_from_srgb(rgba[2]));
    sum += linear;
    ++seen;
    if (texels.sums.empty()) continue;
    texels.sums[i] = luminance(factor * linear);
    texels.counts[i] = 1;
  }
  if (seen > 0) look.albedo = luminance(factor * sum / static_cast<double>(seen));
  if (!texels.sums.empty()) look.mips = albedo_mips(std::move(texels));
  return look;
}

struct Texel {
  std::uint32_t x = 0, y = 0;
};

Texel nearest_texel(const SurfaceLook& look, const glm::dvec2& uv) {
  const auto texel = [](double coordinate, std::uint32_t size) {
    const double wrapped = coordinate - std::floor(coordinate);
    return std::min(static_cast<std::uint32_t>(wrapped * size), size - 1);
  };
  return {texel(uv.x, look.width), texel(uv.y, look.height)};
}

double albedo_at(const SurfaceLook& look, Texel texel, std::uint32_t level) {
  const AlbedoMip& mip = look.mips[level];
  return double{mip.albedo[std::size_t{texel.y >> level} * mip.width + (texel.x >> level)]};
}

/// Pixels [first, last] of a row or column; empty when last < first.
struct PixelRange {
  std::int32_t first = 0, last = -1;
};

/// A triangle as the rays see it, in camera space: x right, y up, z forward.
struct RayTriangle {
  std::array<glm::dvec3, 3> edges{};  ///< b x c, c x a, a x b, of the sign that makes hits positive
  double determinant = 0.0;           ///< a . (b x c), positive; 0: seen edge-on or without area
  PixelRange columns, rows;
  double doubled_area_px = 0.0;  ///< in the picture; 0 where a corner is not in front of the camera
};

/// How a triangle is coloured.
struct TrianglePaint {
  const SurfaceLook& look;
  glm::dvec3 normal{0.0};   ///< unit, on the camera's side; 0 without area
  float mean_value = 0.0f;  ///< luminance of the mean albedo
  std::uint32_t mip_level = 0;
};

class Painter {
 public:
  Painter(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera, std::uint32_t size_px)
      : mesh_(mesh), looks_(looks), camera_(camera), size_px_(static_cast<std::int32_t>(size_px)) {
    const std::size_t pixel_count = std::size_t{size_px} * size_px;
    image_ = {size_px, std::vector<float>(pixel_count, kEvaluationWhite), std::vector<std::uint8_t>(pixel_count, 0)};
    depths_.assign(pixel_count, std::numeric_limits<double>::infinity());
  }

  void draw(std::size_t triangle) {
    const std::uint32_t* indices = mesh_.indices.data() + 3 * triangle;
    const SurfaceLook& look = looks_[mesh_.triangle_materials[triangle]];
    const RayTriangle ray_triangle = prepare(indices);
    if (ray_triangle.determinant == 0.0 || look.all_holes) return;
    const glm::dvec3 normal = seen_normal(indices);
    const TrianglePaint paint{look, normal, lambert_luminance(look.albedo, normal), mip_level(indices, look, ray_triangle)};
    for (std::int32_t y = ray_triangle.rows.first; y <= ray_triangle.rows.last; ++y)
      for (std::int32_t x = ray_triangle.columns.first; x <= ray_triangle.columns.last; ++x) draw_pixel(ray_triangle, indices, paint, x, y);
  }

  EvaluationImage take() { return std::move(image_); }

 private:
  [[nodiscard]] double ray_x(std::int32_t x) const { return camera_.tan_half_view * ((2.0 * x + 1.0) / size_px_ - 1.0); }
  [[nodiscard]] double ray_y(std::int32_t y) const { return camera_.tan_half_view * (1.0 - (2.0 * y + 1.0) / size_px_); }

  [[nodiscard]] RayTriangle prepare(const std::uint32_t* indices) const {
    std::array<glm::dvec3, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 offset = glm::dvec3(mesh_.positions[indices[i]]) - camera_.position;
      corners[i] = {glm::dot(offset, camera_.right), glm::dot(offset, camera_.up), glm::dot(offset, camera_.forward)};
    }
    RayTriangle triangle;
    triangle.edges = {glm::cross(corners[1], corners[2]), glm::cross(corners[2], corners[0]), glm::cross(corners[0], corners[1])};
    triangle.determinant = glm::dot(corners[0], triangle.edges[0]);
    if (triangle.determinant < 0.0) {
      triangle.determinant = -triangle.determinant;
      for (glm::dvec3& edge : triangle.edges) edge = -edge;
    }
    bound(corners, triangle);
    return triangle;
  }

  void bound(const std::array<glm::dvec3, 3>& corners, RayTriangle& triangle) const {
    constexpr double kSlackPx = 1e-6;  // more than rounding can move a projected corner
    triangle.columns = triangle.rows = {0, size_px_ - 1};
    const double nearest = std::min({corners[0].z, corners[1].z, corners[2].z});
    // A corner beside or behind the camera projects to nowhere: any pixel may be hit.
    if (nearest < 1e-6 * glm::length(corners[0])) return;
    std::array<glm::dvec2, 3> pixels{};
    const double half = 0.5 * size_px_;
    for (std::size_t i = 0; i < 3; ++i) {
      const double scale = half / (corners[i].z * camera_.tan_half_view);
      pixels[i] = {half + corners[i].x * scale - 0.5, half - corners[i].y * scale - 0.5};
    }
    const glm::dvec2 low = glm::min(glm::min(pixels[0], pixels[1]), pixels[2]), high = glm::max(glm::max(pixels[0], pixels[1]), pixels[2]);
    triangle.doubled_area_px = doubled_area(pixels);
    const auto range = [&](double from, double to) {
      const double last = size_px_ - 1;
      return PixelRange{static_cast<std::int32_t>(std::ceil(std::clamp(from - kSlackPx, 0.0, last + 1))),
                        static_cast<std::int32_t>(std::floor(std::clamp(to + kSlackPx, -1.0, last)))};
    };
    triangle.columns = range(low.x, high.x);
    triangle.rows = range(low.y, high.y);
  }

  static double doubled_area(const std::array<glm::dvec2, 3>& corners) {
    const glm::dvec2 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
    return std::abs(ab.x * ac.y - ab.y * ac.x);
  }

  /// The level at which a texel is nearest to a pixel in size. One a triangle: over a leaf it does not change much.
  [[nodiscard]] std::uint32_t mip_level(const std::uint32_t* indices, const SurfaceLook& look, const RayTriangle& triangle) const {
    if (look.mips.empty() || triangle.doubled_area_px == 0.0) return 0;
    const glm::dvec2 size(look.width, look.height);
    const double area_texels = doubled_area(
        {glm::dvec2(mesh_.uvs[indices[0]]) * size, glm::dvec2(mesh_.uvs[indices[1]]) * size, glm::dvec2(mesh_.uvs[indices[2]]) * size});
    const double level = 0.5 * std::log2(std::max(1.0, area_texels / triangle.doubled_area_px));
    return static_cast<std::uint32_t>(std::min(std::round(level), static_cast<double>(look.mips.size() - 1)));
  }

  [[nodiscard]] glm::dvec3 seen_normal(const std::uint32_t* indices) const {
    const glm::dvec3 a(mesh_.positions[indices[0]]), b(mesh_.positions[indices[1]]), c(mesh_.positions[indices[2]]);
    const glm::dvec3 across = glm::cross(b - a, c - a);
    const double length = glm::length(across);
    if (length == 0.0) return glm::dvec3(0.0);
    const double side = glm::dot(across, camera_.position - a) < 0.0 ? -1.0 : 1.0;
    return across * (side / length);
  }

  void draw_pixel(const RayTriangle& triangle, const std::uint32_t* indices, const TrianglePaint& paint, std::int32_t x, std::int32_t y) {
    const SurfaceLook& look = paint.look;
    const glm::dvec3 ray(ray_x(x), ray_y(y), 1.0);
    const double a = glm::dot(ray, triangle.edges[0]), b = glm::dot(ray, triangle.edges[1]), c = glm::dot(ray, triangle.edges[2]);
    const double sum = a + b + c;
    if (a < 0.0 || b < 0.0 || c < 0.0 || !(sum > 0.0)) return;
    const double depth = triangle.determinant / sum;
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size_px_) + static_cast<std::size_t>(x);
    if (!(depth < depths_[pixel])) return;
    float value = paint.mean_value;
    if (!look.holes.empty() || !look.mips.empty()) {
      const glm::dvec2 uv =
          (a * glm::dvec2(mesh_.uvs[indices[0]]) + b * glm::dvec2(mesh_.uvs[indices[1]]) + c * glm::dvec2(mesh_.uvs[indices[2]])) / sum;
      const Texel texel = nearest_texel(look, uv);
      if (!look.holes.empty() && look.holes[std::size_t{texel.y} * look.width + texel.x] != 0) return;
      if (!look.mips.empty()) value = lambert_luminance(albedo_at(look, texel, paint.mip_level), paint.normal);
    }
    depths_[pixel] = depth;
    image_.luminance[pixel] = value;
    image_.coverage[pixel] = 1;
  }

  const Mesh& mesh_;
  const std::vector<SurfaceLook>& looks_;
  const EvaluationCamera& camera_;
  std::int32_t size_px_;
  EvaluationImage image_;
  std::vector<double> depths_;
};

}  // namespace

Sphere evaluation_sphere(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  glm::vec3 low = mesh.positions.front(), high = low;
  for (const glm::vec3& position : mesh.positions) {
    low = glm::min(low, position);
    high = glm::max(high, position);
  }
  Sphere sphere{0.5f * (low + high), 0.0f};
  for (const glm::vec3& position : mesh.positions) sphere.radius = std::max(sphere.radius, glm::distance(sphere.center, position));
  return sphere;
}

std::vector<glm::dvec3> evaluation_directions(std::uint32_t count) {
  SeededRandom random(kDirectionSeed);
  std::vector<glm::dvec3> directions;
  for (std::uint32_t i = 0; i < count; ++i) {
    // Archimedes: heights on a sphere are uniform.
    const double height = 2.0 * random.uniform() - 1.0, angle = 2.0 * std::numbers::pi * random.uniform();
    const double ring = std::sqrt(1.0 - height * height);
    directions.emplace_back(ring * std::cos(angle), height, ring * std::sin(angle));
  }
  return directions;
}

EvaluationCamera evaluation_camera(const glm::dvec3& direction, const Sphere& sphere) {
  EvaluationCamera camera;
  camera.position = glm::dvec3(sphere.center) + direction * (kEvaluationDistanceRadii * sphere.radius);
  camera.forward = -direction;
  const glm::dvec3 pole = std::abs(direction.y) > 0.9999 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  camera.right = glm::normalize(glm::cross(camera.forward, pole));
  camera.up = glm::cross(camera.right, camera.forward);
  // The cone that touches the sphere: sin of its half angle is radius / distance.
  camera.tan_half_view = 1.0 / std::sqrt(kEvaluationDistanceRadii * kEvaluationDistanceRadii - 1.0);
  return camera;
}

Result<std::vector<SurfaceLook>> surface_looks(const std::vector<Material>& materials, const std::vector<Image>& images,
                                               SurfaceColour colour) {
  std::vector<SurfaceLook> looks;
  for (const Material& material : materials) {
    COPPICE_TRY(look, look_of(material, images, colour));
    looks.push_back(std::move(look));
  }
  return looks;
}

glm::dvec3 evaluation_sun() {
  return glm::normalize(glm::dvec3(0.5, 1.0, 0.3));
}

float lambert_luminance(double albedo, const glm::dvec3& normal) {
  const double light = kAmbient + (1.0 - kAmbient) * std::max(0.0, glm::dot(normal, evaluation_sun()));
  return kEvaluationWhite * static_cast<float>(srgb_from_linear(std::clamp(albedo * light, 0.0, 1.0)));
}

EvaluationImage render_evaluation(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px) {
  const std::size_t triangle_count = mesh.triangle_materials.size();
  COPPICE_ASSERT(mesh.indices.size() == 3 * triangle_count && mesh.uvs.size() == mesh.positions.size());
  for (const std::uint32_t index : mesh.indices) COPPICE_ASSERT(index < mesh.positions.size());
  for (const std::uint32_t material : mesh.triangle_materials) COPPICE_ASSERT(material < looks.size());
  Painter painter(mesh, looks, camera, size_px);
  for (std::size_t triangle = 0; triangle < triangle_count; ++triangle) painter.draw(triangle);
  return painter.take();
}

}  // namespace coppice::bake
