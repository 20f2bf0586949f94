/* A forest without any GPU API: Coppice streams and selects, and this program draws what it says with a z-buffer of its own into a PNG.
 *
 *     02_no_gpu OUT.png DISTANCE_M PLANT.coppice...
 *
 * Plants stand in a grid; DISTANCE_M is from the eye to the first of them. What a host has to do: take each change that coppice_next_change
 * hands out and confirm it, ask coppice_get_draws what to draw, and draw it. */
#define _POSIX_C_SOURCE 199309L /* nanosleep */
#include <coppice/coppice.h>
#include <coppice/format.h>
#include <math.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { WIDTH = 960, HEIGHT = 540, GRID = 5, MOST_FILES = 64, MOST_MESHES = 16, MOST_PAGE_FRAMES = 400 };

/* What is kept of a chunk that was added. */
typedef struct chunk {
  void* bytes;
  uint32_t vertex_count, index_count, width, height;
} chunk;

/* A plant's file, by its number. */
typedef struct plant_file {
  coppice_file_info info;
  coppice_material* materials;
  chunk wood[MOST_MESHES];
  chunk* textures;
  chunk* leaf_meshes;
} plant_file;

typedef struct vertex {
  float position[3], normal[3], uv[2], color[4];
  uint32_t material;
} vertex;

typedef struct picture {
  float clip_from_world[16];
  float depth[WIDTH * HEIGHT]; /* 1 / distance: 0 is far away */
  unsigned char rgb[WIDTH * HEIGHT * 3];
  uint32_t covered;
} picture;

static plant_file files[MOST_FILES];
static picture shown;

static void check(coppice_status status, const coppice_context* context) {
  if (status == COPPICE_OK) return;
  fprintf(stderr, "%s\n", coppice_last_error(context));
  exit(1);
}

static void* allocate(size_t bytes) {
  void* memory = calloc(1, bytes > 0 ? bytes : 1);
  if (memory != NULL) return memory;
  fprintf(stderr, "out of memory\n");
  exit(1);
}

/* ---- what Coppice hands out ------------------------------------------------------------------------------------------------------ */

static void open_file(const coppice_context* context, uint32_t index) {
  plant_file* file = &files[index];
  coppice_file_info_init(&file->info);
  check(coppice_file_get_info(context, index, &file->info), context);
  file->materials = allocate(file->info.material_count * sizeof *file->materials);
  file->textures = allocate(file->info.texture_count * sizeof *file->textures);
  file->leaf_meshes = allocate(file->info.leaf_mesh_count * sizeof *file->leaf_meshes);
  for (uint32_t i = 0; i < file->info.material_count; ++i) {
    coppice_material_init(&file->materials[i]);
    check(coppice_file_get_material(context, index, i, &file->materials[i]), context);
  }
}

static void close_file(uint32_t index) {
  free(files[index].materials);
  free(files[index].textures);
  free(files[index].leaf_meshes);
  memset(&files[index], 0, sizeof files[index]);
}

/* Null: this program does not keep such chunks. Leaves come from coppice_write_leaves, so pages are not needed. */
static chunk* place_of(const coppice_change* change) {
  plant_file* file = &files[change->file];
  if (change->chunk == COPPICE_STREAMED_WOOD && change->index < MOST_MESHES) return &file->wood[change->index];
  if (change->chunk == COPPICE_STREAMED_TEXTURES) return &file->textures[change->index];
  return change->chunk == COPPICE_STREAMED_LEAF_MESHES ? &file->leaf_meshes[change->index] : NULL;
}

static void take_chunk(const coppice_change* change) {
  chunk* place = place_of(change);
  if (place == NULL) return;
  place->bytes = allocate((size_t)change->byte_count);
  memcpy(place->bytes, change->bytes, (size_t)change->byte_count);
  place->vertex_count = change->vertex_count;
  place->index_count = change->index_count;
  place->width = change->width;
  place->height = change->height;
}

static void drop_chunk(const coppice_change* change) {
  chunk* place = place_of(change);
  if (place == NULL) return;
  free(place->bytes);
  memset(place, 0, sizeof *place);
}

