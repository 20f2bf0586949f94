#ifndef COPPICE_CONTEXT_H
#define COPPICE_CONTEXT_H

/* The context, plants, and their instances. coppice.h says what holds for all. */

#include <coppice/hooks.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- context -------------------------------------------------------------------------------------------------------------------- */

typedef struct coppice_context_desc {
  uint32_t struct_size;
  /* These are upper limits; nothing is sized by them, and they need not be set. Buffers and tables grow as instances are added and plants
   * are opened, by half if the budget allows, and shrink only with the context. An instance takes about 200 bytes, and 60 more to be drawn.
   * A plant takes 3.5 KB on the GPU beside the memory that its file needs. While a buffer grows, the old one counts too, until the GPU is
   * done with it. A device with smaller limits holds fewer instances: maxComputeWorkGroupCount[0] * 32, and maxTexelBufferElements / 4 if
   * that limit is 134,217,728 or more. */
  uint32_t max_instances; /* default 16,777,216; 1 to 268,435,455 */
  uint32_t max_plants;    /* default and maximum 65,536; at least 1 */
  /* COPPICE_TRUE lets a scene's plants be anywhere. Set it only for scenes that you trust: a stranger's scene may name any file. Default
   * COPPICE_FALSE. */
  uint32_t allow_outside;

  /* Counts GPU buffers and images, staging, decoded pages and tables; coppice_allocator says what is not counted. Default 256 MiB. If it is
   * below what the context takes before any plant, the context is not created and the log names the minimum. */
  uint64_t memory_budget_bytes;

  /* Null, the default, stands for malloc, a small thread pool, io_uring (or pread on that pool if the kernel has none), no log and no
   * trace. */
  const coppice_allocator* allocator;
  const coppice_jobs* jobs;
  const coppice_io* io;
  const coppice_log* log;
  const coppice_trace* trace;

  /* The folder that holds the plants a scene names, directly or below it. Copied. Null, the default, is the folder of the scene. A plant
   * outside it is left out like one that cannot be opened. The default io hook follows symbolic links before this check. With an io hook of
   * your own only the text of the path is checked, and the hook must check links. */
  const char* asset_root;

  /* CPU time per frame, ms, > 0, that coppice_frame_begin and coppice_record_upload together spend on taking over finished reads and
   * decodes and on copying them for the GPU. Each frame takes over at least one chunk, copies at least 128 KiB of one, and handles
   * everything without which a plant cannot be drawn. The rest waits for the next frame. Default 1; infinite means no limit. */
  float streaming_ms;
  /* While the camera moves steadily, its demand this many frames ahead is streamed too. 0 to 1000; 0 streams only the present demand.
   * Default 20, about the duration of a read and a decode when many wait. */
  float prefetch_frames;

  /* Only coppice_context_create reads it. COPPICE_TRUE: the host reads BC1 and BC3 blocks, so textures arrive as they are in the file.
   * Default COPPICE_FALSE: jobs decode them to RGBA8, which takes four to eight times the memory. */
  uint32_t block_textures;
  uint32_t reserved; /* 0 */
} coppice_context_desc;
static inline void coppice_context_desc_init(coppice_context_desc* desc) {
  coppice_struct_init(COPPICE_STRUCT_CONTEXT_DESC, desc, sizeof *desc);
}

/* Creates a context for a host that draws by itself what Coppice streams and selects. coppice_vulkan_context_create makes one with our
 * renderer.
 * context: out, null on errors
 * thread: any. cost: a thread pool and a few megabytes
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: a bad field, an incomplete hook, or a memory budget below what the context takes;
 * COPPICE_ERROR_OUT_OF_MEMORY */
COPPICE_API coppice_status coppice_context_create(const coppice_context_desc* desc, coppice_context** context);

/* Destroys a context; null is allowed.
 * before: the GPU has finished every command buffer that Coppice recorded into, and no other call is running
 * after: all handles are gone, and all memory of the hooks is freed. cost: waits for running jobs and reads */
COPPICE_API void coppice_context_destroy(coppice_context* context);

