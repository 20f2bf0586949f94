#ifndef COPPICE_H
#define COPPICE_H

/* libcoppice: streaming level of detail for plants. This header has no graphics API below it: hooks, the context, plants, instances,
 * scenes, views, streaming and statistics. Two libraries have its functions: libcoppice, which needs no graphics API, for hosts that draw
 * themselves; and libcoppice_vulkan, which has our renderer on the engine's Vulkan device too (coppice/vulkan.h). A program links one.
 *
 * A host: it creates a context, and a view of it for each picture; opens plants and adds instances, or opens a scene, which does both; and
 * in each frame says what its cameras show:
 *
 *     coppice_frame_begin(context, &frame);   frame_number grows; completed_number: the last frame whose commands the GPU has finished,
 *                                             such as the last one whose fence has signalled
 *     ...                                     with our renderer: upload, cull, draw (coppice/vulkan.h); else changes and draws (below)
 *
 * until coppice_is_settled, or for as long as it runs. A frame lasts until the next coppice_frame_begin. What changes plants, instances,
 * scenes, views or the origin is called before coppice_record_upload, without a renderer before coppice_frame_begin, or after the last call
 * of the frame that records or asks for draws.
 *
 * Units and axes: metres, right-handed, +Y up (glTF's). Matrices are column-major, for column vectors; view space looks down -Z. Clip space
 * is Vulkan's: y down, depth 0 to 1. Booleans are uint32_t, COPPICE_FALSE or COPPICE_TRUE and no other value.
 *
 * Words:
 *   leaf, wood     of a plant: quads that merge into larger ones, and a mesh in some levels of detail (LoDs)
 *   cut            a set of quads that together are the whole plant, at any number of leaves from all to 1, the root
 *   page           512 steps of refinement, 1,024 quads. Pages come in order: what is there is a prefix, and a complete plant
 *   leaf mesh      leaves as they were modelled, in place of quads close up
 *   chunk          what is read and dropped as one: a page, a wood LoD, a texture, a part of the leaf meshes
 *   front          the first part of a file: tables, the coarsest wood, the first page; a first picture needs no more
 *   threshold      how wrong an instance may look in a view, px (coppice_camera.error_px)
 *   tile, species  of a scene: a square with up to 2,048 of its plants, which comes and goes as one; a plant that it names
 *   resident       in memory, for whoever draws; settled: all that is wanted and fits is
 *
 * Threads: distinct contexts are independent. Calls on one context are externally serialised; functions that take a const context may
 * overlap with each other, and so may the recording of different views (coppice/vulkan.h). Hooks are called from the threads their comments
 * name. A library that was built without NDEBUG, or with _GLIBCXX_ASSERTIONS, refuses a call that overlaps with another, and one that a
 * hook makes, with COPPICE_ERROR_INVALID_ARGUMENT and a line in the log.
 *
 * Errors: every function that can fail returns a coppice_status, also in release builds; the log hook gets one line with the detail, the
 * field and its index: "coppice_instances_add: placements[3].position[0] is not finite". coppice_last_error returns the last such line.
 * What is refused changes nothing. A null context, or a null pointer where none is allowed, is COPPICE_ERROR_INVALID_ARGUMENT. Nothing
 * throws across this header.
 *
 * What the comment of a function says, in this order. Where it is silent:
 *   before   at any time, between frames or within one
 *   after    nothing else has changed
 *   queue    none: only the functions of coppice/vulkan.h that take a command buffer have to do with one
 *   thread   as above: any, one call at a time on a context
 *   cost     microseconds, and no wait for files, jobs or the GPU
 *   errors   COPPICE_ERROR_INVALID_ARGUMENT alone
 *
 * Structs grow: later versions add fields at the end. A struct starts with struct_size, its size in the header that the program was
 * compiled with; the *_init function sets it, and every other field to its default. It does nothing for a null pointer. A program
 * therefore runs with later versions of the library, and with earlier ones as long as it leaves what these do not know at 0:
 *   structs that the library reads   of a smaller one the missing fields have their defaults. A larger one is taken where the bytes that
 *                                    this version does not know are all 0, else COPPICE_ERROR_INVALID_ARGUMENT: the log names the byte
 *   structs that the library fills   a smaller one is filled as far as it goes; of a larger one the rest becomes 0
 *   structs that a hook is given     are as large as their struct_size says: a program must not read further
 * Sizes are multiples of 4 from 4 to 4,096 bytes; others are COPPICE_ERROR_INVALID_ARGUMENT. Enumerations grow too: expect values that
 * you do not know.
 */

#include <stddef.h>
#include <stdint.h>

#define COPPICE_VERSION_MAJOR 0
#define COPPICE_VERSION_MINOR 2
#define COPPICE_VERSION_PATCH 0

/* 10 bits of the major, 10 of the minor and 12 of the patch version: larger numbers are later versions. */
#define COPPICE_MAKE_VERSION(major, minor, patch) ((major)*0x400000u + (minor)*0x1000u + (patch))
#define COPPICE_HEADER_VERSION COPPICE_MAKE_VERSION(COPPICE_VERSION_MAJOR, COPPICE_VERSION_MINOR, COPPICE_VERSION_PATCH)

/* Before every function that the library exports. For Windows, programs that link the shared library define COPPICE_SHARED; the
 * library's own build defines COPPICE_BUILDING too. */
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

/* COPPICE_HEADER_VERSION of the library that is linked or loaded. Any thread, before any context too. */
COPPICE_API uint32_t coppice_version(void);

typedef enum coppice_status {
  COPPICE_OK = 0,
  COPPICE_ERROR_INVALID_ARGUMENT = 1, /* null, bad handle, value out of range */
  COPPICE_ERROR_IO = 2,               /* a file could not be read */
  COPPICE_ERROR_BAD_FILE = 3,         /* not a .coppice or .forest file, damaged, or of another version */
  COPPICE_ERROR_UNSUPPORTED = 4,      /* the device lacks something required; the log names it */
  COPPICE_ERROR_OUT_OF_MEMORY = 5,
  COPPICE_ERROR_DEVICE_LOST = 6,
  COPPICE_ERROR_INTERNAL = 7,
  COPPICE_STATUS_MAX_ENUM = 0x7fffffff
} coppice_status;

/* A short English sentence, static storage, never null. */
COPPICE_API const char* coppice_status_text(coppice_status status);

typedef struct coppice_context coppice_context;

/* The line of the context's last call that failed, whichever thread made it: "coppice_plant_open: oak.coppice: No such file or directory".
 * Calls that succeed leave it as it is; empty: none has failed. Where context is null: of the calling thread's last call that failed
 * without a context, such as one that creates one. Never null, UTF-8, at most 1,023 bytes, without control characters. Valid until the
 * thread calls this function again. Any thread, at any time while the context is there. What fails in the background goes to the log
 * alone. */
COPPICE_API const char* coppice_last_error(const coppice_context* context);

/* The structs of this header, for coppice_struct_init. */
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
/* Fills a struct of `bytes` bytes with the defaults of its kind, as far as it goes; what the library does not know becomes 0. struct_size
 * becomes `bytes`. The *_init functions call it with the size that their program was compiled with; call those, unless you bind the
 * library to another language. Does nothing where data is null or bytes is below 4. Any thread. */
COPPICE_API void coppice_struct_init(coppice_struct kind, void* data, size_t bytes);

/* Handles are 64 bits, from the highest: 3 of the kind (1 a plant, 2 an instance, 3 a scene, 4 a view), 12 of the context, 21 of a
 * generation, 28 of an index. So one of another kind, of another context or of something that has gone is refused with
 * COPPICE_ERROR_INVALID_ARGUMENT. Two contexts are told apart unless 4,095 others are created in between; a slot's generations repeat after
 * two million uses. 0 is never a handle. Nothing else may be concluded from the bits. */
typedef uint64_t coppice_plant;
typedef uint64_t coppice_instance;
typedef uint64_t coppice_scene;
typedef uint64_t coppice_view;

/* ---- hooks ---------------------------------------------------------------------------------------------------------------------- */

/* Each is a struct of functions, which coppice_context_desc points at. The struct is copied when the context is created; `user` and what
 * the functions need must outlive the context. A struct whose functions are all null counts as not given. */

/* Memory for what grows with plants, pages, instances and scenes: chunks as read and as decoded, instances, the streamer's tables, a
 * plant's front and its path, a scene's tiles and species. Not counted by the budget: what the renderer notes of a plant beside its tables.
 * Not through it, and not counted either: what Draco decodes to while a job has the chunk, bounded by the chunk's counts and
 * COPPICE_ERROR_OUT_OF_MEMORY where malloc has nothing; texts of errors; the context itself. Called from any thread that runs a job or
 * calls the context. Must return memory aligned to `align` (a power of two) or null, which makes the operation fail with
 * COPPICE_ERROR_OUT_OF_MEMORY. Must not call back into Coppice. Must outlive the context. */
