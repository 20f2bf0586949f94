#pragma once

// The plants of a frame for culling and draws: a record for each, their share of the draw commands, and the meshes' draws.

#include <cstdint>
#include <span>

#include "growing_buffers.h"
#include "instances.h"
#include "passes.h"
#include "plant_store.h"

namespace coppice::gpu {

struct DrawListInput {
  const PlantStore& store;
  const InstanceTable& instances;
  std::span<const LodPlant> plants;          ///< with what may be drawn of them
  std::span<const DrawPipelines> pipelines;  ///< leaf meshes are drawn once all have their pipelines
  bool raster = false;                       ///< the compute rasteriser draws small leaves
  std::uint64_t memory_budget_bytes = 0;
};

/// Draw commands of clusters and parts take at most the memory budget divided by this.
inline constexpr std::uint64_t kCommandShare = 64;

/// Name of the buffers that DrawLists::fill fills.
inline constexpr const char* kLeafCommandsName = "coppice leaf commands";

class DrawLists {
 public:
  explicit DrawLists(const coppice_allocator& allocator) : allocator_(allocator) {}

  /// Reserves memory for this many plants. errors  out_of_memory; nothing has changed
  Result<void> reserve(std::uint32_t plant_count);
  /// Fills the lists for this frame. True if a command buffer was replaced by a larger one. commands: one for each view, with space for
  /// single clusters of all slots at least; larger ones replace them if memory is free for more draws.
  bool fill(Device& device, DeferredDeletion& deletion, const DrawListInput& input, std::span<Buffer* const> commands);

  [[nodiscard]] std::uint32_t count() const { return count_; }
  [[nodiscard]] std::span<const Plant> records() const { return records_.span().first(count_); }
  /// True if a plant has a MaterialOverride.
  [[nodiscard]] bool has_overrides() const { return has_overrides_; }
  [[nodiscard]] std::uint32_t instance_count(std::uint32_t plant) const { return records_[plant].instance_count; }
  /// kMeshCommands a plant, with no instances.
  [[nodiscard]] std::span<const DrawCommand> mesh_commands() const {
    return mesh_commands_.span().first(std::size_t{count_} * kMeshCommands);
  }

 private:
  void fill_record(std::uint32_t plant, const DrawListInput& input);
  void fill_meshes(std::uint32_t plant, const DrawListInput& input);
  /// Sums over all plants.
  struct Needed {
    std::size_t plants = 0;  ///< plants with instances
    std::uint64_t single_bytes = 0, cluster_bytes = 0, part_bytes = 0;
  };
  Needed add_up(const Device& device);
  static bool grow(Device& device, DeferredDeletion& deletion, std::uint64_t needed_bytes, Buffer& commands);
  [[nodiscard]] std::uint64_t needed_commands(const Device& device, std::uint32_t plant) const;
  [[nodiscard]] std::uint64_t needed_parts(std::uint32_t plant) const;
  void place(std::uint64_t max_clusters, bool parts);

  coppice_allocator allocator_;
  HookArray<Plant> records_;
  HookArray<DrawCommand> mesh_commands_;
  HookArray<std::uint64_t> needed_;  ///< scratch
  std::uint32_t count_ = 0;          ///< number of plants
  bool has_overrides_ = false;       ///< a plant has a MaterialOverride
};

}  // namespace coppice::gpu
