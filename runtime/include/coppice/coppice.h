#ifndef COPPICE_H
#define COPPICE_H

/* libcoppice streams level of detail for plants. This header needs no graphics API. It declares hooks, the context, plants, instances,
 * scenes, views, streaming and statistics. Two libraries implement it: libcoppice, for hosts that draw themselves, and libcoppice_vulkan,
 * which adds our renderer on the engine's Vulkan device (coppice/vulkan.h). A program links one of them.
 *
 * A host creates a context, and one view for each picture. It opens plants and adds instances, or it opens a scene, which does both. In
 * each frame it says what its cameras show:
 *
 *     coppice_frame_begin(context, &frame);   frame_number grows; completed_number is the last frame that the GPU has finished, for
 *                                             example the last one whose fence has signalled
 *     ...                                     with our renderer: upload, cull, draw (coppice/vulkan.h); else changes and draws (below)
 *
 * It repeats this until coppice_is_settled, or for as long as it runs. A frame lasts until the next coppice_frame_begin. Functions that
 * change plants, instances, scenes, views or the origin are called before coppice_record_upload (without a renderer: before
 * coppice_frame_begin), or after the last call of the frame that records or asks for draws.
 *
 * Units and axes: metres, right-handed, +Y up, as in glTF. Matrices are column-major, for column vectors. View space looks down -Z. Clip
 * space is Vulkan's: y points down, depth runs from 0 to 1. Booleans are uint32_t: COPPICE_FALSE or COPPICE_TRUE, no other value.
 *
 * Words:
 *   leaf, wood     a plant consists of leaves, quads that merge into larger ones, and of wood, a mesh in several levels of detail (LoDs)
 *   cut            a set of quads that together show the whole plant, with any number of leaves from all to 1, the root
 *   page           512 steps of refinement, 1,024 quads. Pages arrive in order: the resident ones are a prefix, and a complete plant
 *   leaf mesh      leaves as they were modelled; they replace quads close up
 *   chunk          the unit of reading and eviction: a page, a wood LoD, a texture, a part of the leaf meshes
 *   front          the first part of a file: tables, the coarsest wood, the first page. It is enough for a first picture
 *   threshold      the error that an instance may have in a view, px (coppice_camera.error_px)
 *   tile, species  a tile is a square of a scene with up to 2,048 plants, loaded together; a species is a plant that a scene names
 *   resident       in memory, ready to be drawn
 *   settled        everything that is in demand and fits is resident
 *   view group     views whose demand is measured together, at one threshold (coppice_frame_begin)
 *
 * Threads: distinct contexts are independent. Calls on one context are externally serialised. Functions that take a const context may
 * overlap with each other, and so may the recording of different views (coppice/vulkan.h). The comment of a hook says which threads call
 * it. A library that was built without NDEBUG, or with _GLIBCXX_ASSERTIONS, refuses calls that overlap and calls from inside a hook: it
 * returns COPPICE_ERROR_INVALID_ARGUMENT and logs a line.
 *
 * Errors: every function that can fail returns a coppice_status, also in release builds. The log hook gets one line that names the field
 * and its index: "coppice_instances_add: placements[3].position[0] is not finite". coppice_last_error returns the last such line. A call
 * that is refused changes nothing. A null context, or a null pointer where none is allowed, is COPPICE_ERROR_INVALID_ARGUMENT. No exception
 * leaves the library.
 *
 * Comments of functions state these points, in this order. A point that is missing means:
 *   before   the function may be called at any time, between frames or within one
 *   after    nothing else has changed
 *   queue    none; only functions of coppice/vulkan.h that take a command buffer have one
 *   thread   any, one call at a time on a context
 *   cost     microseconds; the call does not wait for files, jobs or the GPU
 *   errors   COPPICE_ERROR_INVALID_ARGUMENT alone
 *
 * Structs grow: later versions add fields at the end. A struct that is no element of an array starts with struct_size, its size in the
 * header that the program was compiled with. The *_init function sets it, and every other field to its default; it does nothing for a null
 * pointer. A program therefore runs with later versions of the library. It runs with earlier ones too if it leaves the fields that they do
 * not know at 0:
 *   structs that the library reads   fields that a smaller struct lacks have their defaults. A larger struct is accepted if the bytes that
 *                                    this version does not know are all 0; else COPPICE_ERROR_INVALID_ARGUMENT, and the log names the byte
 *   structs that the library fills   a smaller struct is filled as far as it goes; the rest of a larger one becomes 0
 *   structs that a hook is given     struct_size says how large it is; a program must not read further
 * Sizes are multiples of 4 from 4 to 4,096 bytes; others are COPPICE_ERROR_INVALID_ARGUMENT. Enumerations grow too: expect values that you
 * do not know. */

#include <stddef.h>
#include <stdint.h>

#define COPPICE_VERSION_MAJOR 0
#define COPPICE_VERSION_MINOR 2
#define COPPICE_VERSION_PATCH 0

/* Packs 10 bits of the major, 10 of the minor and 12 of the patch version. A larger number is a later version. */
#define COPPICE_MAKE_VERSION(major, minor, patch) ((major)*0x400000u + (minor)*0x1000u + (patch))
#define COPPICE_HEADER_VERSION COPPICE_MAKE_VERSION(COPPICE_VERSION_MAJOR, COPPICE_VERSION_MINOR, COPPICE_VERSION_PATCH)

/* Marks every function that the library exports. On Windows, programs that link the shared library define COPPICE_SHARED; the library's own
 * build also defines COPPICE_BUILDING. */
#if defined(_WIN32) && defined(COPPICE_SHARED) && defined(COPPICE_BUILDING)
#define COPPICE_API __declspec(dllexport)
#elif defined(_WIN32) && defined(COPPICE_SHARED)
#define COPPICE_API __declspec(dllimport)
#elif defined(__GNUC__)
#define COPPICE_API __attribute__((visibility("default")))
#else
#define COPPICE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define COPPICE_FALSE 0u
#define COPPICE_TRUE 1u

/* Returns COPPICE_HEADER_VERSION of the library that is linked or loaded. thread: any; also before any context exists. */
COPPICE_API uint32_t coppice_version(void);

typedef enum coppice_status {
  COPPICE_OK = 0,
  COPPICE_ERROR_INVALID_ARGUMENT = 1, /* a null pointer, a bad handle or a value out of range */
  COPPICE_ERROR_IO = 2,               /* a file could not be read */
  COPPICE_ERROR_BAD_FILE = 3,         /* not a .coppice or .forest file, damaged, or of another version */
  COPPICE_ERROR_UNSUPPORTED = 4,      /* the device lacks something required; the log names it */
  COPPICE_ERROR_OUT_OF_MEMORY = 5,
  COPPICE_ERROR_DEVICE_LOST = 6,
  COPPICE_ERROR_INTERNAL = 7,
  COPPICE_STATUS_MAX_ENUM = 0x7fffffff
} coppice_status;

/* Returns a short English sentence in static storage, never null. */
COPPICE_API const char* coppice_status_text(coppice_status status);

typedef struct coppice_context coppice_context;

/* Returns the line of the context's last call that failed, on any thread: "coppice_plant_open: oak.coppice: No such file or directory".
 * Calls that succeed do not change it. It is empty if none has failed. If context is null it returns the line of the calling thread's last
 * failed call without a context, for example one that creates a context. The text is never null, UTF-8, at most 1,023 bytes and without
 * control characters. It is valid until the thread calls this function again. Failures in the background go to the log only. thread: any,
 * at any time while the context exists. */
COPPICE_API const char* coppice_last_error(const coppice_context* context);

