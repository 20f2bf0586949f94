#ifndef COPPICE_FORMAT_H
#define COPPICE_FORMAT_H

/* The .coppice file, version 9: disk structs and limits only. runtime/src/format/FORMAT.md describes it in prose.
 *
 * The file is little-endian. Every struct below is stored as is, without padding. Offsets count from the start of the file. Lengths are in
 * metres, axes are glTF's (right-handed, +Y up).
 *
 *     header | chunk table | PLANT MATERIALS CARDS ERRORS WIND (LEAF_MESHES) (TEXTURES) | coarsest WOOD | PAGE 0 |
 *     '------------------------- first_read_bytes: everything that a first picture needs -----------------------'
 *                                                     (TEXTURE ...) | finer WOOD ... | PAGE 1 2 3 ... | (LEAF_MESH ...) */

#include <stdint.h>

#define COPPICE_FORMAT_MAGIC "COPPICE\x1a" /* 8 bytes, no terminating zero in the file */
#define COPPICE_FORMAT_VERSION 9u

/* Splits per foliage page. Page k holds splits [k * this, min((k + 1) * this, leaf_count - 1)). */
#define COPPICE_PAGE_SPLITS 512u
/* A quantised coordinate q in [0, max] is at box_min + q / max * (box_max - box_min). max is this, or COPPICE_FINE_QUANTISED_MAX if
 * coppice_file_plant.fine_positions is 1. */
#define COPPICE_QUANTISED_MAX 16383u
#define COPPICE_FINE_QUANTISED_MAX 32767u
#define COPPICE_NO_TEXTURE 0xffffffffu
/* The same for the 16 bits in a material. */
#define COPPICE_FILE_NO_TEXTURE 0xffffu

/* A reader enforces these limits before it trusts a count. */
#define COPPICE_MAX_LEAVES (1u << 26)
#define COPPICE_MAX_MATERIALS 256u
#define COPPICE_MAX_CARDS 256u
#define COPPICE_MAX_TEXTURES 256u
#define COPPICE_MAX_TEXTURE_SIDE 4096u
#define COPPICE_MAX_WOOD_LODS 8u
#define COPPICE_MAX_WOOD_TRIANGLES (1u << 24)
#define COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE 8u /* for a WOOD chunk: the coding takes at least one bit for each */
#define COPPICE_MAX_ERROR_LEVELS 32u
#define COPPICE_MAX_ERROR_SIZES 16u
#define COPPICE_MAX_PAGE_BYTES 65536u
#define COPPICE_MAX_LEAF_MESHES 16u
#define COPPICE_MAX_LEAF_MESH_TRIANGLES (1u << 16) /* for one LEAF_MESH chunk; per byte the limit is that of wood */

#define COPPICE_MAX_SMALL_TEXTURE_SIDE 64u

/* Maximum of nodes along each axis of a WIND chunk's grid. */
#define COPPICE_MAX_WIND_SIDE 8u
/* Limits of motion in full wind: how far any point moves, as a share of sphere_radius; bend_m as a share of height_m; and how much lean and
 * sway move two points against each other, as a share of their distance. */
#define COPPICE_MAX_WIND_MOVE 0.8
#define COPPICE_MAX_WIND_BEND 0.4
#define COPPICE_MAX_WIND_GROWTH 0.08
/* Limits of natural periods, in seconds. */
#define COPPICE_MIN_WIND_PERIOD_S 0.1f
#define COPPICE_MAX_WIND_PERIOD_S 60.0f

/* A writer makes small textures smaller if the TEXTURES chunk would be longer than this. */
#define COPPICE_SMALL_TEXTURES_BYTES 16384u
/* A writer keeps first_read_bytes at or below this, except for plants of some million leaves, whose chunk table alone is longer. */
#define COPPICE_FIRST_READ_BYTES 65536u

/* Bytes [0, 64). */
typedef struct coppice_file_header {
  uint8_t magic[8];
  uint32_t version;
  uint32_t chunk_count;      /* entries in the chunk table, which starts at byte 64 */
  uint64_t file_bytes;       /* size of the whole file */
  uint64_t first_read_bytes; /* a prefix of this length holds everything up to and including PAGE 0 */
  uint64_t table_checksum;   /* XXH3-64 of the chunk table */
  uint64_t reserved[2];      /* zero */
  uint64_t header_checksum;  /* XXH3-64 of bytes [0, 56) */
} coppice_file_header;

