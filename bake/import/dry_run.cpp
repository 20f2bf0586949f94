#include "dry_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bounds.h"
#include "gltf_write.h"
#include "parallel_for.h"
#include "plant_painter.h"
#include "printable.h"
#include "text_number.h"
#include "viewpoints.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMaxClasses = 6;

/// How many of a material's pieces became one part.
struct PartCount {
  std::uint64_t classes = 0, pieces = 0, triangles = 0;
};

PartCount count_part(std::span<const PieceClass> classes, PlantPart part) {
  PartCount count;
  for (const PieceClass& each : classes)
    if (each.part == part) ++count.classes, count.pieces += each.piece_count, count.triangles += each.total_triangles;
  return count;
}

/// "leaves" alone if all pieces became leaves; otherwise how many became what.
std::string becomes(std::span<const PieceClass> classes) {
  const std::array parts{std::pair{PlantPart::leaf, "leaves"}, std::pair{PlantPart::wood, "wood"},
                         std::pair{PlantPart::dropped, "dropped"}};
  std::string text;
  for (const auto& [part, name] : parts) {
    const PartCount count = count_part(classes, part);
    if (count.classes == classes.size()) return name;
    if (count.classes > 0) text += (text.empty() ? "" : ", ") + std::to_string(count.pieces) + " " + name;
  }
  return text;
}

const char* part_name(const PieceClass& each) {
  if (each.is_shell) return "wood (welded shell)";
  return each.part == PlantPart::leaf ? "leaf" : each.part == PlantPart::wood ? "wood" : "dropped";
}

std::string class_line(const PieceClass& each) {
  const std::string shape = each.triangle_count == 0
                                ? "without area"
                                : "x " + std::to_string(each.triangle_count) + " triangles, " + std::to_string(each.point_count) +
                                      " points, " + formatted("%.3g m", each.length_m);
  return formatted("  %9u %-40s %-8s %s\n", each.piece_count, shape.c_str(), part_name(each), printable(each.reason).c_str());
}

/// The printable beginning of a name that fits into `bytes`; cuts no character in two.
std::string printable_front(const std::string& name, std::size_t bytes) {
  std::string front = printable(name);
  if (front.size() <= bytes) return front;
  while (bytes > 0 && (static_cast<unsigned char>(front[bytes]) & 0xc0u) == 0x80u) --bytes;
  return front.substr(0, bytes);
}

/// Lines of one material: its own and those of its largest classes, of leaves and of the rest, each with its number.
std::string material_lines(const std::string& name, std::span<const PieceClass> classes) {
  std::uint64_t triangles = 0, pieces = 0;
  for (const PieceClass& each : classes) triangles += each.total_triangles, pieces += each.piece_count;
  const std::string shown = name.empty() ? "(unnamed)" : printable_front(name, 32);
  std::string text = formatted("%-32s %10llu %9llu %8zu  %s\n", shown.c_str(), static_cast<unsigned long long>(triangles),
                               static_cast<unsigned long long>(pieces), classes.size(), becomes(classes).c_str());
  for (const PieceClass& each : classes.first(std::min(classes.size(), kMaxClasses))) text += class_line(each);
  if (classes.size() > kMaxClasses) {
    const std::span rest = classes.subspan(kMaxClasses);
    text += formatted("            and %zu smaller classes: %s\n", rest.size(), becomes(rest).c_str());
  }
  return text;
}

// The picture is drawn so many times larger, and averaged.
constexpr std::uint32_t kSupersampling = 2;
constexpr glm::dvec3 kWood(0.45, 0.29, 0.16);

/// A green for each number: hue from yellow-green to blue-green, light and dark.
glm::dvec3 leaf_color(std::uint32_t leaf) {
  // Neighbours in the file get hues far apart: steps of the golden ratio never fall into a short cycle.
  const double turn = std::fmod(leaf * 0.6180339887498949, 1.0), shade = std::fmod(leaf * 0.7548776662466927, 1.0);
  const double yellow = std::max(0.0, 1.0 - 2.0 * turn), blue = std::max(0.0, 2.0 * turn - 1.0);
  return (0.65 + 0.35 * shade) * glm::dvec3(0.1 + 0.6 * yellow, 0.85, 0.1 + 0.6 * blue);
}

