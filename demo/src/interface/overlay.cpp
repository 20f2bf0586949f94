#include "overlay.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <numeric>
#include <utility>

#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include "failure.h"
#include "overlay_frag.h"
#include "overlay_vert.h"
#include "pipelines.h"
#include "vk_struct.h"

namespace forest {
namespace {

struct Push {
  float scale[2];
  float offset[2];
};

Image create_font(const Device& device) {
  unsigned char* pixels = nullptr;
  int width = 0;
  int height = 0;
  ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  ImageDesc desc;
  desc.format = VK_FORMAT_R8G8B8A8_UNORM;
  desc.extent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  const std::size_t bytes = std::size_t{desc.extent.width} * desc.extent.height * 4;
  return create_texture(device, desc, std::as_bytes(std::span(pixels, bytes)), 4);
}

void create_set(Overlay& overlay) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1};
  VkDescriptorPoolCreateInfo info = vk_struct<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  info.maxSets = 1;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  check(vkCreateDescriptorPool(overlay.device.handle, &info, nullptr, &pool), "vkCreateDescriptorPool");
  overlay.descriptor_pool = {overlay.device.handle, pool, vkDestroyDescriptorPool};
  VkDescriptorSetAllocateInfo allocation = vk_struct<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocation.descriptorPool = pool;
  allocation.descriptorSetCount = 1;
  allocation.pSetLayouts = overlay.set_layout.address();
  check(vkAllocateDescriptorSets(overlay.device.handle, &allocation, &overlay.set), "vkAllocateDescriptorSets");
  const VkDescriptorImageInfo image{overlay.sampler, overlay.font.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  VkWriteDescriptorSet write = vk_struct<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = overlay.set;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  write.pImageInfo = &image;
  vkUpdateDescriptorSets(overlay.device.handle, 1, &write, 0, nullptr);
}

void create_overlay_pipeline(Overlay& overlay, VkFormat color_format) {
  const VkVertexInputBindingDescription binding{0, sizeof(ImDrawVert), VK_VERTEX_INPUT_RATE_VERTEX};
  const std::array<VkVertexInputAttributeDescription, 3> attributes = {{{0, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, pos)},
                                                                        {1, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, uv)},
                                                                        {2, 0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(ImDrawVert, col)}}};
  PipelineDesc desc;
  desc.layout = overlay.pipeline_layout;
  desc.vertex_spirv = overlay_vert_spirv;
  desc.fragment_spirv = overlay_frag_spirv;
  desc.color_format = color_format;
  desc.alpha_blend = true;
  desc.bindings = {&binding, 1};
  desc.attributes = attributes;
  overlay.pipeline = create_pipeline(overlay.device, desc);
}

// Copies all draw lists into the slot's buffer. Returns the offset of the indices.
VkDeviceSize copy_geometry(Overlay& overlay, std::size_t slot, const ImDrawData& data) {
  const auto vertex_bytes = static_cast<VkDeviceSize>(data.TotalVtxCount) * sizeof(ImDrawVert);
  const VkDeviceSize bytes = vertex_bytes + static_cast<VkDeviceSize>(data.TotalIdxCount) * sizeof(ImDrawIdx);
  Buffer& buffer = overlay.geometry[slot];
  if (buffer.bytes < bytes)
    buffer = create_host_buffer(overlay.device, 2 * bytes, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  std::byte* vertices = buffer.mapped;
  std::byte* indices = buffer.mapped + vertex_bytes;
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    std::memcpy(vertices, list.VtxBuffer.Data, static_cast<std::size_t>(list.VtxBuffer.size_in_bytes()));
    std::memcpy(indices, list.IdxBuffer.Data, static_cast<std::size_t>(list.IdxBuffer.size_in_bytes()));
    vertices += list.VtxBuffer.size_in_bytes();
    indices += list.IdxBuffer.size_in_bytes();
  }
  return vertex_bytes;
}

