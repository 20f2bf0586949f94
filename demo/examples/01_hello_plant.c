/* The smallest host of Coppice: opens one plant, draws it once, writes a picture. No window.
 *
 *     01_hello_plant PLANT.coppice PICTURE.ppm
 *
 * Everything Vulkan is the host's, as in an engine: the device, the images, the command buffer, the wait. What belongs to Coppice is in
 * main, between coppice_vulkan_context_create and coppice_context_destroy.
 */
#include <volk.h>

#include <coppice/vulkan.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { kSide = 512 };
static const VkFormat kColorFormat = VK_FORMAT_R8G8B8A8_SRGB;
static const VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;

/* Prints what failed and ends the program with exit code 1. */
static void require(int succeeded, const char* what) {
  if (succeeded) return;
  fprintf(stderr, "01_hello_plant: %s failed\n", what);
  exit(1);
}
#define REQUIRE_VK(call) require((call) == VK_SUCCESS, #call)
#define REQUIRE_COPPICE(call) require((call) == COPPICE_OK, #call)

static void print_error(void* user, coppice_log_level level, const char* line) {
  (void)user;
  if (level != COPPICE_LOG_INFO) fprintf(stderr, "coppice: %s\n", line);
}

/* ---- the host's Vulkan ---------------------------------------------------------------------------------------------------------- */

typedef struct Host {
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice device;
  VkQueue queue;
  VkCommandPool pool;
  VkCommandBuffer commands;
  VkBool32 texture_compression_bc, draw_indirect_count;
} Host;

typedef struct Target {
  VkImage image;
  VkImageView view;
  VkDeviceMemory memory;
} Target;

static uint32_t graphics_family(VkPhysicalDevice physical) {
  VkQueueFamilyProperties families[16];
  uint32_t count = 16, i;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
  for (i = 0; i < count; ++i)
    if (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) return i;
  require(0, "finding a graphics queue");
  return 0;
}

/* The features coppice_vulkan_desc asks for, and textureCompressionBC and drawIndirectCount, which it can do without. */
static void create_device(Host* host, uint32_t family) {
  const float priority = 1;
  VkPhysicalDeviceVulkan12Features available12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceFeatures2 available = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &available12};
  VkPhysicalDeviceVulkan13Features v13 = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, .synchronization2 = VK_TRUE, .dynamicRendering = VK_TRUE};
  VkPhysicalDeviceVulkan12Features v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                          .pNext = &v13,
                                          .scalarBlockLayout = VK_TRUE,
                                          .bufferDeviceAddress = VK_TRUE};
  VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v12};
  VkDeviceQueueCreateInfo queue = {
      .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueFamilyIndex = family, .queueCount = 1, .pQueuePriorities = &priority};
  VkDeviceCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &features, .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue};
  features.features.multiDrawIndirect = VK_TRUE;
  features.features.drawIndirectFirstInstance = VK_TRUE;
  vkGetPhysicalDeviceFeatures2(host->physical, &available);
  host->texture_compression_bc = features.features.textureCompressionBC = available.features.textureCompressionBC;
  host->draw_indirect_count = v12.drawIndirectCount = available12.drawIndirectCount;
  REQUIRE_VK(vkCreateDevice(host->physical, &info, NULL, &host->device));
}

static Host create_host(void) {
  Host host;
  VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
  VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
  VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                  .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT};
  VkCommandBufferAllocateInfo buffers = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandBufferCount = 1};
  uint32_t one = 1;
  REQUIRE_VK(volkInitialize());
  REQUIRE_VK(vkCreateInstance(&instance, NULL, &host.instance));
  volkLoadInstance(host.instance);
  require(vkEnumeratePhysicalDevices(host.instance, &one, &host.physical) >= 0 && one == 1, "finding a Vulkan device");
  pool.queueFamilyIndex = graphics_family(host.physical);
  create_device(&host, pool.queueFamilyIndex);
  volkLoadDevice(host.device);
  vkGetDeviceQueue(host.device, pool.queueFamilyIndex, 0, &host.queue);
  REQUIRE_VK(vkCreateCommandPool(host.device, &pool, NULL, &host.pool));
  buffers.commandPool = host.pool;
  REQUIRE_VK(vkAllocateCommandBuffers(host.device, &buffers, &host.commands));
  return host;
}

