#pragma once

// Attachments of tests, drawn to by dynamic rendering or inside a classic render pass.

#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "coppice/vulkan.h"
#include "shot.h"
#include "vulkan_device.h"

namespace coppice::test {

/// A colour attachment of a view, and what it gets.
struct Color {
  VkFormat format;
  coppice_content content;
  std::size_t pixel_bytes = 4;
};

inline std::vector<VkFormat> formats_of(std::span<const Color> colors) {
  std::vector<VkFormat> formats;
  for (const Color& color : colors) formats.push_back(color.format);
  return formats;
}

/// With a depth of D32_SFLOAT.
inline coppice_vulkan_view_desc view_formats(std::span<const Color> colors) {
  auto desc = defaults(coppice_vulkan_view_desc_init);
  desc.depth_format = VK_FORMAT_D32_SFLOAT;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    desc.color_formats[i] = colors[i].format;
    desc.contents[i] = colors[i].content;
  }
  return desc;
}

/// A view's attachments of so many pixels a side; all start undefined.
struct PassTarget {
  std::vector<std::unique_ptr<Image>> colors;
  Image depth;

  PassTarget(const VulkanDevice& gpu, std::uint32_t side_px, std::span<const VkFormat> formats)
      : depth(gpu, depth_attachment(side_px, side_px)) {
    for (const VkFormat format : formats) colors.push_back(std::make_unique<Image>(gpu, color_attachment(side_px, side_px, format)));
  }

  /// White, and as far away as can be.
  void begin_cleared(VkCommandBuffer cmd) const {
    Attachments all{.depth = &depth};
    for (const auto& color : colors) all.colors.push_back(color.get());
    begin_rendering(cmd, all);
  }
};

/// A colour image's bytes, `Texel` a pixel.
template <class Texel>
std::vector<Texel> read_texels(const VulkanDevice& gpu, const Image& image) {
  const std::vector<std::uint8_t> bytes = read_bytes(gpu, image, sizeof(Texel));
  std::vector<Texel> texels(bytes.size() / sizeof(Texel));
  std::memcpy(texels.data(), bytes.data(), bytes.size());
  return texels;
}

struct ClassicPassDesc {
  std::vector<VkFormat> colors;  ///< VK_FORMAT_UNDEFINED: a reference that is VK_ATTACHMENT_UNUSED
  std::uint32_t subpass = 0;     ///< that has them; earlier ones have depth alone
  bool clears = true;            ///< to white and to depth 0; else what was there stays
};

/// One subpass for colours of these formats and a depth of D32_SFLOAT, all left as attachments. Destroyed with this object.
class ClassicPass {
 public:
  ClassicPass(const VulkanDevice& gpu, const ClassicPassDesc& desc) : gpu_(gpu), clears_(desc.clears) {
    std::vector<VkAttachmentDescription> attachments;
    const auto add = [&](VkFormat format, VkImageLayout layout) {
      attachments.push_back({.format = format,
                             .samples = VK_SAMPLE_COUNT_1_BIT,
                             .loadOp = clears_ ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD,
                             .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                             .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                             .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                             .initialLayout = clears_ ? VK_IMAGE_LAYOUT_UNDEFINED : layout,
                             .finalLayout = layout});
      return static_cast<std::uint32_t>(attachments.size() - 1);
    };
    std::vector<VkAttachmentReference> colors;
    for (const VkFormat format : desc.colors) {
      const bool used = format != VK_FORMAT_UNDEFINED;
      colors.push_back(
          {used ? add(format, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL) : VK_ATTACHMENT_UNUSED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL});
    }
    const VkAttachmentReference depth{add(VK_FORMAT_D32_SFLOAT, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL),
                                      VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    std::vector<VkSubpassDescription> subpasses(desc.subpass, {.pDepthStencilAttachment = &depth});
    subpasses.push_back({.colorAttachmentCount = static_cast<std::uint32_t>(colors.size()),
                         .pColorAttachments = colors.data(),
                         .pDepthStencilAttachment = &depth});
    constexpr VkPipelineStageFlags kDepthStages = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    std::vector<VkSubpassDependency> dependencies;
    for (std::uint32_t i = 0; i < desc.subpass; ++i)
      dependencies.push_back({i, i + 1, kDepthStages, kDepthStages, VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                              VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, 0});
    const VkRenderPassCreateInfo info{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                      .attachmentCount = static_cast<std::uint32_t>(attachments.size()),
                                      .pAttachments = attachments.data(),
                                      .subpassCount = static_cast<std::uint32_t>(subpasses.size()),
                                      .pSubpasses = subpasses.data(),
                                      .dependencyCount = static_cast<std::uint32_t>(dependencies.size()),
                                      .pDependencies = dependencies.data()};
    check_vk(vkCreateRenderPass(gpu.device, &info, nullptr, &pass_), "vkCreateRenderPass");
    subpass_ = desc.subpass;
  }
  ~ClassicPass() {
    for (const VkFramebuffer framebuffer : framebuffers_) vkDestroyFramebuffer(gpu_.device, framebuffer, nullptr);
    vkDestroyRenderPass(gpu_.device, pass_, nullptr);
  }
  ClassicPass(const ClassicPass&) = delete;
  ClassicPass& operator=(const ClassicPass&) = delete;

  [[nodiscard]] VkRenderPass handle() const { return pass_; }

  /// Up to the subpass with colours. Its framebuffer lives as long as the pass. target: of the formats that are no VK_FORMAT_UNDEFINED
  void begin(VkCommandBuffer cmd, const PassTarget& target) {
    std::vector<VkImageView> views;
    std::vector<VkClearValue> clear(target.colors.size() + 1, {.color = {{1.0f, 1.0f, 1.0f, 1.0f}}});
    clear.back() = {.depthStencil = {0.0f, 0}};
    for (const auto& color : target.colors) views.push_back(color->view());
    views.push_back(target.depth.view());
    const VkExtent2D size{target.depth.desc().width_px, target.depth.desc().height_px};
    const VkFramebufferCreateInfo framebuffer{.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                              .renderPass = pass_,
                                              .attachmentCount = static_cast<std::uint32_t>(views.size()),
                                              .pAttachments = views.data(),
                                              .width = size.width,
                                              .height = size.height,
                                              .layers = 1};
    check_vk(vkCreateFramebuffer(gpu_.device, &framebuffer, nullptr, &framebuffers_.emplace_back()), "vkCreateFramebuffer");
    const VkRenderPassBeginInfo begin{.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                      .renderPass = pass_,
                                      .framebuffer = framebuffers_.back(),
                                      .renderArea = {{0, 0}, size},
                                      .clearValueCount = clears_ ? static_cast<std::uint32_t>(clear.size()) : 0,
                                      .pClearValues = clear.data()};
    vkCmdBeginRenderPass(cmd, &begin, VK_SUBPASS_CONTENTS_INLINE);
    for (std::uint32_t i = 0; i < subpass_; ++i) vkCmdNextSubpass(cmd, VK_SUBPASS_CONTENTS_INLINE);
  }
  static void end(VkCommandBuffer cmd) { vkCmdEndRenderPass(cmd); }

 private:
  const VulkanDevice& gpu_;
  bool clears_;
  std::uint32_t subpass_ = 0;
  VkRenderPass pass_ = VK_NULL_HANDLE;
  std::vector<VkFramebuffer> framebuffers_;
};

}  // namespace coppice::test