/* Names the structs of this header for coppice_struct_init. */
typedef enum coppice_struct {
  COPPICE_STRUCT_CONTEXT_DESC = 0,
  COPPICE_STRUCT_ALLOCATOR = 1,
  COPPICE_STRUCT_JOBS = 2,
  COPPICE_STRUCT_IO = 3,
  COPPICE_STRUCT_LOG = 4,
  COPPICE_STRUCT_TRACE = 5,
  COPPICE_STRUCT_PLANT_INFO = 6,
  COPPICE_STRUCT_SCENE_INFO = 7,
  COPPICE_STRUCT_SCENE_PLANT_INFO = 8,
  COPPICE_STRUCT_STATS = 9,
  COPPICE_STRUCT_VIEW_DESC = 10,
  COPPICE_STRUCT_CAMERA = 11,
  COPPICE_STRUCT_SUN_DESC = 12,
  COPPICE_STRUCT_FRAME = 13,
  COPPICE_STRUCT_VIEW_STATS = 14,
  COPPICE_STRUCT_SCENE_PLACEMENT = 15,
  COPPICE_STRUCT_CHANGE = 16,
  COPPICE_STRUCT_FILE_INFO = 17,
  COPPICE_STRUCT_MATERIAL = 18,
  COPPICE_STRUCT_CARD = 19,
  COPPICE_STRUCT_LEAF_LAYOUT = 20,
  COPPICE_STRUCT_LEAF_OUTPUT = 21,
  COPPICE_STRUCT_EYE = 22,
  COPPICE_STRUCT_TREE_INFO = 23,
  COPPICE_STRUCT_RAY = 24,
  COPPICE_STRUCT_HIT = 25,
  COPPICE_STRUCT_WIND = 26,
  COPPICE_STRUCT_GUSTS = 27,
  COPPICE_STRUCT_MAX_ENUM = 0x7fffffff
} coppice_struct;
/* Fills a struct of `bytes` bytes with the defaults of its kind, as far as it goes. Bytes that the library does not know become 0.
 * struct_size becomes `bytes`. The *_init functions call it with the size that their program was compiled with: call those, unless you bind
 * the library to another language. It does nothing if data is null or bytes is below 4. thread: any. */
COPPICE_API void coppice_struct_init(coppice_struct kind, void* data, size_t bytes);

/* A handle has 64 bits, from the highest: 3 of kind (1 plant, 2 instance, 3 scene, 4 view), 12 of context, 21 of generation, 28 of index. A
 * handle of another kind, of another context or of an object that is gone is therefore refused with COPPICE_ERROR_INVALID_ARGUMENT. Two
 * contexts are told apart unless 4,095 others are created in between; the generations of a slot repeat after two million uses. 0 is never a
 * handle. Conclude nothing else from the bits. */
typedef uint64_t coppice_plant;
typedef uint64_t coppice_instance;
typedef uint64_t coppice_scene;
typedef uint64_t coppice_view;

/* ---- hooks ---------------------------------------------------------------------------------------------------------------------- */

/* A hook is a struct of functions that coppice_context_desc points at. The struct is copied when the context is created. `user`, and
 * everything that the functions need, must outlive the context. A struct whose functions are all null counts as not given. */

/* Allocates host memory. allocate returns memory aligned to `align` (a power of two), or null, which makes the operation fail with
 * COPPICE_ERROR_OUT_OF_MEMORY. Neither function may call back into Coppice.
 *   by the hook      everything that grows with plants, pages, instances and scenes: chunks as read and as decoded, instances, the
 *                    streamer's tables, a plant's front and path, a scene's tiles and species. The memory budget counts it, but for the
 *                    renderer's notes about a plant beside its tables
 *   not by the hook  and not counted: Draco's output while a job decodes a chunk, error texts, the context itself. The chunk's counts bound
 *                    Draco's output; if malloc fails there, the chunk fails with COPPICE_ERROR_OUT_OF_MEMORY
 * thread: any that runs a job or calls the context. */
typedef struct coppice_allocator {
  uint32_t struct_size;
  void* user;
  void* (*allocate)(void* user, size_t bytes, size_t align);
  void (*free)(void* user, void* pointer, size_t bytes);
} coppice_allocator;
static inline void coppice_allocator_init(coppice_allocator* hook) {
  coppice_struct_init(COPPICE_STRUCT_ALLOCATOR, hook, sizeof *hook);
}

/* Runs decoding and the building of pipelines. submit may run `function(argument)` on any thread, or inline before it returns, which makes
 * tests deterministic. Every submitted function must run: coppice_context_destroy waits for them. submit must not call back into Coppice
 * except through `function`. thread: the one inside the function that creates a context, coppice_frame_begin, coppice_record_upload or
 * coppice_record_cull. */
typedef struct coppice_jobs {
  uint32_t struct_size;
  void* user;
  void (*submit)(void* user, void (*function)(void* argument), void* argument);
} coppice_jobs;
static inline void coppice_jobs_init(coppice_jobs* hook) {
  coppice_struct_init(COPPICE_STRUCT_JOBS, hook, sizeof *hook);
}

/* Gives access to files.
 *   open   returns a handle >= 0, or a failure: -errno, which the log spells out, or -1 if the reason is unknown. It returns -EINVAL for
 *          anything but a regular file
 *   read   must not block. It calls done(argument, bytes_read) once, from any thread, or inline. Fewer bytes than `bytes`, or a failure as
 *          of open, is retried after 50, 200 and 800 ms while frames go on; then the chunk, or the opening, has failed. `destination`
 *          stays valid until done is called. coppice_plant_open and coppice_scene_open wait for their reads, so done must not depend on
 *          the calling thread
 *   close  is called once the plant or scene is closed and none of its reads is in flight
 * thread: the one inside coppice_plant_open, coppice_plant_reload, coppice_plant_close, coppice_scene_open, coppice_scene_close,
 * coppice_frame_begin or coppice_context_destroy. */
typedef struct coppice_io {
  uint32_t struct_size;
  void* user;
  int64_t (*open)(void* user, const char* path, uint64_t* file_bytes); /* file_bytes: out, the file's size */
  void (*close)(void* user, int64_t file);
  void (*read)(void* user, int64_t file, uint64_t offset, void* destination, size_t bytes, void (*done)(void* argument, int64_t bytes_read),
               void* argument);
} coppice_io;
static inline void coppice_io_init(coppice_io* hook) {
  coppice_struct_init(COPPICE_STRUCT_IO, hook, sizeof *hook);
}

typedef enum coppice_log_level {
  COPPICE_LOG_INFO = 0,
  COPPICE_LOG_WARNING = 1,
  COPPICE_LOG_ERROR = 2,
  COPPICE_LOG_LEVEL_MAX_ENUM = 0x7fffffff
} coppice_log_level;

/* Takes one line without a newline or any other control character; the text is valid during the call. Each failure is one line, which names
 * the file, the field or chunk, its byte and the system's reason as far as they are known. thread: any. */
typedef struct coppice_log {
  uint32_t struct_size;
  void* user;
  void (*write)(void* user, coppice_log_level level, const char* line);
} coppice_log;
static inline void coppice_log_init(coppice_log* hook) {
  coppice_struct_init(COPPICE_STRUCT_LOG, hook, sizeof *hook);
}

typedef enum coppice_trace_kind {
  COPPICE_TRACE_READ = 0,        /* a chunk, from the request to the bytes; several overlap on one thread */
  COPPICE_TRACE_DECODE = 1,      /* a chunk, on a job's thread */
  COPPICE_TRACE_UPLOAD = 2,      /* a chunk, within COPPICE_TRACE_RECORD_UPLOAD */
  COPPICE_TRACE_FRAME_BEGIN = 3, /* coppice_frame_begin; the names of the next three are their functions */
  COPPICE_TRACE_RECORD_UPLOAD = 4,
  COPPICE_TRACE_RECORD_CULL = 5,
  COPPICE_TRACE_RECORD_DRAW = 6,
  COPPICE_TRACE_KIND_MAX_ENUM = 0x7fffffff
} coppice_trace_kind;

/* The library sets struct_size. */
typedef struct coppice_trace_span {
  uint32_t struct_size;
  coppice_trace_kind kind;
  const char* path;  /* the plant's file; null if the span is about no chunk */
  const char* chunk; /* page, wood, texture or leaf mesh; null if the span is about no chunk */
  uint32_t index;    /* the chunk's index among those of its kind */
  uint64_t bytes;    /* bytes in the file; for an upload, bytes for the GPU */
  uint64_t start_ns; /* CLOCK_MONOTONIC */
  uint64_t end_ns;
} coppice_trace_span;

/* Receives a span whenever the library has finished a piece of work that takes time. `span` and its strings are valid during the call. The
 * function must not call back into Coppice. Without this hook no clock is read for spans. thread: the one that finished the work. */