typedef struct coppice_allocator {
  uint32_t struct_size;
  void* user;
  void* (*allocate)(void* user, size_t bytes, size_t align);
  void (*free)(void* user, void* pointer, size_t bytes);
} coppice_allocator;
static inline void coppice_allocator_init(coppice_allocator* hook) {
  coppice_struct_init(COPPICE_STRUCT_ALLOCATOR, hook, sizeof *hook);
}

/* Where decoding runs, and the building of pipelines. submit is called from the thread inside what creates a context,
 * coppice_frame_begin, coppice_record_upload or coppice_record_cull; it may run `function(argument)` on any thread, or inline before it
 * returns (tests do: deterministic). Every submitted function must run before the context is destroyed: coppice_context_destroy waits for
 * them. May not call back into Coppice other than through `function`. */
typedef struct coppice_jobs {
  uint32_t struct_size;
  void* user;
  void (*submit)(void* user, void (*function)(void* argument), void* argument);
} coppice_jobs;
static inline void coppice_jobs_init(coppice_jobs* hook) {
  coppice_struct_init(COPPICE_STRUCT_JOBS, hook, sizeof *hook);
}

/* File access, called from the thread inside coppice_plant_open, coppice_plant_reload, coppice_plant_close, coppice_scene_open,
 * coppice_scene_close, coppice_frame_begin or coppice_context_destroy; a file is closed once nothing of a closed plant is under way. read
 * must not block: it calls done(argument, bytes_read) once, from any thread, or inline. bytes_read < bytes, or negative, means failure.
 * `destination` stays valid until done is called. coppice_plant_open and coppice_scene_open wait for their reads: done must not depend on
 * the calling thread going on. What is negative is the reason as -errno, which the log spells out, or -1 where there is none to give;
 * -EINVAL of open: not a regular file. A read that failed, or came short, is tried again after 50, 200 and 800 ms before what it was of
 * counts as failed; frames go on meanwhile. */
typedef struct coppice_io {
  uint32_t struct_size;
  void* user;
  int64_t (*open)(void* user, const char* path, uint64_t* file_bytes); /* a handle >= 0, or -errno */
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

/* One line without a newline or any other control character, valid during the call. Each thing that fails is one line, which names the
 * file, the field or chunk, its byte and the system's reason as far as they are known. Called from any thread. */
typedef struct coppice_log {
  uint32_t struct_size;
  void* user;
  void (*write)(void* user, coppice_log_level level, const char* line);
} coppice_log;
static inline void coppice_log_init(coppice_log* hook) {
  coppice_struct_init(COPPICE_STRUCT_LOG, hook, sizeof *hook);
}

typedef enum coppice_trace_kind {
  COPPICE_TRACE_READ = 0,        /* a chunk, from the request to the bytes: several at a time on one thread */
  COPPICE_TRACE_DECODE = 1,      /* a chunk, on a job's thread */
  COPPICE_TRACE_UPLOAD = 2,      /* a chunk, within COPPICE_TRACE_RECORD_UPLOAD */
  COPPICE_TRACE_FRAME_BEGIN = 3, /* coppice_frame_begin, and so on */
  COPPICE_TRACE_RECORD_UPLOAD = 4,
  COPPICE_TRACE_RECORD_CULL = 5,
  COPPICE_TRACE_RECORD_DRAW = 6,
  COPPICE_TRACE_KIND_MAX_ENUM = 0x7fffffff
} coppice_trace_kind;

/* struct_size is the library's. */
typedef struct coppice_trace_span {
  uint32_t struct_size;
  coppice_trace_kind kind;
  const char* path;  /* of the plant's file; null where it is about no chunk */
  const char* chunk; /* page, wood, texture, leaf mesh; null likewise */
  uint32_t index;    /* of the chunk among those of its kind */
  uint64_t bytes;    /* in the file; of an upload, for the GPU */
  uint64_t start_ns; /* CLOCK_MONOTONIC */
  uint64_t end_ns;
} coppice_trace_span;

/* What the library spent time on, said when it ended and on the thread where it ended. `span` and its strings are valid during the call.
 * Must not call back into Coppice. Without it no clock is read for it. */
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
  /* Upper limits alone: nothing is sized by them, and they need not be set. Buffers and tables grow as instances are added and plants are
   * opened, by half where the budget has room for that, and shrink with the context only. An instance takes about 190 bytes, and 60 more
   * for what draws it; a plant 3.5 KB on the GPU beside what its file asks for. While one grows, what it replaces is counted too, until the
   * GPU is done with it. A device that binds fewer holds fewer instances: maxComputeWorkGroupCount[0] * 32, and maxTexelBufferElements / 4
   * where that limit is 134,217,728 or more. */
  uint32_t max_instances; /* default 16,777,216; 1 to 268,435,455 */
  uint32_t max_plants;    /* default 65,536, the most; at least 1 */
  /* COPPICE_TRUE: a scene's plants may be anywhere. For scenes that you trust: one that a stranger made may name any file. Default
   * COPPICE_FALSE. */
  uint32_t allow_outside;

  uint64_t memory_budget_bytes; /* GPU buffers and images, staging, decoded pages, tables; see coppice_allocator for what is
                                   not counted. Default 256 MiB. Below what the context takes before any plant the context is not created,
                                   and the log names the least */

  /* Null, the default: malloc, a small thread pool, io_uring (where the kernel has none, pread on that pool), nothing logged, no trace. */
  const coppice_allocator* allocator;
  const coppice_jobs* jobs;
  const coppice_io* io;
  const coppice_log* log;
  const coppice_trace* trace;

  /* Where the plants that a scene names may be: in this folder or below it. Copied. Default null: in the folder of the scene, or below
   * it. A plant elsewhere is left out as one that cannot be opened is. With the default io hook symbolic links are followed first; with one
   * of your own the path decides by its letters, and where links lead is the hook's to know. */
  const char* asset_root;

  /* CPU time that coppice_frame_begin and coppice_record_upload together take a frame to take over what was read and decoded, and to copy
   * it for the GPU, ms, > 0; at least one chunk is taken over and one copied, and what a plant cannot be drawn without; what is over waits
   * for the next frame. Default 1; infinite: no limit. */
  float streaming_ms;
  /* While the camera goes on steadily, what it will want so many frames on is streamed too. 0 to 1000; 0: only what it wants now.
   * Default 20, about what a read and a decode take when many wait. */
  float prefetch_frames;

  /* Of coppice_context_create alone. COPPICE_TRUE: the host reads BC1 and BC3 blocks, so textures come as they are in the file. Default
   * COPPICE_FALSE: they are decoded to RGBA8 on jobs, and take four to eight times the memory. */
  uint32_t block_textures;
  uint32_t reserved; /* 0 */
} coppice_context_desc;
static inline void coppice_context_desc_init(coppice_context_desc* desc) {
  coppice_struct_init(COPPICE_STRUCT_CONTEXT_DESC, desc, sizeof *desc);
}

/* A context of a host that draws by itself what Coppice streams and selects. coppice_vulkan_context_create makes one that our renderer
 * draws. context: out, null on errors. cost: a thread pool and a few megabytes. Any thread.
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: a field, a hook set in part, or a memory budget below what the context takes;
 * COPPICE_ERROR_OUT_OF_MEMORY */
COPPICE_API coppice_status coppice_context_create(const coppice_context_desc* desc, coppice_context** context);

/* Null is allowed. before: the GPU has finished every command buffer that Coppice recorded into, and no other call is under way.
 * after: all handles, and all memory of the hooks, are gone. cost: waits for running jobs and reads. */
COPPICE_API void coppice_context_destroy(coppice_context* context);

/* after: the next coppice_frame_begin evicts what does not fit any more.
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: below what the context took before any plant */
COPPICE_API coppice_status coppice_set_memory_budget(coppice_context* context, uint64_t bytes);

/* ---- plants --------------------------------------------------------------------------------------------------------------------- */

typedef enum coppice_plant_state {
  COPPICE_PLANT_READY = 0,
  COPPICE_PLANT_OPENING = 1, /* by coppice_plant_open_async */
  COPPICE_PLANT_FAILED = 2,  /* it could not be opened: close it */
  COPPICE_PLANT_STATE_MAX_ENUM = 0x7fffffff
} coppice_plant_state;

