#include "forest.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <optional>
#include <system_error>
#include <utility>

#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "context_desc.h"
#include "failure.h"

namespace forest {
namespace {

/// Why a call failed: what the library logged, which names the file or the call; else `about` and the status.
std::string reason_of(const Forest& forest, coppice_status status, const std::string& about) {
  const std::string logged = take_reason(*forest.log);
  return logged.empty() ? about + ": " + coppice_status_text(status) : logged;
}

/// By name; none where there is no such folder.
std::vector<std::string> plants_in(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(folder, missing))
    if (entry.path().extension() == ".coppice") files.push_back(entry.path().string());
  std::ranges::sort(files);
  return files;
}

/// The plants of a folder, or the file itself. What a person takes for a baked plant gets a line that says what to do with it.
std::vector<std::string> plants_at(const std::string& path) {
  std::error_code missing;
  if (std::filesystem::is_directory(path, missing)) {
    std::vector<std::string> files = plants_in(path);
    if (files.empty())
      throw Failure(path + ": no .coppice file in it. coppice bake-all " + path + " -o baked bakes the plants of a folder");
    return files;
  }
  std::string extension = std::filesystem::path(path).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  if (extension == ".glb" || extension == ".gltf")
    throw Failure(path + ": not baked yet. coppice view " + path + " bakes and shows it; to keep the result: coppice bake " + path +
                  " -o " + std::filesystem::path(path).stem().string() + ".coppice");
  if (extension == ".forest") throw Failure(path + ": a scene. coppice-forest --scene " + path + " shows it");
  return {path};
}

coppice_plant open_plant(const Forest& forest, const std::string& file) {
  coppice_plant plant = 0;
  const coppice_status status = coppice_plant_open(forest.context.get(), file.c_str(), &plant);
  if (status == COPPICE_OK) return plant;
  std::error_code missing;
  const std::string reason = reason_of(forest, status, file);
  throw Failure(std::filesystem::exists(file, missing) ? reason : file + ": no such file");
}

Species species_of(const Forest& forest, coppice_plant plant) {
  coppice_plant_info info;
  coppice_plant_info_init(&info);
  check(forest, coppice_plant_get_info(forest.context.get(), plant, &info), "coppice_plant_get_info");
  Species species;
  species.radius_m = info.sphere_radius;
  std::memcpy(&species.box_min, info.box_min, sizeof species.box_min);
  std::memcpy(&species.box_max, info.box_max, sizeof species.box_max);
  // Roots go below the origin, and a plant may hang over; one that would hang in the air, or of which a quarter would be buried, was not
  // modelled to stand on its origin.
  const float low_m = info.box_min[1], height_m = info.box_max[1] - low_m;
  if (low_m > 0.02f * height_m || low_m < -0.25f * height_m) species.foot_m = low_m;
  return species;
}

/// How much the ground rises along x and z.
glm::vec2 slope_at(const Terrain& terrain, glm::vec2 at) {
  constexpr float kStep_m = 0.7f;
  const auto height = [&](float x, float z) { return height_at(terrain, at.x + x, at.y + z); };
  return glm::vec2(height(kStep_m, 0) - height(-kStep_m, 0), height(0, kStep_m) - height(0, -kStep_m)) / (2 * kStep_m);
}

coppice_placement placement_of(const PlacedPlant& plant, const Species& species, const Terrain& terrain) {
  coppice_placement placement;
  coppice_placement_init(&placement);
  // The lowest ground under the stem's foot, so that on a slope no root hangs in the air.
  const float foot_m = 0.06f * plant.crown_radius_m;
  float ground_m = height_at(terrain, plant.position.x, plant.position.y);
  for (int side = -1; side <= 1; side += 2) {
    const auto offset_m = static_cast<float>(side) * foot_m;
    ground_m = std::min({ground_m, height_at(terrain, plant.position.x + offset_m, plant.position.y),
                         height_at(terrain, plant.position.x, plant.position.y + offset_m)});
  }
  placement.position[0] = plant.position.x;
  placement.position[1] = ground_m - 0.02f - plant.scale * species.foot_m;
  placement.position[2] = plant.position.y;
  placement.scale = plant.mirrored ? -plant.scale : plant.scale;
  // Turned about its stem, which then leans.
  const glm::quat yaw = glm::angleAxis(plant.yaw_rad, glm::vec3(0, 1, 0));
  const glm::vec2 lean_rad = plant.lean_rad - plant.slope_share * slope_at(terrain, plant.position);
  const glm::quat lean = glm::quat(glm::vec3(lean_rad.y, 0, -lean_rad.x));
  const glm::quat half_turn = plant.mirrored ? glm::quat(0, 1, 0, 0) : glm::quat(1, 0, 0, 0);  // see coppice_placement.scale
  const glm::quat rotation = lean * yaw * half_turn;
  std::copy_n(glm::value_ptr(rotation), 4, placement.rotation);
  std::memcpy(placement.tint, &plant.tint, sizeof placement.tint);
  return placement;
}

/// Place along a Z-shaped curve through the unit square: near in code, near in place.
std::uint32_t morton_code(glm::vec2 place) {
  const auto spread = [](float value) {
    auto bits = static_cast<std::uint32_t>(std::clamp(value, 0.0f, 1.0f) * 65535);
    for (const auto& [shift, mask] : {std::pair{8u, 0x00ff00ffu}, {4u, 0x0f0f0f0fu}, {2u, 0x33333333u}, {1u, 0x55555555u}})
      bits = (bits | bits << shift) & mask;
    return bits;
  };
  return spread(place.x) | spread(place.y) << 1;
}

}  // namespace

