// What a host passes wrongly is refused with its field and index: every field of every struct of coppice.h that it fills, every pointer,
// and handles of another kind, of another context or of something that is gone.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "context_fixture.h"
#include "mentions.h"

namespace coppice::test::arguments_test {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kHuge = 3e38f;

// A struct that has grown has a field that the tables below do not know.
static_assert(sizeof(coppice_placement) == 72);
static_assert(sizeof(coppice_scene_placement) == 48);
static_assert(sizeof(coppice_sun_desc) == 48);
static_assert(sizeof(coppice_frame) == 48);
static_assert(sizeof(coppice_wind) == 96);
static_assert(sizeof(coppice_shadow_map) == 136);
static_assert(sizeof(coppice_light) == 4 * (1 + 5 * 3 + 1 + 1) + 8 + 4 * 2 + 8);
static_assert(sizeof(coppice_occluder) == 32);
static_assert(sizeof(coppice_camera) == 8 * 16 + 4 * (2 + 2 + 16 + 2 + 2 + 6) + 8);  // temporal_frame and layer_mask: of any value
static_assert(sizeof(coppice_eye) == 8 * 16 + 4 * (1 + 2 + 16 + 1));
static_assert(sizeof(coppice_view_desc) == 8);
static_assert(sizeof(coppice_vulkan_view_desc) == 96);
static_assert(sizeof(coppice_ray) == 56);  // pick_test

/// Floats of a struct.
struct FloatField {
  const char* name;
  std::size_t offset;
  std::size_t count;
  bool is_double;
  std::vector<float> wrong;  ///< beside what is wrong for all of them: not finite, 3e38
};

/// A change to a struct that makes it wrong.
template <class Struct>
struct Wrong {
  std::string field;  ///< as the log names it
  std::function<void(Struct&)> change;
};

template <class Struct>
std::vector<Wrong<Struct>> wrong_floats(const std::vector<FloatField>& fields) {
  std::vector<Wrong<Struct>> all;
  for (const FloatField& field : fields)
    for (std::size_t i = 0; i < field.count; ++i) {
      std::vector<float> values{kNan, kInf, -kInf, kHuge};
      values.insert(values.end(), field.wrong.begin(), field.wrong.end());
      const std::string name = field.count == 1 ? field.name : std::string(field.name) + "[" + std::to_string(i) + "]";
      for (const float value : values)
        all.push_back({name, [offset = field.offset, is_double = field.is_double, i, value](Struct& changed) {
                         std::byte* first = reinterpret_cast<std::byte*>(&changed) + offset;
                         const double wide = value;
                         if (is_double)
                           std::memcpy(first + i * sizeof wide, &wide, sizeof wide);
                         else
                           std::memcpy(first + i * sizeof value, &value, sizeof value);
                       }});
    }
  return all;
}

#define COPPICE_FLOATS(Struct, field, ...)                                                                                \
  FloatField {                                                                                                            \
#field, offsetof(Struct, field), sizeof(Struct::field) / sizeof(std::remove_all_extents_t <decltype(Struct::field)>), \
        std::is_same_v < std::remove_all_extents_t < decltype(Struct::field)>, double>, {                                 \
      __VA_ARGS__                                                                                                         \
    }                                                                                                                     \
  }

std::vector<Wrong<coppice_placement>> wrong_placements() {
  auto all = wrong_floats<coppice_placement>(
      {COPPICE_FLOATS(coppice_placement, position, -kHuge, 3.4e7f), COPPICE_FLOATS(coppice_placement, scale, 0.0f, -2e6f, 1e-45f, 2e6f),
       COPPICE_FLOATS(coppice_placement, rotation, -kHuge), COPPICE_FLOATS(coppice_placement, tint, -1e-3f, 7e4f, -kHuge),
       COPPICE_FLOATS(coppice_placement, lod_bias, 5.0f, -5.0f), COPPICE_FLOATS(coppice_placement, leaf_share, -0.1f, 1.1f)});
  all.push_back({"rotation", [](coppice_placement& p) { p.rotation[3] = 0.0f; }});
  all.push_back({"rotation", [](coppice_placement& p) { p.rotation[0] = 0.5f; }});
  return all;
}

std::vector<Wrong<coppice_sun_desc>> wrong_suns() {
  auto all = wrong_floats<coppice_sun_desc>({COPPICE_FLOATS(coppice_sun_desc, center, -kHuge),
                                             COPPICE_FLOATS(coppice_sun_desc, radius_m, 0.0f, -1.0f),
                                             COPPICE_FLOATS(coppice_sun_desc, sun_direction, -kHuge)});
  all.push_back({"struct_size", [](coppice_sun_desc& d) { d.struct_size = 0; }});
  all.push_back({"sun_direction", [](coppice_sun_desc& d) { std::fill_n(d.sun_direction, 3, 0.0f); }});
  all.push_back({"size_px", [](coppice_sun_desc& d) { d.size_px = 0; }});
  all.push_back({"size_px", [](coppice_sun_desc& d) { d.size_px = 0xffffffffu; }});
  return all;
}

std::vector<Wrong<coppice_wind>> wrong_winds() {
  auto all =
      wrong_floats<coppice_wind>({COPPICE_FLOATS(coppice_wind, direction, -kHuge), COPPICE_FLOATS(coppice_wind, speed, -1.0f, 101.0f),
                                  COPPICE_FLOATS(coppice_wind, gustiness, -0.1f, 1.1f)});
  all.push_back({"struct_size", [](coppice_wind& w) { w.struct_size = 0; }});
  all.push_back({"direction", [](coppice_wind& w) { w.direction[1] = 1.0f; }});
  for (const double time_s : {-1.0, 1.1e9, std::nan("")}) {
    all.push_back({"time_s", [time_s](coppice_wind& w) { w.time_s = time_s; }});
    all.push_back({"time_before_s", [time_s](coppice_wind& w) { w.time_before_s = time_s; }});
  }
  for (const double gusts_m : {1.1e11, std::nan("")}) all.push_back({"gusts_m", [gusts_m](coppice_wind& w) { w.gusts_m = gusts_m; }});
  static std::array<float, 12> map;
  const auto with_map = [](const std::function<void(coppice_wind&)>& change) {
    return [change](coppice_wind& w) {
      map.fill(1.0f);
      w.map = map.data();
      w.map_width = 3;
      w.map_height = 2;
      w.map_max[0] = w.map_max[1] = 10.0;
      change(w);
    };
  };
  for (const std::uint32_t places : {0u, 1u, 257u, 0xffffffffu}) {
    all.push_back({"map_width", with_map([places](coppice_wind& w) { w.map_width = places; })});
    all.push_back({"map_height", with_map([places](coppice_wind& w) { w.map_height = places; })});
  }
  for (const double corner : {4e7, -4e7, std::nan("")}) {
    all.push_back({"map_min", with_map([corner](coppice_wind& w) { w.map_min[1] = corner; })});
    all.push_back({"map_max", with_map([corner](coppice_wind& w) { w.map_max[0] = corner; })});
  }
  for (const float speed : {101.0f, -101.0f, kNan, kInf}) all.push_back({"map", with_map([speed](coppice_wind&) { map[7] = speed; })});
  for (const double end : {0.0, -1.0, 1e-4}) all.push_back({"map_max", with_map([end](coppice_wind& w) { w.map_max[1] = end; })});
  return all;
}

std::vector<Wrong<coppice_camera>> wrong_cameras() {
  auto all = wrong_floats<coppice_camera>({COPPICE_FLOATS(coppice_camera, view_from_world, -kHuge),
                                           COPPICE_FLOATS(coppice_camera, clip_from_view, -kHuge),
                                           COPPICE_FLOATS(coppice_camera, error_px, 0.0f, -1.0f)});
  const auto add = [&](const char* field, std::function<void(coppice_camera&)> change) { all.push_back({field, std::move(change)}); };
  add("struct_size", [](coppice_camera& v) { v.struct_size = 0; });
  add("struct_size", [](coppice_camera& v) { --v.struct_size; });
  add("struct_size", [](coppice_camera& v) { v.struct_size = 4100; });
  add("view", [](coppice_camera& v) { v.view = 0; });
  add("view", [](coppice_camera& v) { v.view ^= std::uint64_t{1} << 50; });
  add("view_from_world", [](coppice_camera& v) { std::fill_n(v.view_from_world, 16, 0.0f); });
  add("view_from_world", [](coppice_camera& v) { v.view_from_world[0] = 2.0f; });
  add("view_from_world", [](coppice_camera& v) { v.view_from_world[3] = 1.0f; });
  add("view_from_world", [](coppice_camera& v) { v.view_from_world[15] = 0.0f; });
  add("clip_from_view", [](coppice_camera& v) { std::fill_n(v.clip_from_view, 16, 0.0f); });
  add("clip_from_view", [](coppice_camera& v) { v.clip_from_view[11] = 1.0f; });
  add("clip_from_view", [](coppice_camera& v) { v.clip_from_view[15] = 1.0f; });
  add("clip_from_view[0]", [](coppice_camera& v) { v.clip_from_view[0] = 0.0f; });
  add("clip_from_view[5]", [](coppice_camera& v) { v.clip_from_view[5] = 0.0f; });
  add("clip_from_view", [](coppice_camera& v) { v.clip_from_view[14] = 0.0f; });
  add("width_px", [](coppice_camera& v) { v.width_px = 0; });
  add("width_px", [](coppice_camera& v) { v.width_px = 0x80000000u; });
  add("height_px", [](coppice_camera& v) { v.height_px = 0; });
  add("height_px", [](coppice_camera& v) { v.height_px = 0xffffffffu; });
  add("x_px", [](coppice_camera& v) { v.x_px = -1; });
  add("y_px", [](coppice_camera& v) { v.y_px = 0x7fffffff; });
  add("lod", [](coppice_camera& v) { v.lod = static_cast<coppice_lod_mode>(3); });
  add("lod", [](coppice_camera& v) { v.lod = COPPICE_LOD_MODE_MAX_ENUM; });
  add("debug_view", [](coppice_camera& v) { v.debug_view = static_cast<coppice_debug_view>(7); });
  return all;
}

std::vector<Wrong<coppice_eye>> wrong_eyes() {
  auto all = wrong_floats<coppice_eye>(
      {COPPICE_FLOATS(coppice_eye, view_from_world, -kHuge), COPPICE_FLOATS(coppice_eye, clip_from_view, -kHuge)});
  const auto add = [&](const char* field, std::function<void(coppice_eye&)> change) { all.push_back({field, std::move(change)}); };
  add("struct_size", [](coppice_eye& e) { e.struct_size = 0; });
  add("view_from_world", [](coppice_eye& e) { e.view_from_world[0] = 2.0; });
  add("clip_from_view", [](coppice_eye& e) { e.clip_from_view[11] = 1.0f; });
  add("x_px", [](coppice_eye& e) { e.x_px = -1; });
  add("y_px", [](coppice_eye& e) { e.y_px = 0x7fffffff; });
  add(" ", [](coppice_eye& e) {
    e.clip_from_view[11] = 0.0f;
    e.clip_from_view[10] = e.clip_from_view[15] = 1.0f;
  });
  add(" ", [](coppice_eye& e) { e.clip_from_view[0] *= -1.0f; });
  return all;
}

std::vector<Wrong<coppice_light>> wrong_lights() {
  auto all = wrong_floats<coppice_light>(
      {COPPICE_FLOATS(coppice_light, sun_direction, -kHuge), COPPICE_FLOATS(coppice_light, sun_color, -1.0f, -kHuge),
       COPPICE_FLOATS(coppice_light, sky_color, -1.0f, -kHuge), COPPICE_FLOATS(coppice_light, ground_color, -1.0f, -kHuge),
       COPPICE_FLOATS(coppice_light, fog_color, -1.0f, -kHuge), COPPICE_FLOATS(coppice_light, fog_density, -1.0f, -kHuge)});
  const auto add = [&](const char* field, std::function<void(coppice_light&)> change) { all.push_back({field, std::move(change)}); };
  add("struct_size", [](coppice_light& l) { --l.struct_size; });
  add("sun_direction", [](coppice_light& l) { std::fill_n(l.sun_direction, 3, 0.0f); });
  add("sun_direction", [](coppice_light& l) { std::fill_n(l.sun_direction, 3, 1.0f); });
  add("shadow_map_count", [](coppice_light& l) { l.shadow_map_count = COPPICE_MAX_SHADOW_MAPS + 1; });
  add("shadow_maps", [](coppice_light& l) { l.shadow_map_count = 1; });
  static std::array<coppice_shadow_map, 2> maps;
  const auto add_map = [&](const char* field, std::function<void()> change) {
    add(field, [change = std::move(change)](coppice_light& l) {
      for (coppice_shadow_map& map : maps) {
        map = {.image = reinterpret_cast<VkImageView>(&maps), .clip_from_world = {}};
        for (std::size_t i = 0; i < 16; i += 5) map.clip_from_world[i] = 1.0f;
      }
      l.shadow_maps = maps.data();
      l.shadow_map_count = 2;
      change();
    });
  };
  add_map("shadow_maps[1].image", [] { maps[1].image = VK_NULL_HANDLE; });
  for (const float value : {kNan, kInf, kHuge})
    add_map("shadow_maps[1].clip_from_world[7]", [value] { maps[1].clip_from_world[7] = value; });
  add_map("shadow_maps[0].clip_from_world", [] { std::fill_n(maps[0].clip_from_world, 16, 0.0f); });
  static coppice_occluder occluder;
  const auto add_occluder = [&](const char* field, std::function<void()> change) {
    add(field, [change = std::move(change)](coppice_light& l) {
      coppice_occluder_init(&occluder);
      occluder.image = reinterpret_cast<VkImageView>(&occluder);
      l.occluder = &occluder;
      change();
    });
  };
  add_occluder("occluder.struct_size", [] { occluder.struct_size = 0; });
  add_occluder("occluder.image", [] { occluder.image = VK_NULL_HANDLE; });
  add_occluder("occluder.x_px", [] { occluder.x_px = 65537; });
  add_occluder("occluder.y_px", [] { occluder.y_px = -65537; });
  add_occluder("occluder.reserved", [] { occluder.reserved = 1; });
  add("shadow_maps", [](coppice_light& l) {
    l.shadow_maps = maps.data();
    l.shadow_map_count = 2;
    l.shadow_map_bytes = 7;
  });
  return all;
}

/// Both descs of a view, good for the tests' attachments.
struct ViewDescs {
  coppice_view_desc desc;
  coppice_vulkan_view_desc vulkan;
};
ViewDescs view_descs(coppice_output output = COPPICE_OUTPUT_LIT) {
  ViewDescs descs;
  coppice_view_desc_init(&descs.desc);
  coppice_vulkan_view_desc_init(&descs.vulkan);
  descs.desc.output = output;
  if (output == COPPICE_OUTPUT_LIT) descs.vulkan.color_formats[0] = VK_FORMAT_R8G8B8A8_SRGB;
  descs.vulkan.depth_format = VK_FORMAT_D32_SFLOAT;
  return descs;
}

std::vector<Wrong<ViewDescs>> wrong_view_descs() {
  std::vector<Wrong<ViewDescs>> all{
      {"desc.struct_size", [](auto& d) { d.desc.struct_size = 0; }},
      {"vulkan.struct_size", [](auto& d) { d.vulkan.struct_size = 3; }},
      {"desc.output", [](auto& d) { d.desc.output = static_cast<coppice_output>(9); }},
      {"vulkan.color_formats[0]", [](auto& d) { d.vulkan.color_formats[0] = VK_FORMAT_UNDEFINED; }},
      {"vulkan.color_formats[0]", [](auto& d) { d.desc.output = COPPICE_OUTPUT_DEPTH; }},
      {"vulkan.color_formats[7]", [](auto& d) { d.vulkan.color_formats[7] = VK_FORMAT_R8G8B8A8_SRGB; }},
      {"vulkan.contents[1]", [](auto& d) { d.vulkan.color_formats[1] = VK_FORMAT_R8G8B8A8_SRGB; }},
      {"vulkan.contents[0]", [](auto& d) { d.vulkan.contents[0] = static_cast<coppice_content>(8); }},
      {"vulkan.contents[5]",
       [](auto& d) {
         d.desc.output = COPPICE_OUTPUT_SURFACE;
         for (int i = 0; i < 6; ++i) d.vulkan.color_formats[i] = VK_FORMAT_R8G8B8A8_UNORM;
       }},
      {"vulkan.depth_format", [](auto& d) { d.vulkan.depth_format = VK_FORMAT_UNDEFINED; }},
      {"vulkan.has_stencil", [](auto& d) { d.vulkan.has_stencil = VK_TRUE; }},
      {"vulkan.has_stencil", [](auto& d) { d.vulkan.has_stencil = 2; }},
      {"vulkan.subpass", [](auto& d) { d.vulkan.subpass = 1; }},
      {"vulkan.samples", [](auto& d) { d.vulkan.samples = static_cast<VkSampleCountFlagBits>(0); }},
      {"vulkan.samples", [](auto& d) { d.vulkan.samples = static_cast<VkSampleCountFlagBits>(3); }},
      {"vulkan.depth_compare", [](auto& d) { d.vulkan.depth_compare = VK_COMPARE_OP_NEVER; }},
      {"vulkan.depth_compare", [](auto& d) { d.vulkan.depth_compare = VK_COMPARE_OP_ALWAYS; }},
      {"vulkan.depth_compare", [](auto& d) { d.vulkan.depth_compare = static_cast<VkCompareOp>(99); }},
  };
  // Attachments that no pipeline of ours can draw to.
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UINT, VK_FORMAT_R8G8B8A8_SINT, VK_FORMAT_R32_UINT, VK_FORMAT_A2B10G10R10_UINT_PACK32,
                                VK_FORMAT_R16G16B16A16_SINT, VK_FORMAT_D32_SFLOAT, VK_FORMAT_S8_UINT})
    all.push_back({"vulkan.color_formats[0]", [format](auto& d) { d.vulkan.color_formats[0] = format; }});
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_S8_UINT, VK_FORMAT_R32_SFLOAT}) {
    all.push_back({"vulkan.depth_format", [format](auto& d) { d.vulkan.depth_format = format; }});
    all.push_back({"vulkan.depth_format", [format](auto& d) {
                     d = view_descs(COPPICE_OUTPUT_DEPTH);
                     d.vulkan.depth_format = format;
                   }});
  }
  return all;
}

