#include "pipelines.h"

#include <chrono>
#include <utility>
#include <vector>

#include "debug_label.h"
#include "hooks.h"
#include "shader_words.h"

namespace coppice::gpu {
namespace {

constexpr std::uint32_t kReadsTexelsId = 8;  // kReadsTexels of bindings.glsl

/// Destroyed once its pipeline is created.
class ShaderModule {
 public:
  explicit ShaderModule(const Device& device) : device_(device) {}
  ~ShaderModule() { device_.vk.vkDestroyShaderModule(device_.device, module_, nullptr); }
  ShaderModule(const ShaderModule&) = delete;
  ShaderModule& operator=(const ShaderModule&) = delete;

  Result<VkPipelineShaderStageCreateInfo> create(VkShaderStageFlagBits stage, std::span<const std::uint32_t> words,
                                                 const VkSpecializationInfo* constants) {
    std::vector<std::uint32_t> by_address;
    if (!device_.reads_texels) words = by_address = without_branches(words, kReadsTexelsId);
    const VkShaderModuleCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = words.size_bytes(), .pCode = words.data()};
    const VkResult result = device_.vk.vkCreateShaderModule(device_.device, &info, nullptr, &module_);
    if (result != VK_SUCCESS) {
      module_ = VK_NULL_HANDLE;
      return vulkan_error(result, "vkCreateShaderModule");
    }
    return VkPipelineShaderStageCreateInfo{.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                           .stage = stage,
                                           .module = module_,
                                           .pName = "main",
                                           .pSpecializationInfo = constants};
  }

 private:
  const Device& device_;
  VkShaderModule module_ = VK_NULL_HANDLE;
};

Result<VkPipeline> create_compute(const Device& device, VkPipelineCache cache, const PipelineRecipe& recipe,
                                  const VkSpecializationInfo& constants) {
  ShaderModule module(device);
  COPPICE_TRY(stage, module.create(VK_SHADER_STAGE_COMPUTE_BIT, recipe.first, &constants));
  const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, .stage = stage, .layout = recipe.layout};
  VkPipeline pipeline = VK_NULL_HANDLE;
  const VkResult result = device.vk.vkCreateComputePipelines(device.device, cache, 1, &info, nullptr, &pipeline);
  if (result != VK_SUCCESS) return vulkan_error(result, "vkCreateComputePipelines");
  return pipeline;
}

Result<VkPipeline> create_draw(const Device& device, VkPipelineCache cache, const PipelineRecipe& recipe,
                               const VkSpecializationInfo& constants) {
  const AttachmentDesc& attachments = recipe.attachments;
  ShaderModule vertex(device), fragment(device);
  COPPICE_TRY(vertex_stage, vertex.create(VK_SHADER_STAGE_VERTEX_BIT, recipe.first, &constants));
  const std::vector<std::uint32_t> words = with_outputs(recipe.fragment, attachments.color_count);
  COPPICE_TRY(fragment_stage, fragment.create(VK_SHADER_STAGE_FRAGMENT_BIT, words, &constants));
  const std::array stages{vertex_stage, fragment_stage};
  const VkPipelineVertexInputStateCreateInfo vertex_input{.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo assembly{.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .cullMode = VK_CULL_MODE_NONE, .lineWidth = 1.0f};
  const VkPipelineMultisampleStateCreateInfo samples{.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                     .rasterizationSamples = attachments.samples};
  const VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                    .depthTestEnable = VK_TRUE,
                                                    .depthWriteEnable = VK_TRUE,
                                                    .depthCompareOp = attachments.depth_compare};
  constexpr VkColorComponentFlags kAll =
      VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  std::array<VkPipelineColorBlendAttachmentState, COPPICE_MAX_COLORS> no_blend{};
  for (std::uint32_t i = 0; i < attachments.color_count; ++i)
    no_blend[i].colorWriteMask = attachments.contents[i] == COPPICE_CONTENT_NONE ? 0 : kAll;
  const VkPipelineColorBlendStateCreateInfo blend{.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                  .attachmentCount = attachments.color_count,
                                                  .pAttachments = no_blend.data()};
  const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic{.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                 .dynamicStateCount = static_cast<std::uint32_t>(dynamic_states.size()),
                                                 .pDynamicStates = dynamic_states.data()};
  const VkPipelineRenderingCreateInfo rendering{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
      .colorAttachmentCount = attachments.color_count,
      .pColorAttachmentFormats = attachments.color_formats.data(),
      .depthAttachmentFormat = attachments.depth_format,
      .stencilAttachmentFormat = attachments.has_stencil ? attachments.depth_format : VK_FORMAT_UNDEFINED};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = attachments.render_pass == VK_NULL_HANDLE ? &rendering : nullptr,
                                          .stageCount = static_cast<std::uint32_t>(stages.size()),
                                          .pStages = stages.data(),
                                          .pVertexInputState = &vertex_input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &raster,
                                          .pMultisampleState = &samples,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &blend,
                                          .pDynamicState = &dynamic,
                                          .layout = recipe.layout,
                                          .renderPass = attachments.render_pass,
                                          .subpass = attachments.subpass};
  VkPipeline pipeline = VK_NULL_HANDLE;
  const VkResult result = device.vk.vkCreateGraphicsPipelines(device.device, cache, 1, &info, nullptr, &pipeline);
  if (result != VK_SUCCESS) return vulkan_error(result, "vkCreateGraphicsPipelines");
  return pipeline;
}

