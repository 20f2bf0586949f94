#ifndef COPPICE_VULKAN_H
#define COPPICE_VULKAN_H

/* The renderer of libcoppice on the engine's Vulkan device.
 *
 * The engine owns the Vulkan device, its queues and its command buffers. Coppice records into the command buffers that it is given. It
 * never submits and never waits for the GPU. A frame:
 *
 *     coppice_frame_begin(context, &frame);              with the cameras of all views: streams, and reuses what the GPU is done with
 *     coppice_record_upload(context, cmd);               outside a render pass
 *     coppice_record_cull(context, cmd, view, &light);   outside a render pass; for each view
 *     vkCmdBeginRendering(cmd, ...);                     or vkCmdBeginRenderPass, if the view has a render_pass
 *     coppice_record_draw(context, cmd, view, 0);        for each view
 *     vkCmdEndRendering(cmd);
 *
 * After the upload, views may be culled and drawn in any order, into command buffers of their own too, and more than once: a draw shows the
 * result of the cull before it. All commands of a context go to one graphics queue in the order of their frames (or to several queues:
 * coppice_vulkan_desc.queue_families). The commands of coppice_record_upload must be submitted: Coppice relies on it. Light with a shadow
 * map needs the map when the view is *culled*:
 *
 *     coppice_record_cull(context, cmd, sun, NULL);      a view of COPPICE_OUTPUT_DEPTH; coppice_sun_camera fills its camera
 *     vkCmdBeginRendering ... coppice_record_draw(context, cmd, sun, 0) ... vkCmdEndRendering
 *     vkCmdPipelineBarrier2                              depth attachment writes -> sampled reads in compute, vertex and fragment shaders
 *     coppice_record_cull(context, cmd, view, &light);   light.shadow_maps has the map
 *     ...
 *
 * If the engine has enabled VK_EXT_debug_utils, commands have labels, and pipelines, buffers, images, image views, descriptor sets and
 * memory have names that begin with "coppice ". Depth may run either way: see depth_compare. The rules of coppice.h about threads, errors,
 * booleans and struct_size apply here too.
 *
 * A lost device: the call in which Vulkan reports it returns COPPICE_ERROR_DEVICE_LOST and logs a line. From then on every function that
 * opens, reloads, adds instances, begins a frame or records returns the same without a line. Plants and instances can still be closed and
 * removed, and the context destroyed. Coppice does not see the results of the engine's own submits: if one of them reports the loss,
 * destroy the context too. */

#include <coppice/coppice.h>

#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Names the structs of this header for coppice_vulkan_struct_init. */
typedef enum coppice_vulkan_struct {
  COPPICE_VULKAN_STRUCT_DESC = 0,
  COPPICE_VULKAN_STRUCT_DEVICE_MEMORY = 1,
  COPPICE_VULKAN_STRUCT_VIEW_DESC = 2,
  COPPICE_VULKAN_STRUCT_LIGHT = 3,
  COPPICE_VULKAN_STRUCT_OCCLUDER = 4,
  COPPICE_VULKAN_STRUCT_MATERIAL_OVERRIDE = 5,
  COPPICE_VULKAN_STRUCT_TRIANGLES = 6,
  COPPICE_VULKAN_STRUCT_MAX_ENUM = 0x7fffffff
} coppice_vulkan_struct;
/* Does what coppice_struct_init does, for the structs of this header. */
COPPICE_API void coppice_vulkan_struct_init(coppice_vulkan_struct kind, void* data, size_t bytes);

/* ---- context -------------------------------------------------------------------------------------------------------------------- */

/* Describes a range of device memory. The library sets struct_size; an allocate function fills the other fields that it knows. */
typedef struct coppice_memory_block {
  uint32_t struct_size;
  uint32_t memory_type; /* index in VkPhysicalDeviceMemoryProperties; one of the memoryTypeBits asked for */
  VkDeviceMemory memory;
  VkDeviceSize offset; /* start of the range in memory; a multiple of the alignment asked for */
  /* pointer to the start of the range, for host-visible memory; stays mapped until it is freed */
  void* mapped;
  void* handle; /* the engine's own, for example an allocation of its allocator; passed to free */
} coppice_memory_block;