static uint32_t take_changes(coppice_context* context) {
  coppice_change change;
  uint32_t count = 0;
  for (coppice_change_init(&change);; ++count) {
    check(coppice_next_change(context, &change), context);
    switch (change.kind) {
      case COPPICE_CHANGE_NONE:
        return count;
      case COPPICE_CHANGE_PLANT_OPENED:
        open_file(context, change.file);
        break;
      case COPPICE_CHANGE_PLANT_CLOSED:
        close_file(change.file);
        break;
      case COPPICE_CHANGE_CHUNK_ADDED:
        take_chunk(&change);
        check(coppice_confirm(context, &change, COPPICE_OUTCOME_TAKEN), context);
        break;
      case COPPICE_CHANGE_CHUNK_DROPPED:
        drop_chunk(&change);
        check(coppice_confirm(context, &change, COPPICE_OUTCOME_FREED), context);
        break;
      default:
        break;
    }
  }
}

/* ---- a z-buffer ------------------------------------------------------------------------------------------------------------------ */

/* A vertex on its way to pixels: attributes are divided by w, so that they are linear on the screen. */
typedef struct corner {
  float x, y, w_inverse, u, v, light;
} corner;

static const float kSun[3] = {0.45f, 0.8f, 0.4f};

static float dot3(const float* a, const float* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void rotate(const float q[4], const float v[3], float out[3]) {
  const float t[3] = {2 * (q[1] * v[2] - q[2] * v[1]), 2 * (q[2] * v[0] - q[0] * v[2]), 2 * (q[0] * v[1] - q[1] * v[0])};
  out[0] = v[0] + q[3] * t[0] + q[1] * t[2] - q[2] * t[1];
  out[1] = v[1] + q[3] * t[1] + q[2] * t[0] - q[0] * t[2];
  out[2] = v[2] + q[3] * t[2] + q[0] * t[1] - q[1] * t[0];
}

/* False: it is behind the eye, and its triangle is left out. */
static int project(const coppice_draw* draw, const float position[3], const float normal[3], const float uv[2], corner* out) {
  float turned[3], world[3], facing[3];
  const float* m = shown.clip_from_world;
  rotate(draw->rotation, position, turned);
  for (int i = 0; i < 3; ++i) world[i] = (float)draw->position[i] + draw->scale * turned[i];
  const float w = m[3] * world[0] + m[7] * world[1] + m[11] * world[2] + m[15];
  if (w < 0.05f) return 0;
  const float x = m[0] * world[0] + m[4] * world[1] + m[8] * world[2] + m[12];
  const float y = m[1] * world[0] + m[5] * world[1] + m[9] * world[2] + m[13];
  rotate(draw->rotation, normal, facing);
  out->w_inverse = 1.0f / w;
  out->x = (0.5f + 0.5f * x / w) * (float)WIDTH;
  out->y = (0.5f + 0.5f * y / w) * (float)HEIGHT;
  out->u = uv[0] / w;
  out->v = uv[1] / w;
  out->light = (0.35f + 0.65f * fabsf(dot3(facing, kSun))) / w;
  return 1;
}

/* The level whose texels are about as large as pixels: without it leaves far away would sparkle. */
typedef struct level {
  const unsigned char* texels;
  uint32_t width, height;
} level;

static level level_for(const chunk* texture, float texels_per_px) {
  level at = {texture->bytes, texture->width, texture->height};
  while (texels_per_px > 1.5f && (at.width > 1 || at.height > 1)) {
    at.texels += 4 * (size_t)at.width * at.height;
    at.width = at.width > 1 ? at.width / 2 : 1;
    at.height = at.height > 1 ? at.height / 2 : 1;
    texels_per_px *= 0.5f;
  }
  return at;
}

static uint32_t wrap(float t, uint32_t size) {
  const uint32_t at = (uint32_t)((t - floorf(t)) * (float)size);
  return at < size ? at : size - 1;
}

static unsigned char display(float linear) {
  const float srgb = linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1 / 2.4f) - 0.055f;
  return (unsigned char)(255.0f * fminf(fmaxf(srgb, 0.0f), 1.0f) + 0.5f);
}

static float linear_of(unsigned char srgb) {
  const float c = (float)srgb / 255.0f;
  return c <= 0.04045f ? c / 12.92f : powf((c + 0.055f) / 1.055f, 2.4f);
}

static float area_of(const corner* a, const corner* b, float x, float y) {
  return (b->x - a->x) * (y - a->y) - (b->y - a->y) * (x - a->x);
}

