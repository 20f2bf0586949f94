#include "texture_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include <glm/gtc/type_precision.hpp>

#include "texture_shown.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

// Maximum share of the image for a region that is worth an image of its own.
constexpr double kMaxKept = 0.75;
// Texels round the shown ones that the filter needs.
constexpr double kMargin = 1.0;

/// Materials whose texels differ by no more than this, 0..1 in sRGB, may share them.
constexpr double kAlikeColors = 12.0 / 255.0;
/// Maximum number of differently coloured copies of a region. A material with yet another colour shares the first.
constexpr std::size_t kMaxCopies = 8;

/// What a material shows of its image.
struct Shown {
  UvBounds bounds;
  ColorSum color;
};

std::vector<Shown> shown_by_material(const Plant& plant) {
  std::vector<Shown> shown(plant.materials.size());
  for (const Mesh* mesh : {&plant.foliage, &plant.wood})
    for (std::size_t t = 0; t < mesh->triangle_materials.size(); ++t) {
      const std::uint32_t material = mesh->triangle_materials[t];
      const UvTriangle uvs = triangle_uvs(*mesh, t);
      for (const glm::vec2& uv : uvs) shown[material].bounds.add(uv);
      shown[material].color.add(triangle_color(plant.materials[material], plant.images, uvs, triangle_area_m2(*mesh, t)));
    }
  return shown;
}

/// The period that holds all coordinates of the axis; none if they span several.
std::optional<double> period_of(double low, double high) {
  const double period = std::floor(low);
  return std::isfinite(period) && high <= period + 1.0 ? std::optional(period) : std::nullopt;
}

/// The smallest region round `region` that is whole texels in both of two images of one surface.
TextureRegion snapped(const TextureRegion& region, const Image& image, const Image& other) {
  const glm::uvec2 side(image.width, image.height), other_side(other.width, other.height);
  TextureRegion result;
  for (int axis = 0; axis < 2; ++axis) {
    const std::uint32_t step = side[axis] / std::gcd(side[axis], other_side[axis]);
    result.first[axis] = region.first[axis] / step * step;
    result.last[axis] = (region.last[axis] + step - 1) / step * step;
  }
  return result;
}

/// The same region in an image of another size.
TextureRegion rescaled(const TextureRegion& region, const Image& from, const Image& to) {
  const auto scaled = [&](const glm::uvec2& texel) {
    return glm::uvec2(glm::u64vec2(texel) * glm::u64vec2(to.width, to.height) / glm::u64vec2(from.width, from.height));
  };
  return {scaled(region.first), scaled(region.last)};
}

Image cut(const Image& image, const TextureRegion& region) {
  Image result{region.size().x, region.size().y, {}, image.is_normal_map};
  result.rgba.reserve(std::size_t{4} * result.width * result.height);
  for (std::uint32_t row = region.first.y; row < region.last.y; ++row) {
    const auto begin = image.rgba.begin() + 4 * (std::ptrdiff_t{row} * image.width + region.first.x);
    result.rgba.insert(result.rgba.end(), begin, begin + 4 * std::ptrdiff_t{result.width});
  }
  return result;
}

/// A change of texture coordinates: uv becomes (uv - offset) * scale.
struct UvChange {
  glm::dvec2 offset{0.0}, scale{1.0};
};

UvChange change_for(const UvBounds& bounds, const TextureRegion& region, const Image& image) {
  UvChange change;
  const glm::dvec2 side(image.width, image.height);
  for (int axis = 0; axis < 2; ++axis) {
    if (region.size()[axis] == static_cast<std::uint32_t>(side[axis])) continue;
    change.offset[axis] = std::floor(bounds.low[axis]) + region.first[axis] / side[axis];
    change.scale[axis] = side[axis] / region.size()[axis];
  }
  return change;
}