typedef struct coppice_plant_info {
  uint32_t struct_size;
  coppice_plant_state state; /* all else but failure and reloading is 0 until it is ready */
  coppice_status failure;    /* of COPPICE_PLANT_FAILED: the error of coppice_plant_open */
  uint32_t reloading;        /* what coppice_plant_reload read is not shown yet */
  uint32_t leaf_count;
  uint32_t resident_leaf_count; /* the finest cut that can be drawn now */
  uint32_t page_count;
  uint32_t resident_page_count;
  uint32_t wood_lod_count;
  uint32_t wood_triangle_count; /* of the finest wood LoD */
  float sphere_center[3];
  float sphere_radius;
  uint64_t file_bytes;
  char name[64];
  float box_min[3], box_max[3]; /* object space, m; of leaves and the coarsest wood: finer ones may reach a little further */
} coppice_plant_info;

/* Opens a .coppice file: reads its front and validates it. Finer detail streams in by itself. A file that is open already, by a scene say,
 * is opened once more, and takes memory once more.
 * plant: out, 0 on errors
 * cost: waits for two reads, the header and the front, and for the further tries of one that fails (see coppice_io): call it while loading,
 * or coppice_plant_open_async
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_IO, COPPICE_ERROR_BAD_FILE, COPPICE_ERROR_DEVICE_LOST;
 * COPPICE_ERROR_OUT_OF_MEMORY: max_plants are open, or there is no room: where the log says that it is being made, try again in a few
 * frames */
COPPICE_API coppice_status coppice_plant_open(coppice_context* context, const char* path, coppice_plant* plant);

/* The same without waiting: returns a handle at once. coppice_frame_begin goes on with it, while the reads are under way and a job decodes
 * the root page, and coppice_plant_info.state says how far it is; up to eight are read at a time, the others wait for their turn. Instances
 * may be added, moved and removed meanwhile: they are shown once the plant is ready. An error of coppice_plant_open ends in
 * COPPICE_PLANT_FAILED and a line in the log, the instances are removed then, and the handle is good for coppice_plant_get_info and
 * coppice_plant_close alone. Where the memory budget has no room it is tried again for some seconds before that. coppice_plant_close takes
 * it back at any time without waiting. Counts for max_plants until it is closed.
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_DEVICE_LOST; COPPICE_ERROR_OUT_OF_MEMORY: max_plants are open,
 * or there is no room for one more, as in coppice_plant_open */
COPPICE_API coppice_status coppice_plant_open_async(coppice_context* context, const char* path, coppice_plant* plant);

/* coppice_plant_open of a file that is in memory already, in an archive of the engine's say: chunks are copied from there when they are
 * wanted, and the io hook is not called. bytes: [size], not copied: it stays as it is until the plant is closed, or until a reload from
 * elsewhere is shown (coppice_plant_info.reloading). size: > 0. name: what the log and the trace call it; copied. errors: as
 * coppice_plant_open, but for COPPICE_ERROR_IO */
COPPICE_API coppice_status coppice_plant_open_memory(coppice_context* context, const void* bytes, size_t size, const char* name,
                                                     coppice_plant* plant);

/* Removes the plant and all its instances. after: its memory goes once none of its reads and jobs is under way, and the GPU, or a host, is
 * done with it (see coppice_frame) */
COPPICE_API coppice_status coppice_plant_close(coppice_context* context, coppice_plant plant);

/* Shows what is in a file now: `path`, or where it is null what the plant was opened from, file or memory. Reads the front as
 * coppice_plant_open does. after: plant and instance handles are as before, and what was there is drawn until as much of the new file is
 * resident, at most two seconds of frames; until then the plant takes memory twice, and one of four places that a context has for this.
 * A further reload replaces one that is under way. cost: as coppice_plant_open. errors: its own, and nothing has changed;
 * COPPICE_ERROR_INVALID_ARGUMENT also for a plant that is not ready */
COPPICE_API coppice_status coppice_plant_reload(coppice_context* context, coppice_plant plant, const char* path);

/* The same from memory: bytes, size and name as coppice_plant_open_memory has them. */
COPPICE_API coppice_status coppice_plant_reload_memory(coppice_context* context, coppice_plant plant, const void* bytes, size_t size,
                                                       const char* name);

static inline void coppice_plant_info_init(coppice_plant_info* info) {
  coppice_struct_init(COPPICE_STRUCT_PLANT_INFO, info, sizeof *info);
}
/* thread: may overlap with other const calls, as all that take a const context. errors: COPPICE_ERROR_INVALID_ARGUMENT */
COPPICE_API coppice_status coppice_plant_get_info(const coppice_context* context, coppice_plant plant, coppice_plant_info* info);

/* ---- instances ------------------------------------------------------------------------------------------------------------------ */

#define COPPICE_ALL_LAYERS 0xffffffffu

/* Where one plant stands, and how it is drawn. world = position + rotation * (scale * object). Records are passed with their size in
 * bytes, sizeof(coppice_placement) or that of a struct which begins with one: what a shorter one lacks has its default. */
typedef struct coppice_placement {
  double position[3];  /* metres; within 3.3e7 of where coordinates began, see coppice_set_origin. Kept to within 0.03 mm */
  float scale;         /* 1e-6 to 1e6; default 1. As much below 0: mirrored in its origin, or left to right if rotation ends in a half turn
                        * about x, * (1, 0, 0, 0) */
  float rotation[4];   /* unit quaternion x y z w, to within half a per cent; default 0 0 0 1 */
  float tint[3];       /* multiplies leaf colour, 0 to 65504, kept to 11 bits; default 1 1 1 */
  uint32_t user_data;  /* the engine's; default 0 */
  uint32_t layer_mask; /* drawn in views whose layer_mask shares a bit with it; default COPPICE_ALL_LAYERS */
  float lod_bias;      /* added to log2 of the error threshold, -4 to 4, kept to 11 bits; default 0. 1 is half as fine, -1 twice */
  /* Share of its leaves that is drawn, 0 to 1, for seasons and felling; default 1, and 0 is bare wood. Leaves go one after the other,
   * always in the same order; coarse ones, which stand for several, become smaller, so that a far plant thins out as a near one does. What
   * leaves there are let more light into the crown. */
  float leaf_share;
} coppice_placement;
/* Sets every field to its default, at 0 0 0. */
static inline void coppice_placement_init(coppice_placement* placement) {
  const coppice_placement at_origin = {{0, 0, 0}, 1, {0, 0, 0, 1}, {1, 1, 1}, 0, COPPICE_ALL_LAYERS, 0, 1};
  if (placement) *placement = at_origin;
}

/* Adds `count` instances of a plant that is ready or being opened. placements: [count] records of `stride` bytes, at least those of a
 * position; they need no alignment. instances: [count] handles out, may be null. All or none are added,
 * and a call that fails changes nothing else either. Those of a block of 32 slots are culled together: add neighbours together.
 * after: drawn in the next frame; by our renderer in this one if coppice_record_upload is still to come. cost: some 0.1 us each
 * errors: COPPICE_ERROR_INVALID_ARGUMENT; COPPICE_ERROR_OUT_OF_MEMORY: more than max_instances, or what holds and draws them finds no room
 * in the memory budget, or the hooks give none; where the log says that room is being made, try again in a few frames;
 * COPPICE_ERROR_DEVICE_LOST; COPPICE_ERROR_INTERNAL */
COPPICE_API coppice_status coppice_instances_add(coppice_context* context, coppice_plant plant, const coppice_placement* placements,
                                                 size_t stride, uint32_t count, coppice_instance* instances);
/* Gives instances new placements, all fields of them: [count] each, placements as above. All or none are moved. after: as of
 * coppice_instances_add. cost: 60 bytes each to the GPU, and those of their neighbours */
COPPICE_API coppice_status coppice_instances_move(coppice_context* context, const coppice_instance* instances,
                                                  const coppice_placement* placements, size_t stride, uint32_t count);
/* instances: [count]; all or none are removed. after: not drawn from the next coppice_record_upload on */
COPPICE_API coppice_status coppice_instances_remove(coppice_context* context, const coppice_instance* instances, uint32_t count);

/* For engines that move the origin of their coordinates along with the camera. From this call on what is passed (placements, cameras,
 * shadow maps, maps of wind, boxes, rays) and what is returned (draws, hits, placements of trees) counts from `origin`, which itself is in
 * coordinates as they were when the context was created: a place p is where p + origin was then. Numbers that the engine has kept are its
 * to convert. What stands already stays where it is, and nothing is loaded again. Positions are doubles and the GPU computes with what is
 * relative to the eye, so no engine needs this for precision's sake. origin: [3] m, within 3.3e7 of 0; 0 0 0 at first. before: not within a
 * frame */
