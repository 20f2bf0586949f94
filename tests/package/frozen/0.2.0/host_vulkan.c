/* A host of libcoppice_vulkan 0.2.0, as a program that was compiled then: it must run for ever. It calls every function of vulkan.h: a
 * plant for two eyes side by side in one attachment, in the light of a sun with a shadow map, with memory of the host's own.
 *
 *     host_vulkan PLANT.coppice
 */
#include <coppice/vulkan.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

enum { SIDE = 256 };

static coppice_context* context;

#define CHECK(condition)                                                                                                \
  do {                                                                                                                  \
    if (!(condition)) {                                                                                                 \
      fprintf(stderr, "host_vulkan: line %d: %s; last error: %s\n", __LINE__, #condition, coppice_last_error(context)); \
      exit(1);                                                                                                          \
    }                                                                                                                   \
  } while (0)
#define OK(call) CHECK((call) == COPPICE_OK)
#define VK(call) CHECK((call) == VK_SUCCESS)

static VkInstance instance;
static VkPhysicalDevice physical;
static VkDevice device;
static VkQueue queue;
static VkCommandPool pool;
static VkCommandBuffer cmd;
static VkPhysicalDeviceMemoryProperties memory_properties;
static int blocks;

typedef struct image {
  VkImage image;
  VkDeviceMemory memory;
  VkImageView view;
  VkImageAspectFlags aspect;
} image;

static void create_device(void) {
  VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
  VkInstanceCreateInfo of_instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
  VkPhysicalDeviceVulkan13Features v13 = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, .synchronization2 = VK_TRUE, .dynamicRendering = VK_TRUE};
  VkPhysicalDeviceVulkan12Features v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                          .pNext = &v13,
                                          .drawIndirectCount = VK_TRUE,
                                          .scalarBlockLayout = VK_TRUE,
                                          .bufferDeviceAddress = VK_TRUE};
  VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                        .pNext = &v12,
                                        .features = {.multiDrawIndirect = VK_TRUE, .drawIndirectFirstInstance = VK_TRUE}};
  const float priority = 1;
  VkDeviceQueueCreateInfo of_queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
  VkDeviceCreateInfo of_device = {
      .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &features, .queueCreateInfoCount = 1, .pQueueCreateInfos = &of_queue};
  VkCommandPoolCreateInfo of_pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                     .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT};
  VkCommandBufferAllocateInfo of_cmd = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandBufferCount = 1};
  VkQueueFamilyProperties families[16];
  uint32_t count = 1, family_count = 16;
  VK(vkCreateInstance(&of_instance, NULL, &instance));
  CHECK(vkEnumeratePhysicalDevices(instance, &count, &physical) >= 0 && count == 1);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &family_count, families);
  while (!(families[of_queue.queueFamilyIndex].queueFlags & VK_QUEUE_GRAPHICS_BIT)) ++of_queue.queueFamilyIndex;
  VK(vkCreateDevice(physical, &of_device, NULL, &device));
  vkGetDeviceQueue(device, of_queue.queueFamilyIndex, 0, &queue);
  of_pool.queueFamilyIndex = of_queue.queueFamilyIndex;
  VK(vkCreateCommandPool(device, &of_pool, NULL, &pool));
  of_cmd.commandPool = pool;
  VK(vkAllocateCommandBuffers(device, &of_cmd, &cmd));
  vkGetPhysicalDeviceMemoryProperties(physical, &memory_properties);
}

static uint32_t memory_type(uint32_t bits, VkMemoryPropertyFlags wanted) {
  uint32_t type = 0;
  while (!(bits >> type & 1u) || (memory_properties.memoryTypes[type].propertyFlags & wanted) != wanted) ++type;
  return type;
}

static VkDeviceMemory allocate(const VkMemoryRequirements* needs, VkMemoryPropertyFlags wanted, uint32_t* type) {
  VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO, .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
  VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .pNext = &flags, .allocationSize = needs->size};
  VkDeviceMemory memory;
  info.memoryTypeIndex = memory_type(needs->memoryTypeBits, wanted);
  VK(vkAllocateMemory(device, &info, NULL, &memory));
  if (type != NULL) *type = info.memoryTypeIndex;
  return memory;
}