/* A hook, as those of coppice.h, for engines with their own allocator of device memory. Set both functions, or none for vkAllocateMemory.
 * Coppice asks for blocks of about a 32nd of the memory budget, 256 KiB to 32 MiB, and divides them among buffers and images. A buffer or
 * image larger than half a block, or one that grows, gets a block of its own.
 *   requirements  size, alignment, and memoryTypeBits, of which the engine chooses any type that has `properties`: DEVICE_LOCAL, or
 *                 HOST_VISIBLE and HOST_COHERENT. Device-local memory must have VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT
 *   returns       VK_SUCCESS, or an error of vkAllocateMemory; VK_ERROR_OUT_OF_DEVICE_MEMORY has the effect of a full budget
 * A block may hold buffers beside optimally tiled images; the engine keeps bufferImageGranularity to its neighbours in `memory`. The block
 * is Coppice's until it calls free, by when the GPU is done with it. coppice_context_destroy frees all remaining blocks. Blocks count whole
 * towards memory_budget_bytes. The functions must not call back into Coppice and must outlive the context. While the camera stands still
 * and everything in demand is resident they are not called.
 * thread: the one inside coppice_vulkan_context_create, coppice_context_destroy, coppice_set_memory_budget, functions that open and reload
 * plants, coppice_instances_add, coppice_frame_begin, coppice_record_upload and coppice_record_cull. */
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

/* Describes the device. The init function sets handles to null; they must be set. Flags are VK_TRUE or VK_FALSE, no other value. */
typedef struct coppice_vulkan_desc {
  uint32_t struct_size;

  VkInstance instance;
  VkPhysicalDevice physical_device;
  /* Vulkan 1.3, created with these features enabled: dynamicRendering (not needed if each view has a render_pass), synchronization2,
   * bufferDeviceAddress, scalarBlockLayout, multiDrawIndirect, drawIndirectFirstInstance. The log names those that the physical device
   * lacks. Vulkan gives no way to see which ones were not enabled. */
  VkDevice device;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  /* May be null. Jobs use it at any time until the context is destroyed, so it must not have
   * VK_PIPELINE_CACHE_CREATE_EXTERNALLY_SYNCHRONIZED_BIT. coppice_stats.pipelines_ms says what it saves. */
  VkPipelineCache pipeline_cache;
  const coppice_device_memory* device_memory; /* null, the default: vkAllocateMemory */

  /* VK_TRUE: `device` was created with the feature textureCompressionBC, so textures stay the BC1 and BC3 blocks of the file. Default
   * VK_FALSE, which always works: jobs decode them to RGBA8, which takes four to eight times the memory. If the physical device lacks the
   * feature, it counts as VK_FALSE. */
  VkBool32 texture_compression_bc;

  /* VK_TRUE, the default: compute shaders rasterise leaves below about 12 px, and the wood between them, in coppice_record_cull.
   * coppice_record_draw copies their colour and depth into the attachments before it draws the rest. This is several times faster if plants
   * are many or far. Instances are then culled in blocks of those that were added one after the other: add neighbours together.
   * VK_FALSE, or a missing requirement, draws everything by the hardware. Views with COPPICE_LOD_FULL are always drawn so. So are all views
   * on a device without subgroup ballots, with fewer than 15 storage buffers a stage, or with max_instances above 16,777,216; the log
   * warns.
   * Memory: 8 bytes a pixel of each view, and about 60 bytes a triangle of wood and of leaf meshes. With the first instance its lists take
   * 2 MB, 10 MB for each view with colours, 31 MB more for each with COPPICE_CONTENT_VELOCITY, and 10 MB for all views of only depth
   * together; from 131,072 instances on up to twice that. Below a budget of 256 MiB all but the 2 MB shrink with it; instances that find no
   * place in the lists are drawn coarser. coppice_vulkan_view_cost returns the sum. */
  VkBool32 compute_raster;

  /* VK_TRUE: `device` was created with shaderInt64 and shaderBufferInt64Atomics. Default VK_FALSE, which always works: the compute shaders
   * then process all leaves twice. If the physical device lacks a feature, it counts as VK_FALSE. */
  VkBool32 shader_int64_atomics;
  /* VK_TRUE measures coppice_view_stats.pass_ms, which costs some hundredths of a millisecond a pass. Default VK_FALSE. */
  VkBool32 pass_times;

  /* VK_TRUE: a pipeline is built inside the call that first needs it. The call then takes up to some hundred milliseconds, but no picture
   * misses anything. Default VK_FALSE: jobs build pipelines, see coppice_pipelines_ready. */
  VkBool32 blocking_pipelines;

  /* VK_TRUE: `device` was created with the feature drawIndirectCount. Default VK_FALSE, which always works: each culling then clears its
   * draw commands, and every draw goes through the whole list, used or not. If the physical device lacks the feature, it counts as
   * VK_FALSE. */
  VkBool32 draw_indirect_count;

  /* The families of the queues that commands of the context are submitted to, if there is more than one: 2 or 3 of them, each once. Default
   * 0: one family. coppice_record_upload may then be recorded for any queue, coppice_record_cull for one with COMPUTE, and
   * coppice_record_draw for one with GRAPHICS, so that culling can run beside the engine's own graphics work. Buffers and images are made
   * with VK_SHARING_MODE_CONCURRENT, so that they need no ownership transfers, and barriers wait for everything that the queue does.
   * Between queues the engine waits with semaphores, with all stages, so that uploads, culls and draws run in the order of a single queue.
   * That includes a cull after the draws of the frame before, because it overwrites what they read. pass_times needs queues with
   * timestamps, and none that only transfers. With several families uploads have no debug label, because transfer queues do not take any.
   */
  uint32_t queue_family_count;
  uint32_t queue_families[COPPICE_MAX_QUEUE_FAMILIES]; /* [queue_family_count] */
} coppice_vulkan_desc;
static inline void coppice_vulkan_desc_init(coppice_vulkan_desc* desc) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_DESC, desc, sizeof *desc);
}

