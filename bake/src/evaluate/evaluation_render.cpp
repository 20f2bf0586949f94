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

Result<SurfaceLook> look_of(const Material& material, const std::vector<Image>& images) {
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
  glm::dvec3 sum(0.0);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < texel_count; ++i) {
    const std::uint8_t* rgba = image.rgba.data() + 4 * i;
    const bool hole = masked && material.base_color.a * static_cast<float>(rgba[3]) / 255.0f < material.alpha_cutoff;
    if (masked) look.holes[i] = hole ? 1 : 0;
    if (hole) continue;
    sum += glm::dvec3(linear_from_srgb(rgba[0]), linear_from_srgb(rgba[1]), linear_from_srgb(rgba[2]));
    ++seen;
  }
  if (seen > 0) look.albedo = luminance(factor * sum / static_cast<double>(seen));
  return look;
}

bool is_hole(const SurfaceLook& look, const glm::dvec2& uv) {
  if (look.holes.empty()) return look.all_holes;
  const auto texel = [](double coordinate, std::uint32_t size) {
    const double wrapped = coordinate - std::floor(coordinate);
    return std::min(static_cast<std::uint32_t>(wrapped * size), size - 1);
  };
  return look.holes[std::size_t{texel(uv.y, look.height)} * look.width + texel(uv.x, look.width)] != 0;
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
    const float value = shade(indices, look.albedo);
    for (std::int32_t y = ray_triangle.rows.first; y <= ray_triangle.rows.last; ++y)
      for (std::int32_t x = ray_triangle.columns.first; x <= ray_triangle.columns.last; ++x)
        draw_pixel(ray_triangle, indices, look, value, x, y);
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
    glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-std::numeric_limits<double>::infinity());
    const double half = 0.5 * size_px_;
    for (const glm::dvec3& corner : corners) {
      const double scale = half / (corner.z * camera_.tan_half_view);
      const glm::dvec2 pixel(half + corner.x * scale - 0.5, half - corner.y * scale - 0.5);
      low = glm::min(low, pixel);
      high = glm::max(high, pixel);
    }
    const auto range = [&](double from, double to) {
      const double last = size_px_ - 1;
      return PixelRange{static_cast<std::int32_t>(std::ceil(std::clamp(from - kSlackPx, 0.0, last + 1))),
                        static_cast<std::int32_t>(std::floor(std::clamp(to + kSlackPx, -1.0, last)))};
    };
    triangle.columns = range(low.x, high.x);
    triangle.rows = range(low.y, high.y);
  }

  [[nodiscard]] float shade(const std::uint32_t* indices, double albedo) const {
    const glm::dvec3 a(mesh_.positions[indices[0]]), b(mesh_.positions[indices[1]]), c(mesh_.positions[indices[2]]);
    const glm::dvec3 across = glm::cross(b - a, c - a);
    const double length = glm::length(across);
    if (length == 0.0) return lambert_luminance(albedo, glm::dvec3(0.0));
    const double side = glm::dot(across, camera_.position - a) < 0.0 ? -1.0 : 1.0;
    return lambert_luminance(albedo, across * (side / length));
  }

  void draw_pixel(const RayTriangle& triangle, const std::uint32_t* indices, const SurfaceLook& look, float value, std::int32_t x,
                  std::int32_t y) {
    const glm::dvec3 ray(ray_x(x), ray_y(y), 1.0);
    const double a = glm::dot(ray, triangle.edges[0]), b = glm::dot(ray, triangle.edges[1]), c = glm::dot(ray, triangle.edges[2]);
    const double sum = a + b + c;
    if (a < 0.0 || b < 0.0 || c < 0.0 || !(sum > 0.0)) return;
    const double depth = triangle.determinant / sum;
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size_px_) + static_cast<std::size_t>(x);
    if (!(depth < depths_[pixel])) return;
    if (!look.holes.empty()) {
      const glm::dvec2 uv =
          (a * glm::dvec2(mesh_.uvs[indices[0]]) + b * glm::dvec2(mesh_.uvs[indices[1]]) + c * glm::dvec2(mesh_.uvs[indices[2]])) / sum;
      if (is_hole(look, uv)) return;
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

Result<std::vector<SurfaceLook>> surface_looks(const std::vector<Material>& materials, const std::vector<Image>& images) {
  std::vector<SurfaceLook> looks;
  for (const Material& material : materials) {
    COPPICE_TRY(look, look_of(material, images));
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