static VkResult allocate_block(void* user, const VkMemoryRequirements* needs, VkMemoryPropertyFlags wanted, coppice_memory_block* block) {
  (void)user;
  CHECK(block->struct_size >= 40);
  block->memory = allocate(needs, wanted, &block->memory_type);
  block->offset = 0;
  block->handle = NULL;
  block->mapped = NULL;
  if (wanted & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) VK(vkMapMemory(device, block->memory, 0, VK_WHOLE_SIZE, 0, &block->mapped));
  ++blocks;
  return VK_SUCCESS;
}
static void free_block(void* user, const coppice_memory_block* block) {
  (void)user;
  vkFreeMemory(device, block->memory, NULL);
  --blocks;
}

static image create_image(uint32_t width, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect) {
  image made = {.aspect = aspect};
  VkMemoryRequirements needs;
  VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                            .imageType = VK_IMAGE_TYPE_2D,
                            .format = format,
                            .extent = {width, SIDE, 1},
                            .mipLevels = 1,
                            .arrayLayers = 1,
                            .samples = VK_SAMPLE_COUNT_1_BIT,
                            .usage = usage};
  VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                .format = format,
                                .subresourceRange = {aspect, 0, 1, 0, 1}};
  VK(vkCreateImage(device, &info, NULL, &made.image));
  vkGetImageMemoryRequirements(device, made.image, &needs);
  made.memory = allocate(&needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, NULL);
  VK(vkBindImageMemory(device, made.image, made.memory, 0));
  view.image = made.image;
  VK(vkCreateImageView(device, &view, NULL, &made.view));
  return made;
}
static void destroy_image(const image* made) {
  vkDestroyImageView(device, made->view, NULL);
  vkDestroyImage(device, made->image, NULL);
  vkFreeMemory(device, made->memory, NULL);
}

static void change_layout(const image* of, VkImageLayout from, VkImageLayout to) {
  VkImageMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                   .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                   .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                   .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT,
                                   .oldLayout = from,
                                   .newLayout = to,
                                   .image = of->image,
                                   .subresourceRange = {of->aspect, 0, 1, 0, 1}};
  VkDependencyInfo dependency = {
      .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
  vkCmdPipelineBarrier2(cmd, &dependency);
}

/* color: null for depth alone */
static void begin_rendering(const image* color, const image* depth, uint32_t width) {
  VkRenderingAttachmentInfo of_color = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                        .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                        .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                        .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                        .clearValue = {.color = {.float32 = {1, 1, 1, 1}}}};
  VkRenderingAttachmentInfo of_depth = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                        .imageView = depth->view,
                                        .imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL,
                                        .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                        .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
  VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                          .renderArea = {{0, 0}, {width, SIDE}},
                          .layerCount = 1,
                          .colorAttachmentCount = color != NULL,
                          .pColorAttachments = &of_color,
                          .pDepthAttachment = &of_depth};
  if (color != NULL) of_color.imageView = color->view;
  if (color != NULL) change_layout(color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
  change_layout(depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL);
  vkCmdBeginRendering(cmd, &info);
}

static void create_context(void) {
  coppice_context_desc desc;
  coppice_vulkan_desc vulkan;
  coppice_device_memory memory;
  uint64_t cost = 0;
  VkBool32 ready = VK_FALSE;
  coppice_context_desc_init(&desc);
  coppice_vulkan_desc_init(&vulkan);
  coppice_device_memory_init(&memory);
  memory.allocate = allocate_block;
  memory.free = free_block;
  vulkan.instance = instance;
  vulkan.physical_device = physical;
  vulkan.device = device;
  vulkan.get_instance_proc_addr = vkGetInstanceProcAddr;
  vulkan.device_memory = &memory;
  vulkan.pass_times = VK_TRUE;
  vulkan.blocking_pipelines = VK_TRUE;
  desc.memory_budget_bytes = 1;
  OK(coppice_vulkan_context_cost(&desc, &vulkan, &cost));
  CHECK(cost > 0);
  desc.memory_budget_bytes = cost + (64u << 20);
  OK(coppice_vulkan_context_create(&desc, &vulkan, &context));
  OK(coppice_pipelines_ready(context, &ready));
  CHECK(ready == VK_TRUE);
}

