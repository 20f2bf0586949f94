#pragma once

// `coppice evaluate`: what each simplifier does to a plant, measured the same way for all.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evaluation_render.h"
#include "import_gltf.h"
#include "level_set.h"
#include "methods.h"
#include "plant.h"
#include "result.h"

namespace coppice::bake {

/// The paper's levels of detail.
inline const std::vector<double> kEvaluationFractions = {0.8, 0.6, 0.4, 0.2, 0.1, 0.05, 0.025};

/// What simplified plants are compared with.
enum class ReferenceKind {
  quads,   ///< the plant's leaf quads, all of them, each material in its mean colour: what the simplifiers start from
  meshes,  ///< its leaves as they were modelled, with their textures: what a person sees
};

/// "quads", "meshes"
const char* reference_name(ReferenceKind reference);

/// Picture sides are whole multiples of this: the smallest picture is filtered from so many pixels each way.
inline constexpr std::uint32_t kEvaluationSizeStepPx = 16;

/// How leaves become quads, and what the methods look from.
enum class Setup {
  ours,   ///< as `coppice bake` does
  paper,  ///< rectangles of equation (1), each material opaque in its mean colour; `mi` looks in perspective, from the cameras' distance
};

/// "ours", "paper"
const char* setup_name(Setup setup);

struct EvaluateOptions {
  std::vector<Method> methods{default_methods().begin(), default_methods().end()};
  std::vector<LevelSet> level_sets;                      ///< measured after the methods
  std::vector<double> fractions = kEvaluationFractions;  ///< of the source leaves, in (0, 1]
  Setup setup = Setup::ours;
  double view_distance_radii = kEvaluationDistanceRadii;  ///< of cameras from the middle of the bounding sphere, in its radii; above 1
  bool suns_and_frames = true;                            ///< measure the pictures of LevelMeasures::Lit too
  ReferenceKind reference = ReferenceKind::quads;
  std::uint32_t size_px = kEvaluationSizePx;  ///< side of the pictures, a multiple of kEvaluationSizeStepPx, at most kMaxEvaluationSizePx
  std::uint32_t thread_count = 0;             ///< 0: all
  bool keep_pictures = false;                 ///< the report gets pictures for a reader: see thumbnail.h
  ImportOptions import;
};

/// One method at one level, against EvaluationReport::reference. Distances are infinite for a mesh without triangles.
struct LevelMeasures {
  /// Of other pictures than that of one frame under one sun: as LevelMeasures::rmse_full and rmse_sixteenth.
  struct Lit {
    double suns_full = 0.0, suns_sixteenth = 0.0;      ///< root mean square over evaluation_suns()
    double frames_full = 0.0, frames_sixteenth = 0.0;  ///< of the means of temporal_frames()
  };
  double fraction = 0.0;
  std::string parameters;                 ///< of the method's variants the one measured: the least product of the three rmse; may be empty
  std::uint32_t leaves = 0;               ///< asked for: level_leaves(N, fraction)
  std::uint32_t triangles = 0;            ///< got
  double rmse_full = 0.0;                 ///< luminance 0..255 over all pixels and cameras, pictures of EvaluationReport::size_px
  double rmse_quarter = 0.0;              ///< of the same pictures box-filtered by 4 both ways
  double rmse_sixteenth = 0.0;            ///< and by 16
  double coverage = 0.0;                  ///< foliage pixels over the reference's
  double soft_iou = 0.0;                  ///< of coverage box-filtered by 4 both ways
  double area_ratio = 0.0;                ///< surface over the reference's
  double hausdorff = 0.0;                 ///< largest distance of the surfaces, over the diagonal of the reference's box
  double mean_distance = 0.0;             ///< mean distance, over the same; of both directions the larger
  std::optional<Lit> lit;                 ///< none unless EvaluateOptions::suns_and_frames
  std::vector<std::uint8_t> picture_png;  ///< a file; empty unless EvaluateOptions::keep_pictures
};

struct MethodMeasures {
  std::string name;      ///< method_name, or that of a level set
  double seconds = 0.0;  ///< wall time to simplify, all levels and variants together; 0 of a level set
  std::vector<LevelMeasures> levels;
};

struct EvaluationReport {
  std::string plant;
  std::uint32_t source_leaves = 0;
  ReferenceKind reference = ReferenceKind::quads;
  Setup setup = Setup::ours;
  double view_distance_radii = kEvaluationDistanceRadii;
  std::uint32_t size_px = kEvaluationSizePx;
  std::uint32_t source_triangles = 0;            ///< of the reference
  std::vector<std::uint8_t> source_picture_png;  ///< as LevelMeasures::picture_png
  std::vector<MethodMeasures> methods;
  /// With meshes as the reference: the finest level as a .coppice file gives it back.
  struct Stored {
    bool is_leaf_meshes = false;  ///< else all quads, because that is what the leaves are
    LevelMeasures level;
  };
  std::optional<Stored> stored;
  std::vector<std::string> warnings;  ///< the importer's, and of level sets that are too large to be compared
};

/// The names of LevelMeasures::rmse_full, rmse_quarter and rmse_sixteenth in reports: "rmse_256", "rmse_64" and "rmse_16" for pictures of
/// 256 px, "rmse_512", "rmse_128" and "rmse_32" for 512.
std::array<std::string, 3> rmse_names(std::uint32_t size_px);

/// The names of LevelMeasures::Lit's members in reports, in their order: "rmse_256_suns", "rmse_16_suns", "rmse_256_frames", ...
std::array<std::string, 4> lit_names(std::uint32_t size_px);

/// Called from one thread with the running stage's name and its fraction in [0, 1].
using EvaluateProgress = std::function<void(const char* stage, double fraction)>;

/// floor(fraction N), at least 1; a product a rounding error below a whole number is that number.
std::uint32_t level_leaves(std::uint32_t leaf_count, double fraction);

/// Measures every method at every fraction. All figures but `seconds` are the same for any number of threads.
/// plant     its name
/// progress  may be empty
/// errors    invalid_argument: no methods and no level sets, no fractions, a fraction not in (0, 1], a picture size or distance out of
/// range,
///           a foliage without extent, what a method or surface_looks rejects; meshes as the reference, which leaf quads are without;
///           those of read_level_set
Result<EvaluationReport> evaluate_foliage(const std::string& plant, const ShownFoliage& shown, const EvaluateOptions& options,
                                          const EvaluateProgress& progress);

/// The same of a plant, leaf quads and their cards as the set-up makes them.
/// errors  those of source_foliage and the above, but for meshes as the reference of Setup::ours
Result<EvaluationReport> evaluate_plant(Plant plant, const EvaluateOptions& options, const EvaluateProgress& progress);

/// The leaf quads that simplifiers start from; the plant's materials and images become those that they show.
/// errors  those of card_foliage, fit_leaf_quads and alpha_masks
Result<Foliage> source_foliage(Plant& plant, Setup setup);

/// The same of a file. errors  also those of import_gltf
Result<EvaluationReport> evaluate(const std::filesystem::path& input, const EvaluateOptions& options, const EvaluateProgress& progress);

}  // namespace coppice::bake