/* What a triangle shows. */
typedef struct surface {
  const coppice_material* material;
  const chunk* texture; /* null, or not there yet: its colour alone */
  float color[3];       /* linear */
  float share;          /* share of its pixels that are drawn */
} surface;

/* False: a hole. */
static int shade(const surface* of, const level* texels, const float at[3], float color[3]) {
  memcpy(color, of->color, sizeof of->color);
  if (texels->texels != NULL) {
    const uint32_t column = wrap(at[0], texels->width), row = wrap(at[1], texels->height);
    const unsigned char* texel = texels->texels + 4 * ((size_t)row * texels->width + column);
    if ((float)texel[3] / 255.0f < of->material->alpha_cutoff) return 0;
    for (int i = 0; i < 3; ++i) color[i] *= linear_of(texel[i]);
  }
  for (int i = 0; i < 3; ++i) color[i] *= at[2];
  return 1;
}

/* A pixel's place in a pattern of sixteen, 0 to 15: a leaf with gaps is drawn where it is below its share. */
static uint32_t pattern(int x, int y) {
  static const unsigned char places[16] = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
  return places[(y & 3) * 4 + (x & 3)];
}

static void draw_triangle(const corner* a, const corner* b, const corner* c, const surface* of) {
  const float area = area_of(a, b, c->x, c->y);
  if (fabsf(area) < 1e-6f) return;
  const int left = (int)fmaxf(floorf(fminf(a->x, fminf(b->x, c->x))), 0), right = (int)fminf(fmaxf(a->x, fmaxf(b->x, c->x)), WIDTH - 1);
  const int top = (int)fmaxf(floorf(fminf(a->y, fminf(b->y, c->y))), 0), bottom = (int)fminf(fmaxf(a->y, fmaxf(b->y, c->y)), HEIGHT - 1);
  level texels = {NULL, 1, 1};
  if (of->texture != NULL && of->texture->bytes != NULL) {
    const float ua = a->u / a->w_inverse, va = a->v / a->w_inverse, ub = b->u / b->w_inverse, vb = b->v / b->w_inverse;
    const float uc = c->u / c->w_inverse, vc = c->v / c->w_inverse;
    const float in_texture = fabsf((ub - ua) * (vc - va) - (vb - va) * (uc - ua)) * (float)of->texture->width * (float)of->texture->height;
    texels = level_for(of->texture, sqrtf(in_texture / fabsf(area)));
  }
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const float px = (float)x + 0.5f, py = (float)y + 0.5f;
      const float ka = area_of(b, c, px, py) / area, kb = area_of(c, a, px, py) / area, kc = 1 - ka - kb;
      float color[3];
      if (ka < 0 || kb < 0 || kc < 0 || (float)pattern(x, y) >= 16.0f * of->share) continue;
      const float w_inverse = ka * a->w_inverse + kb * b->w_inverse + kc * c->w_inverse;
      const int place = y * WIDTH + x;
      if (w_inverse <= shown.depth[place]) continue;
      const float at[3] = {(ka * a->u + kb * b->u + kc * c->u) / w_inverse, (ka * a->v + kb * b->v + kc * c->v) / w_inverse,
                           (ka * a->light + kb * b->light + kc * c->light) / w_inverse};
      if (!shade(of, &texels, at, color)) continue;
      if (shown.depth[place] == 0.0f) ++shown.covered;
      shown.depth[place] = w_inverse;
      for (int i = 0; i < 3; ++i) shown.rgb[3 * place + i] = display(1.6f * color[i]);
    }
}

/* ---- draws ----------------------------------------------------------------------------------------------------------------------- */

static const chunk* texture_of(const plant_file* file, const coppice_material* material) {
  return material->texture == COPPICE_NONE ? NULL : &file->textures[material->texture];
}

