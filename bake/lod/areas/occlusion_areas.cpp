#include "occlusion_areas.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include <glm/matrix.hpp>

#include "alpha_mask.h"
#include "area_device.h"
#include "bounds.h"
#include "leaf_area_frag.h"
#include "leaf_area_vert.h"
#include "whole_view_vert.h"

namespace coppice::bake {
namespace {

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr std::uint32_t kVerticesPerLeaf = 6;
/// Queries in one submission: enough that waiting for it costs little, few enough for drivers that end submissions that take seconds.
constexpr std::uint32_t kQueryCount = 8192;
/// A driver that takes longer hangs. A processor may do the GPU's work, so the limit is high.
constexpr std::uint64_t kMaxWait_ns = 600'000'000'000;

// These structs have the layouts of shaders/areas/leaf_area.glsl.

struct AreaLeaf {
  std::array<glm::vec3, 4> corners{};  ///< from the centre of the bounding sphere, relative to its radius
  std::array<glm::vec2, 4> uvs{};
  std::uint32_t mask = 0;
};
static_assert(sizeof(AreaLeaf) == 84);

struct AreaMask {
  std::uint32_t width = 0, height = 0;  ///< 0: no holes
  std::uint32_t first_word = 0;
};
static_assert(sizeof(AreaMask) == 12);

struct AreaPush {
  glm::mat4 clip_from_sphere{1.0f};
  VkDeviceAddress leaves = 0, masks = 0, holes = 0;
};
static_assert(sizeof(AreaPush) == 88);
constexpr VkShaderStageFlags kAreaPushStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

/// Maps metres from the sphere's centre, relative to its radius, to clip space: the camera of raster.h. Depth has a margin on both sides,
/// so that rounding clips no leaf and no leaf is as far as a cleared pixel.
glm::mat4 clip_from_sphere(const Viewpoint& view) {
  constexpr double kMargin = 1.0 / 1024.0;
  glm::dmat4 rows(0.0);  // x, y, z, w of clip space, each by x, y, z, 1
  const auto set = [&](int row, const glm::vec3& axis, double scale, double constant) {
    rows[row] = glm::dvec4(glm::dvec3(axis) * scale, constant);
  };
  if (view.distance_radii > 0.0f) {
    const double eye = view.distance_radii, side = std::sqrt(eye * eye - 1.0);
    const double nearest = 1.0 / (eye - 1.0), span = nearest - 1.0 / (eye + 1.0);
    set(0, view.right, side, 0.0);
    set(1, view.up, -side, 0.0);
    set(2, view.direction, -nearest / span, (nearest * eye - 1.0) / span);
    set(3, view.direction, -1.0, eye);
  } else {
    set(0, view.right, 1.0, 0.0);
    set(1, view.up, -1.0, 0.0);
    set(2, view.direction, -0.5, 0.5);
    set(3, view.direction, 0.0, 1.0);
  }
  rows[2] = rows[2] * (1.0 - 2.0 * kMargin) + rows[3] * kMargin;
  return glm::mat4(glm::transpose(rows));
}

/// The holes of all masks, a bit a texel, and the first word of each mask.
struct MaskBits {
  std::vector<AreaMask> masks;
  std::vector<std::uint32_t> words;
};

MaskBits mask_bits(const std::vector<AlphaMask>& masks) {
  MaskBits bits;
  for (const AlphaMask& mask : masks) {
    AreaMask& packed = bits.masks.emplace_back();
    if (mask.hole.empty()) continue;
    packed = {mask.width, mask.height, static_cast<std::uint32_t>(bits.words.size())};
    bits.words.resize(bits.words.size() + (mask.hole.size() + 31) / 32);
    for (std::size_t texel = 0; texel < mask.hole.size(); ++texel)
      if (mask.hole[texel] != 0) bits.words[packed.first_word + texel / 32] |= 1u << (texel % 32);
  }
  return bits;
}

// Functions that fail leave in their last argument what they created: the destructor of AreaMeasurer destroys it in any case.

/// A storage buffer in mapped, coherent memory.
struct AreaBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  void* mapped = nullptr;
  VkDeviceAddress address = 0;
  VkDeviceSize bytes = 0;
};

struct AreaDepth {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
};

struct AreaPipelines {
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkShaderModule leaf = VK_NULL_HANDLE, holes = VK_NULL_HANDLE, whole_view = VK_NULL_HANDLE;
  VkPipeline fill_depth = VK_NULL_HANDLE;        ///< draws leaves and keeps the nearest depth
  VkPipeline count_leaf = VK_NULL_HANDLE;        ///< draws leaves and counts samples of equal depth
  VkPipeline count_background = VK_NULL_HANDLE;  ///< draws three vertices and counts samples of depth 1, the cleared value
};

Result<void> allocate(const AreaDevice& gpu, const VkMemoryRequirements& needs, VkMemoryPropertyFlags properties,
                      VkMemoryAllocateFlags allocate_flags, VkDeviceMemory& memory) {
  const VkMemoryAllocateFlagsInfo flags{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, .flags = allocate_flags};
  VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .pNext = &flags, .allocationSize = needs.size};
  for (; info.memoryTypeIndex < gpu.memory.memoryTypeCount; ++info.memoryTypeIndex) {
    const bool allowed = (needs.memoryTypeBits >> info.memoryTypeIndex & 1u) != 0;
    if (!allowed || (gpu.memory.memoryTypes[info.memoryTypeIndex].propertyFlags & properties) != properties) continue;
    return check_vulkan(gpu.vk.vkAllocateMemory(gpu.device, &info, nullptr, &memory), "vkAllocateMemory");
  }
  return Error{Status::unsupported, "the Vulkan device has no memory of the kind that areas need"};
}

