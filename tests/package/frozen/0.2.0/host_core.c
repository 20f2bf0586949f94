/* A host of libcoppice 0.2.0 without a graphics API, as a program that was compiled then: it must run for ever. It calls every function of
 * coppice.h and checks what the header of 0.2.0 promised.
 *
 *     host_core PLANT.coppice WOOD.forest    the scene's species are copies of the plant
 */
#include <coppice/coppice.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static coppice_context* context;

#define CHECK(condition)                                                                                              \
  do {                                                                                                                \
    if (!(condition)) {                                                                                               \
      fprintf(stderr, "host_core: line %d: %s; last error: %s\n", __LINE__, #condition, coppice_last_error(context)); \
      exit(1);                                                                                                        \
    }                                                                                                                 \
  } while (0)
#define OK(call) CHECK((call) == COPPICE_OK)

/* A record of the host's own that begins with a placement. */
typedef struct tree {
  coppice_placement placement;
  int age;
} tree;

typedef struct vertex {
  float position[3], normal[3], uv[2];
  unsigned char color[4];
  uint32_t material;
} vertex;

static size_t allocated_bytes;
static int log_lines, trace_spans;

static void* allocate(void* user, size_t bytes, size_t align) {
  (void)user;
  allocated_bytes += bytes;
  return aligned_alloc(align < sizeof(void*) ? sizeof(void*) : align, (bytes + 63) / 64 * 64);
}
static void release(void* user, void* pointer, size_t bytes) {
  (void)user;
  allocated_bytes -= bytes;
  free(pointer);
}
static void run(void* user, void (*function)(void* argument), void* argument) {
  (void)user;
  function(argument);
}
static void write_line(void* user, coppice_log_level level, const char* line) {
  (void)user;
  (void)level;
  log_lines += strchr(line, '\n') == NULL;
}
static void on_span(void* user, const coppice_trace_span* span) {
  (void)user;
  trace_spans += span->struct_size >= 56 && span->end_ns >= span->start_ns;
}

static void create(void) {
  coppice_allocator allocator;
  coppice_jobs jobs;
  coppice_log log;
  coppice_trace trace;
  coppice_context_desc desc;
  coppice_allocator_init(&allocator);
  coppice_jobs_init(&jobs);
  coppice_log_init(&log);
  coppice_trace_init(&trace);
  coppice_context_desc_init(&desc);
  allocator.allocate = allocate;
  allocator.free = release;
  jobs.submit = run;
  log.write = write_line;
  trace.span = on_span;
  desc.allocator = &allocator;
  desc.jobs = &jobs;
  desc.log = &log;
  desc.trace = &trace;
  desc.max_instances = 4096;
  desc.memory_budget_bytes = 64u << 20;
  desc.streaming_ms = 1000;
  OK(coppice_context_create(&desc, &context));
  desc.memory_budget_bytes = 1;
  coppice_context* none = NULL;
  CHECK(coppice_context_create(&desc, &none) == COPPICE_ERROR_INVALID_ARGUMENT && none == NULL && coppice_last_error(NULL)[0] != 0);
}

/* Looks down -Z from the origin, 90 degrees wide. */
static coppice_camera camera_of(coppice_view view) {
  coppice_camera camera;
  coppice_camera_init(&camera);
  camera.view = view;
  camera.width_px = camera.height_px = 512;
  camera.error_px = 0.01f;
  camera.clip_from_view[5] = -1;
  camera.clip_from_view[10] = camera.clip_from_view[15] = 0;
  camera.clip_from_view[11] = -1;
  camera.clip_from_view[14] = 0.1f;
  return camera;
}

static uint64_t frame_number;
static uint32_t added, dropped, opened, closed;

static void frame(const coppice_camera* camera) {
  coppice_frame now;
  coppice_change change;
  coppice_frame_init(&now);
  now.frame_number = ++frame_number;
  now.completed_number = frame_number - 1;
  now.cameras = camera;
  now.camera_count = camera != NULL;
  OK(coppice_frame_begin(context, &now));
  coppice_change_init(&change);
  while (coppice_next_change(context, &change) == COPPICE_OK && change.kind != COPPICE_CHANGE_NONE) {
    opened += change.kind == COPPICE_CHANGE_PLANT_OPENED;
    closed += change.kind == COPPICE_CHANGE_PLANT_CLOSED;
    added += change.kind == COPPICE_CHANGE_CHUNK_ADDED;
    dropped += change.kind == COPPICE_CHANGE_CHUNK_DROPPED;
    CHECK(change.kind != COPPICE_CHANGE_CHUNK_ADDED || (change.bytes != NULL && change.byte_count > 0));
    OK(coppice_confirm(context, &change, change.kind == COPPICE_CHANGE_CHUNK_DROPPED ? COPPICE_OUTCOME_FREED : COPPICE_OUTCOME_TAKEN));
  }
}

static void settle(const coppice_camera* camera) {
  uint32_t settled = COPPICE_FALSE, i;
  for (i = 0; i < 1000000 && settled == COPPICE_FALSE; ++i) {
    frame(camera);
    OK(coppice_is_settled(context, camera->view, &settled));
  }
  CHECK(settled == COPPICE_TRUE);
}

/* A plant that comes by a file, by memory, while frames go on, and again from another place. */
static coppice_plant open_plants(const char* path) {
  coppice_plant plant = 0, other = 0;
  coppice_plant_info info;
  FILE* file = fopen(path, "rb");
  long bytes;
  void* memory;
  CHECK(file != NULL && fseek(file, 0, SEEK_END) == 0);
  bytes = ftell(file);
  memory = malloc((size_t)bytes);
  rewind(file);
  CHECK(fread(memory, 1, (size_t)bytes, file) == (size_t)bytes && fclose(file) == 0);

  OK(coppice_plant_open_memory(context, memory, (size_t)bytes, "in memory", &other));
  OK(coppice_plant_reload_memory(context, other, memory, (size_t)bytes, "in memory again"));
  OK(coppice_plant_close(context, other));
  OK(coppice_plant_open_async(context, path, &other));
  coppice_plant_info_init(&info);
  do {
    frame(NULL);
    OK(coppice_plant_get_info(context, other, &info));
  } while (info.state == COPPICE_PLANT_OPENING);
  CHECK(info.state == COPPICE_PLANT_READY);
  OK(coppice_plant_reload(context, other, NULL));
  OK(coppice_plant_close(context, other));
  while (closed < 4) frame(NULL); /* of each opening and of each reload a file */
  free(memory);

  CHECK(coppice_plant_open(context, "/none.coppice", &plant) == COPPICE_ERROR_IO && plant == 0);
  CHECK(strstr(coppice_last_error(context), "/none.coppice") != NULL && log_lines > 0);
  OK(coppice_plant_open(context, path, &plant));
  OK(coppice_plant_get_info(context, plant, &info));
  CHECK(info.leaf_count > 0 && info.sphere_radius > 0 && info.box_max[1] > info.box_min[1]);
  return plant;
}

static void draw(const coppice_camera* camera, coppice_plant plant, coppice_instance first) {
  coppice_draw draws[16];
  coppice_file_info info;
  coppice_material material;
  coppice_card card;
  coppice_leaf_layout layout;
  coppice_leaf_output output;
  coppice_view_stats stats;
  vertex* vertices;
  uint32_t count = 0, i, *indices;
  settle(camera);
  CHECK(added > 0);
  OK(coppice_get_draws(context, camera->view, draws, 16, sizeof draws[0], &count));
  CHECK(count == 3 && draws[0].plant == plant && draws[0].instance == first && draws[0].user_data == 7 && draws[0].tree.scene == 0);
  CHECK(draws[0].position[2] == -3.0 && draws[0].scale == 1.0f && draws[0].leaf_count >= 1.0f);
  coppice_file_info_init(&info);
  OK(coppice_file_get_info(context, draws[0].file, &info));
  coppice_material_init(&material);
  for (i = 0; i < info.material_count; ++i) OK(coppice_file_get_material(context, draws[0].file, i, &material));
  coppice_card_init(&card);
  for (i = 0; i < info.card_count; ++i) OK(coppice_file_get_card(context, draws[0].file, i, &card));
  CHECK(coppice_file_get_card(context, draws[0].file, i, &card) == COPPICE_ERROR_INVALID_ARGUMENT);

  coppice_leaf_layout_init(&layout);
  layout.vertex_bytes = sizeof(vertex);
  layout.position = offsetof(vertex, position);
  layout.normal = offsetof(vertex, normal);
  layout.uv = offsetof(vertex, uv);
  layout.color = offsetof(vertex, color);
  layout.color_format = COPPICE_LEAF_COLOR_UNORM8X4;
  layout.material = offsetof(vertex, material);
  coppice_leaf_output_init(&output);
  OK(coppice_write_leaves(context, draws[0].file, draws[0].leaf_count, &layout, &output));
  CHECK(output.leaf_count > 0 && output.vertex_count == 4 * output.leaf_count && output.index_count == 6 * output.leaf_count);
  vertices = malloc(output.vertex_count * sizeof *vertices);
  indices = malloc(output.index_count * sizeof *indices);
  output.vertices = vertices;
  output.indices = indices;
  output.vertex_capacity = output.vertex_count;
  output.index_capacity = output.index_count;
  OK(coppice_write_leaves(context, draws[0].file, draws[0].leaf_count, &layout, &output));
  CHECK(indices[output.index_count - 1] == output.vertex_count - 1 && vertices[0].material < info.material_count);
  free(vertices);
  free(indices);
  coppice_view_stats_init(&stats);
  OK(coppice_get_view_stats(context, camera->view, &stats));
  CHECK(stats.visible_instance_count == 3);
}

static void pick(coppice_instance expected) {
  coppice_ray ray;
  coppice_hit hit;
  coppice_ray_init(&ray);
  coppice_hit_init(&hit);
  ray.boxes = COPPICE_TRUE;
  OK(coppice_pick(context, &ray, &hit));
  CHECK(hit.kind == COPPICE_HIT_BOX && hit.instance == expected && hit.user_data == 7 && hit.distance_m > 0);
}

static void walk_a_scene(const char* path, coppice_plant stump, coppice_camera camera) {
  const double low[3] = {-1e6, -1e6, -1e6}, high[3] = {1e6, 1e6, 1e6};
  coppice_scene scene = 0;
  coppice_scene_placement at;
  coppice_scene_info info;
  coppice_scene_plant_info species;
  coppice_scene_tree trees[64];
  coppice_tree_info tree_info;
  uint32_t count = 0, missing = 0;
  coppice_scene_placement_init(&at);
  at.position[0] = 5000;
  OK(coppice_scene_open(context, path, &at, &scene));
  coppice_scene_info_init(&info);
  OK(coppice_scene_get_info(context, scene, &info));
  camera.view_from_world[12] = -5000;
  settle(&camera);
  at.position[0] = 6000;
  OK(coppice_scene_move(context, scene, &at));
  camera.view_from_world[12] = -6000;
  settle(&camera);
  coppice_scene_plant_info_init(&species);
  OK(coppice_scene_get_plant(context, scene, 0, &species));
  CHECK(species.plant != 0 && species.path != NULL);
  OK(coppice_scene_query(context, scene, low, high, trees, 64, &count, &missing));
  CHECK(count == info.instance_count && missing == 0);
  coppice_tree_info_init(&tree_info);
  OK(coppice_scene_get_tree(context, &trees[0], &tree_info));
  CHECK(tree_info.resident == COPPICE_TRUE && tree_info.state == COPPICE_TREE_AS_IN_FILE && tree_info.plant != 0);
  OK(coppice_scene_hide(context, trees, 2));
  OK(coppice_scene_replace(context, trees, stump, &tree_info.placement, sizeof tree_info.placement, 1));
  OK(coppice_scene_get_tree(context, &trees[0], &tree_info));
  CHECK(tree_info.state == COPPICE_TREE_REPLACED && tree_info.plant == stump);
  OK(coppice_scene_get_tree(context, &trees[1], &tree_info));
  CHECK(tree_info.state == COPPICE_TREE_HIDDEN);
  OK(coppice_scene_restore(context, trees, 2));
  OK(coppice_scene_close(context, scene));
}

int main(int argc, char** argv) {
  coppice_view view = 0, map = 0;
  coppice_view_desc view_desc;
  coppice_camera camera, sun;
  coppice_sun_desc sun_desc;
  coppice_instance instances[3];
  coppice_plant plant;
  coppice_stats stats;
  tree trees[3];
  double origin[3] = {0, 0, -1};
  int i;
  CHECK(argc == 3);
  CHECK(coppice_version() >= COPPICE_HEADER_VERSION);
  CHECK(strlen(coppice_status_text(COPPICE_ERROR_IO)) > 0);
  create();
  plant = open_plants(argv[1]);

  coppice_view_desc_init(&view_desc);
  OK(coppice_view_create(context, &view_desc, &view));
  view_desc.output = COPPICE_OUTPUT_DEPTH;
  OK(coppice_view_create(context, &view_desc, &map));
  camera = camera_of(view);
  for (i = 0; i < 3; ++i) {
    coppice_placement_init(&trees[i].placement);
    trees[i].placement.position[2] = -3.0 - 2.0 * i;
    trees[i].placement.user_data = 7;
  }
  OK(coppice_instances_add(context, plant, &trees[0].placement, sizeof(tree), 3, instances));
  OK(coppice_instances_move(context, instances, &trees[0].placement, sizeof(tree), 3));
  draw(&camera, plant, instances[0]);
  pick(instances[0]);
  OK(coppice_instances_remove(context, instances, 1));
  pick(instances[1]);
  OK(coppice_set_origin(context, origin));
  origin[2] = 0;
  OK(coppice_set_origin(context, origin));

  coppice_sun_desc_init(&sun_desc);
  sun_desc.radius_m = 10;
  sun_desc.size_px = 256;
  coppice_camera_init(&sun);
  OK(coppice_sun_camera(context, map, &sun_desc, &sun));
  settle(&sun);
  OK(coppice_view_destroy(context, map));

  walk_a_scene(argv[2], plant, camera);
  OK(coppice_set_memory_budget(context, 32u << 20));
  coppice_stats_init(&stats);
  OK(coppice_get_stats(context, &stats));
  CHECK(stats.instance_count == 2 && stats.streamed[COPPICE_STREAMED_ALL].loaded == added && stats.memory_bytes > 0);
  OK(coppice_plant_close(context, plant));
  CHECK(coppice_plant_close(context, plant) == COPPICE_ERROR_INVALID_ARGUMENT);
  for (i = 0; i < 50; ++i) frame(NULL);
  CHECK(added == dropped && opened == closed && trace_spans > 0);
  coppice_context_destroy(context);
  CHECK(allocated_bytes == 0);
  puts("host_core: ran");
  return 0;
}
