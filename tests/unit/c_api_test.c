/* Calls the whole API from C99 on a headless device. Argument: a .coppice file. */

#ifdef __cplusplus
#error "this test is about C"
#endif

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <volk.h>

#include "coppice/vulkan.h"

#define CHECK(condition)                                                      \
  do {                                                                        \
    if (!(condition)) {                                                       \
      fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
      exit(1);                                                                \
    }                                                                         \
  } while (0)

typedef struct Gpu {
  VkInstance instance;
  VkPhysicalDevice physical_device;
  VkDevice device;
  VkQueue queue;
  VkCommandPool pool;
} Gpu;

static Gpu open_gpu(void) {
  Gpu gpu;
  memset(&gpu, 0, sizeof gpu);
  CHECK(volkInitialize() == VK_SUCCESS);
  VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
  VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
  CHECK(vkCreateInstance(&instance, NULL, &gpu.instance) == VK_SUCCESS);
  volkLoadInstance(gpu.instance);
  uint32_t count = 1;
  vkEnumeratePhysicalDevices(gpu.instance, &count, &gpu.physical_device);
  CHECK(count == 1);

  VkPhysicalDeviceVulkan13Features vulkan13 = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, .dynamicRendering = VK_TRUE, .synchronization2 = VK_TRUE};
  VkPhysicalDeviceVulkan12Features vulkan12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                               .pNext = &vulkan13,
                                               .drawIndirectCount = VK_TRUE,
                                               .scalarBlockLayout = VK_TRUE,
                                               .bufferDeviceAddress = VK_TRUE};
  VkPhysicalDeviceFeatures features = {.multiDrawIndirect = VK_TRUE, .drawIndirectFirstInstance = VK_TRUE};
  float priority = 1.0f;
  VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
  VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &vulkan12,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .pEnabledFeatures = &features};
  CHECK(vkCreateDevice(gpu.physical_device, &device, NULL, &gpu.device) == VK_SUCCESS);
  volkLoadDevice(gpu.device);
  vkGetDeviceQueue(gpu.device, 0, 0, &gpu.queue);
  VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  CHECK(vkCreateCommandPool(gpu.device, &pool, NULL, &gpu.pool) == VK_SUCCESS);
  return gpu;
}

static void close_gpu(Gpu* gpu) {
  vkDestroyCommandPool(gpu->device, gpu->pool, NULL);
  vkDestroyDevice(gpu->device, NULL);
  vkDestroyInstance(gpu->instance, NULL);
}

/* An empty pass: what there is to see is the golden tests' business, that the calls work from C is this one's. */
static void record(coppice_context* context, VkCommandBuffer cmd, const coppice_camera* camera) {
  CHECK(coppice_record_upload(context, cmd) == COPPICE_OK);
  CHECK(coppice_record_cull(context, cmd, camera->view, NULL) == COPPICE_OK);
  VkRenderingInfo rendering = {
      .sType = VK_STRUCTURE_TYPE_RENDERING_INFO, .renderArea = {{0, 0}, {camera->width_px, camera->height_px}}, .layerCount = 1};
  CHECK(coppice_record_draw(context, NULL, camera->view, 0) == COPPICE_ERROR_INVALID_ARGUMENT);
  vkCmdBeginRendering(cmd, &rendering);
  vkCmdEndRendering(cmd);
}