static coppice_view create_view(coppice_output output) {
  coppice_view_desc desc;
  coppice_vulkan_view_desc formats;
  coppice_view view = 0;
  coppice_view_desc_init(&desc);
  coppice_vulkan_view_desc_init(&formats);
  desc.output = output;
  if (output == COPPICE_OUTPUT_LIT) formats.color_formats[0] = VK_FORMAT_R8G8B8A8_UNORM;
  formats.depth_format = VK_FORMAT_D32_SFLOAT;
  OK(coppice_vulkan_view_create(context, &desc, &formats, &view));
  return view;
}

/* clip_from_view * view_from_world */
static void multiply(double* product, const float* clip_from_view, const double* view_from_world) {
  int column, row, k;
  for (column = 0; column < 4; ++column)
    for (row = 0; row < 4; ++row) {
      product[4 * column + row] = 0;
      for (k = 0; k < 4; ++k) product[4 * column + row] += (double)clip_from_view[4 * k + row] * view_from_world[4 * column + k];
    }
}

/* Looks at the plant along -Z, with eyes that are 6 cm apart; the second picture is right of the first. */
static coppice_camera camera_of(coppice_view view, const coppice_plant_info* plant, coppice_eye* second) {
  coppice_camera camera;
  coppice_camera_init(&camera);
  coppice_eye_init(second);
  camera.view = view;
  camera.width_px = camera.height_px = SIDE;
  camera.view_from_world[12] = -plant->sphere_center[0];
  camera.view_from_world[13] = -plant->sphere_center[1];
  camera.view_from_world[14] = -plant->sphere_center[2] - 2.0 * plant->sphere_radius;
  camera.clip_from_view[5] = -1;
  camera.clip_from_view[10] = camera.clip_from_view[15] = 0;
  camera.clip_from_view[11] = -1;
  camera.clip_from_view[14] = 0.1f;
  memcpy(second->view_from_world, camera.view_from_world, sizeof second->view_from_world);
  memcpy(second->clip_from_view, camera.clip_from_view, sizeof second->clip_from_view);
  second->view_from_world[12] -= 0.06;
  second->x_px = SIDE;
  camera.second_eye = second;
  return camera;
}

/* Pixels of an eye's half that are not white. */
static int covered(const unsigned char* rgba, int eye) {
  int x, y, count = 0;
  for (y = 0; y < SIDE; ++y)
    for (x = eye * SIDE; x < (eye + 1) * SIDE; ++x) count += rgba[4 * (y * 2 * SIDE + x) + 1] < 250;
  return count;
}