/// bytes  > 0
Result<void> create_area_buffer(const AreaDevice& gpu, VkDeviceSize bytes, AreaBuffer& buffer) {
  buffer.bytes = bytes;
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = bytes,
                                .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT};
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreateBuffer(gpu.device, &info, nullptr, &buffer.buffer), "vkCreateBuffer"));
  VkMemoryRequirements needs{};
  gpu.vk.vkGetBufferMemoryRequirements(gpu.device, buffer.buffer, &needs);
  COPPICE_CHECK(allocate(gpu, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                         VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT, buffer.memory));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkBindBufferMemory(gpu.device, buffer.buffer, buffer.memory, 0), "vkBindBufferMemory"));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkMapMemory(gpu.device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped), "vkMapMemory"));
  const VkBufferDeviceAddressInfo address{.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer.buffer};
  buffer.address = gpu.vk.vkGetBufferDeviceAddress(gpu.device, &address);
  return {};
}

Result<void> create_area_depth(const AreaDevice& gpu, std::uint32_t side_px, AreaDepth& depth) {
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = kDepthFormat,
                               .extent = {side_px, side_px, 1},
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT};
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreateImage(gpu.device, &info, nullptr, &depth.image), "vkCreateImage"));
  VkMemoryRequirements needs{};
  gpu.vk.vkGetImageMemoryRequirements(gpu.device, depth.image, &needs);
  COPPICE_CHECK(allocate(gpu, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0, depth.memory));
  COPPICE_CHECK(check_vulkan(gpu.vk.vkBindImageMemory(gpu.device, depth.image, depth.memory, 0), "vkBindImageMemory"));
  const VkImageViewCreateInfo view{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = depth.image,
                                   .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                   .format = kDepthFormat,
                                   .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1}};
  return check_vulkan(gpu.vk.vkCreateImageView(gpu.device, &view, nullptr, &depth.view), "vkCreateImageView");
}

void destroy_area_buffer(const AreaDevice& gpu, AreaBuffer& buffer) {
  gpu.vk.vkDestroyBuffer(gpu.device, buffer.buffer, nullptr);
  gpu.vk.vkFreeMemory(gpu.device, buffer.memory, nullptr);
  buffer = {};
}

struct PipelineKind {
  VkShaderModule vertex = VK_NULL_HANDLE;
  VkShaderModule fragment = VK_NULL_HANDLE;  ///< may be null
  bool depth_write = false;                  ///< and the test is for nearer; else for equal
};