/* Changes the memory budget. A larger one is never worse: what it shows holds what a smaller one shows.
 * after: a smaller budget is reached within some frames: chunks are evicted, lists become shorter, views' pictures are given back. Until
 * then coppice_stats.memory_bytes is above it
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: the budget is below what the present plants, instances and views take at least; the log names the
 * least budget */
COPPICE_API coppice_status coppice_set_memory_budget(coppice_context* context, uint64_t bytes);

/* Gives memory back once, for a system that runs short of it. The budget stays as it is.
 * after: as with coppice_set_memory_budget, until coppice_stats.memory_bytes is at most target_bytes, or for 120 frames; then memory grows
 * again as views ask for it. A program that draws no frames meanwhile calls coppice_frame_begin without cameras
 * errors: as coppice_set_memory_budget */
COPPICE_API coppice_status coppice_trim(coppice_context* context, uint64_t target_bytes);

/* Requests again what could not be loaded: chunks of open plants, unreadable or damaged, and tiles of scenes. Call it when a drive or a
 * connection is back. Without it, what could not be read is tried again after 5, 10, 20 and 40 seconds, and then once a minute, with one
 * read each time; what is damaged is not. Plants that could not be opened are not tried again: open them again.
 * after: from the next coppice_frame_begin on it is in demand like everything else; if it fails again, the log says so again */
COPPICE_API coppice_status coppice_retry_failed(coppice_context* context);

/* ---- plants --------------------------------------------------------------------------------------------------------------------- */

typedef enum coppice_plant_state {
  COPPICE_PLANT_READY = 0,
  COPPICE_PLANT_OPENING = 1, /* coppice_plant_open_async is at work */
  COPPICE_PLANT_FAILED = 2,  /* the plant could not be opened: close it */
  COPPICE_PLANT_STATE_MAX_ENUM = 0x7fffffff
} coppice_plant_state;

typedef struct coppice_plant_info {
  uint32_t struct_size;
  coppice_plant_state state; /* until the plant is ready, all fields but failure and reloading are 0 */
  coppice_status failure;    /* the error of coppice_plant_open, if the state is COPPICE_PLANT_FAILED */
  uint32_t reloading;        /* COPPICE_TRUE until the file that coppice_plant_reload read is shown */
  uint32_t leaf_count;
  uint32_t resident_leaf_count; /* the finest cut that can be drawn now */
  uint32_t page_count;
  uint32_t resident_page_count;
  uint32_t wood_lod_count;
  uint32_t wood_triangle_count; /* triangles of the finest wood LoD */
  float sphere_center[3];
  float sphere_radius;
  uint64_t file_bytes;
  char name[64];
  /* object space, m; holds the leaves and the coarsest wood. Finer wood may reach a little further */
  float box_min[3], box_max[3];
} coppice_plant_info;

/* Opens a .coppice file: reads its front and validates it. Finer detail is streamed in later. A file that is open already, for example by a
 * scene, is opened a second time and takes memory a second time.
 * plant: out, 0 on errors
 * cost: waits for two reads, the header and the front, and for their retries (see coppice_io). Call it while loading, or call
 * coppice_plant_open_async
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_IO, COPPICE_ERROR_BAD_FILE, COPPICE_ERROR_DEVICE_LOST; COPPICE_ERROR_OUT_OF_MEMORY:
 * max_plants are open, or memory is short. If the log says that room is being made, try again in a few frames */
COPPICE_API coppice_status coppice_plant_open(coppice_context* context, const char* path, coppice_plant* plant);

/* Opens a plant without waiting and returns a handle at once. coppice_frame_begin continues the work: reads run in the background, a job
 * decodes the root page, and coppice_plant_info.state tells the progress. Up to eight plants are read at a time; others wait for their
 * turn. Instances may be added, moved and removed meanwhile; they are shown once the plant is ready. An error of coppice_plant_open ends in
 * COPPICE_PLANT_FAILED and a line in the log. The instances are then removed, and the handle is valid for coppice_plant_get_info and
 * coppice_plant_close only. If the memory budget is too small for the plant, opening is retried for some seconds first. coppice_plant_close
 * cancels at any time without waiting. The plant counts for max_plants until it is closed.
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_DEVICE_LOST; COPPICE_ERROR_OUT_OF_MEMORY: as coppice_plant_open */
COPPICE_API coppice_status coppice_plant_open_async(coppice_context* context, const char* path, coppice_plant* plant);

