#ifndef COPPICE_BASE_H
#define COPPICE_BASE_H

/* Version, errors, structs that grow, and handles. coppice.h says what holds for all. */

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

/* Names the structs for coppice_struct_init. */
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

#ifdef __cplusplus
}
#endif

#endif
