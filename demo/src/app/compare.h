#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "camera.h"
#include "options.h"

namespace forest {

struct Session;

/// One way of drawing the forest, over the same poses as the others.
struct ComparedMode {
  LodMode lod = LodMode::cut;
  float error_px = 0;        ///< threshold; of full detail 0
  float frame_ms = 0;        ///< median over the poses
  std::uint64_t leaves = 0;  ///< medians
  std::uint64_t wood_triangles = 0, leaf_mesh_triangles = 0;
  std::uint64_t memory_bytes = 0;
  /// Root mean square difference of luminance, 0..255, from full detail; here and below of means of 4 x 4 pictures moved by parts of a
  /// pixel, so that it shows what the LoD does and not where samples fall.
  float rmse = 0;
  /// The same measure of what changes from frame to frame of a slow dolly and does not in full detail: mean over those frames, largest.
  /// Mostly what rmse counts, as it moves with the picture.
  float popping_mean = 0, popping_max = 0;
  float wind_popping_mean = 0, wind_popping_max = 0;  ///< the same in wind, 30 frames a second; 0 in still air
  /// What changes of cuts alone change: of pictures of the poses from the same with the cuts of an eye 10 cm to the right, about what
  /// changes in a frame of the dolly; the largest change of the mean of 8 x 8 pixels.
  float switching_rmse = 0, switching_block_max = 0;
};

struct Comparison {
  std::string device;
  std::uint32_t plants = 0, width_px = 0, height_px = 0, poses = 0;
  float wind_mps = 0;               ///< for wind_popping; everything else is in still air
  std::vector<ComparedMode> modes;  ///< full detail last
};

const char* mode_name(LodMode lod);

/// Runs cuts and discrete levels at one, two and four times options.error_px, and full detail, over poses of the path, in still air, and
/// the dolly in options.wind_mps too; prints the table and writes options.compare and the plot. errors  Failure
void compare_lods(Session& session, const CameraPath& path, const Options& options);

// In compare_report.cpp.
std::string comparison_table(const Comparison& comparison);
std::string comparison_json(const Comparison& comparison);
/// Error against frame time, one line a mode; the time's axis is logarithmic.
std::string comparison_svg(const Comparison& comparison);

}  // namespace forest
