/* The layout of every struct of the public headers, on platforms with 64-bit pointers: a field that moves breaks every program that was
 * compiled before. New fields go to the end of a struct, and get a line here; a line that is here is never changed. The last field
 * ends where its struct ends: what the library reads must not lie where older programs have padding, which may hold anything. */

#ifdef __cplusplus
#error "this test is about C"
#endif

#include <stddef.h>

#include "coppice/coppice.h"
#include "coppice/vulkan.h"

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define CHECK(condition) typedef char JOIN(check_, __LINE__)[(condition) ? 1 : -1] __attribute__((unused))
#define FIELD(type, field, at) CHECK(offsetof(type, field) == (at))
#define LAST_FIELD(type, field, at, size) \
  CHECK(offsetof(type, field) == (at) && (at) + sizeof(((type*)0)->field) == (size) && sizeof(type) == (size))

CHECK(sizeof(void*) == 8);
CHECK(sizeof(coppice_status) == 4);

FIELD(coppice_allocator, struct_size, 0);
FIELD(coppice_allocator, user, 8);
FIELD(coppice_allocator, allocate, 16);
LAST_FIELD(coppice_allocator, free, 24, 32);

FIELD(coppice_jobs, struct_size, 0);
FIELD(coppice_jobs, user, 8);
LAST_FIELD(coppice_jobs, submit, 16, 24);

FIELD(coppice_io, struct_size, 0);
FIELD(coppice_io, user, 8);
FIELD(coppice_io, open, 16);
FIELD(coppice_io, close, 24);
LAST_FIELD(coppice_io, read, 32, 40);

FIELD(coppice_log, struct_size, 0);
FIELD(coppice_log, user, 8);
LAST_FIELD(coppice_log, write, 16, 24);

FIELD(coppice_trace_span, struct_size, 0);
FIELD(coppice_trace_span, kind, 4);
FIELD(coppice_trace_span, path, 8);
FIELD(coppice_trace_span, chunk, 16);
FIELD(coppice_trace_span, index, 24);
FIELD(coppice_trace_span, bytes, 32);
FIELD(coppice_trace_span, start_ns, 40);
LAST_FIELD(coppice_trace_span, end_ns, 48, 56);

FIELD(coppice_trace, struct_size, 0);
FIELD(coppice_trace, user, 8);
LAST_FIELD(coppice_trace, span, 16, 24);

FIELD(coppice_context_desc, struct_size, 0);
FIELD(coppice_context_desc, max_instances, 4);
FIELD(coppice_context_desc, max_plants, 8);
FIELD(coppice_context_desc, allow_outside, 12);
FIELD(coppice_context_desc, memory_budget_bytes, 16);
FIELD(coppice_context_desc, allocator, 24);
FIELD(coppice_context_desc, jobs, 32);
FIELD(coppice_context_desc, io, 40);
FIELD(coppice_context_desc, log, 48);
FIELD(coppice_context_desc, trace, 56);
FIELD(coppice_context_desc, asset_root, 64);
FIELD(coppice_context_desc, streaming_ms, 72);
FIELD(coppice_context_desc, prefetch_frames, 76);
FIELD(coppice_context_desc, block_textures, 80);
LAST_FIELD(coppice_context_desc, reserved, 84, 88);

FIELD(coppice_plant_info, struct_size, 0);
FIELD(coppice_plant_info, state, 4);
FIELD(coppice_plant_info, failure, 8);
FIELD(coppice_plant_info, reloading, 12);
FIELD(coppice_plant_info, leaf_count, 16);
FIELD(coppice_plant_info, resident_leaf_count, 20);
FIELD(coppice_plant_info, page_count, 24);
FIELD(coppice_plant_info, resident_page_count, 28);
FIELD(coppice_plant_info, wood_lod_count, 32);
FIELD(coppice_plant_info, wood_triangle_count, 36);
FIELD(coppice_plant_info, sphere_center, 40);
FIELD(coppice_plant_info, sphere_radius, 52);
FIELD(coppice_plant_info, file_bytes, 56);
FIELD(coppice_plant_info, name, 64);
FIELD(coppice_plant_info, box_min, 128);
LAST_FIELD(coppice_plant_info, box_max, 140, 152);