std::vector<std::string> find_plants(const Options& options) {
  std::vector<std::string> files;
  for (const std::string& path : options.plants) {
    const std::vector<std::string> found = plants_at(path);
    files.insert(files.end(), found.begin(), found.end());
  }
  if (files.empty()) files = plants_in("out/plants");
  std::error_code missing;
  const std::filesystem::path executable = std::filesystem::read_symlink("/proc/self/exe", missing);
  if (files.empty() && !missing) files = plants_in(executable.parent_path() / "plants");
  if (files.empty())
    throw Failure(
        "no baked plants in out/plants. ./demo/run bakes three; by hand: coppice plant willow -o willow.glb && "
        "coppice bake willow.glb -o out/plants/willow.coppice");
  return files;
}

namespace {

coppice_view create_view(const Forest& forest, coppice_output output, coppice_vulkan_view_desc formats) {
  coppice_view_desc desc;
  coppice_view_desc_init(&desc);
  desc.output = output;
  formats.depth_format = Renderer::kDepthFormat;
  coppice_view view = 0;
  check(forest, coppice_vulkan_view_create(forest.context.get(), &desc, &formats, &view), "coppice_vulkan_view_create");
  return view;
}

coppice_view create_picture_view(const Forest& forest, PlantTargets targets) {
  coppice_vulkan_view_desc formats;
  coppice_vulkan_view_desc_init(&formats);
  std::size_t count = 0;
  const auto attach = [&](coppice_content content, VkFormat format) {
    formats.contents[count] = content;
    formats.color_formats[count++] = format;
  };
  if (targets.deferred) {
    attach(COPPICE_CONTENT_ALBEDO, Renderer::kAlbedoFormat);
    attach(COPPICE_CONTENT_NORMAL, Renderer::kNormalFormat);
    attach(COPPICE_CONTENT_LIGHT, Renderer::kLightFormat);
  } else {
    attach(COPPICE_CONTENT_LIT, Renderer::kSceneFormat);
  }
  if (targets.velocity) attach(COPPICE_CONTENT_VELOCITY, Renderer::kVelocityFormat);
  return create_view(forest, targets.deferred ? COPPICE_OUTPUT_SURFACE : COPPICE_OUTPUT_LIT, formats);
}

coppice_view create_map_view(const Forest& forest) {
  coppice_vulkan_view_desc formats;
  coppice_vulkan_view_desc_init(&formats);
  return create_view(forest, COPPICE_OUTPUT_DEPTH, formats);
}

Forest create_forest(const Device& device, const Options& options, PlantTargets targets, std::optional<std::uint32_t> max_instances) {
  Forest forest;
  forest.log = std::make_unique<Log>();
  coppice_vulkan_desc vulkan = desc_of(device);
  vulkan.compute_raster = options.path != LeafPath::hardware ? VK_TRUE : VK_FALSE;
  vulkan.pass_times = options.pass_times ? VK_TRUE : VK_FALSE;
  vulkan.blocking_pipelines = options.headless || options.frames ? VK_TRUE : VK_FALSE;  // frames that are counted miss nothing
  coppice_context_desc desc;
  coppice_context_desc_init(&desc);
  desc.memory_budget_bytes = std::uint64_t{options.memory_mb} << 20;
  desc.allow_outside = options.allow_outside ? COPPICE_TRUE : COPPICE_FALSE;
  if (max_instances) desc.max_instances = *max_instances;
  const coppice_log log = hook_of(*forest.log);
  desc.log = &log;
  coppice_trace trace;
  if (!options.trace.empty()) {
    forest.trace = std::make_unique<Trace>();
    trace = forest.trace->hook();
    desc.trace = &trace;
  }
  coppice_context* context = nullptr;
  const coppice_status status = coppice_vulkan_context_create(&desc, &vulkan, &context);
  forest.context.reset(context);
  check(forest, status, "coppice_vulkan_context_create");
  for (std::size_t pane = 0; pane < (options.split ? 2u : 1u); ++pane) forest.views[pane] = create_picture_view(forest, targets);
  const std::size_t maps = !options.shadows ? 0 : targets.deferred ? Shadows::kMaps : Shadows::kCascades;
  for (std::size_t map = 0; map < maps; ++map) forest.sun_views[map] = create_map_view(forest);
  return forest;
}

/// The mean over all plants with leaves of what their cards show from afar. A new context numbers files from 0, as they are opened.
void find_leaf_color(Forest& forest) {
  glm::vec3 sum(0);
  float plants = 0;
  for (std::uint32_t file = 0; file < forest.plants.size(); ++file) {
    coppice_file_info info;
    coppice_file_info_init(&info);
    check(forest, coppice_file_get_info(forest.context.get(), file, &info), "coppice_file_get_info");
    glm::vec3 of_plant(0);
    float covered = 0;
    for (std::uint32_t i = 0; i < info.card_count; ++i) {
      coppice_card card;
      coppice_card_init(&card);
      check(forest, coppice_file_get_card(forest.context.get(), file, i, &card), "coppice_file_get_card");
      of_plant += card.coverage * glm::make_vec3(card.albedo);
      covered += card.coverage;
    }
    if (covered <= 0) continue;
    sum += of_plant / covered;
    ++plants;
  }
  if (plants > 0) forest.leaf_color = sum / plants;
}

}  // namespace