VkRect2D scissor_of(const ImVec4& rectangle, VkExtent2D extent) {
  const auto clamp = [](float value, std::uint32_t limit) {
    return static_cast<std::int32_t>(std::clamp(value, 0.0f, static_cast<float>(limit)));
  };
  const VkOffset2D from{clamp(rectangle.x, extent.width), clamp(rectangle.y, extent.height)};
  const VkOffset2D to{clamp(rectangle.z, extent.width), clamp(rectangle.w, extent.height)};
  return {from, {static_cast<std::uint32_t>(std::max(to.x - from.x, 0)), static_cast<std::uint32_t>(std::max(to.y - from.y, 0))}};
}

/// Means over about the last 30 frames.
void update_rates(Overlay& overlay, const coppice_stats& stats, float frame_ms) {
  constexpr float kNewest = 1.0f / 30;
  if (frame_ms <= 0) return;
  const auto mean = [&](float& of, double change) { of += kNewest * (static_cast<float>(change) / frame_ms - of); };
  mean(overlay.bytes_per_ms, static_cast<double>(stats.bytes_read - overlay.bytes_read));
  mean(overlay.decode_share, stats.decode_ms - overlay.decode_ms);
  overlay.bytes_read = stats.bytes_read;
  overlay.decode_ms = stats.decode_ms;
}

void show_streaming(const Overlay& overlay, const coppice_stats& stats) {
  const coppice_streamed_stats& all = stats.streamed[COPPICE_STREAMED_ALL];
  ImGui::Text("loaded   %llu pages, %llu wood, %llu textures, %llu leaf meshes",
              static_cast<unsigned long long>(stats.streamed[COPPICE_STREAMED_PAGES].loaded),
              static_cast<unsigned long long>(stats.streamed[COPPICE_STREAMED_WOOD].loaded),
              static_cast<unsigned long long>(stats.streamed[COPPICE_STREAMED_TEXTURES].loaded),
              static_cast<unsigned long long>(stats.streamed[COPPICE_STREAMED_LEAF_MESHES].loaded));
  ImGui::Text("         %llu evicted, %llu cancelled; %u wanted, %u on their way, %u queued", static_cast<unsigned long long>(all.evicted),
              static_cast<unsigned long long>(all.cancelled), all.wanted, all.in_flight, all.queued);
  ImGui::Text("reading  %.1f MB/s, decoding on %.2f threads", 1e-3 * static_cast<double>(overlay.bytes_per_ms),
              static_cast<double>(overlay.decode_share));
}

void show_statistics(const coppice_stats& stats, const coppice_view_stats& view) {
  constexpr double kMebibyte = 1 << 20;
  const double share =
      stats.source_leaf_count ? 100.0 * static_cast<double>(view.drawn_leaf_count) / static_cast<double>(stats.source_leaf_count) : 0;
  ImGui::Text("leaves   %llu drawn, %.2f %% of all", static_cast<unsigned long long>(view.drawn_leaf_count), share);
  ImGui::Text("error    %.2f px", static_cast<double>(view.threshold_px));
  ImGui::Text("plants   %u visible, %u hidden, of %u", view.visible_instance_count, view.occluded_instance_count, stats.instance_count);
  ImGui::Text("close    %u drawn with leaf meshes, %.2f M triangles", view.leaf_mesh_instance_count,
              1e-6 * static_cast<double>(view.drawn_leaf_mesh_triangle_count));
  ImGui::Text("memory   %.1f of %.0f MiB", static_cast<double>(stats.memory_bytes) / kMebibyte,
              static_cast<double>(stats.memory_budget_bytes) / kMebibyte);
}

// A bar a pass, the longest as wide as the panel's plot.
void show_passes(const coppice_view_stats& stats, const SceneTimes& scene_times) {
  std::array<float, kPassNames.size()> times_ms{};
  std::ranges::copy(scene_times, std::copy_n(stats.pass_ms, COPPICE_PASS_COUNT, times_ms.begin()));
  const float longest_ms = std::max(*std::ranges::max_element(times_ms), 1e-3f);
  for (std::size_t i = 0; i < times_ms.size(); ++i) {
    char label[32];
    std::snprintf(label, sizeof label, "%s %.2f ms", kPassNames[i], static_cast<double>(times_ms[i]));
    ImGui::ProgressBar(times_ms[i] / longest_ms, {320, 0}, label);
  }
}

