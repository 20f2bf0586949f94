#pragma once

// `coppice evaluate`: measures how simplifiers change a plant, in the same way for all.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evaluation_render.h"
#include "import_gltf.h"
#include "level_files.h"
#include "methods.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// The paper's levels of detail.
inline const std::vector<double> kEvaluationFractions = {0.8, 0.6, 0.4, 0.2, 0.1, 0.05, 0.025};

/// What simplified plants are compared with.
enum class ReferenceKind {
  quads,   ///< all of the plant's leaf quads, each material in its mean colour: what the simplifiers start from
  meshes,  ///< the leaves as they were modelled, with their textures: what a person sees
};

/// Returns "quads" or "meshes".
const char* reference_name(ReferenceKind reference);

/// Sides of images are whole multiples of this: the smallest image is filtered by this factor.
inline constexpr std::uint32_t kEvaluationSizeStepPx = 16;

/// How leaves become quads, and where the methods look from.
enum class Setup {
  ours,   ///< as `coppice bake` does
  paper,  ///< rectangles of equation (1), each material opaque in its mean colour; `mi` looks in perspective, from the cameras' distance
};

/// Returns "ours" or "paper".
const char* setup_name(Setup setup);

/// What a report repeats of the options.
struct EvaluationSetup {
  ReferenceKind reference = ReferenceKind::quads;
  Setup setup = Setup::ours;
  double view_distance_radii = kEvaluationDistanceRadii;  ///< from the cameras to the bounding sphere's centre, in radii; above 1
  std::uint32_t size_px = kEvaluationSizePx;  ///< side of the images, a multiple of kEvaluationSizeStepPx, at most kMaxEvaluationSizePx
};

struct EvaluateOptions : EvaluationSetup {
  std::vector<Method> methods{default_methods().begin(), default_methods().end()};
  std::vector<LevelSet> level_sets;                      ///< they follow the methods
  std::vector<double> fractions = kEvaluationFractions;  ///< shares of the source leaves, in (0, 1]
  bool suns_and_frames = true;                           ///< whether to measure LevelMeasures::Lit too
  std::uint32_t thread_count = 0;                        ///< 0: all
  bool keep_pictures = false;                            ///< whether the report gets pictures for a reader: see thumbnail.h
  ImportOptions import;
};

/// The figures of one method at one level, against EvaluationReport::reference. Distances are infinite for a mesh without triangles.
struct LevelMeasures {
  /// The same as rmse_full and rmse_sixteenth, under other conditions than one frame under one sun.
  struct Lit {
    double suns_full = 0.0, suns_sixteenth = 0.0;      ///< root mean square over evaluation_suns()
    double frames_full = 0.0, frames_sixteenth = 0.0;  ///< for the mean image of temporal_frames()
  };
  /// The figures under one of kEvaluationLights before one of kEvaluationGrounds, over evaluation_light_suns().
  struct Lighting {
    double rmse_full = 0.0, rmse_sixteenth = 0.0;
    double luminance = 1.0;  ///< mean luminance of foliage pixels over the reference's; the same before every ground
  };
  double fraction = 0.0;
  std::string parameters;       ///< the variant with the smallest product of the three rmse; may be empty
  std::uint32_t leaves = 0;     ///< requested: level_leaves(N, fraction)
  std::uint32_t triangles = 0;  ///< actual
  double rmse_full = 0.0;       ///< luminance 0..255 over all pixels and cameras, with images of EvaluationReport::size_px
  double rmse_quarter = 0.0;    ///< the same images, box-filtered by 4 both ways
  double rmse_sixteenth = 0.0;  ///< box-filtered by 16
  double coverage = 0.0;        ///< foliage pixels over the reference's
  double soft_iou = 0.0;        ///< intersection over union of coverage box-filtered by 4 both ways
  double area_ratio = 0.0;      ///< surface over the reference's
  double hausdorff = 0.0;       ///< largest distance of the surfaces, over the diagonal of the reference's box
  double mean_distance = 0.0;   ///< mean distance, over the same diagonal; the larger of both directions
  /// [light * kEvaluationGrounds.size() + ground]
  std::array<Lighting, kLightingCount> lightings{};
  std::optional<Lit> lit;                 ///< none unless EvaluateOptions::suns_and_frames
  std::vector<std::uint8_t> picture_png;  ///< a file; empty unless EvaluateOptions::keep_pictures
};