typedef struct coppice_trace {
  uint32_t struct_size;
  void* user;
  void (*span)(void* user, const coppice_trace_span* span);
} coppice_trace;
static inline void coppice_trace_init(coppice_trace* hook) {
  coppice_struct_init(COPPICE_STRUCT_TRACE, hook, sizeof *hook);
}

/* ---- context -------------------------------------------------------------------------------------------------------------------- */

typedef struct coppice_context_desc {
  uint32_t struct_size;
  /* These are upper limits; nothing is sized by them, and they need not be set. Buffers and tables grow as instances are added and plants
   * are opened, by half if the budget allows, and shrink only with the context. An instance takes about 190 bytes, and 60 more to be drawn.
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
   * decodes and on copying them for the GPU. Each frame takes over at least one chunk, copies at least one, and handles everything without
   * which a plant cannot be drawn. The rest waits for the next frame. Default 1; infinite means no limit. */
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

/* Changes the memory budget.
 * after: the next coppice_frame_begin evicts what no longer fits
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: the budget is below what the context took before any plant */
COPPICE_API coppice_status coppice_set_memory_budget(coppice_context* context, uint64_t bytes);

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

/* Adds `count` instances of a plant that is ready or being opened. All or none are added; a call that fails changes nothing else either. A
 * block of 32 slots is culled together: add neighbours together.
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

/* Moves the origin, for engines that move the origin of their coordinates along with the camera. From this call on, positions that are
 * passed (placements, cameras, shadow maps, maps of wind, boxes, rays) and returned (draws, hits, placements of trees) count from `origin`.
 * `origin` itself always counts from the origin that the context was created with: a position p means what p + origin meant then. The
 * engine converts positions that it has kept. Plants keep their places, and nothing is loaded again. Precision does not need this call:
 * positions are doubles, and the GPU computes relative to the eye.
 * origin: [3] m, within 3.3e7 of 0; at first 0 0 0. before: not within a frame */
COPPICE_API coppice_status coppice_set_origin(coppice_context* context, const double* origin);

/* ---- scenes ---------------------------------------------------------------------------------------------------------------------- */

typedef struct coppice_scene_info {
  uint32_t struct_size;
  uint32_t species_count;
  uint32_t tile_count;
  float square_side;   /* side of the square that the plants stand in, metres */
  float square_min[2]; /* corner of the square: x and z, in the scene's own space */
  uint64_t instance_count;
  uint64_t file_bytes;
  float height_min; /* height range of the plants' feet; both are the same if the ground is flat */
  float height_max;
} coppice_scene_info;

/* Says where a scene stands: world = position + rotation * scene. */
typedef struct coppice_scene_placement {
  uint32_t struct_size;
  float rotation[4];  /* unit quaternion x y z w, to within half a per cent; default 0 0 0 1 */
  double position[3]; /* metres, as in coppice_placement; default 0 0 0 */
} coppice_scene_placement;
static inline void coppice_scene_placement_init(coppice_scene_placement* placement) {
  coppice_struct_init(COPPICE_STRUCT_SCENE_PLACEMENT, placement, sizeof *placement);
}

#define COPPICE_MAX_SCENES 64u

/* Opens a .forest file, which `coppice scene` makes: reads and checks its front. From then on coppice_frame_begin streams the scene.
 * A tile is loaded while its largest plant, at the tile's nearest point, is at least 1 px high in one of the frame's views; views of
 * COPPICE_OUTPUT_DEPTH do not count. If the tiles in demand do not fit into max_instances, or into a quarter of the memory budget, that
 * limit of 1 px rises for all tiles alike. Plants are opened, without waiting for their reads, when the first tile with them arrives; they
 * count for max_plants. A plant that cannot be opened, or is not where coppice_context_desc.asset_root allows, is left out, logged once and
 * counted in scene_species_failed. Placing tiles and opening plants takes about streaming_ms a frame, but at least one of each. Scenes
 * share the limits of a context; each gets at least its part of a quarter of the memory budget. The engine's own plants and instances may
 * stand beside them.
 * A settled picture does not change, but another run may show other cuts where two are equally good: that depends on an instance's slot,
 * and slots depend on the order in which tiles arrive. If jobs and reads run inside the hooks' calls, slots are the same each time.
 * placement: may be null: default. scene: out, 0 on errors
 * after: nothing is loaded yet; coppice_is_settled says when everything in demand is
 * cost: waits for two reads and their retries (see coppice_io): call it while loading
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_IO, COPPICE_ERROR_BAD_FILE, COPPICE_ERROR_DEVICE_LOST; COPPICE_ERROR_OUT_OF_MEMORY,
 * also if COPPICE_MAX_SCENES are open */
COPPICE_API coppice_status coppice_scene_open(coppice_context* context, const char* path, const coppice_scene_placement* placement,
                                              coppice_scene* scene);

/* Moves a scene with everything that is resident of it; nothing is loaded again. If a scene moves in each frame, rounding moves its plants
 * by 0.03 mm against each other each time.
 * after: as coppice_instances_add. cost: as moving its instances */
COPPICE_API coppice_status coppice_scene_move(coppice_context* context, coppice_scene scene, const coppice_scene_placement* placement);

/* Closes a scene.
 * after: its instances are removed, its plants closed, and the changes of coppice_scene_hide and coppice_scene_replace are forgotten
 * cost: waits for reads of tiles that are running */
COPPICE_API coppice_status coppice_scene_close(coppice_context* context, coppice_scene scene);

static inline void coppice_scene_info_init(coppice_scene_info* info) {
  coppice_struct_init(COPPICE_STRUCT_SCENE_INFO, info, sizeof *info);
}
/* Describes a scene. thread: may overlap with other calls that take a const context */
COPPICE_API coppice_status coppice_scene_get_info(const coppice_context* context, coppice_scene scene, coppice_scene_info* info);

/* Describes a plant that a scene names. */
typedef struct coppice_scene_plant_info {
  uint32_t struct_size;
  const char* path; /* the path that it is opened by; valid while the scene is open */
  /* 0 while it is not open, because no tile has needed it yet or because it failed. It may be reloaded; the scene closes it */
  coppice_plant plant;
} coppice_scene_plant_info;
static inline void coppice_scene_plant_info_init(coppice_scene_plant_info* info) {
  coppice_struct_init(COPPICE_STRUCT_SCENE_PLANT_INFO, info, sizeof *info);
}
/* Describes the scene's plant number `species`, < coppice_scene_info.species_count. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_scene_get_plant(const coppice_context* context, coppice_scene scene, uint32_t species,
                                                   coppice_scene_plant_info* info);

/* Names a tree: a plant that a scene's file places. The name is valid as long as the file does not change, whether the tile is loaded or
 * not; a saved game may keep tile and number. All 0 means none. */
typedef struct coppice_scene_tree {
  coppice_scene scene;
  uint32_t tile;   /* < coppice_scene_info.tile_count */
  uint32_t number; /* its number in the tile */
} coppice_scene_tree;

/* Hides trees, for example felled ones: they are neither drawn nor picked, and nothing is streamed for them alone. A tree that was replaced
 * is hidden too. Trees may be of several scenes, and may be hidden already.
 * trees: [count]; all or none are hidden
 * before: any time; their tiles need not be loaded
 * after: as coppice_instances_remove; until coppice_scene_restore, or until the scene closes
 * cost: some 0.1 us each, and a walk over all changed trees of the scene: pass many at once
 * errors: COPPICE_ERROR_INVALID_ARGUMENT; COPPICE_ERROR_OUT_OF_MEMORY: a change takes about 180 bytes a tree */
COPPICE_API coppice_status coppice_scene_hide(coppice_context* context, const coppice_scene_tree* trees, uint32_t count);

/* Shows a plant in place of trees: a stump, a burnt tree, the same tree with fewer leaves. Hidden trees are replaced too. The plant is
 * shown while the tile is loaded; tiles are still chosen by what the file holds. It moves with its scene from then on. Closing the plant
 * hides it.
 * trees: [count]; all or none are replaced. plant: open or being opened; 0 means each tree's own
 * placements: [count] records of `stride` bytes, world space, as in coppice_instances_add
 * before, cost, errors: as coppice_scene_hide. after: as coppice_scene_hide; drawn as after coppice_instances_add */
COPPICE_API coppice_status coppice_scene_replace(coppice_context* context, const coppice_scene_tree* trees, coppice_plant plant,
                                                 const coppice_placement* placements, size_t stride, uint32_t count);

/* Shows trees as the file has them again, whether they were hidden or replaced or both. trees: [count]; unchanged trees stay unchanged.
 * before, after: as coppice_scene_replace. cost: as coppice_scene_hide */
COPPICE_API coppice_status coppice_scene_restore(coppice_context* context, const coppice_scene_tree* trees, uint32_t count);

/* Lists the trees in a box, hidden ones too: those whose shown position is in the box and whose tile is loaded.
 * box_min, box_max: [3] world space, m; may be infinite. trees: [capacity], may be null if capacity is 0
 * count: out, the number of trees in the box; those beyond capacity are left out
 * missing_tiles: out, may be null; the number of tiles that may hold more but are not loaded. In a settled view only damaged tiles are
 * missing
 * thread: as coppice_scene_get_info. cost: a look at the scene's tiles, and at the trees of those that the box meets */
COPPICE_API coppice_status coppice_scene_query(const coppice_context* context, coppice_scene scene, const double* box_min,
                                               const double* box_max, coppice_scene_tree* trees, uint32_t capacity, uint32_t* count,
                                               uint32_t* missing_tiles);

typedef enum coppice_tree_state {
  COPPICE_TREE_AS_IN_FILE = 0,
  COPPICE_TREE_HIDDEN = 1,
  COPPICE_TREE_REPLACED = 2,
  COPPICE_TREE_STATE_MAX_ENUM = 0x7fffffff
} coppice_tree_state;

typedef struct coppice_tree_info {
  uint32_t struct_size;
  coppice_tree_state state;
  /* COPPICE_TRUE: its tile is loaded. All fields below are 0 if it is not, or if its plant cannot be opened */
  uint32_t resident;
  uint32_t reserved[9]; /* 0 */
  coppice_plant plant;  /* the plant that it shows, or would show if it were not hidden */
  /* likewise. To make the tree the engine's own, pass this to coppice_instances_add and hide the tree */
  coppice_placement placement;
} coppice_tree_info;
static inline void coppice_tree_info_init(coppice_tree_info* info) {
  coppice_struct_init(COPPICE_STRUCT_TREE_INFO, info, sizeof *info);
}
/* Describes a tree. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_scene_get_tree(const coppice_context* context, const coppice_scene_tree* tree, coppice_tree_info* info);

/* ---- picking --------------------------------------------------------------------------------------------------------------------- */

typedef struct coppice_ray {
  uint32_t struct_size;
  uint32_t layer_mask;  /* instances whose layer_mask shares a bit with it are hit; default COPPICE_ALL_LAYERS */
  double origin[3];     /* world space, m, within 1e10 of 0 */
  float direction[3];   /* unit, to within half a per cent; default 0 0 -1 */
  float max_distance_m; /* > 0, may be infinite; default infinite */
  uint32_t boxes;       /* COPPICE_TRUE hits plants' boxes. COPPICE_FALSE, the default, hits wood and crowns */
  uint32_t reserved;    /* 0 */
} coppice_ray;
static inline void coppice_ray_init(coppice_ray* ray) {
  coppice_struct_init(COPPICE_STRUCT_RAY, ray, sizeof *ray);
}

typedef enum coppice_hit_kind {
  COPPICE_HIT_NOTHING = 0,
  COPPICE_HIT_BOX = 1,
  COPPICE_HIT_WOOD = 2,
  COPPICE_HIT_CROWN = 3,
  COPPICE_HIT_KIND_MAX_ENUM = 0x7fffffff
} coppice_hit_kind;

typedef struct coppice_hit {
  uint32_t struct_size;
  coppice_hit_kind kind; /* if nothing was hit, all other fields are 0 */
  coppice_plant plant;
  coppice_instance instance; /* 0 if a scene placed it */
  coppice_scene_tree tree;   /* the tree that was hit; 0 if the engine placed it */
  double position[3];        /* world space, m */
  float distance_m;          /* along the ray */
  uint32_t user_data;        /* the one of its placement */
} coppice_hit;
static inline void coppice_hit_init(coppice_hit* hit) {
  coppice_struct_init(COPPICE_STRUCT_HIT, hit, sizeof *hit);
}

/* Finds the nearest plant that a ray hits. Wood is tested as its coarsest LoD, some tens to hundreds of triangles. A crown is tested as a
 * coarse cut of at most 512 leaves without holes, about as large as the crown, so a ray does not pass between its leaves. A plant without
 * leaves (coppice_placement.leaf_share 0) has no crown. Plants are hit at rest, whatever the wind.
 * before: any time. Hidden and removed plants are never hit. Plants added or moved since the last coppice_frame_begin may be missed, and
 * tiles that are not loaded are
 * thread: as coppice_scene_get_info
 * cost: some 20 ns for each instance that the ray passes near, and some 10 us for each plant whose box it enters on its way to the first
 * hit */
COPPICE_API coppice_status coppice_pick(const coppice_context* context, const coppice_ray* ray, coppice_hit* hit);

/* ---- views ----------------------------------------------------------------------------------------------------------------------- */

/* A view is something that plants are drawn to: a camera's picture, a shadow map, a mirror. It keeps the results of culling, the picture of
 * the compute rasteriser, and history of earlier frames. A frame begins with all the views that it will draw. */
typedef enum coppice_output {
  COPPICE_OUTPUT_LIT = 0, /* colour, lit by coppice_light, and depth */
  /* only depth: a shadow map. Leaves are quads, and plants out of view have no demand */
  COPPICE_OUTPUT_DEPTH = 1,
  COPPICE_OUTPUT_SURFACE = 2, /* what the engine needs to light plants itself, and depth: coppice_content of coppice/vulkan.h */
  COPPICE_OUTPUT_MAX_ENUM = 0x7fffffff
} coppice_output;

typedef struct coppice_view_desc {
  uint32_t struct_size;
  coppice_output output; /* default COPPICE_OUTPUT_LIT */
} coppice_view_desc;
static inline void coppice_view_desc_init(coppice_view_desc* desc) {
  coppice_struct_init(COPPICE_STRUCT_VIEW_DESC, desc, sizeof *desc);
}

/* Creates a view of a context from coppice_context_create. coppice_vulkan_view_create makes views of other contexts.
 * view: out, 0 on errors. cost: 100 bytes for each open plant
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, also if the context has a renderer; COPPICE_ERROR_OUT_OF_MEMORY */
COPPICE_API coppice_status coppice_view_create(coppice_context* context, const coppice_view_desc* desc, coppice_view* view);

/* Destroys a view. coppice_context_destroy destroys all of them.
 * before: not within a frame that shows the view and whose commands are still to be recorded
 * after: its memory is freed once the GPU has finished the frames that drew it (see coppice_frame) */
COPPICE_API coppice_status coppice_view_destroy(coppice_context* context, coppice_view view);

/* Tells whether everything that the view's group (coppice_frame_begin) demanded in the last frame, and that fits, is resident: plants have
 * been opened, tiles of scenes are loaded (near ones grow up over 16 frames), and so are chunks. coppice_view_stats.threshold_px has also
 * come to rest then. Changes since that frame, and pipelines (coppice_pipelines_ready), do not count. COPPICE_FALSE for a view that the
 * last frame did not show.
 * settled: out; COPPICE_FALSE on errors. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_is_settled(const coppice_context* context, coppice_view view, uint32_t* settled);

/* ---- frame ---------------------------------------------------------------------------------------------------------------------- */

typedef enum coppice_lod_mode {
  COPPICE_LOD_CUT = 0, /* chosen per instance, from the error table */
  /* the reference picture: every resident leaf of every instance, or its leaf meshes if they are resident */
  COPPICE_LOD_FULL = 1,
  /* For comparison: seven cuts of a plant, each a quarter of the one before, as in an engine with discrete levels. An instance shows the
   * coarsest that error_px allows. The hardware draws it, also with compute_raster. */
  COPPICE_LOD_DISCRETE = 2,
  COPPICE_LOD_MODE_MAX_ENUM = 0x7fffffff
} coppice_lod_mode;

/* Shows what the library does by colours instead of light. Fog and textures are left out; what the engine draws is unchanged. A ramp goes
 * from blue through green to red. */
typedef enum coppice_debug_view {
  COPPICE_DEBUG_NONE = 0,
  /* leaves of an instance on a logarithmic ramp: blue is one leaf, red is all; leaf meshes are white */
  COPPICE_DEBUG_LOD = 1,
  /* drawn by compute shaders: leaves green, wood dark green; by the hardware: quads orange, leaf meshes magenta, wood blue */
  COPPICE_DEBUG_PATH = 2,
  /* how often compute shaders drew a pixel: blue once, green 5 times, red 32; grey: by the hardware, not counted */
  COPPICE_DEBUG_OVERDRAW = 3,
  /* the culling pass that drew it: blue the first, whose depth hides later ones, red the last; grey: by the hardware */
  COPPICE_DEBUG_OCCLUSION = 4,
  /* error of an instance's cut at its size, logarithmic: blue 0.5 px and less, green 4, red 32 */
  COPPICE_DEBUG_ERROR = 5,
  COPPICE_DEBUG_RESIDENCY = 6, /* leaves of the plant that are resident, logarithmic: blue all, red only one */
  COPPICE_DEBUG_VIEW_MAX_ENUM = 0x7fffffff
} coppice_debug_view;

/* Describes the second eye of a stereo pair. Its fields mean the same as those of coppice_camera, which describe the first eye. */
typedef struct coppice_eye {
  uint32_t struct_size;
  int32_t x_px;
  int32_t y_px;
  float clip_from_view[16];
  double view_from_world[16];
} coppice_eye;
static inline void coppice_eye_init(coppice_eye* eye) {
  coppice_struct_init(COPPICE_STRUCT_EYE, eye, sizeof *eye);
}

/* Says what a view shows in a frame. */
typedef struct coppice_camera {
  uint32_t struct_size;
  coppice_view view;
  /* a rotation, perhaps mirrored, and a translation of at most 1e10 m along each axis; default identity */
  double view_from_world[16];
  /* A perspective projection that looks down -z (last row 0 0 -1 0), or an orthographic one (last row 0 0 0 1), or a positive multiple of
   * either. Default identity. It may be oblique: the third row may be that of any near plane, for example a mirror's. Depth runs as
   * coppice_vulkan_view_desc.depth_compare says. Without a renderer the directions of depth and y do not matter. In an orthographic view
   * sizes do not depend on distance, and fog begins at the plane of the eye. */
  float clip_from_view[16];
  uint32_t width_px; /* 1 to the device's limit; 0, the default, is refused */
  uint32_t height_px;
  int32_t x_px; /* place of the picture's first pixel in the attachments */
  int32_t y_px;
  /* Threshold, px, > 0, at most 1e6; default 2. The error of a cut at its size on screen was measured when the plant was baked. An error of
   * e px means: all pixels of the plant together are as wrong as a square of e x e pixels that are wholly wrong. 1 is hard to tell from all
   * leaves; 2 is seen in a direct comparison; 8 is coarse, for shadows or slow devices. */
  float error_px;
  coppice_lod_mode lod;
  /* The number of leaves that the view may draw. 0, the default, draws what error_px asks for. Otherwise the threshold rises gradually
   * above error_px, for all instances alike, to 32 px at most, until the drawn leaves fit. A wood triangle counts as a leaf; a triangle
   * that the hardware draws counts as four more. The threshold follows the counts of frames that the GPU has finished. It is ignored in
   * modes other than COPPICE_LOD_CUT. */
  uint32_t leaf_budget;
  coppice_debug_view debug_view; /* default none */

  /* Coarse leaves stand for several leaves with gaps between them, so they leave out some of their pixels (stochastic transparency). 0, the
   * default, always leaves out the same pixels of a leaf, so that a still picture does not change. Engines that average frames, as temporal
   * antialiasing does, pass a number above 0 that differs in each frame, such as a frame count; it may start again at 1 after 16 or more.
   * Each frame then leaves out other pixels, and the average shows what lies behind. Do not use it for shadow maps that are kept. */
  uint32_t temporal_frame;
  uint32_t layer_mask; /* instances whose layer_mask shares a bit with it are drawn and streamed; default COPPICE_ALL_LAYERS */

  /* Null, the default, or the second eye of a stereo pair; read within the call. Both eyes show the same leaves: an instance is drawn in
   * both if one of them sees it, and its cut and its light are those seen from the middle between the eyes. Both eyes are perspectives of
   * width_px x height_px, both mirrored or neither. They may be turned against each other. */
  const coppice_eye* second_eye;
} coppice_camera;
static inline void coppice_camera_init(coppice_camera* camera) {
  coppice_struct_init(COPPICE_STRUCT_CAMERA, camera, sizeof *camera);
}

/* Describes what a shadow map covers: a sphere, and what may cast shadows on it up to three radii further towards the sun. Radius and size
 * must be set. */
typedef struct coppice_sun_desc {
  uint32_t struct_size;
  float sun_direction[3]; /* unit, towards the sun, world space; default 0 1 0 */
  double center[3];       /* world space, m, within 1e9 of 0 */
  float radius_m;         /* 1e-6 to 1e8 */
  uint32_t size_px;       /* 1 to the device's limit */
} coppice_sun_desc;
static inline void coppice_sun_desc_init(coppice_sun_desc* desc) {
  coppice_struct_init(COPPICE_STRUCT_SUN_DESC, desc, sizeof *desc);
}

/* Fills the camera of a view of COPPICE_OUTPUT_DEPTH with the sun's orthographic view. error_px is the default, in px of the map; a metre
 * is size_px / (2 radius_m) px. Depth runs as the view's depth_compare says, without a renderer from 0 at the near plane to 1. If the
 * centre moves in whole steps of the map, edges of shadows stay still.
 * camera: out. struct_size must be set; all other fields are overwritten, so set error_px and layer_mask afterwards. thread: as
 * coppice_scene_get_info */
COPPICE_API coppice_status coppice_sun_camera(const coppice_context* context, coppice_view view, const coppice_sun_desc* desc,
                                              coppice_camera* camera);

/* Describes the wind on all plants of a context. The place of a point depends only on this struct and on its place at rest, so every level
 * of detail and every view agree. Stems bend, boughs sway and leaves flutter as far as the file says (coppice bake --wind-stiffness); gusts
 * travel. A gale of 25 m/s bends stems by no more than 0.4 of the plant's height, moves no point by more than 0.8 of the radius of its
 * bounding sphere, and stronger winds move it no further. */
typedef struct coppice_wind {
  uint32_t struct_size;
  /* The direction that the wind blows to, unit, world space. Its horizontal part counts; straight up or down is still air. Default 1 0 0.
   * Gusts turn with it about the context's first origin: turn it slowly. */
  float direction[3];
  /* m/s, 0 to 100; 0, the default, is still air: the picture is bit for bit the one without wind */
  float speed;
  float gustiness; /* 0 to 1: how far gusts depart from the mean; default 0.5 */
  double time_s;   /* seconds since any moment, 0 to 1e9; default 0 */
  /* time_s of the frame before; default 0. Velocities are the motion since then. They use the wind of that frame */
  double time_before_s;
  /* Velocities that are added to the wind: gusts, rotors, explosions. Null, the default, adds none, and the fields below are ignored. The
   * array is [map_height][map_width][2], x and z in world space, m/s, each within -100 to 100. A plant takes the velocity where it stands,
   * linear between places of the map and 0 outside. The sum moves it no further than a gale would. The map is copied within the call and
   * kept for the next frame's velocities. Cost: 8 bytes a place are sent to the GPU in each frame; the GPU keeps 1 MB from the first map
   * on; moving a plant takes four more loads. If memory is short plants move without the map, and the log says so. */
  const float* map;
  double map_min[2];   /* world x and z of the map's first place, m; within 3.3e7 of the origin */
  double map_max[2];   /* world x and z of its last place; above map_min by 1e-3 or more */
  uint32_t map_width;  /* places along x, 2 to 256 */
  uint32_t map_height; /* places along z, 2 to 256 */
  /* How far gusts have travelled, m, up to 1e11. An engine that changes the wind's speed adds speed * seconds in each frame, so that gusts
   * continue from where they are. Below 0, the default, stands for speed * time_s: the wind has always had this speed. */
  double gusts_m;
} coppice_wind;
static inline void coppice_wind_init(coppice_wind* wind) {
  coppice_struct_init(COPPICE_STRUCT_WIND, wind, sizeof *wind);
}

#define COPPICE_GUST_WAVES 3u

typedef struct coppice_gust_wave {
  float x, z;  /* rad/m, along world x and z */
  float phase; /* rad, at the place that was asked for */
  float share; /* share of this wave; the shares sum to 1 */
} coppice_gust_wave;

/* Describes the wind about a place at one moment, for things beside plants: grass, cloth, smoke. At p, m from the place, things bear the
 * load
 *     load * (1 - gustiness * (0.5 - 0.5 * g)),    g = sum of share * sin(x * p.x + z * p.z + phase)
 * along `direction`. coppice_wind.map is not included. */
typedef struct coppice_gusts {
  uint32_t struct_size;
  float direction[3]; /* unit, horizontal */
  float load;         /* 0 in still air, 1 in a gale of 25 m/s and beyond; grows slower than speed */
  float gustiness;
  coppice_gust_wave waves[COPPICE_GUST_WAVES];
} coppice_gusts;
static inline void coppice_gusts_init(coppice_gusts* gusts) {
  coppice_struct_init(COPPICE_STRUCT_GUSTS, gusts, sizeof *gusts);
}

/* Returns the gusts at wind->time_s. place: world space, m; choose it near the things that move, because phases are single precision.
 * gusts: out. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_wind_gusts(const coppice_context* context, const coppice_wind* wind, const double place[3],
                                              coppice_gusts* gusts);

typedef struct coppice_frame {
  uint32_t struct_size;
  uint64_t frame_number; /* number of the frame that begins; grows by at least 1 each call; the first is >= 1 */
  /* The GPU, or the host, has finished every frame up to this number; 0: none yet. Below frame_number; never falls */
  uint64_t completed_number;
  const coppice_camera* cameras; /* [camera_count], one for each view that is drawn; read within the call */
  uint32_t camera_count;         /* may be 0: then nothing is drawn, and nothing is in demand */
  /* distance between cameras: sizeof(coppice_camera) as the program was compiled with. coppice_frame_init sets it */
  uint32_t camera_bytes;
  const coppice_wind* wind; /* read within the call; null, the default: still air */
} coppice_frame;
static inline void coppice_frame_init(coppice_frame* frame) {
  coppice_struct_init(COPPICE_STRUCT_FRAME, frame, sizeof *frame);
  if (frame) frame->camera_bytes = sizeof(coppice_camera);
}

