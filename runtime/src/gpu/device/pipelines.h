#pragma once

// Pipelines that jobs build once something wants them: a context starts at once, and what it never draws is never built.

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

/// The attachments record_draw will find.
struct AttachmentDesc {
  std::array<VkFormat, COPPICE_MAX_COLORS> color_formats{};    ///< [color_count]
  std::uint32_t color_count = 0;                               ///< 0: depth alone
  std::array<coppice_content, COPPICE_MAX_COLORS> contents{};  ///< [color_count]; none is COPPICE_CONTENT_DEFAULT
  VkFormat depth_format = VK_FORMAT_UNDEFINED;
  VkCompareOp depth_compare = VK_COMPARE_OP_GREATER_OR_EQUAL;
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  bool has_stencil = false;  ///< of depth_format: bound, and left as it is
  /// Null: dynamic rendering. Lives until the context is destroyed, so that a handle stands for one pass for good.
  VkRenderPass render_pass = VK_NULL_HANDLE;
  std::uint32_t subpass = 0;

  bool operator==(const AttachmentDesc&) const = default;
};

/// What a pipeline is made of. Without a fragment shader it computes; with one it draws triangles on the attachments, depth tested and
/// written, viewport and scissor dynamic.
struct PipelineRecipe {
  const char* name = "";  ///< of its first shader; static storage, as the words
  VkPipelineLayout layout = VK_NULL_HANDLE;
  std::span<const std::uint32_t> first;          ///< SPIR-V of the compute or the vertex shader
  std::span<const std::uint32_t> fragment = {};  ///< SPIR-V
  std::array<std::uint32_t, 8> constants = {};   ///< of its shaders, by id
  AttachmentDesc attachments = {};
};

/// How long drivers took to create pipelines, by the clock: what is created side by side is added up.
struct PipelineTimes {
  double sum_ms = 0.0, longest_ms = 0.0;
  const char* longest = nullptr;  ///< name of its recipe; null while none is created
};

class PipelineSet;

struct Pipeline {
  PipelineSet* set = nullptr;
  PipelineRecipe recipe;
  bool wanted = false;
  std::atomic<VkPipeline> built = VK_NULL_HANDLE;  ///< null until it is

  /// Any thread.
  [[nodiscard]] VkPipeline handle() const { return built.load(std::memory_order_acquire); }
};

/// Thread: externally serialised, but for jobs; const functions may overlap.
class PipelineSet {
 public:
  /// device: outlives this object. cache: may be null. jobs: without a hook a pipeline is built inside want
  PipelineSet(Device& device, VkPipelineCache cache, const coppice_jobs& jobs) : device_(device), cache_(cache), jobs_(jobs) {}
  ~PipelineSet() { close(); }
  PipelineSet(const PipelineSet&) = delete;
  PipelineSet& operator=(const PipelineSet&) = delete;

  /// Nothing is built yet. The pipeline stays where it is.
  Pipeline& add(const PipelineRecipe& recipe);
  /// Has it built, once. Whether it is there: it never will be where that failed.
  bool want(Pipeline& pipeline);
  /// Tells the device what jobs have found out: that it is lost.
  void collect();
  /// Waits for jobs, destroys all pipelines. The GPU must be done with them; before their layouts go.
  void close();

  [[nodiscard]] std::uint32_t wanted_count() const { return wanted_count_; }
  [[nodiscard]] std::uint32_t built_count() const;
  [[nodiscard]] PipelineTimes times() const;
  /// Name of the first that is wanted and not there; null: all are.
  [[nodiscard]] const char* missing() const;
  /// Whether every wanted one is there. errors  of the first that could not be built; the log has it
  [[nodiscard]] Result<bool> ready() const;

 private:
  static void build(void* pipeline);

  Device& device_;
  VkPipelineCache cache_ = VK_NULL_HANDLE;
  coppice_jobs jobs_{};
  std::deque<Pipeline> pipelines_;
  std::uint32_t wanted_count_ = 0;
  std::atomic<bool> closing_ = false;

  mutable std::mutex mutex_;  ///< of what follows
  std::condition_variable ended_;
  std::uint32_t running_count_ = 0, built_count_ = 0;
  PipelineTimes times_;
  Result<void> failure_;  ///< the first
  const char* lost_call_ = nullptr;
};

}  // namespace coppice::gpu