/* Creates a context with our renderer. It creates what every frame needs; the jobs hook builds pipelines.
 * context: out, null on errors. cost: some milliseconds
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: a field of desc or vulkan, which the log and coppice_last_error(NULL) name;
 * COPPICE_ERROR_UNSUPPORTED, COPPICE_ERROR_OUT_OF_MEMORY, COPPICE_ERROR_DEVICE_LOST, COPPICE_ERROR_INTERNAL */
COPPICE_API coppice_status coppice_vulkan_context_create(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                                         coppice_context** context);

/* Returns the memory that a context of these descs takes before any plant: coppice_stats.memory_bytes right after its creation. It depends
 * on compute_raster, pass_times and memory_budget_bytes, because one block of device memory is reserved ahead. The budget has to be above
 * the result; here it may be 1. Plants take more, and views and instances as coppice_vulkan_view_cost says. It queries the
 * device, but allocates none of its memory, and calls no hook but the log.
 * bytes: out; 0 on an error. cost: some milliseconds. errors: as coppice_vulkan_context_create */
COPPICE_API coppice_status coppice_vulkan_context_cost(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                                       uint64_t* bytes);

/* Tells whether all pipelines are built that have been needed so far. A view needs the first when it is created, and others when their
 * first plants arrive: wood without a texture, normal maps, leaf meshes, a debug view. No frame waits for them. Meanwhile
 * coppice_stats.pipelines_built is below pipelines_wanted, and a replacement draws if there is one: the hardware for the compute
 * rasteriser, the pipeline with textures for plants without, quads for leaf meshes. Normal maps, debug views and everything else are
 * missing. An engine may show a loading screen until the first pipelines are ready, with frames or without. Building takes seconds if the
 * processor does the GPU's work; decoding comes first (coppice_jobs). A pipeline that cannot be built is an error in the log, and what it
 * draws stays missing.
 * ready: out; VK_FALSE on an error
 * errors: COPPICE_ERROR_INVALID_ARGUMENT; else the error of the first pipeline that could not be built: COPPICE_ERROR_OUT_OF_MEMORY,
 * COPPICE_ERROR_DEVICE_LOST, COPPICE_ERROR_INTERNAL */