Result<void> create_module(const AreaDevice& gpu, std::span<const std::uint32_t> words, VkShaderModule& module) {
  const VkShaderModuleCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = words.size_bytes(), .pCode = words.data()};
  return check_vulkan(gpu.vk.vkCreateShaderModule(gpu.device, &info, nullptr, &module), "vkCreateShaderModule");
}

Result<void> create_pipeline(const AreaDevice& gpu, VkPipelineLayout layout, const PipelineKind& kind, VkPipeline& pipeline) {
  const auto stage = [](VkShaderStageFlagBits bit, VkShaderModule module) {
    return VkPipelineShaderStageCreateInfo{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = bit, .module = module, .pName = "main"};
  };
  const std::array stages{stage(VK_SHADER_STAGE_VERTEX_BIT, kind.vertex), stage(VK_SHADER_STAGE_FRAGMENT_BIT, kind.fragment)};
  const VkPipelineVertexInputStateCreateInfo vertex_input{.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo assembly{.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .cullMode = VK_CULL_MODE_NONE, .lineWidth = 1.0f};
  const VkPipelineMultisampleStateCreateInfo samples{.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                     .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                    .depthTestEnable = VK_TRUE,
                                                    .depthWriteEnable = kind.depth_write ? VK_TRUE : VK_FALSE,
                                                    .depthCompareOp = kind.depth_write ? VK_COMPARE_OP_LESS : VK_COMPARE_OP_EQUAL};
  const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic{.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                 .dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size()),
                                                 .pDynamicStates = dynamic_states.data()};
  const VkPipelineRenderingCreateInfo rendering{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                .depthAttachmentFormat = kDepthFormat};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = &rendering,
                                          .stageCount = kind.fragment == VK_NULL_HANDLE ? 1u : 2u,
                                          .pStages = stages.data(),
                                          .pVertexInputState = &vertex_input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &raster,
                                          .pMultisampleState = &samples,
                                          .pDepthStencilState = &depth,
                                          .pDynamicState = &dynamic,
                                          .layout = layout};
  return check_vulkan(gpu.vk.vkCreateGraphicsPipelines(gpu.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
                      "vkCreateGraphicsPipelines");
}

/// masked  whether any leaf has holes; without holes there is no fragment shader
Result<void> create_pipelines(const AreaDevice& gpu, bool masked, AreaPipelines& pipelines) {
  const VkPushConstantRange range{kAreaPushStages, 0, sizeof(AreaPush)};
  const VkPipelineLayoutCreateInfo layout{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .pushConstantRangeCount = 1, .pPushConstantRanges = &range};
  COPPICE_CHECK(check_vulkan(gpu.vk.vkCreatePipelineLayout(gpu.device, &layout, nullptr, &pipelines.layout), "vkCreatePipelineLayout"));
  COPPICE_CHECK(create_module(gpu, leaf_area_vert_spirv, pipelines.leaf));
  COPPICE_CHECK(create_module(gpu, leaf_area_frag_spirv, pipelines.holes));
  COPPICE_CHECK(create_module(gpu, whole_view_vert_spirv, pipelines.whole_view));
  const VkShaderModule fragment = masked ? pipelines.holes : VK_NULL_HANDLE;
  COPPICE_CHECK(create_pipeline(gpu, pipelines.layout, {pipelines.leaf, fragment, true}, pipelines.fill_depth));
  COPPICE_CHECK(create_pipeline(gpu, pipelines.layout, {pipelines.leaf, fragment, false}, pipelines.count_leaf));
  return create_pipeline(gpu, pipelines.layout, {pipelines.whole_view, VK_NULL_HANDLE, false}, pipelines.count_background);
}

class AreaMeasurer : public OcclusionAreas {
 public:
  AreaMeasurer(std::unique_ptr<AreaDevice> device, const Scene& scene)
      : gpu_(std::move(device)),
        sphere_(bounding_sphere(scene.shown.foliage)),
        card_table_(scene.shown.foliage.card_table),
        resolution_px_(scene.resolution_px) {
    for (const Viewpoint& view : scene.views) views_.push_back({make_projection(view, sphere_, resolution_px_), clip_from_sphere(view)});
  }
  AreaMeasurer(const AreaMeasurer&) = delete;
  AreaMeasurer& operator=(const AreaMeasurer&) = delete;

