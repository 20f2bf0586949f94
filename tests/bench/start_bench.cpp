// How long an engine waits for a context and its views: the calls that create them, and until their pipelines are built. Without validation
// and pipeline cache; a driver that keeps compiled shaders on disk has to be told not to (Mesa: MESA_SHADER_CACHE_DISABLE=true).

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <vector>

#include <unistd.h>

#include "context_desc.h"
#include "shot.h"
#include "stopwatch.h"

namespace coppice::test {
namespace {

struct Times {
  double created_ms = 0, ready_ms = 0;
};

Times start(const ContextDesc& desc, bool shadows) {
  coppice_context* context = nullptr;
  const Stopwatch watch;
  if (create_context(desc, &context) != COPPICE_OK) throw std::runtime_error("coppice_vulkan_context_create failed");
  std::vector<coppice_output> outputs{COPPICE_OUTPUT_LIT};
  if (shadows) outputs.push_back(COPPICE_OUTPUT_DEPTH);
  for (const coppice_output output : outputs) {
    coppice_view view = 0;
    if (create_view(context, &view, output) != COPPICE_OK) throw std::runtime_error("coppice_vulkan_view_create failed");
  }
  Times times{.created_ms = watch.ms()};
  VkBool32 ready = VK_FALSE;
  while (coppice_pipelines_ready(context, &ready) == COPPICE_OK && ready == VK_FALSE) usleep(100);
  times.ready_ms = watch.ms();
  coppice_context_destroy(context);
  return times;
}

void measure(const char* name, const ContextDesc& desc, bool shadows = false) {
  std::vector<Times> runs;
  for (int i = 0; i < 5; ++i) runs.push_back(start(desc, shadows));
  const auto median = [&](double Times::*of) {
    std::ranges::sort(runs, {}, of);
    return runs[runs.size() / 2].*of;
  };
  std::printf("%-34s created %8.1f ms, ready %8.1f ms\n", name, median(&Times::created_ms), median(&Times::ready_ms));
}

}  // namespace
}  // namespace coppice::test

int main() {
  using namespace coppice::test;
  ContextDesc desc = context_desc(vulkan_device(Validation::off));
  desc.pipeline_cache = VK_NULL_HANDLE;
  desc.blocking_pipelines = VK_FALSE;
  measure("hardware", desc);
  desc.compute_raster = VK_TRUE;
  measure("compute_raster", desc);
  desc.shader_int64_atomics = vulkan_device().int64_atomics ? VK_TRUE : VK_FALSE;
  measure("compute_raster, 64-bit atomics", desc);
  measure("the same, with a shadow view", desc, true);
  return 0;
}
