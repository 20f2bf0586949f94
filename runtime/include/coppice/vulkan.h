#ifndef COPPICE_VULKAN_H
#define COPPICE_VULKAN_H

/* The renderer of libcoppice on the engine's Vulkan device.
 *
 * The engine owns the Vulkan device, its queues and its command buffers. Coppice records into command buffers it is given; it never
 * submits and never waits for the GPU. A frame:
 *
 *     coppice_frame_begin(context, &frame);              with the cameras of all views: pump streaming, recycle what the GPU is done with
 *     coppice_record_upload(context, cmd);               outside a render pass
 *     coppice_record_cull(context, cmd, view, &light);   outside a render pass; of each view
 *     vkCmdBeginRendering(cmd, ...);                     or vkCmdBeginRenderPass, where the view has a render_pass
 *     coppice_record_draw(context, cmd, view, 0);        of each view
 *     vkCmdEndRendering(cmd);
 *
 * Views are culled and drawn in any order after the upload, also into command buffers of their own, and may be culled or drawn more than
 * once: a draw shows what the cull before it found. All of a context's commands go to one graphics queue, in the order of their frames (or
 * to several: coppice_vulkan_desc.queue_families), and what record_upload recorded must be submitted: Coppice counts on it. Light with a
 * shadow map needs the map when the view is *culled*:
 *
 *     coppice_record_cull(context, cmd, sun, NULL);      of a view of COPPICE_OUTPUT_DEPTH, which coppice_sun_camera looks for
 *     vkCmdBeginRendering ... coppice_record_draw(context, cmd, sun, 0) ... vkCmdEndRendering
 *     vkCmdPipelineBarrier2                              depth attachment writes -> sampled reads in compute, vertex and fragment shaders
 *     coppice_record_cull(context, cmd, view, &light);   light.shadow_maps has the map
 *     ...
 *
 * Where the engine has enabled VK_EXT_debug_utils, what is recorded has labels, pipelines have names, and so have buffers, images, their
 * views, descriptor sets and memory: these begin with "coppice ". Depth may run either way: see
 * depth_compare. What coppice.h says of threads, errors, booleans and struct_size holds here too.
 *
 * A lost device: the call in which Vulkan said so returns COPPICE_ERROR_DEVICE_LOST and writes a line; from then on so does, without a
 * line, every function that opens, reloads, adds instances, begins a frame or records. Plants and instances can still be closed and
 * removed, and the context destroyed. What the engine learns from its own submits Coppice does not hear of: destroy the context then as
 * well.
 */

#include <coppice/coppice.h>

#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The structs of this header, for coppice_vulkan_struct_init. */
typedef enum coppice_vulkan_struct {
  COPPICE_VULKAN_STRUCT_DESC = 0,
  COPPICE_VULKAN_STRUCT_DEVICE_MEMORY = 1,
  COPPICE_VULKAN_STRUCT_VIEW_DESC = 2,
  COPPICE_VULKAN_STRUCT_LIGHT = 3,
  COPPICE_VULKAN_STRUCT_OCCLUDER = 4,
  COPPICE_VULKAN_STRUCT_MAX_ENUM = 0x7fffffff
} coppice_vulkan_struct;
/* As coppice_struct_init. */
COPPICE_API void coppice_vulkan_struct_init(coppice_vulkan_struct kind, void* data, size_t bytes);

/* ---- context -------------------------------------------------------------------------------------------------------------------- */

/* A run of device memory. struct_size is the library's; an allocate function fills the other fields that it knows. */
typedef struct coppice_memory_block {
  uint32_t struct_size;
  uint32_t memory_type; /* of VkPhysicalDeviceMemoryProperties; one of the memoryTypeBits asked for */
  VkDeviceMemory memory;
  VkDeviceSize offset; /* of its first byte in memory; a multiple of the alignment asked for */
  void* mapped;        /* its first byte; used where the memory is to be host visible, and mapped until it is freed */
  void* handle;        /* the engine's own, given back to free: an allocation of its allocator */
} coppice_memory_block;