void show_controls(Controls& controls, const OverlayFigures& figures) {
  ImGui::SliderFloat("error, px", &controls.error_px, 0.25f, 32, "%.2f", ImGuiSliderFlags_Logarithmic);
  ImGui::SliderFloat("wind, m/s", &controls.wind_mps, 0, 25, "%.1f");
  ImGui::SliderFloat("frame, ms (0: any)", &controls.frame_ms, 0, 200, "%.0f");
  ImGui::Text("drawn at %u x %u", figures.drawn.width, figures.drawn.height);
  if (figures.leaf_budget > 0) ImGui::Text("leaf budget %.0f thousand", 1e-3 * static_cast<double>(figures.leaf_budget));
  ImGui::SliderInt("memory, MiB", &controls.memory_mb, 8, 1024, "%d", ImGuiSliderFlags_Logarithmic);
  if (ImGui::RadioButton("cut", controls.lod == LodMode::cut)) controls.lod = LodMode::cut;
  ImGui::SameLine();
  if (ImGui::RadioButton("seven levels", controls.lod == LodMode::discrete)) controls.lod = LodMode::discrete;
  ImGui::SameLine();
  if (ImGui::RadioButton("every leaf", controls.lod == LodMode::full)) controls.lod = LodMode::full;
  constexpr std::array kViews = {"light", "lod", "path", "overdraw", "occlusion", "error", "residency"};
  static_assert(kViews.size() == static_cast<std::size_t>(DebugView::count));
  auto view = static_cast<int>(controls.view);
  if (ImGui::Combo("view", &view, kViews.data(), static_cast<int>(kViews.size()))) controls.view = static_cast<DebugView>(view);
}

constexpr float kMargin = 12;
constexpr ImGuiWindowFlags kLabel = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoInputs |
                                    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing;

/// Fits the next window to its content, but not larger than the picture; the rest can be scrolled to.
void keep_inside(const ImVec2& display) {
  const ImVec2 most{std::max(display.x - 2 * kMargin, 1.0f), std::max(display.y - 2 * kMargin, 1.0f)};
  ImGui::SetNextWindowSizeConstraints({0, 0}, most);
}

/// Text without a frame to grab, broken where the picture ends.
void show_label(const char* name, const std::string& text, float display_width) {
  ImGui::SetNextWindowBgAlpha(0.5f);
  ImGui::Begin(name, nullptr, kLabel);
  ImGui::PushTextWrapPos(std::max(display_width - 3 * kMargin, 1.0f));
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::End();
}

void show_line(const Overlay& overlay, const OverlayFigures& figures, const ImVec2& display) {
  const auto drawn = static_cast<std::ptrdiff_t>(std::min(overlay.frame_count, overlay.frame_ms.size()));
  const float mean_ms = std::accumulate(overlay.frame_ms.begin(), overlay.frame_ms.begin() + drawn, 0.0f) / static_cast<float>(drawn);
  char text[128];
  std::snprintf(text, sizeof text, "%.0f frames/s   %llu leaves   error %.2f px   H: keys, Tab: more",
                1000 / std::max(1e-3, double{mean_ms}), static_cast<unsigned long long>(figures.view.drawn_leaf_count),
                double{figures.view.threshold_px});
  ImGui::SetNextWindowPos({kMargin, kMargin});
  show_label("line", text, display.x);
}

void show_help(const ImVec2& display) {
  keep_inside(display);
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::Begin("Keys", nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse);
  for (const WindowKey& key : kWindowKeys) ImGui::Text("%-10s %s", key.key, key.what);
  ImGui::End();
}

void show_panel(Overlay& overlay, const OverlayFigures& figures, Controls& controls, const ImVec2& display) {
  keep_inside(display);
  ImGui::SetNextWindowPos({kMargin, kMargin}, ImGuiCond_FirstUseEver);
  ImGui::Begin("Coppice", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  const float slowest = *std::ranges::max_element(overlay.frame_ms);
  char label[48];
  std::snprintf(label, sizeof label, "%.1f ms, worst %.1f", static_cast<double>(figures.frame_ms), static_cast<double>(slowest));
  ImGui::PlotLines("##frame", overlay.frame_ms.data(), static_cast<int>(overlay.frame_ms.size()),
                   static_cast<int>(overlay.frame_count % overlay.frame_ms.size()), label, 0, std::max(33.0f, slowest), {320, 56});
  show_statistics(figures.stats, figures.view);
  if (figures.scene_times != nullptr) show_passes(figures.view, *figures.scene_times);
  show_streaming(overlay, figures.stats);
  show_controls(controls, figures);
  ImGui::End();
}

}  // namespace