static void destroy_host(Host* host) {
  vkDestroyCommandPool(host->device, host->pool, NULL);
  vkDestroyDevice(host->device, NULL);
  vkDestroyInstance(host->instance, NULL);
}

static VkDeviceMemory allocate(const Host* host, VkMemoryRequirements needs, VkMemoryPropertyFlags wanted) {
  VkPhysicalDeviceMemoryProperties memory;
  VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size};
  VkDeviceMemory result = VK_NULL_HANDLE;
  vkGetPhysicalDeviceMemoryProperties(host->physical, &memory);
  for (; info.memoryTypeIndex < memory.memoryTypeCount; ++info.memoryTypeIndex)
    if ((needs.memoryTypeBits >> info.memoryTypeIndex & 1) && (memory.memoryTypes[info.memoryTypeIndex].propertyFlags & wanted) == wanted)
      break;
  require(info.memoryTypeIndex < memory.memoryTypeCount, "finding a memory type");
  REQUIRE_VK(vkAllocateMemory(host->device, &info, NULL, &result));
  return result;
}

static Target create_target(const Host* host, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect) {
  Target target;
  VkMemoryRequirements needs;
  VkImageCreateInfo image = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                             .imageType = VK_IMAGE_TYPE_2D,
                             .format = format,
                             .extent = {kSide, kSide, 1},
                             .mipLevels = 1,
                             .arrayLayers = 1,
                             .samples = VK_SAMPLE_COUNT_1_BIT,
                             .usage = usage};
  VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                .format = format,
                                .subresourceRange = {aspect, 0, 1, 0, 1}};
  REQUIRE_VK(vkCreateImage(host->device, &image, NULL, &target.image));
  vkGetImageMemoryRequirements(host->device, target.image, &needs);
  target.memory = allocate(host, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  REQUIRE_VK(vkBindImageMemory(host->device, target.image, target.memory, 0));
  view.image = target.image;
  REQUIRE_VK(vkCreateImageView(host->device, &view, NULL, &target.view));
  return target;
}

static void destroy_target(const Host* host, Target* target) {
  vkDestroyImageView(host->device, target->view, NULL);
  vkDestroyImage(host->device, target->image, NULL);
  vkFreeMemory(host->device, target->memory, NULL);
}

static void begin_commands(const Host* host) {
  VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  REQUIRE_VK(vkBeginCommandBuffer(host->commands, &begin));
}

/* A GPU that takes longer hangs. */
#define MOST_WAIT_NS 600000000000ull

static void submit_and_wait(const Host* host) {
  const VkFenceCreateInfo fence_info = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence done;
  VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &host->commands};
  REQUIRE_VK(vkEndCommandBuffer(host->commands));
  REQUIRE_VK(vkCreateFence(host->device, &fence_info, NULL, &done));
  REQUIRE_VK(vkQueueSubmit(host->queue, 1, &submit, done));
  REQUIRE_VK(vkWaitForFences(host->device, 1, &done, VK_TRUE, MOST_WAIT_NS));
  vkDestroyFence(host->device, done, NULL);
}

/* Waits for everything before and holds back everything after: the simplest barrier, not the fastest. */
static void change_layout(const Host* host, VkImage image, VkImageAspectFlags aspect, VkImageLayout from, VkImageLayout to) {
  VkImageMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                   .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                   .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                   .oldLayout = from,
                                   .newLayout = to,
                                   .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                   .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                   .image = image,
                                   .subresourceRange = {aspect, 0, 1, 0, 1}};
  VkDependencyInfo dependency = {
      .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
  vkCmdPipelineBarrier2(host->commands, &dependency);
}