/* A hook, as those of coppice.h are. Device memory, for engines with an allocator of their own: both functions, or none for
 * vkAllocateMemory. Coppice asks for blocks of about a 32nd of the memory budget, 256 KiB to 32 MiB, and divides them among buffers and
 * images; what is larger than half a block, or grows, gets one of its own.
 *   requirements  size, alignment, and memoryTypeBits, of which the engine chooses any type that has `properties`: DEVICE_LOCAL, or
 *                 HOST_VISIBLE and HOST_COHERENT. Device-local memory must have VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT
 *   returns       VK_SUCCESS, or what vkAllocateMemory would: VK_ERROR_OUT_OF_DEVICE_MEMORY is no worse than a full budget
 * A block may hold buffers beside optimally tiled images: what is next to it in `memory` the engine keeps bufferImageGranularity away.
 * It is Coppice's until it is freed: by then the GPU is done with it. coppice_context_destroy frees what is left. Called from the thread
 * inside coppice_vulkan_context_create, coppice_context_destroy, coppice_set_memory_budget, functions that open and reload plants,
 * coppice_instances_add, coppice_frame_begin, coppice_record_upload and coppice_record_cull; never while the camera stands still and all
 * that it wants is there. Blocks count whole towards memory_budget_bytes. May not call back into Coppice. Must outlive the context. */
typedef struct coppice_device_memory {
  uint32_t struct_size;
  void* user;
  VkResult (*allocate)(void* user, const VkMemoryRequirements* requirements, VkMemoryPropertyFlags properties, coppice_memory_block* block);
  void (*free)(void* user, const coppice_memory_block* block);
} coppice_device_memory;
static inline void coppice_device_memory_init(coppice_device_memory* hook) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_DEVICE_MEMORY, hook, sizeof *hook);
}

#define COPPICE_MAX_QUEUE_FAMILIES 3u