/* Begins a frame: collects finished reads and decodes, decides for all its views together what to load and evict, and starts reads and
 * jobs. Each view group measures its own demand; streaming loads the maximum over the groups. A view with colours joins the one of three
 * groups that has the fewest views; views of COPPICE_OUTPUT_DEPTH are a fourth. A group has the lowest threshold of its views.
 * before: between frames; a frame of which nothing was recorded has ended too
 * after: the frame has begun. With a renderer coppice_record_upload comes next, without one coppice_next_change and coppice_get_draws
 * cost: streaming_ms at most for finished reads; measuring 100,000 instances takes 0.1 to 0.5 ms a view
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: no frame is begun, and the one before goes on. COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_frame_begin(coppice_context* context, const coppice_frame* frame);

/* ---- statistics ----------------------------------------------------------------------------------------------------------------- */

/* Names the passes that coppice_view_stats.pass_ms times. The engine times coppice_record_draw itself. */
typedef enum coppice_pass {
  COPPICE_PASS_UPLOAD = 0,
  COPPICE_PASS_CULL = 1,   /* blocks, instances, cuts, clusters */
  COPPICE_PASS_SPLATS = 2, /* small leaves and wood, by compute shaders */
  COPPICE_PASS_LEAVES = 3, /* larger leaves and wood, by compute shaders */
  COPPICE_PASS_TILES = 4,  /* depth of tiles, for occlusion */
  COPPICE_PASS_COUNT = 5,  /* number of passes; later headers may have more */
  COPPICE_PASS_MAX_ENUM = 0x7fffffff
} coppice_pass;
#define COPPICE_MAX_PASSES 16u

