/* A Vulkan layer that lets the device fail in programs whose command line has a word, for what such a device does to them:
 *
 *     COPPICE_FAULTS="hang splats;wrong leaves;lost uploads"
 *
 * hang  the GPU takes work and never finishes it; waits pass their time. stop  the same of work without a fence, frames. wrong  what is
 * copied is zeros. lost  the device is lost when it is given work. One instance and one device a process. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

static PFN_vkGetInstanceProcAddr next_instance_proc;
static PFN_vkGetDeviceProcAddr next_device_proc;
static VkInstance the_instance;
static VkDevice the_device;
static char fault[16] = "none";

/* Leaves the fault of the first entry whose word is an argument of this process. */
static void choose_fault(void) {
  static char arguments[65536];
  char kind[sizeof fault], word[64];
  FILE* file = fopen("/proc/self/cmdline", "rb");
  const size_t bytes = file ? fread(arguments, 1, sizeof arguments - 1, file) : 0;
  const char* entry = getenv("COPPICE_FAULTS");
  if (file) (void)fclose(file);
  for (; entry && sscanf(entry, "%15s %63[^;]", kind, word) == 2; entry = strchr(entry, ';') ? strchr(entry, ';') + 1 : NULL)
    for (size_t at = 0; at < bytes; at += strlen(arguments + at) + 1)
      if (strcmp(arguments + at, word) == 0) strcpy(fault, kind);
}

static int has_fault(const char* kind) {
  return strcmp(fault, kind) == 0;
}

static PFN_vkVoidFunction next(const char* name) {
  return next_device_proc(the_device, name);
}

static VkResult pass_time(uint64_t timeout_ns) {
  const struct timespec time = {(time_t)(timeout_ns / 1000000000), (long)(timeout_ns % 1000000000)};
  nanosleep(&time, NULL);
  return VK_TIMEOUT;
}

static VKAPI_ATTR VkResult VKAPI_CALL queue_submit2(VkQueue queue, uint32_t count, const VkSubmitInfo2* submits, VkFence fence) {
  if (has_fault("hang") || (has_fault("stop") && fence == VK_NULL_HANDLE)) return VK_SUCCESS;
  if (has_fault("lost")) return VK_ERROR_DEVICE_LOST;
  return ((PFN_vkQueueSubmit2)next("vkQueueSubmit2"))(queue, count, submits, fence);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_for_fences(VkDevice device, uint32_t count, const VkFence* fences, VkBool32 all,
                                                      uint64_t timeout) {
  if (has_fault("hang")) return pass_time(timeout);
  return ((PFN_vkWaitForFences)next("vkWaitForFences"))(device, count, fences, all, timeout);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_semaphores(VkDevice device, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
  if (has_fault("hang") || has_fault("stop")) return pass_time(timeout);
  return ((PFN_vkWaitSemaphores)next("vkWaitSemaphores"))(device, info, timeout);
}

static void fill(VkCommandBuffer commands, VkBuffer buffer) {
  ((PFN_vkCmdFillBuffer)next("vkCmdFillBuffer"))(commands, buffer, 0, VK_WHOLE_SIZE, 0);
}

static VKAPI_ATTR void VKAPI_CALL copy_buffer(VkCommandBuffer commands, VkBuffer from, VkBuffer to, uint32_t count,
                                              const VkBufferCopy* regions) {
  if (has_fault("wrong"))
    fill(commands, to);
  else
    ((PFN_vkCmdCopyBuffer)next("vkCmdCopyBuffer"))(commands, from, to, count, regions);
}

static VKAPI_ATTR void VKAPI_CALL copy_image(VkCommandBuffer commands, VkImage from, VkImageLayout layout, VkBuffer to, uint32_t count,
                                             const VkBufferImageCopy* regions) {
  if (has_fault("wrong"))
    fill(commands, to);
  else
    ((PFN_vkCmdCopyImageToBuffer)next("vkCmdCopyImageToBuffer"))(commands, from, layout, to, count, regions);
}

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                                      VkInstance* instance) {
  VkLayerInstanceCreateInfo* link = (VkLayerInstanceCreateInfo*)info->pNext;
  while (link->sType != VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO)
    link = (VkLayerInstanceCreateInfo*)link->pNext;
  next_instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  choose_fault();
  const VkResult result = ((PFN_vkCreateInstance)next_instance_proc(NULL, "vkCreateInstance"))(info, allocator, instance);
  the_instance = *instance;
  return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                                    const VkAllocationCallbacks* allocator, VkDevice* device) {
  VkLayerDeviceCreateInfo* link = (VkLayerDeviceCreateInfo*)info->pNext;
  while (link->sType != VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO)
    link = (VkLayerDeviceCreateInfo*)link->pNext;
  next_device_proc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const VkResult result = ((PFN_vkCreateDevice)next_instance_proc(the_instance, "vkCreateDevice"))(physical, info, allocator, device);
  the_device = *device;
  return result;
}

static PFN_vkVoidFunction own(const char* name) {
  static const struct {
    const char* name;
    PFN_vkVoidFunction function;
  } all[] = {{"vkCreateInstance", (PFN_vkVoidFunction)create_instance}, {"vkCreateDevice", (PFN_vkVoidFunction)create_device},
             {"vkQueueSubmit2", (PFN_vkVoidFunction)queue_submit2},     {"vkWaitForFences", (PFN_vkVoidFunction)wait_for_fences},
             {"vkWaitSemaphores", (PFN_vkVoidFunction)wait_semaphores}, {"vkCmdCopyBuffer", (PFN_vkVoidFunction)copy_buffer},
             {"vkCmdCopyImageToBuffer", (PFN_vkVoidFunction)copy_image}};
  for (size_t i = 0; i < sizeof all / sizeof all[0]; ++i)
    if (strcmp(all[i].name, name) == 0) return all[i].function;
  return NULL;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_proc(VkDevice device, const char* name) {
  const PFN_vkVoidFunction function = own(name);
  return function ? function : next_device_proc(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_proc(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction function = strcmp(name, "vkGetDeviceProcAddr") == 0 ? (PFN_vkVoidFunction)device_proc : own(name);
  return function ? function : next_instance_proc(instance, name);
}

VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* versions) {
  versions->loaderLayerInterfaceVersion = 2;
  versions->pfnGetInstanceProcAddr = instance_proc;
  versions->pfnGetDeviceProcAddr = device_proc;
  versions->pfnGetPhysicalDeviceProcAddr = NULL;
  return VK_SUCCESS;
}