/* The device. Handles become null and must be set. Flags are VK_TRUE or VK_FALSE, no other value. */
typedef struct coppice_vulkan_desc {
  uint32_t struct_size;

  VkInstance instance;
  VkPhysicalDevice physical_device;
  VkDevice device; /* Vulkan 1.3, created with these features enabled: dynamicRendering (not where each view has a render_pass),
                      synchronization2, bufferDeviceAddress, scalarBlockLayout, multiDrawIndirect, drawIndirectFirstInstance. What the
                      physical device lacks is named in the log; what was merely not enabled Vulkan gives no way to see */
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  VkPipelineCache pipeline_cache;             /* may be null. Used by jobs, at any time until the context is destroyed: not one of
                                                 VK_PIPELINE_CACHE_CREATE_EXTERNALLY_SYNCHRONIZED_BIT. coppice_stats.pipelines_ms says
                                                 what it saves */
  const coppice_device_memory* device_memory; /* null, the default: vkAllocateMemory */

  /* VK_TRUE: `device` was created with the feature textureCompressionBC, so textures stay the BC1 and BC3 blocks they are in the file.
   * Default VK_FALSE, always right: they are decoded to RGBA8 on jobs and take four to eight times the memory. Where the physical device
   * lacks the feature it counts as VK_FALSE. */
  VkBool32 texture_compression_bc;

  /* VK_TRUE, the default: leaves below about 12 px, and the wood between them, are rasterised by compute shaders in coppice_record_cull,
   * and coppice_record_draw copies what they drew into the attachments, colour and depth, before it draws the rest: several times faster
   * where plants are many or far. Instances are then culled in blocks of those that were added one after the other: add neighbours
   * together. Takes 8 bytes a pixel of the largest view, and about 60 bytes a triangle of wood and of leaf meshes. Views with
   * COPPICE_LOD_FULL are drawn as with VK_FALSE, and all views on a device without subgroup ballots, with fewer than 15 storage buffers a
   * stage, or with max_instances above 16,777,216; a warning in the log says so. With the first instance its lists take 2 MB, 10 MB of each
   * view with colours, 31 MB more of each with COPPICE_CONTENT_VELOCITY, and 10 MB of all those of depth alone; from 131,072 instances on
   * up to twice that. */
  VkBool32 compute_raster;

  /* VK_TRUE: `device` was created with shaderInt64 and shaderBufferInt64Atomics. Default VK_FALSE, always right: the compute shaders then
   * go over all leaves twice. Where the physical device lacks a feature it counts as VK_FALSE. */
  VkBool32 shader_int64_atomics;
  /* VK_TRUE: coppice_view_stats.pass_ms is measured. Costs some hundredths of a millisecond a pass. Default VK_FALSE. */
  VkBool32 pass_times;

  /* VK_TRUE: a pipeline is built inside the call that first needs it, which then takes up to some hundred milliseconds, so that no picture
   * misses anything. Default VK_FALSE: by jobs, see coppice_pipelines_ready. */
  VkBool32 blocking_pipelines;

  /* VK_TRUE: `device` was created with the feature drawIndirectCount. Default VK_FALSE, always right: each culling then clears its draw
   * commands, and every draw goes through all that there is room for. Where the physical device lacks the feature it counts as VK_FALSE. */
  VkBool32 draw_indirect_count;

  /* Families of the queues that commands of the context are submitted to, where those are of more than one: 2 or 3 of them, each once.
   * coppice_record_upload may then be recorded for any queue, coppice_record_cull for one with COMPUTE and coppice_record_draw for one with
   * GRAPHICS: culling beside the engine's own graphics work. Buffers and images are made with VK_SHARING_MODE_CONCURRENT, so that nothing
   * changes owners, and barriers wait for all that the queue does. From one queue to the next the engine waits by semaphores, with all
   * stages, so that uploads, culls and draws run in the order that one queue would run them in: a cull also after the draws of the frame
   * before, as it fills what those read. pass_times wants queues with timestamps, none for transfers alone. Default 0: one family; with
   * more, uploads have no debug label, which transfer queues do not take. */
  uint32_t queue_family_count;
  uint32_t queue_families[COPPICE_MAX_QUEUE_FAMILIES]; /* [queue_family_count] */
} coppice_vulkan_desc;
static inline void coppice_vulkan_desc_init(coppice_vulkan_desc* desc) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_DESC, desc, sizeof *desc);
}

/* Creates what every frame needs, and has pipelines built by the jobs hook. Cost: some milliseconds. On error *context is null.
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: a field of desc or vulkan, which the log and coppice_last_error(NULL) name.
 * COPPICE_ERROR_UNSUPPORTED, COPPICE_ERROR_OUT_OF_MEMORY, COPPICE_ERROR_DEVICE_LOST, COPPICE_ERROR_INTERNAL */
COPPICE_API coppice_status coppice_vulkan_context_create(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                                         coppice_context** context);

/* The memory that a context of these descs takes before any plant: coppice_stats.memory_bytes right after its creation. It depends on
 * compute_raster, pass_times and memory_budget_bytes (a block of device memory is counted ahead), which has to be above it: 1 is allowed
 * here. Instances, plants, the lists and the picture of the compute rasteriser come on top when there are any. Cost: some milliseconds;
 * asks the device, but takes no memory of it, and calls no hook but the log. bytes: out; 0 on an error. errors: as
 * coppice_vulkan_context_create */
COPPICE_API coppice_status coppice_vulkan_context_cost(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                                       uint64_t* bytes);

/* Whether all pipelines are built that anything has needed so far. A view asks for the first when it is created, for others when what
 * they draw first comes: wood without a texture, normal maps, leaf meshes, a debug view. Nothing waits for them: what they
 * draw is missing meanwhile, or drawn as it can be (the compute rasteriser's work by the hardware, what has no texture by the pipeline for
 * textures, leaf meshes as quads, normal maps and debug views not at all), and coppice_stats.pipelines_built is below pipelines_wanted. An
 * engine may show a loading screen until the first are ready, with frames or without. Where a processor does the GPU's work they take
 * seconds, which count in time, not in frames; the default pool lets reads and decodes go first. One that cannot be built is an error in
 * the log, and what it draws stays away. ready: out; VK_FALSE on an error. errors: COPPICE_ERROR_INVALID_ARGUMENT; else of the first that
 * could not be built: COPPICE_ERROR_OUT_OF_MEMORY, COPPICE_ERROR_DEVICE_LOST, COPPICE_ERROR_INTERNAL */