COPPICE_API coppice_status coppice_set_origin(coppice_context* context, const double* origin);

/* ---- scenes ---------------------------------------------------------------------------------------------------------------------- */

typedef struct coppice_scene_info {
  uint32_t struct_size;
  uint32_t species_count;
  uint32_t tile_count;
  float square_side;   /* of the square that the plants stand in, metres */
  float square_min[2]; /* its corner: x and z, in the scene's own space */
  uint64_t instance_count;
  uint64_t file_bytes;
  float height_min; /* of the plants' feet; the same where the ground is flat */
  float height_max;
} coppice_scene_info;

/* Where a scene stands: world = position + rotation * scene. */
typedef struct coppice_scene_placement {
  uint32_t struct_size;
  float rotation[4];  /* unit quaternion x y z w, to within half a per cent; default 0 0 0 1 */
  double position[3]; /* metres, as coppice_placement's; default 0 0 0 */
} coppice_scene_placement;
static inline void coppice_scene_placement_init(coppice_scene_placement* placement) {
  coppice_struct_init(COPPICE_STRUCT_SCENE_PLACEMENT, placement, sizeof *placement);
}

#define COPPICE_MAX_SCENES 64u

/* Opens a .forest file (coppice scene makes them): reads and checks its front. From then on coppice_frame_begin streams it: a tile's
 * instances are there while its largest plant, at the tile's nearest point, is at least 1 px high in one of the frame's pictures, shadow
 * maps left aside; or evenly more, where the tiles wanted do not fit into max_instances, or into a quarter of the memory budget. The plants
 * that it names are opened as tiles with them arrive, without waiting for their reads, and count for max_plants; one that cannot be opened,
 * or is not where coppice_context_desc.asset_root allows, is left out, told to the log once and counted in scene_species_failed. Placing
 * tiles and opening plants takes about streaming_ms a frame, one of each at least. Scenes share what a context has room for: each gets at
 * least its part of a quarter of the memory budget. Plants and instances of the engine's own may stand beside them. Cuts differ a little
 * with an instance's slot, and slots go by when tiles arrive: a settled picture stands still, but another run may differ where two cuts are
 * as good. Jobs and reads that run inside the hooks' calls give the same slots each time. placement: may be null: default. scene: out, 0 on
 * errors after: nothing is there yet; coppice_is_settled says when what the views want is cost: waits for two reads, and for the further
 * tries of one that fails (see coppice_io): call it while loading errors: COPPICE_ERROR_INVALID_ARGUMENT, COPPICE_ERROR_IO,
 * COPPICE_ERROR_BAD_FILE, COPPICE_ERROR_DEVICE_LOST; COPPICE_ERROR_OUT_OF_MEMORY, also where COPPICE_MAX_SCENES are open */
COPPICE_API coppice_status coppice_scene_open(coppice_context* context, const char* path, const coppice_scene_placement* placement,
                                              coppice_scene* scene);

/* Places the scene anew, with all that is there of it: nothing is loaded again. Of a scene that moves in each frame rounding moves plants
 * by 0.03 mm against each other each time.
 * after: as of coppice_instances_add. cost: as moving its instances */
COPPICE_API coppice_status coppice_scene_move(coppice_context* context, coppice_scene scene, const coppice_scene_placement* placement);

/* after: its instances are removed, its plants closed, and what coppice_scene_hide and coppice_scene_replace have changed is forgotten.
 * cost: waits for reads of tiles that are under way */
COPPICE_API coppice_status coppice_scene_close(coppice_context* context, coppice_scene scene);

static inline void coppice_scene_info_init(coppice_scene_info* info) {
  coppice_struct_init(COPPICE_STRUCT_SCENE_INFO, info, sizeof *info);
}
/* thread: may overlap with other const calls, as all that take a const context */
COPPICE_API coppice_status coppice_scene_get_info(const coppice_context* context, coppice_scene scene, coppice_scene_info* info);

/* One of the plants that a scene names. */
typedef struct coppice_scene_plant_info {
  uint32_t struct_size;
  const char* path;    /* that it is opened by; valid while the scene is open */
  coppice_plant plant; /* 0 while it is not open: no tile has wanted it yet, or it cannot be. May be reloaded; the scene closes it */
} coppice_scene_plant_info;
static inline void coppice_scene_plant_info_init(coppice_scene_plant_info* info) {
  coppice_struct_init(COPPICE_STRUCT_SCENE_PLANT_INFO, info, sizeof *info);
}
/* species: < coppice_scene_info.species_count. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_scene_get_plant(const coppice_context* context, coppice_scene scene, uint32_t species,
                                                   coppice_scene_plant_info* info);

/* A tree: a plant that a scene's file places. It is the same one as long as the file is: before its tile comes, while it is there, and when
 * it has gone and come again. So a saved game may keep tile and number. All 0: none. */
typedef struct coppice_scene_tree {
  coppice_scene scene;
  uint32_t tile;   /* < coppice_scene_info.tile_count */
  uint32_t number; /* in the tile */
} coppice_scene_tree;

/* Hides trees, felled ones say: they are not drawn, not picked, and what they alone would want is not streamed. A tree that was replaced
 * is hidden all the same. Trees may be of several scenes, and hidden again.
 * trees: [count]; all or none are hidden
 * before: any time; their tiles need not be there. after: as of coppice_instances_remove; until coppice_scene_restore, or the scene closes
 * cost: some 0.1 us each, and a look at all trees of the scene that are not as in the file: give many at once
 * errors: COPPICE_ERROR_INVALID_ARGUMENT; COPPICE_ERROR_OUT_OF_MEMORY: about 180 bytes a tree */
COPPICE_API coppice_status coppice_scene_hide(coppice_context* context, const coppice_scene_tree* trees, uint32_t count);

/* Shows a plant in place of trees: a stump, a burnt one, the same with fewer leaves; of hidden ones too. It is there when the tile is,
 * whose choice goes by what the file has. From then on it moves with its scene. Closing the plant hides it. trees: [count]; all or none are
 * replaced. plant: open or being opened; 0: each tree's own. placements: [count] records of `stride` bytes, world space, as of
 * coppice_instances_add before, cost, errors: as of coppice_scene_hide. after: likewise; drawn as of coppice_instances_add */
COPPICE_API coppice_status coppice_scene_replace(coppice_context* context, const coppice_scene_tree* trees, coppice_plant plant,
                                                 const coppice_placement* placements, size_t stride, uint32_t count);

/* Shows trees as the file has them, whether they were hidden or replaced, or both. trees: [count]; what is as in the file stays so. before,
 * after: as of coppice_scene_replace. cost: as of coppice_scene_hide */
COPPICE_API coppice_status coppice_scene_restore(coppice_context* context, const coppice_scene_tree* trees, uint32_t count);

/* The trees that stand in a box, hidden ones too: those whose position is in it, as they are shown, of tiles that are there.
 * box_min, box_max: [3] world space, m; may be infinite. trees: [capacity], may be null where that is 0
 * count: out, how many there are; those beyond capacity are left out
 * missing_tiles: out, may be null; tiles that may have more and are not there: none about a view that has settled, but for damaged ones
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
  uint32_t resident;           /* COPPICE_TRUE: its tile is there. All below is 0 where it is not, or where its plant cannot be opened */
  uint32_t reserved[9];        /* 0 */
  coppice_plant plant;         /* that it shows, or would if it were not hidden */
  coppice_placement placement; /* likewise: give it to coppice_instances_add and hide the tree, and it is the engine's to fell */
} coppice_tree_info;
static inline void coppice_tree_info_init(coppice_tree_info* info) {
  coppice_struct_init(COPPICE_STRUCT_TREE_INFO, info, sizeof *info);
}
/* thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_scene_get_tree(const coppice_context* context, const coppice_scene_tree* tree, coppice_tree_info* info);

/* ---- picking --------------------------------------------------------------------------------------------------------------------- */

