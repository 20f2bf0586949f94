#pragma once

// Positions of a plant's triangles for an engine's acceleration structures, written by the GPU (cut_triangles.comp).

#include <cstdint>
#include <optional>

#include "pipelines.h"
#include "plant_store.h"

namespace coppice::gpu {

/// Which triangles of a plant: all of it is resident.
struct CutTriangles {
  std::uint32_t leaf_count = 0;  ///< of a cut; 0: none
  bool leaf_meshes = false;
  std::optional<std::uint32_t> wood_lod;
};

/// A cut of up to kReadyLeaves leaves is the next larger one that the plant has ready.
std::uint32_t triangle_count(const StoredPlant& plant, const CutTriangles& of);

/// Thread: as Renderer's.
class TriangleWriter {
 public:
  /// Both outlive this object; the pipeline is closed before it is destroyed.
  TriangleWriter(Device& device, PipelineSet& pipelines) : device_(device), pipelines_(pipelines) {}
  ~TriangleWriter();
  TriangleWriter(const TriangleWriter&) = delete;
  TriangleWriter& operator=(const TriangleWriter&) = delete;
  /// The pipeline is not requested yet. errors  out_of_memory, device_lost
  Result<void> create();

  /// Requests the pipeline. True if it is built.
  bool is_ready() { return pipelines_.request(*pipeline_); }
  /// Writes triangle_count triangles to the device address `positions`. before: is_ready; the plant's chunks are uploaded
  void record(VkCommandBuffer cmd, const StoredPlant& plant, const CutTriangles& of, std::uint64_t positions) const;

 private:
  Device& device_;
  PipelineSet& pipelines_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  Pipeline* pipeline_ = nullptr;
};

}  // namespace coppice::gpu
