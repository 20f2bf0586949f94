// COPPICE_TEST_REVERSE: of a command buffer's dispatches, copies and fills those that no barrier parts run in reverse. Vulkan promises
// no order of them, so that where a barrier is missing the picture is another.
//
// They are held back until a barrier, a render pass or the end, and then recorded from the last to the first. A dispatch has the pipeline,
// sets and push constants that were bound when it came.

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "layer_state.h"

namespace limits_layer {
namespace {

struct Sets {
  VkPipelineLayout layout;
  std::uint32_t first;
  std::vector<VkDescriptorSet> sets;
  std::vector<std::uint32_t> offsets;
};

struct Push {
  VkPipelineLayout layout;
  VkShaderStageFlags stages;
  std::uint32_t offset;
  std::vector<std::uint8_t> bytes;
};

/// What a dispatch takes of earlier commands, in their order: a later layout may disturb what an earlier one bound.
struct Bindings {
  VkPipeline pipeline = VK_NULL_HANDLE;
  std::vector<Sets> sets;
  std::vector<Push> pushes;
};

struct Held {
  Bindings bindings;
  std::function<void()> record;
};

struct Commands {
  Bindings bindings;
  std::vector<Held> held;
};

/// One thread at a time records a command buffer.
Commands& commands_of(VkCommandBuffer cmd) {
  static std::mutex mutex;
  static std::map<VkCommandBuffer, Commands> all;
  const std::lock_guard lock(mutex);
  return all[cmd];
}

void bind(VkCommandBuffer cmd, const Bindings& bindings) {
  const Device& device = device_of(cmd);
  constexpr VkPipelineBindPoint kCompute = VK_PIPELINE_BIND_POINT_COMPUTE;
  if (bindings.pipeline != VK_NULL_HANDLE) NEXT(device, CmdBindPipeline)(cmd, kCompute, bindings.pipeline);
  for (const Sets& it : bindings.sets) NEXT(device, CmdBindDescriptorSets)
  (cmd, kCompute, it.layout, it.first, static_cast<std::uint32_t>(it.sets.size()), it.sets.data(),
   static_cast<std::uint32_t>(it.offsets.size()), it.offsets.data());
  for (const Push& it : bindings.pushes)
    NEXT(device, CmdPushConstants)(cmd, it.layout, it.stages, it.offset, static_cast<std::uint32_t>(it.bytes.size()), it.bytes.data());
}

void record_held(VkCommandBuffer cmd) {
  Commands& commands = commands_of(cmd);
  if (commands.held.empty()) return;
  for (auto held = commands.held.rbegin(); held != commands.held.rend(); ++held) {
    bind(cmd, held->bindings);
    held->record();
  }
  commands.held.clear();
  bind(cmd, commands.bindings);
}

void hold(VkCommandBuffer cmd, std::function<void()> record) {
  Commands& commands = commands_of(cmd);
  commands.held.push_back({commands.bindings, std::move(record)});
}

VkResult begin_command_buffer(VkCommandBuffer cmd, const VkCommandBufferBeginInfo* info) {
  commands_of(cmd) = {};
  return NEXT(device_of(cmd), BeginCommandBuffer)(cmd, info);
}

void cmd_bind_pipeline(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipeline pipeline) {
  if (point == VK_PIPELINE_BIND_POINT_COMPUTE) commands_of(cmd).bindings.pipeline = pipeline;
  NEXT(device_of(cmd), CmdBindPipeline)(cmd, point, pipeline);
}

void cmd_bind_descriptor_sets(VkCommandBuffer cmd, VkPipelineBindPoint point, VkPipelineLayout layout, std::uint32_t first,
                              std::uint32_t count, const VkDescriptorSet* sets, std::uint32_t offset_count, const std::uint32_t* offsets) {
  if (point == VK_PIPELINE_BIND_POINT_COMPUTE) {
    std::vector<Sets>& bound = commands_of(cmd).bindings.sets;
    std::erase_if(bound, [&](const Sets& it) { return it.layout == layout && it.first == first && it.sets.size() <= count; });
    bound.push_back({layout, first, {sets, sets + count}, {offsets, offsets + offset_count}});
  }
  NEXT(device_of(cmd), CmdBindDescriptorSets)(cmd, point, layout, first, count, sets, offset_count, offsets);
}

void cmd_push_constants(VkCommandBuffer cmd, VkPipelineLayout layout, VkShaderStageFlags stages, std::uint32_t offset, std::uint32_t size,
                        const void* values) {
  std::vector<Push>& pushes = commands_of(cmd).bindings.pushes;
  std::erase_if(
      pushes, [&](const Push& it) { return it.layout == layout && it.stages == stages && it.offset == offset && it.bytes.size() <= size; });
  const auto* const bytes = static_cast<const std::uint8_t*>(values);
  pushes.push_back({layout, stages, offset, {bytes, bytes + size}});
  NEXT(device_of(cmd), CmdPushConstants)(cmd, layout, stages, offset, size, values);
}

void cmd_update_buffer(VkCommandBuffer cmd, VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size, const void* data) {
  const auto* const bytes = static_cast<const std::uint8_t*>(data);
  hold(cmd, [=, copy = std::vector<std::uint8_t>(bytes, bytes + size)] {
    NEXT(device_of(cmd), CmdUpdateBuffer)(cmd, buffer, offset, size, copy.data());
  });
}

void cmd_copy_buffer(VkCommandBuffer cmd, VkBuffer from, VkBuffer to, std::uint32_t count, const VkBufferCopy* regions) {
  hold(cmd, [=, copy = std::vector<VkBufferCopy>(regions, regions + count)] {
    NEXT(device_of(cmd), CmdCopyBuffer)(cmd, from, to, count, copy.data());
  });
}

void cmd_copy_buffer_to_image(VkCommandBuffer cmd, VkBuffer from, VkImage to, VkImageLayout layout, std::uint32_t count,
                              const VkBufferImageCopy* regions) {
  hold(cmd, [=, copy = std::vector<VkBufferImageCopy>(regions, regions + count)] {
    NEXT(device_of(cmd), CmdCopyBufferToImage)(cmd, from, to, layout, count, copy.data());
  });
}

}  // namespace

void hold_dispatch(VkCommandBuffer cmd, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  hold(cmd, [=] { NEXT(device_of(cmd), CmdDispatch)(cmd, x, y, z); });
}

PFN_vkVoidFunction reversed_function(std::string_view name) {
#define HELD(call) \
  OURS(call, [](VkCommandBuffer cmd, auto... arguments) { hold(cmd, [=] { NEXT(device_of(cmd), call)(cmd, arguments...); }); })
  // What others are not moved across.
#define FENCE(call)                                       \
  OURS(call, [](VkCommandBuffer cmd, auto... arguments) { \
    record_held(cmd);                                     \
    return NEXT(device_of(cmd), call)(cmd, arguments...); \
  })
  static const Functions hooks{OURS(BeginCommandBuffer, begin_command_buffer),
                               OURS(CmdBindPipeline, cmd_bind_pipeline),
                               OURS(CmdBindDescriptorSets, cmd_bind_descriptor_sets),
                               OURS(CmdPushConstants, cmd_push_constants),
                               OURS(CmdUpdateBuffer, cmd_update_buffer),
                               OURS(CmdCopyBuffer, cmd_copy_buffer),
                               OURS(CmdCopyBufferToImage, cmd_copy_buffer_to_image),
                               HELD(CmdDispatchIndirect),
                               HELD(CmdFillBuffer),
                               FENCE(CmdPipelineBarrier),
                               FENCE(CmdPipelineBarrier2),
                               FENCE(CmdBeginRendering),
                               FENCE(CmdBeginRenderPass),
                               FENCE(CmdBeginRenderPass2),
                               FENCE(CmdBlitImage),
                               FENCE(CmdClearColorImage),
                               FENCE(CmdClearDepthStencilImage),
                               FENCE(CmdCopyImage),
                               FENCE(CmdCopyImageToBuffer),
                               FENCE(CmdCopyQueryPoolResults),
                               FENCE(CmdExecuteCommands),
                               FENCE(CmdResolveImage),
                               FENCE(EndCommandBuffer)};
  return layer::find_function(hooks, name);
}

}  // namespace limits_layer