static void draw_mesh(const coppice_draw* draw, const plant_file* file, const chunk* mesh, int tinted) {
  const coppice_mesh_vertex* vertices = mesh->bytes;
  const uint32_t* indices = (const uint32_t*)(vertices + mesh->vertex_count);
  for (uint32_t i = 0; i + 2 < mesh->index_count; i += 3) {
    corner corners[3];
    int in_front = 1;
    for (int k = 0; k < 3; ++k) {
      const coppice_mesh_vertex* at = &vertices[indices[i + (uint32_t)k]];
      in_front = in_front && project(draw, at->position, at->normal, at->uv, &corners[k]);
    }
    if (!in_front) continue;
    const coppice_material* material = &file->materials[vertices[indices[i]].material];
    surface of = {.material = material, .texture = texture_of(file, material), .share = 1};
    for (int k = 0; k < 3; ++k) of.color[k] = material->base_color[k] * (tinted ? draw->tint[k] : 1.0f);
    draw_triangle(&corners[0], &corners[1], &corners[2], &of);
  }
}

static void draw_leaves(const coppice_context* context, const coppice_draw* draw, const plant_file* file) {
  coppice_leaf_layout layout;
  coppice_leaf_output output;
  coppice_leaf_layout_init(&layout);
  layout.vertex_bytes = sizeof(vertex);
  layout.position = offsetof(vertex, position);
  layout.normal = offsetof(vertex, normal);
  layout.uv = offsetof(vertex, uv);
  layout.color = offsetof(vertex, color);
  layout.material = offsetof(vertex, material);
  coppice_leaf_output_init(&output);
  check(coppice_write_leaves(context, draw->file, draw->leaf_count, &layout, &output), context); /* how many? */
  vertex* vertices = output.vertices = allocate(output.vertex_count * sizeof(vertex));
  uint32_t* indices = output.indices = allocate(output.index_count * sizeof(uint32_t));
  output.vertex_capacity = output.vertex_count;
  output.index_capacity = output.index_count;
  check(coppice_write_leaves(context, draw->file, draw->leaf_count, &layout, &output), context);
  for (uint32_t i = 0; i < output.index_count; i += 3) {
    corner corners[3];
    int in_front = 1;
    for (int k = 0; k < 3; ++k) {
      const vertex* at = &vertices[indices[i + (uint32_t)k]];
      in_front = in_front && project(draw, at->position, at->normal, at->uv, &corners[k]);
    }
    if (!in_front) continue;
    const vertex* first = &vertices[indices[i]];
    const coppice_material* material = &file->materials[first->material];
    surface of = {.material = material, .texture = texture_of(file, material), .share = first->color[3]};
    for (int k = 0; k < 3; ++k) of.color[k] = first->color[k] * draw->tint[k];
    draw_triangle(&corners[0], &corners[1], &corners[2], &of);
  }
  free(vertices);
  free(indices);
}

static void draw_forest(coppice_context* context, coppice_view view) {
  uint32_t count = 0;
  check(coppice_get_draws(context, view, NULL, 0, sizeof(coppice_draw), &count), context);
  coppice_draw* draws = allocate(count * sizeof *draws);
  check(coppice_get_draws(context, view, draws, count, sizeof *draws, &count), context);
  double leaves = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const plant_file* file = &files[draws[i].file];
    if (draws[i].wood_lod != COPPICE_NONE) draw_mesh(&draws[i], file, &file->wood[draws[i].wood_lod], 0);
    for (uint32_t k = 0; draws[i].leaf_meshes && k < file->info.leaf_mesh_count; ++k) draw_mesh(&draws[i], file, &file->leaf_meshes[k], 1);
    if (!draws[i].leaf_meshes) draw_leaves(context, &draws[i], file);
    leaves += (double)draws[i].leaf_count;
  }
  printf("%u instances in view, %.0f leaves, %.1f %% of the picture covered\n", (unsigned)count, leaves,
         100.0 * shown.covered / (WIDTH * HEIGHT));
  free(draws);
}

/* ---- the program ----------------------------------------------------------------------------------------------------------------- */

/* Looks along -z from a little above the ground, y down in the picture. */
static void set_camera(coppice_camera* camera, float eye_height_m, float distance_m) {
  const float focal = 1.7f;
  camera->width_px = WIDTH;
  camera->height_px = HEIGHT;
  camera->view_from_world[13] = -eye_height_m;
  camera->view_from_world[14] = -distance_m;
  memset(camera->clip_from_view, 0, sizeof camera->clip_from_view);
  camera->clip_from_view[0] = focal * (float)HEIGHT / (float)WIDTH;
  camera->clip_from_view[5] = -focal;
  camera->clip_from_view[11] = -1.0f;
  camera->clip_from_view[14] = 0.05f; /* the near plane; depth is reversed and infinite */
  camera->error_px = 1.0f;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) {
      float sum = 0;
      for (int k = 0; k < 4; ++k) sum += camera->clip_from_view[4 * k + row] * (float)camera->view_from_world[4 * column + k];
      shown.clip_from_world[4 * column + row] = sum;
    }
}

