// COPPICE_TEST_LATE: the GPU runs a submission when somebody waits for it, and no earlier. What is written, freed or recorded anew while
// the GPU may still use it then always is too early, on a driver that would have been done with it.
//
// Each submission also waits for a timeline semaphore, the gate. A wait for its fence or for a value that it signals opens the gate for it
// and those before; all other waits open it for all. Asking without waiting opens nothing.

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string_view>
#include <vector>

#include "layer_state.h"

namespace limits_layer {
namespace {

/// The mutex is held.
void open(Device& device, std::uint64_t submission) {
  Gate& gate = device.gate;
  if (submission <= gate.opened) return;
  const VkSemaphoreSignalInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, nullptr, gate.semaphore, submission};
  NEXT(device, SignalSemaphore)(device.handle, &info);
  gate.opened = submission;
}

Device& open_all(const void* handle) {
  Device& device = device_of(handle);
  const std::lock_guard lock(device.mutex);
  open(device, device.gate.submitted);
  return device;
}

VkResult queue_submit2(VkQueue queue, std::uint32_t count, const VkSubmitInfo2* submits, VkFence fence) {
  Device& device = device_of(queue);
  const std::lock_guard lock(device.mutex);
  Gate& gate = device.gate;
  const std::uint64_t number = ++gate.submitted;
  std::vector<VkSubmitInfo2> ours(submits, submits + count);
  std::vector<std::vector<VkSemaphoreSubmitInfo>> waits(count);
  for (std::size_t i = 0; i < ours.size(); ++i) {
    VkSubmitInfo2& submit = ours[i];
    waits[i].assign(submit.pWaitSemaphoreInfos, submit.pWaitSemaphoreInfos + submit.waitSemaphoreInfoCount);
    waits[i].push_back({VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO, nullptr, gate.semaphore, number, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, 0});
    submit.waitSemaphoreInfoCount = static_cast<std::uint32_t>(waits[i].size());
    submit.pWaitSemaphoreInfos = waits[i].data();
    for (std::uint32_t k = 0; k < submit.signalSemaphoreInfoCount; ++k)
      gate.signals[submit.pSignalSemaphoreInfos[k].semaphore][submit.pSignalSemaphoreInfos[k].value] = number;
  }
  if (fence != VK_NULL_HANDLE) gate.fences[fence] = number;
  return NEXT(device, QueueSubmit2)(queue, count, ours.data(), fence);
}

VkResult wait_semaphores(VkDevice handle, const VkSemaphoreWaitInfo* info, std::uint64_t timeout) {
  Device& device = device_of(handle);
  {
    const std::lock_guard lock(device.mutex);
    for (std::uint32_t i = 0; i < info->semaphoreCount; ++i) {
      const std::map<std::uint64_t, std::uint64_t>& signals = device.gate.signals[info->pSemaphores[i]];
      const auto signal = signals.lower_bound(info->pValues[i]);
      open(device, signal != signals.end() ? signal->second : device.gate.submitted);
    }
  }
  return NEXT(device, WaitSemaphores)(handle, info, timeout);
}

VkResult wait_for_fences(VkDevice handle, std::uint32_t count, const VkFence* fences, VkBool32 all, std::uint64_t timeout) {
  Device& device = device_of(handle);
  {
    const std::lock_guard lock(device.mutex);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto submission = device.gate.fences.find(fences[i]);
      open(device, submission != device.gate.fences.end() ? submission->second : device.gate.submitted);
    }
  }
  return NEXT(device, WaitForFences)(handle, count, fences, all, timeout);
}

VkResult queue_wait_idle(VkQueue queue) {
  return NEXT(open_all(queue), QueueWaitIdle)(queue);
}

VkResult device_wait_idle(VkDevice handle) {
  return NEXT(open_all(handle), DeviceWaitIdle)(handle);
}

VkResult queue_submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* submits, VkFence fence) {
  return NEXT(open_all(queue), QueueSubmit)(queue, count, submits, fence);
}

/// Another may get its handle, and begin at 0.
void destroy_semaphore(VkDevice handle, VkSemaphore semaphore, Callbacks callbacks) {
  Device& device = device_of(handle);
  {
    const std::lock_guard lock(device.mutex);
    device.gate.signals.erase(semaphore);
  }
  NEXT(device, DestroySemaphore)(handle, semaphore, callbacks);
}

VkResult queue_present(VkQueue queue, const VkPresentInfoKHR* info) {
  return NEXT(open_all(queue), QueuePresentKHR)(queue, info);
}

}  // namespace

PFN_vkVoidFunction late_function(std::string_view name) {
  static const Functions hooks{OURS(QueueSubmit2, queue_submit2),      OURS(WaitSemaphores, wait_semaphores),
                               OURS(WaitForFences, wait_for_fences),   OURS(QueueWaitIdle, queue_wait_idle),
                               OURS(DeviceWaitIdle, device_wait_idle), OURS(QueueSubmit, queue_submit),
                               OURS(QueuePresentKHR, queue_present),   OURS(DestroySemaphore, destroy_semaphore)};
  return layer::find_function(hooks, name);
}

VkResult create_gate(Device& device) {
  if (!device.instance->late) return VK_SUCCESS;
  const VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO, nullptr, VK_SEMAPHORE_TYPE_TIMELINE, 0};
  const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
  return NEXT(device, CreateSemaphore)(device.handle, &info, nullptr, &device.gate.semaphore);
}

void destroy_gate(Device& device) {
  if (device.gate.semaphore != VK_NULL_HANDLE) NEXT(device, DestroySemaphore)(device.handle, device.gate.semaphore, nullptr);
}

}  // namespace limits_layer
