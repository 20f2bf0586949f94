#pragma once
// An engine in miniature: Vulkan by Vulkan-Hpp, an allocator of device memory, a pool of jobs, an archive of assets.
#include <coppice/vulkan.h>
#include <unistd.h>

#include <condition_variable>
#include <deque>
#include <fstream>
#include <list>
#include <map>
#include <mutex>
#include <thread>
#include <vulkan/vulkan_raii.hpp>

namespace engine {

/// Divides pages of 64 MiB first fit, among the engine's images and Coppice's blocks alike. thread: one at a time
struct DeviceMemory {
  struct Page {
    vk::raii::DeviceMemory memory;
    std::uint32_t type;
    vk::DeviceSize bytes;
    char* mapped;                                   ///< null unless it is host-visible
    std::map<vk::DeviceSize, vk::DeviceSize> used;  ///< ends of ranges, by their begins
  };
  const vk::raii::Device& device;
  vk::PhysicalDeviceMemoryProperties types;
  std::list<Page> pages = {};
};

/// Ranges begin at multiples of the largest bufferImageGranularity, so that images and buffers may be neighbours.
inline bool take_range(DeviceMemory::Page& page, vk::DeviceSize bytes, coppice_memory_block& block) {
  block.offset = 0;
  for (auto next = page.used.begin(); next != page.used.end() && block.offset + bytes > next->first; ++next)
    block.offset = (next->second + 131071) / 131072 * 131072;
  if (block.offset + bytes > page.bytes) return false;
  page.used[block.offset] = block.offset + bytes;
  block.memory_type = page.type;
  block.memory = *page.memory;
  block.mapped = page.mapped ? page.mapped + block.offset : nullptr;
  block.handle = &page;
  return true;
}

/// Throws vk::SystemError if there is no such memory left.
inline void allocate(DeviceMemory& memory, const vk::MemoryRequirements& needs, vk::MemoryPropertyFlags properties,
                     coppice_memory_block& block) {
  std::uint32_t type = 0;
  while (!(needs.memoryTypeBits >> type & 1) || (memory.types.memoryTypes[type].propertyFlags & properties) != properties)
    if (++type == memory.types.memoryTypeCount) throw vk::OutOfDeviceMemoryError("no such memory");
  for (DeviceMemory::Page& page : memory.pages)
    if (page.type == type && take_range(page, needs.size, block)) return;
  const vk::MemoryAllocateFlagsInfo flags(vk::MemoryAllocateFlagBits::eDeviceAddress);  // shaders reach buffers by their addresses
  const vk::DeviceSize bytes = std::max<vk::DeviceSize>(needs.size, 64u << 20);
  DeviceMemory::Page page{{memory.device, vk::MemoryAllocateInfo(bytes, type, &flags)}, type, bytes, nullptr, {}};
  if (memory.types.memoryTypes[type].propertyFlags & vk::MemoryPropertyFlagBits::eHostVisible)
    page.mapped = static_cast<char*>(page.memory.mapMemory(0, VK_WHOLE_SIZE));
  take_range(memory.pages.emplace_front(std::move(page)), needs.size, block);
}

inline void release(DeviceMemory& memory, const coppice_memory_block& block) {
  static_cast<DeviceMemory::Page*>(block.handle)->used.erase(block.offset);
  memory.pages.remove_if([](const DeviceMemory::Page& page) { return page.used.empty(); });
}

constexpr std::uint32_t kFramesInFlight = 2;
using Features = vk::StructureChain<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features, vk::PhysicalDeviceVulkan13Features>;
struct Gpu {
  static constexpr std::uint32_t kFamily = 0;  ///< the one that draws, on every desktop driver
  vk::raii::Context loader;
  vk::ApplicationInfo application{"engine", 1, nullptr, 0, VK_API_VERSION_1_3};
  vk::raii::Instance instance{loader, vk::InstanceCreateInfo({}, &application)};
  vk::raii::PhysicalDevice physical{std::move(vk::raii::PhysicalDevices(instance).front())};
  /// All that the device has: what Coppice needs, and what it can do without, is among them.
  Features features =
      physical.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features, vk::PhysicalDeviceVulkan13Features>();
  float priority = 1;
  vk::DeviceQueueCreateInfo queue_info{{}, kFamily, 1, &priority};
  const char* extension = VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME;  ///< for the engine's own pass
  vk::raii::Device device{physical, vk::DeviceCreateInfo({}, queue_info, {}, extension, nullptr, &features.get<>())};
  vk::raii::Queue queue{device, kFamily, 0};
  DeviceMemory memory{device, physical.getMemoryProperties()};
  vk::raii::CommandPool pool{device, vk::CommandPoolCreateInfo(vk::CommandPoolCreateFlagBits::eResetCommandBuffer, kFamily)};
  vk::raii::CommandBuffers commands{device, vk::CommandBufferAllocateInfo(*pool, vk::CommandBufferLevel::ePrimary, kFramesInFlight)};
  vk::SemaphoreTypeCreateInfo timeline{vk::SemaphoreType::eTimeline, 0};
  vk::raii::Semaphore finished{device, vk::SemaphoreCreateInfo({}, &timeline)};  ///< its value is the last frame that the GPU has finished
};

/// Waits until the GPU has finished frame `frame` - kFramesInFlight. frame: from 1
inline const vk::raii::CommandBuffer& begin_commands(const Gpu& gpu, std::uint64_t frame) {
  const std::uint64_t before = frame - std::min<std::uint64_t>(frame, kFramesInFlight);
  if (gpu.device.waitSemaphores(vk::SemaphoreWaitInfo({}, *gpu.finished, before), 600'000'000'000) != vk::Result::eSuccess)
    throw std::runtime_error("the GPU hangs");
  const vk::raii::CommandBuffer& cmd = gpu.commands[frame % kFramesInFlight];
  cmd.begin({});
  return cmd;
}

inline void submit_commands(const Gpu& gpu, const vk::raii::CommandBuffer& cmd, std::uint64_t frame) {
  const vk::MemoryBarrier2 pictures(vk::PipelineStageFlagBits2::eComputeShader, vk::AccessFlagBits2::eShaderWrite,
                                    vk::PipelineStageFlagBits2::eHost, vk::AccessFlagBits2::eHostRead);
  cmd.pipelineBarrier2(vk::DependencyInfo({}, pictures));
  cmd.end();
  const vk::CommandBufferSubmitInfo commands(*cmd);
  const vk::SemaphoreSubmitInfo signal(*gpu.finished, frame, vk::PipelineStageFlagBits2::eAllCommands);
  gpu.queue.submit2(vk::SubmitInfo2({}, {}, commands, signal));
}

/// Its memory is freed with the device, as that of a buffer.
struct Image {
  vk::raii::Image image = nullptr;
  vk::raii::ImageView view = nullptr;
  vk::ImageSubresourceRange all;
  vk::ImageLayout layout = vk::ImageLayout::eUndefined;
};

inline Image create_image(Gpu& gpu, vk::Format format, vk::Extent2D size, vk::ImageUsageFlags usage) {
  Image result{.all = {vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1}};
  if (format == vk::Format::eD32Sfloat) result.all.aspectMask = vk::ImageAspectFlagBits::eDepth;
  const vk::ImageCreateInfo info({}, vk::ImageType::e2D, format, {size.width, size.height, 1}, 1, 1, vk::SampleCountFlagBits::e1,
                                 vk::ImageTiling::eOptimal, usage | vk::ImageUsageFlagBits::eSampled);
  result.image = {gpu.device, info};
  coppice_memory_block block{};
  allocate(gpu.memory, result.image.getMemoryRequirements(), vk::MemoryPropertyFlagBits::eDeviceLocal, block);
  result.image.bindMemory(block.memory, block.offset);
  result.view = {gpu.device, vk::ImageViewCreateInfo({}, *result.image, vk::ImageViewType::e2D, format, {}, result.all)};
  return result;
}

/// Waits for everything before and holds back everything after: the simplest barrier, not the fastest.
inline void change_layout(const vk::raii::CommandBuffer& cmd, Image& image, vk::ImageLayout layout) {
  constexpr auto kAll = vk::PipelineStageFlagBits2::eAllCommands;
  constexpr auto kWrite = vk::AccessFlagBits2::eMemoryWrite, kRead = vk::AccessFlagBits2::eMemoryRead;
  const vk::ImageMemoryBarrier2 barrier(kAll, kWrite, kAll, kRead | kWrite, std::exchange(image.layout, layout), layout, 0, 0, *image.image,
                                        image.all);
  cmd.pipelineBarrier2(vk::DependencyInfo({}, {}, {}, barrier));
}

/// Memory that the GPU reaches by its address and the engine by a pointer.
struct Buffer {
  vk::raii::Buffer buffer = nullptr;
  vk::DeviceAddress address = 0;
  char* mapped = nullptr;
};

inline Buffer create_buffer(Gpu& gpu, vk::DeviceSize bytes) {
  vk::raii::Buffer buffer(gpu.device, vk::BufferCreateInfo({}, bytes, vk::BufferUsageFlagBits::eShaderDeviceAddress));
  coppice_memory_block block{};
  constexpr auto kVisible = vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent;
  allocate(gpu.memory, buffer.getMemoryRequirements(), kVisible, block);
  buffer.bindMemory(block.memory, block.offset);
  const vk::DeviceAddress address = gpu.device.getBufferAddress(vk::BufferDeviceAddressInfo(*buffer));
  return {std::move(buffer), address, static_cast<char*>(block.mapped)};
}

/// Threads that run jobs, first in, first out. Without threads a job runs before submit returns.
struct JobPool {
  explicit JobPool(unsigned thread_count) {
    for (unsigned i = 0; i < thread_count; ++i) threads.emplace_back([this](const std::stop_token& stop) { run(stop); });
  }
  void submit(std::function<void()> job) {
    if (threads.empty()) return job();
    const std::lock_guard lock(mutex);
    jobs.push_back(std::move(job));
    added.notify_one();
  }
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex);
    while (added.wait(lock, stop, [&] { return !jobs.empty(); })) {
      const auto job = std::move(jobs.front());
      jobs.pop_front();
      lock.unlock();
      job();
      lock.lock();
    }
  }
  std::mutex mutex;
  std::condition_variable_any added;
  std::deque<std::function<void()>> jobs;
  std::vector<std::jthread> threads;
};

/// One file that holds all assets, as engines ship them; here a temporary one.
struct Archive {
  Archive(const std::vector<std::string>& paths, unsigned thread_count) : names(paths), reader(thread_count) {
    for (const std::string& path : paths) {
      std::ifstream in(path, std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(in), {}};
      if (pwrite(fileno(file.get()), bytes.data(), bytes.size(), off_t(begins.back())) <= 0)
        throw std::runtime_error(path + " cannot be archived");
      begins.push_back(begins.back() + bytes.size());
    }
  }
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{std::tmpfile(), std::fclose};
  std::vector<std::string> names;
  std::vector<std::uint64_t> begins = {0};  ///< of the assets, and the end of the last
  JobPool reader;
};

}  // namespace engine
