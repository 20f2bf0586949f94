#ifndef COPPICE_HPP
#define COPPICE_HPP

// C++20 over coppice.h: ownership and spans, no behaviour of its own. Same contracts, same statuses, nothing throws.

#include <cstdint>
#include <span>
#include <utility>

#include "coppice/coppice.h"

namespace coppice {

/// A struct of the C API with its defaults filled in.
[[nodiscard]] inline coppice_context_desc make_context_desc() {
  coppice_context_desc desc;
  coppice_context_desc_init(&desc);
  return desc;
}
[[nodiscard]] inline coppice_view make_view() {
  coppice_view view;
  coppice_view_init(&view);
  return view;
}

/// Owns a coppice_context; the GPU must have finished what it recorded when it is destroyed or reset.
class ContextHandle {
 public:
  ContextHandle() = default;
  ~ContextHandle() { reset(); }
  ContextHandle(ContextHandle&& other) noexcept : context_(std::exchange(other.context_, nullptr)) {}
  ContextHandle& operator=(ContextHandle&& other) noexcept {
    std::swap(context_, other.context_);
    return *this;
  }

  /// Replaces what is owned. On error nothing is owned.
  [[nodiscard]] coppice_status create(const coppice_context_desc& desc) {
    reset();
    return coppice_context_create(&desc, &context_);
  }
  void reset() { coppice_context_destroy(std::exchange(context_, nullptr)); }
  [[nodiscard]] coppice_context* get() const { return context_; }
  explicit operator bool() const { return context_ != nullptr; }

  [[nodiscard]] coppice_status open(const char* path, coppice_plant& plant) { return coppice_plant_open(context_, path, &plant); }
  [[nodiscard]] coppice_status close(coppice_plant plant) { return coppice_plant_close(context_, plant); }
  [[nodiscard]] coppice_status info(coppice_plant plant, coppice_plant_info& info) const {
    coppice_plant_info_init(&info);
    return coppice_plant_get_info(context_, plant, &info);
  }

  /// handles: as long as placements, or empty. errors  invalid_argument: neither
  [[nodiscard]] coppice_status add(coppice_plant plant, std::span<const coppice_placement> placements,
                                   std::span<coppice_instance> handles = {}) {
    if (!handles.empty() && handles.size() != placements.size()) return COPPICE_ERROR_INVALID_ARGUMENT;
    return coppice_instances_add(context_, plant, placements.data(), static_cast<std::uint32_t>(placements.size()),
                                 handles.empty() ? nullptr : handles.data());
  }
  [[nodiscard]] coppice_status move(coppice_instance instance, const coppice_placement& placement) {
    return coppice_instance_move(context_, instance, &placement);
  }
  [[nodiscard]] coppice_status remove(std::span<const coppice_instance> instances) {
    return coppice_instances_remove(context_, instances.data(), static_cast<std::uint32_t>(instances.size()));
  }

  [[nodiscard]] coppice_status open_scene(const char* path, coppice_scene& scene) { return coppice_scene_open(context_, path, &scene); }
  [[nodiscard]] coppice_status close_scene(coppice_scene scene) { return coppice_scene_close(context_, scene); }
  [[nodiscard]] coppice_status scene_plant(coppice_scene scene, std::uint32_t species, coppice_scene_plant_info& info) const {
    coppice_scene_plant_info_init(&info);
    return coppice_scene_get_plant(context_, scene, species, &info);
  }
  [[nodiscard]] coppice_status scene_info(coppice_scene scene, coppice_scene_info& info) const {
    coppice_scene_info_init(&info);
    return coppice_scene_get_info(context_, scene, &info);
  }

  [[nodiscard]] coppice_status begin_frame(std::uint64_t frame_number, std::uint64_t completed_number, const coppice_view& view) {
    coppice_frame frame;
    coppice_frame_init(&frame);
    frame.frame_number = frame_number;
    frame.completed_number = completed_number;
    frame.view = &view;
    return coppice_frame_begin(context_, &frame);
  }
  [[nodiscard]] coppice_status record_upload(VkCommandBuffer cmd) { return coppice_record_upload(context_, cmd); }
  [[nodiscard]] coppice_status record_cull(VkCommandBuffer cmd, const coppice_view& view) {
    return coppice_record_cull(context_, cmd, &view);
  }
  [[nodiscard]] coppice_status record_draw(VkCommandBuffer cmd, const coppice_view& view) {
    return coppice_record_draw(context_, cmd, &view);
  }

  [[nodiscard]] coppice_status stats(coppice_stats& stats) const {
    coppice_stats_init(&stats);
    return coppice_get_stats(context_, &stats);
  }

 private:
  coppice_context* context_ = nullptr;
};

}  // namespace coppice

#endif
