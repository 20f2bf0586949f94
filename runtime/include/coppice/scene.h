#ifndef COPPICE_SCENE_H
#define COPPICE_SCENE_H

/* Scenes, whose plants the library places, and picking. coppice.h says what holds for all. */

#include <coppice/context.h>

#ifdef __cplusplus
extern "C" {
#endif

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
 * Near tiles grow up over 16 frames (coppice_instances_fade_in). A settled picture does not depend on the order in which tiles arrived.
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

#ifdef __cplusplus
}
#endif

#endif
