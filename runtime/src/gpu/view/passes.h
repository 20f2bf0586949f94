#pragma once

// Drawing by the hardware: the set that every shader reads, and the pipelines.

#include <array>
#include <cstdint>

#include "attachments.h"
#include "coppice_shared.h"
#include "descriptor_sets.h"
#include "pipelines.h"
#include "result.h"
#include "texture_sets.h"

namespace coppice::gpu {

/// Kinds of draws; each has a pipeline for each kind of attachments. A plain surface has one colour, a textured one a base colour texture,
/// relief also a normal map. A plain surface is drawn with early depth tests unless some of its leaves are transparent.
enum class DrawKind : std::uint8_t {
  leaf_plain,
  leaf_textured,
  leaf_plain_transparent,
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

constexpr DrawKind leaf_kind(std::uint32_t texture, bool has_transparency) {
  if (texture != kNoTexture) return DrawKind::leaf_textured;
  return has_transparency ? DrawKind::leaf_plain_transparent : DrawKind::leaf_plain;
}

/// mesh: a wood LoD, or kMaxWoodLods + a chunk of leaf meshes
constexpr DrawKind mesh_kind(std::uint32_t mesh, bool textured, bool relief) {
  const DrawKind first = mesh < kMaxWoodLods ? DrawKind::wood_plain : DrawKind::mesh_plain;
  return static_cast<DrawKind>(static_cast<std::uint32_t>(first) + (relief ? 2u : 0u) + (textured ? 1u : 0u));
}

/// The pipelines for one kind of attachments. Null if there is none: views of only depth have neither relief nor leaf meshes.
struct DrawPipelines {
  AttachmentDesc attachments;
  std::array<Pipeline*, kDrawKinds> kinds{};
  Pipeline* resolve = nullptr;  ///< for the rasteriser's picture; null without a rasteriser

  [[nodiscard]] Pipeline* of(DrawKind kind) const { return kinds[static_cast<std::size_t>(kind)]; }
  /// Returns the pipeline of `kind`. Until that is built it returns the one for textures, which looks the same: a surface without a texture
  /// reads the placeholder, which is white. Null if neither is built.
  [[nodiscard]] VkPipeline drawing(DrawKind kind, DrawKind textured) const {
    const VkPipeline own = of(kind)->handle();
    return own != VK_NULL_HANDLE ? own : of(textured)->handle();
  }
};

/// Pipelines of a pass over instances, for views of one eye and of two.
struct EyePipelines {
  std::array<Pipeline*, kMaxEyes> by_eyes{};

  [[nodiscard]] Pipeline* of(std::uint32_t eye_count) const { return by_eyes[eye_count - 1]; }
};

/// The pass, and a variant that also colours instances for a debug view, if there is one.
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
  for (std::uint32_t eyes = 1; eyes <= kMaxEyes; ++eyes) added.by_eyes[eyes - 1] = add(eyes);
  return added;
}

/// Buffers of set 0, in binding order (bindings.glsl). Shadow maps, occluders, the wind's maps and moved instances come after them.
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

/// The stages that DrawPush is for.
inline constexpr VkShaderStageFlags kDrawStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

/// Objects that all views share.
struct Passes {
  SetLayout frame_set;
  VkSampler map_sampler = VK_NULL_HANDLE;    ///< reads texels of depth unfiltered
  VkPipelineLayout layout = VK_NULL_HANDLE;  ///< the frame's set, the sets of a texture and of a normal map, and DrawPush
  CullPipelines cull;
};

/// None of the pipelines is requested yet. On errors `passes` holds what was created so far; it must be destroyed in any case. errors
/// out_of_memory, device_lost; unsupported: a stage sees too few storage buffers
Result<void> create_passes(Device& device, const TextureSets& textures, PipelineSet& pipelines, Passes& passes);
/// Before: the pipelines are closed.
void destroy_passes(Device& device, Passes& passes);

/// Adds all pipelines but `resolve`; none is requested yet.
DrawPipelines add_draw_pipelines(const Passes& passes, const AttachmentDesc& attachments, PipelineSet& pipelines);

struct FrameBindings {
  std::array<const Buffer*, kFrameBuffers> buffers{};  ///< by FrameBinding
  std::array<VkImageView, kMaxShadowMaps> maps{};
  std::array<VkImageView, kMaxEyes> occluders{};
  const Buffer* wind_maps = nullptr;
  const Buffer* moved = nullptr;
};
Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const FrameBindings& bindings);
/// set: from create_frame_set; the GPU must be done with it
void write_frame_set(Device& device, const Passes& passes, const DescriptorSet& set, const FrameBindings& bindings);

}  // namespace coppice::gpu