static void draw_frame(const Gpu* gpu, coppice_context* context, uint64_t frame_number, const coppice_camera* camera) {
  coppice_frame frame;
  coppice_frame_init(&frame);
  frame.frame_number = frame_number;
  frame.completed_number = frame_number - 1;
  frame.cameras = camera;
  frame.camera_count = 1;
  CHECK(coppice_frame_begin(context, &frame) == COPPICE_OK);
  VkCommandBufferAllocateInfo allocate = {
      .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = gpu->pool, .commandBufferCount = 1};
  VkCommandBuffer cmd = VK_NULL_HANDLE;
  CHECK(vkAllocateCommandBuffers(gpu->device, &allocate, &cmd) == VK_SUCCESS);
  VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  CHECK(vkBeginCommandBuffer(cmd, &begin) == VK_SUCCESS);
  record(context, cmd, camera);
  CHECK(vkEndCommandBuffer(cmd) == VK_SUCCESS);
  VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
  CHECK(vkQueueSubmit(gpu->queue, 1, &submit, VK_NULL_HANDLE) == VK_SUCCESS);
  CHECK(vkQueueWaitIdle(gpu->queue) == VK_SUCCESS);
}

static coppice_camera look_at_origin(coppice_view of_view) {
  coppice_camera view;
  coppice_camera_init(&view);
  view.view = of_view;
  view.width_px = view.height_px = 64;
  view.view_from_world[14] = -5.0f;
  view.clip_from_view[5] = -1.0f;
  view.clip_from_view[10] = 0.0f;
  view.clip_from_view[11] = -1.0f;
  view.clip_from_view[14] = 0.1f;
  view.clip_from_view[15] = 0.0f;
  return view;
}

static void use_plant(const Gpu* gpu, coppice_context* context, const char* path) {
  coppice_plant plant = 0;
  CHECK(coppice_plant_open(context, path, &plant) == COPPICE_OK && plant != 0);
  coppice_plant_info info;
  coppice_plant_info_init(&info);
  CHECK(coppice_plant_get_info(context, plant, &info) == COPPICE_OK && info.leaf_count > 0 && info.resident_leaf_count > 0);

  coppice_placement placements[2] = {{{0.0f, 0.0f, 0.0f}, 1.0f, {0.0f, 0.0f, 0.0f, 1.0f}, {1, 1, 1}, 0, COPPICE_ALL_LAYERS, 0, 1},
                                     {{0.5f, 0.0f, 0.0f}, 1.0f, {0.0f, 0.0f, 0.0f, 1.0f}, {1, 1, 1}, 0, COPPICE_ALL_LAYERS, 0, 1}};
  coppice_instance instances[2];
  CHECK(coppice_instances_add(context, plant, placements, sizeof(coppice_placement), 2, instances) == COPPICE_OK);
  CHECK(coppice_instances_move(context, &instances[0], &placements[1], sizeof(coppice_placement), 1) == COPPICE_OK);
  CHECK(coppice_instances_remove(context, &instances[1], 1) == COPPICE_OK);

  coppice_view_desc view_desc;
  coppice_view_desc_init(&view_desc);
  coppice_vulkan_view_desc formats;
  coppice_vulkan_view_desc_init(&formats);
  formats.color_formats[0] = VK_FORMAT_R8G8B8A8_SRGB;
  formats.depth_format = VK_FORMAT_D32_SFLOAT;
  coppice_view of_view = 0;
  CHECK(coppice_vulkan_view_create(context, &view_desc, &formats, &of_view) == COPPICE_OK && of_view != 0);
  VkBool32 ready = VK_FALSE;
  CHECK(coppice_pipelines_ready(context, &ready) == COPPICE_OK && ready == VK_TRUE);
  coppice_camera view = look_at_origin(of_view);
  coppice_frame wrong;
  coppice_frame_init(&wrong);
  wrong.frame_number = 1;
  wrong.cameras = &view;
  wrong.camera_count = 1;
  view.debug_view = COPPICE_DEBUG_VIEW_MAX_ENUM;
  CHECK(coppice_frame_begin(context, &wrong) == COPPICE_ERROR_INVALID_ARGUMENT);
  view.debug_view = COPPICE_DEBUG_NONE;
  draw_frame(gpu, context, 1, &view);
  CHECK(coppice_set_memory_budget(context, 64ull << 20) == COPPICE_OK);
  draw_frame(gpu, context, 2, &view);
  coppice_stats stats;
  coppice_stats_init(&stats);
  CHECK(coppice_get_stats(context, &stats) == COPPICE_OK);
  CHECK(stats.instance_count == 1 && stats.source_leaf_count == info.leaf_count);
  coppice_view_stats drawn;
  coppice_view_stats_init(&drawn);
  CHECK(coppice_get_view_stats(context, of_view, &drawn) == COPPICE_OK);
  CHECK(drawn.gpu_frame_number == 1 && drawn.visible_instance_count == 1 && drawn.drawn_leaf_count > 0);
  uint32_t settled = 0;
  CHECK(coppice_is_settled(context, of_view, &settled) == COPPICE_OK && settled <= 1);
  CHECK(coppice_plant_close(context, plant) == COPPICE_OK);
  draw_frame(gpu, context, 3, &view);
  CHECK(coppice_plant_open_async(context, path, &plant) == COPPICE_OK && plant != 0);
  CHECK(coppice_plant_get_info(context, plant, &info) == COPPICE_OK && info.state == COPPICE_PLANT_OPENING);
  CHECK(coppice_plant_close(context, plant) == COPPICE_OK);
  CHECK(coppice_plant_open_memory(context, path, strlen(path), "no plant", &plant) == COPPICE_ERROR_BAD_FILE && plant == 0);
  CHECK(coppice_plant_reload_memory(context, plant, path, strlen(path), "no plant") == COPPICE_ERROR_INVALID_ARGUMENT);
}