  ~AreaMeasurer() override {
    for (AreaBuffer* buffer : {&leaves_, &masks_, &holes_}) destroy_area_buffer(*gpu_, *buffer);
    vk().vkDestroyImageView(gpu_->device, depth_.view, nullptr);
    vk().vkDestroyImage(gpu_->device, depth_.image, nullptr);
    vk().vkFreeMemory(gpu_->device, depth_.memory, nullptr);
    for (const VkPipeline pipeline : {pipelines_.fill_depth, pipelines_.count_leaf, pipelines_.count_background})
      vk().vkDestroyPipeline(gpu_->device, pipeline, nullptr);
    for (const VkShaderModule module : {pipelines_.leaf, pipelines_.holes, pipelines_.whole_view})
      vk().vkDestroyShaderModule(gpu_->device, module, nullptr);
    vk().vkDestroyPipelineLayout(gpu_->device, pipelines_.layout, nullptr);
    vk().vkDestroyQueryPool(gpu_->device, queries_, nullptr);
    vk().vkDestroyFence(gpu_->device, fence_, nullptr);
    vk().vkDestroyCommandPool(gpu_->device, command_pool_, nullptr);
  }

  [[nodiscard]] const std::string& device_name() const override { return gpu_->name; }

  Result<void> prepare(const std::vector<AlphaMask>& masks) {
    const MaskBits bits = mask_bits(masks);
    COPPICE_CHECK(upload(std::as_bytes(std::span(bits.masks)), masks_));
    COPPICE_CHECK(upload(std::as_bytes(std::span(bits.words)), holes_));
    COPPICE_CHECK(create_area_depth(*gpu_, resolution_px_, depth_));
    COPPICE_CHECK(create_pipelines(*gpu_, !bits.words.empty(), pipelines_));
    return create_commands();
  }