std::vector<Wrong<ContextDesc>> wrong_descs() {
  std::vector<Wrong<ContextDesc>> all{
      {"vulkan.instance", [](auto& d) { d.instance = VK_NULL_HANDLE; }},
      {"vulkan.queue_family_count", [](auto& d) { d.queue_family_count = 1; }},
      {"vulkan.queue_family_count", [](auto& d) { d.queue_family_count = 4; }},
      {"vulkan.queue_families[1]", [](auto& d) { d.queue_family_count = 2; }},
      {"vulkan.physical_device", [](auto& d) { d.physical_device = VK_NULL_HANDLE; }},
      {"vulkan.device", [](auto& d) { d.device = VK_NULL_HANDLE; }},
      {"vulkan.get_instance_proc_addr", [](auto& d) { d.get_instance_proc_addr = nullptr; }},
      {"desc.memory_budget_bytes", [](auto& d) { d.memory_budget_bytes = 0; }},
      {"desc.max_instances", [](auto& d) { d.max_instances = 0; }},
      {"desc.max_instances", [](auto& d) { d.max_instances = 0xffffffffu; }},
      {"desc.max_plants", [](auto& d) { d.max_plants = 0; }},
      {"desc.max_plants", [](auto& d) { d.max_plants = 65537; }},
      {"desc.streaming_ms", [](auto& d) { d.streaming_ms = 0.0f; }},
      {"desc.streaming_ms", [](auto& d) { d.streaming_ms = -1.0f; }},
      {"desc.streaming_ms", [](auto& d) { d.streaming_ms = kNan; }},
      {"desc.prefetch_frames", [](auto& d) { d.prefetch_frames = -1.0f; }},
      {"desc.prefetch_frames", [](auto& d) { d.prefetch_frames = kNan; }},
      {"desc.prefetch_frames", [](auto& d) { d.prefetch_frames = kInf; }},
      {"desc.prefetch_frames", [](auto& d) { d.prefetch_frames = kHuge; }},
      {"vulkan.texture_compression_bc", [](auto& d) { d.texture_compression_bc = 2; }},
      {"vulkan.compute_raster", [](auto& d) { d.compute_raster = 0xffffffffu; }},
      {"vulkan.shader_int64_atomics", [](auto& d) { d.shader_int64_atomics = 7; }},
      {"vulkan.draw_indirect_count", [](auto& d) { d.draw_indirect_count = 2; }},
      {"desc.allow_outside", [](auto& d) { d.allow_outside = 2; }},
      {"vulkan.pass_times", [](auto& d) { d.pass_times = 2; }},
  };
  return all;
}