FIELD(coppice_placement, position, 0);
FIELD(coppice_placement, scale, 24);
FIELD(coppice_placement, rotation, 28);
FIELD(coppice_placement, tint, 44);
FIELD(coppice_placement, user_data, 56);
FIELD(coppice_placement, layer_mask, 60);
FIELD(coppice_placement, lod_bias, 64);
LAST_FIELD(coppice_placement, leaf_share, 68, 72);

FIELD(coppice_scene_info, struct_size, 0);
FIELD(coppice_scene_info, species_count, 4);
FIELD(coppice_scene_info, tile_count, 8);
FIELD(coppice_scene_info, square_side, 12);
FIELD(coppice_scene_info, square_min, 16);
FIELD(coppice_scene_info, instance_count, 24);
FIELD(coppice_scene_info, file_bytes, 32);
FIELD(coppice_scene_info, height_min, 40);
LAST_FIELD(coppice_scene_info, height_max, 44, 48);

FIELD(coppice_scene_placement, struct_size, 0);
FIELD(coppice_scene_placement, rotation, 4);
LAST_FIELD(coppice_scene_placement, position, 24, 48);

FIELD(coppice_scene_plant_info, struct_size, 0);
FIELD(coppice_scene_plant_info, path, 8);
LAST_FIELD(coppice_scene_plant_info, plant, 16, 24);

/* A name, which does not grow. */
FIELD(coppice_scene_tree, scene, 0);
FIELD(coppice_scene_tree, tile, 8);
LAST_FIELD(coppice_scene_tree, number, 12, 16);

/* It grows as coppice_placement does; fields of its own have their room before that. */
FIELD(coppice_tree_info, struct_size, 0);
FIELD(coppice_tree_info, state, 4);
FIELD(coppice_tree_info, resident, 8);
FIELD(coppice_tree_info, reserved, 12);
FIELD(coppice_tree_info, plant, 48);
LAST_FIELD(coppice_tree_info, placement, 56, 128);

FIELD(coppice_ray, struct_size, 0);
FIELD(coppice_ray, layer_mask, 4);
FIELD(coppice_ray, origin, 8);
FIELD(coppice_ray, direction, 32);
FIELD(coppice_ray, max_distance_m, 44);
FIELD(coppice_ray, boxes, 48);
LAST_FIELD(coppice_ray, reserved, 52, 56);

FIELD(coppice_wind, struct_size, 0);
FIELD(coppice_wind, direction, 4);
FIELD(coppice_wind, speed, 16);
FIELD(coppice_wind, gustiness, 20);
FIELD(coppice_wind, time_s, 24);
FIELD(coppice_wind, time_before_s, 32);
FIELD(coppice_wind, map, 40);
FIELD(coppice_wind, map_min, 48);
FIELD(coppice_wind, map_max, 64);
FIELD(coppice_wind, map_width, 80);
LAST_FIELD(coppice_wind, gusts_m, 88, 96);
FIELD(coppice_gust_wave, x, 0);
FIELD(coppice_gust_wave, z, 4);
FIELD(coppice_gust_wave, phase, 8);
LAST_FIELD(coppice_gust_wave, share, 12, 16);
FIELD(coppice_gusts, struct_size, 0);
FIELD(coppice_gusts, direction, 4);
FIELD(coppice_gusts, load, 16);
FIELD(coppice_gusts, gustiness, 20);
LAST_FIELD(coppice_gusts, waves, 24, 72);

FIELD(coppice_hit, struct_size, 0);
FIELD(coppice_hit, kind, 4);
FIELD(coppice_hit, plant, 8);
FIELD(coppice_hit, instance, 16);
FIELD(coppice_hit, tree, 24);
FIELD(coppice_hit, position, 40);
FIELD(coppice_hit, distance_m, 64);
LAST_FIELD(coppice_hit, user_data, 68, 72);

/* Part of coppice_stats, so that it cannot grow; 4 bytes of padding at its end. */
FIELD(coppice_streamed_stats, loaded, 0);
FIELD(coppice_streamed_stats, evicted, 8);
FIELD(coppice_streamed_stats, failed, 16);
FIELD(coppice_streamed_stats, cancelled, 24);
FIELD(coppice_streamed_stats, in_flight, 32);
FIELD(coppice_streamed_stats, wanted, 36);
FIELD(coppice_streamed_stats, queued, 40);
CHECK(sizeof(coppice_streamed_stats) == 48);

