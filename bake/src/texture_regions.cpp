#include "texture_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "texture_mips.h"

namespace coppice::bake {
namespace {

// A region that is more of the image than this is not worth an image of its own.
constexpr double kMostKept = 0.75;
// Texels kept around what is shown, for the filter.
constexpr double kMargin = 1.0;

/// Texels [first, last) of an image.
struct Region {
  glm::uvec2 first{0}, last{0};
  [[nodiscard]] glm::uvec2 size() const { return last - first; }
};
bool operator<(const Region& a, const Region& b) {
  const auto key = [](const Region& r) { return std::array{r.first.x, r.first.y, r.last.x, r.last.y}; };
  return key(a) < key(b);
}

/// Bounds of a material's texture coordinates; none where nothing shows it.
struct Bounds {
  glm::dvec2 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
  [[nodiscard]] bool none() const { return !(low.x <= high.x); }
};

using UvTriangle = std::array<glm::vec2, 3>;

template <typename Visit>
void for_each_triangle(const Mesh& mesh, Visit&& visit) {
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const auto uv = [&](std::size_t k) { return mesh.uvs[mesh.indices[3 * t + k]]; };
    visit(mesh.triangle_materials[t], UvTriangle{uv(0), uv(1), uv(2)});
  }
}

std::vector<Bounds> bounds_by_material(const Plant& plant) {
  std::vector<Bounds> bounds(plant.materials.size());
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for_each_triangle(*mesh, [&](std::uint32_t material, const UvTriangle& uvs) {
      for (const glm::vec2& uv : uvs) {
        bounds[material].low = glm::min(bounds[material].low, glm::dvec2(uv));
        bounds[material].high = glm::max(bounds[material].high, glm::dvec2(uv));
      }
    });
  return bounds;
}

/// The period that holds all of the axis's coordinates; none where they are in several.
std::optional<double> period_of(double low, double high) {
  const double period = std::floor(low);
  return std::isfinite(period) && high <= period + 1.0 ? std::optional(period) : std::nullopt;
}

Region region_of(const Bounds& bounds, const Image& image) {
  Region region{glm::uvec2(0), {image.width, image.height}};
  for (int axis = 0; axis < 2; ++axis) {
    const auto period = period_of(bounds.low[axis], bounds.high[axis]);
    if (!period) continue;
    const double side = region.last[axis];
    region.first[axis] = static_cast<std::uint32_t>(std::max(std::floor((bounds.low[axis] - *period) * side - kMargin), 0.0));
    region.last[axis] = static_cast<std::uint32_t>(std::min(std::ceil((bounds.high[axis] - *period) * side + kMargin), side));
  }
  return region;
}

/// The same region of an image of another size, where it falls on that one's texels.
std::optional<Region> rescaled(const Region& region, const Image& from, const Image& to) {
  Region result;
  const glm::uvec2 from_side(from.width, from.height), to_side(to.width, to.height);
  for (int axis = 0; axis < 2; ++axis) {
    const auto scaled = [&](std::uint32_t texel) { return std::uint64_t{texel} * to_side[axis]; };
    if (scaled(region.first[axis]) % from_side[axis] != 0 || scaled(region.last[axis]) % from_side[axis] != 0) return std::nullopt;
    result.first[axis] = static_cast<std::uint32_t>(scaled(region.first[axis]) / from_side[axis]);
    result.last[axis] = static_cast<std::uint32_t>(scaled(region.last[axis]) / from_side[axis]);
  }
  return result;
}

Image cut(const Image& image, const Region& region) {
  Image result{region.size().x, region.size().y, {}, image.is_normal_map};
  result.rgba.reserve(std::size_t{4} * result.width * result.height);
  for (std::uint32_t row = region.first.y; row < region.last.y; ++row) {
    const auto begin = image.rgba.begin() + 4 * (std::ptrdiff_t{row} * image.width + region.first.x);
    result.rgba.insert(result.rgba.end(), begin, begin + 4 * std::ptrdiff_t{result.width});
  }
  return result;
}

/// uv becomes (uv - offset) * scale.
struct UvChange {
  glm::dvec2 offset{0.0}, scale{1.0};
};

UvChange change_for(const Bounds& bounds, const Region& region, const Image& image) {
  UvChange change;
  const glm::dvec2 side(image.width, image.height);
  for (int axis = 0; axis < 2; ++axis) {
    if (region.size()[axis] == static_cast<std::uint32_t>(side[axis])) continue;
    change.offset[axis] = std::floor(bounds.low[axis]) + region.first[axis] / side[axis];
    change.scale[axis] = side[axis] / region.size()[axis];
  }
  return change;
}

/// A vertex that triangles of several materials share is split, so that each has its own coordinates.
void change_uvs(Mesh& mesh, const std::vector<UvChange>& changes) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // of a vertex for a material
  std::vector<std::uint32_t> material_of(mesh.positions.size(), kNone);
  const std::vector<glm::vec2> source = mesh.uvs;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t vertex = mesh.indices[i], material = mesh.triangle_materials[i / 3];
    std::uint32_t& owner = material_of[vertex];
    if (owner == kNone) owner = material;
    if (owner != material) {
      const auto [copy, is_new] = copies.try_emplace({vertex, material}, static_cast<std::uint32_t>(mesh.positions.size()));
      if (is_new) {
        mesh.positions.push_back(glm::vec3(mesh.positions[vertex]));
        mesh.normals.push_back(glm::vec3(mesh.normals[vertex]));
        mesh.uvs.emplace_back();
      }
      mesh.indices[i] = copy->second;
    }
    const UvChange& change = changes[material];
    mesh.uvs[mesh.indices[i]] = glm::vec2((glm::dvec2(source[vertex]) - change.offset) * change.scale);
  }
}