typedef struct coppice_ray {
  uint32_t struct_size;
  uint32_t layer_mask;  /* instances whose layer_mask shares a bit with it are hit; default COPPICE_ALL_LAYERS */
  double origin[3];     /* world space, m, within 1e10 of 0 */
  float direction[3];   /* unit, to within half a per cent; default 0 0 -1 */
  float max_distance_m; /* > 0, may be infinite, which is the default */
  uint32_t boxes;       /* COPPICE_TRUE: plants' boxes are hit. Default COPPICE_FALSE: their wood and their crowns */
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
  coppice_hit_kind kind; /* all else is 0 where it is nothing */
  coppice_plant plant;
  coppice_instance instance; /* 0: a scene's */
  coppice_scene_tree tree;   /* which; 0 of the engine's own */
  double position[3];        /* world space, m */
  float distance_m;          /* along the ray */
  uint32_t user_data;        /* of its placement */
} coppice_hit;
static inline void coppice_hit_init(coppice_hit* hit) {
  coppice_struct_init(COPPICE_STRUCT_HIT, hit, sizeof *hit);
}

/* The nearest plant that a ray hits. Wood is the coarsest LoD, some tens to hundreds of triangles. A crown is a
 * coarse cut of at most 512 leaves without holes, which is about as large as the crown: a ray does not pass between its leaves. That of a
 * plant without leaves (coppice_placement.leaf_share 0) is not there. Plants are hit where they are at rest, whatever the wind.
 * before: any time. What is hidden or removed is never hit. What was added or moved since the last coppice_frame_begin may be missed,
 * and so are tiles that are not there
 * thread: as coppice_scene_get_info
 * cost: some 20 ns an instance that the ray passes near, and some 10 us for each plant whose box it enters on its way to the first hit */
COPPICE_API coppice_status coppice_pick(const coppice_context* context, const coppice_ray* ray, coppice_hit* hit);

/* ---- views ----------------------------------------------------------------------------------------------------------------------- */

/* Something that plants are drawn to: a camera's picture, a shadow map, a mirror. A view keeps what culling fills, the picture of the
 * compute rasteriser, and what earlier frames have taught it; a frame begins with all the views that it will draw. */
typedef enum coppice_output {
  COPPICE_OUTPUT_LIT = 0,     /* colour, lit by coppice_light, and depth */
  COPPICE_OUTPUT_DEPTH = 1,   /* depth alone: a shadow map. Leaves are quads, and what is out of view wants nothing */
  COPPICE_OUTPUT_SURFACE = 2, /* what an engine lights itself, and depth: coppice_content of coppice/vulkan.h */
  COPPICE_OUTPUT_MAX_ENUM = 0x7fffffff
} coppice_output;

typedef struct coppice_view_desc {
  uint32_t struct_size;
  coppice_output output; /* default COPPICE_OUTPUT_LIT */
} coppice_view_desc;
static inline void coppice_view_desc_init(coppice_view_desc* desc) {
  coppice_struct_init(COPPICE_STRUCT_VIEW_DESC, desc, sizeof *desc);
}

/* A view of a context that coppice_context_create has made; of others coppice_vulkan_view_create makes them. view: out, 0 on errors.
 * before: any time. cost: 100 bytes a plant that is open.
 * errors: COPPICE_ERROR_INVALID_ARGUMENT, also where the context has a renderer; COPPICE_ERROR_OUT_OF_MEMORY */
COPPICE_API coppice_status coppice_view_create(coppice_context* context, const coppice_view_desc* desc, coppice_view* view);

/* coppice_context_destroy destroys all. before: not within a frame that shows it, whose commands are still to be recorded.
 * after: its memory goes once the GPU has finished the frames that drew it (see coppice_frame) */
COPPICE_API coppice_status coppice_view_destroy(coppice_context* context, coppice_view view);

/* Whether everything that the view, and those that share its lot in streaming (coppice_frame_begin), wanted in the last frame and can have
 * is there: plants that are being opened, tiles of scenes (near ones grow up in 16 frames), chunks; and coppice_view_stats.threshold_px has
 * come to rest. COPPICE_FALSE of a view that the last frame did not show. It knows nothing of what was opened or changed since then, nor of
 * pipelines (coppice_pipelines_ready).
 * settled: out; COPPICE_FALSE on errors. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_is_settled(const coppice_context* context, coppice_view view, uint32_t* settled);

/* ---- frame ---------------------------------------------------------------------------------------------------------------------- */

typedef enum coppice_lod_mode {
  COPPICE_LOD_CUT = 0,  /* per instance, from the error table */
  COPPICE_LOD_FULL = 1, /* every resident leaf of every instance, as modelled where that is resident: the reference picture */
  /* To compare with: seven cuts of a plant, each a quarter of the one before, as an engine with discrete levels would have them; an
   * instance shows the coarsest that error_px allows. Drawn by the hardware, also with compute_raster. */
  COPPICE_LOD_DISCRETE = 2,
  COPPICE_LOD_MODE_MAX_ENUM = 0x7fffffff
} coppice_lod_mode;

/* Colours that show what the library does, instead of light; fog and textures are left out, what the engine draws stays as it is.
 * A ramp goes from blue by green to red. */
typedef enum coppice_debug_view {
  COPPICE_DEBUG_NONE = 0,
  COPPICE_DEBUG_LOD = 1, /* leaves of an instance on a logarithmic ramp: blue one, red all; white leaf meshes */
  COPPICE_DEBUG_PATH =
      2, /* green: compute shaders, dark green: their wood; orange: quads by the hardware, magenta: leaf meshes, blue: wood */
  COPPICE_DEBUG_OVERDRAW =
      3, /* how often compute shaders drew a pixel: blue once, green 5 times, red 32; grey: by the hardware, not counted */
  COPPICE_DEBUG_OCCLUSION =
      4,                   /* the round that drew it: blue the first, which hides what later ones look at, red the last; grey: hardware */
  COPPICE_DEBUG_ERROR = 5, /* error of an instance's cut at its size, logarithmic: blue 0.5 px and less, green 4, red 32 */
  COPPICE_DEBUG_RESIDENCY = 6, /* leaves of the plant that are resident, logarithmic: blue all, red only one */
  COPPICE_DEBUG_VIEW_MAX_ENUM = 0x7fffffff
} coppice_debug_view;

/* The other eye of a stereo pair: its fields mean what those of coppice_camera do, which are the first eye's. */
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

/* What a view shows in a frame. */
typedef struct coppice_camera {
  uint32_t struct_size;
  coppice_view view;
  double view_from_world[16]; /* a rotation, perhaps mirrored, and a translation of at most 1e10 m an axis; default identity, as the next */
  /* A perspective that looks down -z, whose last row is 0 0 -1 0, or an orthographic projection, whose last row is 0 0 0 1; or a multiple
   * of it above 0. May be oblique: the third row is any near plane's, as a mirror's. Depth runs as
   * coppice_vulkan_view_desc.depth_compare says; without a renderer it makes no difference, nor does which way y points. Under an
   * orthographic one sizes do not depend on distance, and fog begins at the plane of the eye. */
  float clip_from_view[16];
  uint32_t width_px; /* 1 to what the device draws; 0, the default, is none */
  uint32_t height_px;
  int32_t x_px; /* of the picture's first pixel in the attachments */
  int32_t y_px;
  /* Threshold, > 0, at most 1e6; default 2. The error of a cut at its size on screen, measured when the plant was baked, is the side of a
   * square of wholly wrong pixels that is as wrong as all its pixels together. 1: hard to tell from all leaves; 2: seen in a direct
   * comparison; 8: coarse, for shadows or slow devices. */
  float error_px;
  coppice_lod_mode lod;
  /* How much the view may draw, in leaves; 0: as much as error_px asks for, the default. The threshold rises above error_px, for all
   * instances alike and little by little, to 32 px at most, until what is drawn fits: a wood triangle counts as a leaf, a triangle that the
   * hardware draws as four more. It follows the counts of frames that the GPU has finished. Without COPPICE_LOD_CUT it is ignored. */
  uint32_t leaf_budget;
  coppice_debug_view debug_view; /* default none */

  /* Coarse leaves stand for several with gaps between them, and leave out some of their pixels. 0, the default: always the same pixels of a
   * leaf, so that a still picture stands still. Where the engine averages frames, as temporal antialiasing does: a number above 0 that is
   * another in each of them, such as a count of frames (it may begin again at 1 after 16 or more); each frame then leaves out other pixels,
   * and the average shows what lies behind. Not for shadow maps that are kept. */
  uint32_t temporal_frame;
  uint32_t layer_mask; /* instances whose layer_mask shares a bit with it are drawn and streamed; default COPPICE_ALL_LAYERS */

  /* Null, the default, or the other eye of a stereo pair; read within the call. Both eyes are culled and selected for at once: what one
   * of them sees, at its size from the middle between them, which light looks from too. So both show the same leaves. Both are
   * perspectives, mirrored or not alike, and pictures of width_px x height_px. Eyes may be turned against each other. */
  const coppice_eye* second_eye;
} coppice_camera;
static inline void coppice_camera_init(coppice_camera* camera) {
  coppice_struct_init(COPPICE_STRUCT_CAMERA, camera, sizeof *camera);
}