COPPICE_API coppice_status coppice_pipelines_ready(const coppice_context* context, VkBool32* ready);

/* ---- views ----------------------------------------------------------------------------------------------------------------------- */

#define COPPICE_MAX_COLORS 8u

/* Says what a colour attachment holds. coppice_surface.glsl, which is installed beside this header, documents the channels and reads them
 * back. It also has the light of COPPICE_CONTENT_LIT, so that an engine's lighting pass can start from it. */
typedef enum coppice_content {
  /* In a view of COPPICE_OUTPUT_LIT the first attachment is LIT. With COPPICE_OUTPUT_SURFACE they are ALBEDO, NORMAL, LIGHT, USER and
   * VELOCITY in this order. Other attachments must be set. */
  COPPICE_CONTENT_DEFAULT = 0,
  COPPICE_CONTENT_LIT = 1,    /* shaded by coppice_light, linear, with fog; alpha 1 */
  COPPICE_CONTENT_ALBEDO = 2, /* albedo, linear (an sRGB format encodes it); alpha: occlusion */
  COPPICE_CONTENT_NORMAL = 3, /* octahedral normal in world space, roughness, along */
  /* translucency; the share of the sun that arrives (through the plant's own crown, and past coppice_light.shadow_maps); sided; 0 */
  COPPICE_CONTENT_LIGHT = 4,
  COPPICE_CONTENT_USER = 5, /* coppice_placement.user_data, a byte each, lowest first: R8G8B8A8_UNORM is exact */
  /* x, y: how far the place has moved since the frame before, px, including shifts (jitter) of the cameras' projections. z is 0, but 1 in
   * two cases:
   *   the instance came with this frame, grows up, or was moved together with more than an eighth of the instance slots; then x and y are
   *   the motion by the camera and the wind alone
   *   the place lay behind the eye in the frame before; then x and y are 0
   * In a view that the frame before did not show the camera counts as still. R16G16B16A16_SFLOAT is precise enough. */
  COPPICE_CONTENT_VELOCITY = 6,
  /* nothing is drawn to it: an attachment of the engine's own. Needs the feature independentBlend */
  COPPICE_CONTENT_NONE = 7,
  COPPICE_CONTENT_MAX_ENUM = 0x7fffffff
} coppice_content;

/* Describes the images that a view is drawn to. They need no usage but that of attachments, and SAMPLED for shadow maps. Formats must be
 * set. */
typedef struct coppice_vulkan_view_desc {
  uint32_t struct_size;
  /* The formats of the colour attachments that are bound during coppice_record_draw, then VK_FORMAT_UNDEFINED. At least one, but none with
   * COPPICE_OUTPUT_DEPTH. No integer formats, except for COPPICE_CONTENT_NONE. */
  VkFormat color_formats[COPPICE_MAX_COLORS];
  VkFormat depth_format;         /* a format with depth */
  VkCompareOp depth_compare;     /* LESS, LESS_OR_EQUAL, GREATER or, the default, GREATER_OR_EQUAL: reversed depth */
  VkSampleCountFlagBits samples; /* default 1 */
  /* VK_TRUE: depth_format has stencil too, and the image is also bound as the stencil attachment while drawing; its stencil is not changed.
   * Default VK_FALSE: no stencil attachment is bound. With a render_pass it is ignored: stencil is never changed. */
  VkBool32 has_stencil;
  coppice_content contents[COPPICE_MAX_COLORS]; /* one for each of color_formats; default COPPICE_CONTENT_DEFAULT */
  /* render_pass null, the default: coppice_record_draw draws inside dynamic rendering. Otherwise it draws inside this subpass of the pass,
   * or of any compatible pass. The formats and samples above must be those of the subpass: color_formats has an entry for each of its
   * colour references, with COPPICE_CONTENT_NONE and any colour format for one that is VK_ATTACHMENT_UNUSED. Vulkan gives no way to check
   * that. Multiview is not supported. Jobs build pipelines with the pass whenever a plant needs another, so it must live until the context
   * is destroyed. An engine that recreates its passes keeps a compatible one for Coppice. Views share pipelines if render_pass and subpass
   * are the same. */
  uint32_t subpass; /* default 0 */
  VkRenderPass render_pass;
} coppice_vulkan_view_desc;
static inline void coppice_vulkan_view_desc_init(coppice_vulkan_view_desc* desc) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_VIEW_DESC, desc, sizeof *desc);
}