typedef enum coppice_chunk_kind {
  COPPICE_CHUNK_PLANT = 1,       /* one coppice_file_plant */
  COPPICE_CHUNK_MATERIALS = 2,   /* coppice_file_material[material_count] */
  COPPICE_CHUNK_CARDS = 3,       /* coppice_file_card[card_count] */
  COPPICE_CHUNK_ERRORS = 4,      /* the error table, see coppice_file_plant */
  COPPICE_CHUNK_WOOD = 5,        /* wood LoD `index`, 0 is the finest; a Draco triangle mesh */
  COPPICE_CHUNK_PAGE = 6,        /* foliage page `index`; its splits, entropy-coded */
  COPPICE_CHUNK_TEXTURE = 7,     /* texture `index`: coppice_file_texture and its mip levels, largest first, tightly packed */
  COPPICE_CHUNK_LEAF_MESHES = 8, /* the sizes of the LEAF_MESH chunks, see coppice_file_leaf_mesh; only if there are any */
  COPPICE_CHUNK_LEAF_MESH = 9,   /* some of the leaves as they were modelled; a Draco triangle mesh */
  COPPICE_CHUNK_TEXTURES = 10,   /* the sizes of the TEXTURE chunks, see coppice_file_texture; only if there are any */
  COPPICE_CHUNK_WIND = 11,       /* coppice_file_wind, then coppice_file_wind_node[node_side^3] */
  COPPICE_CHUNK_KIND_MAX_ENUM = 0x7fffffff
} coppice_chunk_kind;

/* An entry of the chunk table. Entries are in file order, chunks do not overlap. The PAGE entries are the page index. */
typedef struct coppice_file_chunk {
  uint32_t kind; /* coppice_chunk_kind */
  uint32_t index;
  uint64_t offset;
  uint64_t bytes;
  uint64_t checksum; /* XXH3-64 of the chunk's bytes */
} coppice_file_chunk;

/* The metric that orders the collapses. */
typedef enum coppice_metric {
  COPPICE_METRIC_MI = 1,        /* the paper: viewpoint mutual information, Algorithm 1 */
  COPPICE_METRIC_GEOMETRIC = 2, /* greedy geometric similarity */
  COPPICE_METRIC_IMAGE = 3,     /* least squared error of the shaded picture against the source plant's */
  COPPICE_METRIC_MAX_ENUM = 0x7fffffff
} coppice_metric;

typedef struct coppice_file_plant {
  uint32_t leaf_count; /* N >= 1; the tree has 2N - 1 nodes and N - 1 splits */
  uint32_t page_count; /* ceil((N - 1) / COPPICE_PAGE_SPLITS) */
  uint32_t material_count;
  uint32_t card_count; /* >= 1 */
  uint32_t texture_count;
  uint32_t wood_lod_count; /* 0 for a plant without wood */
  uint32_t error_level_count;
  uint32_t error_size_count;
  float leaf_box_min[3]; /* quantisation box of every leaf vertex */
  float leaf_box_max[3];
  float sphere_center[3]; /* bounds leaves and wood */
  float sphere_radius;
  uint16_t root_quad[4][3]; /* node 0, quantised in the leaf box */
  uint8_t root_card;
  uint8_t root_opacity;  /* sixteenths, 1..16; 16 if leaf_count is 1 */
  uint16_t root_normals; /* FORMAT.md, section 8: bits 0..9 axis, 10..13 along, 14 and 15 side */
  /* The size of each wood LoD after decoding, so that a reader can reserve its memory; 0 from wood_lod_count on. */
  uint32_t wood_vertex_counts[COPPICE_MAX_WOOD_LODS];   /* <= 3 * triangles */
  uint32_t wood_triangle_counts[COPPICE_MAX_WOOD_LODS]; /* <= COPPICE_MAX_WOOD_TRIANGLES, non-increasing */
  uint32_t metric;                                      /* coppice_metric */
  uint16_t leaf_mesh_count;                             /* number of LEAF_MESH chunks; 0: nothing is finer than the quads */
  uint16_t fine_positions;                              /* 1: coordinates have 15 bits instead of 14; only without leaf meshes */
  char name[64];                                        /* UTF-8, zero-terminated */
} coppice_file_plant;

#define COPPICE_MATERIAL_DOUBLE_SIDED 1u
/* Only LEAF_MESH chunks use the material. */
#define COPPICE_MATERIAL_LEAF_MESH_ONLY 2u
/* The normals of LEAF_MESH vertices of the material say which side is lit, whoever looks; otherwise the side that the eye sees is. */
#define COPPICE_MATERIAL_SIDED_NORMALS 4u