/* A square of the sun's view that holds a sphere, and what stands between it and the sun for three radii more. Radius and size must be set.
 */
typedef struct coppice_sun_desc {
  uint32_t struct_size;
  float sun_direction[3]; /* unit, towards the sun, world space; default 0 1 0 */
  double center[3];       /* world space, m, within 1e9 of 0 */
  float radius_m;         /* 1e-6 to 1e8 */
  uint32_t size_px;       /* 1 to what the device draws */
} coppice_sun_desc;
static inline void coppice_sun_desc_init(coppice_sun_desc* desc) {
  coppice_struct_init(COPPICE_STRUCT_SUN_DESC, desc, sizeof *desc);
}

/* Fills the camera of a view of COPPICE_OUTPUT_DEPTH: the sun's, orthographic. Its error_px is the default, in px of the map; size_px /
 * (2 radius_m) px are a metre. Depth runs as the view's depth_compare says, without a renderer from 0 at the near plane to 1. A centre that
 * moves by whole steps of the map keeps edges of shadows still.
 * camera: out; struct_size set, all else is overwritten: set error_px and layer_mask afterwards. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_sun_camera(const coppice_context* context, coppice_view view, const coppice_sun_desc* desc,
                                              coppice_camera* camera);

/* The wind that all plants of a context stand in. Where a place of a plant is depends on nothing but this and its place at rest, so that
 * every level of detail, and every view, has it at the same. Stems bend, boughs sway, leaves flutter, as far as the file says
 * (coppice bake --wind-stiffness); gusts travel. In a gale of 25 m/s nothing of a plant is moved by more than a twentieth of its bounding
 * sphere's radius, and stronger winds move it no further. */
typedef struct coppice_wind {
  uint32_t struct_size;
  /* Where it blows to, unit, world space: the direction of its level part; straight up or down is still air. Default 1 0 0. Gusts turn with
   * it, about where coordinates began: turn it slowly. */
  float direction[3];
  float speed;          /* m/s, 0 to 100; 0, the default, is still air: the picture is that without wind, to the bit */
  float gustiness;      /* 0 to 1: how far gusts depart from the mean; default 0.5 */
  double time_s;        /* from any moment on, 0 to 1e9; default 0 */
  double time_before_s; /* of the frame before: velocity is what has moved since, and by the wind of then. Default 0 */
  /* Velocities that are added to the wind: gusts, rotors, explosions. Null, the default: none, and the fields below are not looked at.
   * [map_height][map_width][2] x and z in world space, m/s, each within -100 to 100. A plant takes what is where it stands, linear between
   * places of the map and 0 outside it; the sum moves it no further than a gale would. Copied within the call, and kept for the velocities
   * of the frame after. Cost: 8 bytes a place in each frame on their way to the GPU, which keeps 1 MB from the first map on, and four loads
   * where a plant is moved. Where memory is short plants move without, and the log says so. */
  const float* map;
  double map_min[2];   /* world x and z of the map's first place, m; within 3.3e7 of the origin */
  double map_max[2];   /* of its last; above map_min by 1e-3 or more */
  uint32_t map_width;  /* places along x, 2 to 256 */
  uint32_t map_height; /* along z, the same */
  /* How far gusts have travelled, m, up to 1e11. An engine whose wind changes its speed adds speed * seconds to it each frame, so that
   * gusts go on from where they are. Below 0, the default: speed * time_s, for a wind that always blew alike. */
  double gusts_m;
} coppice_wind;
static inline void coppice_wind_init(coppice_wind* wind) {
  coppice_struct_init(COPPICE_STRUCT_WIND, wind, sizeof *wind);
}

#define COPPICE_GUST_WAVES 3u

typedef struct coppice_gust_wave {
  float x, z;  /* rad/m, along world x and z */
  float phase; /* rad, at the place asked for */
  float share; /* of all waves; they sum up to 1 */
} coppice_gust_wave;

/* A moment of a wind about a place, for what is not Coppice's and moves with plants: grass, cloth, smoke. At p, m from the place, things
 * bear the load
 *     load * (1 - gustiness * (0.5 - 0.5 * g)),    g = sum of share * sin(x * p.x + z * p.z + phase)
 * along `direction`. What coppice_wind.map adds is not in it. */
typedef struct coppice_gusts {
  uint32_t struct_size;
  float direction[3]; /* unit, level */
  float load;         /* 0 in still air, 1 in a gale of 25 m/s and beyond; grows slower than speed */
  float gustiness;
  coppice_gust_wave waves[COPPICE_GUST_WAVES];
} coppice_gusts;
static inline void coppice_gusts_init(coppice_gusts* gusts) {
  coppice_struct_init(COPPICE_STRUCT_GUSTS, gusts, sizeof *gusts);
}

/* The gusts of wind->time_s. place: world space, m; near what will be asked about, since phases are single precision.
 * gusts: out. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_wind_gusts(const coppice_context* context, const coppice_wind* wind, const double place[3],
                                              coppice_gusts* gusts);

typedef struct coppice_frame {
  uint32_t struct_size;
  uint64_t frame_number;         /* of the frame about to be recorded; grows by at least 1 each call, first is >= 1 */
  uint64_t completed_number;     /* GPU or host are done with every frame up to this; 0: none yet. Below frame_number, and never falls */
  const coppice_camera* cameras; /* [camera_count], one for each view that is drawn; read within the call */
  uint32_t camera_count;         /* may be 0: then nothing is drawn, and nothing wanted */
  uint32_t camera_bytes;    /* from one to the next: sizeof(coppice_camera) as the program was compiled with. coppice_frame_init sets it */
  const coppice_wind* wind; /* read within the call; null, the default: still air */
} coppice_frame;
static inline void coppice_frame_init(coppice_frame* frame) {
  coppice_struct_init(COPPICE_STRUCT_FRAME, frame, sizeof *frame);
  if (frame) frame->camera_bytes = sizeof(coppice_camera);
}

/* Collects finished reads and decodes, decides what to load and evict for all its views together, starts reads and jobs.
 * Streaming wants of a plant the most that any of the views wants. Views with colours are taken apart in three lots, in the order
 * of their creation, those of COPPICE_OUTPUT_DEPTH in one more; views of a lot are streamed for at the lowest threshold of them.
 * before: between frames; a frame that nothing was recorded of is one too
 * after: the frame is begun: with a renderer coppice_record_upload is next, without one coppice_next_change and coppice_get_draws
 * cost: streaming_ms at most for what came; measuring 100,000 instances 0.1 to 0.5 ms a view
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: then no frame is begun, and the one before goes on. COPPICE_ERROR_DEVICE_LOST */
COPPICE_API coppice_status coppice_frame_begin(coppice_context* context, const coppice_frame* frame);

/* ---- statistics ----------------------------------------------------------------------------------------------------------------- */

/* What coppice_view_stats.pass_ms has the times of; coppice_record_draw is the engine's to measure. */
typedef enum coppice_pass {
  COPPICE_PASS_UPLOAD = 0,
  COPPICE_PASS_CULL = 1,   /* blocks, instances, cuts, clusters */
  COPPICE_PASS_SPLATS = 2, /* leaves and wood of few pixels by compute shaders */
  COPPICE_PASS_LEAVES = 3, /* larger ones, likewise */
  COPPICE_PASS_TILES = 4,  /* depth of tiles, for occlusion */
  COPPICE_PASS_COUNT = 5,  /* of these, as the next one's below; later headers may have more */
  COPPICE_PASS_MAX_ENUM = 0x7fffffff
} coppice_pass;
#define COPPICE_MAX_PASSES 16u

/* What is streamed, in chunks that are counted apart. */
typedef enum coppice_streamed {
  COPPICE_STREAMED_PAGES = 0,       /* of foliage */
  COPPICE_STREAMED_WOOD = 1,        /* LoDs */
  COPPICE_STREAMED_TEXTURES = 2,    /* normal maps too */
  COPPICE_STREAMED_LEAF_MESHES = 3, /* parts of the leaves as modelled */
  COPPICE_STREAMED_ALL = 4,         /* sums of the others */
  COPPICE_STREAMED_COUNT = 5,
  COPPICE_STREAMED_MAX_ENUM = 0x7fffffff
} coppice_streamed;
#define COPPICE_MAX_STREAMED 8u

