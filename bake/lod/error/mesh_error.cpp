#include "mesh_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

#include <glm/geometric.hpp>

#include "alpha_mask.h"
#include "error_image.h"
#include "leaf_shade.h"
#include "parallel_for.h"
#include "texture_mips.h"
#include "tree_order.h"
#include "visibility.h"

namespace coppice::bake {
namespace {

/// An image's linear luminance at one mip level.
struct LuminanceLevel {
  std::uint32_t width = 0, height = 0;
  std::vector<float> luminance;
};

struct Look {
  float plain = 0.0f;                  ///< luminance without an image
  std::vector<LuminanceLevel> levels;  ///< luminance, times the base colour
};

Look look_of(const Material& material, const std::vector<Image>& images) {
  Look look{luminance(glm::vec3(material.base_color)), {}};
  if (material.image == kNone) return look;
  for (const Image& level : mip_levels(images[material.image], material.alpha_cutoff)) {
    LuminanceLevel& of_level = look.levels.emplace_back(LuminanceLevel{level.width, level.height, {}});
    for (std::size_t i = 0; i < level.rgba.size(); i += 4)
      of_level.luminance.push_back(luminance(linear_color(&level.rgba[i]) * glm::vec3(material.base_color)));
  }
  return look;
}

/// The mip level whose texels are about as large as pixels.
std::size_t level_of(const Look& look, const std::array<ProjectedPoint, 3>& points, const std::array<glm::vec2, 3>& uvs) {
  const glm::dvec2 ab(points[1].x - points[0].x, points[1].y - points[0].y), ac(points[2].x - points[0].x, points[2].y - points[0].y);
  const double pixels = std::abs(ab.x * ac.y - ab.y * ac.x) / (double{kSubpixels} * kSubpixels);
  const glm::dvec2 uv_ab(uvs[1] - uvs[0]), uv_ac(uvs[2] - uvs[0]);
  const double texels = std::abs(uv_ab.x * uv_ac.y - uv_ab.y * uv_ac.x) * look.levels.front().width * look.levels.front().height;
  if (!(texels > pixels) || !(pixels > 0.0)) return 0;
  return std::min(static_cast<std::size_t>(std::lround(0.5 * std::log2(texels / pixels))), look.levels.size() - 1);
}

/// Wood is lit by the normals of its corners.
float smooth_cosine(const std::array<glm::vec3, 3>& normals, const std::array<double, 3>& weight) {
  glm::vec3 normal(0.0f);
  for (std::size_t k = 0; k < 3; ++k) normal += static_cast<float>(weight[k]) * normals[k];
  const float length = glm::length(normal);
  return length > 0.0f ? std::max(glm::dot(normal, error_light()) / length, 0.0f) : 0.0f;
}

class TexturedCanvas {
  static constexpr std::uint32_t kNoDepth = 0xffffffff;

 public:
  TexturedCanvas(const Projection& projection, const std::vector<Look>& looks, const std::vector<AlphaMask>& masks)
      : projection_(projection), looks_(looks), masks_(masks), depths_(image.size(), kNoDepth) {}

  [[nodiscard]] glm::vec3 to_viewer() const { return {projection_.direction[0], projection_.direction[1], projection_.direction[2]}; }