Overlay::Overlay(const Device& device_in, const Window& window, VkFormat color_format) : device(device_in) {
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // leave no file behind
  ImGui::GetIO().BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  ImGui_ImplGlfw_InitForOther(window.handle, true);
  font = create_font(device);
  sampler = create_sampler(device, VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE);
  set_layout = create_set_layout(device, std::array{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  pipeline_layout = create_pipeline_layout(device, set_layout, sizeof(Push));
  create_set(*this);
  create_overlay_pipeline(*this, color_format);
}

Overlay::~Overlay() {
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void show_message(Overlay& overlay, std::string text) {
  constexpr float kShown_ms = 5000;
  overlay.message = std::move(text);
  overlay.message_left_ms = kShown_ms;
}

void layout_overlay(Overlay& overlay, const Window& window, const OverlayFigures& figures, Controls& controls) {
  if (figures.frame_ms > 0) overlay.frame_ms[overlay.frame_count++ % overlay.frame_ms.size()] = figures.frame_ms;
  constexpr float kMostOfAFrame_ms = 250;  // what was said during a long frame is to be seen all the same
  overlay.message_left_ms -= std::min(figures.frame_ms, kMostOfAFrame_ms);
  update_rates(overlay, figures.stats, figures.frame_ms);
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  if (!overlay.hidden) {
    if (window.overlay == OverlayDetail::line && overlay.frame_count > 0) show_line(overlay, figures, display);
    if (window.overlay == OverlayDetail::all) show_panel(overlay, figures, controls, display);
    if (window.help_visible) show_help(display);
    if (overlay.message_left_ms > 0) {
      ImGui::SetNextWindowPos({kMargin, display.y - kMargin}, ImGuiCond_Always, {0, 1});
      show_label("message", overlay.message, display.x);
    }
  }
  ImGui::Render();
}

void record_overlay(Overlay& overlay, VkCommandBuffer commands, std::size_t slot, VkExtent2D extent) {
  const ImDrawData& data = *ImGui::GetDrawData();
  if (data.TotalIdxCount == 0) return;
  const VkDeviceSize index_offset = copy_geometry(overlay, slot, data);
  const Buffer& buffer = overlay.geometry[slot];
  const VkDeviceSize vertex_offset = 0;
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, overlay.pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, overlay.pipeline_layout, 0, 1, &overlay.set, 0, nullptr);
  vkCmdBindVertexBuffers(commands, 0, 1, buffer.buffer.address(), &vertex_offset);
  vkCmdBindIndexBuffer(commands, buffer.buffer, index_offset, VK_INDEX_TYPE_UINT16);
  static_assert(sizeof(ImDrawIdx) == 2);
  const Push push{{2 / data.DisplaySize.x, 2 / data.DisplaySize.y}, {-1, -1}};
  vkCmdPushConstants(commands, overlay.pipeline_layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof push, &push);
  record_viewport(commands, extent);
  const float pixels = data.FramebufferScale.x;
  std::uint32_t first_index = 0;
  std::int32_t first_vertex = 0;
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ImVec4& clip = command.ClipRect;
      const VkRect2D scissor = scissor_of({clip.x * pixels, clip.y * pixels, clip.z * pixels, clip.w * pixels}, extent);
      vkCmdSetScissor(commands, 0, 1, &scissor);
      vkCmdDrawIndexed(commands, command.ElemCount, 1, first_index + command.IdxOffset,
                       first_vertex + static_cast<std::int32_t>(command.VtxOffset), 0);
    }
    first_index += static_cast<std::uint32_t>(list.IdxBuffer.Size);
    first_vertex += list.VtxBuffer.Size;
  }
}

bool overlay_uses_mouse() {
  return ImGui::GetIO().WantCaptureMouse;
}

}  // namespace forest