/* Opens a plant whose file is in memory already, for example in an archive of the engine. Chunks are copied from there on demand; the io
 * hook is not called.
 * bytes: [size], not copied. They must not change until the plant is closed, or until a reload from elsewhere is shown
 * (coppice_plant_info.reloading)
 * size: > 0. name: used by the log and the trace; copied
 * errors: as coppice_plant_open, without COPPICE_ERROR_IO */
COPPICE_API coppice_status coppice_plant_open_memory(coppice_context* context, const void* bytes, size_t size, const char* name,
                                                     coppice_plant* plant);

/* Removes the plant and all its instances.
 * after: its memory is freed once none of its reads and jobs is running, and the GPU or the host is done with it (see coppice_frame) */
COPPICE_API coppice_status coppice_plant_close(coppice_context* context, coppice_plant plant);

/* Reloads a plant from `path`, or from the file or memory that it was opened from if path is null. It reads the front as coppice_plant_open
 * does.
 * after: plant and instance handles stay valid. The old file is drawn until everything in demand of the new one is resident; after 120
 * frames its root page and coarsest wood are enough. Until then the plant takes memory twice. A context can run four reloads at once. A
 * further reload of the same plant replaces the one that is running
 * cost: as coppice_plant_open. errors: as coppice_plant_open, and nothing has changed; COPPICE_ERROR_INVALID_ARGUMENT also for a plant that
 * is not ready */
COPPICE_API coppice_status coppice_plant_reload(coppice_context* context, coppice_plant plant, const char* path);

/* Reloads a plant from memory. bytes, size and name are as in coppice_plant_open_memory. */
COPPICE_API coppice_status coppice_plant_reload_memory(coppice_context* context, coppice_plant plant, const void* bytes, size_t size,
                                                       const char* name);

static inline void coppice_plant_info_init(coppice_plant_info* info) {
  coppice_struct_init(COPPICE_STRUCT_PLANT_INFO, info, sizeof *info);
}
/* Describes a plant. thread: may overlap with other calls that take a const context */
COPPICE_API coppice_status coppice_plant_get_info(const coppice_context* context, coppice_plant plant, coppice_plant_info* info);

/* ---- instances ------------------------------------------------------------------------------------------------------------------ */

#define COPPICE_ALL_LAYERS 0xffffffffu

/* Says where one plant stands and how it is drawn. world = position + rotation * (scale * object). Records are passed with their size in
 * bytes, sizeof(coppice_placement) or that of a struct that begins with one. Fields that a shorter record lacks have their defaults. */
typedef struct coppice_placement {
  double position[3]; /* metres; within 3.3e7 of the context's first origin, see coppice_set_origin. Kept to within 0.03 mm */
  /* 1e-6 to 1e6, or the negative of such a number; default 1. A negative scale mirrors the plant through its origin. To exchange only left
   * and right, turn it about x as well: rotation * (1, 0, 0, 0) */
  float scale;
  float rotation[4];   /* unit quaternion x y z w, to within half a per cent; default 0 0 0 1 */
  float tint[3];       /* multiplies leaf colour, 0 to 65504, kept to 11 bits; default 1 1 1 */
  uint32_t user_data;  /* for the engine's use; default 0 */
  uint32_t layer_mask; /* drawn in views whose layer_mask shares a bit with it; default COPPICE_ALL_LAYERS */
  /* added to log2 of the error threshold, -4 to 4, kept to 11 bits; default 0. 1 is half as fine, -1 twice as fine */
  float lod_bias;
  /* Share of the leaves that is drawn, 0 to 1, for seasons and felling; default 1; 0 leaves bare wood. Leaves vanish one by one, always in
   * the same order. A coarse leaf that stands for several becomes smaller, so that far plants lose leaves as near ones do. The remaining
   * leaves let more light into the crown. */
  float leaf_share;
} coppice_placement;
/* Sets every field to its default. The plant stands at 0 0 0. */
static inline void coppice_placement_init(coppice_placement* placement) {
  const coppice_placement at_origin = {{0, 0, 0}, 1, {0, 0, 0, 1}, {1, 1, 1}, 0, COPPICE_ALL_LAYERS, 0, 1};
  if (placement) *placement = at_origin;
}