/* Names the kinds of chunks that are counted separately. */
typedef enum coppice_streamed {
  COPPICE_STREAMED_PAGES = 0,       /* pages of foliage */
  COPPICE_STREAMED_WOOD = 1,        /* LoDs of the wood */
  COPPICE_STREAMED_TEXTURES = 2,    /* textures, normal maps too */
  COPPICE_STREAMED_LEAF_MESHES = 3, /* parts of the leaf meshes */
  COPPICE_STREAMED_ALL = 4,         /* sums over the other kinds */
  COPPICE_STREAMED_COUNT = 5,
  COPPICE_STREAMED_MAX_ENUM = 0x7fffffff
} coppice_streamed;
#define COPPICE_MAX_STREAMED 8u

typedef struct coppice_streamed_stats {
  uint64_t loaded; /* since creation, as the next three */
  uint64_t evicted;
  uint64_t failed;    /* given up; the log says why */
  uint64_t cancelled; /* reads whose chunk was no longer in demand when they returned */
  uint32_t in_flight; /* being read or decoded */
  uint32_t wanted;    /* in demand by a view at its threshold_px, and not resident */
  uint32_t queued;    /* in demand, not requested yet */
} coppice_streamed_stats;

typedef struct coppice_stats {
  uint32_t struct_size;
  uint32_t instance_count;
  uint64_t source_leaf_count; /* sum over all instances */
  uint64_t memory_budget_bytes;
  /* in use now: GPU, staging and decoded pages. Device memory counts in whole blocks, including one that is reserved ahead */
  uint64_t memory_bytes;
  uint64_t memory_peak_bytes;
  /* blocks of device memory in use: calls of coppice_device_memory.allocate minus those of free */
  uint64_t device_allocations;
  coppice_streamed_stats streamed[COPPICE_MAX_STREAMED]; /* indexed by coppice_streamed; other elements are 0 */
  uint64_t bytes_read;                                   /* since creation, after opening */
  double decode_ms;                                      /* since creation; CPU time of decoding, summed over all threads */
  uint32_t pipelines_wanted;                             /* since creation; see coppice_pipelines_ready */
  uint32_t pipelines_built;                              /* number of those that are built; the others' draws are missing */

  /* Sums over the open scenes; all zero without one. */
  uint64_t scene_instance_count; /* in the files; instance_count counts those that are loaded */
  uint32_t scene_tile_count;
  uint32_t scene_tiles_resident;
  uint32_t scene_tiles_wanted;  /* in demand by a view, resident or not */
  uint32_t scene_tiles_missing; /* in demand, not resident, and not given up as damaged */
  uint32_t scene_tiles_failed;
  /* plants that a scene names and that could not be opened or are not allowed; their instances are left out */
  uint32_t scene_species_failed;
  float scene_threshold_px; /* the largest limit of all scenes; above 1 if not everything larger than a pixel fits */

  /* creation time of the pipeline that took longest; see coppice_vulkan_desc.pipeline_cache */
  float longest_pipeline_ms;
  const char* longest_pipeline; /* its first shader; static storage; null before the first */
  double pipelines_ms;          /* creation time, summed over all threads */
  const char* missing_pipeline; /* the first shader of the first pipeline that is not built; null if all are */
} coppice_stats;
static inline void coppice_stats_init(coppice_stats* stats) {
  coppice_struct_init(COPPICE_STRUCT_STATS, stats, sizeof *stats);
}
/* Returns statistics of the context. stats: out. The figures are as of the last coppice_frame_begin, or newer.
 * thread: as coppice_scene_get_info. cost: some 0.1 us for each open plant */
