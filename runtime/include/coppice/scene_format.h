#ifndef COPPICE_SCENE_FORMAT_H
#define COPPICE_SCENE_FORMAT_H

/* The .forest file, version 1, says where plants stand: disk structs and limits only. runtime/src/scene/SCENE.md describes it in prose.
 *
 * The file is little-endian. Every struct below is stored as is, without padding. Lengths are in metres, axes are glTF's (right-handed, +Y
 * up).
 *
 *     header | species[species_count] | paths | tiles[tile_count] | instances of tile 0 | of tile 1 | ...
 *     '------------------ the front, read at once ---------------' */

#include <stdint.h>

#define COPPICE_SCENE_MAGIC "FOREST\x1a\n" /* 8 bytes, no terminating zero in the file */
#define COPPICE_SCENE_VERSION 1u

/* A reader enforces these limits before it trusts a count. */
#define COPPICE_MAX_SCENE_SPECIES 4096u
#define COPPICE_SCENE_MIRRORED 0x8000u
#define COPPICE_MAX_SCENE_PATH_BYTES 1024u /* limit for one species */
#define COPPICE_MAX_SCENE_TILES (1u << 20)
#define COPPICE_MAX_SCENE_LEVELS 24u
#define COPPICE_MAX_TILE_INSTANCES 2048u
#define COPPICE_MAX_SCENE_SCALE 1e6f
#define COPPICE_MAX_SCENE_SCALE_RATIO 1e30f /* largest scale of a tile divided by its smallest */

/* Bytes [0, 72). */
typedef struct coppice_scene_header {
  uint8_t magic[8];
  uint32_t version;
  uint32_t species_count; /* at least 1 */
  uint32_t tile_count;    /* at least 1 */
  uint32_t path_bytes;    /* all paths together */
  uint64_t instance_count;
  uint64_t file_bytes;      /* size of the whole file */
  float square_min[2];      /* x and z of the root tile's square */
  float square_side;        /* > 0 */
  uint32_t reserved;        /* zero */
  uint64_t front_checksum;  /* XXH3-64 of the front without the header */
  uint64_t header_checksum; /* XXH3-64 of bytes [0, 64) */
} coppice_scene_header;

/* A .coppice file, and the sphere that its plant had when the scene was written, so that tiles can be chosen before it is opened. */
typedef struct coppice_scene_species {
  uint32_t path_offset; /* offset in the paths, which follow each other in this order */
  uint32_t path_bytes;  /* UTF-8, relative to the scene's folder, not terminated */
  float sphere_center[3];
  float sphere_radius; /* > 0 */
} coppice_scene_species;

/* A square of the quadtree. Tile 0 is the root. Tiles are in breadth-first order: a tile's children follow each other, in ascending order
 * of their quadrants, and the children of an earlier tile come before those of a later one. */
typedef struct coppice_scene_tile {
  float box_min[3]; /* bounds its instances' positions; inside the tile's square */
  float box_max[3];
  float scale_min;         /* smallest scale of its instances, > 0 */
  float scale_max;         /* largest scale; at most COPPICE_MAX_SCENE_SCALE, and COPPICE_MAX_SCENE_SCALE_RATIO times scale_min */
  float max_radius;        /* largest sphere_radius * scale of its instances; no child has a larger one */
  uint32_t instance_count; /* 1 .. COPPICE_MAX_TILE_INSTANCES */
  uint32_t first_child;    /* 0 without children */
  uint32_t child_mask;     /* bit q: quadrant q has a child; bit 0 of q is the upper half in x, bit 1 in z */
  uint64_t checksum;       /* XXH3-64 of its instances */
} coppice_scene_tile;

/* A plant. position = box_min + q / 65535 * (box_max - box_min); scale = scale_min * (scale_max / scale_min)^(q / 255);
 * yaw, about +Y, = q / 256 * 2 pi. */
typedef struct coppice_scene_instance {
  uint16_t position[3];
  /* COPPICE_SCENE_MIRRORED is set if left and right (x of the plant's own axes) are exchanged before it is turned */
  uint16_t species;
  uint8_t yaw;
  uint8_t scale;
  uint16_t tint; /* bits 0..4 red, 5..10 green, 11..15 blue, red and blue in 16ths, green in 32nds */
} coppice_scene_instance;

#endif
