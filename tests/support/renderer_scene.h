#pragma once

// A renderer with plants in it and a camera, without files and without a streamer: what is resident is what the test uploads.

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "hook_array.h"
#include "made_mesh.h"
#include "picture.h"
#include "plant.h"
#include "renderer.h"
#include "shot.h"
#include "vulkan_device.h"

namespace coppice::test {

/// A front that can be copied: without its chunk table, which the renderer does not look at.
struct DecodedFront : PlantFile {
  DecodedFront() = default;
  DecodedFront(const DecodedFront& other)
      : PlantFile{other.header,
                  {},
                  other.plant,
                  copied(other.materials),
                  copied(other.cards),
                  copied(other.error_leaf_counts),
                  copied(other.error_sizes_px),
                  copied(other.error_px),
                  other.wind,
                  copied(other.wind_nodes),
                  copied(other.leaf_meshes),
                  copied(other.wood_error_px),
                  copied(other.textures),
                  hook_arrays(other.small_textures),
                  copied(other.leaf_mesh_error_px)} {}
  DecodedFront(DecodedFront&&) = default;
  DecodedFront& operator=(DecodedFront other) {
    PlantFile::operator=(std::move(other));
    return *this;
  }
  ~DecodedFront() = default;
};

/// A baked plant as the runtime would have decoded it.
struct DecodedPlant {
  DecodedFront file;
  std::vector<std::uint32_t> lod_words;
  std::vector<PageNode> nodes;  ///< [2N - 1]
  std::vector<MadeMesh> wood;
  std::vector<std::vector<std::uint8_t>> textures;  ///< TEXTURE chunks with one mip level each
  std::vector<MadeMesh> leaf_meshes;
};

DecodedPlant decoded_plant(const bake::BakedPlant& baked);

struct CameraDesc {
  glm::vec3 eye_m{0.0f, 1.0f, 4.0f};
  glm::vec3 target_m{0.0f};
  float vertical_fov_radians = 0.8f;
  std::uint32_t width_px = 256, height_px = 0;  ///< 0: as high as wide
  float error_px = 2.0f;
  coppice_lod_mode lod = COPPICE_LOD_CUT;
  coppice_view view = 0;
};

/// Reversed, infinite depth; a low sun behind the camera's right shoulder; no fog.
Shot make_view(const CameraDesc& camera);

/// Records `before`, then `inside` a pass on a white R8G8B8A8_SRGB and a D32_SFLOAT attachment of the view's size; submits and waits.
Picture draw_on_white(const VulkanDevice& gpu, const Shot& view, const std::function<void(VkCommandBuffer)>& before,
                      const std::function<void(VkCommandBuffer)>& inside, float clear_depth = 0.0f);

struct SceneOptions {
  std::uint64_t memory_budget_bytes = 64ull << 20;
  bool compute_raster = false;
  bool int64_atomics = true;       ///< where the device has them; without, its draws have no counts either
  std::optional<bool> many_lanes;  ///< RendererDesc's
  VkCompareOp depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  PFN_vkAllocateMemory allocate_memory = nullptr;  ///< instead of the device's; frames may then fail
};

class RendererScene {
 public:
  RendererScene(const VulkanDevice& gpu, std::uint32_t max_instances, const SceneOptions& options = {});

  /// Uploads the first page_count pages (all of them if there are fewer), and all wood, textures and leaf meshes unless page_count is 0.
  std::uint32_t add_plant(const DecodedPlant& plant, std::uint32_t page_count = 0xffffffffu);
  void place(std::uint32_t plant, const std::vector<coppice_placement>& placements);
  [[nodiscard]] gpu::Renderer& renderer() { return *renderer_; }
  gpu::InstanceTable& instances() { return instances_; }
  /// As when pages have been evicted.
  void set_resident_leaves(std::uint32_t plant, std::uint32_t leaf_count) { lod_plants_[plant].resident_leaf_count = leaf_count; }

  /// Whether record_upload_end failed in the last frame.
  [[nodiscard]] bool upload_failed() const { return upload_failed_; }

  /// Uploads what is new and culls; the cut of every instance slot.
  std::vector<float> select(const Shot& view);

  struct Frame {
    Picture picture;
    gpu::FrameCounts counts;
  };
  /// Uploads what is new, culls, draws on white, waits.
  Frame draw(const Shot& view);
  /// As a view of COPPICE_OUTPUT_DEPTH: its depth, 0 where nothing is.
  std::vector<float> draw_depth(const Shot& view);

 private:
  struct Pending {
    std::uint32_t index;
    DecodedPlant plant;
    std::uint32_t page_count;
    gpu::PlantLooks looks;
    gpu::CrownLight light;
  };
  void upload(VkCommandBuffer cmd);
  void begin_frame(std::uint32_t view, const Shot& shot);
  void record_selection(VkCommandBuffer cmd, std::uint32_t view, const Shot& shot);
  void upload_plant(const Pending& pending);

  const VulkanDevice& gpu_;
  Ledger ledger_;
  std::unique_ptr<gpu::Renderer> renderer_;
  gpu::InstanceTable instances_;
  std::vector<LodPlant> lod_plants_;
  std::vector<Pending> pending_;
  std::uint32_t plant_count_ = 0;
  std::uint32_t view_ = 0;
  std::optional<std::uint32_t> depth_view_;  ///< once something is drawn to depth alone
  bool frames_may_fail_ = false, upload_failed_ = false;
  float clear_depth_ = 0.0f;
  std::uint64_t frame_ = 0;
};

}  // namespace coppice::test
