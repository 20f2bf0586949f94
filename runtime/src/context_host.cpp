// A context's functions for hosts that draw themselves: changes, draws, and the appearance of plants.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>

#include "check.h"
#include "context.h"
#include "convert.h"
#include "coppice_light.h"
#include "cut_nodes.h"
#include "leaf_writer.h"
#include "page_codec.h"

namespace coppice {
namespace {

static_assert(sizeof(coppice_leaf_node) == sizeof(PageNode) && offsetof(coppice_leaf_node, corners) == offsetof(PageNode, corners) &&
              offsetof(coppice_leaf_node, card) == offsetof(PageNode, card) &&
              offsetof(coppice_leaf_node, opacity) == offsetof(PageNode, opacity) &&
              offsetof(coppice_leaf_node, split) == offsetof(PageNode, split) &&
              offsetof(coppice_leaf_node, normals) == offsetof(PageNode, normals) && kNeverReplaced == lod::kCoppiceNoSplit);

std::uint32_t texture_or_none(std::uint32_t texture) {
  return texture == COPPICE_NO_TEXTURE ? COPPICE_NONE : texture;
}

/// Fills the fields that depend on the kind of chunk. file: its plant's
void describe_bytes(const DecodedChunk& chunk, const PlantFile& file, coppice_change& change) {
  const std::uint32_t index = chunk.id.index;
  const auto describe = [&change](std::span<const std::uint8_t> bytes) {
    change.bytes = bytes.data();
    change.byte_count = bytes.size();
  };
  if (chunk.id.kind == ChunkKind::page) {
    change.bytes = chunk.nodes.data();
    change.byte_count = chunk.nodes.size_bytes();
    change.first_node = chunk.first_node;
    change.node_count = static_cast<std::uint32_t>(chunk.nodes.size());
  } else if (chunk.id.kind == ChunkKind::texture) {
    coppice_file_texture texture{};
    std::memcpy(&texture, chunk.texture.data(), sizeof texture);
    describe(chunk.texture.subspan(sizeof texture));
    change.texture_format = texture.format;
    change.width = texture.width;
    change.height = texture.height;
    change.mip_count = texture.mip_count;
  } else {
    describe(chunk.mesh->bytes.span());
    change.index_count = chunk.mesh->index_count;
    change.vertex_count = chunk.id.kind == ChunkKind::wood ? file.plant.wood_vertex_counts[index] : file.leaf_meshes[index].vertex_count;
  }
}

/// Without the bytes of an added chunk.
coppice_change change_of(const BackendEvent& event) {
  return {.struct_size = sizeof(coppice_change),
          .kind = event.kind,
          .plant = event.plant,
          .file = event.chunk.plant,
          .chunk = static_cast<coppice_streamed>(event.chunk.kind),
          .index = event.chunk.index};
}

/// Finds the instances that a view sees, first by blocks and then one by one, as the shaders do. Calls take(slot), in order, for each
/// instance of the view's layers whose sphere, enlarged by the motion of wind, reaches into the view.
template <class Take>
void for_each_visible(const InstanceBlocks& instances, const LodView& view, const Take& take) {
  for (std::size_t block = 0; block < instances.bounds.size(); ++block) {
    const InstanceBounds& bounds = instances.bounds[block];
    if (bounds.radius_m < 0.0f || (bounds.any_layer & view.layer_mask) == 0) continue;
    const float block_depth_m = depth_in_view(view, bounds.center_m);
    const float block_reach_m = bounds.radius_m + wind_reach_m(view, bounds.max_instance_radius_m);
    if (block_depth_m < -block_reach_m) continue;
    const bool whole = block_depth_m >= block_reach_m;
    const std::size_t first = block * kInstanceBlockSlots, end = std::min(first + kInstanceBlockSlots, instances.slots.size());
    for (std::size_t slot = first; slot < end; ++slot) {
      const InstanceSphere& sphere = instances.slots[slot];
      if (sphere.plant == InstanceSphere::kNoPlant || (sphere.layer_mask & view.layer_mask) == 0) continue;
      const float reach_m = sphere.radius_m + wind_reach_m(view, sphere.radius_m);
      if (whole || depth_in_view(view, sphere.center_m) >= -reach_m) take(static_cast<std::uint32_t>(slot));
    }
  }
}

}  // namespace

coppice_change Context::next_change() {
  COPPICE_ASSERT(renderer() == nullptr);
  if (const auto event = backend_->next_event()) return change_of(*event);
  const auto added = streamer_->next_pending();
  if (!added) return {.struct_size = sizeof(coppice_change)};
  coppice_change change = change_of({COPPICE_CHANGE_CHUNK_ADDED, slots_[added->id.plant].plant, added->id});
  describe_bytes(*added, file(added->id.plant), change);
  return change;
}

Result<void> Context::acknowledge(ChunkId id, coppice_outcome outcome) {
  COPPICE_ASSERT(renderer() == nullptr);
  const Streamer::Pending needed = outcome == COPPICE_OUTCOME_FREED ? Streamer::Pending::dropped : Streamer::Pending::added;
  if (const Streamer::Pending pending = streamer_->pending(id); pending != needed)
    return Error{
        Status::invalid_argument,
        pending == Streamer::Pending::no      ? "change: waits for no confirmation, it has come already or the chunk was never handed out"
        : pending == Streamer::Pending::added ? "change: was added, and waits for COPPICE_OUTCOME_TAKEN or FAILED"
                                              : "change: was dropped, and waits for COPPICE_OUTCOME_FREED",
        Error::kNoOffset, std::string(chunk_kind_name(id.kind)) + " " + std::to_string(id.index) + " of file " + std::to_string(id.plant)};
  if (outcome == COPPICE_OUTCOME_FREED)
    streamer_->acknowledge_freed(id);
  else if (outcome == COPPICE_OUTCOME_TAKEN)
    streamer_->acknowledge_taken(id);
  else
    streamer_->acknowledge_refused(id);
  if (slots_[id.plant].open) note_residency(id.plant);
  return {};
}

coppice_file_info Context::file_info(std::uint32_t index) const {
  const PlantFile& of = file(index);
  coppice_file_info info{.struct_size = sizeof(coppice_file_info)};
  info.leaf_count = of.plant.leaf_count;
  info.page_count = of.plant.page_count;
  info.wood_lod_count = of.plant.wood_lod_count;
  info.leaf_mesh_count = of.plant.leaf_mesh_count;
  info.texture_count = of.plant.texture_count;
  info.material_count = static_cast<std::uint32_t>(of.materials.size());
  info.card_count = static_cast<std::uint32_t>(of.cards.size());
  const gpu::Plant plant = gpu::gpu_plant(of.plant);
  std::memcpy(info.box_min, &plant.box_min, sizeof info.box_min);
  std::memcpy(info.box_step, &plant.box_step, sizeof info.box_step);
  std::copy_n(of.plant.sphere_center, 3, info.sphere_center);
  info.sphere_radius = of.plant.sphere_radius;
  const PageNode root = root_node(of.plant);
  std::memcpy(&info.root, &root, sizeof info.root);
  return info;
}

coppice_material Context::material(std::uint32_t index, std::uint32_t material) const {
  const coppice_file_material& of = file(index).materials[material];
  coppice_material info{.struct_size = sizeof(coppice_material)};
  std::copy_n(of.base_color, 4, info.base_color);
  info.alpha_cutoff = of.alpha_cutoff;
  info.roughness = of.roughness;
  info.sided_normals = (of.flags & COPPICE_MATERIAL_SIDED_NORMALS) != 0 ? COPPICE_TRUE : COPPICE_FALSE;
  info.texture = texture_or_none(material_texture(of));
  info.normal_map = texture_or_none(material_normal_map(of));
  return info;
}

coppice_card Context::card(std::uint32_t index, std::uint32_t card) const {
  const coppice_file_card& of = file(index).cards[card];
  const gpu::CardLook& look = streamer_->appearance(index).looks.cards()[card];
  coppice_card info{.struct_size = sizeof(coppice_card)};
  info.material = of.material;
  std::memcpy(info.uv, of.uv, sizeof info.uv);
  std::memcpy(info.albedo, &look.albedo, sizeof info.albedo);
  info.coverage = look.coverage;
  return info;
}

std::uint32_t Context::draws(coppice_view view, const DrawOutput& out) {
  ViewEntry& of = entry_of_view(view);
  const std::span<const gpu::Instance> instances = instances_.slots();
  const InstanceBlocks blocks = instances_.blocks();
  ViewCounts counts;
  counts.frame = frame_number_;
  const bool in_place = out.draw_bytes >= sizeof(coppice_draw) && out.draw_bytes % alignof(coppice_draw) == 0 &&
                        reinterpret_cast<std::uintptr_t>(out.draws) % alignof(coppice_draw) == 0;
  const auto take = [&](std::uint32_t slot) {
    const gpu::Instance& instance = instances[slot];
    const std::uint32_t plant_slot = plant_of(instance);
    if (plant_slot == gpu::kNoPlant) return;
    const LodPlant& plant = lod_plants_[plant_slot];
    const InstanceLod lod = select_lod(blocks.slots[slot], seed_of(instance), plant, of.shown);
    const PlantFile& of_plant = file(plant_slot);
    const std::uint32_t leaves = lod.leaf_meshes ? 0 : std::min(lod::coppice_whole_leaf_count(lod.leaf_count), plant.resident_leaf_count);
    const bool wood = lod.wood_lod < plant.table.wood_lod_count;
    counts.leaves += leaves;
    if (wood) counts.wood_triangles += of_plant.plant.wood_triangle_counts[lod.wood_lod];
    if (lod.leaf_meshes) {
      ++counts.leaf_mesh_instances;
      for (const coppice_file_leaf_mesh& mesh : of_plant.leaf_meshes) counts.leaf_mesh_triangles += mesh.triangle_count;
    }
    const std::uint32_t index = counts.visible_instances++;
    if (index >= out.capacity) return;
    // Writes directly to the program's memory: a copy would wait for data that was just written.
    unsigned char* theirs = reinterpret_cast<unsigned char*>(out.draws) + std::size_t{index} * out.draw_bytes;
    coppice_draw shorter;
    coppice_draw& draw = in_place ? *reinterpret_cast<coppice_draw*>(theirs) : shorter;
    draw.plant = slots_[plant_slot].plant;
    draw.instance = instances_.handle_at(slot);
    draw.tree = tree_at(slot);
    draw.file = plant_slot;
    draw.leaf_count = lod.leaf_meshes ? 0.0f : lod.leaf_count;
    draw.node_end = leaves > 0 ? 2 * leaves - 1 : 0;
    draw.wood_lod = wood ? lod.wood_lod : COPPICE_NONE;
    draw.leaf_meshes = lod.leaf_meshes ? COPPICE_TRUE : COPPICE_FALSE;
    draw.user_data = instance.user_data;
    const dvec3 position = place_of(instance) - origin();
    std::memcpy(draw.position, &position, sizeof draw.position);
    draw.scale = gpu::signed_scale(instance) * instances_.grown_share_at(slot);
    std::memcpy(draw.rotation, &instance.rotation, sizeof draw.rotation);
    const vec3 tint = gpu::tint_of(instance);
    std::memcpy(draw.tint, &tint, sizeof draw.tint);
    draw.leaf_share = gpu::leaf_share_of(instance);
    draw.reserved = 0;
    if (!in_place) std::memcpy(theirs, &shorter, std::min<std::size_t>(sizeof shorter, out.draw_bytes));
    if (out.draw_bytes > sizeof draw) std::memset(theirs + sizeof draw, 0, out.draw_bytes - sizeof draw);
  };
  for_each_visible(blocks, of.shown, take);
  of.counts = counts;
  return counts.visible_instances;
}

std::uint32_t Context::whole_cut(std::uint32_t index, float leaf_count) const {
  return std::min(lod::coppice_whole_leaf_count(leaf_count), streamer_->state(index).resident_leaf_count);
}

void Context::write_leaves(std::uint32_t index, std::uint32_t leaf_count, const coppice_leaf_layout& layout,
                           const coppice_leaf_output& output) const {
  const PlantFile& of = file(index);
  LeafWriter writer(of, gpu::leaf_box(gpu::gpu_plant(of.plant)), layout, output);
  for_each_leaf(*streamer_, index, leaf_count, [&writer](const PageNode& node) { writer.write(node); });
}

}  // namespace coppice
