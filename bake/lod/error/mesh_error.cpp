#include "mesh_error.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

  /// 1 for pixels that show something nearer than the other canvas does, else 0.
  [[nodiscard]] LuminanceImage nearer_than(const TexturedCanvas& other) const {
    LuminanceImage nearer(depths_.size());
    std::ranges::transform(depths_, other.depths_, nearer.begin(),
                           [](std::uint32_t own, std::uint32_t its) { return own < its ? 1.0f : 0.0f; });
    return nearer;
  }

  /// Number of pixels that show anything.
  [[nodiscard]] double covered() const {
    return static_cast<double>(image.size()) - static_cast<double>(std::ranges::count(depths_, kNoDepth));
  }

  LuminanceImage image = LuminanceImage(std::size_t{kErrorImagePx} * kErrorImagePx, kWhiteLuminance);

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
  const LuminanceImage before = coarse_image(finest, kErrorImagePx, 8), after = coarse_image(other, kErrorImagePx, 8);
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

/// Sums over an image of one size, px.
struct StemChange {
  double changed = 0.0;  ///< how much of the stems a LoD loses, or makes too thick
  double wood = 0.0;     ///< what the finest LoD covers
};
/// At the sizes up to 64 px. Beyond, squares show a stem that is missing, and shares hardly change.
constexpr std::size_t kStemSizes = 4;
using StemChanges = std::array<StemChange, kStemSizes>;

/// Replaces each pixel by the sum of it and its neighbours in one direction.
void add_neighbours(LuminanceImage& image, std::size_t size_px, std::size_t line_step, std::size_t step) {
  for (std::size_t line = 0; line < size_px; ++line) {
    float before = 0.0f;
    for (std::size_t i = 0; i < size_px; ++i) {
      float* at = &image[line * line_step + i * step];
      before = std::exchange(*at, before + *at + (i + 1 < size_px ? at[step] : 0.0f));
    }
  }
}

LuminanceImage sums_of_nine(LuminanceImage image, std::size_t size_px) {
  add_neighbours(image, size_px, size_px, 1);
  add_neighbours(image, size_px, 1, size_px);
  return image;
}

/// Compares what wood covers in 3 x 3 pixels, so that a stem may be a pixel aside. A pixel counts as the cube of its coverage: a stem that
/// is missing is seen where it is as wide as a pixel and hardly where it is half as wide. Twigs are a haze, in which each may be anywhere.
/// finest, other  1 where pixels show wood, else 0
StemChanges stem_changes(LuminanceImage finest, LuminanceImage other) {
  StemChanges changes;
  std::uint32_t last_px = kErrorImagePx;
  for (std::size_t size = kStemSizes; size-- > 0;) {
    const std::uint32_t size_px = kErrorSizesPx[size];
    finest = coarse_image(std::move(finest), last_px, size_px);
    other = coarse_image(std::move(other), last_px, size_px);
    last_px = size_px;
    const LuminanceImage before = sums_of_nine(finest, size_px), after = sums_of_nine(other, size_px);
    for (std::size_t i = 0; i < finest.size(); ++i) {
      if (!(finest[i] > 0.0f)) continue;
      const double covered = double{finest[i]};
      changes[size].wood += covered;
      changes[size].changed += covered * covered * covered * std::min(std::abs(double{after[i]} / double{before[i]} - 1.0), 1.0);
    }
  }
  return changes;
}

/// Converts the changed share of the wood to an error, px. At two thresholds of 2 px a fifth of stems as wide as pixels may change. Wood of
/// a few pixels counts as more of them.
float stem_px(const std::array<StemChanges, kErrorViewCount>& views, std::size_t size) {
  constexpr double kErrorPx = 20.0, kFewPx = 16.0;
  StemChange sum;
  for (const StemChanges& view : views) {
    const StemChange& change = view[std::min(size, kStemSizes - 1)];
    sum.changed += change.changed, sum.wood += change.wood;
  }
  return static_cast<float>(kErrorPx * sum.changed / std::max(sum.wood, kFewPx * kErrorViewCount));
}