/* Creates a view of a context with our renderer. Views of the same formats share pipelines; the first of its kind starts building some
 * (coppice_pipelines_ready). A view takes about 64 bytes an instance slot and 1.5 KB a plant, draw commands of up to a 64th of the memory
 * budget, and the memory that compute_raster names.
 * view: out, 0 on errors. cost: some milliseconds, and jobs that build pipelines
 * errors: COPPICE_ERROR_INVALID_ARGUMENT; COPPICE_ERROR_UNSUPPORTED: a format, samples, or more colours than the device draws to;
 * COPPICE_ERROR_OUT_OF_MEMORY, COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_vulkan_view_create(coppice_context* context, const coppice_view_desc* desc,
                                                      const coppice_vulkan_view_desc* vulkan, coppice_view* view);

/* Describes a view that is planned. */
typedef struct coppice_planned_view {
  const coppice_vulkan_view_desc* vulkan;
  coppice_output output;
  uint32_t width_px; /* of its cameras' pictures */
  uint32_t height_px;
  uint32_t eye_count; /* 1 or 2 */
} coppice_planned_view;

/* Returns the memory that a context of these descs takes with these views once instance_count instances have been added in one call, before
 * any chunk of a plant: what coppice_vulkan_context_cost returns, the views' lists and pictures, and the instances. A plant takes some
 * hundred kilobytes as soon as it is open, and a view up to a 64th of the budget for draw commands. Otherwise as
 * coppice_vulkan_context_cost.
 * views: [view_count], each `view_bytes` after the one before, which is sizeof(coppice_planned_view) as the program was compiled with
 * bytes: out; 0 on an error. errors: as coppice_vulkan_context_create and coppice_vulkan_view_create */
COPPICE_API coppice_status coppice_vulkan_view_cost(const coppice_context_desc* desc, const coppice_vulkan_desc* vulkan,
                                                    const coppice_planned_view* views, uint32_t view_count, uint32_t view_bytes,
                                                    uint32_t instance_count, uint64_t* bytes);

/* ---- materials ------------------------------------------------------------------------------------------------------------------- */

/* Changes all surfaces of a plant: a season, rain, snow, an artist's correction. An engine's own GLSL function can change them further: see
 * COPPICE_ENGINE_SURFACE in runtime/README.md. */
typedef struct coppice_material_override {
  uint32_t struct_size;
  /* They multiply the albedo, linear, 0 to 65504; default 1 1 1. The leaves' stands beside coppice_placement.tint. */
  float leaf_tint[3], wood_tint[3];
  float leaf_roughness, wood_roughness; /* 0 to 1; -1, the default: the material's own */
  float translucency;                   /* of leaves: the share of the sun on the back that shines through, 0 to 1; -1, the default: 0.45 */
  float parameters[4];                  /* for the engine's function, finite, magnitude at most 1e9; default 0 */
} coppice_material_override;
static inline void coppice_material_override_init(coppice_material_override* material_override) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_MATERIAL_OVERRIDE, material_override, sizeof *material_override);
}

/* Sets a plant's override, or removes it if material_override is null. It stays over reloads, until the plant is closed. Plants without one
 * cost nothing; if any plant has one, a pixel reads 52 bytes more.
 * after: it shows from the next coppice_record_upload on, in all views */
COPPICE_API coppice_status coppice_set_material_override(coppice_context* context, coppice_plant plant,
                                                         const coppice_material_override* material_override);

/* ---- recording ------------------------------------------------------------------------------------------------------------------- */

