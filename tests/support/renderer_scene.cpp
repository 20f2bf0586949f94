#include "renderer_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "card_look.h"
#include "card_looks.h"
#include "convert.h"
#include "demand.h"
#include "hooks.h"
#include "normal_map.h"
#include "page_clusters.h"
#include "page_codec.h"

namespace coppice::test {
namespace {

template <class T>
T expect(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message());
  return *std::move(result);
}

void expect(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().message());
}

struct Box {
  glm::vec3 low{INFINITY}, high{-INFINITY};
};

Box leaf_box(const bake::Tree& tree) {
  Box box;
  for (const glm::vec3& vertex : tree.vertices) box = {glm::min(box.low, vertex), glm::max(box.high, vertex)};
  return box;
}

QuantisedPoint quantise(const glm::vec3& p, const Box& box) {
  QuantisedPoint q{};
  for (int axis = 0; axis < 3; ++axis)
    q[static_cast<std::size_t>(axis)] =
        static_cast<std::uint16_t>(std::lround((p[axis] - box.low[axis]) / (box.high[axis] - box.low[axis]) * COPPICE_QUANTISED_MAX));
  return q;
}

MadeMesh wood_mesh(const bake::Mesh& mesh) {
  MadeMesh wood;
  wood.indices = mesh.indices;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    wood.vertices.push_back({{mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z},
                             {mesh.normals[i].x, mesh.normals[i].y, mesh.normals[i].z},
                             {mesh.uvs[i].x, mesh.uvs[i].y},
                             0,
                             {}});
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) wood.vertices[mesh.indices[i]].material = mesh.triangle_materials[i / 3];
  return wood;
}

void fill_front(const bake::BakedPlant& baked, const Box& box, PlantFile& file) {
  coppice_file_plant& plant = file.plant;
  plant.leaf_count = baked.tree.leaf_count();
  plant.page_count = (plant.leaf_count - 1 + COPPICE_PAGE_SPLITS - 1) / COPPICE_PAGE_SPLITS;
  plant.material_count = static_cast<std::uint32_t>(baked.materials.size());
  plant.card_count = static_cast<std::uint32_t>(baked.card_table.size());
  plant.texture_count = static_cast<std::uint32_t>(baked.images.size());
  plant.wood_lod_count = static_cast<std::uint32_t>(baked.wood.lods.size());
  plant.error_level_count = static_cast<std::uint32_t>(baked.errors.leaf_counts.size());
  plant.error_size_count = static_cast<std::uint32_t>(baked.errors.sizes_px.size());
  for (int axis = 0; axis < 3; ++axis) {
    plant.leaf_box_min[axis] = box.low[axis];
    plant.leaf_box_max[axis] = box.high[axis];
    plant.sphere_center[axis] = 0.5f * (box.low[axis] + box.high[axis]);
  }
  plant.sphere_radius = 0.5f * glm::length(box.high - box.low);
  std::vector<coppice_file_material> materials;
  for (const bake::Material& material : baked.materials) {
    coppice_file_material& converted = materials.emplace_back();
    for (int channel = 0; channel < 4; ++channel) converted.base_color[channel] = material.base_color[channel];
    converted.alpha_cutoff = material.alpha_cutoff;
    converted.roughness = material.roughness;
    set_material_textures(converted, material.image == bake::kNone ? COPPICE_NO_TEXTURE : material.image,
                          material.normal_map == bake::kNone ? COPPICE_NO_TEXTURE : material.normal_map);
    converted.flags = material.sided_normals ? COPPICE_MATERIAL_SIDED_NORMALS : 0u;
  }
  file.materials = hook_array(materials);
  std::vector<coppice_file_card> cards;
  for (const bake::Card& card : baked.card_table) {
    coppice_file_card converted{.material = card.material, .uv = {}};
    for (std::size_t i = 0; i < 4; ++i) {
      converted.uv[i][0] = card.uv[i].x;
      converted.uv[i][1] = card.uv[i].y;
    }
    cards.push_back(converted);
  }
  file.cards = hook_array(cards);
  file.error_leaf_counts = hook_array(baked.errors.leaf_counts);
  file.error_sizes_px = hook_array(baked.errors.sizes_px);
  file.error_px = hook_array(baked.errors.error_px);
  file.wind = baked.wind.head;
  file.wind_nodes = hook_array(baked.wind.nodes);
  plant.leaf_mesh_count = static_cast<std::uint16_t>(baked.leaf_meshes.parts.size());
  file.leaf_mesh_error_px = hook_array(baked.leaf_meshes.error_px);
  file.wood_error_px = hook_array(baked.wood.error_px);
  for (std::size_t lod = 0; lod < baked.wood.lods.size(); ++lod)
    plant.wood_triangle_counts[lod] = static_cast<std::uint32_t>(baked.wood.lods[lod].triangle_materials.size());
}

}  // namespace