FIELD(coppice_stats, struct_size, 0);
FIELD(coppice_stats, instance_count, 4);
FIELD(coppice_stats, source_leaf_count, 8);
FIELD(coppice_stats, memory_budget_bytes, 16);
FIELD(coppice_stats, memory_bytes, 24);
FIELD(coppice_stats, memory_peak_bytes, 32);
FIELD(coppice_stats, device_allocations, 40);
FIELD(coppice_stats, streamed, 48);
FIELD(coppice_stats, bytes_read, 432);
FIELD(coppice_stats, decode_ms, 440);
FIELD(coppice_stats, pipelines_wanted, 448);
FIELD(coppice_stats, pipelines_built, 452);
FIELD(coppice_stats, scene_instance_count, 456);
FIELD(coppice_stats, scene_tile_count, 464);
FIELD(coppice_stats, scene_tiles_resident, 468);
FIELD(coppice_stats, scene_tiles_wanted, 472);
FIELD(coppice_stats, scene_tiles_missing, 476);
FIELD(coppice_stats, scene_tiles_failed, 480);
FIELD(coppice_stats, scene_species_failed, 484);
FIELD(coppice_stats, scene_threshold_px, 488);
FIELD(coppice_stats, longest_pipeline_ms, 492);
FIELD(coppice_stats, longest_pipeline, 496);
FIELD(coppice_stats, pipelines_ms, 504);
LAST_FIELD(coppice_stats, missing_pipeline, 512, 520);

FIELD(coppice_view_stats, struct_size, 0);
FIELD(coppice_view_stats, visible_instance_count, 4);
FIELD(coppice_view_stats, occluded_instance_count, 8);
FIELD(coppice_view_stats, leaf_mesh_instance_count, 12);
FIELD(coppice_view_stats, gpu_frame_number, 16);
FIELD(coppice_view_stats, drawn_leaf_count, 24);
FIELD(coppice_view_stats, drawn_wood_triangle_count, 32);
FIELD(coppice_view_stats, drawn_leaf_mesh_triangle_count, 40);
FIELD(coppice_view_stats, threshold_px, 48);
FIELD(coppice_view_stats, pass_ms, 52);
CHECK(sizeof(coppice_view_stats) == 120); /* the library fills it: padding at its end does no harm */

FIELD(coppice_view_desc, struct_size, 0);
LAST_FIELD(coppice_view_desc, output, 4, 8);

FIELD(coppice_camera, struct_size, 0);
FIELD(coppice_camera, view, 8);
FIELD(coppice_camera, view_from_world, 16);
FIELD(coppice_camera, clip_from_view, 144);
FIELD(coppice_camera, width_px, 208);
FIELD(coppice_camera, height_px, 212);
FIELD(coppice_camera, x_px, 216);
FIELD(coppice_camera, y_px, 220);
FIELD(coppice_camera, error_px, 224);
FIELD(coppice_camera, lod, 228);
FIELD(coppice_camera, leaf_budget, 232);
FIELD(coppice_camera, debug_view, 236);
FIELD(coppice_camera, temporal_frame, 240);
FIELD(coppice_camera, layer_mask, 244);
LAST_FIELD(coppice_camera, second_eye, 248, 256);

FIELD(coppice_eye, struct_size, 0);
FIELD(coppice_eye, x_px, 4);
FIELD(coppice_eye, y_px, 8);
FIELD(coppice_eye, clip_from_view, 12);
LAST_FIELD(coppice_eye, view_from_world, 80, 208);

FIELD(coppice_sun_desc, struct_size, 0);
FIELD(coppice_sun_desc, sun_direction, 4);
FIELD(coppice_sun_desc, center, 16);
FIELD(coppice_sun_desc, radius_m, 40);
LAST_FIELD(coppice_sun_desc, size_px, 44, 48);

