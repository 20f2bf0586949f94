// Structs of programs that were compiled with an older or a newer header: read, filled and set to their defaults in any size.

#include "vulkan_abi.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "mentions.h"
#include "resized.h"

namespace coppice::test::abi_test {

constexpr std::size_t kStep = 4;
constexpr std::size_t kBeyond = 64;

template <class T>
bool same_bytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// write  fills a struct of so many bytes: with as much of `full` as fits, and zeros behind it
template <class T, class Write>
void expect_filled_in_any_size(const T& full, const Write& write) {
  for (std::size_t bytes = kStep; bytes <= sizeof(T) + kBeyond; bytes += kStep) {
    Resized<T> theirs(T{}, bytes, 0xee);
    write(theirs.get(), bytes);
    EXPECT_TRUE(theirs.has_canaries()) << bytes;
    T expected{};
    std::memcpy(static_cast<void*>(&expected), &full, std::min(bytes, sizeof(T)));
    expected.struct_size = static_cast<std::uint32_t>(bytes);
    EXPECT_TRUE(same_bytes(theirs.value(), expected)) << bytes;
    for (std::size_t i = sizeof(T); i < bytes; ++i) EXPECT_EQ(theirs.byte(i), 0) << i << " of " << bytes;
  }
}

void init_struct(coppice_struct kind, void* data, std::size_t bytes) {
  coppice_struct_init(kind, data, bytes);
}

void init_struct(coppice_vulkan_struct kind, void* data, std::size_t bytes) {
  coppice_vulkan_struct_init(kind, data, bytes);
}

template <class Kind, class T>
void expect_defaults(Kind kind, void (*init)(T*)) {
  T known{};
  std::memset(static_cast<void*>(&known), 0xee, sizeof known);
  init_struct(kind, &known, sizeof known);
  EXPECT_EQ(known.struct_size, sizeof known);
  expect_filled_in_any_size(known, [kind](void* data, std::size_t bytes) { init_struct(kind, data, bytes); });
  init(nullptr);
  init(&known);
  EXPECT_TRUE(same_bytes(known, struct_defaults<T>()));
}

/// A kind of a later version.
template <class Kind>
void expect_zeros() {
  Resized<coppice_stats> later({}, 40, 0xee);
  init_struct(static_cast<Kind>(999), later.get(), 40);
  EXPECT_TRUE(later.has_canaries());
  EXPECT_EQ(later.value().struct_size, 40u);
  for (std::size_t i = 4; i < 40; ++i) EXPECT_EQ(later.byte(i), 0);
}

TEST(StructInit, FillsAsMuchAsTheProgramHas) {
  expect_defaults(COPPICE_STRUCT_CONTEXT_DESC, coppice_context_desc_init);
  expect_defaults(COPPICE_STRUCT_ALLOCATOR, coppice_allocator_init);
  expect_defaults(COPPICE_STRUCT_JOBS, coppice_jobs_init);
  expect_defaults(COPPICE_STRUCT_IO, coppice_io_init);
  expect_defaults(COPPICE_STRUCT_LOG, coppice_log_init);
  expect_defaults(COPPICE_STRUCT_TRACE, coppice_trace_init);
  expect_defaults(COPPICE_STRUCT_PLANT_INFO, coppice_plant_info_init);
  expect_defaults(COPPICE_STRUCT_SCENE_INFO, coppice_scene_info_init);
  expect_defaults(COPPICE_STRUCT_SCENE_PLANT_INFO, coppice_scene_plant_info_init);
  expect_defaults(COPPICE_STRUCT_STATS, coppice_stats_init);
  expect_defaults(COPPICE_VULKAN_STRUCT_DESC, coppice_vulkan_desc_init);
  expect_defaults(COPPICE_VULKAN_STRUCT_DEVICE_MEMORY, coppice_device_memory_init);
  expect_defaults(COPPICE_STRUCT_VIEW_DESC, coppice_view_desc_init);
  expect_defaults(COPPICE_STRUCT_EYE, coppice_eye_init);
  expect_defaults(COPPICE_STRUCT_CAMERA, coppice_camera_init);
  expect_defaults(COPPICE_STRUCT_SUN_DESC, coppice_sun_desc_init);
  expect_defaults(COPPICE_STRUCT_FRAME, coppice_frame_init);
  expect_defaults(COPPICE_STRUCT_CHANGE, coppice_change_init);
  expect_defaults(COPPICE_STRUCT_FILE_INFO, coppice_file_info_init);
  expect_defaults(COPPICE_STRUCT_MATERIAL, coppice_material_init);
  expect_defaults(COPPICE_STRUCT_CARD, coppice_card_init);
  expect_defaults(COPPICE_STRUCT_LEAF_LAYOUT, coppice_leaf_layout_init);
  expect_defaults(COPPICE_STRUCT_LEAF_OUTPUT, coppice_leaf_output_init);
  expect_defaults(COPPICE_STRUCT_VIEW_STATS, coppice_view_stats_init);
  expect_defaults(COPPICE_VULKAN_STRUCT_VIEW_DESC, coppice_vulkan_view_desc_init);
  expect_defaults(COPPICE_STRUCT_TREE_INFO, coppice_tree_info_init);
  expect_defaults(COPPICE_STRUCT_RAY, coppice_ray_init);
  expect_defaults(COPPICE_STRUCT_HIT, coppice_hit_init);
  expect_defaults(COPPICE_STRUCT_WIND, coppice_wind_init);
  expect_defaults(COPPICE_STRUCT_GUSTS, coppice_gusts_init);
  expect_defaults(COPPICE_VULKAN_STRUCT_LIGHT, coppice_light_init);
  expect_defaults(COPPICE_VULKAN_STRUCT_OCCLUDER, coppice_occluder_init);
  expect_defaults(COPPICE_VULKAN_STRUCT_MATERIAL_OVERRIDE, coppice_material_override_init);
  expect_defaults(COPPICE_VULKAN_STRUCT_TRIANGLES, coppice_triangles_init);
}

TEST(StructInit, AKindOfALaterVersionIsZeros) {
  expect_zeros<coppice_struct>();
  expect_zeros<coppice_vulkan_struct>();
}

TEST(StructInit, LeavesAloneWhatCannotBeAStruct) {
  std::array<unsigned char, 8192> block{};
  block.fill(0xee);
  const auto untouched = block;
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{3}, std::size_t{4100}, SIZE_MAX}) {
    coppice_struct_init(COPPICE_STRUCT_STATS, block.data(), bytes);
    coppice_vulkan_struct_init(COPPICE_VULKAN_STRUCT_LIGHT, block.data(), bytes);
  }
  EXPECT_EQ(block, untouched);
}

