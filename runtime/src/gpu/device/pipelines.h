#pragma once

// Jobs build pipelines when they are first needed. So a context starts at once, and pipelines that it never needs are never built.

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>

#include "coppice/vulkan.h"
#include "device.h"
#include "result.h"

namespace coppice::gpu {

/// The attachments of coppice_record_draw.
struct AttachmentDesc {
  std::array<VkFormat, COPPICE_MAX_COLORS> color_formats{};    ///< [color_count]
  std::uint32_t color_count = 0;                               ///< 0: only depth
  std::array<coppice_content, COPPICE_MAX_COLORS> contents{};  ///< [color_count]; none is COPPICE_CONTENT_DEFAULT
  VkFormat depth_format = VK_FORMAT_UNDEFINED;
  VkCompareOp depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  bool has_stencil = false;  ///< the stencil of depth_format is bound, and not changed
  /// Null: dynamic rendering. It lives until the context is destroyed, so a handle always means the same pass.
  VkRenderPass render_pass = VK_NULL_HANDLE;
  std::uint32_t subpass = 0;

  bool operator==(const AttachmentDesc&) const = default;
};

/// The ingredients of a pipeline. Without a fragment shader it is a compute pipeline. With one it draws triangles to the attachments, with
/// depth test and depth writes; viewport and scissor are dynamic.
struct PipelineRecipe {
  const char* name = "";  ///< its first shader; static storage, as are the words
  VkPipelineLayout layout = VK_NULL_HANDLE;
  std::span<const std::uint32_t> first;          ///< SPIR-V of the compute or the vertex shader
  std::span<const std::uint32_t> fragment = {};  ///< SPIR-V
  std::array<std::uint32_t, 8> constants = {};   ///< specialization constants of its shaders, by id
  AttachmentDesc attachments = {};
};

/// Times that drivers took to create pipelines. Times of pipelines that are created at the same time add up.
struct PipelineTimes {
  double sum_ms = 0.0, longest_ms = 0.0;
  const char* longest = nullptr;  ///< its recipe's name; null before the first
};

class PipelineSet;

struct Pipeline {
  PipelineSet* set = nullptr;
  PipelineRecipe recipe;
  bool requested = false;
  std::atomic<VkPipeline> built = VK_NULL_HANDLE;  ///< null until it is built

  /// Any thread.
  [[nodiscard]] VkPipeline handle() const { return built.load(std::memory_order_acquire); }
};

/// Thread: externally serialised, but for jobs; const functions may overlap.
class PipelineSet {
 public:
  /// device: outlives this object. cache: may be null. jobs: without a hook a pipeline is built inside request
  PipelineSet(Device& device, VkPipelineCache cache, const coppice_jobs& jobs) : device_(device), cache_(cache), jobs_(jobs) {}
  ~PipelineSet() { close(); }
  PipelineSet(const PipelineSet&) = delete;
  PipelineSet& operator=(const PipelineSet&) = delete;

  /// Adds a pipeline without building it. The result does not move.
  Pipeline& add(const PipelineRecipe& recipe);
  /// Starts to build the pipeline, once. True if it is built; it never will be if that failed.
  bool request(Pipeline& pipeline);
  /// Passes a device loss that jobs have found on to the device.
  void collect();
  /// Waits for jobs and destroys all pipelines. before: the GPU is done with them, and their layouts still exist
  void close();

  [[nodiscard]] std::uint32_t requested_count() const { return requested_count_; }
  [[nodiscard]] std::uint32_t built_count() const;
  [[nodiscard]] PipelineTimes times() const;
  /// Name of the first pipeline that is requested and not built; null if there is none.
  [[nodiscard]] const char* missing() const;
  /// True if every requested pipeline is built. errors  of the first that could not be built; the log has it
  [[nodiscard]] Result<bool> ready() const;

 private:
  static void build(void* pipeline);

  Device& device_;
  VkPipelineCache cache_ = VK_NULL_HANDLE;
  coppice_jobs jobs_{};
  std::deque<Pipeline> pipelines_;
  std::uint32_t requested_count_ = 0;
  std::atomic<bool> closing_ = false;

  mutable std::mutex mutex_;  ///< guards the fields below
  std::condition_variable ended_;
  std::uint32_t running_count_ = 0, built_count_ = 0;
  PipelineTimes times_;
  Result<void> failure_;  ///< the first failure
  const char* lost_call_ = nullptr;
};

}  // namespace coppice::gpu