typedef struct coppice_streamed_stats {
  uint64_t loaded; /* since creation, as the next three */
  uint64_t evicted;
  uint64_t failed;    /* given up; the log says why */
  uint64_t cancelled; /* reads whose chunk nothing wanted any more when they returned */
  uint32_t in_flight; /* reading or decoding */
  uint32_t wanted;    /* by any view at its threshold_px, and not resident */
  uint32_t queued;    /* of those, not asked for yet */
} coppice_streamed_stats;

typedef struct coppice_stats {
  uint32_t struct_size;
  uint32_t instance_count;
  uint64_t source_leaf_count; /* sum over all instances */
  uint64_t memory_budget_bytes;
  uint64_t memory_bytes; /* in use now: GPU, staging and decoded pages; of device memory whole blocks, and the next one */
  uint64_t memory_peak_bytes;
  uint64_t device_allocations; /* blocks of device memory that are held now: calls of coppice_device_memory.allocate less those of free */
  coppice_streamed_stats streamed[COPPICE_MAX_STREAMED]; /* by coppice_streamed; what is none of them is 0 */
  uint64_t bytes_read;                                   /* since creation, after opening */
  double decode_ms;                                      /* since creation, CPU time of decoding added up over all threads */
  uint32_t pipelines_wanted;                             /* since creation; see coppice_pipelines_ready */
  uint32_t pipelines_built;                              /* of those: what the others draw is missing */

  /* Sums over the open scenes; all zero without one. */
  uint64_t scene_instance_count; /* in the file; instance_count has those that are there */
  uint32_t scene_tile_count;
  uint32_t scene_tiles_resident;
  uint32_t scene_tiles_wanted;  /* by the view, resident or not */
  uint32_t scene_tiles_missing; /* wanted, not resident, and not given up as damaged */
  uint32_t scene_tiles_failed;
  uint32_t scene_species_failed; /* plants that it names, but that could not be opened or may not be: their instances are left out */
  float scene_threshold_px;      /* the largest; above 1 where not all that is larger than a pixel fits */

  float longest_pipeline_ms;    /* of the pipelines_built, the one that took longest to create; see coppice_vulkan_desc.pipeline_cache */
  const char* longest_pipeline; /* names its first shader; static storage; null before the first */
  double pipelines_ms;          /* time of their creation, added up over all threads */
  const char* missing_pipeline; /* of those wanted and not built the first, named likewise; null: all are built */
} coppice_stats;
static inline void coppice_stats_init(coppice_stats* stats) {
  coppice_struct_init(COPPICE_STRUCT_STATS, stats, sizeof *stats);
}
/* stats: out. before: any time; figures are as of the last coppice_frame_begin, or newer. thread: as coppice_scene_get_info.
 * cost: some 0.1 us a plant that is open */
COPPICE_API coppice_status coppice_get_stats(const coppice_context* context, coppice_stats* stats);

/* Of a view. */
typedef struct coppice_view_stats {
  uint32_t struct_size;
  uint32_t visible_instance_count;
  uint32_t occluded_instance_count;  /* in view, but hidden by others: with compute_raster; the rest is outside the view */
  uint32_t leaf_mesh_instance_count; /* visible instances that are drawn with their leaves as modelled, not as quads */
  uint64_t gpu_frame_number;         /* the frame that these figures are of: the latest completed one that culled the view; 0: none yet */
  uint64_t drawn_leaf_count;
  uint64_t drawn_wood_triangle_count;
  uint64_t drawn_leaf_mesh_triangle_count;
  float threshold_px; /* that decides what is loaded: the view's error_px, or higher where what that asks for does not fit the leaf budget,
                         and then it decides what is drawn too, or the memory budget; 0: every leaf. Of the last frame that showed it */
  float pass_ms[COPPICE_MAX_PASSES]; /* by coppice_pass: GPU time of a recent frame, the upload's that of all views; 0 without pass_times */
} coppice_view_stats;
static inline void coppice_view_stats_init(coppice_view_stats* stats) {
  coppice_struct_init(COPPICE_STRUCT_VIEW_STATS, stats, sizeof *stats);
}
/* stats: out; all 0 of a view that no frame has shown. before, thread: as coppice_get_stats */
COPPICE_API coppice_status coppice_get_view_stats(const coppice_context* context, coppice_view view, coppice_view_stats* stats);

/* ---- hosts that draw themselves -------------------------------------------------------------------------------------------------- */

/* What a host of coppice_context_create does in a frame:
 *
 *     coppice_frame_begin(context, &frame);                with the cameras of all views; completed_number: frames that it has drawn
 *     coppice_change_init(&change);
 *     while (coppice_next_change(context, &change) == COPPICE_OK && change.kind != COPPICE_CHANGE_NONE)
 *       coppice_confirm(context, &change, outcome);        now or in a later frame, once it has copied or freed what change is about
 *     coppice_get_draws(context, view, draws, ...);        of each view: what to draw of which plant, and where
 *     coppice_write_leaves(context, file, leaf_count, ...) for hosts that draw leaves as triangles; others draw the nodes
 *
 * A plant is known to it by its *file*: a number that the plant's first change says, below max_plants + 4, and that changes when the plant
 * is reloaded: chunks and draws are of a file. Numbers are given out again after COPPICE_CHANGE_PLANT_CLOSED. Take the changes before you
 * ask for draws, or a draw may be of a file that you have not heard of. */

/* A leaf quad, a node of the plant's tree of leaves; node 0, the root, is coppice_file_info.root. Split s replaces a node by nodes 2s + 1
 * and 2s + 2. The cut of m leaves is the nodes below 2m - 1 that no split below m - 1 replaces: m of them. */
typedef struct coppice_leaf_node {
  uint16_t corners[4][3]; /* in ring order: position = box_min + box_step * corner, object space, m. 0 and 3 are at the stalk, 1 and 2 at
                             the tip; triangles (0, 1, 2) and (0, 2, 3). Corner i shows coppice_card.uv[i] */
  uint8_t card;
  uint8_t fade;      /* low four bits: sixteenths of its pixels that are shown, less one; high four: brightness b, which multiplies linear
                        colour by ((8 + b) / 16)^2 */
  uint16_t reserved; /* whatever it is */
  uint32_t split;    /* that replaces it; 0xffffffff: none */
} coppice_leaf_node;

/* Of wood and of leaves as they were modelled. */
typedef struct coppice_mesh_vertex {
  float position[3]; /* object space, m */
  float normal[3];   /* unit */
  float uv[2];
  uint32_t material;
} coppice_mesh_vertex;

typedef enum coppice_change_kind {
  COPPICE_CHANGE_NONE = 0,
  COPPICE_CHANGE_PLANT_OPENED = 1,  /* chunks of the file follow. Needs no confirmation */
  COPPICE_CHANGE_PLANT_CLOSED = 2,  /* all its chunks have been freed. Needs no confirmation */
  COPPICE_CHANGE_CHUNK_ADDED = 3,   /* to be copied. It counts as there once it is confirmed: draws name it from then on */
  COPPICE_CHANGE_CHUNK_DROPPED = 4, /* no draw names it any more. Its memory counts towards the budget until it is confirmed */
  COPPICE_CHANGE_KIND_MAX_ENUM = 0x7fffffff
} coppice_change_kind;