/// Cuts what is worth it: new images, and how the coordinates of each material change.
std::vector<UvChange> cut_images(Plant& plant) {
  const std::vector<Bounds> bounds = bounds_by_material(plant);
  std::vector<UvChange> changes(plant.materials.size());
  std::map<std::pair<std::uint32_t, Region>, std::uint32_t> cut_already;
  const auto cut_once = [&](std::uint32_t image, const Region& region) {
    const auto [found, is_new] = cut_already.try_emplace({image, region}, static_cast<std::uint32_t>(plant.images.size()));
    if (is_new) plant.images.push_back(cut(plant.images[image], region));
    return found->second;
  };
  for (std::size_t m = 0; m < plant.materials.size(); ++m) {
    Material& material = plant.materials[m];
    if (material.image == kNone || bounds[m].none()) continue;
    const Image& image = plant.images[material.image];
    const Region region = region_of(bounds[m], image);
    const double kept = static_cast<double>(region.size().x) * region.size().y;
    if (kept > kMostKept * static_cast<double>(image.width) * image.height) continue;
    std::optional<Region> of_normals = region;
    if (material.normal_map != kNone) of_normals = rescaled(region, image, plant.images[material.normal_map]);
    if (!of_normals) continue;
    changes[m] = change_for(bounds[m], region, image);
    material.image = cut_once(material.image, region);
    if (material.normal_map != kNone) material.normal_map = cut_once(material.normal_map, *of_normals);
  }
  return changes;
}

/// Which texels of an image are shown.
class ShownTexels {
 public:
  explicit ShownTexels(const Image& image) : side_(image.width, image.height), shown_(std::size_t{image.width} * image.height, 0) {}