  Result<void> measure(const AreaRequest& request, std::span<std::uint32_t> areas_px, const ProgressFunction& progress) override {
    COPPICE_CHECK(upload_leaves(request));
    std::vector<std::uint32_t> asked;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      find_asked(request, v, asked);
      for (std::size_t leaf = 0; request.changed.empty() && leaf <= request.quads.size(); ++leaf) areas_px[leaf * views_.size() + v] = 0;
      for (std::size_t done = 0; done < asked.size();) {
        if (targets_.size() == kQueryCount) COPPICE_CHECK(finish(areas_px));
        if (targets_.empty()) COPPICE_CHECK(begin());
        const std::size_t count = std::min(kQueryCount - targets_.size(), asked.size() - done);
        record(v, std::span(asked).subspan(done, count), request.quads.size(), done == 0);
        done += count;
      }
      if (progress) progress(static_cast<double>(v + 1) / static_cast<double>(views_.size()));
    }
    return targets_.empty() ? Result<void>() : finish(areas_px);
  }

 private:
  struct View {
    Projection projection;
    glm::mat4 clip_from_sphere{1.0f};
  };

  [[nodiscard]] const VolkDeviceTable& vk() const { return gpu_->vk; }

  Result<void> create_commands() {
    const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .queueFamilyIndex = gpu_->queue_family};
    COPPICE_CHECK(check_vulkan(vk().vkCreateCommandPool(gpu_->device, &pool, nullptr, &command_pool_), "vkCreateCommandPool"));
    const VkCommandBufferAllocateInfo commands{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                               .commandPool = command_pool_,
                                               .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                               .commandBufferCount = 1};
    COPPICE_CHECK(check_vulkan(vk().vkAllocateCommandBuffers(gpu_->device, &commands, &commands_), "vkAllocateCommandBuffers"));
    const VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    COPPICE_CHECK(check_vulkan(vk().vkCreateFence(gpu_->device, &fence, nullptr, &fence_), "vkCreateFence"));
    const VkQueryPoolCreateInfo queries{
        .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_OCCLUSION, .queryCount = kQueryCount};
    return check_vulkan(vk().vkCreateQueryPool(gpu_->device, &queries, nullptr, &queries_), "vkCreateQueryPool");
  }

  /// Copies into a buffer, which is replaced if it is too small.
  Result<void> upload(std::span<const std::byte> bytes, AreaBuffer& buffer) {
    if (buffer.bytes < std::max<std::size_t>(bytes.size(), 4)) {
      destroy_area_buffer(*gpu_, buffer);
      COPPICE_CHECK(create_area_buffer(*gpu_, std::max<std::size_t>(bytes.size(), 4), buffer));
    }
    if (!bytes.empty()) std::memcpy(buffer.mapped, bytes.data(), bytes.size());
    return {};
  }

  Result<void> upload_leaves(const AreaRequest& request) {
    const double scale = sphere_.radius > 0.0f ? 1.0 / sphere_.radius : 0.0;
    std::vector<AreaLeaf> leaves(request.quads.size());
    for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
      const Card& card = card_table_[request.cards[leaf]];
      for (std::size_t corner = 0; corner < 4; ++corner) {
        leaves[leaf].corners[corner] = (glm::dvec3(request.quads[leaf][corner]) - glm::dvec3(sphere_.center)) * scale;
        leaves[leaf].uvs[corner] = card.uv[corner];
      }
      leaves[leaf].mask = card.material;
    }
    return upload(std::as_bytes(std::span(leaves)), leaves_);
  }

  /// Finds the leaves of a view whose areas may have changed; the background is the one after the last leaf.
  void find_asked(const AreaRequest& request, std::size_t v, std::vector<std::uint32_t>& asked) const {
    asked.clear();
    if (!request.changed.empty() && request.changed[v].empty()) return;
    const Projection& projection = views_[v].projection;
    for (std::uint32_t leaf = 0; leaf < request.quads.size(); ++leaf) {
      const PixelBox box = pixel_box(project(projection, request.quads[leaf]), projection.resolution_px);
      if (!box.empty() && (request.changed.empty() || box.meets(request.changed[v]))) asked.push_back(leaf);
    }
    asked.push_back(static_cast<std::uint32_t>(request.quads.size()));
  }

  Result<void> begin() {
    COPPICE_CHECK(check_vulkan(vk().vkResetCommandPool(gpu_->device, command_pool_, 0), "vkResetCommandPool"));
    const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                        .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    COPPICE_CHECK(check_vulkan(vk().vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer"));
    vk().vkCmdResetQueryPool(commands_, queries_, 0, kQueryCount);
    return {};
  }

  /// Makes draws into the depth image wait for all earlier ones. A new view discards the image's contents.
  void wait_for_depth(bool is_new) const {
    constexpr VkPipelineStageFlags2 kTests = VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
    const VkImageMemoryBarrier2 barrier{
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = kTests,
        .srcAccessMask = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
        .dstStageMask = kTests,
        .dstAccessMask = VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
        .oldLayout = is_new ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
        .newLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = depth_.image,
        .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, 1}};
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
    vk().vkCmdPipelineBarrier2(commands_, &info);
  }

  void begin_rendering(bool is_new) const {
    const VkRenderingAttachmentInfo attachment{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                               .imageView = depth_.view,
                                               .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                               .loadOp = is_new ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD,
                                               .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                               .clearValue = {.depthStencil = {.depth = 1.0f}}};
    const VkRenderingInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                               .renderArea = {.extent = {resolution_px_, resolution_px_}},
                               .layerCount = 1,
                               .pDepthAttachment = &attachment};
    vk().vkCmdBeginRendering(commands_, &info);
    const auto side = static_cast<float>(resolution_px_);
    const VkViewport viewport{0.0f, 0.0f, side, side, 0.0f, 1.0f};
    vk().vkCmdSetViewport(commands_, 0, 1, &viewport);
    vk().vkCmdSetScissor(commands_, 0, 1, &info.renderArea);
  }

  /// Records the depth of a view, if it is a new one, and a query for each leaf in `asked`. Depth is written in the order of the draws, so
  /// the queries need no barrier.
  void record(std::size_t v, std::span<const std::uint32_t> asked, std::size_t leaf_count, bool is_new) {
    wait_for_depth(is_new);
    begin_rendering(is_new);
    const AreaPush push{views_[v].clip_from_sphere, leaves_.address, masks_.address, holes_.address};
    vk().vkCmdPushConstants(commands_, pipelines_.layout, kAreaPushStages, 0, sizeof push, &push);
    const auto bind = [&](VkPipeline pipeline) { vk().vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline); };
    if (is_new && leaf_count > 0) {
      bind(pipelines_.fill_depth);
      vk().vkCmdDraw(commands_, static_cast<std::uint32_t>(leaf_count) * kVerticesPerLeaf, 1, 0, 0);
    }
    bind(pipelines_.count_leaf);
    for (const std::uint32_t leaf : asked) {
      const bool is_leaf = leaf < leaf_count;  // the background comes last
      if (!is_leaf) bind(pipelines_.count_background);
      const auto query = static_cast<std::uint32_t>(targets_.size());
      vk().vkCmdBeginQuery(commands_, queries_, query, VK_QUERY_CONTROL_PRECISE_BIT);
      vk().vkCmdDraw(commands_, is_leaf ? kVerticesPerLeaf : 3, 1, is_leaf ? leaf * kVerticesPerLeaf : 0, 0);
      vk().vkCmdEndQuery(commands_, queries_, query);
      targets_.push_back(leaf * views_.size() + v);
    }
    vk().vkCmdEndRendering(commands_);
  }

  Result<void> finish(std::span<std::uint32_t> areas_px) {
    const std::vector<std::size_t> targets = std::exchange(targets_, {});
    COPPICE_CHECK(check_vulkan(vk().vkEndCommandBuffer(commands_), "vkEndCommandBuffer"));
    const VkCommandBufferSubmitInfo commands{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO, .commandBuffer = commands_};
    const VkSubmitInfo2 submit{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2, .commandBufferInfoCount = 1, .pCommandBufferInfos = &commands};
    COPPICE_CHECK(check_vulkan(vk().vkQueueSubmit2(gpu_->queue, 1, &submit, fence_), "vkQueueSubmit2"));
    COPPICE_CHECK(check_vulkan(vk().vkWaitForFences(gpu_->device, 1, &fence_, VK_TRUE, kMaxWait_ns), "vkWaitForFences"));
    COPPICE_CHECK(check_vulkan(vk().vkResetFences(gpu_->device, 1, &fence_), "vkResetFences"));
    std::vector<std::uint32_t> counts(targets.size());
    COPPICE_CHECK(check_vulkan(
        vk().vkGetQueryPoolResults(gpu_->device, queries_, 0, static_cast<std::uint32_t>(targets.size()),
                                   counts.size() * sizeof(std::uint32_t), counts.data(), sizeof(std::uint32_t), VK_QUERY_RESULT_WAIT_BIT),
        "vkGetQueryPoolResults"));
    for (std::size_t i = 0; i < targets.size(); ++i) areas_px[targets[i]] = counts[i];
    return {};
  }

  std::unique_ptr<AreaDevice> gpu_;
  Sphere sphere_;
  std::vector<Card> card_table_;
  std::uint32_t resolution_px_ = 0;
  std::vector<View> views_;
  AreaBuffer leaves_, masks_, holes_;
  AreaDepth depth_;
  AreaPipelines pipelines_;
  VkQueryPool queries_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  VkCommandPool command_pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  std::vector<std::size_t> targets_;  ///< [recorded query] where in areas_px its count belongs
};

}  // namespace

Result<std::string> area_device_name() {
  COPPICE_TRY(device, open_area_device());
  return device->name;
}

Result<std::unique_ptr<OcclusionAreas>> OcclusionAreas::create(const Scene& scene) {
  COPPICE_TRY(device, open_area_device());
  return create(scene, std::move(device));
}

Result<std::unique_ptr<OcclusionAreas>> OcclusionAreas::create(const Scene& scene, std::unique_ptr<AreaDevice> device) {
  COPPICE_TRY(masks, alpha_masks(scene.shown.materials, scene.shown.images));
  auto measurer = std::make_unique<AreaMeasurer>(std::move(device), scene);
  COPPICE_CHECK(measurer->prepare(masks));
  return {std::move(measurer)};
}

}  // namespace coppice::bake