DecodedPlant decoded_plant(const bake::BakedPlant& baked) {
  DecodedPlant plant;
  const Box box = leaf_box(baked.tree);
  fill_front(baked, box, plant.file);
  for (std::size_t id = 0; id < baked.tree.nodes.size(); ++id) {
    PageNode node{.card = static_cast<std::uint8_t>(baked.tree.nodes[id].card),
                  .opacity = baked.tree.nodes[id].opacity,
                  .split = baked.tree.node_split[id],
                  .normals = baked.tree.nodes[id].normals};
    for (std::size_t corner = 0; corner < 4; ++corner)
      node.corners[corner] = quantise(baked.tree.vertices[baked.tree.nodes[id].vertices[corner]], box);
    plant.nodes.push_back(node);
  }
  const PageNode& root = plant.nodes[0];
  for (std::size_t corner = 0; corner < 4; ++corner) std::copy_n(root.corners[corner].begin(), 3, plant.file.plant.root_quad[corner]);
  plant.file.plant.root_card = root.card;
  plant.file.plant.root_opacity = root.opacity;
  plant.file.plant.root_normals = root.normals;
  for (const bake::Mesh& lod : baked.wood.lods) plant.wood.push_back(wood_mesh(lod));
  std::vector<coppice_file_texture> headers;
  for (const bake::Image& baked_image : baked.images) {
    const bake::Image image = baked_image.is_normal_map ? bake::stored_normal_map(baked_image) : baked_image;
    const coppice_file_texture header{image.width, image.height, 1, 1};
    std::vector<std::uint8_t> chunk(sizeof header + image.rgba.size());
    std::memcpy(chunk.data(), &header, sizeof header);
    std::ranges::copy(image.rgba, chunk.begin() + sizeof header);
    headers.push_back(header);
    plant.textures.push_back(std::move(chunk));
  }
  plant.file.textures = hook_array(headers);
  plant.file.small_textures = hook_arrays(plant.textures);
  plant.file.plant.texture_count = static_cast<std::uint32_t>(plant.textures.size());
  for (coppice_file_card& card : plant.file.cards)
    bake::set_card_look(plant.file.materials[card.material], plant.textures, bake::kAllShown, card);
  for (const bake::LeafMeshPart& part : baked.leaf_meshes.parts) {
    plant.leaf_meshes.push_back(wood_mesh(part.mesh));
    for (std::size_t i = 0; i < part.stalks.size(); ++i) plant.leaf_meshes.back().vertices[i].stalk = quantise(part.stalks[i], box);
  }
  const auto lod_words = expect(pack_lod_table(plant.file, default_allocator()));
  plant.lod_words.assign(lod_words.begin(), lod_words.end());
  return plant;
}

Shot make_view(const CameraDesc& camera) {
  Shot view{};
  view.struct_size = sizeof(coppice_camera);
  view.light.struct_size = sizeof(coppice_light);
  view.light.shadow_map_bytes = sizeof(coppice_shadow_map);
  view.view = camera.view;
  view.error_px = camera.error_px;
  view.lod = camera.lod;
  view.width_px = camera.width_px;
  view.height_px = camera.height_px != 0 ? camera.height_px : camera.width_px;
  std::ranges::fill(view.light.sun_color, 3.0f);
  std::ranges::fill(view.light.sky_color, 0.6f);
  std::ranges::fill(view.light.ground_color, 0.2f);
  const glm::mat4 view_from_world = glm::lookAt(camera.eye_m, camera.target_m, glm::vec3(0.0f, 1.0f, 0.0f));
  const float focal = 1.0f / std::tan(0.5f * camera.vertical_fov_radians);
  constexpr float kNearM = 0.05f;
  glm::mat4 clip_from_view(0.0f);
  clip_from_view[0][0] = focal * static_cast<float>(view.height_px) / static_cast<float>(view.width_px);
  clip_from_view[1][1] = -focal;
  clip_from_view[2][3] = -1.0f;
  clip_from_view[3][2] = kNearM;
  std::copy_n(glm::value_ptr(view_from_world), 16, view.view_from_world);
  std::copy_n(glm::value_ptr(clip_from_view), 16, view.clip_from_view);
  view.layer_mask = COPPICE_ALL_LAYERS;
  const glm::vec3 sun = glm::normalize(glm::vec3(0.5f, 0.6f, 0.6f));
  std::copy_n(&sun.x, 3, view.light.sun_direction);
  return view;
}

