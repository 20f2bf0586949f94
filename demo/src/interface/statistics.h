#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <coppice/coppice.h>

#include "pass_timer.h"

namespace forest {

/// What a run measures; the frames rendered only to let streaming settle are not in it.
struct Statistics {
  std::string device, driver;
  bool software_device = false;                                 ///< a processor does the GPU's work
  std::array<std::uint32_t, 2> picture_px = {}, drawn_px = {};  ///< width and height of the picture, and of what is enlarged to it
  bool shadow_maps = false, temporal = false;                   ///< at the end of the run
  std::vector<float> frame_ms;
  /// Per frame: drawn, in view but hidden, outside the view.
  std::vector<std::uint32_t> visible_instances, occluded_instances, culled_instances;
  std::vector<std::uint64_t> drawn_leaves;          ///< per frame
  std::vector<std::uint32_t> leaf_mesh_instances;   ///< per frame
  std::vector<std::uint64_t> leaf_mesh_triangles;   ///< per frame
  std::vector<std::uint64_t> drawn_wood_triangles;  ///< per frame
  std::vector<float> threshold_px;                  ///< per frame
  /// GPU time by pass, ms, per frame: the library's (coppice_pass), then the scene's (ScenePass). Empty unless measured.
  std::array<std::vector<float>, COPPICE_PASS_COUNT + static_cast<std::size_t>(ScenePass::count)> pass_ms;
  coppice_stats last = {};            ///< the last frame's
  coppice_view_stats last_view = {};  ///< likewise, of the picture
  /// Headless, from the start of the program, device and pipelines included: until the GPU had drawn the first frame that shows a plant,
  /// and until all of a scene that the first view wants was there.
  float first_picture_ms = 0, settled_ms = 0;
  double seconds = 0;  ///< from the start to `last`
  float max_threshold_px = 0;
  std::uint32_t max_chunks_in_flight = 0, max_chunks_queued = 0;
  std::uint32_t errors = 0;  ///< lines that the library logged: what could not be read or made
  std::uint32_t validation_messages = 0;
};

/// Names of Statistics::pass_ms.
constexpr std::array kPassNames = {"upload", "cull",   "splats", "leaves", "tiles",    "shadows", "draw",
                                   "light",  "ground", "tufts",  "sky",    "tone_map", "temporal"};
static_assert(kPassNames.size() == std::tuple_size_v<decltype(Statistics::pass_ms)>);

struct FrameTimes {
  float median = 0;
  float p95 = 0;
  float p99 = 0;
  float max = 0;
};
/// Percentiles by nearest rank; all 0 for no frames.
FrameTimes summarize(const std::vector<float>& frame_ms);

std::string table(const Statistics& statistics);
/// The keys are a contract, listed in demo/README.md.
/// errors  Failure: the file cannot be written
void write_json(const std::string& file, const Statistics& statistics);

}  // namespace forest