COPPICE_API coppice_status coppice_pipelines_ready(const coppice_context* context, VkBool32* ready);

/* ---- views ----------------------------------------------------------------------------------------------------------------------- */

#define COPPICE_MAX_COLORS 8u

/* What a colour attachment gets. coppice_surface.glsl, which is installed beside this header, says which channel holds what, reads it back,
 * and has the light of COPPICE_CONTENT_LIT: an engine's lighting pass can start from it. */
typedef enum coppice_content {
  COPPICE_CONTENT_DEFAULT = 0, /* of COPPICE_OUTPUT_LIT the first is LIT; of COPPICE_OUTPUT_SURFACE they are ALBEDO, NORMAL, LIGHT, USER and
                                  VELOCITY in this order; others must be set */
  COPPICE_CONTENT_LIT = 1,     /* shaded by coppice_light, linear, with fog; alpha 1 */
  COPPICE_CONTENT_ALBEDO = 2,  /* albedo, linear: an sRGB format encodes it; alpha: occlusion */
  COPPICE_CONTENT_NORMAL = 3,  /* octahedral normal in world space, roughness, roundness */
  COPPICE_CONTENT_LIGHT = 4,   /* translucency, the share of the sun that arrives (through the plant's own crown, and past what is in
                                  coppice_light.shadow_maps), octahedral face */
  COPPICE_CONTENT_USER = 5,    /* coppice_placement.user_data, a byte each, lowest first: R8G8B8A8_UNORM holds all of it */
  COPPICE_CONTENT_VELOCITY = 6, /* px that the place has moved since the frame before, x and y; 1 in z where its instance came with this
                                   frame, grows up, or was moved with more than an eighth of the instance slots: then only the camera and
                                   the wind count; and where the place lay behind the eye then, with 0 in x and y. In a view that the frame
                                   before did not show the camera has no motion. R16G16B16A16_SFLOAT holds all of it. What the cameras'
                                   projections are shifted by (jitter) is in it */
  COPPICE_CONTENT_NONE = 7,     /* nothing is drawn to it: an attachment of the engine's own. Needs the feature independentBlend */
  COPPICE_CONTENT_MAX_ENUM = 0x7fffffff
} coppice_content;

/* What a view is drawn to: images with no other usage than that of attachments, and of SAMPLED where they become shadow maps. Formats must
 * be set. */
typedef struct coppice_vulkan_view_desc {
  uint32_t struct_size;
  /* Of the colour attachments that are bound while coppice_record_draw draws, VK_FORMAT_UNDEFINED from the first on that is not there: at
   * least one, but none of COPPICE_OUTPUT_DEPTH. No integers, but for COPPICE_CONTENT_NONE. */
  VkFormat color_formats[COPPICE_MAX_COLORS];
  VkFormat depth_format;         /* with depth */
  VkCompareOp depth_compare;     /* LESS, LESS_OR_EQUAL, GREATER or, the default, GREATER_OR_EQUAL: reversed depth */
  VkSampleCountFlagBits samples; /* default 1 */
  /* VK_TRUE: depth_format has stencil too, and while drawing the image is bound as the stencil attachment as well; what is in it stays.
   * Default VK_FALSE: no stencil attachment is bound. With a render_pass it says nothing: stencil always stays. */
  VkBool32 has_stencil;
  coppice_content contents[COPPICE_MAX_COLORS]; /* of color_formats; default COPPICE_CONTENT_DEFAULT */
  /* Not null: coppice_record_draw draws inside this subpass of a classic render pass, or of any that is compatible with it; default null:
   * inside dynamic rendering. The formats and samples above are those of the subpass: color_formats has an entry for each of its colour
   * references, with COPPICE_CONTENT_NONE and any colour format for one that is VK_ATTACHMENT_UNUSED. That they agree Vulkan gives no way
   * to see. No multiview. Jobs build pipelines with the pass whenever a plant needs another: it must live until the context is destroyed.
   * An engine that makes new passes keeps one of the same kind for Coppice; views share pipelines where render_pass and subpass are the
   * same. */
  uint32_t subpass; /* default 0 */
  VkRenderPass render_pass;
} coppice_vulkan_view_desc;
static inline void coppice_vulkan_view_desc_init(coppice_vulkan_view_desc* desc) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_VIEW_DESC, desc, sizeof *desc);
}