/* Records copies of changed instances and newly decoded pages, and allocates the memory that the frame's views need.
 * before: coppice_frame_begin, once for each call. after: everything is visible to coppice_record_cull and coppice_record_draw
 * queue: graphics, or see queue_families
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: not the first call since coppice_frame_begin; COPPICE_ERROR_OUT_OF_MEMORY, or
 * COPPICE_ERROR_INTERNAL for other failures of the driver: nothing is drawn in this frame, its commands must be submitted all the same, and
 * the next frame tries again; COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_record_upload(coppice_context* context, VkCommandBuffer cmd);

#define COPPICE_MAX_SHADOW_MAPS 4u

/* A shadow map, which fills the whole image. A view of COPPICE_OUTPUT_DEPTH, or the engine itself, has drawn its depth before
 * coppice_record_cull of the view that it shades. Its depth is reversed if that of the shaded view is. */
typedef struct coppice_shadow_map {
  /* 2D, depth; SHADER_READ_ONLY_OPTIMAL, its writes visible to COMPUTE, VERTEX and FRAGMENT_SHADER / SHADER_SAMPLED_READ */
  VkImageView image;
  /* the matrix it was drawn with: clip_from_view * view_from_world, multiplied as doubles; invertible */
  double clip_from_world[16];
} coppice_shadow_map;

/* The depth that the engine has drawn in this frame before plants are culled: terrain, buildings, a depth prepass. Plants behind it are
 * neither rasterised nor drawn. The picture does not change, provided that the attachment that plants are drawn to has that depth too.
 *   depth    drawn with the camera's matrices, for each eye its own, in a viewport with depth from 0 to 1, in the direction of the view's
 *            depth_compare. In the view's depth_format, or copied to D32_SFLOAT. Empty pixels hold the far plane's depth
 *   samples  one. If the attachments have more, pass the farthest sample of each pixel: resolve by VK_RESOLVE_MODE_MIN_BIT for reversed
 *            depth, else by VK_RESOLVE_MODE_MAX_BIT
 * It needs compute_raster, and hides nothing in views that the hardware draws entirely. The first frame with an occluder only starts
 * building its pipeline. coppice_view_stats counts what it hides as occluded, or as not drawn. */
typedef struct coppice_occluder {
  uint32_t struct_size;
  /* The place of the picture's first pixel in the image, in addition to its place in the attachments (coppice_camera.x_px and y_px, or
   * coppice_eye's for the second eye): -65,536 to 65,536. 0, the default, is right for the depth attachment itself. Pixels outside the
   * image hide nothing. */
  int32_t x_px, y_px;
  uint32_t reserved; /* 0 */
  /* 2D, depth aspect; SHADER_READ_ONLY_OPTIMAL, its writes visible to COMPUTE_SHADER / SHADER_SAMPLED_READ. It must live until the GPU has
   * finished the frame */
  VkImageView image;
  VkImageView second_image; /* the second eye's image; null, the default: `image` holds both eyes */
} coppice_occluder;
static inline void coppice_occluder_init(coppice_occluder* occluder) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_OCCLUDER, occluder, sizeof *occluder);
}

/* The light that COPPICE_CONTENT_LIT is shaded with. COPPICE_CONTENT_LIGHT depends on sun_direction and the shadow maps; no other content
 * depends on the light. */
typedef struct coppice_light {
  uint32_t struct_size;
  float sun_direction[3]; /* unit, towards the sun, world space; default 0 1 0 */
  /* Colours are linear, 0 to 1e9. There is no division by pi: a white surface that faces the sun gets sun_color and its share of sky and
   * ground. */
  float sun_color[3];    /* default 3 3 3 */
  float sky_color[3];    /* ambient from above; default 0.6 */
  float ground_color[3]; /* ambient from below; default 0.2 */
  float fog_color[3];    /* default 0 */
  float fog_density;     /* 1/m, 0 to 1e6; 0, the default: none. transmittance = exp(-(fog_density * distance)^2) */
  /* Shadow maps; 0, the default, puts everything in the sun. The first map that contains a place decides. A plant looks up the point where
   * the sun's ray enters its bounding sphere, so the maps give the shadows of other plants, terrain and buildings. A crown shades itself
   * without a map. An image must live until the GPU has finished the frame. */
  const coppice_shadow_map* shadow_maps; /* [shadow_map_count], read within the call */
  uint32_t shadow_map_count;             /* at most COPPICE_MAX_SHADOW_MAPS */
  /* distance between maps: sizeof(coppice_shadow_map) as the program was compiled with. coppice_light_init sets it */
  uint32_t shadow_map_bytes;
  const coppice_occluder* occluder; /* read within the call; null, the default: only plants hide plants */
} coppice_light;
static inline void coppice_light_init(coppice_light* light) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_LIGHT, light, sizeof *light);
  if (light) light->shadow_map_bytes = sizeof(coppice_shadow_map);
}