/* Adds `count` instances of a plant that is ready or being opened. All or none are added; a call that fails changes nothing else either.
 * They may come in any order: coppice_frame_begin sorts instances so that neighbours are measured and culled together.
 * placements: [count] records of `stride` bytes, which hold at least a position; they need no alignment
 * instances: [count] handles out, may be null
 * after: drawn in the next frame; our renderer draws them in this one if coppice_record_upload is still to come. cost: some 0.1 us each
 * errors: COPPICE_ERROR_INVALID_ARGUMENT; COPPICE_ERROR_OUT_OF_MEMORY: more than max_instances, or the memory budget or the hooks have no
 * memory for them. If the log says that room is being made, try again in a few frames; COPPICE_ERROR_DEVICE_LOST; COPPICE_ERROR_INTERNAL
 */
COPPICE_API coppice_status coppice_instances_add(coppice_context* context, coppice_plant plant, const coppice_placement* placements,
                                                 size_t stride, uint32_t count, coppice_instance* instances);
/* Gives instances new placements, with all fields. instances, placements: [count], as in coppice_instances_add. All or none are moved.
 * after: as coppice_instances_add. cost: copies 60 bytes for each instance and for its neighbours to the GPU */
COPPICE_API coppice_status coppice_instances_move(coppice_context* context, const coppice_instance* instances,
                                                  const coppice_placement* placements, size_t stride, uint32_t count);
/* Removes instances. instances: [count]; all or none are removed. after: not drawn from the next coppice_record_upload on */
COPPICE_API coppice_status coppice_instances_remove(coppice_context* context, const coppice_instance* instances, uint32_t count);

/* Tells whether an instance exists. instance: any value. live: out; COPPICE_FALSE if the instance has been removed or its plant has been
 * closed or has failed, if it is no handle of an instance of this context, and on errors. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_instance_is_live(const coppice_context* context, coppice_instance instance, uint32_t* live);
/* As coppice_instances_move and coppice_instances_remove, but handles that coppice_instance_is_live denies are skipped, and so are their
 * placements; the other instances are all moved or removed, or none of them. A handle that is given to the second function twice is skipped
 * once.
 * skipped: out, may be null; the number of handles that were skipped, 0 on errors */
COPPICE_API coppice_status coppice_instances_move_live(coppice_context* context, const coppice_instance* instances,
                                                       const coppice_placement* placements, size_t stride, uint32_t count,
                                                       uint32_t* skipped);
COPPICE_API coppice_status coppice_instances_remove_live(coppice_context* context, const coppice_instance* instances, uint32_t count,
                                                         uint32_t* skipped);

/* Lets instances fade in: they grow up about their feet, as tiles of scenes do, so that they do not pop in. In the n-th frame that begins
 * after the call they have n / frames of their size, in all views and in coppice_draw.scale; a frame that has begun shows them as the
 * first. Instances of a plant that is being opened begin once it is ready. A second call begins again; coppice_instances_move does not.
 * Streaming and coppice_pick count with the full size from the start.
 * instances: [count]; all or none fade in. frames: 1 to 255; tiles of scenes take 16
 * before: the frame that is to show them first; within a frame, before coppice_record_upload
 * cost: as coppice_instances_move, in this frame alone */
COPPICE_API coppice_status coppice_instances_fade_in(coppice_context* context, const coppice_instance* instances, uint32_t count,
                                                     uint32_t frames);

/* Moves the origin, for engines that move the origin of their coordinates along with the camera. From this call on, positions that are
 * passed (placements, cameras, shadow maps, maps of wind, boxes, rays) and returned (draws, hits, placements of trees) count from `origin`.
 * `origin` itself always counts from the origin that the context was created with: a position p means what p + origin meant then. The
 * engine converts positions that it has kept. Plants keep their places, and nothing is loaded again. Precision does not need this call:
 * positions are doubles, and the GPU computes relative to the eye.
 * origin: [3] m, within 3.3e7 of 0; at first 0 0 0. before: not within a frame */
COPPICE_API coppice_status coppice_set_origin(coppice_context* context, const double* origin);

#ifdef __cplusplus
}
#endif

#endif