/* Pipelines are shared by views of the same formats; the first of their kind has some built (coppice_pipelines_ready). A view takes about
 * 64 bytes an instance slot and 1.5 KB a plant, draw commands of up to a 64th of the memory budget and what compute_raster says. cost: some
 * milliseconds, and pipelines by jobs. errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_UNSUPPORTED: a format, samples, or more
 * colours than the device draws to; COPPICE_ERROR_OUT_OF_MEMORY, COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_vulkan_view_create(coppice_context* context, const coppice_view_desc* desc,
                                                      const coppice_vulkan_view_desc* vulkan, coppice_view* view);

/* ---- recording ------------------------------------------------------------------------------------------------------------------- */

/* Records copies of changed instances and newly decoded pages, and takes the memory that the frame's views need.
 * before: coppice_frame_begin, once for each call. after: everything visible to coppice_record_cull and _draw. queue: graphics, or see
 * queue_families. errors: COPPICE_ERROR_INVALID_ARGUMENT: not the first call since coppice_frame_begin. COPPICE_ERROR_OUT_OF_MEMORY, or
 * COPPICE_ERROR_INTERNAL where the driver fails otherwise: nothing is drawn in this frame; the commands must be submitted all the same, and
 * the next frame tries again. COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_record_upload(coppice_context* context, VkCommandBuffer cmd);

#define COPPICE_MAX_SHADOW_MAPS 4u

/* A shadow map, the whole image: depth as a view of COPPICE_OUTPUT_DEPTH, or the engine itself, has drawn it before coppice_record_cull of
 * the view that it falls on, with reversed depth or not as that view has it. */
typedef struct coppice_shadow_map {
  VkImageView
      image; /* 2D, depth; SHADER_READ_ONLY_OPTIMAL, its writes visible to COMPUTE, VERTEX and FRAGMENT_SHADER / SHADER_SAMPLED_READ */
  double clip_from_world[16]; /* that it was drawn with: clip_from_view * view_from_world, multiplied as doubles; has an inverse */
} coppice_shadow_map;

/* What the engine has drawn in this frame before it culls plants: terrain, buildings, a depth prepass. What of plants lies behind it is
 * neither rasterised nor drawn; the picture is the one without, as long as the attachment that plants are drawn to has that depth too.
 *   depth       drawn with the camera's matrices, of each eye its own, in a viewport with depth from 0 to 1; in the direction of the view's
 *               depth_compare; in the view's depth_format, or a copy in D32_SFLOAT of that. Where nothing is it has the far plane's
 *   samples     one. With more than one in the attachments give the farthest of a pixel's, by VK_RESOLVE_MODE_MIN_BIT where depth is
 *               reversed, else MAX
 * It is used where compute shaders draw leaves (compute_raster), from the second frame on that has one: the first has its pipeline built.
 * Where the hardware draws all of a view it hides nothing. What it hides counts in coppice_view_stats as occluded, or as not drawn. */