COPPICE_API coppice_status coppice_get_stats(const coppice_context* context, coppice_stats* stats);

/* Statistics of one view. */
typedef struct coppice_view_stats {
  uint32_t struct_size;
  uint32_t visible_instance_count;
  /* in view but hidden by others; counted with compute_raster only */
  uint32_t occluded_instance_count;
  uint32_t leaf_mesh_instance_count; /* visible instances that are drawn with leaf meshes, not quads */
  /* the frame that these figures are of: the latest finished one that culled the view; 0: none yet */
  uint64_t gpu_frame_number;
  uint64_t drawn_leaf_count;
  uint64_t drawn_wood_triangle_count;
  uint64_t drawn_leaf_mesh_triangle_count;
  /* The threshold that decides what is loaded. It is the view's error_px, or higher if the memory budget or the leaf budget is too small;
   * in the latter case it decides what is drawn too. 0: every leaf. From the last frame that showed the view. */
  float threshold_px;
  /* indexed by coppice_pass: GPU time of a recent frame; the upload's is that of all views. 0 without pass_times */
  float pass_ms[COPPICE_MAX_PASSES];
} coppice_view_stats;
static inline void coppice_view_stats_init(coppice_view_stats* stats) {
  coppice_struct_init(COPPICE_STRUCT_VIEW_STATS, stats, sizeof *stats);
}
/* Returns statistics of a view. stats: out; all 0 if no frame has shown it. before, thread: as coppice_get_stats */
COPPICE_API coppice_status coppice_get_view_stats(const coppice_context* context, coppice_view view, coppice_view_stats* stats);

