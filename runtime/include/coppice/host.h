#ifndef COPPICE_HOST_H
#define COPPICE_HOST_H

/* What a host that draws itself is given: changes, and draws. coppice.h says what holds for all. */

#include <coppice/frame.h>
#include <coppice/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

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