Sphere bounds(const Plant& plant) {
  glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (const glm::vec3& position : mesh->positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
  Sphere sphere;
  if (low.x > high.x) return sphere;
  sphere.center = 0.5f * (low + high);
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (const glm::vec3& position : mesh->positions) sphere.radius = std::max(sphere.radius, glm::distance(sphere.center, position));
  return sphere;
}

/// Draws one view of the plant into its columns of the picture.
void draw_view(const Plant& plant, const Viewpoint& viewpoint, const Sphere& sphere, std::size_t view, std::size_t view_count,
               std::vector<std::uint8_t>& rgb) {
  PlantPainter painter(plant.materials, plant.images, viewpoint, sphere, kSupersampling * kPreviewSizePx, glm::vec3(1.0f));
  const auto paint = [&painter](const Mesh& mesh, std::size_t t, const glm::dvec3& color) {
    const PaintedTriangle triangle = painted_triangle(mesh, t);
    const glm::vec3 shaded(color * (0.55 + 0.45 * painter.facing(triangle)));
    painter.paint(
        triangle, [](std::size_t) { return false; }, [&shaded](const glm::dvec2&) { return shaded; });
  };
  for (std::size_t t = 0; t < plant.wood.triangle_materials.size(); ++t) paint(plant.wood, t, kWood);
  for (std::uint32_t leaf = 0; leaf < plant.leaves.size(); ++leaf)
    for (std::uint32_t k = 0; k < plant.leaves[leaf].triangle_count; ++k)
      paint(plant.foliage, std::size_t{plant.leaves[leaf].first_triangle} + k, leaf_color(leaf));
  const std::vector<glm::vec3> colors = shrunk_picture(painter.colors(), kSupersampling * kPreviewSizePx, kSupersampling);
  for (std::size_t y = 0; y < kPreviewSizePx; ++y)
    for (std::size_t x = 0; x < kPreviewSizePx; ++x) {
      std::uint8_t* pixel = &rgb[3 * ((y * view_count + view) * kPreviewSizePx + x)];
      for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(std::lround(255.0f * colors[y * kPreviewSizePx + x][c]));
    }
}

}  // namespace

std::string parts_table(const Plant& plant) {
  std::string text = formatted("%-32s %10s %9s %8s  %s\n", "material", "triangles", "pieces", "classes", "becomes");
  const std::span<const PieceClass> all(plant.classes);
  for (std::size_t first = 0, last = 0; first < all.size(); first = last) {
    while (last < all.size() && all[last].material == all[first].material) ++last;
    text += material_lines(plant.materials[all[first].material].name, all.subspan(first, last - first));
  }
  text += formatted("%zu leaves of %zu triangles; wood of %zu triangles\n", plant.leaves.size(), plant.foliage.triangle_materials.size(),
                    plant.wood.triangle_materials.size());
  return text + size_text(plant_size_m(plant)) + "\n";
}

Result<std::vector<std::uint8_t>> render_leaf_preview_png(const Plant& plant) {
  const std::array views{viewpoint_towards({0.0f, 0.0f, 1.0f}), viewpoint_towards({1.0f, 0.0f, 0.0f}),
                         viewpoint_towards(glm::normalize(glm::vec3(0.4f, 1.0f, 0.6f)))};
  const Sphere sphere = bounds(plant);
  std::vector<std::uint8_t> rgb(std::size_t{3} * views.size() * kPreviewSizePx * kPreviewSizePx);
  parallel_for(views.size(), [&](std::size_t i) { draw_view(plant, views[i], sphere, i, views.size(), rgb); });
  return encode_png(3 * kPreviewSizePx, kPreviewSizePx, 3, rgb);
}

}  // namespace coppice::bake