/* ---- hosts that draw themselves -------------------------------------------------------------------------------------------------- */

/* A host of coppice_context_create does this in a frame:
 *
 *     coppice_frame_begin(context, &frame);                with the cameras of all views; completed_number: frames that it has drawn
 *     coppice_change_init(&change);
 *     while (coppice_next_change(context, &change) == COPPICE_OK && change.kind != COPPICE_CHANGE_NONE)
 *       coppice_confirm(context, &change, outcome);        now or in a later frame, once it has copied or freed the chunk
 *     coppice_get_draws(context, view, draws, ...);        for each view: what to draw of which plant, and where
 *     coppice_write_leaves(context, file, leaf_count, ...) if it draws leaves as triangles; others draw the nodes
 *
 * The host knows a plant by its *file*: a number below max_plants + 4 that the plant's first change gives and that changes when the plant
 * is reloaded. Chunks and draws name a file. Numbers are used again after COPPICE_CHANGE_PLANT_CLOSED. Take the changes before you ask for
 * draws; otherwise a draw may name a file that you do not know. */

/* A node of the plant's tree of leaves is a quad. Node 0, the root, is coppice_file_info.root. Split s replaces a node by nodes 2s + 1 and
 * 2s + 2. The cut of m leaves consists of the m nodes below 2m - 1 that no split below m - 1 replaces. */
typedef struct coppice_leaf_node {
  /* in ring order: position = box_min + box_step * corner, object space, m. 0 and 3 are at the stalk, 1 and 2 at the tip; triangles are (0,
   * 1, 2) and (0, 2, 3). Corner i shows coppice_card.uv[i] */
  uint16_t corners[4][3];
  uint8_t card;
  uint8_t opacity;   /* 1 to 16: so many sixteenths of the quad's pixels are shown */
  uint16_t reserved; /* any value */
  uint32_t split;    /* the split that replaces it; 0xffffffff: none */
  /* How the normals of the leaves that it stands for lie about an axis: what coppice_leaf_light of coppice_surface.glsl takes. Bits 14 and
   * 15 are a side s. With s = 3 it is one flat leaf: the axis is the quad's normal, (corner 2 - corner 0) x (corner 3 - corner 1), along is
   * 1, and the side that the eye sees is the front. Else k, bits 10 to 13, is 15 times along; w is 3 for k = 1..9, 4 for k = 0, 10..12,
   * else 5; h, the highest w of bits 0..4, gives u = max((h - H) / (H - 1), -1), H = 2^(w - 1), bits 5..9 give v. The axis is (x, 1 - |x| -
   * |z|, z) normalised, x = (u + v) / 2, z = (u - v) / 2. s = 1: it points to the front, whoever looks; 2: away from it; 0: the eye's side
   * is front */
  uint16_t normals;
  uint16_t reserved_end; /* 0 */
} coppice_leaf_node;

/* A vertex of wood or of a leaf mesh. */
typedef struct coppice_mesh_vertex {
  float position[3]; /* object space, m */
  float normal[3];   /* unit */
  float uv[2];
  uint32_t material;
} coppice_mesh_vertex;

typedef enum coppice_change_kind {
  COPPICE_CHANGE_NONE = 0,
  COPPICE_CHANGE_PLANT_OPENED = 1, /* its chunks follow. Needs no confirmation */
  COPPICE_CHANGE_PLANT_CLOSED = 2, /* all its chunks have been freed. Needs no confirmation */
  /* to be copied by the host. Once it is confirmed the chunk counts as resident, and draws name it */
  COPPICE_CHANGE_CHUNK_ADDED = 3,
  COPPICE_CHANGE_CHUNK_DROPPED = 4, /* no draw names it any more. Its memory counts towards the budget until it is confirmed */
  COPPICE_CHANGE_KIND_MAX_ENUM = 0x7fffffff
} coppice_change_kind;

typedef struct coppice_change {
  uint32_t struct_size;
  coppice_change_kind kind;
  coppice_plant plant; /* the handle may have been closed since */
  uint32_t file;
  /* All fields from here on describe a chunk. Fields that do not belong to its kind are 0. */
  coppice_streamed chunk;  /* COPPICE_STREAMED_PAGES, _WOOD, _TEXTURES, _LEAF_MESHES */
  uint32_t index;          /* index among chunks of its kind: page, wood LoD (0 is the finest), texture, part of the leaf meshes */
  uint32_t texture_format; /* coppice_texture_format of coppice/format.h */
  /* The content of a chunk that was added; null for one that was dropped. Valid until the change is confirmed; aligned to 4 bytes.
   *   page             coppice_leaf_node[node_count], starting with node first_node. Pages come in order: the resident ones are a prefix
   *   wood, leaf mesh  coppice_mesh_vertex[vertex_count], then uint32_t[index_count], three a triangle
   *   texture          mip_count levels of texels, largest first, tightly packed. Each level has half the sides of the one before, at
   *                    least 1. The first row is v = 0, glTF's uppermost
   * A normal map is a texture too. With the sampled alpha a, and green g converted from sRGB to linear, the normal is x = 2a - 1 along u, y
   * = 2g - 1 against v, and z out of the surface. */
  const void* bytes;
  uint64_t byte_count;
  uint32_t first_node;
  uint32_t node_count;
  uint32_t vertex_count;
  uint32_t index_count;
  uint32_t width;
  uint32_t height;
  uint32_t mip_count;
  uint32_t reserved; /* 0 */
} coppice_change;
static inline void coppice_change_init(coppice_change* change) {
  coppice_struct_init(COPPICE_STRUCT_CHANGE, change, sizeof *change);
}

/* Takes the next change. Opened, closed and dropped plants and chunks come first, in the order of their events; then added chunks by
 * priority, one page of a plant at a time. kind is COPPICE_CHANGE_NONE if there is none. A plant's chunks are dropped in a frame in which
 * none of its reads and jobs is running. The change that closes the plant comes one frame after the last of them is confirmed.
 * before: any time; most changes appear with coppice_frame_begin, the next page of a plant with coppice_confirm
 * cost: a look at each chunk of each open plant. errors: COPPICE_ERROR_INVALID_ARGUMENT, also if the context has a renderer */
COPPICE_API coppice_status coppice_next_change(coppice_context* context, coppice_change* change);

typedef enum coppice_outcome {
  COPPICE_OUTCOME_TAKEN = 0,  /* for an added chunk: the host has copied it and does not read `bytes` any more */
  COPPICE_OUTCOME_FAILED = 1, /* for an added chunk: the host has no memory for it. It is offered again after half a second of frames */
  COPPICE_OUTCOME_FREED = 2,  /* for a dropped chunk: the host has freed it */
  COPPICE_OUTCOME_MAX_ENUM = 0x7fffffff
} coppice_outcome;

/* Acknowledges a chunk. change: as coppice_next_change filled it; kind, file, chunk and index are read. For opened or closed plants it does
 * nothing and is not needed. Chunks that nobody confirms stay in memory and count. A closed plant keeps its file number until all its
 * chunks are confirmed.
 * before: the change was taken. errors: COPPICE_ERROR_INVALID_ARGUMENT: the chunk does not wait for this outcome; the log says what it
 * waits for */
COPPICE_API coppice_status coppice_confirm(coppice_context* context, const coppice_change* change, coppice_outcome outcome);