/* A row of plants behind another. Returns the height of the largest. */
static float place_forest(coppice_context* context, char** paths, int count) {
  float height = 0, spacing = 0;
  coppice_plant plants[MOST_FILES];
  for (int i = 0; i < count; ++i) {
    coppice_plant_info info;
    check(coppice_plant_open(context, paths[i], &plants[i]), context);
    coppice_plant_info_init(&info);
    check(coppice_plant_get_info(context, plants[i], &info), context);
    height = fmaxf(height, info.box_max[1]);
    spacing = fmaxf(spacing, 1.6f * info.sphere_radius);
  }
  for (int i = 0; i < GRID * GRID; ++i) {
    coppice_placement placement;
    coppice_placement_init(&placement);
    placement.scale = 0.8f + 0.05f * (float)(i % 7);
    const float turn = 0.7f * (float)i;
    placement.position[0] = ((float)(i % GRID) - 0.5f * (float)(GRID - 1)) * spacing;
    placement.position[2] = -(float)(i / GRID) * spacing;
    placement.rotation[1] = sinf(turn);
    placement.rotation[3] = cosf(turn);
    check(coppice_instances_add(context, plants[i % count], &placement, sizeof placement, 1, NULL), context);
  }
  return height;
}

static void clear_picture(void) {
  for (int i = 0; i < WIDTH * HEIGHT; ++i) {
    const float share = (float)(i / WIDTH) / (float)HEIGHT;
    shown.rgb[3 * i] = (unsigned char)(150 + 60 * share);
    shown.rgb[3 * i + 1] = (unsigned char)(185 + 35 * share);
    shown.rgb[3 * i + 2] = 225;
  }
}

int main(int argc, char** argv) {
  /* A plant that was taken for the picture's name would be written over. */
  const char* ending = argc > 1 ? strrchr(argv[1], '.') : NULL;
  const float distance_m = argc > 2 ? strtof(argv[2], NULL) : 0;
  if (argc < 4 || argc > 3 + MOST_FILES / 2 || ending == NULL || strcmp(ending, ".png") != 0 || !(distance_m > 0)) {
    fprintf(stderr, "02_no_gpu OUT.png DISTANCE_M PLANT.coppice...\n");
    return 2;
  }
  coppice_context_desc desc;
  coppice_context* context = NULL;
  coppice_view_desc view_desc;
  coppice_view view = 0;
  coppice_camera camera;
  coppice_context_desc_init(&desc);
  check(coppice_context_create(&desc, &context), NULL);
  coppice_view_desc_init(&view_desc);
  check(coppice_view_create(context, &view_desc, &view), context);
  const float height = place_forest(context, argv + 3, argc - 3);
  coppice_camera_init(&camera);
  camera.view = view;
  set_camera(&camera, 0.6f * height, distance_m);

  /* Frames until all that the view wants is there. */
  uint32_t settled = 0;
  for (uint64_t number = 1; number <= MOST_PAGE_FRAMES && !settled; ++number) {
    const struct timespec pause = {0, 5000000};
    coppice_frame frame;
    coppice_frame_init(&frame);
    frame.frame_number = number;
    frame.completed_number = number - 1;
    frame.cameras = &camera;
    frame.camera_count = 1;
    check(coppice_frame_begin(context, &frame), context);
    if (take_changes(context) == 0) nanosleep(&pause, NULL);
    check(coppice_is_settled(context, view, &settled), context);
  }
  clear_picture();
  draw_forest(context, view);
  coppice_context_destroy(context);

  png_image image;
  memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = WIDTH;
  image.height = HEIGHT;
  image.format = PNG_FORMAT_RGB;
  if (!png_image_write_to_file(&image, argv[1], 0, shown.rgb, 0, NULL)) {
    fprintf(stderr, "%s: %s\n", argv[1], image.message);
    return 1;
  }
  return settled ? 0 : 1;
}
