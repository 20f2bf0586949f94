#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "collapse.h"
#include "import_gltf.h"
#include "pack.h"
#include "wind.h"

namespace coppice::bake {

enum class Metric { default_metric, mi, geometric };

/// Who measures projected areas, which order the collapses of Metric::mi and of no other.
enum class Areas {
  item_buffers,  ///< the baker's own: the same on every machine
  vulkan,        ///< occlusion queries of a Vulkan device: the paper's way. Another driver may give other areas
};

/// Up to so many leaves Areas::vulkan measures anew at every step; of more only the areas before the first. Time goes by the square of
/// them.
inline constexpr std::uint32_t kMostMeasuredLeaves = 512;

/// The number of viewpoints that a metric looks from unless told otherwise: 20, the paper's; for the default metric 42, or 32 for plants
/// of more than 8,192 leaves, where time matters and a single leaf does not.
std::uint32_t metric_view_count(Metric metric, std::uint32_t leaf_count);

/// The side of a view in which a metric weighs collapses: `resolution_px`; of the default metric down to 3/8 of it where leaves would cover
/// more than six times the view. Time goes by what leaves cover, and leaves that overlap so much are large in a smaller view, too.
std::uint32_t metric_resolution_px(Metric metric, const Foliage& foliage, std::uint32_t resolution_px);

/// Ten times faster than the defaults: fewer and smaller views, fewer candidates. bake/README.md has what it costs.
inline constexpr std::uint32_t kQuickViewCount = 14, kQuickResolution_px = 128, kQuickCandidateCount = 4;

struct BakeOptions {
  Metric metric = Metric::default_metric;
  std::uint32_t view_count = 0;    ///< 0: metric_view_count
  std::uint32_t thread_count = 0;  ///< 0: all
  ImportOptions import;
  CollapseOptions collapse;
  TextureCoding textures = TextureCoding::bc;
  float crown_normals = kCrownNormals;  ///< of all leaves, 0..1: plant.h
  bool leaf_meshes = true;              ///< keep the leaves as they were modelled, for close up
  Areas areas = Areas::item_buffers;
  WindOptions wind;
};

inline constexpr const char* kAreasNeedMi = "--areas vulkan needs --metric mi: no other metric orders collapses by projected areas";

/// errors  invalid_argument: areas are to be measured and the metric does not use them
Result<void> check_areas(const BakeOptions& options);

/// What `coppice bake --report` writes; times are wall seconds.
struct BakeReport {
  std::uint32_t source_leaves = 0;  ///< 0 of a plant that is all wood
  std::array<double, 3> size_m{};   ///< width, height, depth
  struct Seconds {
    double import = 0, visibility = 0, collapse = 0, error_table = 0, wind = 0, pack = 0, total = 0;
  } seconds;
  std::uint64_t peak_rss_bytes = 0;
  std::uint64_t evaluations = 0;
  PackSizes sizes;
  std::uint32_t leaf_mesh_triangles = 0;
  std::string leaf_mesh_note;  ///< why there are none
  FoliageInformation source_information;
  std::vector<FoliageInformation> level_information;
  std::string area_device;            ///< what measured areas; empty: item buffers
  bool area_every_step = false;       ///< whether it did so at every step, or only before the first
  std::vector<std::string> warnings;  ///< what the importer had to guess or drop, one line each
};

/// Called with the running stage's name and its fraction in [0, 1].
using StageProgress = std::function<void(const char* stage, double fraction)>;

/// plant.glb -> .coppice bytes: the whole pipeline of ARCHITECTURE.md. Same input and options, same bytes, whatever the thread count; with
/// Areas::vulkan on the same device and driver.
Result<std::vector<std::uint8_t>> bake(const std::filesystem::path& input, const BakeOptions& options, const StageProgress& progress,
                                       BakeReport& report);

}  // namespace coppice::bake
