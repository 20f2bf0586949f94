#ifndef COPPICE_HOOKS_H
#define COPPICE_HOOKS_H

/* What an engine may give the library in place of its own: memory, jobs, files, a log, a trace. coppice.h says what holds for all. */

#include <coppice/base.h>

#ifdef __cplusplus
extern "C" {
#endif

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

typedef enum coppice_job_kind {
  COPPICE_JOB_DECODE = 0,   /* decodes chunks, the first parts of a plant, or a tile: up to some ten milliseconds */
  COPPICE_JOB_PIPELINE = 1, /* builds a pipeline: up to a second in the driver, more if the processor does the GPU's work */
  COPPICE_JOB_KIND_MAX_ENUM = 0x7fffffff
} coppice_job_kind;

typedef enum coppice_priority {
  COPPICE_PRIORITY_LOW = 0,    /* pipelines */
  COPPICE_PRIORITY_NORMAL = 1, /* finer detail of a plant that is shown already */
  COPPICE_PRIORITY_HIGH = 2,   /* plants and tiles of which nothing can be shown without it */
  COPPICE_PRIORITY_MAX_ENUM = 0x7fffffff
} coppice_priority;

/* The library sets struct_size. */
typedef struct coppice_job {
  uint32_t struct_size;
  coppice_job_kind kind;
  coppice_priority priority;
  uint32_t reserved; /* 0 */
  void (*function)(void* argument);
  void* argument;
} coppice_job;

/* Runs decoding and the building of pipelines. submit may run job->function(job->argument) on any thread, or inline before it returns,
 * which makes tests deterministic. `job` is valid during the call. Every submitted function must run, once: coppice_context_destroy waits
 * for them. submit must not call back into Coppice except through the function.
 * A pool may ignore kind and priority. While decoding waits for a thread the library submits no pipelines, and a queued one returns at once
 * and is submitted again later. However much decoding waits, a pipeline is built every half a second. A pool that has priorities runs
 * higher ones first.
 * thread: the one inside the function that creates a context, coppice_frame_begin, coppice_record_upload or coppice_record_cull, or any
 * that runs a job. */
typedef struct coppice_jobs {
  uint32_t struct_size;
  void* user;
  void (*submit)(void* user, const coppice_job* job);
} coppice_jobs;
static inline void coppice_jobs_init(coppice_jobs* hook) {
  coppice_struct_init(COPPICE_STRUCT_JOBS, hook, sizeof *hook);
}

/* Gives access to files.
 *   open   returns a handle >= 0, or a failure: -errno, which the log spells out, or -1 if the reason is unknown. It returns -EINVAL for
 *          anything but a regular file
 *   read   must not block. It calls done(argument, bytes_read) once, from any thread, or inline. Fewer bytes than `bytes`, or a failure as
 *          of open, is retried after 50, 200 and 800 ms while frames go on; then the chunk (coppice_retry_failed), or the opening, has
 *          failed. `destination` stays valid until done is called. coppice_plant_open and coppice_scene_open wait for their reads, so
 *          done must not depend on the calling thread
 *   close  is called once the plant or scene is closed and none of its reads is in flight
 *   cancel may be null, the default. It says that nobody needs the bytes of the read that was given this argument. done must still be
 *          called once, soon, with any result, for example -ECANCELED. If it has been called already, ignore the call; it must not block
 * thread: the one inside coppice_plant_open, coppice_plant_reload, coppice_plant_close, coppice_scene_open, coppice_scene_close,
 * coppice_frame_begin or coppice_context_destroy. */
typedef struct coppice_io {
  uint32_t struct_size;
  void* user;
  int64_t (*open)(void* user, const char* path, uint64_t* file_bytes); /* file_bytes: out, the file's size */
  void (*close)(void* user, int64_t file);
  void (*read)(void* user, int64_t file, uint64_t offset, void* destination, size_t bytes, void (*done)(void* argument, int64_t bytes_read),
               void* argument);
  void (*cancel)(void* user, int64_t file, void* argument);
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
  COPPICE_TRACE_UPLOAD = 2,      /* a chunk or a part of one, within COPPICE_TRACE_RECORD_UPLOAD */
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
  uint64_t bytes;    /* bytes in the file; for an upload, bytes of the part for the GPU */
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

#ifdef __cplusplus
}
#endif

#endif