Forest open_forest(const Device& device, const std::vector<std::string>& files, const Options& options, PlantTargets targets) {
  Forest forest = create_forest(device, options, targets, std::nullopt);
  forest.files = files;
  for (const std::string& file : files) {
    forest.plants.push_back(open_plant(forest, file));
    forest.species.push_back(species_of(forest, forest.plants.back()));
  }
  find_leaf_color(forest);
  return forest;
}

namespace {

coppice_scene_plant_info scene_plant(const Forest& forest, std::uint32_t species) {
  coppice_scene_plant_info info;
  coppice_scene_plant_info_init(&info);
  check(forest, coppice_scene_get_plant(forest.context.get(), forest.scene, species, &info), "coppice_scene_get_plant");
  return info;
}

template <class Eye>
void set_eye(const FrameView& view, Eye& eye) {
  std::copy_n(glm::value_ptr(view.view_from_world), 16, eye.view_from_world);
  std::copy_n(glm::value_ptr(view.clip_from_view), 16, eye.clip_from_view);
  eye.x_px = view.pane.offset.x;
  eye.y_px = view.pane.offset.y;
}

}  // namespace

Forest open_scene(const Device& device, const Options& options, PlantTargets targets) {
  Forest forest = create_forest(device, options, targets, options.most_instances);
  const coppice_status status = coppice_scene_open(forest.context.get(), options.scene.c_str(), nullptr, &forest.scene);
  if (status != COPPICE_OK) {
    std::error_code missing;
    const std::string reason = reason_of(forest, status, options.scene);
    throw Failure(std::filesystem::exists(options.scene, missing) ? reason : options.scene + ": no such file");
  }
  coppice_scene_info_init(&forest.scene_info);
  check(forest, coppice_scene_get_info(forest.context.get(), forest.scene, &forest.scene_info), "coppice_scene_get_info");
  for (std::uint32_t species = 0; species < forest.scene_info.species_count; ++species)
    forest.files.emplace_back(scene_plant(forest, species).path);
  return forest;
}

