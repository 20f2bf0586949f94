// A ray caster that walks triangles. With the camera at the origin, the ray of a pixel is d = (x, y, 1). It hits the triangle a, b, c if d
// . (b x c), d . (c x a) and d . (a x b) have the sign of a . (b x c). These three are also the corners' weights at the hit, perspective
// included, and depth is a . (b x c) over their sum. Nothing is divided by a corner's depth, so triangles may reach behind the camera. An
// edge shared by two triangles gives exactly opposite numbers in them, so no pixel falls between.

#include "evaluation_render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "check.h"
#include "leaf_shade.h"
#include "seeded_random.h"

namespace coppice::bake {
namespace {

constexpr std::uint64_t kDirectionSeed = 20070805;

double srgb_from_linear(double value) {
  return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

/// An albedo as a display would show it, 0..1.
double tone_of(double albedo) {
  return srgb_from_linear(std::clamp(albedo, 0.0, 1.0));
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

constexpr std::uint32_t kRollSteps = 8;

void normalise(std::vector<UnlitImage::Facet>& facets, double sum) {
  for (UnlitImage::Facet& facet : facets) facet.share /= sum;
}

/// A needle as a ribbon whose face turns to a point. There is none if the needle points at it, or has no length or width.
struct NeedleRibbon {
  Mesh mesh;
  /// Normals of flat leaves, rolled about the needle's axis in eight even steps and weighted by the area that each shows.
  std::vector<UnlitImage::Facet> facets;
};

NeedleRibbon ribbon_towards(const Needle& needle, const glm::dvec3& camera) {
  NeedleRibbon ribbon;
  const glm::dvec3 from(needle.from), to(needle.to), middle = 0.5 * (from + to);
  const glm::dvec3 sideways = glm::cross(to - from, camera - middle);
  const double length = glm::length(sideways);
  if (!(length > 0.0) || !(needle.width_m > 0.0f)) return ribbon;
  const glm::dvec3 across = sideways / length, front = glm::normalize(glm::cross(across, to - from));
  const glm::vec3 half(across * (0.5 * double{needle.width_m}));
  ribbon.mesh.positions = {needle.from - half, needle.to - half, needle.to + half, needle.from + half};
  ribbon.mesh.uvs.assign(4, glm::vec2(0.0f));
  ribbon.mesh.indices = {0, 1, 2, 0, 2, 3};
  ribbon.mesh.triangle_materials = {needle.material, needle.material};
  const glm::vec3 to_viewer(glm::normalize(camera - middle));
  double sum = 0.0;
  for (std::uint32_t step = 0; step < kRollSteps; ++step) {
    const double roll = std::numbers::pi * ((step + 0.5) / kRollSteps - 0.5);
    ribbon.facets.push_back({flat_normals(std::cos(roll) * front + std::sin(roll) * across), to_viewer, std::cos(roll)});
    sum += std::cos(roll);
  }
  normalise(ribbon.facets, sum);
  return ribbon;
}

/// The leaves of a voxel as seen from a far point.
struct VoxelFacets {
  double area_m2 = 0.0;  ///< area across the line of sight
  std::vector<UnlitImage::Facet> facets;
};

VoxelFacets facets_towards(const Voxel& voxel, const glm::dvec3& camera) {
  VoxelFacets seen;
  const glm::dvec3 towards = glm::normalize(camera - glm::dvec3(voxel.center));
  for (std::size_t i = 0; i < kVoxelNormalCount; ++i) {
    const glm::dvec3& normal = voxel_normals()[i];
    const double area_m2 = double{voxel.area_m2[i]} * std::abs(glm::dot(normal, towards));
    if (!(area_m2 > 0.0)) continue;
    seen.area_m2 += area_m2;
    seen.facets.push_back({flat_normals(normal), glm::vec3(towards), area_m2});
  }
  if (seen.area_m2 > 0.0) normalise(seen.facets, seen.area_m2);
  return seen;
}

/// The part of a ray inside a box, in lengths of `ray`; far <= near: none.
struct BoxHit {
  double near = 0.0, far = 0.0;
};

BoxHit hit_box(const glm::dvec3& from, const glm::dvec3& ray, const glm::dvec3& center, double half_m) {
  BoxHit hit{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  for (int axis = 0; axis < 3; ++axis) {
    const double to_middle = center[axis] - from[axis];
    if (ray[axis] == 0.0) {
      if (std::abs(to_middle) >= half_m) return {0.0, 0.0};
      continue;
    }
    const double a = (to_middle - half_m) / ray[axis], b = (to_middle + half_m) / ray[axis];
    hit.near = std::max(hit.near, std::min(a, b));
    hit.far = std::min(hit.far, std::max(a, b));
  }
  return hit;
}

/// Pixels [first, last] of a row or column; empty when last < first.
struct PixelRange {
  std::int32_t first = 0, last = -1;
};

struct PixelBox {
  PixelRange columns, rows;
};

/// A triangle as the rays see it, in camera space: x right, y up, z forward.
struct RayTriangle {
  const std::uint32_t* indices = nullptr;  ///< its corners in the mesh
  std::array<glm::dvec3, 3> edges{};       ///< b x c, c x a, a x b, of the sign that makes hits positive
  double determinant = 0.0;                ///< a . (b x c), positive; 0: seen edge-on or without area
  PixelBox box;
  double doubled_area_px = 0.0;  ///< in the image; 0 if a corner is not in front of the camera
};

/// How a triangle is painted.
struct TrianglePaint {
  const SurfaceLook& look;
  float opacity = 1.0f;
  std::uint32_t leaf = 0;
  std::uint32_t surface = 0;
  std::uint32_t mip_level = 0;
};

class Painter {
 public:
  Painter(const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera, std::uint32_t size_px, const EvaluationFrame& frame)
      : looks_(looks), camera_(camera), size_px_(static_cast<std::int32_t>(size_px)), jitter_px_(frame.jitter_px), frame_(frame.index) {
    const std::size_t pixel_count = std::size_t{size_px} * size_px;
    image_.size_px = size_px;
    image_.pixel_surfaces.assign(pixel_count, kNone);
    const bool textured = std::ranges::any_of(looks, [](const SurfaceLook& look) { return !look.mips.empty(); });
    if (textured) image_.pixel_albedos.assign(pixel_count, 0.0f);
    depths_.assign(pixel_count, std::numeric_limits<double>::infinity());
  }

  void draw_mesh(const Level& level) {
    mesh_ = &level.mesh;
    for (std::size_t triangle = 0; triangle < mesh_->triangle_materials.size(); ++triangle)
      draw_triangle(triangle, level.normals.empty() ? flat_normals(face_normal(*mesh_, triangle)) : level.normals[triangle]);
  }

  void draw_needle(const Needle& needle, std::uint32_t leaf) {
    const NeedleRibbon ribbon = ribbon_towards(needle, camera_.position);
    if (ribbon.mesh.indices.empty() || looks_[needle.material].all_holes) return;
    mesh_ = &ribbon.mesh;
    const TrianglePaint paint{plain_look(needle.material), 1.0f, leaf, add_surface(needle.material, ribbon.facets), 0};
    for (std::size_t triangle = 0; triangle < ribbon.mesh.triangle_materials.size(); ++triangle) walk(prepare(triangle), paint);
  }

  void draw_voxel(const Voxel& voxel, std::uint32_t leaf) {
    const VoxelFacets seen = facets_towards(voxel, camera_.position);
    if (!(seen.area_m2 > 0.0) || looks_[voxel.material].all_holes) return;
    const std::uint32_t surface = add_surface(voxel.material, seen.facets);
    const double side_m = 2.0 * double{voxel.half_m}, per_metre = seen.area_m2 / (side_m * side_m * side_m);
    const PixelBox box = voxel_pixels(voxel);
    for (std::int32_t y = box.rows.first; y <= box.rows.last; ++y)
      for (std::int32_t x = box.columns.first; x <= box.columns.last; ++x) {
        const glm::dvec3 ray = ray_x(x) * camera_.right + ray_y(y) * camera_.up + camera_.forward;
        const BoxHit hit = hit_box(camera_.position, ray, voxel.center, voxel.half_m);
        if (!(hit.far > hit.near) || hit.near < 0.0) continue;
        const double depth = 0.5 * (hit.near + hit.far), opacity = 1.0 - std::exp(-per_metre * (hit.far - hit.near) * glm::length(ray));
        const std::size_t pixel = pixel_at(x, y);
        if (depth < depths_[pixel] && covers(static_cast<float>(opacity), leaf, pixel)) show(pixel, depth, surface);
      }
  }

  UnlitImage take() { return std::move(image_); }

 private:
  [[nodiscard]] double ray_x(std::int32_t x) const { return camera_.tan_half_view * ((2.0 * (x + jitter_px_.x) + 1.0) / size_px_ - 1.0); }
  [[nodiscard]] double ray_y(std::int32_t y) const { return camera_.tan_half_view * (1.0 - (2.0 * (y + jitter_px_.y) + 1.0) / size_px_); }
  [[nodiscard]] std::size_t pixel_at(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size_px_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] bool covers(float opacity, std::uint32_t leaf, std::size_t pixel) const {
    return opacity >= 1.0f || covers_sample(opacity, leaf, static_cast<std::uint32_t>(pixel), frame_);
  }

  void show(std::size_t pixel, double depth, std::uint32_t surface) {
    depths_[pixel] = depth;
    image_.pixel_surfaces[pixel] = surface;
  }

  /// A look without holes or texture: a shape that stands for many leaves shows their mean.
  const SurfaceLook& plain_look(std::uint32_t material) {
    plain_.albedo = looks_[material].albedo;
    return plain_;
  }

  std::uint32_t add_surface(std::uint32_t material, std::span<const UnlitImage::Facet> facets) {
    const auto first = static_cast<std::uint32_t>(image_.facets.size());
    image_.facets.insert(image_.facets.end(), facets.begin(), facets.end());
    image_.surfaces.push_back({looks_[material].albedo, false, first, static_cast<std::uint32_t>(facets.size())});
    return static_cast<std::uint32_t>(image_.surfaces.size() - 1);
  }

  void draw_triangle(std::size_t triangle, const ShadingNormals& normals) {
    const std::uint32_t material = mesh_->triangle_materials[triangle];
    const SurfaceLook& look = looks_[material];
    const RayTriangle ray_triangle = prepare(triangle);
    if (ray_triangle.determinant == 0.0 || look.all_holes) return;
    const UnlitImage::Facet facet{normals, to_viewer(triangle), 1.0};
    const std::uint32_t surface = add_surface(material, {&facet, 1});
    image_.surfaces.back().is_textured = !look.mips.empty();
    walk(ray_triangle, {look, opacity(triangle), static_cast<std::uint32_t>(triangle / 2), surface, mip_level(look, ray_triangle)});
  }

  void walk(const RayTriangle& triangle, const TrianglePaint& paint) {
    for (std::int32_t y = triangle.box.rows.first; y <= triangle.box.rows.last; ++y)
      for (std::int32_t x = triangle.box.columns.first; x <= triangle.box.columns.last; ++x) draw_pixel(triangle, paint, x, y);
  }

  [[nodiscard]] RayTriangle prepare(std::size_t index) const {
    RayTriangle triangle;
    triangle.indices = mesh_->indices.data() + 3 * index;
    std::array<glm::dvec3, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) corners[i] = in_camera_space(glm::dvec3(mesh_->positions[triangle.indices[i]]));
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
    triangle.box = whole_image();
    const double nearest = std::min({corners[0].z, corners[1].z, corners[2].z});
    // A corner beside or behind the camera has no projection, so any pixel may be hit.
    if (nearest < 1e-6 * glm::length(corners[0])) return;
    const std::array pixels{pixel_of(corners[0]), pixel_of(corners[1]), pixel_of(corners[2])};
    triangle.doubled_area_px = doubled_area(pixels);
    triangle.box = pixel_box(pixels);
  }

  /// A point in camera space: x right, y up, z forward.
  [[nodiscard]] glm::dvec3 in_camera_space(const glm::dvec3& point) const {
    const glm::dvec3 offset = point - camera_.position;
    return {glm::dot(offset, camera_.right), glm::dot(offset, camera_.up), glm::dot(offset, camera_.forward)};
  }

  /// Where a point in front of the camera, in camera space, is in the image.
  [[nodiscard]] glm::dvec2 pixel_of(const glm::dvec3& point) const {
    const double half = 0.5 * size_px_, scale = half / (point.z * camera_.tan_half_view);
    return glm::dvec2(half + point.x * scale - 0.5, half - point.y * scale - 0.5) - jitter_px_;
  }

  [[nodiscard]] PixelBox whole_image() const { return {{0, size_px_ - 1}, {0, size_px_ - 1}}; }

  [[nodiscard]] PixelBox pixel_box(std::span<const glm::dvec2> pixels) const {
    glm::dvec2 low = pixels[0], high = low;
    for (const glm::dvec2& pixel : pixels) {
      low = glm::min(low, pixel);
      high = glm::max(high, pixel);
    }
    return {pixel_range(low.x, high.x), pixel_range(low.y, high.y)};
  }

  [[nodiscard]] PixelRange pixel_range(double from, double to) const {
    constexpr double kSlackPx = 1e-6;  // more than rounding can move a projected corner
    const double last = size_px_ - 1;
    return {static_cast<std::int32_t>(std::ceil(std::clamp(from - kSlackPx, 0.0, last + 1))),
            static_cast<std::int32_t>(std::floor(std::clamp(to + kSlackPx, -1.0, last)))};
  }

  static double doubled_area(const std::array<glm::dvec2, 3>& corners) {
    const glm::dvec2 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
    return std::abs(ab.x * ac.y - ab.y * ac.x);
  }

  [[nodiscard]] glm::dvec2 uv_of(const RayTriangle& triangle, std::size_t corner) const { return {mesh_->uvs[triangle.indices[corner]]}; }

  /// The level whose texels are nearest to a pixel in size. One level per triangle suffices: over a leaf the size changes little.
  [[nodiscard]] std::uint32_t mip_level(const SurfaceLook& look, const RayTriangle& triangle) const {
    if (look.mips.empty() || triangle.doubled_area_px == 0.0) return 0;
    const glm::dvec2 size(look.width, look.height);
    const double area_texels = doubled_area({uv_of(triangle, 0) * size, uv_of(triangle, 1) * size, uv_of(triangle, 2) * size});
    const double level = 0.5 * std::log2(std::max(1.0, area_texels / triangle.doubled_area_px));
    return static_cast<std::uint32_t>(std::min(std::round(level), static_cast<double>(look.mips.size() - 1)));
  }

  [[nodiscard]] float opacity(std::size_t triangle) const {
    if (mesh_->vertex_opacities.empty()) return 1.0f;
    return static_cast<float>(mesh_->vertex_opacities[mesh_->indices[3 * triangle]]) / float{kOpaque};
  }

  /// From the triangle's middle.
  [[nodiscard]] glm::vec3 to_viewer(std::size_t triangle) const {
    const auto [a, b, c] = at_corners(mesh_->positions, mesh_->indices, 3 * triangle);
    const glm::dvec3 middle = (glm::dvec3(a) + glm::dvec3(b) + glm::dvec3(c)) / 3.0;
    return glm::vec3(glm::normalize(camera_.position - middle));
  }

  /// Pixels that the cube may cover; all if a corner is not in front of the camera.
  [[nodiscard]] PixelBox voxel_pixels(const Voxel& voxel) const {
    std::array<glm::dvec2, 8> pixels{};
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const glm::dvec3 sign((corner & 1) != 0 ? 1.0 : -1.0, (corner & 2) != 0 ? 1.0 : -1.0, (corner & 4) != 0 ? 1.0 : -1.0);
      const glm::dvec3 point = in_camera_space(glm::dvec3(voxel.center) + double{voxel.half_m} * sign);
      if (point.z < 1e-6 * glm::length(point)) return whole_image();
      pixels[corner] = pixel_of(point);
    }
    return pixel_box(pixels);
  }

  void draw_pixel(const RayTriangle& triangle, const TrianglePaint& paint, std::int32_t x, std::int32_t y) {
    const SurfaceLook& look = paint.look;
    const glm::dvec3 ray(ray_x(x), ray_y(y), 1.0);
    const double a = glm::dot(ray, triangle.edges[0]), b = glm::dot(ray, triangle.edges[1]), c = glm::dot(ray, triangle.edges[2]);
    const double sum = a + b + c;
    if (a < 0.0 || b < 0.0 || c < 0.0 || !(sum > 0.0)) return;
    const double depth = triangle.determinant / sum;
    const std::size_t pixel = pixel_at(x, y);
    if (!(depth < depths_[pixel])) return;
    Texel texel;
    if (!look.holes.empty() || !look.mips.empty())
      texel = nearest_texel(look, (a * uv_of(triangle, 0) + b * uv_of(triangle, 1) + c * uv_of(triangle, 2)) / sum);
    if (!look.holes.empty() && look.holes[std::size_t{texel.y} * look.width + texel.x] != 0) return;
    if (!covers(paint.opacity, paint.leaf, pixel)) return;
    if (!look.mips.empty()) image_.pixel_albedos[pixel] = static_cast<float>(albedo_at(look, texel, paint.mip_level));
    show(pixel, depth, paint.surface);
  }

  const std::vector<SurfaceLook>& looks_;
  const EvaluationCamera& camera_;
  std::int32_t size_px_;
  glm::dvec2 jitter_px_;
  std::uint32_t frame_;
  const Mesh* mesh_ = nullptr;
  SurfaceLook plain_;
  UnlitImage image_;
  std::vector<double> depths_;
};

/// The digits of `index` in a base, mirrored at the point.
double radical_inverse(std::uint32_t index, std::uint32_t base) {
  double value = 0.0, digit = 1.0 / base;
  while (index > 0) {
    value += digit * (index % base);
    index /= base;
    digit /= base;
  }
  return value;
}

void check_level(const Level& level, const std::vector<SurfaceLook>& looks) {
  const Mesh& mesh = level.mesh;
  const std::size_t triangle_count = mesh.triangle_materials.size();
  COPPICE_ASSERT(mesh.indices.size() == 3 * triangle_count && mesh.uvs.size() == mesh.positions.size());
  COPPICE_ASSERT(level.normals.empty() || level.normals.size() == triangle_count);
  COPPICE_ASSERT(mesh.vertex_opacities.empty() || mesh.vertex_opacities.size() == mesh.positions.size());
  for (const std::uint32_t index : mesh.indices) COPPICE_ASSERT(index < mesh.positions.size());
  for (const std::uint32_t material : mesh.triangle_materials) COPPICE_ASSERT(material < looks.size());
  for (const Needle& needle : level.needles) COPPICE_ASSERT(needle.material < looks.size());
  for (const Voxel& voxel : level.voxels) COPPICE_ASSERT(voxel.material < looks.size());
}

/// Calls put(pixel, luminance_of(albedo, cosine)) for each pixel with foliage. luminance_of is called once for surfaces of one colour.
template <class LuminanceOf, class Put>
void light_leaves(const UnlitImage& unlit, const glm::dvec3& sun, float translucency, const LuminanceOf& luminance_of, const Put& put) {
  struct LitSurface {
    bool is_known = false;
    float cosine = 0.0f, luminance = 0.0f;
  };
  std::vector<LitSurface> lit(unlit.surfaces.size());
  for (std::size_t pixel = 0; pixel < unlit.pixel_surfaces.size(); ++pixel) {
    const std::uint32_t index = unlit.pixel_surfaces[pixel];
    if (index == kNone) continue;
    const UnlitImage::Surface& surface = unlit.surfaces[index];
    if (!lit[index].is_known) {
      double cosine = 0.0;
      for (std::uint32_t i = 0; i < surface.facet_count; ++i) {
        const UnlitImage::Facet& facet = unlit.facets[surface.first_facet + i];
        cosine += facet.share * double{leaf_cosine(facet.normals, glm::vec3(sun), facet.to_viewer, translucency)};
      }
      lit[index] = {true, static_cast<float>(cosine), luminance_of(surface.albedo, static_cast<float>(cosine))};
    }
    put(pixel, surface.is_textured ? luminance_of(double{unlit.pixel_albedos[pixel]}, lit[index].cosine) : lit[index].luminance);
  }
}

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
    // Heights on a sphere are uniform (Archimedes).
    const double height = 2.0 * random.uniform() - 1.0, angle = 2.0 * std::numbers::pi * random.uniform();
    const double ring = std::sqrt(1.0 - height * height);
    directions.emplace_back(ring * std::cos(angle), height, ring * std::sin(angle));
  }
  return directions;
}

EvaluationCamera evaluation_camera(const glm::dvec3& direction, const Sphere& sphere, double distance_radii) {
  EvaluationCamera camera;
  camera.position = glm::dvec3(sphere.center) + direction * (distance_radii * sphere.radius);
  camera.forward = -direction;
  const glm::dvec3 pole = std::abs(direction.y) > 0.9999 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  camera.right = glm::normalize(glm::cross(camera.forward, pole));
  camera.up = glm::cross(camera.right, camera.forward);
  // The cone that touches the sphere: sin of its half angle is radius / distance.
  camera.tan_half_view = 1.0 / std::sqrt(distance_radii * distance_radii - 1.0);
  return camera;
}

glm::dvec3 evaluation_sun() {
  return glm::normalize(glm::dvec3(0.5, 1.0, 0.3));
}

std::vector<glm::dvec3> evaluation_suns() {
  const double golden_angle = 2.0 * std::numbers::pi * (1.0 - 1.0 / std::numbers::phi);
  std::vector<glm::dvec3> suns;
  for (std::uint32_t i = 0; i < kEvaluationSunCount; ++i) {
    const double height = (i + 0.5) / kEvaluationSunCount, ring = std::sqrt(1.0 - height * height);
    suns.emplace_back(ring * std::cos(golden_angle * i), height, ring * std::sin(golden_angle * i));
  }
  return suns;
}

std::array<glm::dvec3, 2> evaluation_light_suns() {
  return {glm::normalize(glm::dvec3(0.4, 0.85, 0.3)), glm::normalize(glm::dvec3(-0.85, 0.3, 0.45))};
}

std::vector<EvaluationFrame> temporal_frames() {
  std::vector<EvaluationFrame> frames;
  for (std::uint32_t i = 0; i < kTemporalFrameCount; ++i)
    frames.push_back({i, {radical_inverse(i + 1, 2) - 0.5, radical_inverse(i + 1, 3) - 0.5}});
  return frames;
}

bool covers_sample(float opacity, std::uint32_t leaf, std::uint32_t pixel, std::uint32_t frame) {
  const double start = SeededRandom(std::uint64_t{leaf} << 32 | pixel).uniform();
  const double moved = start + frame * (std::numbers::phi - 1.0);
  return moved - std::floor(moved) < double{opacity};
}

UnlitImage render_unlit(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera, std::uint32_t size_px,
                        const EvaluationFrame& frame) {
  check_level(level, looks);
  Painter painter(looks, camera, size_px, frame);
  painter.draw_mesh(level);
  auto leaf = static_cast<std::uint32_t>(level.mesh.triangle_materials.size());
  for (const Needle& needle : level.needles) painter.draw_needle(needle, leaf++);
  for (const Voxel& voxel : level.voxels) painter.draw_voxel(voxel, leaf++);
  return painter.take();
}

EvaluationImage lit_image(const UnlitImage& unlit, const glm::dvec3& sun) {
  const std::size_t pixel_count = unlit.pixel_surfaces.size();
  EvaluationImage image{unlit.size_px, std::vector<float>(pixel_count, kEvaluationWhite), std::vector<std::uint8_t>(pixel_count, 0)};
  const auto luminance_of = [](double albedo, float cosine) { return lambert_luminance(static_cast<float>(albedo), cosine); };
  light_leaves(unlit, sun, kTranslucency, luminance_of, [&](std::size_t pixel, float luminance) {
    image.luminance[pixel] = luminance;
    image.coverage[pixel] = 1;
  });
  return image;
}

std::vector<float> leaf_luminances(const UnlitImage& unlit, const glm::dvec3& sun, float translucency, double mean_tone, float ground) {
  std::vector<float> luminances(unlit.pixel_surfaces.size(), ground);
  const auto luminance_of = [&](double albedo, float cosine) {
    const double shown = (0.2 + 0.6 * double{cosine}) * tone_of(albedo) / mean_tone;
    return kEvaluationWhite * static_cast<float>(std::min(shown, 1.0));
  };
  light_leaves(unlit, sun, translucency, luminance_of, [&](std::size_t pixel, float luminance) { luminances[pixel] = luminance; });
  return luminances;
}

ToneSum tone_sum(const UnlitImage& unlit) {
  ToneSum tones;
  for (std::size_t pixel = 0; pixel < unlit.pixel_surfaces.size(); ++pixel) {
    if (unlit.pixel_surfaces[pixel] == kNone) continue;
    const UnlitImage::Surface& surface = unlit.surfaces[unlit.pixel_surfaces[pixel]];
    tones.sum += tone_of(surface.is_textured ? double{unlit.pixel_albedos[pixel]} : surface.albedo);
    ++tones.pixel_count;
  }
  return tones;
}

EvaluationImage render_evaluation(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px) {
  return lit_image(render_unlit(level, looks, camera, size_px), evaluation_sun());
}

EvaluationImage render_evaluation(const Mesh& mesh, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                  std::uint32_t size_px) {
  return render_evaluation(level_of(mesh), looks, camera, size_px);
}

std::vector<float> render_temporal_mean(const Level& level, const std::vector<SurfaceLook>& looks, const EvaluationCamera& camera,
                                        std::uint32_t size_px) {
  std::vector<float> mean(std::size_t{size_px} * size_px, 0.0f);
  for (const EvaluationFrame& frame : temporal_frames()) {
    const EvaluationImage image = lit_image(render_unlit(level, looks, camera, size_px, frame), evaluation_sun());
    for (std::size_t pixel = 0; pixel < mean.size(); ++pixel) mean[pixel] += image.luminance[pixel] / kTemporalFrameCount;
  }
  return mean;
}

}  // namespace coppice::bake
