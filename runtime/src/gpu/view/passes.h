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

/// One for surfaces of one colour, one for those with a base colour texture. Null where there are none.
struct SurfacePipelines {
  Pipeline *plain = nullptr, *textured = nullptr;

  [[nodiscard]] Pipeline* of(std::uint32_t texture) const { return texture == kNoTexture ? plain : textured; }
};

/// A surface of one colour is drawn with early depth tests unless some of its leaves have gaps.
struct LeafPipelines {
  SurfacePipelines surface;
  Pipeline* plain_with_gaps = nullptr;

  [[nodiscard]] Pipeline* of(std::uint32_t texture, bool has_gaps) const {
    return has_gaps && texture == kNoTexture ? plain_with_gaps : surface.of(texture);
  }
};

struct MeshPipelines {
  SurfacePipelines flat, relief;  ///< without and with a normal map
};

/// What draws a view.
struct DrawPipelines {
  LeafPipelines leaf;
  MeshPipelines wood, leaf_mesh;
};

/// A pass over instances, and the one that also colours them for a debug view.
struct CullPipelines {
  Pipeline *plain = nullptr, *debug = nullptr;

  [[nodiscard]] Pipeline* of(coppice_debug_view debug_view) const { return debug_view == COPPICE_DEBUG_NONE ? plain : debug; }
};

/// Buffers of set 0, in binding order (bindings.glsl); the shadow maps come after them.
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

struct Passes {
  SetLayout frame_set;
  VkSampler map_sampler = VK_NULL_HANDLE;    ///< texels of shadow maps as they are
  VkPipelineLayout layout = VK_NULL_HANDLE;  ///< the frame's set, those of a texture and of a normal map, and DrawPush
  CullPipelines cull;
  DrawPipelines camera;
  DrawPipelines shadow;  ///< depth alone, without relief and leaf meshes; null where there are no shadow views
};

/// None of the pipelines is wanted yet. errors  out_of_memory, device_lost. What was created so far is in `passes`, to be destroyed in any
/// case
Result<void> create_passes(Device& device, const AttachmentDesc& attachments, const TextureSets& textures, PipelineSet& pipelines,
                           Passes& passes);
/// The pipelines are closed.
void destroy_passes(Device& device, Passes& passes);

struct FrameBindings {
  std::array<const Buffer*, kFrameBuffers> buffers{};  ///< by FrameBinding
  std::array<VkImageView, kMaxCascades> maps{};
};
Result<DescriptorSet> create_frame_set(Device& device, const Passes& passes, const FrameBindings& bindings);

}  // namespace coppice::gpu