int main(int argc, char** argv) {
  image color, depth, map;
  coppice_plant plant = 0;
  coppice_plant_info info;
  coppice_placement placement;
  coppice_camera cameras[2];
  coppice_eye second;
  coppice_sun_desc sun;
  coppice_shadow_map shadow;
  coppice_light light;
  coppice_view_stats stats;
  coppice_frame frame;
  VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &cmd};
  VkBufferCreateInfo of_buffer = {
      .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = 2 * SIDE * SIDE * 4, .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
  VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1}, .imageExtent = {2 * SIDE, SIDE, 1}};
  VkMemoryRequirements needs;
  VkBuffer buffer;
  VkDeviceMemory memory;
  void* rgba = NULL;
  uint32_t settled = COPPICE_FALSE, eye;
  uint64_t number = 0;
  CHECK(argc == 2);
  create_device();
  color = create_image(2 * SIDE, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                       VK_IMAGE_ASPECT_COLOR_BIT);
  depth = create_image(2 * SIDE, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT);
  map = create_image(SIDE, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                     VK_IMAGE_ASPECT_DEPTH_BIT);

  create_context();
  OK(coppice_plant_open(context, argv[1], &plant));
  coppice_placement_init(&placement);
  OK(coppice_instances_add(context, plant, &placement, sizeof placement, 1, NULL));
  coppice_plant_info_init(&info);
  OK(coppice_plant_get_info(context, plant, &info));
  cameras[0] = camera_of(create_view(COPPICE_OUTPUT_LIT), &info, &second);
  coppice_sun_desc_init(&sun);
  sun.radius_m = 2 * info.sphere_radius;
  sun.size_px = SIDE;
  coppice_camera_init(&cameras[1]);
  OK(coppice_sun_camera(context, create_view(COPPICE_OUTPUT_DEPTH), &sun, &cameras[1]));
  memset(&shadow, 0, sizeof shadow);
  shadow.image = map.view;
  multiply(shadow.clip_from_world, cameras[1].clip_from_view, cameras[1].view_from_world);
  coppice_light_init(&light);
  light.shadow_maps = &shadow;
  light.shadow_map_count = 1;
  coppice_view_stats_init(&stats);

  while (!settled || stats.gpu_frame_number == 0) {
    coppice_frame_init(&frame);
    frame.frame_number = ++number;
    frame.completed_number = number - 1;
    frame.cameras = cameras;
    frame.camera_count = 2;
    OK(coppice_frame_begin(context, &frame));
    VK(vkBeginCommandBuffer(cmd, &begin));
    OK(coppice_record_upload(context, cmd));
    OK(coppice_record_cull(context, cmd, cameras[1].view, NULL));
    begin_rendering(NULL, &map, SIDE);
    OK(coppice_record_draw(context, cmd, cameras[1].view, 0));
    vkCmdEndRendering(cmd);
    change_layout(&map, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    OK(coppice_record_cull(context, cmd, cameras[0].view, &light));
    begin_rendering(&color, &depth, 2 * SIDE);
    for (eye = 0; eye < 2; ++eye) OK(coppice_record_draw(context, cmd, cameras[0].view, eye));
    vkCmdEndRendering(cmd);
    change_layout(&color, VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    VK(vkEndCommandBuffer(cmd));
    VK(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE));
    VK(vkQueueWaitIdle(queue));
    OK(coppice_is_settled(context, cameras[0].view, &settled));
    OK(coppice_get_view_stats(context, cameras[0].view, &stats));
  }
  CHECK(stats.visible_instance_count == 1 && stats.drawn_leaf_count > 0 && stats.pass_ms[COPPICE_PASS_CULL] >= 0);
  CHECK(blocks > 0);

  VK(vkCreateBuffer(device, &of_buffer, NULL, &buffer));
  vkGetBufferMemoryRequirements(device, buffer, &needs);
  memory = allocate(&needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, NULL);
  VK(vkBindBufferMemory(device, buffer, memory, 0));
  VK(vkBeginCommandBuffer(cmd, &begin));
  vkCmdCopyImageToBuffer(cmd, color.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
  VK(vkEndCommandBuffer(cmd));
  VK(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE));
  VK(vkQueueWaitIdle(queue));
  VK(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &rgba));
  CHECK(covered(rgba, 0) > SIDE && covered(rgba, 1) > SIDE);

  coppice_context_destroy(context);
  context = NULL;
  CHECK(blocks == 0);
  vkDestroyBuffer(device, buffer, NULL);
  vkFreeMemory(device, memory, NULL);
  destroy_image(&color);
  destroy_image(&depth);
  destroy_image(&map);
  vkDestroyCommandPool(device, pool, NULL);
  vkDestroyDevice(device, NULL);
  vkDestroyInstance(instance, NULL);
  puts("host_vulkan: ran");
  return 0;
}