int main(int argc, char** argv) {
  CHECK(argc == 2);
  Gpu gpu = open_gpu();
  coppice_context_desc desc;
  coppice_vulkan_desc vulkan;
  coppice_context_desc_init(&desc);
  coppice_vulkan_desc_init(&vulkan);
  CHECK(coppice_version() == COPPICE_HEADER_VERSION);
  CHECK(desc.memory_budget_bytes == 256ull << 20);
  CHECK(vulkan.texture_compression_bc == VK_FALSE);
  coppice_context* context = NULL;
  CHECK(coppice_vulkan_context_create(&desc, &vulkan, &context) == COPPICE_ERROR_INVALID_ARGUMENT && context == NULL);
  CHECK(strstr(coppice_last_error(NULL), "coppice_vulkan_context_create: vulkan.instance ") == coppice_last_error(NULL));
  vulkan.instance = gpu.instance;
  vulkan.physical_device = gpu.physical_device;
  vulkan.device = gpu.device;
  vulkan.get_instance_proc_addr = vkGetInstanceProcAddr;
  vulkan.blocking_pipelines = VK_TRUE;
  uint64_t cost = 0;
  CHECK(coppice_vulkan_context_cost(&desc, &vulkan, &cost) == COPPICE_OK && cost > 0 && cost < desc.memory_budget_bytes);
  CHECK(coppice_vulkan_context_create(&desc, &vulkan, &context) == COPPICE_OK && context != NULL);
  CHECK(coppice_status_text(COPPICE_OK)[0] != 0);
  use_plant(&gpu, context, argv[1]);
  coppice_scene scene = 1;
  CHECK(coppice_scene_open(context, "/nonexistent/a.forest", NULL, &scene) == COPPICE_ERROR_IO && scene == 0);
  CHECK(strstr(coppice_last_error(context), "coppice_scene_open: /nonexistent/a.forest: ") == coppice_last_error(context));
  CHECK(strstr(coppice_last_error(context), strerror(ENOENT)) != NULL);
  CHECK(coppice_scene_close(context, scene) == COPPICE_ERROR_INVALID_ARGUMENT);
  coppice_scene_info scene_info;
  coppice_scene_info_init(&scene_info);
  CHECK(coppice_scene_get_info(context, scene, &scene_info) == COPPICE_ERROR_INVALID_ARGUMENT);
  coppice_context_destroy(context);
  coppice_context_destroy(NULL);
  close_gpu(&gpu);
  return 0;
}