  /// cosine(weights)  of the angle to the light, at a place between the corners
  template <class Cosine>
  void draw(const std::array<glm::vec3, 3>& corners, const std::array<glm::vec2, 3>& uvs, std::uint32_t material, const Cosine& cosine) {
    const std::array points{project(projection_, corners[0]), project(projection_, corners[1]), project(projection_, corners[2])};
    const RasterTriangle triangle(points[0], points[1], points[2]);
    const Look& look = looks_[material];
    const std::size_t level = look.levels.empty() ? 0 : level_of(look, points, uvs);
    const int last_row = std::min(triangle.last_row(), static_cast<std::int32_t>(kErrorImagePx) - 1);
    for (std::int32_t y = std::max(triangle.first_row(), 0); y <= last_row; ++y) {
      const Span span = triangle.row(y, kErrorImagePx);
      for (std::int32_t x = span.first; x <= span.last; ++x) {
        const std::size_t pixel = static_cast<std::size_t>(y) * kErrorImagePx + static_cast<std::size_t>(x);
        const std::uint32_t depth = triangle.depth(x, y);
        if (depth >= depths_[pixel]) continue;
        const std::array<double, 3> weight = triangle.weights(x, y);
        const glm::dvec2 uv = glm::dvec2(uvs[0]) * weight[0] + glm::dvec2(uvs[1]) * weight[1] + glm::dvec2(uvs[2]) * weight[2];
        if (masks_[material].is_hole(uv)) continue;
        depths_[pixel] = depth;
        const float albedo = look.levels.empty() ? look.plain : luminance_at(look.levels[level], uv);
        image[pixel] = plant_luminance(lambert_luminance(albedo, cosine(weight)));
      }
    }
  }

  LuminanceImage image = LuminanceImage(std::size_t{kErrorImagePx} * kErrorImagePx, kWhiteLuminance);
  [[nodiscard]] double covered() const {
    return static_cast<double>(image.size()) - static_cast<double>(std::ranges::count(depths_, kNoDepth));
  }

 private:
  static float luminance_at(const LuminanceLevel& level, const glm::dvec2& uv) {
    return level.luminance[std::size_t{wrapped_texel(uv.y, level.height)} * level.width + wrapped_texel(uv.x, level.width)];
  }

  const Projection& projection_;
  const std::vector<Look>& looks_;
  const std::vector<AlphaMask>& masks_;
  std::vector<std::uint32_t> depths_;
};

void draw_leaf_triangle(const std::array<glm::vec3, 3>& corners, const std::array<glm::vec2, 3>& uvs, std::uint32_t material,
                        const ShadingNormals& normals, TexturedCanvas& canvas) {
  const float cosine = leaf_cosine(normals, error_light(), canvas.to_viewer(), kTranslucency);
  canvas.draw(corners, uvs, material, [cosine](const auto&) { return cosine; });
}

void draw_quads(const BakedPlant& plant, std::span<const std::uint32_t> nodes, TexturedCanvas& canvas) {
  for (const std::uint32_t node : nodes) {
    const Quad quad = node_quad(plant.tree, node);
    const Card& card = plant.card_table[plant.tree.nodes[node].card];
    const ShadingNormals normals = shading_normals(plant.tree.nodes[node].normals, quad);
    for (const std::size_t second : {std::size_t{1}, std::size_t{2}})
      draw_leaf_triangle({quad[0], quad[second], quad[second + 1]}, {card.uv[0], card.uv[second], card.uv[second + 1]}, card.material,
                         normals, canvas);
  }
}

void draw_leaves(const Mesh& mesh, const std::vector<Material>& materials, TexturedCanvas& canvas) {
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const std::array<glm::vec3, 3> normals = at_corners(mesh.normals, mesh.indices, 3 * t);
    const glm::vec3 sum = normals[0] + normals[1] + normals[2];
    const float length = glm::length(sum);
    const glm::vec3 axis = length > 0.0f ? sum / length : normals[0];
    const std::uint32_t material = mesh.triangle_materials[t];
    draw_leaf_triangle(at_corners(mesh.positions, mesh.indices, 3 * t), at_corners(mesh.uvs, mesh.indices, 3 * t), material,
                       {{axis.x, axis.y, axis.z}, 1.0f, materials[material].sided_normals}, canvas);
  }
}

/// Seen from behind, a triangle is lit by the opposites of its normals.
void draw_wood(const Mesh& mesh, TexturedCanvas& canvas) {
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const std::array corners = at_corners(mesh.positions, mesh.indices, 3 * t);
    std::array normals = at_corners(mesh.normals, mesh.indices, 3 * t);
    const glm::vec3 face = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    if (glm::dot(face, canvas.to_viewer()) < 0.0f)
      for (glm::vec3& normal : normals) normal = -normal;
    canvas.draw(corners, at_corners(mesh.uvs, mesh.indices, 3 * t), mesh.triangle_materials[t],
                [&](const std::array<double, 3>& weight) { return smooth_cosine(normals, weight); });
  }
}

