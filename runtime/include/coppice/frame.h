#ifndef COPPICE_FRAME_H
#define COPPICE_FRAME_H

/* Views, frames, and statistics. coppice.h says what holds for all. */

#include <coppice/context.h>

#ifdef __cplusplus
extern "C" {
#endif

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
 * been opened, tiles of scenes are loaded, plants that fade in have grown up, and chunks are loaded. coppice_view_stats.threshold_px has
 * also come to rest then. Changes since that frame, and pipelines (coppice_pipelines_ready), do not count. COPPICE_FALSE for a view that
 * the last frame did not show.
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
   * coppice_vulkan_view_desc.depth_compare says: by default it is reversed, 1 near and 0 far. The far plane may be infinitely far, as with
   * the third row (0, 0, 0, near) of reversed depth. Without a renderer the directions of depth and y do not matter. In an orthographic
   * view sizes do not depend on distance, and fog begins at the plane of the eye. */
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
 * cost: streaming_ms at most for finished reads; measuring 100,000 instances takes 0.1 to 0.5 ms a view once they are sorted. Sorting takes
 * 0.1 ms while it has something to do: 100,000 in random order are sorted after some 450 frames
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
  uint64_t failed;    /* given up; the log says why. See coppice_retry_failed */
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

#ifdef __cplusplus
}
#endif

#endif