/// Applies the changes. A vertex that triangles of several materials share is split, so that each has its own coordinates.
void change_uvs(Mesh& mesh, const std::vector<UvChange>& changes) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // the copy of a vertex for a material
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
        const auto copy_of = [&](auto& values) {
          if (!values.empty()) values.push_back(typename std::decay_t<decltype(values)>::value_type(values[vertex]));
        };
        copy_of(mesh.vertex_opacities);
        copy_of(mesh.vertex_alongs);
        copy_of(mesh.wind_weights);
      }
      mesh.indices[i] = copy->second;
    }
    const UvChange& change = changes[material];
    mesh.uvs[mesh.indices[i]] = glm::vec2((glm::dvec2(source[vertex]) - change.offset) * change.scale);
  }
}

/// Images that have been cut out of others, and the colour in which they are shown.
class CutImages {
 public:
  explicit CutImages(std::vector<Image>& images) : images_(images) {}

  /// Cuts the image's region, or shares the cut of a material that shows it in about the same colour.
  std::uint32_t take(std::uint32_t image, const TextureRegion& region, const glm::dvec3& color) {
    auto& copies = copies_[{image, region.first.x, region.first.y, region.last.x, region.last.y}];
    for (const Copy& copy : copies)
      if (color_difference(copy.color, color) <= kAlikeColors) return copy.image;
    if (copies.size() >= kMaxCopies) return copies.front().image;
    copies.push_back({static_cast<std::uint32_t>(images_.size()), color});
    images_.push_back(cut(images_[image], region));
    return copies.back().image;
  }

 private:
  struct Copy {
    std::uint32_t image = 0;
    glm::dvec3 color{0.0};
  };
  std::vector<Image>& images_;
  std::map<std::array<std::uint32_t, 5>, std::vector<Copy>> copies_;
};

/// Whether another material shows the material's image in another colour.
bool is_shared_by_others(const std::vector<Material>& materials, const std::vector<Shown>& shown, std::size_t material) {
  for (std::size_t m = 0; m < materials.size(); ++m)
    if (m != material && materials[m].image == materials[material].image && !shown[m].bounds.is_empty() &&
        color_difference(shown[m].color.mean(), shown[material].color.mean()) > kAlikeColors)
      return true;
  return false;
}

/// Cuts images where it pays, and returns how each material's coordinates change.
std::vector<UvChange> cut_images(Plant& plant) {
  const std::vector<Shown> shown = shown_by_material(plant);
  std::vector<UvChange> changes(plant.materials.size());
  CutImages cut_already(plant.images);
  const std::vector<Material> before = plant.materials;
  for (std::size_t m = 0; m < plant.materials.size(); ++m) {
    Material& material = plant.materials[m];
    if (material.image == kNone || shown[m].bounds.is_empty()) continue;
    const Image& image = plant.images[material.image];
    TextureRegion region = texture_region(shown[m].bounds, image);
    if (material.normal_map != kNone) region = snapped(region, image, plant.images[material.normal_map]);
    const bool is_small = static_cast<double>(region.texels()) <= kMaxKept * static_cast<double>(image.width) * image.height;
    if (!is_small && !is_shared_by_others(before, shown, m)) continue;
    changes[m] = change_for(shown[m].bounds, region, image);
    if (material.normal_map != kNone) {
      const TextureRegion of_normals = rescaled(region, image, plant.images[material.normal_map]);
      material.normal_map = cut_already.take(material.normal_map, of_normals, glm::dvec3(0.0));
    }
    material.image = cut_already.take(before[m].image, region, shown[m].color.mean());
  }
  return changes;
}

// Textures along a trunk repeat less often than this.
constexpr float kFar = 64.0f;

bool is_far(const glm::vec2& uv) {
  return std::abs(uv.x) >= kFar || std::abs(uv.y) >= kFar;
}