/// Everything needed to draw a plant's quads and some meshes.
struct Scene {
  std::vector<AlphaMask> masks;         ///< [material]
  std::vector<Look> looks;              ///< [material] only those shown
  std::vector<Projection> projections;  ///< [kErrorViewCount]
  std::vector<std::uint32_t> leaves;    ///< nodes of the finest cut
};

Result<Scene> make_scene(const BakedPlant& plant, std::span<const Mesh* const> meshes) {
  Scene scene;
  COPPICE_CHECK(move_into(scene.masks, alpha_masks(plant.materials, plant.images)));
  std::vector<bool> shown(plant.materials.size(), false);
  for (const Card& card : plant.card_table) shown[card.material] = true;
  for (const Mesh* mesh : meshes)
    for (const std::uint32_t material : mesh->triangle_materials) shown[material] = true;
  scene.looks.resize(plant.materials.size());
  parallel_for(scene.looks.size(), [&](std::size_t material) {
    if (shown[material]) scene.looks[material] = look_of(plant.materials[material], plant.images);
  });
  scene.projections = error_projections(plant.sphere);
  scene.leaves = cut_nodes(plant.tree, plant.tree.leaf_count());
  return scene;
}

/// Sums over the parts of a coarse image.
struct CoarseChange {
  double changed = 0.0;  ///< how much a LoD changes
  double plant = 0.0;    ///< how much the finest LoD differs from white
};

CoarseChange coarse_change(const LuminanceImage& finest, const LuminanceImage& other) {
  const LuminanceImage before = coarse_image(finest), after = coarse_image(other);
  CoarseChange change;
  for (std::size_t i = 0; i < before.size(); ++i) {
    change.changed += std::abs(double{before[i]} - double{after[i]});
    change.plant += double{kWhiteLuminance} - double{before[i]};
  }
  return change;
}

/// Converts the changed share of the plant to an error, px. At two thresholds of 2 px a 24th of a plant of 36 px and more may change; of a
/// smaller plant more, since it is less visible.
float change_px(const std::array<CoarseChange, kErrorViewCount>& views, std::uint32_t size_px) {
  constexpr std::uint32_t kLargest_px = 36;
  constexpr double kErrorPerPx = 96.0 / kLargest_px;
  CoarseChange sum;
  for (const CoarseChange& view : views) sum.changed += view.changed, sum.plant += view.plant;
  return sum.plant > 0.0 ? static_cast<float>(kErrorPerPx * std::min(size_px, kLargest_px) * sum.changed / sum.plant) : 0.0f;
}

using ErrorRow = std::array<float, kErrorSizesPx.size()>;

Result<std::vector<ErrorRow>> own_wood_errors(const BakedPlant& plant, std::span<const Mesh* const> lods) {
  if (!std::ranges::equal(plant.errors.sizes_px, kErrorSizesPx))
    return Error{Status::invalid_argument, "wood error: the error table is not at the sizes that are measured"};
  COPPICE_TRY(scene, make_scene(plant, lods));
  std::vector<std::array<SquaredErrors, kErrorViewCount>> errors(lods.size());
  std::vector<std::array<CoarseChange, kErrorViewCount>> changes(lods.size());
  parallel_for(std::size_t{kErrorViewCount}, [&](std::size_t view) {
    TexturedCanvas leaves(scene.projections[view], scene.looks, scene.masks);
    draw_quads(plant, scene.leaves, leaves);
    LuminanceImage finest;
    for (std::size_t lod = 0; lod < lods.size(); ++lod) {
      TexturedCanvas canvas(leaves);
      draw_wood(*lods[lod], canvas);
      if (lod == 0) finest = canvas.image;
      errors[lod][view] = squared_errors(finest, canvas.image);
      changes[lod][view] = coarse_change(finest, canvas.image);
    }
  });
  std::vector<ErrorRow> rows(lods.size());
  for (std::size_t lod = 0; lod < lods.size(); ++lod)
    for (std::size_t size = 0; size < kErrorSizesPx.size(); ++size)
      rows[lod][size] = std::max(error_px_of(errors[lod], size), change_px(changes[lod], kErrorSizesPx[size]));
  return rows;
}