/* The properties of a file that do not change while it is open. */
typedef struct coppice_file_info {
  uint32_t struct_size;
  uint32_t leaf_count;
  uint32_t page_count;
  uint32_t wood_lod_count;
  uint32_t leaf_mesh_count;
  uint32_t texture_count;
  uint32_t material_count;
  uint32_t card_count;
  float box_min[3]; /* object space, m: see coppice_leaf_node.corners */
  float box_step[3];
  float sphere_center[3]; /* object space, m */
  float sphere_radius;
  coppice_leaf_node root;
} coppice_file_info;
static inline void coppice_file_info_init(coppice_file_info* info) {
  coppice_struct_init(COPPICE_STRUCT_FILE_INFO, info, sizeof *info);
}
/* Describes a file. file: the number from a change or a draw. before: any time, with a renderer too. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_file_get_info(const coppice_context* context, uint32_t file, coppice_file_info* info);

#define COPPICE_NONE 0xffffffffu

typedef struct coppice_material {
  uint32_t struct_size;
  float base_color[4]; /* linear; multiplies the texture */
  float alpha_cutoff;  /* 0: opaque; otherwise texels of smaller alpha are holes */
  float roughness;     /* 0 to 1 */
  /* COPPICE_TRUE: the normals of its leaf meshes' vertices say which side is lit, whoever looks; else the side that the eye sees is */
  uint32_t sided_normals;
  /* base colour, sRGB; COPPICE_NONE if it has none. Both sides are shown, of wood too: do not cull */
  uint32_t texture;
  uint32_t normal_map; /* index of a texture, see coppice_change.bytes; COPPICE_NONE if it has none */
} coppice_material;
static inline void coppice_material_init(coppice_material* material) {
  coppice_struct_init(COPPICE_STRUCT_MATERIAL, material, sizeof *material);
}
/* Describes material `index`, < coppice_file_info.material_count. before, thread: as coppice_file_get_info */
COPPICE_API coppice_status coppice_file_get_material(const coppice_context* context, uint32_t file, uint32_t index,
                                                     coppice_material* material);

/* Describes what a leaf quad shows. */
typedef struct coppice_card {
  uint32_t struct_size;
  uint32_t material;
  float uv[4][2]; /* for each corner, in the material's texture */
  /* replaces the texture at a distance: the mean colour outside holes, linear, base_color included */
  float albedo[3];
  float coverage; /* share of the card that is no hole */
} coppice_card;
static inline void coppice_card_init(coppice_card* card) {
  coppice_struct_init(COPPICE_STRUCT_CARD, card, sizeof *card);
}
/* Describes card `index`, < coppice_file_info.card_count. before, thread: as coppice_file_get_info */
COPPICE_API coppice_status coppice_file_get_card(const coppice_context* context, uint32_t file, uint32_t index, coppice_card* card);

/* Says what to draw of an instance in a view. world = position + rotation * (scale * object). */
typedef struct coppice_draw {
  coppice_plant plant;
  coppice_instance instance; /* 0 if a scene placed it */
  coppice_scene_tree tree;   /* its tree; 0 if the engine placed it */
  uint32_t file;
  /* the size of the cut, which has ceil(leaf_count * 0.999999) leaves. Not rounded, so that it changes evenly with distance. 0: leaf meshes
   * are drawn instead */
  float leaf_count;
  uint32_t node_end;    /* the cut's nodes are below it; it is 2 m - 1 */
  uint32_t wood_lod;    /* COPPICE_NONE: no wood */
  uint32_t leaf_meshes; /* COPPICE_TRUE: draw all chunks of COPPICE_STREAMED_LEAF_MESHES in place of quads */
  uint32_t user_data;   /* from its placement, as all fields below */
  double position[3];   /* world space, m; counts from the origin of coppice_set_origin */
  float scale;          /* below 0: mirrored */
  float rotation[4];    /* unit quaternion x y z w */
  float tint[3];        /* multiplies leaf colour */
  /* share of the leaves to draw, 0 to 1. The host applies it: leaf_count and coppice_write_leaves count all leaves. Our renderer leaves out
   * single leaves by a hash and shrinks merged ones; a host need not choose the same leaves */
  float leaf_share;
  uint32_t reserved; /* 0 */
} coppice_draw;

/* Lists the instances in the view's frustum, each with what the threshold asks for as far as it is resident. With a renderer that is what
 * was resident at the last coppice_record_upload, otherwise what has been confirmed.
 * draws: [capacity], each `draw_bytes` after the one before, which is sizeof(coppice_draw) as the program was compiled with; may be null if
 * capacity is 0
 * count: out, the number of instances; those beyond capacity are left out without an error
 * before: coppice_frame_begin with a camera of the view. thread: calls for different views may overlap. cost: some 40 ns a draw */
COPPICE_API coppice_status coppice_get_draws(coppice_context* context, coppice_view view, coppice_draw* draws, uint32_t capacity,
                                             uint32_t draw_bytes, uint32_t* count);

typedef enum coppice_leaf_color {
  COPPICE_LEAF_COLOR_FLOAT4 = 0,
  COPPICE_LEAF_COLOR_UNORM8X4 = 1, /* bytes r, g, b, a; values above 1 become 1 */
  COPPICE_LEAF_COLOR_MAX_ENUM = 0x7fffffff
} coppice_leaf_color;

/* Describes the host's vertices: offsets in bytes, or COPPICE_NONE, the default of all, for an attribute that they lack. */
typedef struct coppice_leaf_layout {
  uint32_t struct_size;
  uint32_t vertex_bytes; /* distance between vertices */
  uint32_t position;     /* float3, object space, m */
  /* float3, unit: the axis of the node's normals. A flat leaf's is its quad's; 0 0 0 if that has no area. A node that is sided has it on
   * its front, others on the side from which the triangles run counter-clockwise */
  uint32_t normal;
  uint32_t uv; /* float2 */
  /* as color_format: base_color without tint and texture, linear; alpha is the share of its pixels that are shown */
  uint32_t color;
  uint32_t material; /* uint32_t */
  coppice_leaf_color color_format;
  uint32_t index_bytes; /* 4, the default, or 2 */
  /* float, 0 to 1: how far the normals of the leaves that a node stands for lie along `normal`; 1 is flat, 1/3 all directions. A renderer
   * lights with coppice_leaf_light(normal, along, light, eye, sided) of coppice_surface.glsl, all in one space, in place of the cosine of
   * normal and light: its x is the light on the visible side, its y the light that shines through */
  uint32_t along;
  uint32_t sided; /* float, 0 or 1: 1 if `normal` says which side is lit, whoever looks */
} coppice_leaf_layout;
static inline void coppice_leaf_layout_init(coppice_leaf_layout* layout) {
  coppice_struct_init(COPPICE_STRUCT_LEAF_LAYOUT, layout, sizeof *layout);
}

typedef struct coppice_leaf_output {
  uint32_t struct_size;
  uint32_t vertex_capacity; /* vertices that fit; a leaf has four */
  void* vertices;
  void* indices;
  /* indices that fit; a leaf has six, counter-clockwise from the front: (0, 1, 2) and (0, 2, 3) */
  uint32_t index_capacity;
  uint32_t vertex_count; /* out, as the next two: what the cut needs, written or not */
  uint32_t index_count;
  uint32_t leaf_count;
} coppice_leaf_output;
static inline void coppice_leaf_output_init(coppice_leaf_output* output) {
  coppice_struct_init(COPPICE_STRUCT_LEAF_OUTPUT, output, sizeof *output);
}

/* Writes a cut's leaves as triangles in the host's layout, in the order of their nodes. leaf_count: of a draw, or any number above 0. It is
 * rounded as coppice_draw.leaf_count says, and clamped to the resident leaves: those of confirmed pages, whose nodes Coppice keeps, or
 * those that our renderer has. If a capacity is too small, or both are 0, nothing is written and the counts say what is needed. Bytes that
 * the layout does not mention stay as they are.
 * before: any time, with a renderer too. thread: as coppice_scene_get_info. cost: some 10 ns for each node below 2 m - 1
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: no open file; an offset whose attribute does not fit vertex_bytes, or is not a multiple of 4; too
 * many vertices for 2 bytes of index; a null pointer */
COPPICE_API coppice_status coppice_write_leaves(const coppice_context* context, uint32_t file, float leaf_count,
                                                const coppice_leaf_layout* layout, coppice_leaf_output* output);

#ifdef __cplusplus
}
#endif

#endif
