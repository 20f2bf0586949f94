#pragma once

// The backend of a host that draws itself.

#include <deque>
#include <memory>

#include "backend.h"

namespace coppice {

class HostBackend final : public Backend {
 public:
  /// errors  out_of_memory
  static Result<std::unique_ptr<Backend>> create(const BackendOptions& options);

  [[nodiscard]] const BackendLimits& limits() const override { return limits_; }
  void set_memory_budget(std::uint64_t) override {}
  [[nodiscard]] std::uint64_t reserved_bytes() const override { return 0; }
  [[nodiscard]] std::uint64_t lasting_bytes(std::uint32_t, std::uint64_t) override { return 0; }
  [[nodiscard]] bool shrink(std::uint32_t) override { return true; }
  void release_pictures() override {}
  [[nodiscard]] Result<void> device_state() const override { return {}; }
  void fill_stats(coppice_stats&) const override {}
  [[nodiscard]] std::uint32_t plant_capacity() const override { return limits_.max_plants; }
  [[nodiscard]] std::uint64_t reserve_bytes(const SceneSize&) override { return 0; }
  Result<void> reserve(const SceneSize&) override { return {}; }
  [[nodiscard]] std::uint64_t slot_upload_bytes(std::uint32_t) const override { return 0; }
  Result<void> add_plant(std::uint32_t, const PlantFile&, const gpu::PlantAppearance&, std::span<const std::uint32_t>) override {
    return {};
  }
  void remove_plant(std::uint32_t) override {}
  void begin_frame(std::uint64_t, std::uint64_t, const FrameWind&) override {}
  [[nodiscard]] std::uint64_t staging_bytes() const override { return 0; }
  Result<bool> upload_chunk(const DecodedChunk&, std::uint64_t) override { return true; }
  void abandon_upload() override {}
  void hide_chunk(ChunkId) override {}
  void drop_chunk(ChunkId) override {}
  Result<void> end_upload(gpu::InstanceTable&, std::span<const LodPlant>) override { return {}; }
  void remove_view(std::uint32_t) override {}
  void show_view(std::uint32_t, const coppice_camera&, const LodView&) override {}
  [[nodiscard]] bool has_reversed_depth(std::uint32_t) const override { return false; }
  [[nodiscard]] std::optional<ViewCounts> view_counts(std::uint32_t) const override { return std::nullopt; }
  bool tell(const BackendEvent& event) override;
  std::optional<BackendEvent> next_event() override;

 private:
  explicit HostBackend(const BackendLimits& limits) : limits_(limits) {}

  BackendLimits limits_;
  std::deque<BackendEvent> events_;  ///< at most one for each plant opened or closed and each chunk dropped
};

}  // namespace coppice