/// Appends a row that is nowhere below the previous one.
void append_row(const ErrorRow& row, std::vector<float>& error_px) {
  for (const float own_px : row)
    error_px.push_back(std::max(own_px, error_px.size() < row.size() ? 0.0f : error_px[error_px.size() - row.size()]));
}

double summed_logarithms(const ErrorRow& row) {
  double sum = 0.0;
  for (const float error_px : row) sum += std::log(std::max(double{error_px}, 1e-6));
  return sum;
}

/// Pulls a mesh into the sphere. A proxy may reach beyond its piece, and so out of the source's sphere, which culling trusts.
void pull_into(const Sphere& sphere, Mesh& mesh) {
  for (glm::vec3& position : mesh.positions) {
    const glm::vec3 arm = position - sphere.center;
    const float length_m = glm::length(arm);
    if (length_m > sphere.radius) position = sphere.center + arm * (sphere.radius / length_m);
  }
}

}  // namespace

Result<std::vector<float>> measure_leaf_mesh_error(const BakedPlant& plant) {
  std::vector<const Mesh*> parts;
  for (const LeafMeshPart& part : plant.leaf_meshes.parts) parts.push_back(&part.mesh);
  COPPICE_TRY(scene, make_scene(plant, parts));
  std::array<SquaredErrors, kErrorViewCount> errors{};
  std::array<double, kErrorViewCount> covered{}, changes{};
  parallel_for(std::size_t{kErrorViewCount}, [&](std::size_t view) {
    TexturedCanvas quads(scene.projections[view], scene.looks, scene.masks), meshes(quads);
    draw_quads(plant, scene.leaves, quads);
    for (const Mesh* part : parts) draw_leaves(*part, plant.materials, meshes);
    errors[view] = squared_errors(meshes.image, quads.image);
    covered[view] = meshes.covered();
    changes[view] = std::abs(quads.covered() - covered[view]);
  });
  const double all = std::accumulate(covered.begin(), covered.end(), 0.0);
  const double change = all > 0.0 ? std::accumulate(changes.begin(), changes.end(), 0.0) / all : 0.0;
  std::vector<float> error_px;
  for (std::size_t size = 0; size < kErrorSizesPx.size(); ++size) {
    const float own_px = std::max(error_px_of(errors, size), coverage_error_px(change, kErrorSizesPx[size]));
    error_px.push_back(std::max(own_px, error_px.empty() ? 0.0f : error_px.back()));
  }
  return error_px;
}

Result<std::vector<float>> measure_wood_error(const BakedPlant& plant, std::span<const Mesh* const> lods) {
  COPPICE_TRY(rows, own_wood_errors(plant, lods));
  std::vector<float> error_px;
  for (const ErrorRow& row : rows) append_row(row, error_px);
  return error_px;
}

Result<WoodLods> choose_wood_lods(const BakedPlant& plant, std::vector<WoodLevel> levels) {
  WoodLods chosen;
  std::vector<const Mesh*> meshes;
  for (WoodLevel& level : levels)
    for (Mesh& mesh : level) {
      pull_into(plant.sphere, mesh);
      meshes.push_back(&mesh);
    }
  if (meshes.empty()) return chosen;
  COPPICE_TRY(rows, own_wood_errors(plant, meshes));
  std::size_t first = 0;
  for (WoodLevel& level : levels) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < level.size(); ++i)
      if (summed_logarithms(rows[first + i]) < summed_logarithms(rows[first + best])) best = i;
    append_row(rows[first + best], chosen.error_px);
    first += level.size();
    chosen.lods.push_back(std::move(level[best]));
  }
  return chosen;
}

}  // namespace coppice::bake
