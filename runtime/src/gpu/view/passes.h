#pragma once

// What draws plants by the hardware: the set that every shader reads, and the pipelines.

#include <array>
#include <cstdint>

#include "attachments.h"
#include "coppice_shared.h"
#include "descriptor_sets.h"
#include "pipelines.h"
#include "result.h"
#include "texture_sets.h"

namespace coppice::gpu {

/// What is drawn: each has a pipeline for each kind of attachments. Plain is of one colour, textured has a base colour texture, relief a
/// normal map too. A plain surface is drawn with early depth tests unless some of its leaves have gaps.
enum class DrawKind : std::uint8_t {
  leaf_plain,
  leaf_textured,
  leaf_plain_with_gaps,
  wood_plain,
  wood_textured,
  wood_relief_plain,
  wood_relief_textured,
  mesh_plain,
  mesh_textured,
  mesh_relief_plain,
  mesh_relief_textured,
  count
};
inline constexpr std::size_t kDrawKinds = static_cast<std::size_t>(DrawKind::count);

constexpr DrawKind leaf_kind(std::uint32_t texture, bool has_gaps) {
  if (texture != kNoTexture) return DrawKind::leaf_textured;
  return has_gaps ? DrawKind::leaf_plain_with_gaps : DrawKind::leaf_plain;
}

/// mesh: a wood LoD, or from kMaxWoodLods on a chunk of leaf meshes
constexpr DrawKind mesh_kind(std::uint32_t mesh, bool textured, bool relief) {
  const DrawKind first = mesh < kMaxWoodLods ? DrawKind::wood_plain : DrawKind::mesh_plain;
  return static_cast<DrawKind>(static_cast<std::uint32_t>(first) + (relief ? 2u : 0u) + (textured ? 1u : 0u));
}

/// What draws views on one kind of attachments. Null where there is none: depth alone has neither relief nor leaf meshes.
struct DrawPipelines {
  AttachmentDesc attachments;
  std::array<Pipeline*, kDrawKinds> kinds{};
  Pipeline* resolve = nullptr;  ///< of the rasteriser's picture; null without one

  [[nodiscard]] Pipeline* of(DrawKind kind) const { return kinds[static_cast<std::size_t>(kind)]; }
  /// Draws `kind`. Until that is built it is the one for textures: a surface without one finds the placeholder, which is white, and looks
  /// the same. Null: neither is there.
  [[nodiscard]] VkPipeline drawing(DrawKind kind, DrawKind textured) const {
    const VkPipeline own = of(kind)->handle();
    return own != VK_NULL_HANDLE ? own : of(textured)->handle();
  }
};

/// A pass over instances, for views of one eye and of two.
struct EyePipelines {
  std::array<Pipeline*, kMostEyes> by_eyes{};

  [[nodiscard]] Pipeline* of(std::uint32_t eye_count) const { return by_eyes[eye_count - 1]; }
};

/// One that also colours instances for a debug view, where there is one.
struct CullPipelines {
  EyePipelines plain, debug;

  [[nodiscard]] Pipeline* of(coppice_debug_view debug_view, std::uint32_t eye_count) const {
    return (debug_view == COPPICE_DEBUG_NONE ? plain : debug).of(eye_count);
  }
};

/// add(eye_count) adds a pipeline.
template <class Add>
EyePipelines for_each_eye_count(const Add& add) {
  EyePipelines added;
  for (std::uint32_t eyes = 1; eyes <= kMostEyes; ++eyes) added.by_eyes[eyes - 1] = add(eyes);
  return added;
}

/// Buffers of set 0, in binding order (bindings.glsl); the shadow maps, the occluders, the wind's maps and what has
/// moved come after them.
enum class FrameBinding : std::uint32_t {
  view,
  instances,
  plants,
  tables,
  cuts,
  wood_list,
  leaf_commands,
  draw_counts,
  wood_commands,
  counters
};
inline constexpr std::uint32_t kFrameBuffers = 10;
inline constexpr std::uint32_t kFrameStorageBuffers = kFrameBuffers - 3;  ///< all but the view, instances and tables

/// That DrawPush is for.
inline constexpr VkShaderStageFlags kDrawStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

/// What all views share.
struct Passes {
  SetLayout frame_set;
  VkSampler map_sampler = VK_NULL_HANDLE;    ///< texels of depth as they are
  VkPipelineLayout layout = VK_NULL_HANDLE;  ///< the frame's set, those of a texture and of a normal map, and DrawPush
  CullPipelines cull;
};

/// None of the pipelines is wanted yet. errors  out_of_memory, device_lost; unsupported: a stage sees too few storage buffers. What was
/// created so far is in `passes`, to be destroyed in any case
Result<void> create_passes(Device& device, const TextureSets& textures, PipelineSet& pipelines, Passes& passes);
/// The pipelines are closed.
void destroy_passes(Device& device, Passes& passes);

/// Without `resolve`; none is wanted yet.
DrawPipelines add_draw_pipelines(const Passes& passes, const AttachmentDesc& attachments, PipelineSet& pipelines);

struct FrameBindings {
  std::array<const Buffer*, kFrameBuffers> buffers{};  ///< by FrameBinding
  std::array<VkImageView, kMaxShadowMaps> maps{};
  std::array<VkImageView, kMostEyes> occluders{};
  const Buffer* wind_maps = nullptr;
  const Buffer* moved = nullptr;
};
Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const FrameBindings& bindings);
/// set: of create_frame_set; the GPU must be done with it
void write_frame_set(Device& device, const Passes& passes, const DescriptorSet& set, const FrameBindings& bindings);

}  // namespace coppice::gpu