FIELD(coppice_frame, struct_size, 0);
FIELD(coppice_frame, frame_number, 8);
FIELD(coppice_frame, completed_number, 16);
FIELD(coppice_frame, cameras, 24);
FIELD(coppice_frame, camera_count, 32);
FIELD(coppice_frame, camera_bytes, 36);
LAST_FIELD(coppice_frame, wind, 40, 48);

FIELD(coppice_memory_block, struct_size, 0);
FIELD(coppice_memory_block, memory_type, 4);
FIELD(coppice_memory_block, memory, 8);
FIELD(coppice_memory_block, offset, 16);
FIELD(coppice_memory_block, mapped, 24);
LAST_FIELD(coppice_memory_block, handle, 32, 40);

FIELD(coppice_device_memory, struct_size, 0);
FIELD(coppice_device_memory, user, 8);
FIELD(coppice_device_memory, allocate, 16);
LAST_FIELD(coppice_device_memory, free, 24, 32);

FIELD(coppice_leaf_node, corners, 0);
FIELD(coppice_leaf_node, card, 24);
FIELD(coppice_leaf_node, fade, 25);
FIELD(coppice_leaf_node, reserved, 26);
LAST_FIELD(coppice_leaf_node, split, 28, 32);

FIELD(coppice_mesh_vertex, position, 0);
FIELD(coppice_mesh_vertex, normal, 12);
FIELD(coppice_mesh_vertex, uv, 24);
LAST_FIELD(coppice_mesh_vertex, material, 32, 36);

FIELD(coppice_change, struct_size, 0);
FIELD(coppice_change, kind, 4);
FIELD(coppice_change, plant, 8);
FIELD(coppice_change, file, 16);
FIELD(coppice_change, chunk, 20);
FIELD(coppice_change, index, 24);
FIELD(coppice_change, texture_format, 28);
FIELD(coppice_change, bytes, 32);
FIELD(coppice_change, byte_count, 40);
FIELD(coppice_change, first_node, 48);
FIELD(coppice_change, node_count, 52);
FIELD(coppice_change, vertex_count, 56);
FIELD(coppice_change, index_count, 60);
FIELD(coppice_change, width, 64);
FIELD(coppice_change, height, 68);
FIELD(coppice_change, mip_count, 72);
LAST_FIELD(coppice_change, reserved, 76, 80);

FIELD(coppice_file_info, struct_size, 0);
FIELD(coppice_file_info, leaf_count, 4);
FIELD(coppice_file_info, page_count, 8);
FIELD(coppice_file_info, wood_lod_count, 12);
FIELD(coppice_file_info, leaf_mesh_count, 16);
FIELD(coppice_file_info, texture_count, 20);
FIELD(coppice_file_info, material_count, 24);
FIELD(coppice_file_info, card_count, 28);
FIELD(coppice_file_info, box_min, 32);
FIELD(coppice_file_info, box_step, 44);
FIELD(coppice_file_info, sphere_center, 56);
FIELD(coppice_file_info, sphere_radius, 68);
LAST_FIELD(coppice_file_info, root, 72, 104);

FIELD(coppice_material, struct_size, 0);
FIELD(coppice_material, base_color, 4);
FIELD(coppice_material, alpha_cutoff, 20);
FIELD(coppice_material, roughness, 24);
FIELD(coppice_material, crown_normals, 28);
FIELD(coppice_material, texture, 32);
LAST_FIELD(coppice_material, normal_map, 36, 40);

FIELD(coppice_card, struct_size, 0);
FIELD(coppice_card, material, 4);
FIELD(coppice_card, uv, 8);
FIELD(coppice_card, albedo, 40);
LAST_FIELD(coppice_card, coverage, 52, 56);

FIELD(coppice_draw, plant, 0);
FIELD(coppice_draw, instance, 8);
FIELD(coppice_draw, tree, 16);
FIELD(coppice_draw, file, 32);
FIELD(coppice_draw, leaf_count, 36);
FIELD(coppice_draw, node_end, 40);
FIELD(coppice_draw, wood_lod, 44);
FIELD(coppice_draw, leaf_meshes, 48);
FIELD(coppice_draw, user_data, 52);
FIELD(coppice_draw, position, 56);
FIELD(coppice_draw, scale, 80);
FIELD(coppice_draw, rotation, 84);
FIELD(coppice_draw, tint, 100);
FIELD(coppice_draw, leaf_share, 112);
LAST_FIELD(coppice_draw, reserved, 116, 120);