class ArgumentsTest : public ContextTest {
 protected:
  void TearDown() override {
    if (!plant_path_.empty()) std::filesystem::remove(plant_path_);
    ContextTest::TearDown();
  }

  coppice_plant open_one() {
    plant_path_ = temporary_plant({.leaf_count = 60, .seed = 5}, "arguments_test");
    return open(plant_path_);
  }

  /// The last call's status, and that the log names what was wrong, in one line.
  void expect_refused(coppice_status status, std::initializer_list<std::string_view> names) {
    EXPECT_EQ(status, COPPICE_ERROR_INVALID_ARGUMENT) << *names.begin();
    EXPECT_TRUE(mentions(log_, names));
    EXPECT_EQ(std::count(log_.begin(), log_.end(), '\n'), 1) << log_;
    log_.clear();
  }
  void expect_refused(coppice_status status, const std::string& name) {
    expect_refused(status, std::initializer_list<std::string_view>{name});
  }

  std::string plant_path_;
};

const coppice_placement kHere{{0, 0, 0}, 1.0f, {0, 0, 0, 1}, {1, 1, 1}, 0, COPPICE_ALL_LAYERS, 0, 1};

Shot good_view() {
  return make_view({.width_px = 32});
}

TEST_F(ArgumentsTest, EveryFieldOfADesc) {
  for (const auto& wrong : wrong_descs()) {
    ContextDesc changed = desc();
    wrong.change(changed);
    expect_refused(create_context(changed, &context_), wrong.field);
    ASSERT_EQ(context_, nullptr) << wrong.field;
  }
  ContextDesc changed = desc();
  static_cast<coppice_context_desc&>(changed).struct_size = 0;
  // Where the log is to be found is not known then.
  EXPECT_EQ(create_context(changed, &context_), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(mentions(coppice_last_error(nullptr), {"coppice_vulkan_context_create: desc.struct_size", "0"}));
  changed = desc();
  static_cast<coppice_vulkan_desc&>(changed).struct_size = 0;
  expect_refused(create_context(changed, &context_), "vulkan.struct_size");
}

TEST_F(ArgumentsTest, EveryFieldOfAViewDesc) {
  create(desc());
  coppice_view view = 0;
  for (const auto& wrong : wrong_view_descs()) {
    ViewDescs changed = view_descs();
    wrong.change(changed);
    expect_refused(coppice_vulkan_view_create(context_, &changed.desc, &changed.vulkan, &view), wrong.field);
    EXPECT_EQ(view, 0u);
  }
  // Right, but not what this device does.
  ViewDescs changed = view_descs();
  changed.vulkan.color_formats[0] = VK_FORMAT_BC1_RGB_SRGB_BLOCK;
  EXPECT_EQ(coppice_vulkan_view_create(context_, &changed.desc, &changed.vulkan, &view), COPPICE_ERROR_UNSUPPORTED);
  EXPECT_TRUE(mentions(log_, {"color_formats[0]"}));
  changed = view_descs();
  changed.vulkan.samples = VK_SAMPLE_COUNT_64_BIT;
  EXPECT_EQ(coppice_vulkan_view_create(context_, &changed.desc, &changed.vulkan, &view), COPPICE_ERROR_UNSUPPORTED);
  EXPECT_TRUE(mentions(log_, {"samples"}));
}

TEST_F(ArgumentsTest, EveryFieldOfAPlacement) {
  create(desc());
  const coppice_plant plant = open_one();
  coppice_instance instance = 0;
  ASSERT_EQ(coppice_instances_add(context_, plant, &kHere, sizeof(coppice_placement), 1, &instance), COPPICE_OK);
  for (const auto& wrong : wrong_placements()) {
    std::vector<coppice_placement> placements(5, kHere);
    wrong.change(placements[3]);
    expect_refused(coppice_instances_add(context_, plant, placements.data(), sizeof(coppice_placement), 5, nullptr),
                   "placements[3]." + wrong.field);
    expect_refused(coppice_instances_move(context_, &instance, &placements[3], sizeof(coppice_placement), 1),
                   "placements[0]." + wrong.field);
  }
  EXPECT_EQ(stats().instance_count, 1u);
}

TEST_F(ArgumentsTest, EveryFieldOfACameraAndALight) {
  create(desc());
  const Shot good = good_view();
  const coppice_view other = create_view();
  for (const auto& wrong : wrong_cameras()) {
    coppice_camera cameras[2] = {good, good};
    cameras[0].view = other;
    cameras[1].view = view_;
    wrong.change(cameras[1]);
    auto frame = defaults(coppice_frame_init);
    frame.frame_number = 1;
    frame.cameras = cameras;
    frame.camera_count = 2;
    expect_refused(coppice_frame_begin(context_, &frame), "frame.cameras[1]." + wrong.field);
  }
  for (const auto& wrong : wrong_eyes()) {
    Shot pair = good;
    coppice_eye eye = eye_beside(good, 0.0, 0.0);
    pair.second_eye = &eye;
    wrong.change(eye);
    expect_refused(try_begin({&pair, 1}), "frame.cameras[0].second_eye" + (wrong.field.front() == ' ' ? wrong.field : "." + wrong.field));
  }
  const Shot twice[2] = {good, good};
  expect_refused(try_begin(twice), {"frame.cameras[1].view", "frame.cameras[0]"});
  // No call gets as far as the command buffer.
  const auto cmd = reinterpret_cast<VkCommandBuffer>(this);
  for (const auto& wrong : wrong_lights()) {
    coppice_light light = good.light;
    wrong.change(light);
    expect_refused(coppice_record_cull(context_, cmd, view_, &light), "light." + wrong.field);
  }
  auto sun_desc = defaults(coppice_sun_desc_init);
  sun_desc.radius_m = 1.0f;
  sun_desc.size_px = 32;
  for (const auto& wrong : wrong_suns()) {
    coppice_sun_desc changed = sun_desc;
    auto sun = defaults(coppice_camera_init);
    wrong.change(changed);
    expect_refused(coppice_sun_camera(context_, view_, &changed, &sun), "desc." + wrong.field);
  }
}

TEST_F(ArgumentsTest, FrameNumbersGrowAndCompletedOnesDoNotFall) {
  create(desc());
  auto frame = defaults(coppice_frame_init);
  const auto begin_frame = [&](std::uint64_t number, std::uint64_t completed) {
    frame.frame_number = number;
    frame.completed_number = completed;
    return coppice_frame_begin(context_, &frame);
  };
  expect_refused(begin_frame(0, 0), "frame_number");
  EXPECT_EQ(begin_frame(8, 7), COPPICE_OK) << log_;
  expect_refused(begin_frame(8, 7), "frame_number");
  expect_refused(begin_frame(7, 6), "frame_number");
  expect_refused(begin_frame(9, 9), "completed_number");
  expect_refused(begin_frame(9, ~std::uint64_t{0}), "completed_number");
  expect_refused(begin_frame(9, 6), {"completed_number", "6"});
  EXPECT_EQ(begin_frame(9, 7), COPPICE_OK) << "what was refused has changed nothing\n" << log_;
  frame.struct_size = 1;
  expect_refused(begin_frame(10, 7), "frame.struct_size");
}

TEST_F(ArgumentsTest, WrongWindsNameTheField) {
  create(desc());
  auto frame = defaults(coppice_frame_init);
  frame.frame_number = 1;
  for (const Wrong<coppice_wind>& wrong : wrong_winds()) {
    auto wind = defaults(coppice_wind_init);
    wrong.change(wind);
    frame.wind = &wind;
    expect_refused(coppice_frame_begin(context_, &frame), "frame.wind." + wrong.field);
  }
  auto wind = defaults(coppice_wind_init);
  wind.speed = 100.0f;
  frame.wind = &wind;
  EXPECT_EQ(coppice_frame_begin(context_, &frame), COPPICE_OK) << log_;
}

TEST_F(ArgumentsTest, NoPointerMayBeNullButThoseThatSaySo) {
  coppice_context_desc_init(nullptr);
  coppice_plant_info_init(nullptr);
  coppice_scene_info_init(nullptr);
  coppice_scene_plant_info_init(nullptr);
  coppice_camera_init(nullptr);
  coppice_light_init(nullptr);
  coppice_view_desc_init(nullptr);
  coppice_vulkan_view_desc_init(nullptr);
  coppice_sun_desc_init(nullptr);
  coppice_view_stats_init(nullptr);
  coppice_frame_init(nullptr);
  coppice_stats_init(nullptr);
  coppice_context_destroy(nullptr);
  EXPECT_NE(coppice_status_text(static_cast<coppice_status>(99)), nullptr);

  const ContextDesc good = desc();
  const coppice_context_desc& core = good;
  EXPECT_EQ(coppice_vulkan_context_create(nullptr, &good, &context_), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(coppice_vulkan_context_create(&core, nullptr, &context_), COPPICE_ERROR_INVALID_ARGUMENT);
  expect_refused(create_context(good, nullptr), {": context", "null"});

  create(good);
  const coppice_plant plant = open_one();
  coppice_instance instance = 0;
  ASSERT_EQ(coppice_instances_add(context_, plant, &kHere, sizeof(coppice_placement), 1, &instance), COPPICE_OK);
  const coppice_view view = view_;
  const ViewDescs good_view_descs = view_descs();
  coppice_view made = 0;
  auto square = defaults(coppice_sun_desc_init);
  auto sun = defaults(coppice_camera_init);
  uint32_t settled = 0;
  VkBool32 ready = VK_TRUE;
  auto view_figures = defaults(coppice_view_stats_init);
  coppice_plant opened = 0;
  coppice_scene scene = 0;
  auto frame = defaults(coppice_frame_init);
  frame.frame_number = 1;
  auto stats = defaults(coppice_stats_init);
  const auto cmd = reinterpret_cast<VkCommandBuffer>(this);

  expect_refused(coppice_plant_open(context_, nullptr, &opened), "path");
  expect_refused(coppice_plant_open(context_, plant_path_.c_str(), nullptr), {": plant", "null"});
  expect_refused(coppice_plant_get_info(context_, plant, nullptr), "info");
  expect_refused(coppice_instances_add(context_, plant, nullptr, sizeof(coppice_placement), 1, nullptr), "placements");
  expect_refused(coppice_instances_move(context_, &instance, nullptr, sizeof(coppice_placement), 1), "placements");
  expect_refused(coppice_instances_remove(context_, nullptr, 1), "instances");
  expect_refused(coppice_instance_is_live(context_, instance, nullptr), "live");
  expect_refused(coppice_instances_move_live(context_, nullptr, &kHere, sizeof(coppice_placement), 1, nullptr), "instances");
  expect_refused(coppice_instances_move_live(context_, &instance, nullptr, sizeof(coppice_placement), 1, nullptr), "placements");
  expect_refused(coppice_instances_remove_live(context_, nullptr, 1, nullptr), "instances");
  expect_refused(coppice_instances_fade_in(context_, nullptr, 1, 16), "instances");
  expect_refused(coppice_scene_open(context_, nullptr, nullptr, &scene), "path");
  expect_refused(coppice_scene_open(context_, "x", nullptr, nullptr), "scene");
  expect_refused(coppice_vulkan_view_create(context_, nullptr, &good_view_descs.vulkan, &made), "desc");
  expect_refused(coppice_vulkan_view_create(context_, &good_view_descs.desc, nullptr, &made), "vulkan");
  expect_refused(coppice_vulkan_view_create(context_, &good_view_descs.desc, &good_view_descs.vulkan, nullptr), "view");
  expect_refused(coppice_sun_camera(context_, 0, &square, &sun), "view");
  expect_refused(coppice_sun_camera(context_, view, nullptr, &sun), "desc");
  expect_refused(coppice_sun_camera(context_, view, &square, nullptr), "camera");
  expect_refused(coppice_is_settled(context_, view, nullptr), "settled");
  expect_refused(coppice_pipelines_ready(context_, nullptr), {": ready", "null"});
  expect_refused(coppice_frame_begin(context_, nullptr), "frame");
  frame.camera_count = 1;
  expect_refused(coppice_frame_begin(context_, &frame), "cameras");
  frame.camera_count = 0;
  expect_refused(coppice_record_upload(context_, nullptr), "cmd");
  expect_refused(coppice_record_cull(context_, nullptr, view, nullptr), "cmd");
  expect_refused(coppice_record_cull(context_, cmd, 0, nullptr), "view");
  expect_refused(coppice_record_draw(context_, nullptr, view, 0), "cmd");
  expect_refused(coppice_record_draw(context_, cmd, 0, 0), "view");
  expect_refused(coppice_get_stats(context_, nullptr), "stats");
  expect_refused(coppice_get_view_stats(context_, view, nullptr), "stats");
  EXPECT_EQ(coppice_instances_add(context_, plant, nullptr, sizeof(coppice_placement), 0, nullptr), COPPICE_OK);
  EXPECT_EQ(coppice_instances_remove(context_, nullptr, 0), COPPICE_OK);
  EXPECT_EQ(coppice_plant_reload(context_, plant, nullptr), COPPICE_OK) << log_;

  auto info = defaults(coppice_plant_info_init);
  auto scene_info = defaults(coppice_scene_info_init);
  auto scene_plant = defaults(coppice_scene_plant_info_init);
  const coppice_scene_placement scene_placement{};
  const double origin[3]{};
  for (const coppice_status status : {coppice_set_memory_budget(nullptr, 1u << 30),
                                      coppice_retry_failed(nullptr),
                                      coppice_set_origin(nullptr, origin),
                                      coppice_plant_open(nullptr, "x", &opened),
                                      coppice_plant_close(nullptr, plant),
                                      coppice_plant_reload(nullptr, plant, "x"),
                                      coppice_plant_get_info(nullptr, plant, &info),
                                      coppice_instances_add(nullptr, plant, &kHere, sizeof(coppice_placement), 1, nullptr),
                                      coppice_instances_move(nullptr, &instance, &kHere, sizeof(coppice_placement), 1),
                                      coppice_instances_remove(nullptr, &instance, 1),
                                      coppice_instance_is_live(nullptr, instance, &settled),
                                      coppice_instances_move_live(nullptr, &instance, &kHere, sizeof(coppice_placement), 1, nullptr),
                                      coppice_instances_remove_live(nullptr, &instance, 1, nullptr),
                                      coppice_instances_fade_in(nullptr, &instance, 1, 16),
                                      coppice_scene_open(nullptr, "x", nullptr, &scene),
                                      coppice_scene_move(nullptr, 1, &scene_placement),
                                      coppice_scene_close(nullptr, 1),
                                      coppice_scene_get_info(nullptr, 1, &scene_info),
                                      coppice_scene_get_plant(nullptr, 1, 0, &scene_plant),
                                      coppice_vulkan_view_create(nullptr, &good_view_descs.desc, &good_view_descs.vulkan, &made),
                                      coppice_view_destroy(nullptr, view),
                                      coppice_is_settled(nullptr, view, &settled),
                                      coppice_pipelines_ready(nullptr, &ready),
                                      coppice_sun_camera(nullptr, view, &square, &sun),
                                      coppice_frame_begin(nullptr, &frame),
                                      coppice_record_upload(nullptr, cmd),
                                      coppice_record_cull(nullptr, cmd, view, nullptr),
                                      coppice_record_draw(nullptr, cmd, view, 0),
                                      coppice_get_stats(nullptr, &stats),
                                      coppice_get_view_stats(nullptr, view, &view_figures)})
    EXPECT_EQ(status, COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(ready, VK_FALSE);
}

TEST_F(ArgumentsTest, AHandleIsGoodInItsContextForItsKind) {
  create(desc());
  const coppice_plant plant = open_one();
  coppice_instance instances[2] = {};
  const coppice_placement both[2] = {kHere, kHere};
  ASSERT_EQ(coppice_instances_add(context_, plant, both, sizeof(coppice_placement), 2, instances), COPPICE_OK);
  // The other context holds the same things at the same indices.
  coppice_context* const first = context_;
  create(desc());
  const coppice_plant others = open(plant_path_);
  coppice_instance other_instances[2] = {};
  ASSERT_EQ(coppice_instances_add(context_, others, both, sizeof(coppice_placement), 2, other_instances), COPPICE_OK);
  log_.clear();

  auto info = defaults(coppice_plant_info_init);
  // After the colon stands the argument, after it whose handle it is.
  expect_refused(coppice_instances_add(context_, plant, &kHere, sizeof(coppice_placement), 1, nullptr), {": plant", "context"});
  expect_refused(coppice_plant_get_info(context_, plant, &info), {": plant", "context"});
  expect_refused(coppice_plant_reload(context_, plant, nullptr), {": plant", "context"});
  expect_refused(coppice_plant_close(context_, plant), {": plant", "context"});
  expect_refused(coppice_instances_move(context_, &instances[0], &kHere, sizeof(coppice_placement), 1), {": instances[0]", "context"});
  const coppice_instance mixed[2] = {other_instances[0], instances[1]};
  expect_refused(coppice_instances_remove(context_, mixed, 2), {": instances[1]", "context"});
  EXPECT_EQ(stats().instance_count, 2u) << "none was removed";

  expect_refused(coppice_instances_move(context_, &others, &kHere, sizeof(coppice_placement), 1), {": instances[0]", "plant"});
  expect_refused(coppice_plant_close(context_, other_instances[0]), {": plant", "instance"});
  expect_refused(coppice_scene_close(context_, others), {": scene", "plant"});
  for (const std::uint64_t garbage : {0x1ull, ~0ull, 0x8000000000000000ull, 0x123456789abcdefull}) {
    expect_refused(coppice_plant_close(context_, garbage), ": plant");
    expect_refused(coppice_instances_move(context_, &garbage, &kHere, sizeof(coppice_placement), 1), ": instances[0]");
    expect_refused(coppice_scene_close(context_, garbage), ": scene");
  }
  expect_refused(coppice_plant_close(context_, 0), {": plant", "0"});

  ASSERT_EQ(coppice_instances_remove(context_, other_instances, 1), COPPICE_OK);
  expect_refused(coppice_instances_move(context_, &other_instances[0], &kHere, sizeof(coppice_placement), 1), ": instances[0]");
  const coppice_view gone = create_view();
  ASSERT_EQ(coppice_view_destroy(context_, gone), COPPICE_OK);
  expect_refused(coppice_view_destroy(context_, gone), ": view");
  expect_refused(coppice_view_destroy(context_, others), {": view", "plant"});
  expect_refused(coppice_plant_close(context_, view_), {": plant", "view"});
  ASSERT_EQ(coppice_plant_close(context_, others), COPPICE_OK);
  expect_refused(coppice_plant_close(context_, others), ": plant");
  EXPECT_EQ(coppice_plant_close(first, plant), COPPICE_OK) << log_;
  coppice_context_destroy(first);
}

/// The number that a context is refused with is the least that it is made with.
TEST_F(ArgumentsTest, ABudgetBelowWhatAContextTakesIsRefusedWithWhatItNeeds) {
  struct Size {
    VkBool32 compute_raster;
    std::uint32_t max_instances;
  };
  for (const auto [compute_raster, max_instances] : {Size{VK_TRUE, 4096}, Size{VK_FALSE, 2000000}}) {
    ContextDesc with = desc();
    with.compute_raster = compute_raster;
    with.max_instances = max_instances;
    with.memory_budget_bytes = 1u << 20;
    log_.clear();
    ASSERT_EQ(create_context(with, &context_), COPPICE_ERROR_INVALID_ARGUMENT);
    const std::string before = "MiB (";
    const std::size_t at = log_.find(before);
    ASSERT_NE(at, std::string::npos) << log_;
    const unsigned long long least = std::stoull(log_.substr(at + before.size()));
    log_.clear();
    with.memory_budget_bytes = least - 1;
    expect_refused(create_context(with, &context_), "(" + std::to_string(least) + " bytes)");
    with.memory_budget_bytes = least;
    ASSERT_EQ(create_context(with, &context_), COPPICE_OK) << log_;
    EXPECT_LE(stats().memory_bytes, least);
    expect_refused(coppice_set_memory_budget(context_, least - 1), std::to_string(least));
    expect_refused(coppice_set_memory_budget(context_, 0), std::to_string(least));
    EXPECT_EQ(coppice_set_memory_budget(context_, least), COPPICE_OK);
    EXPECT_EQ(stats().memory_budget_bytes, least);
    destroy();
  }
}

}  // namespace coppice::test::arguments_test