typedef struct coppice_change {
  uint32_t struct_size;
  coppice_change_kind kind;
  coppice_plant plant; /* the handle may have been closed since */
  uint32_t file;
  /* Of chunks, as the rest; what does not belong to the kind of chunk is 0. */
  coppice_streamed chunk;  /* COPPICE_STREAMED_PAGES, _WOOD, _TEXTURES, _LEAF_MESHES */
  uint32_t index;          /* among those of its kind: a page, a wood LoD (0 is the finest), a texture, a part of the leaves as modelled */
  uint32_t texture_format; /* coppice_texture_format of coppice/format.h */
  /* What a chunk that was added consists of; null where it was dropped. Valid until it is confirmed, aligned to 4 bytes.
   *   page               coppice_leaf_node[node_count], nodes first_node and on. Pages come in order: what is there is a prefix
   *   wood, leaf mesh    coppice_mesh_vertex[vertex_count], then uint32_t[index_count], three a triangle
   *   texture            mip_count levels of texels, largest first, tightly packed; a level's sides are half of those before, at least 1.
   *                      The first row is that of v = 0, glTF's uppermost. A normal map is a picture too: with alpha a and green g as
   *                      sampled, g from sRGB to linear, the normal is x = 2a - 1 along u, y = 2g - 1 against v, z out of the surface */
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

/* Takes the next change: what has been opened, closed or dropped in the order in which that happened, then chunks that were added, those
 * that are worth most first, of each plant one page at a time. kind is COPPICE_CHANGE_NONE when there is none. A plant's chunks are dropped
 * in a frame at which none of its reads and jobs is under way; that it is closed comes a frame after the last of them is confirmed.
 * before: any time; most changes appear with coppice_frame_begin, the next page of a plant with coppice_confirm. cost: a look at each chunk
 * of each open plant. errors: COPPICE_ERROR_INVALID_ARGUMENT, also where the context has a renderer */
COPPICE_API coppice_status coppice_next_change(coppice_context* context, coppice_change* change);

typedef enum coppice_outcome {
  COPPICE_OUTCOME_TAKEN = 0,  /* of a chunk that was added: the host has it, `bytes` are not looked at any more */
  COPPICE_OUTCOME_FAILED = 1, /* likewise: it had no room. Asked for again after half a second of frames */
  COPPICE_OUTCOME_FREED = 2,  /* of one that was dropped */
  COPPICE_OUTCOME_MAX_ENUM = 0x7fffffff
} coppice_outcome;

/* Says what has become of a chunk. change: as coppice_next_change has filled it; kind, file, chunk and index are looked at. Plants that
 * were opened or closed need it not: nothing happens then. Chunks that nobody
 * confirms are held, and counted, for as long; a plant that was closed keeps its file's number until all its chunks are confirmed.
 * before: the change was taken. errors: COPPICE_ERROR_INVALID_ARGUMENT: the chunk does not wait for this outcome; the log says for what */
COPPICE_API coppice_status coppice_confirm(coppice_context* context, const coppice_change* change, coppice_outcome outcome);

/* What does not change while a file is open. */
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
/* file: of a change or a draw, as below. before: any time, with a renderer too. thread: as coppice_scene_get_info */
COPPICE_API coppice_status coppice_file_get_info(const coppice_context* context, uint32_t file, coppice_file_info* info);

#define COPPICE_NONE 0xffffffffu

typedef struct coppice_material {
  uint32_t struct_size;
  float base_color[4]; /* linear; multiplies the texture */
  float alpha_cutoff;  /* 0: opaque; otherwise texels of smaller alpha are holes */
  float roughness;     /* 0 to 1 */
  float crown_normals; /* how far its leaves' normals turn to the crown's, 0 to 1 */
  uint32_t texture;    /* of base colour, sRGB; COPPICE_NONE: it has none. Both sides are shown, of wood too: do not cull */
  uint32_t normal_map; /* a texture, see coppice_change.bytes; COPPICE_NONE: it has none */
} coppice_material;
static inline void coppice_material_init(coppice_material* material) {
  coppice_struct_init(COPPICE_STRUCT_MATERIAL, material, sizeof *material);
}
/* index: < coppice_file_info.material_count. before, thread: as coppice_file_get_info */
COPPICE_API coppice_status coppice_file_get_material(const coppice_context* context, uint32_t file, uint32_t index,
                                                     coppice_material* material);

/* What a leaf quad shows. */
typedef struct coppice_card {
  uint32_t struct_size;
  uint32_t material;
  float uv[4][2];  /* by corner, of the material's texture */
  float albedo[3]; /* from afar, in place of the texture: the mean colour of what is no hole, linear, base_color included */
  float coverage;  /* share that is no hole */
} coppice_card;
static inline void coppice_card_init(coppice_card* card) {
  coppice_struct_init(COPPICE_STRUCT_CARD, card, sizeof *card);
}
/* index: < coppice_file_info.card_count. before, thread: as coppice_file_get_info */
COPPICE_API coppice_status coppice_file_get_card(const coppice_context* context, uint32_t file, uint32_t index, coppice_card* card);

/* What to draw of an instance in a view. world = position + rotation * (scale * object). */
typedef struct coppice_draw {
  coppice_plant plant;
  coppice_instance instance; /* 0: a scene's */
  coppice_scene_tree tree;   /* which; 0 of the engine's own */
  uint32_t file;
  float leaf_count;     /* the cut is ceil(leaf_count * 0.999999) leaves; changes evenly with distance. 0: leaf meshes are drawn instead */
  uint32_t node_end;    /* the cut's nodes are below it: 2 m - 1 */
  uint32_t wood_lod;    /* COPPICE_NONE: no wood */
  uint32_t leaf_meshes; /* COPPICE_TRUE: all chunks of COPPICE_STREAMED_LEAF_MESHES in place of quads */
  uint32_t user_data;   /* of its placement, as what follows */
  double position[3];   /* world space, m; counts from coppice_set_origin's origin */
  float scale;          /* below 0: mirrored */
  float rotation[4];    /* unit quaternion x y z w */
  float tint[3];        /* multiplies leaf colour */
  float leaf_share;  /* the host's to apply: leaf_count and coppice_write_leaves are of all leaves. Our renderer leaves out single leaves by
                        a hash, and scales the area of merged ones; no host matches it leaf by leaf */
  uint32_t reserved; /* 0 */
} coppice_draw;

/* The instances in the view's frustum, with what its threshold asks for as far as it is there: of a context with a renderer as of the
 * last coppice_record_upload, else of what has been confirmed.
 * draws: [capacity] `draw_bytes` apart, which is sizeof(coppice_draw) as the program was compiled with; may be null where capacity is 0
 * count: out, how many there are; those beyond capacity are left out, and nothing else happens
 * before: coppice_frame_begin with a camera of the view. thread: calls for different views may overlap.
 * cost: some 40 ns a draw */
COPPICE_API coppice_status coppice_get_draws(coppice_context* context, coppice_view view, coppice_draw* draws, uint32_t capacity,
                                             uint32_t draw_bytes, uint32_t* count);

typedef enum coppice_leaf_color {
  COPPICE_LEAF_COLOR_FLOAT4 = 0,
  COPPICE_LEAF_COLOR_UNORM8X4 = 1, /* bytes r, g, b, a; what is above 1 becomes 1 */
  COPPICE_LEAF_COLOR_MAX_ENUM = 0x7fffffff
} coppice_leaf_color;

/* Where in a vertex of the host's what is: offsets in bytes, COPPICE_NONE for what it has not, which is the default of all. */
typedef struct coppice_leaf_layout {
  uint32_t struct_size;
  uint32_t vertex_bytes; /* from one vertex to the next */
  uint32_t position;     /* float3, object space, m */
  uint32_t normal;       /* float3, of the quad, unit; 0 0 0 where it has no area */
  uint32_t uv;           /* float2 */
  uint32_t color;    /* as color_format: base_color times brightness, at most 2.07, without tint and texture, linear; alpha: share of its
                        pixels that are shown */
  uint32_t material; /* uint32_t */
  coppice_leaf_color color_format;
  uint32_t index_bytes; /* 4, the default, or 2 */
} coppice_leaf_layout;
static inline void coppice_leaf_layout_init(coppice_leaf_layout* layout) {
  coppice_struct_init(COPPICE_STRUCT_LEAF_LAYOUT, layout, sizeof *layout);
}

typedef struct coppice_leaf_output {
  uint32_t struct_size;
  uint32_t vertex_capacity; /* of vertices: four a leaf */
  void* vertices;
  void* indices;
  uint32_t index_capacity; /* of indices: six a leaf, counter-clockwise from the front: (0, 1, 2) and (0, 2, 3) */
  uint32_t vertex_count;   /* out, here and below: what the cut needs, written or not */
  uint32_t index_count;
  uint32_t leaf_count;
} coppice_leaf_output;
static inline void coppice_leaf_output_init(coppice_leaf_output* output) {
  coppice_struct_init(COPPICE_STRUCT_LEAF_OUTPUT, output, sizeof *output);
}

/* Writes a cut's leaves as triangles, in the order of their nodes, in the host's layout. leaf_count: of a draw, or any number above 0;
 * it is rounded as coppice_draw.leaf_count says, and clamped to the leaves that are there: those of confirmed pages, whose nodes Coppice
 * keeps as long as they are, or of those that our renderer has. Where a capacity is too small, or both are 0, nothing is written and the
 * counts say what is needed. What the layout does not mention stays as it is.
 * before: any time, with a renderer too. thread: as coppice_scene_get_info. cost: some 10 ns a node below 2 m - 1.
 * errors: COPPICE_ERROR_INVALID_ARGUMENT: no open file; an offset whose attribute does not fit vertex_bytes, or not at a multiple of 4;
 * too many vertices for 2 bytes of index; a null pointer */
COPPICE_API coppice_status coppice_write_leaves(const coppice_context* context, uint32_t file, float leaf_count,
                                                const coppice_leaf_layout* layout, coppice_leaf_output* output);

#ifdef __cplusplus
}
#endif

#endif
