// A context's scenes, and the trees in them.

#include <algorithm>
#include <utility>

#include "context.h"
#include "handle.h"

namespace coppice {

Result<coppice_scene> Context::open_scene(const char* path, const gpu::Pose& pose) {
  const auto entry = std::ranges::find_if(scenes_, [](const SceneEntry& each) { return each.scene == nullptr; });
  if (entry == scenes_.end()) {
    log_line(log(), COPPICE_LOG_ERROR, "%s: COPPICE_MAX_SCENES are open", path);
    return Error{Status::out_of_memory, "COPPICE_MAX_SCENES are open"};
  }
  const auto index = static_cast<std::uint32_t>(entry - scenes_.begin());
  COPPICE_CHECK(move_into(entry->scene, OpenScene::open(*this, index, path, pose)));
  ++entry->generation;
  return scene_handle(index);
}

coppice_scene Context::scene_handle(std::uint32_t index) const {
  return pack_handle({HandleKind::scene, tag_, scenes_[index].generation, index});
}

bool Context::is_scene(coppice_scene scene) const {
  const std::uint32_t index = unpack_handle(scene).index;
  return index < scenes_.size() && scenes_[index].scene != nullptr && scene == scene_handle(index);
}

void Context::close_scene(coppice_scene scene) {
  std::unique_ptr<OpenScene>& closed = scenes_[unpack_handle(scene).index].scene;
  closed->close();
  closed.reset();
}

std::uint32_t Context::usable_slot(coppice_plant plant) const {
  return plant != 0 && is_open(plant) && plant_state(plant) != COPPICE_PLANT_FAILED ? plant_slot(plant) : gpu::kNoPlant;
}

coppice_plant Context::plant_at(std::uint32_t slot) const {
  return slot == gpu::kNoPlant ? 0 : slots_[slot].plant;
}

coppice_scene_tree Context::tree_at(std::uint32_t slot) const {
  const gpu::TileMember member = instances_.member_at(slot);
  if (member.tile == gpu::TileMember::kNoTile) return {};
  const OpenScene::TileName name = OpenScene::tile_name(member.tile);
  return {scene_handle(name.scene), name.tile, member.number};
}

Result<void> Context::change_trees(std::span<const coppice_scene_tree> trees, const TreeEdit& edit) {
  // Reserves memory in all scenes before it changes one.
  if (edit.state != COPPICE_TREE_AS_IN_FILE)
    for (std::uint32_t i = 0; i < scenes_.size(); ++i) {
      const auto count = std::ranges::count(trees, scene_handle(i), &coppice_scene_tree::scene);
      if (scenes_[i].scene && count > 0) COPPICE_CHECK(scenes_[i].scene->reserve_changes(static_cast<std::size_t>(count)));
    }
  for (std::uint32_t i = 0; i < scenes_.size(); ++i)
    if (scenes_[i].scene) scenes_[i].scene->change_trees(scene_handle(i), trees, edit);
  return {};
}

void Context::query(const WorldBox& box, TreeOutput& out) const {
  scene(out.scene)->query({box.low + origin(), box.high + origin()}, out);
}

coppice_tree_info Context::tree_info(const coppice_scene_tree& tree) const {
  coppice_tree_info info = scene(tree.scene)->tree_info(tree.tile, tree.number);
  if (info.plant == 0) return info;
  for (std::size_t axis = 0; axis < 3; ++axis) info.placement.position[axis] -= origin()[axis];
  return info;
}

}  // namespace coppice
