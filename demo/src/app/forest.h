#pragma once

#include <coppice/vulkan.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "device.h"
#include "log.h"
#include "options.h"
#include "placement.h"
#include "renderer.h"
#include "trace.h"

namespace forest {

struct ContextDestroyer {
  void operator()(coppice_context* context) const { coppice_context_destroy(context); }
};

/// The Coppice context and its open plants.
struct Forest {
  std::vector<std::string> files;  ///< per plant, of a scene per species
  std::unique_ptr<Log> log;
  std::unique_ptr<Trace> trace;  ///< null unless asked for
  std::unique_ptr<coppice_context, ContextDestroyer> context;
  std::array<coppice_view, kMaxPanes> views{};           ///< the picture, or its panes; 0: not there
  std::array<coppice_view, Shadows::kMaps> sun_views{};  ///< the shadow maps; 0 without them
  std::vector<coppice_plant> plants;
  std::vector<Species> species;                  ///< per plant
  glm::vec3 leaf_color = {0.07f, 0.12f, 0.03f};  ///< albedo, the mean over plants; a leaf's green of scenes, and where none has leaves
  coppice_scene scene = 0;
  coppice_scene_info scene_info{};  ///< the scene's, if there is one
};

/// The .coppice files to show: those of the command line, of folders by name; else every one in out/plants of the current folder, else
/// every one in `plants` beside the executable, by name. errors  Failure that says how to bake some: none found, or a plant that is not
/// baked
std::vector<std::string> find_plants(const Options& options);

/// errors  Failure: the device does not do, or a file cannot be opened (path and reason)
Forest open_forest(const Device& device, const std::vector<std::string>& files, const Options& options, PlantTargets targets);
/// The same with a scene instead. errors  Failure
Forest open_scene(const Device& device, const Options& options, PlantTargets targets);
void add_instances(Forest& forest, const Planting& planting, const Terrain& terrain);

/// What a camera that shows all is to see: the plant where there is one, else the square that they stand in.
Box box_of(const Forest& forest, const Planting& planting, const Terrain& terrain);

/// Shows files[file] as it is now; where that cannot be read, says so and keeps what was there.
void reload(Forest& forest, std::size_t file);

/// Throws a Failure with the reason that the library logged, or the call's name, unless the status is COPPICE_OK.
void check(const Forest& forest, coppice_status status, const char* call);
coppice_stats statistics_of(const Forest& forest);
/// Statistics of the picture, or of its left pane.
coppice_view_stats view_statistics_of(const Forest& forest);

struct CutSettings {
  float error_px = 2;
  std::uint32_t leaf_budget = 0;
  LodMode lod = LodMode::cut;
  DebugView view = DebugView::none;
};
/// pane: of the picture, which shows `view`
coppice_camera make_camera(const Forest& forest, std::size_t pane, const FrameView& view, const CutSettings& settings);
/// The other eye of a pair.
coppice_eye make_eye(const FrameView& view);
coppice_light make_light(const Weather& weather);

}  // namespace forest
