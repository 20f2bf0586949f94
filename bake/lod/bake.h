#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "collapse.h"
#include "coppice/format.h"
#include "import_gltf.h"
#include "pack.h"
#include "wind.h"

namespace coppice::bake {

/// The values are the file's.
enum class Metric : std::uint32_t {
  default_metric = COPPICE_METRIC_IMAGE,
  mi = COPPICE_METRIC_MI,
  geometric = COPPICE_METRIC_GEOMETRIC,
};

/// Who measures projected areas. Only Metric::mi orders collapses by them.
enum class Areas {
  item_buffers,  ///< the baker's own rasteriser: the same on every machine
  vulkan,        ///< a Vulkan device's occlusion queries, the paper's way; another driver may give other areas
};

/// Maximum number of leaves for which Areas::vulkan measures again at every step; with more leaves it measures once, before the first step.
/// Time grows with the square of the number.
inline constexpr std::uint32_t kMaxMeasuredLeaves = 512;

/// Default number of a metric's viewpoints: 20, the paper's, except for the default metric. That has 42, or 32 for plants of more than
/// 8,192 leaves, where time matters and a single leaf does not.
std::uint32_t metric_view_count(Metric metric, std::uint32_t leaf_count);

/// Side of the views in which a metric computes costs: `resolution_px`. The default metric reduces it to as little as 3/8 if leaves would
/// cover more than six times the view: time grows with the pixels that leaves cover, and leaves that overlap so much are large in a smaller
/// view, too.
std::uint32_t metric_resolution_px(Metric metric, const Foliage& foliage, std::uint32_t resolution_px);

/// Options of --quick, four to eight times faster than the defaults: fewer and smaller views, fewer candidates. bake/README.md says what it
/// costs.
inline constexpr std::uint32_t kQuickViewCount = 14, kQuickResolution_px = 128, kQuickCandidateCount = 4;

struct BakeOptions {
  Metric metric = Metric::default_metric;
  std::uint32_t view_count = 0;    ///< 0: metric_view_count
  std::uint32_t thread_count = 0;  ///< 0: all
  ImportOptions import;
  CollapseOptions collapse;
  TextureCoding textures = TextureCoding::bc;
  float crown_normals = 0.0f;  ///< turn_normals_to_crown
  bool leaf_meshes = true;     ///< keeps the leaves as they were modelled, for close views
  Areas areas = Areas::item_buffers;
  WindOptions wind;
};

inline constexpr const char* kAreasNeedMi = "--areas vulkan needs --metric mi: no other metric orders collapses by projected areas";

/// errors  invalid_argument: areas are to be measured, but the metric does not use them
Result<void> check_areas(const BakeOptions& options);

/// The contents of `coppice bake --report`. Times are wall seconds.
struct BakeReport {
  std::uint32_t source_leaves = 0;  ///< 0 for a plant that is all wood
  std::array<double, 3> size_m{};   ///< width, height, depth
  struct Seconds {
    double import = 0, visibility = 0, collapse = 0, error_table = 0, wind = 0, pack = 0, total = 0;
  } seconds;
  std::uint64_t peak_rss_bytes = 0;
  std::uint64_t evaluations = 0;
  PackSizes sizes;
  std::uint32_t leaf_mesh_triangles = 0;
  std::string leaf_mesh_note;  ///< the reason if there are no leaf meshes
  FoliageInformation source_information;
  std::vector<FoliageInformation> level_information;
  std::string area_device;            ///< the device that measured areas; empty: item buffers did
  bool area_every_step = false;       ///< whether it measured at every step, or only before the first
  std::vector<std::string> warnings;  ///< what the importer guessed or dropped, one line each
};

/// Receives the running stage's name and its fraction in [0, 1].
using StageProgress = std::function<void(const char* stage, double fraction)>;

/// Bakes a plant to the bytes of a .coppice file: the whole pipeline of ARCHITECTURE.md. The same input and options give the same bytes,
/// whatever the thread count; with Areas::vulkan only on the same device and driver.
Result<std::vector<std::uint8_t>> bake(const std::filesystem::path& input, const BakeOptions& options, const StageProgress& progress,
                                       BakeReport& report);

}  // namespace coppice::bake