/* Records the culling and cut selection of a view for every instance. Call it outside a render pass, into any command buffer of the frame
 * that is submitted after the upload's. If memory is short for the compute rasteriser's picture or the images of the light, the frame goes
 * on without them and the log says so once. What has no pipeline yet is left out (coppice_pipelines_ready).
 * light: null stands for a default one; views of COPPICE_OUTPUT_DEPTH need none
 * before: coppice_record_upload in the same frame, which began with a camera of the view
 * after: draw commands are visible to DRAW_INDIRECT and the vertex stage (the barrier is recorded here)
 * queue: graphics, or see queue_families. thread: culls and draws of different views may be recorded at the same time
 * errors: COPPICE_ERROR_INVALID_ARGUMENT; COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_record_cull(coppice_context* context, VkCommandBuffer cmd, coppice_view view,
                                               const coppice_light* light);

/* Records the draws of a view, as one of its eyes sees it. Call it inside dynamic rendering with the formats of the view's desc, or inside
 * the subpass of its render_pass. It sets viewport and scissor, binds pipelines and descriptor sets (the engine must rebind its own), and
 * records no barrier.
 * eye: 0, or 1 if the camera has a second_eye; each may have its own attachments, or a rectangle of the same
 * before: coppice_record_cull of the view in the same frame, submitted before; culls and draws of other views may stand between
 * queue: graphics. thread: as coppice_record_cull */
COPPICE_API coppice_status coppice_record_draw(coppice_context* context, VkCommandBuffer cmd, coppice_view view, uint32_t eye);

/* ---- ray tracing ----------------------------------------------------------------------------------------------------------------- */

/* Asks for a plant's triangles as an acceleration structure takes them: positions alone. Holes of textures and opacity are left out. */
typedef struct coppice_triangles {
  uint32_t struct_size;
  /* The cut, as coppice_draw.leaf_count, at most the leaves that are resident; up to 64 leaves the next larger cut that the plant has
   * ready. 0: the leaf meshes instead, if all are resident, else no leaves. */
  float leaf_count;
  uint32_t wood_lod; /* as coppice_draw.wood_lod, or the next coarser that is resident; COPPICE_NONE, the default: no wood */
  uint32_t triangle_capacity;
  VkDeviceAddress positions; /* a multiple of 4: float[triangle_capacity][3][3], object space at rest, m */
  uint32_t triangle_count;   /* out: the triangles of the plant, written or not */
} coppice_triangles;
static inline void coppice_triangles_init(coppice_triangles* triangles) {
  coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_TRIANGLES, triangles, sizeof *triangles);
}

/* Records the writing of a plant's triangles, leaves first, for vkCmdBuildAccelerationStructuresKHR: VK_FORMAT_R32G32B32_SFLOAT, a stride
 * of 12 bytes, no indices. If triangle_capacity is too small nothing is recorded, and the count says what is needed. The count is 0 until
 * something of the plant is resident and the pipeline, which the first call asks for, is built. The same cut has the same bytes.
 * before: coppice_record_upload in the same frame; outside a render pass. The buffer has VK_BUFFER_USAGE_STORAGE_BUFFER_BIT
 * after: the positions are written by COMPUTE_SHADER / SHADER_STORAGE_WRITE; the engine's barrier follows
 * cost: the GPU reads each node of the cut's pages some times; call it when a cut changes
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_record_triangles(coppice_context* context, VkCommandBuffer cmd, coppice_plant plant,
                                                    coppice_triangles* triangles);

#ifdef __cplusplus
}
#endif

#endif