  void add(const UvTriangle& uvs) {
    std::array<glm::dvec2, 3> points{};
    for (std::size_t k = 0; k < 3; ++k) points[k] = glm::dvec2(uvs[k]) * glm::dvec2(side_);
    const glm::dvec2 low = glm::floor(glm::min(glm::min(points[0], points[1]), points[2]) - kMargin);
    const glm::dvec2 high = glm::ceil(glm::max(glm::max(points[0], points[1]), points[2]) + kMargin);
    const glm::dvec2 extent = high - low;
    if (!(extent.x < 2.0 * side_.x && extent.y < 2.0 * side_.y)) return shown_.assign(shown_.size(), 1);
    const glm::i64vec2 first(low), last(high);
    for (std::int64_t y = first.y; y < last.y; ++y)
      for (std::int64_t x = first.x; x < last.x; ++x)
        if (is_near(glm::dvec2(x, y) + 0.5, points)) shown_[wrapped(y, side_.y) * side_.x + wrapped(x, side_.x)] = 1;
  }
  [[nodiscard]] bool all() const { return std::ranges::count(shown_, 0) == 0; }
  [[nodiscard]] bool at(std::size_t texel) const { return shown_[texel] != 0; }

 private:
  static std::size_t wrapped(std::int64_t texel, std::int64_t side) { return static_cast<std::size_t>((texel % side + side) % side); }
  /// Within a texel of the triangle, or a little more at its corners.
  static bool is_near(const glm::dvec2& point, const std::array<glm::dvec2, 3>& points) {
    const glm::dvec2 ab = points[1] - points[0], ac = points[2] - points[0];
    const double turn = ab.x * ac.y - ab.y * ac.x < 0.0 ? -1.0 : 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec2 edge = points[(k + 1) % 3] - points[k], arm = point - points[k];
      if (turn * (edge.x * arm.y - edge.y * arm.x) < -kMargin * glm::length(edge)) return false;
    }
    return true;
  }

  glm::uvec2 side_;
  std::vector<std::uint8_t> shown_;
};

/// Colours from the texels that are shown, the nearest first: those of the first coarser mip level that has any.
void fill_unshown(Image& image, const ShownTexels& shown) {
  for (std::size_t i = 0; i < image.rgba.size() / 4; ++i) image.rgba[4 * i + 3] = shown.at(i) ? 255 : 0;
  std::vector<std::uint8_t> filled = std::move(mip_levels(image, 0.0f).front().rgba);
  if (filled.size() == image.rgba.size()) image.rgba = std::move(filled);  // else it is larger than any texture: left as it is
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) image.rgba[i + 3] = 255;
}

/// By image, whether colour is all that its materials take from it.
std::vector<bool> opaque_images(const Plant& plant) {
  std::vector<bool> opaque(plant.images.size(), false);
  for (const Material& material : plant.materials)
    if (material.image != kNone) opaque[material.image] = true;
  for (const Material& material : plant.materials) {
    if (material.image != kNone && material.alpha_cutoff > 0.0f) opaque[material.image] = false;
    if (material.normal_map != kNone) opaque[material.normal_map] = false;
  }
  return opaque;
}

void fill_opaque_images(Plant& plant) {
  const std::vector<bool> opaque = opaque_images(plant);
  using Corners = std::array<float, 6>;
  std::vector<std::set<Corners>> triangles(plant.images.size());  // leaves are often the same one many times
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for_each_triangle(*mesh, [&](std::uint32_t material, const UvTriangle& uvs) {
      const std::uint32_t image = plant.materials[material].image;
      if (image != kNone && opaque[image]) triangles[image].insert({uvs[0].x, uvs[0].y, uvs[1].x, uvs[1].y, uvs[2].x, uvs[2].y});
    });
  for (std::size_t i = 0; i < plant.images.size(); ++i) {
    if (triangles[i].empty()) continue;
    ShownTexels shown(plant.images[i]);
    for (const auto& [ax, ay, bx, by, cx, cy] : triangles[i]) shown.add({glm::vec2(ax, ay), glm::vec2(bx, by), glm::vec2(cx, cy)});
    if (!shown.all()) fill_unshown(plant.images[i], shown);
  }
}

}  // namespace

void cut_texture_regions(Plant& plant) {
  const std::vector<UvChange> changes = cut_images(plant);
  change_uvs(plant.foliage, changes);
  change_uvs(plant.wood, changes);
  fill_opaque_images(plant);
}

}  // namespace coppice::bake
