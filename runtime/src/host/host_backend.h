#pragma once

// The backend of a host that draws itself.

#include <deque>
#include <memory>

#include "backend.h"

namespace coppice {

/// An event for the host, other than an added chunk.
struct HostEvent {
  coppice_change_kind kind = COPPICE_CHANGE_NONE;
  coppice_plant plant = 0;
  ChunkId chunk;  ///< its plant is the file
};

class HostBackend final : public Backend {
 public:
  /// errors  out_of_memory
  static Result<std::unique_ptr<Backend>> create(const BackendOptions& options);

  [[nodiscard]] const BackendLimits& limits() const override { return limits_; }
  [[nodiscard]] std::uint64_t min_budget_bytes(std::uint64_t reserved_bytes) const override { return reserved_bytes; }
  void set_memory_budget(std::uint64_t) override {}
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
  Result<void> upload_chunk(const DecodedChunk&) override { return {}; }
  void hide_chunk(ChunkId) override {}
  void drop_chunk(ChunkId) override {}
  Result<void> end_upload(gpu::InstanceTable&, std::span<const gpu::PlantResidency>) override { return {}; }
  void remove_view(std::uint32_t) override {}
  void show_view(std::uint32_t, const coppice_camera&, const LodView&) override {}
  [[nodiscard]] bool has_reversed_depth(std::uint32_t) const override { return false; }
  [[nodiscard]] ViewCounts view_counts(std::uint32_t) const override { return {}; }
  [[nodiscard]] HostBackend* host() override { return this; }

  /// Events that the host has not taken yet: at most one for each plant opened or closed and each chunk dropped.
  [[nodiscard]] std::deque<HostEvent>& events() { return events_; }

 private:
  explicit HostBackend(const BackendLimits& limits) : limits_(limits) {}

  BackendLimits limits_;
  std::deque<HostEvent> events_;
};

}  // namespace coppice