// Neighbours one after the other, so that what is out of view or far away is so in whole blocks.
void add_instances(Forest& forest, const Planting& planting, const Terrain& terrain) {
  std::vector<std::uint32_t> order(planting.plants.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<std::uint64_t> keys;
  for (const PlacedPlant& plant : planting.plants)
    keys.push_back(std::uint64_t{plant.species} << 32 |
                   morton_code((plant.position + planting.half_extent_m) / (2 * planting.half_extent_m)));
  std::ranges::sort(order, [&](auto a, auto b) { return keys[a] != keys[b] ? keys[a] < keys[b] : a < b; });
  std::vector<coppice_placement> placements;
  for (std::size_t next = 0, i = 0; i < forest.plants.size(); ++i) {
    placements.clear();
    for (; next < order.size() && planting.plants[order[next]].species == i; ++next)
      placements.push_back(placement_of(planting.plants[order[next]], forest.species[i], terrain));
    if (placements.empty()) continue;
    check(forest,
          coppice_instances_add(forest.context.get(), forest.plants[i], placements.data(), sizeof(coppice_placement),
                                static_cast<std::uint32_t>(placements.size()), nullptr),
          "coppice_instances_add");
  }
}

Box box_of(const Forest& forest, const Planting& planting, const Terrain& terrain) {
  if (planting.plants.size() == 1) {
    const PlacedPlant& plant = planting.plants.front();
    const Species& species = forest.species[plant.species];
    const coppice_placement placement = placement_of(plant, species, terrain);
    const glm::vec3 origin(placement.position[0], placement.position[1], placement.position[2]);
    return {origin + plant.scale * species.box_min, origin + plant.scale * species.box_max};
  }
  constexpr float kWidest_m = 1000, kTall_m = 20;  // what is beyond the haze; a tree
  const float half_m = std::min(planting.half_extent_m, kWidest_m), ground_m = height_at(terrain, 0, 0);
  return {{-half_m, ground_m, -half_m}, {half_m, ground_m + kTall_m, half_m}};
}

void reload(Forest& forest, std::size_t file) {
  const coppice_plant plant = forest.scene != 0 ? scene_plant(forest, static_cast<std::uint32_t>(file)).plant : forest.plants[file];
  if (plant == 0) return;  // a scene's plant that is not opened yet
  const coppice_status status = coppice_plant_reload(forest.context.get(), plant, nullptr);
  if (status == COPPICE_OK) return;
  std::fprintf(stderr, "coppice-forest: %s; what was there stays\n", reason_of(forest, status, forest.files[file]).c_str());
}

void check(const Forest& forest, coppice_status status, const char* call) {
  if (status == COPPICE_OK) return;
  const char* advice = status == COPPICE_ERROR_OUT_OF_MEMORY ? "; --memory-mb gives it more" : "";
  throw Failure(reason_of(forest, status, call) + advice);
}

coppice_stats statistics_of(const Forest& forest) {
  coppice_stats stats;
  coppice_stats_init(&stats);
  check(forest, coppice_get_stats(forest.context.get(), &stats), "coppice_get_stats");
  return stats;
}

coppice_view_stats view_statistics_of(const Forest& forest) {
  coppice_view_stats stats;
  coppice_view_stats_init(&stats);
  check(forest, coppice_get_view_stats(forest.context.get(), forest.views[0], &stats), "coppice_get_view_stats");
  return stats;
}

coppice_camera make_camera(const Forest& forest, std::size_t pane, const FrameView& view, const CutSettings& settings) {
  coppice_camera result;
  coppice_camera_init(&result);
  result.view = forest.views[pane];
  set_eye(view, result);
  result.width_px = view.pane.extent.width;
  result.height_px = view.pane.extent.height;
  result.error_px = settings.error_px;
  result.leaf_budget = settings.leaf_budget;
  result.lod = settings.lod == LodMode::full       ? COPPICE_LOD_FULL
               : settings.lod == LodMode::discrete ? COPPICE_LOD_DISCRETE
                                                   : COPPICE_LOD_CUT;
  result.debug_view = static_cast<coppice_debug_view>(settings.view);
  result.temporal_frame = view.temporal_frame;
  return result;
}

coppice_eye make_eye(const FrameView& view) {
  coppice_eye result;
  coppice_eye_init(&result);
  set_eye(view, result);
  return result;
}

coppice_light make_light(const Weather& weather) {
  coppice_light result;
  coppice_light_init(&result);
  const auto copy = [](float(&to)[3], const glm::vec3& from) { std::memcpy(to, &from, sizeof to); };
  copy(result.sun_direction, weather.sun_direction);
  copy(result.sun_color, weather.sun_color);
  copy(result.sky_color, weather.sky_color);
  copy(result.ground_color, weather.ground_color);
  copy(result.fog_color, weather.fog_color);
  result.fog_density = weather.fog_density;
  return result;
}

}  // namespace forest