/// Every byte but those of struct_size another than its default.
template <class T>
T far_from_default() {
  T value{};
  std::memset(static_cast<void*>(&value), 0x11, sizeof value);
  return value;
}

template <class T>
void expect_read() {
  const T full = far_from_default<T>();
  for (std::size_t bytes = kStep; bytes <= sizeof(T) + kBeyond; bytes += kStep) {
    // Exactly so large: a read behind it is seen by AddressSanitizer.
    const std::unique_ptr<unsigned char[]> theirs(new unsigned char[bytes]());
    std::memcpy(theirs.get(), &full, std::min(bytes, sizeof(T)));
    const auto struct_size = static_cast<std::uint32_t>(bytes);
    std::memcpy(theirs.get(), &struct_size, sizeof struct_size);
    T ours{};
    EXPECT_EQ(read_struct(reinterpret_cast<const T*>(theirs.get()), "given", ours), "");
    T expected = struct_defaults<T>();
    std::memcpy(static_cast<void*>(&expected), &full, std::min(bytes, sizeof(T)));
    expected.struct_size = sizeof(T);
    EXPECT_TRUE(same_bytes(ours, expected)) << bytes;
  }
  for (std::size_t at = sizeof(T); at < sizeof(T) + kBeyond; ++at) {
    std::vector<unsigned char> theirs(sizeof(T) + kBeyond);
    const auto struct_size = static_cast<std::uint32_t>(theirs.size());
    std::memcpy(theirs.data(), &struct_size, sizeof struct_size);
    theirs[at] = 1;
    T ours{};
    const std::string problem = read_struct(reinterpret_cast<const T*>(theirs.data()), "given", ours);
    EXPECT_TRUE(test::mentions(problem, {"given: byte " + std::to_string(at)}));
  }
}