RendererScene::RendererScene(const VulkanDevice& gpu, std::uint32_t max_instances, const SceneOptions& options)
    : gpu_(gpu),
      frames_may_fail_(options.allocate_memory != nullptr),
      clear_depth_(options.depth_compare == VK_COMPARE_OP_LESS || options.depth_compare == VK_COMPARE_OP_LESS_OR_EQUAL ? 1.0f : 0.0f) {
  constexpr std::uint32_t kMaxPlants = 8;
  gpu::Device device = expect(gpu::open_device(gpu.instance, gpu.physical_device, gpu.device, vkGetInstanceProcAddr));
  device.draw_counts = options.int64_atomics && gpu.draw_indirect_count;
  device.memory.ledger = &ledger_;
  if (options.allocate_memory != nullptr) device.vk.vkAllocateMemory = options.allocate_memory;
  renderer_ = expect(gpu::Renderer::create({.device = device,
                                            .allocator = default_allocator(),
                                            .views = {.max_instances = max_instances,
                                                      .compute_raster = options.compute_raster,
                                                      .int64_atomics = options.int64_atomics && gpu.int64_atomics,
                                                      .many_lanes = options.many_lanes},
                                            .pipeline_cache = gpu.pipeline_cache,
                                            .memory_budget_bytes = options.memory_budget_bytes,
                                            .max_plants = kMaxPlants}));
  view_ = expect(renderer_->add_view({.color_formats = {VK_FORMAT_R8G8B8A8_SRGB},
                                      .color_count = 1,
                                      .contents = {COPPICE_CONTENT_LIT},
                                      .depth_format = VK_FORMAT_D32_SFLOAT,
                                      .depth_compare = options.depth_compare}));
  instances_ = gpu::InstanceTable(default_allocator(), max_instances);
  expect(instances_.reserve_plants(kMaxPlants));
  lod_plants_.resize(kMaxPlants);
}

namespace {

std::uint32_t page_node_count(const DecodedPlant& plant, std::uint32_t page) {
  return 2 * page_split_count(plant.file.plant.leaf_count, page);
}

}  // namespace

std::uint32_t RendererScene::add_plant(const DecodedPlant& plant, std::uint32_t page_count) {
  const std::uint32_t index = plant_count_++;
  gpu::PlantLooks looks = expect(gpu::plant_looks(plant.file, default_allocator()));
  gpu::CrownLight light;
  if (plant.file.plant.page_count > 0)
    light = gpu::measure_crown({plant.nodes[0], std::span(plant.nodes).subspan(1, page_node_count(plant, 0)), looks.cards(),
                                gpu::leaf_box(gpu::gpu_plant(plant.file.plant))});
  expect(renderer_->add_plant(index, plant.file, {looks, light}, plant.lod_words));
  instances_.set_plant_sphere(index, plant.file.plant.sphere_center, plant.file.plant.sphere_radius);
  pending_.push_back({index, plant, std::min(page_count, plant.file.plant.page_count), std::move(looks), light});
  return index;
}

void RendererScene::place(std::uint32_t plant, const std::vector<coppice_placement>& placements) {
  expect(instances_.add(plant, placements, {}));
  expect(renderer_->reserve({.slots = instances_.capacity()}));
}

void RendererScene::upload_plant(const Pending& pending) {
  const DecodedPlant& plant = pending.plant;
  const std::uint32_t index = pending.index;
  const gpu::LeafSource source{root_node(plant.file.plant), pending.looks.cards(), gpu::leaf_box(gpu::gpu_plant(plant.file.plant)),
                               &pending.light, plant.file.plant.leaf_count};
  const auto scratch = std::make_unique<gpu::ClusterScratch>();
  gpu::ReadyCuts cuts;
  for (std::uint32_t page = 0; page < pending.page_count; ++page) {
    const std::uint32_t count = page_node_count(plant, page);
    const std::span<const PageNode> nodes = std::span(plant.nodes).subspan(2 * COPPICE_PAGE_SPLITS * page + 1, count);
    if (page == 0) {
      expect(allocate_into(cuts.bytes, default_allocator(), gpu::ready_cut_bytes(source.leaf_count)));
      gpu::build_ready_cuts(source, nodes, *scratch, cuts);
    }
    std::vector<std::uint8_t> clusters(gpu::kPageBytes);
    gpu::build_page(source, page, nodes, *scratch, clusters);
    expect(renderer_->upload_page({.plant = index, .page = page, .clusters = clusters, .ready_cuts = &cuts}));
    lod_plants_[index].resident_leaf_count = page * COPPICE_PAGE_SPLITS + count / 2 + 1;
  }
  if (pending.page_count == 0) return;
  const auto upload_mesh = [&](gpu::MeshKind kind, std::uint32_t mesh, const WoodSpan& decoded) {
    const gpu::MeshSource meshes{{pending.looks, pending.light}, source.box, renderer_->has_raster()};
    gpu::MeshBlock block = expect(gpu::build_mesh(kind, decoded, meshes, default_allocator()));
    expect(renderer_->upload_mesh({.plant = index, .mesh = mesh, .block = &block}));
  };
  for (std::uint32_t lod = 0; lod < plant.wood.size(); ++lod) {
    if (plant.wood[lod].indices.empty()) continue;
    upload_mesh(gpu::MeshKind::wood, lod, plant.wood[lod]);
    lod_plants_[index].resident_wood_mask |= 1u << lod;
  }
  for (std::uint32_t texture = 0; texture < plant.textures.size(); ++texture)
    expect(renderer_->upload_texture(index, texture, plant.textures[texture]));
  for (std::uint32_t mesh = 0; mesh < plant.leaf_meshes.size(); ++mesh)
    upload_mesh(gpu::MeshKind::leaves, gpu::kMaxWoodLods + mesh, plant.leaf_meshes[mesh]);
  lod_plants_[index].leaf_meshes_resident = !plant.leaf_meshes.empty();
}

