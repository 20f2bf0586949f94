#pragma once

// Our renderer as a context's backend.

#include <memory>

#include "backend.h"
#include "coppice/vulkan.h"
#include "renderer.h"

namespace coppice {

/// The checked arguments of coppice_vulkan_context_create. The desc's own pointer to a hook is not used.
struct VulkanOptions {
  coppice_vulkan_desc desc{};
  coppice_device_memory device_memory{};
};

class VulkanBackend final : public Backend {
 public:
  /// errors  unsupported, out_of_memory, device_lost, internal
  static Result<std::unique_ptr<Backend>> create(const VulkanOptions& vulkan, const BackendOptions& options);

  [[nodiscard]] const BackendLimits& limits() const override { return limits_; }
  void set_memory_budget(std::uint64_t bytes) override { renderer_->set_memory_budget(bytes); }
  [[nodiscard]] std::uint64_t reserved_bytes() const override { return gpu::committed_bytes(renderer_->device().memory); }
  [[nodiscard]] std::uint64_t lasting_bytes(std::uint32_t slots, std::uint64_t budget_bytes) override {
    return renderer_->lasting_bytes(slots, budget_bytes);
  }
  [[nodiscard]] bool shrink(std::uint32_t slots) override { return renderer_->shrink(slots); }
  void release_pictures() override { renderer_->release_pictures(); }
  [[nodiscard]] Result<void> device_state() const override { return renderer_->device_state(); }
  void fill_stats(coppice_stats& stats) const override;
  [[nodiscard]] std::uint32_t plant_capacity() const override { return renderer_->capacity().plants; }
  [[nodiscard]] std::uint64_t reserve_bytes(const SceneSize& needed) override {
    return renderer_->reserve_bytes({needed.slots, needed.plants});
  }
  Result<void> reserve(const SceneSize& needed) override { return renderer_->reserve({needed.slots, needed.plants}); }
  [[nodiscard]] std::uint64_t slot_upload_bytes(std::uint32_t slots) const override { return renderer_->slot_upload_bytes(slots); }
  Result<void> add_plant(std::uint32_t plant, const PlantFile& file, const gpu::PlantAppearance& appearance,
                         std::span<const std::uint32_t> lod_words) override {
    return renderer_->add_plant(plant, file, appearance, lod_words);
  }
  void remove_plant(std::uint32_t plant) override { renderer_->remove_plant(plant); }
  void begin_frame(std::uint64_t frame_number, std::uint64_t completed_number, const FrameWind& wind) override;
  [[nodiscard]] std::uint64_t staging_bytes() const override { return renderer_->staging_bytes(); }
  Result<bool> upload_chunk(const DecodedChunk& chunk, std::uint64_t max_bytes) override;
  void abandon_upload() override { renderer_->plants().abandon_upload(); }
  void hide_chunk(ChunkId id) override;
  void drop_chunk(ChunkId id) override;
  Result<void> end_upload(gpu::InstanceTable& instances, std::span<const LodPlant> plants) override {
    return renderer_->record_upload_end(instances, plants);
  }
  void remove_view(std::uint32_t view) override { renderer_->remove_view(view); }
  void show_view(std::uint32_t view, const coppice_camera& camera, const LodView& lod) override;
  [[nodiscard]] bool has_reversed_depth(std::uint32_t view) const override;
  [[nodiscard]] std::optional<ViewCounts> view_counts(std::uint32_t view) const override;
  [[nodiscard]] gpu::Renderer* renderer() override { return renderer_.get(); }

 private:
  explicit VulkanBackend(std::unique_ptr<gpu::Renderer> renderer);
  [[nodiscard]] const gpu::ViewRecorder& view(std::uint32_t index) const { return std::as_const(*renderer_).view(index); }

  std::unique_ptr<gpu::Renderer> renderer_;
  FrameWind wind_;
  BackendLimits limits_;
};

}  // namespace coppice