typedef struct coppice_file_material {
  float base_color[4];          /* linear RGBA factor, multiplies the texture */
  float alpha_cutoff;           /* 0: opaque; otherwise texels of smaller alpha are holes */
  float roughness;              /* 0..1 */
  uint16_t texture_or_none;     /* index of the base colour texture, or COPPICE_FILE_NO_TEXTURE */
  uint16_t normal_map_plus_one; /* index of the normal map plus one; 0: none */
  uint32_t flags;
} coppice_file_material;

/* Says what a leaf quad shows: corner i of the quad shows texture coordinate uv[i] of the material's texture. */
typedef struct coppice_file_card {
  uint32_t material;
  float uv[4][2];
  /* These replace the texture at a distance. albedo is the mean colour outside holes, sRGB, base_color included. mask is the outline in 8 x
   * 8 cells, row by row from corner 0, x towards corner 1 and y towards corner 3: bit x + 8 (y % 4) of word y / 4 is set if the cell holds
   * leaf. */
  uint8_t albedo[3];
  uint8_t reserved; /* 0 */
  uint32_t mask[2]; /* not both 0 */
} coppice_file_card;

/* ERRORS chunk: uint32_t leaf_counts[levels], ascending, first 1, last N; float sizes_px[sizes], ascending;
 * float error_px[levels][sizes], >= 0, non-increasing along a column; float wood_error_px[wood_lod_count][sizes], >= 0,
 * non-decreasing along a column: the error of each wood LoD against the finest. sizes_px is the projected diameter of the bounding
 * sphere. */

/* WIND chunk: says how wind moves the plant. Let w be the wind's horizontal direction and s the height above base_y_m divided by height_m,
 * 0..1. A point moves by w bend_m s^2 and down by 2/3 bend_m^2 / height_m s^3, so that a stem keeps its length; by w lean_m lean, and by
 * sway_m (sway_cos, sway_sin) as the two phases of a swing. lean, sway_cos and sway_sin are trilinear between the nodes of the grid; a
 * point outside the box takes those of the box's nearest point. */
typedef struct coppice_file_wind {
  float base_y_m;        /* height of the plant's base */
  float height_m;        /* >= 1e-30: from the base to the top */
  float bend_m;          /* how far the bending stem moves the top in full wind, 25 m/s; >= 0, as are the next two */
  float lean_m;          /* the length of a lean of 1 */
  float sway_m;          /* the length of a sway of 1 */
  float stem_period_s;   /* natural period of the stem */
  float branch_period_s; /* natural period of the branches */
  float box_min[3];      /* the grid's box; below box_max on every axis */
  float box_max[3];
  uint32_t node_side; /* n: 0, 2, 4 or 8; 0: no grid, lean_m and sway_m are 0 */
} coppice_file_wind;

/* Node order: x fastest, then y, then z. Node i of an axis is at box_min + i / (n - 1) (box_max - box_min). */
typedef struct coppice_file_wind_node {
  uint8_t lean;     /* 0..255 stand for 0..1 */
  int8_t sway_cos;  /* -127..127 stand for -1..1 */
  int8_t sway_sin;  /* the same */
  uint8_t reserved; /* 0 */
} coppice_file_wind_node;

/* LEAF_MESHES chunk: one of these for each LEAF_MESH; then float error_px[error_size_count], >= 0, not falling: the error of all leaf quads
 * against the leaf meshes at the error table's sizes. */
typedef struct coppice_file_leaf_mesh {
  uint32_t vertex_count;   /* <= 3 * triangles */
  uint32_t triangle_count; /* <= COPPICE_MAX_LEAF_MESH_TRIANGLES */
} coppice_file_leaf_mesh;

/* Says how texels are stored. Colour is sRGB, alpha is linear. A block has 4 x 4 texels; the last blocks of a row or column reach beyond
 * the level if its side is no multiple of 4. */
typedef enum coppice_texture_format {
  COPPICE_TEXTURE_RGBA8 = 1, /* 4 bytes a texel */
  COPPICE_TEXTURE_BC3 = 2,   /* 16 bytes a block */
  COPPICE_TEXTURE_BC1 = 3,   /* 8 bytes a block, alpha is 1 */
  COPPICE_TEXTURE_FORMAT_MAX_ENUM = 0x7fffffff
} coppice_texture_format;

/* TEXTURES chunk: for each TEXTURE a copy of the struct that it begins with. Then, for each texture that is a material's base colour,
 * lowest index first, a small version of at most COPPICE_MAX_SMALL_TEXTURE_SIDE: this struct with mip_count 1, and its texels. */
typedef struct coppice_file_texture {
  uint32_t width;
  uint32_t height;
  uint32_t mip_count;
  uint32_t format; /* coppice_texture_format */
} coppice_file_texture;

#endif
