#pragma once

#include "coppice/vulkan.h"
#include "vulkan_device.h"

namespace coppice::test {

struct HookStructs {
  coppice_allocator allocator{};
  coppice_jobs jobs{};
  coppice_io io{};
  coppice_log log{};
  coppice_trace trace{};
  coppice_device_memory device_memory{};
};

/// What a context is created with: the fields of both descs, and hooks by value, to which create_context() points the descs.
struct ContextDesc : coppice_context_desc, coppice_vulkan_desc {
  HookStructs hooks;
};

/// The descs' defaults, and hooks that are not given.
inline ContextDesc default_desc() {
  ContextDesc desc{};
  coppice_context_desc_init(&desc);
  coppice_vulkan_desc_init(&desc);
  coppice_allocator_init(&desc.hooks.allocator);
  coppice_jobs_init(&desc.hooks.jobs);
  coppice_io_init(&desc.hooks.io);
  coppice_log_init(&desc.hooks.log);
  coppice_trace_init(&desc.hooks.trace);
  coppice_device_memory_init(&desc.hooks.device_memory);
  return desc;
}

/// Defaults and the device; without the compute rasteriser, of which most tests ask nothing, and with
/// pictures that miss nothing.
inline ContextDesc context_desc(const VulkanDevice& gpu) {
  ContextDesc desc = default_desc();
  desc.instance = gpu.instance;
  desc.physical_device = gpu.physical_device;
  desc.device = gpu.device;
  desc.get_instance_proc_addr = vkGetInstanceProcAddr;
  desc.pipeline_cache = gpu.pipeline_cache;
  desc.compute_raster = VK_FALSE;
  desc.draw_indirect_count = gpu.draw_indirect_count ? VK_TRUE : VK_FALSE;
  desc.blocking_pipelines = VK_TRUE;
  return desc;
}

/// Points the descs at their hooks. They must not be copied or moved before they are used.
inline void point_at_hooks(ContextDesc& desc) {
  coppice_context_desc& core = desc;
  core.allocator = &desc.hooks.allocator;
  core.jobs = &desc.hooks.jobs;
  core.io = &desc.hooks.io;
  core.log = &desc.hooks.log;
  core.trace = &desc.hooks.trace;
  desc.device_memory = &desc.hooks.device_memory;
}

inline coppice_status create_context(ContextDesc desc, coppice_context** context) {
  point_at_hooks(desc);
  return coppice_vulkan_context_create(&desc, &desc, context);
}

inline coppice_status context_cost(ContextDesc desc, std::uint64_t* bytes) {
  point_at_hooks(desc);
  return coppice_vulkan_context_cost(&desc, &desc, bytes);
}

}  // namespace coppice::test