template <class... T>
void expect_read_in_any_size() {
  (expect_read<T>(), ...);
}

TEST(ReadStruct, ASmallerOneHasDefaultsAndALargerOneZeros) {
  expect_read_in_any_size<coppice_context_desc, coppice_allocator, coppice_jobs, coppice_io, coppice_log, coppice_trace,
                          coppice_vulkan_desc, coppice_device_memory, coppice_view_desc, coppice_eye, coppice_camera, coppice_sun_desc,
                          coppice_frame, coppice_vulkan_view_desc, coppice_light, coppice_occluder>();
}

TEST(ReadStruct, ASizeThatNobodySetIsRefused) {
  coppice_camera ours{};
  EXPECT_TRUE(test::mentions(read_struct<coppice_camera>(nullptr, "camera", ours), {"camera", "null"}));
  for (const std::uint32_t size : {0u, 3u, 7u, 4097u, 4100u, 0xcdcdcdcdu}) {
    coppice_camera theirs = struct_defaults<coppice_camera>();
    theirs.struct_size = size;
    EXPECT_TRUE(test::mentions(read_struct(&theirs, "camera", ours), {"camera.struct_size", std::to_string(size)}));
    EXPECT_TRUE(same_bytes(ours, struct_defaults<coppice_camera>()));
  }
}

TEST(ReadRecord, AnArrayMayBeOfShorterOrLongerRecords) {
  struct Record {
    std::uint32_t first, second;
  };
  const std::uint32_t theirs[] = {1, 2, 3, 4, 5, 6, 0, 7, 0, 8};
  Record ours{9, 9};
  EXPECT_EQ(read_record(theirs, 2, 4, "records", ours), "");
  EXPECT_TRUE(ours.first == 3 && ours.second == 9) << "what a short one has not keeps its default";
  EXPECT_EQ(read_record(theirs + 4, 0, 12, "records", ours), "");
  EXPECT_TRUE(ours.first == 5 && ours.second == 6);
  EXPECT_TRUE(test::mentions(read_record(theirs, 1, 12, "records", ours), {"records[1]: byte 8"}));
  EXPECT_EQ(records_problem(nullptr, 0, 0, "records"), "");
  EXPECT_TRUE(test::mentions(records_problem(nullptr, 1, 8, "records"), {"records", "null"}));
  for (const std::uint32_t bytes : {0u, 2u, 10u, 5000u}) EXPECT_NE(records_problem(theirs, 1, bytes, "records"), "");
}

template <class... T>
void expect_written_in_any_size() {
  const auto expect_written = []<class Each>(const Each& full) {
    expect_filled_in_any_size(full, [&](Each* theirs, std::size_t) { write_struct(full, theirs); });
  };
  (expect_written(far_from_default<T>()), ...);
}

TEST(WriteStruct, FillsAsMuchAsTheProgramHas) {
  expect_written_in_any_size<coppice_plant_info, coppice_scene_info, coppice_scene_plant_info, coppice_stats, coppice_camera,
                             coppice_view_stats, coppice_change, coppice_file_info, coppice_material, coppice_card, coppice_leaf_output>();
}

}  // namespace coppice::test::abi_test