FIELD(coppice_leaf_layout, struct_size, 0);
FIELD(coppice_leaf_layout, vertex_bytes, 4);
FIELD(coppice_leaf_layout, position, 8);
FIELD(coppice_leaf_layout, normal, 12);
FIELD(coppice_leaf_layout, uv, 16);
FIELD(coppice_leaf_layout, color, 20);
FIELD(coppice_leaf_layout, material, 24);
FIELD(coppice_leaf_layout, color_format, 28);
LAST_FIELD(coppice_leaf_layout, index_bytes, 32, 36);

FIELD(coppice_leaf_output, struct_size, 0);
FIELD(coppice_leaf_output, vertex_capacity, 4);
FIELD(coppice_leaf_output, vertices, 8);
FIELD(coppice_leaf_output, indices, 16);
FIELD(coppice_leaf_output, index_capacity, 24);
FIELD(coppice_leaf_output, vertex_count, 28);
FIELD(coppice_leaf_output, index_count, 32);
LAST_FIELD(coppice_leaf_output, leaf_count, 36, 40);

FIELD(coppice_vulkan_desc, struct_size, 0);
FIELD(coppice_vulkan_desc, instance, 8);
FIELD(coppice_vulkan_desc, physical_device, 16);
FIELD(coppice_vulkan_desc, device, 24);
FIELD(coppice_vulkan_desc, get_instance_proc_addr, 32);
FIELD(coppice_vulkan_desc, pipeline_cache, 40);
FIELD(coppice_vulkan_desc, device_memory, 48);
FIELD(coppice_vulkan_desc, texture_compression_bc, 56);
FIELD(coppice_vulkan_desc, compute_raster, 60);
FIELD(coppice_vulkan_desc, shader_int64_atomics, 64);
FIELD(coppice_vulkan_desc, pass_times, 68);
FIELD(coppice_vulkan_desc, blocking_pipelines, 72);
FIELD(coppice_vulkan_desc, draw_indirect_count, 76);
FIELD(coppice_vulkan_desc, queue_family_count, 80);
LAST_FIELD(coppice_vulkan_desc, queue_families, 84, 96);

FIELD(coppice_vulkan_view_desc, struct_size, 0);
FIELD(coppice_vulkan_view_desc, color_formats, 4);
FIELD(coppice_vulkan_view_desc, depth_format, 36);
FIELD(coppice_vulkan_view_desc, depth_compare, 40);
FIELD(coppice_vulkan_view_desc, samples, 44);
FIELD(coppice_vulkan_view_desc, has_stencil, 48);
FIELD(coppice_vulkan_view_desc, contents, 52);
FIELD(coppice_vulkan_view_desc, subpass, 84);
LAST_FIELD(coppice_vulkan_view_desc, render_pass, 88, 96);

FIELD(coppice_shadow_map, image, 0);
LAST_FIELD(coppice_shadow_map, clip_from_world, 8, 136);

FIELD(coppice_light, struct_size, 0);
FIELD(coppice_light, sun_direction, 4);
FIELD(coppice_light, sun_color, 16);
FIELD(coppice_light, sky_color, 28);
FIELD(coppice_light, ground_color, 40);
FIELD(coppice_light, fog_color, 52);
FIELD(coppice_light, fog_density, 64);
FIELD(coppice_light, shadow_maps, 72);
FIELD(coppice_light, shadow_map_count, 80);
FIELD(coppice_light, shadow_map_bytes, 84);
LAST_FIELD(coppice_light, occluder, 88, 96);

FIELD(coppice_occluder, struct_size, 0);
FIELD(coppice_occluder, x_px, 4);
FIELD(coppice_occluder, y_px, 8);
FIELD(coppice_occluder, reserved, 12);
FIELD(coppice_occluder, image, 16);
LAST_FIELD(coppice_occluder, second_image, 24, 32);

/* What is wrong does not compile; abi_test is linked with this. */
int abi_layout_is_checked(void);
int abi_layout_is_checked(void) {
  return 1;
}