/// The largest of a level's lightings in each error, and the luminance that is farthest from 1.
LevelMeasures::Lighting worst_lighting(const LevelMeasures& level);
/// The mean of a level's lightings.
LevelMeasures::Lighting mean_lighting(const LevelMeasures& level);

struct MethodMeasures {
  std::string name;      ///< method_name, or the level set's name
  double seconds = 0.0;  ///< wall time to simplify, all levels and variants together; 0 for a level set
  std::vector<LevelMeasures> levels;
};

struct EvaluationReport : EvaluationSetup {
  std::string plant;
  std::uint32_t source_leaves = 0;
  std::uint32_t source_triangles = 0;            ///< the reference's
  std::vector<std::uint8_t> source_picture_png;  ///< as LevelMeasures::picture_png
  std::vector<MethodMeasures> methods;
  /// With meshes as the reference: the finest level after it went through a .coppice file.
  struct Stored {
    bool is_leaf_meshes = false;  ///< false: all quads, because the leaves are quads
    LevelMeasures level;
  };
  std::optional<Stored> stored;
  std::vector<std::string> warnings;  ///< the importer's, and those about level sets that are too large to compare
};

/// Names of LevelMeasures::rmse_full, rmse_quarter and rmse_sixteenth in reports: "rmse_256", "rmse_64" and "rmse_16" for images of 256 px,
/// "rmse_512", "rmse_128" and "rmse_32" for 512.
std::array<std::string, 3> rmse_names(std::uint32_t size_px);

/// Names in reports of the errors of mean_lighting and worst_lighting: "rmse_256_mean", "rmse_16_mean", "rmse_256_worst", "rmse_16_worst".
std::array<std::string, 4> lighting_names(std::uint32_t size_px);

/// Names of LevelMeasures::Lit's members in reports, in order: "rmse_256_suns", "rmse_16_suns", "rmse_256_frames", ...
std::array<std::string, 4> lit_names(std::uint32_t size_px);

/// Called from one thread with the running stage's name and its fraction in [0, 1].
using EvaluateProgress = std::function<void(const char* stage, double fraction)>;

/// floor(fraction N), at least 1. A product that rounding puts just below a whole number counts as that number.
std::uint32_t level_leaves(std::uint32_t leaf_count, double fraction);

/// Measures every method at every fraction. All figures but `seconds` are the same for any number of threads.
/// plant     its name
/// progress  may be empty
/// errors    invalid_argument: no methods and no level sets, no fractions, a fraction not in (0, 1], an image size or distance out of
///           range, a foliage without extent, what a method or surface_looks rejects; meshes as the reference, since there are only leaf
///           quads here; those of read_level_set
Result<EvaluationReport> evaluate_foliage(const std::string& plant, const ShownFoliage& shown, const EvaluateOptions& options,
                                          const EvaluateProgress& progress);

/// The same for a plant. The set-up makes its leaf quads and their cards.
/// errors  those of source_foliage and evaluate_foliage, except for meshes as the reference of Setup::ours
Result<EvaluationReport> evaluate_plant(Plant plant, const EvaluateOptions& options, const EvaluateProgress& progress);

/// Makes the leaf quads that simplifiers start from. The plant's materials and images become those that the quads show.
/// errors  those of card_foliage, fit_leaf_quads and alpha_masks
Result<Foliage> source_foliage(Plant& plant, Setup setup);

/// The same for a file. errors  also those of import_gltf
Result<EvaluationReport> evaluate(const std::filesystem::path& input, const EvaluateOptions& options, const EvaluateProgress& progress);

}  // namespace coppice::bake