void RendererScene::upload(VkCommandBuffer cmd) {
  renderer_->record_upload_begin(cmd);
  for (const Pending& pending : pending_) upload_plant(pending);
  pending_.clear();
  const auto ended = renderer_->record_upload_end(instances_, lod_plants_);
  upload_failed_ = !ended;
  if (!frames_may_fail_) expect(ended);
}

Picture draw_on_white(const VulkanDevice& gpu, const Shot& view, const std::function<void(VkCommandBuffer)>& before,
                      const std::function<void(VkCommandBuffer)>& inside, float clear_depth) {
  const Image color(gpu, color_attachment(view.width_px, view.height_px)), depth(gpu, depth_attachment(view.width_px, view.height_px));
  submit(gpu, [&](VkCommandBuffer cmd) {
    before(cmd);
    begin_rendering(cmd, {.colors = {&color}, .depth = &depth, .farthest = {clear_depth, 0}});
    inside(cmd);
    vkCmdEndRendering(cmd);
  });
  return read_picture(gpu, color);
}

void RendererScene::begin_frame(std::uint32_t view, const Shot& shot) {
  renderer_->begin_frame(frame_ + 1, frame_);
  ++frame_;
  renderer_->view(view).show({shot, expect(demand_view(shot))});
}

void RendererScene::record_selection(VkCommandBuffer cmd, std::uint32_t view, const Shot& shot) {
  upload(cmd);
  if (!renderer_->can_cull()) return renderer_->view(view).leave_out();
  renderer_->view(view).record_cull(cmd, shot.light);
  full_barrier(cmd);
}

std::vector<float> RendererScene::select(const Shot& view) {
  std::vector<float> cuts(instances_.slots().size());
  const VkBufferCopy region{0, 0, cuts.size() * sizeof(float)};
  const Buffer copy(gpu_, region.size, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  begin_frame(view_, view);
  submit(gpu_, [&](VkCommandBuffer cmd) {
    record_selection(cmd, view_, view);
    vkCmdCopyBuffer(cmd, renderer_->view(view_).cut_buffer(), copy.handle(), 1, &region);
  });
  std::memcpy(cuts.data(), copy.mapped(), region.size);
  return cuts;
}

RendererScene::Frame RendererScene::draw(const Shot& view) {
  Frame frame;
  begin_frame(view_, view);
  frame.picture = draw_on_white(
      gpu_, view, [&](VkCommandBuffer cmd) { record_selection(cmd, view_, view); },
      [&](VkCommandBuffer cmd) { renderer_->view(view_).record_draw(cmd, 0); }, clear_depth_);
  renderer_->begin_frame(frame_ + 1, frame_);
  ++frame_;
  frame.counts = renderer_->view(view_).counts();
  return frame;
}

std::vector<float> RendererScene::draw_depth(const Shot& view) {
  const Image depth(gpu_, depth_attachment(view.width_px, view.height_px));
  if (!depth_view_) depth_view_ = expect(renderer_->add_view({.depth_format = VK_FORMAT_D32_SFLOAT}));
  begin_frame(*depth_view_, view);
  submit(gpu_, [&](VkCommandBuffer cmd) {
    record_selection(cmd, *depth_view_, view);
    begin_rendering(cmd, {.depth = &depth});
    renderer_->view(*depth_view_).record_draw(cmd, 0);
    vkCmdEndRendering(cmd);
  });
  return read_floats(gpu_, depth);
}

}  // namespace coppice::test