/// Keeps the images that materials show, in order of first use.
void drop_unused_images(std::vector<Material>& materials, std::vector<Image>& images) {
  std::vector<std::uint32_t> numbers(images.size(), kNone);
  std::vector<Image> kept;
  for (Material& material : materials)
    for (std::uint32_t* image : {&material.image, &material.normal_map}) {
      if (*image == kNone) continue;
      if (numbers[*image] == kNone) {
        numbers[*image] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(std::move(images[*image]));
      }
      *image = numbers[*image];
    }
  images = std::move(kept);
}

}  // namespace

TextureRegion texture_region(const UvBounds& bounds, const Image& image) {
  TextureRegion region{glm::uvec2(0), {image.width, image.height}};
  for (int axis = 0; axis < 2; ++axis) {
    const auto period = period_of(bounds.low[axis], bounds.high[axis]);
    if (!period) continue;
    const double side = region.last[axis];
    region.first[axis] = static_cast<std::uint32_t>(std::max(std::floor((bounds.low[axis] - *period) * side - kMargin), 0.0));
    region.last[axis] = static_cast<std::uint32_t>(std::min(std::ceil((bounds.high[axis] - *period) * side + kMargin), side));
  }
  return region;
}

void cut_texture_regions(Plant& plant) {
  const std::vector<UvChange> changes = cut_images(plant);
  change_uvs(plant.foliage, changes);
  change_uvs(plant.wood, changes);
  drop_unused_images(plant.materials, plant.images);
  measure_shown_texels(plant);
}

void bring_uvs_near_zero(Mesh& mesh, std::span<const LeafRange> leaves) {
  if (std::ranges::none_of(mesh.uvs, is_far)) return;
  UnionFind sets(mesh.uvs.size());
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    for (std::size_t k = 1; k < 3; ++k) sets.join(mesh.indices[i], mesh.indices[i + k]);
  for (const LeafRange& leaf : leaves)
    for (const std::uint32_t vertex : leaf_indices(mesh, leaf)) sets.join(leaf_indices(mesh, leaf)[0], vertex);
  std::vector<PointBox<glm::vec2>> boxes(mesh.uvs.size());
  for (std::uint32_t i = 0; i < mesh.uvs.size(); ++i) boxes[sets.find(i)].add(mesh.uvs[i]);
  for (std::uint32_t i = 0; i < mesh.uvs.size(); ++i) {
    const PointBox<glm::vec2>& box = boxes[sets.find(i)];
    const glm::vec2 middle = glm::floor(0.5f * box.low + 0.5f * box.high);
    if (is_far(middle)) mesh.uvs[i] -= middle;
  }
}

void drop_unused_materials(BakedPlant& plant) {
  std::vector<Mesh*> meshes;
  for (Mesh& lod : plant.wood.lods) meshes.push_back(&lod);
  for (LeafMeshPart& part : plant.leaf_meshes.parts) meshes.push_back(&part.mesh);
  std::vector<bool> is_on_card(plant.materials.size(), false), is_on_mesh(plant.materials.size(), false);
  for (const Card& card : plant.card_table) is_on_card[card.material] = true;
  for (const Mesh* mesh : meshes)
    for (const std::uint32_t material : mesh->triangle_materials) is_on_mesh[material] = true;
  std::vector<std::uint32_t> numbers(plant.materials.size(), kNone);
  std::vector<Material> kept;
  for (std::size_t m = 0; m < plant.materials.size(); ++m) {
    if (!is_on_card[m] && !is_on_mesh[m]) continue;
    if (!is_on_mesh[m]) plant.materials[m].normal_map = kNone;
    numbers[m] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(std::move(plant.materials[m]));
  }
  plant.materials = std::move(kept);
  drop_unused_images(plant.materials, plant.images);
  for (Card& card : plant.card_table) card.material = numbers[card.material];
  for (Mesh* mesh : meshes)
    for (std::uint32_t& material : mesh->triangle_materials) material = numbers[material];
}

}  // namespace coppice::bake