Result<VkPipeline> create_pipeline(const Device& device, VkPipelineCache cache, const PipelineRecipe& recipe) {
  constexpr std::uint32_t kWord = sizeof(std::uint32_t);
  std::array<VkSpecializationMapEntry, std::tuple_size_v<decltype(recipe.constants)>> entries{};
  for (std::uint32_t i = 0; i < entries.size(); ++i) entries[i] = {.constantID = i, .offset = i * kWord, .size = kWord};
  const VkSpecializationInfo constants{.mapEntryCount = static_cast<std::uint32_t>(entries.size()),
                                       .pMapEntries = entries.data(),
                                       .dataSize = sizeof recipe.constants,
                                       .pData = recipe.constants.data()};
  return recipe.fragment.empty() ? create_compute(device, cache, recipe, constants) : create_draw(device, cache, recipe, constants);
}

}  // namespace

Pipeline& PipelineSet::add(const PipelineRecipe& recipe) {
  Pipeline& pipeline = pipelines_.emplace_back();
  pipeline.set = this;
  pipeline.recipe = recipe;
  return pipeline;
}

bool PipelineSet::request(Pipeline& pipeline) {
  if (!std::exchange(pipeline.requested, true)) {
    ++requested_count_;
    {
      const std::lock_guard lock(mutex_);
      ++running_count_;
    }
    const coppice_job job = make_job(COPPICE_JOB_PIPELINE, COPPICE_PRIORITY_LOW, build, &pipeline);
    if (jobs_.submit != nullptr)
      jobs_.submit(jobs_.user, &job);
    else
      build(&pipeline);
    collect();
  }
  return pipeline.handle() != VK_NULL_HANDLE;
}

// Reads only constant properties of the device. Notifies under the lock: the waiter may destroy the set as soon as it can take it.
void PipelineSet::build(void* argument) {
  auto& pipeline = *static_cast<Pipeline*>(argument);
  PipelineSet& set = *pipeline.set;
  const Device& device = set.device_;
  Result<VkPipeline> built(VkPipeline{});
  const auto start = std::chrono::steady_clock::now();
  if (!set.closing_) built = create_pipeline(device, set.cache_, pipeline.recipe);
  const double took_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (built) name_object(device, VK_OBJECT_TYPE_PIPELINE, *built, pipeline.recipe.name);
  const bool lost = !built && built.error().status == Status::device_lost;
  if (!built && !lost)
    log_line(device.log, COPPICE_LOG_ERROR, "%s; nothing is drawn with %s", built.error().message().c_str(), pipeline.recipe.name);
  const std::lock_guard lock(set.mutex_);
  if (built) {
    pipeline.built.store(*built, std::memory_order_release);
    ++set.built_count_;
    set.times_.sum_ms += took_ms;
    if (took_ms >= set.times_.longest_ms) {
      set.times_.longest_ms = took_ms;
      set.times_.longest = pipeline.recipe.name;
    }
  } else if (set.failure_) {
    set.failure_ = built.error();
  }
  if (lost) set.lost_call_ = built.error().what;
  --set.running_count_;
  set.ended_.notify_all();
}

void PipelineSet::collect() {
  const std::lock_guard lock(mutex_);
  if (lost_call_ != nullptr) device_.lost_call = lost_call_;
}

void PipelineSet::close() {
  closing_ = true;
  {
    std::unique_lock lock(mutex_);
    while (!ended_.wait_for(lock, std::chrono::seconds(20), [this] { return running_count_ == 0; }))
      log_line(device_.log, COPPICE_LOG_WARNING, "coppice_context_destroy still waits for %u pipelines: the driver or the jobs hook hangs",
               running_count_);
  }
  for (const Pipeline& pipeline : pipelines_) device_.vk.vkDestroyPipeline(device_.device, pipeline.handle(), nullptr);
  pipelines_.clear();
}

std::uint32_t PipelineSet::built_count() const {
  const std::lock_guard lock(mutex_);
  return built_count_;
}

PipelineTimes PipelineSet::times() const {
  const std::lock_guard lock(mutex_);
  return times_;
}

const char* PipelineSet::missing() const {
  for (const Pipeline& pipeline : pipelines_)
    if (pipeline.requested && pipeline.handle() == VK_NULL_HANDLE) return pipeline.recipe.name;
  return nullptr;
}

Result<bool> PipelineSet::ready() const {
  const std::lock_guard lock(mutex_);
  if (!failure_) return failure_.error();
  return built_count_ == requested_count_;
}

}  // namespace coppice::gpu