typedef struct coppice_occluder {
  uint32_t struct_size;
  /* Where in the image the picture's first pixel is, beyond where it is in the attachments (coppice_camera.x_px, y_px; of the second eye
   * coppice_eye's): -65,536 to 65,536. 0, the default, for the depth attachment itself. Pixels outside the image hide nothing. */
  int32_t x_px, y_px;
  uint32_t reserved;        /* 0 */
  VkImageView image;        /* 2D, depth aspect; SHADER_READ_ONLY_OPTIMAL, its writes visible to COMPUTE_SHADER / SHADER_SAMPLED_READ; must
                               live until the GPU has finished the frame */
  VkImageView second_image; /* of the second eye; null, the default: both eyes are in `image` */
} coppice_occluder;
static inline void coppice_occluder_init(coppice_occluder* occluder) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_OCCLUDER, occluder, sizeof *occluder);
}

/* What COPPICE_CONTENT_LIT is shaded by. Of other contents LIGHT depends on sun_direction and the shadow maps, and nothing else on it. */
typedef struct coppice_light {
  uint32_t struct_size;
  float sun_direction[3]; /* unit, towards the sun, world space; default 0 1 0 */
  /* Linear; 0 to 1e9, here and below. A white surface that faces the sun comes out as sun_color and its share of sky and ground: there is
   * no division by pi. */
  float sun_color[3];    /* default 3 3 3 */
  float sky_color[3];    /* ambient from above; default 0.6 */
  float ground_color[3]; /* ambient from below; default 0.2 */
  float fog_color[3];    /* default 0 */
  float fog_density;     /* 1/m, 0 to 1e6; 0, the default, for none. transmittance = exp(-(fog_density * distance)^2) */
  /* What the sun does not reach: the first map that holds a place says. Plants look where the sun's ray enters the sphere about
   * them, so that what shades them is other plants, terrain and buildings; how a crown shades itself Coppice knows without a map. 0, the
   * default: all is in the sun. An image must live until the GPU has finished the frame. */
  const coppice_shadow_map* shadow_maps; /* [shadow_map_count], read within the call */
  uint32_t shadow_map_count;             /* at most COPPICE_MAX_SHADOW_MAPS */
  uint32_t
      shadow_map_bytes; /* from one to the next: sizeof(coppice_shadow_map) as the program was compiled with. coppice_light_init sets it */
  const coppice_occluder* occluder; /* read within the call; null, the default: plants alone hide plants */
} coppice_light;
static inline void coppice_light_init(coppice_light* light) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_LIGHT, light, sizeof *light);
  if (light) light->shadow_map_bytes = sizeof(coppice_shadow_map);
}

/* Records culling and cut selection of a view for every instance. Outside a render pass. queue: graphics, or see queue_families; in any
 * command buffer of the frame that is submitted after the upload's. thread: culls and draws of different views may be recorded at the same
 * time.
 * light: null stands for a default one, as for shadow maps, which have none.
 * before: coppice_record_upload in the same frame, else COPPICE_ERROR_INVALID_ARGUMENT; so too for a view that the frame did not begin
 * with. Where the compute rasteriser's picture or the images of the light find no memory the frame goes on without, and the log says so
 * once; what has no pipeline yet is left out (coppice_pipelines_ready). COPPICE_ERROR_DEVICE_LOST
 * after: draw commands visible to DRAW_INDIRECT and the vertex stage (the barrier is recorded here). */
COPPICE_API coppice_status coppice_record_cull(coppice_context* context, VkCommandBuffer cmd, coppice_view view,
                                               const coppice_light* light);

/* Records the draws of a view, as one of its eyes sees it. Inside dynamic rendering with the formats of its desc, or inside the subpass of
 * its render_pass; sets viewport and scissor to the view's, binds its own pipelines and descriptor sets (the engine must rebind its own),
 * records no barrier. queue: graphics. thread: as
 * coppice_record_cull. eye: 0, or 1 where the camera has a second_eye; each may have attachments of its own, or a rectangle of the same.
 * before: coppice_record_cull of the view in the same frame, submitted before; else COPPICE_ERROR_INVALID_ARGUMENT. Culls and draws of
 * other views may stand between. */
COPPICE_API coppice_status coppice_record_draw(coppice_context* context, VkCommandBuffer cmd, coppice_view view, uint32_t eye);

#ifdef __cplusplus
}
#endif

#endif
