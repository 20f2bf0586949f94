// The scenes of the C API, their trees, and picking: checks arguments, translates, forwards. No logic.

#include <span>
#include <string>

#include "abi.h"
#include "api_call.h"
#include "api_checks.h"

namespace {

using coppice::HandleKind;
using coppice::gpu::PlacementRecords;
using Trees = std::span<const coppice_scene_tree>;

std::string scene_problem(const coppice_context& context, coppice_scene scene, const std::string& name = "scene") {
  if (context.context->is_scene(scene)) return {};
  const std::string problem = coppice::handle_problem(scene, HandleKind::scene, context.context->tag());
  return name + " " + (problem.empty() ? "has been closed" : problem);
}

/// placement: may be null; it is checked here
std::string read_pose(const coppice_context& context, const coppice_scene_placement* placement, coppice::gpu::Pose& pose) {
  auto at = coppice::struct_defaults<coppice_scene_placement>();
  const coppice::dvec3& origin = context.context->origin();
  if (placement != nullptr) {
    if (std::string problem = coppice::read_struct(placement, "placement", at); !problem.empty()) return problem;
    if (const std::string problem = coppice::scene_placement_problem(at, origin); !problem.empty()) return "placement." + problem;
  }
  pose = {coppice::dvec3(at.position) + origin, {at.rotation[0], at.rotation[1], at.rotation[2], at.rotation[3]}};
  return {};
}

/// name: of the argument
std::string tree_problem(const coppice_context& context, const coppice_scene_tree& tree, const std::string& name) {
  if (std::string problem = scene_problem(context, tree.scene, name + ".scene"); !problem.empty()) return problem;
  const std::string problem = context.context->scene(tree.scene)->tree_problem(tree);
  return problem.empty() ? "" : name + "." + problem;
}

/// rest: what happens to the other records, for the message
std::string trees_problem(const coppice_context& context, const coppice_scene_tree* trees, uint32_t count, const char* rest) {
  if (trees == nullptr) return count > 0 ? "trees is null" : "";
  for (uint32_t i = 0; i < count; ++i)
    if (const std::string problem = tree_problem(context, trees[i], "trees[" + std::to_string(i) + "]"); !problem.empty())
      return problem + rest;
  return {};
}

}  // namespace

coppice_status coppice_scene_open(coppice_context* context, const char* path, const coppice_scene_placement* placement,
                                  coppice_scene* scene) {
  if (scene != nullptr) *scene = 0;
  COPPICE_BEGIN_CALL(exclusive);
  if (path == nullptr || scene == nullptr) return call.refuse(path == nullptr ? "path is null" : "scene is null");
  if (!context->context->device_state()) return call.lost();
  coppice::gpu::Pose pose;
  COPPICE_REFUSE_IF(read_pose(*context, placement, pose));
  return finish_open(call, path, context->context->open_scene(path, pose), scene);
}

coppice_status coppice_scene_close(coppice_context* context, coppice_scene scene) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  context->context->close_scene(scene);
  return COPPICE_OK;
}

coppice_status coppice_scene_move(coppice_context* context, coppice_scene scene, const coppice_scene_placement* placement) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  COPPICE_REFUSE_IF(placement == nullptr ? "placement is null" : "");
  coppice::gpu::Pose pose;
  COPPICE_REFUSE_IF(read_pose(*context, placement, pose));
  context->context->scene(scene)->move(pose);
  return COPPICE_OK;
}

coppice_status coppice_scene_get_info(const coppice_context* context, coppice_scene scene, coppice_scene_info* info) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(info, "info"));
  auto ours = coppice::struct_defaults<coppice_scene_info>();
  context->context->scene(scene)->fill_info(ours);
  coppice::write_struct(ours, info);
  return COPPICE_OK;
}

coppice_status coppice_scene_get_plant(const coppice_context* context, coppice_scene scene, uint32_t species,
                                       coppice_scene_plant_info* info) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(info, "info"));
  auto ours = coppice::struct_defaults<coppice_scene_plant_info>();
  COPPICE_REFUSE_IF(
      context->context->scene(scene)->fill_info(species, ours) ? "" : "species " + std::to_string(species) + " is none of the scene's");
  coppice::write_struct(ours, info);
  return COPPICE_OK;
}

coppice_status coppice_scene_hide(coppice_context* context, const coppice_scene_tree* trees, uint32_t count) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(trees_problem(*context, trees, count, "; none was hidden"));
  return call.finish(context->context->change_trees(Trees(trees, count), {.state = COPPICE_TREE_HIDDEN}));
}

coppice_status coppice_scene_replace(coppice_context* context, const coppice_scene_tree* trees, coppice_plant plant,
                                     const coppice_placement* placements, size_t stride, uint32_t count) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(trees_problem(*context, trees, count, "; none was replaced"));
  if (plant != 0) COPPICE_REFUSE_IF(coppice::failed_plant_problem(*context, plant));
  const PlacementRecords records{placements, stride, count};
  COPPICE_REFUSE_IF(coppice::placements_problem(*context, records, "; none was replaced"));
  return call.finish(
      context->context->change_trees(Trees(trees, count), {.state = COPPICE_TREE_REPLACED, .plant = plant, .placements = records}));
}

coppice_status coppice_scene_restore(coppice_context* context, const coppice_scene_tree* trees, uint32_t count) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(trees_problem(*context, trees, count, "; none was restored"));
  return call.finish(context->context->change_trees(Trees(trees, count), {}));
}

coppice_status coppice_scene_query(const coppice_context* context, coppice_scene scene, const double* box_min, const double* box_max,
                                   coppice_scene_tree* trees, uint32_t capacity, uint32_t* count, uint32_t* missing_tiles) {
  if (count != nullptr) *count = 0;
  if (missing_tiles != nullptr) *missing_tiles = 0;
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(scene_problem(*context, scene));
  COPPICE_REFUSE_IF(coppice::box_problem(box_min, box_max));
  if (count == nullptr) return call.refuse("count is null");
  if (trees == nullptr && capacity > 0) return call.refuse("trees is null");
  coppice::TreeOutput out{.scene = scene, .trees = {trees, capacity}};
  context->context->query({{box_min[0], box_min[1], box_min[2]}, {box_max[0], box_max[1], box_max[2]}}, out);
  *count = out.count;
  if (missing_tiles != nullptr) *missing_tiles = out.missing_tiles;
  return COPPICE_OK;
}

coppice_status coppice_scene_get_tree(const coppice_context* context, const coppice_scene_tree* tree, coppice_tree_info* info) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(tree == nullptr ? "tree is null" : tree_problem(*context, *tree, "tree"));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(info, "info"));
  coppice::write_struct(context->context->tree_info(*tree), info);
  return COPPICE_OK;
}

coppice_status coppice_pick(const coppice_context* context, const coppice_ray* ray, coppice_hit* hit) {
  COPPICE_BEGIN_CALL(shared);
  coppice_ray ours;
  COPPICE_REFUSE_IF(coppice::read_struct(ray, "ray", ours));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(hit, "hit"));
  if (const std::string problem = coppice::ray_problem(ours); !problem.empty()) return call.refuse("ray." + problem);
  coppice::write_struct(context->context->pick(ours), hit);
  return COPPICE_OK;
}