using ErrorRow = std::array<float, kErrorSizesPx.size()>;

Result<std::vector<ErrorRow>> own_wood_errors(const BakedPlant& plant, std::span<const Mesh* const> lods) {
  if (!std::ranges::equal(plant.errors.sizes_px, kErrorSizesPx))
    return Error{Status::invalid_argument, "wood error: the error table is not at the sizes that are measured"};
  COPPICE_TRY(scene, make_scene(plant, lods));
  std::vector<std::array<SquaredErrors, kErrorViewCount>> errors(lods.size());
  std::vector<std::array<CoarseChange, kErrorViewCount>> changes(lods.size());
  std::vector<std::array<StemChanges, kErrorViewCount>> stems(lods.size());
  std::vector<ViewCoverage> coverage(lods.size());
  parallel_for(std::size_t{kErrorViewCount}, [&](std::size_t view) {
    TexturedCanvas leaves(scene.projections[view], scene.looks, scene.masks);
    draw_quads(plant, scene.leaves, leaves);
    LuminanceImage finest, finest_wood;
    for (std::size_t lod = 0; lod < lods.size(); ++lod) {
      TexturedCanvas canvas(leaves);
      draw_wood(*lods[lod], canvas);
      LuminanceImage wood = canvas.nearer_than(leaves);
      if (lod == 0) finest = canvas.image, finest_wood = wood;
      errors[lod][view] = squared_errors(finest, canvas.image);
      changes[lod][view] = coarse_change(finest, canvas.image);
      stems[lod][view] = stem_changes(finest_wood, std::move(wood));
      coverage[lod][view] = canvas.covered();
    }
  });
  std::vector<ErrorRow> rows(lods.size());
  for (std::size_t lod = 0; lod < lods.size(); ++lod) {
    double worst = 0.0;
    for (std::size_t view = 0; view < kErrorViewCount; ++view)
      if (const double finest = coverage[0][view]; finest > 0.0) worst = std::max(worst, std::abs(coverage[lod][view] - finest) / finest);
    for (std::size_t size = 0; size < kErrorSizesPx.size(); ++size)
      rows[lod][size] = std::max({error_px_of(errors[lod], size), change_px(changes[lod], kErrorSizesPx[size]), stem_px(stems[lod], size),
                                  coverage_error_px(worst, kErrorSizesPx[size])});
  }
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
  ViewCoverage mesh_coverage{}, quad_coverage{};
  parallel_for(std::size_t{kErrorViewCount}, [&](std::size_t view) {
    TexturedCanvas quads(scene.projections[view], scene.looks, scene.masks), meshes(quads);
    draw_quads(plant, scene.leaves, quads);
    for (const Mesh* part : parts) draw_leaves(*part, plant.materials, meshes);
    errors[view] = squared_errors(meshes.image, quads.image);
    mesh_coverage[view] = meshes.covered();
    quad_coverage[view] = quads.covered();
  });
  const double change = changed_coverage(mesh_coverage, quad_coverage);
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
    const auto cost = [&](std::size_t i) {
      constexpr double kLimbsFactor = 1.5;  // keeps a poplar, whose limbs have less error but look too light, as a whole
      const double more = i < kWholeMeshes ? 0.0 : std::log(kLimbsFactor) * static_cast<double>(kErrorSizesPx.size());
      return summed_logarithms(rows[first + i]) + more;
    };
    std::size_t best = 0;
    for (std::size_t i = 1; i < level.size(); ++i)
      if (cost(i) < cost(best)) best = i;
    append_row(rows[first + best], chosen.error_px);
    first += level.size();
    chosen.lods.push_back(std::move(level[best]));
  }
  return chosen;
}

}  // namespace coppice::bake