static void begin_rendering(const Host* host, const Target* color, const Target* depth) {
  VkRenderingAttachmentInfo color_info = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                          .imageView = color->view,
                                          .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                          .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                          .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                          .clearValue = {.color = {.float32 = {0.6f, 0.75f, 0.9f, 1}}}};
  VkRenderingAttachmentInfo depth_info = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                          .imageView = depth->view,
                                          .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                          .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR, /* to 0: reversed depth */
                                          .storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE};
  VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                          .renderArea = {{0, 0}, {kSide, kSide}},
                          .layerCount = 1,
                          .colorAttachmentCount = 1,
                          .pColorAttachments = &color_info,
                          .pDepthAttachment = &depth_info};
  change_layout(host, color->image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
  change_layout(host, depth->image, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
  vkCmdBeginRendering(host->commands, &info);
}

static void write_ppm(const char* path, const unsigned char* rgba) {
  FILE* file = fopen(path, "wb");
  size_t i;
  int written;
  require(file != NULL, "creating the picture");
  written = fprintf(file, "P6\n%d %d\n255\n", kSide, kSide) > 0;
  for (i = 0; i < (size_t)kSide * kSide; ++i) written &= fwrite(rgba + 4 * i, 1, 3, file) == 3;
  require(fclose(file) == 0 && written, "writing the picture");
}

static void save_picture(const Host* host, const Target* color, const char* path) {
  VkBufferCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = (VkDeviceSize)kSide * kSide * 4, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
  VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, .imageExtent = {kSide, kSide, 1}};
  VkMemoryBarrier2 to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                              .srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
                              .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                              .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
                              .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
  VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &to_host};
  VkMemoryRequirements needs;
  VkDeviceMemory memory;
  VkBuffer buffer;
  void* mapped = NULL;
  REQUIRE_VK(vkCreateBuffer(host->device, &info, NULL, &buffer));
  vkGetBufferMemoryRequirements(host->device, buffer, &needs);
  memory = allocate(host, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  REQUIRE_VK(vkBindBufferMemory(host->device, buffer, memory, 0));
  begin_commands(host);
  change_layout(host, color->image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
  vkCmdCopyImageToBuffer(host->commands, color->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
  vkCmdPipelineBarrier2(host->commands, &dependency);
  submit_and_wait(host);
  REQUIRE_VK(vkMapMemory(host->device, memory, 0, VK_WHOLE_SIZE, 0, &mapped));
  write_ppm(path, mapped);
  vkDestroyBuffer(host->device, buffer, NULL);
  vkFreeMemory(host->device, memory, NULL);
}

/* ---- Coppice -------------------------------------------------------------------------------------------------------------------- */

static coppice_context* create_context(const Host* host) {
  coppice_context* context = NULL;
  coppice_context_desc desc;
  coppice_vulkan_desc vulkan;
  coppice_log log;
  coppice_context_desc_init(&desc);
  coppice_vulkan_desc_init(&vulkan);
  coppice_log_init(&log);
  vulkan.instance = host->instance;
  vulkan.physical_device = host->physical;
  vulkan.device = host->device;
  vulkan.get_instance_proc_addr = vkGetInstanceProcAddr;
  vulkan.texture_compression_bc = host->texture_compression_bc;
  vulkan.draw_indirect_count = host->draw_indirect_count;
  vulkan.blocking_pipelines = VK_TRUE; /* nothing may be missing from a picture */
  log.write = print_error;
  desc.log = &log;
  REQUIRE_COPPICE(coppice_vulkan_context_create(&desc, &vulkan, &context));
  return context;
}

static coppice_view create_view(coppice_context* context) {
  coppice_view view = 0;
  coppice_view_desc desc;
  coppice_vulkan_view_desc formats;
  coppice_view_desc_init(&desc);
  coppice_vulkan_view_desc_init(&formats);
  formats.color_formats[0] = kColorFormat;
  formats.depth_format = kDepthFormat;
  REQUIRE_COPPICE(coppice_vulkan_view_create(context, &desc, &formats, &view));
  return view;
}

/* Looks along -Z at the plant's bounding sphere from the distance at which a 45 degree view just holds it. */
static coppice_camera camera_of(coppice_view view, const coppice_plant_info* plant) {
  const float half_angle = 0.3926991f;
  const float distance = plant->sphere_radius / sinf(half_angle);
  const float near_m = 0.05f, far_m = 1000;
  coppice_camera camera;
  coppice_camera_init(&camera);
  camera.view = view;
  memset(camera.view_from_world, 0, sizeof camera.view_from_world);
  memset(camera.clip_from_view, 0, sizeof camera.clip_from_view);
  camera.view_from_world[0] = camera.view_from_world[5] = camera.view_from_world[10] = camera.view_from_world[15] = 1;
  camera.view_from_world[12] = -plant->sphere_center[0];
  camera.view_from_world[13] = -plant->sphere_center[1];
  camera.view_from_world[14] = -plant->sphere_center[2] - distance;
  camera.clip_from_view[0] = 1 / tanf(half_angle);
  camera.clip_from_view[5] = -1 / tanf(half_angle);
  camera.clip_from_view[10] = near_m / (far_m - near_m);
  camera.clip_from_view[11] = -1;
  camera.clip_from_view[14] = near_m * far_m / (far_m - near_m);
  camera.width_px = kSide;
  camera.height_px = kSide;
  return camera;
}

/* One frame of any host. Here the GPU has always finished the frame before. */
static void draw_frame(const Host* host, coppice_context* context, const coppice_camera* camera, uint64_t number, const Target* color,
                       const Target* depth) {
  coppice_frame frame;
  coppice_frame_init(&frame);
  frame.frame_number = number;
  frame.completed_number = number - 1;
  frame.cameras = camera;
  frame.camera_count = 1;
  REQUIRE_COPPICE(coppice_frame_begin(context, &frame));
  begin_commands(host);
  REQUIRE_COPPICE(coppice_record_upload(context, host->commands));
  REQUIRE_COPPICE(coppice_record_cull(context, host->commands, camera->view, NULL));
  begin_rendering(host, color, depth);
  REQUIRE_COPPICE(coppice_record_draw(context, host->commands, camera->view, 0));
  vkCmdEndRendering(host->commands);
  submit_and_wait(host);
}

/* Draws until all the view wants has arrived, and its figures with it. */
static coppice_view_stats draw_until_settled(const Host* host, coppice_context* context, const coppice_camera* camera, const Target* color,
                                             const Target* depth) {
  coppice_view_stats stats;
  uint32_t settled = 0;
  uint64_t number = 0;
  coppice_view_stats_init(&stats);
  do {
    draw_frame(host, context, camera, ++number, color, depth);
    REQUIRE_COPPICE(coppice_is_settled(context, camera->view, &settled));
    REQUIRE_COPPICE(coppice_get_view_stats(context, camera->view, &stats));
  } while (stats.gpu_frame_number == 0 || !settled);
  return stats;
}

int main(int argc, char** argv) {
  Host host;
  Target color, depth;
  coppice_context* context;
  coppice_plant plant = 0;
  coppice_plant_info info;
  coppice_camera camera;
  coppice_view_stats stats;
  coppice_placement placement;
  coppice_placement_init(&placement);
  if (argc != 3) {
    fprintf(stderr, "usage: 01_hello_plant PLANT.coppice PICTURE.ppm\n");
    return 2;
  }
  host = create_host();
  color =
      create_target(&host, kColorFormat, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT);
  depth = create_target(&host, kDepthFormat, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT);

  context = create_context(&host);
  REQUIRE_COPPICE(coppice_plant_open(context, argv[1], &plant));
  REQUIRE_COPPICE(coppice_instances_add(context, plant, &placement, sizeof(coppice_placement), 1, NULL));
  coppice_plant_info_init(&info);
  REQUIRE_COPPICE(coppice_plant_get_info(context, plant, &info));
  camera = camera_of(create_view(context), &info);
  stats = draw_until_settled(&host, context, &camera, &color, &depth);
  printf("%s: %llu of %u leaves drawn\n", info.name, (unsigned long long)stats.drawn_leaf_count, info.leaf_count);
  coppice_context_destroy(context);

  save_picture(&host, &color, argv[2]);
  destroy_target(&host, &color);
  destroy_target(&host, &depth);
  destroy_host(&host);
  return 0;
}
