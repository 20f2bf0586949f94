// What a host passes wrongly is refused with its field and index: every field of every struct of coppice.h that it fills, every pointer,
// and handles of another kind, of another context or of something that is gone.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "context_fixture.h"

namespace coppice::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kHuge = 3e38f;

// A struct that has grown has a field that the tables below do not know.
static_assert(sizeof(coppice_placement) == 44);
static_assert(sizeof(coppice_shadow_desc) == 20);
static_assert(sizeof(coppice_frame) == 32);
static_assert(sizeof(coppice_shadow_cascade) == 72);
static_assert(sizeof(coppice_view) == 4 * (1 + 16 + 16 + 2 + 1 + 1 + 1) + 4 * (5 * 3 + 1) + 4 * 3 + 4 + 3 * sizeof(coppice_shadow_cascade) +
                                          8);  // temporal_frame, of any value, and padding

/// Floats of a struct.
struct FloatField {
  const char* name;
  std::size_t offset;
  std::size_t count;
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
        all.push_back({name, [at = field.offset + i * sizeof(float), value](Struct& changed) {
                         std::memcpy(reinterpret_cast<std::byte*>(&changed) + at, &value, sizeof value);
                       }});
    }
  return all;
}

#define COPPICE_FLOATS(Struct, field, ...)                                    \
  FloatField {                                                                \
#field, offsetof(Struct, field), sizeof(Struct::field) / sizeof(float), { \
      __VA_ARGS__                                                             \
    }                                                                         \
  }

std::vector<Wrong<coppice_placement>> wrong_placements() {
  auto all = wrong_floats<coppice_placement>(
      {COPPICE_FLOATS(coppice_placement, position, -kHuge, 2e9f), COPPICE_FLOATS(coppice_placement, scale, 0.0f, -1.0f, 1e-45f, 2e6f),
       COPPICE_FLOATS(coppice_placement, rotation, -kHuge), COPPICE_FLOATS(coppice_placement, tint, -1e-3f, -kHuge)});
  all.push_back({"rotation", [](coppice_placement& p) { p.rotation[3] = 0.0f; }});
  all.push_back({"rotation", [](coppice_placement& p) { p.rotation[0] = 0.5f; }});
  return all;
}

std::vector<Wrong<coppice_shadow_desc>> wrong_shadows() {
  auto all = wrong_floats<coppice_shadow_desc>(
      {COPPICE_FLOATS(coppice_shadow_desc, center, -kHuge), COPPICE_FLOATS(coppice_shadow_desc, radius_m, 0.0f, -1.0f)});
  all.push_back({"size_px", [](coppice_shadow_desc& d) { d.size_px = 0; }});
  all.push_back({"size_px", [](coppice_shadow_desc& d) { d.size_px = 0xffffffffu; }});
  return all;
}

std::vector<Wrong<coppice_view>> wrong_views() {
  auto all = wrong_floats<coppice_view>(
      {COPPICE_FLOATS(coppice_view, view_from_world, -kHuge), COPPICE_FLOATS(coppice_view, clip_from_view, -kHuge),
       COPPICE_FLOATS(coppice_view, error_px, 0.0f, -1.0f), COPPICE_FLOATS(coppice_view, sun_direction, -kHuge),
       COPPICE_FLOATS(coppice_view, sun_color, -1.0f, -kHuge), COPPICE_FLOATS(coppice_view, sky_color, -1.0f, -kHuge),
       COPPICE_FLOATS(coppice_view, ground_color, -1.0f, -kHuge), COPPICE_FLOATS(coppice_view, fog_color, -1.0f, -kHuge),
       COPPICE_FLOATS(coppice_view, fog_density, -1.0f, -kHuge)});
  const auto add = [&](const char* field, std::function<void(coppice_view&)> change) { all.push_back({field, std::move(change)}); };
  add("struct_size", [](coppice_view& v) { v.struct_size = 0; });
  add("struct_size", [](coppice_view& v) { --v.struct_size; });
  add("view_from_world", [](coppice_view& v) { std::fill_n(v.view_from_world, 16, 0.0f); });
  add("view_from_world", [](coppice_view& v) { v.view_from_world[0] = 2.0f; });
  add("view_from_world", [](coppice_view& v) { v.view_from_world[3] = 1.0f; });
  add("view_from_world", [](coppice_view& v) { v.view_from_world[15] = 0.0f; });
  add("clip_from_view", [](coppice_view& v) { std::fill_n(v.clip_from_view, 16, 0.0f); });
  add("clip_from_view", [](coppice_view& v) { v.clip_from_view[11] = 1.0f; });
  add("clip_from_view", [](coppice_view& v) { v.clip_from_view[15] = 1.0f; });
  add("clip_from_view[0]", [](coppice_view& v) { v.clip_from_view[0] = 0.0f; });
  add("clip_from_view[5]", [](coppice_view& v) { v.clip_from_view[5] = 0.0f; });
  add("clip_from_view", [](coppice_view& v) { v.clip_from_view[14] = 0.0f; });
  add("width_px", [](coppice_view& v) { v.width_px = 0; });
  add("width_px", [](coppice_view& v) { v.width_px = 0x80000000u; });
  add("height_px", [](coppice_view& v) { v.height_px = 0; });
  add("height_px", [](coppice_view& v) { v.height_px = 0xffffffffu; });
  add("lod", [](coppice_view& v) { v.lod = static_cast<coppice_lod_mode>(3); });
  add("lod", [](coppice_view& v) { v.lod = COPPICE_LOD_MODE_MAX_ENUM; });
  add("sun_direction", [](coppice_view& v) { std::fill_n(v.sun_direction, 3, 0.0f); });
  add("sun_direction", [](coppice_view& v) { std::fill_n(v.sun_direction, 3, 1.0f); });
  add("debug_view", [](coppice_view& v) { v.debug_view = static_cast<coppice_debug_view>(7); });
  add("kind", [](coppice_view& v) { v.kind = static_cast<coppice_view_kind>(2); });
  add("kind", [](coppice_view& v) { v.kind = COPPICE_VIEW_SHADOW; });  // of a context without them
  add("shadow_cascade_count", [](coppice_view& v) { v.shadow_cascade_count = COPPICE_MAX_SHADOW_CASCADES + 1; });
  const auto with_cascades = [](coppice_view& v) {
    v.shadow_cascade_count = 2;
    for (coppice_shadow_cascade& cascade : v.shadow_cascades) {
      cascade.image = reinterpret_cast<VkImageView>(&v);
      std::copy_n(v.view_from_world, 16, cascade.clip_from_world);
    }
  };
  add("shadow_cascades[1].image", [=](coppice_view& v) {
    with_cascades(v);
    v.shadow_cascades[1].image = VK_NULL_HANDLE;
  });
  for (const float value : {kNan, kInf, kHuge})
    add("shadow_cascades[1].clip_from_world[7]", [=](coppice_view& v) {
      with_cascades(v);
      v.shadow_cascades[1].clip_from_world[7] = value;
    });
  add("shadow_cascades[0].clip_from_world", [=](coppice_view& v) {
    with_cascades(v);
    std::fill_n(v.shadow_cascades[0].clip_from_world, 16, 0.0f);
  });
  return all;
}

std::vector<Wrong<coppice_context_desc>> wrong_descs() {
  std::vector<Wrong<coppice_context_desc>> all{
      {"instance", [](auto& d) { d.instance = VK_NULL_HANDLE; }},
      {"physical_device", [](auto& d) { d.physical_device = VK_NULL_HANDLE; }},
      {"device", [](auto& d) { d.device = VK_NULL_HANDLE; }},
      {"get_instance_proc_addr", [](auto& d) { d.get_instance_proc_addr = nullptr; }},
      {"color_format", [](auto& d) { d.color_format = VK_FORMAT_UNDEFINED; }},
      {"depth_format", [](auto& d) { d.depth_format = VK_FORMAT_UNDEFINED; }},
      {"samples", [](auto& d) { d.samples = static_cast<VkSampleCountFlagBits>(0); }},
      {"samples", [](auto& d) { d.samples = static_cast<VkSampleCountFlagBits>(3); }},
      {"depth_compare", [](auto& d) { d.depth_compare = VK_COMPARE_OP_NEVER; }},
      {"depth_compare", [](auto& d) { d.depth_compare = VK_COMPARE_OP_ALWAYS; }},
      {"depth_compare", [](auto& d) { d.depth_compare = static_cast<VkCompareOp>(99); }},
      {"memory_budget_bytes", [](auto& d) { d.memory_budget_bytes = 0; }},
      {"max_instances", [](auto& d) { d.max_instances = 0; }},
      {"max_instances", [](auto& d) { d.max_instances = 0xffffffffu; }},
      {"max_plants", [](auto& d) { d.max_plants = 0; }},
      {"max_plants", [](auto& d) { d.max_plants = 65537; }},
      {"streaming_ms", [](auto& d) { d.streaming_ms = 0.0f; }},
      {"streaming_ms", [](auto& d) { d.streaming_ms = -1.0f; }},
      {"streaming_ms", [](auto& d) { d.streaming_ms = kNan; }},
      {"prefetch_frames", [](auto& d) { d.prefetch_frames = -1.0f; }},
      {"prefetch_frames", [](auto& d) { d.prefetch_frames = kNan; }},
      {"prefetch_frames", [](auto& d) { d.prefetch_frames = kInf; }},
      {"prefetch_frames", [](auto& d) { d.prefetch_frames = kHuge; }},
      {"texture_compression_bc", [](auto& d) { d.texture_compression_bc = 2; }},
      {"compute_raster", [](auto& d) { d.compute_raster = 0xffffffffu; }},
      {"shader_int64_atomics", [](auto& d) { d.shader_int64_atomics = 7; }},
      {"allow_outside", [](auto& d) { d.allow_outside = 2; }},
      {"pass_times", [](auto& d) { d.pass_times = 2; }},
  };
  // Attachments that no pipeline of ours can draw to.
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UINT, VK_FORMAT_R8G8B8A8_SINT, VK_FORMAT_R32_UINT, VK_FORMAT_A2B10G10R10_UINT_PACK32,
                                VK_FORMAT_R16G16B16A16_SINT, VK_FORMAT_D32_SFLOAT, VK_FORMAT_S8_UINT})
    all.push_back({"color_format", [format](auto& d) { d.color_format = format; }});
  for (const VkFormat format : {VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_S8_UINT, VK_FORMAT_R32_SFLOAT}) {
    all.push_back({"depth_format", [format](auto& d) { d.depth_format = format; }});
    all.push_back({"shadow_format", [format](auto& d) { d.shadow_format = format; }});
  }
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
  void expect_refused(coppice_status status, const std::string& named) {
    EXPECT_EQ(status, COPPICE_ERROR_INVALID_ARGUMENT) << named;
    EXPECT_NE(log_.find(named), std::string::npos) << named << " is not in: " << log_;
    EXPECT_EQ(std::count(log_.begin(), log_.end(), '\n'), 1) << log_;
    log_.clear();
  }

  std::string plant_path_;
};

const coppice_placement kHere{{0, 0, 0}, 1.0f, {0, 0, 0, 1}, {1, 1, 1}};

coppice_view good_view() {
  return make_view({.width_px = 32, .height_px = 32});
}

TEST_F(ArgumentsTest, EveryFieldOfADesc) {
  for (const auto& wrong : wrong_descs()) {
    coppice_context_desc changed = desc();
    wrong.change(changed);
    expect_refused(coppice_context_create(&changed, &context_), wrong.field);
    ASSERT_EQ(context_, nullptr) << wrong.field;
  }
  coppice_context_desc changed = desc();
  changed.struct_size = 8;
  EXPECT_EQ(coppice_context_create(&changed, &context_), COPPICE_ERROR_INVALID_ARGUMENT);
  // Right, but not what this device does.
  changed = desc();
  changed.color_format = VK_FORMAT_BC1_RGB_SRGB_BLOCK;
  EXPECT_EQ(coppice_context_create(&changed, &context_), COPPICE_ERROR_UNSUPPORTED);
  EXPECT_NE(log_.find("color_format"), std::string::npos) << log_;
  changed = desc();
  changed.samples = VK_SAMPLE_COUNT_64_BIT;
  EXPECT_EQ(coppice_context_create(&changed, &context_), COPPICE_ERROR_UNSUPPORTED);
  EXPECT_NE(log_.find("samples"), std::string::npos) << log_;
}

TEST_F(ArgumentsTest, EveryFieldOfAPlacement) {
  create(desc());
  const coppice_plant plant = open_one();
  coppice_instance instance = 0;
  ASSERT_EQ(coppice_instances_add(context_, plant, &kHere, 1, &instance), COPPICE_OK);
  for (const auto& wrong : wrong_placements()) {
    std::vector<coppice_placement> placements(5, kHere);
    wrong.change(placements[3]);
    expect_refused(coppice_instances_add(context_, plant, placements.data(), 5, nullptr), "placements[3]." + wrong.field);
    expect_refused(coppice_instance_move(context_, instance, &placements[3]), "placement." + wrong.field);
  }
  EXPECT_EQ(stats().instance_count, 1u);
}

TEST_F(ArgumentsTest, EveryFieldOfAView) {
  create(desc());
  const coppice_shadow_desc square{{0, 0, 0}, 1.0f, 32};
  // No call gets as far as the command buffer.
  const auto cmd = reinterpret_cast<VkCommandBuffer>(this);
  for (const auto& wrong : wrong_views()) {
    coppice_view view = good_view(), sun{};
    wrong.change(view);
    coppice_frame frame;
    coppice_frame_init(&frame);
    frame.frame_number = 1;
    frame.view = &view;
    const std::string named = "view." + wrong.field;
    expect_refused(coppice_frame_begin(context_, &frame), named);
    expect_refused(coppice_record_cull(context_, cmd, &view), named);
    expect_refused(coppice_record_draw(context_, cmd, &view), named);
    expect_refused(coppice_shadow_view(context_, &view, &square, &sun), named);
  }
  const coppice_view view = good_view();
  for (const auto& wrong : wrong_shadows()) {
    coppice_shadow_desc changed = square;
    coppice_view sun{};
    wrong.change(changed);
    expect_refused(coppice_shadow_view(context_, &view, &changed, &sun), "desc." + wrong.field);
  }
}

TEST_F(ArgumentsTest, FrameNumbersGrowAndCompletedOnesDoNotFall) {
  create(desc());
  const coppice_view view = good_view();
  coppice_frame frame;
  coppice_frame_init(&frame);
  frame.view = &view;
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
  expect_refused(begin_frame(9, 6), "completed_number falls");
  EXPECT_EQ(begin_frame(9, 7), COPPICE_OK) << "what was refused has changed nothing\n" << log_;
  frame.struct_size = 1;
  expect_refused(begin_frame(10, 7), "frame.struct_size");
}

TEST_F(ArgumentsTest, NoPointerMayBeNullButThoseThatSaySo) {
  coppice_context_desc_init(nullptr);
  coppice_plant_info_init(nullptr);
  coppice_scene_info_init(nullptr);
  coppice_scene_plant_info_init(nullptr);
  coppice_view_init(nullptr);
  coppice_frame_init(nullptr);
  coppice_stats_init(nullptr);
  coppice_context_destroy(nullptr);
  EXPECT_NE(coppice_status_text(static_cast<coppice_status>(99)), nullptr);

  const coppice_context_desc good = desc();
  EXPECT_EQ(coppice_context_create(nullptr, &context_), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(coppice_context_create(&good, nullptr), COPPICE_ERROR_INVALID_ARGUMENT);

  create(good);
  const coppice_plant plant = open_one();
  coppice_instance instance = 0;
  ASSERT_EQ(coppice_instances_add(context_, plant, &kHere, 1, &instance), COPPICE_OK);
  const coppice_view view = good_view();
  const coppice_shadow_desc square{{0, 0, 0}, 1.0f, 32};
  coppice_view sun{};
  coppice_plant opened = 0;
  coppice_scene scene = 0;
  coppice_frame frame;
  coppice_frame_init(&frame);
  frame.frame_number = 1;
  coppice_stats stats;
  coppice_stats_init(&stats);
  const auto cmd = reinterpret_cast<VkCommandBuffer>(this);

  expect_refused(coppice_plant_open(context_, nullptr, &opened), "path");
  expect_refused(coppice_plant_open(context_, plant_path_.c_str(), nullptr), "plant is null");
  expect_refused(coppice_plant_get_info(context_, plant, nullptr), "info");
  expect_refused(coppice_instances_add(context_, plant, nullptr, 1, nullptr), "placements");
  expect_refused(coppice_instance_move(context_, instance, nullptr), "placement");
  expect_refused(coppice_instances_remove(context_, nullptr, 1), "instances");
  expect_refused(coppice_scene_open(context_, nullptr, &scene), "path");
  expect_refused(coppice_scene_open(context_, "x", nullptr), "scene");
  expect_refused(coppice_shadow_view(context_, nullptr, &square, &sun), "view");
  expect_refused(coppice_shadow_view(context_, &view, nullptr, &sun), "desc");
  expect_refused(coppice_shadow_view(context_, &view, &square, nullptr), "shadow");
  expect_refused(coppice_frame_begin(context_, nullptr), "frame");
  expect_refused(coppice_frame_begin(context_, &frame), "view");
  expect_refused(coppice_record_upload(context_, nullptr), "cmd");
  expect_refused(coppice_record_cull(context_, nullptr, &view), "cmd");
  expect_refused(coppice_record_cull(context_, cmd, nullptr), "view");
  expect_refused(coppice_record_draw(context_, nullptr, &view), "cmd");
  expect_refused(coppice_record_draw(context_, cmd, nullptr), "view");
  expect_refused(coppice_get_stats(context_, nullptr), "stats");
  EXPECT_EQ(coppice_instances_add(context_, plant, nullptr, 0, nullptr), COPPICE_OK);
  EXPECT_EQ(coppice_instances_remove(context_, nullptr, 0), COPPICE_OK);
  EXPECT_EQ(coppice_plant_reload(context_, plant, nullptr), COPPICE_OK) << log_;

  coppice_plant_info info;
  coppice_plant_info_init(&info);
  coppice_scene_info scene_info;
  coppice_scene_info_init(&scene_info);
  coppice_scene_plant_info scene_plant;
  coppice_scene_plant_info_init(&scene_plant);
  frame.view = &view;
  for (const coppice_status status :
       {coppice_set_memory_budget(nullptr, 1u << 30), coppice_plant_open(nullptr, "x", &opened), coppice_plant_close(nullptr, plant),
        coppice_plant_reload(nullptr, plant, "x"), coppice_plant_get_info(nullptr, plant, &info),
        coppice_instances_add(nullptr, plant, &kHere, 1, nullptr), coppice_instance_move(nullptr, instance, &kHere),
        coppice_instances_remove(nullptr, &instance, 1), coppice_scene_open(nullptr, "x", &scene), coppice_scene_close(nullptr, 1),
        coppice_scene_get_info(nullptr, 1, &scene_info), coppice_scene_get_plant(nullptr, 1, 0, &scene_plant),
        coppice_shadow_view(nullptr, &view, &square, &sun), coppice_frame_begin(nullptr, &frame), coppice_record_upload(nullptr, cmd),
        coppice_record_cull(nullptr, cmd, &view), coppice_record_draw(nullptr, cmd, &view), coppice_get_stats(nullptr, &stats)})
    EXPECT_EQ(status, COPPICE_ERROR_INVALID_ARGUMENT);
}

TEST_F(ArgumentsTest, AHandleIsGoodInItsContextForItsKind) {
  create(desc());
  const coppice_plant plant = open_one();
  coppice_instance instances[2] = {};
  const coppice_placement both[2] = {kHere, kHere};
  ASSERT_EQ(coppice_instances_add(context_, plant, both, 2, instances), COPPICE_OK);
  // The other context holds the same things at the same indices.
  coppice_context* const first = context_;
  create(desc());
  const coppice_plant others = open(plant_path_);
  coppice_instance other_instances[2] = {};
  ASSERT_EQ(coppice_instances_add(context_, others, both, 2, other_instances), COPPICE_OK);
  log_.clear();

  coppice_plant_info info;
  coppice_plant_info_init(&info);
  const std::string elsewhere = " is a handle of another context";
  expect_refused(coppice_instances_add(context_, plant, &kHere, 1, nullptr), "plant" + elsewhere);
  expect_refused(coppice_plant_get_info(context_, plant, &info), "plant" + elsewhere);
  expect_refused(coppice_plant_reload(context_, plant, nullptr), "plant" + elsewhere);
  expect_refused(coppice_plant_close(context_, plant), "plant" + elsewhere);
  expect_refused(coppice_instance_move(context_, instances[0], &kHere), "instance" + elsewhere);
  const coppice_instance mixed[2] = {other_instances[0], instances[1]};
  expect_refused(coppice_instances_remove(context_, mixed, 2), "instances[1]" + elsewhere);
  EXPECT_EQ(stats().instance_count, 2u) << "none was removed";

  expect_refused(coppice_instance_move(context_, others, &kHere), "instance is a plant's handle");
  expect_refused(coppice_plant_close(context_, other_instances[0]), "plant is an instance's handle");
  expect_refused(coppice_scene_close(context_, others), "scene is a plant's handle");
  for (const std::uint64_t garbage : {0x1ull, ~0ull, 0x8000000000000000ull, 0x123456789abcdefull}) {
    expect_refused(coppice_plant_close(context_, garbage), "plant is");
    expect_refused(coppice_instance_move(context_, garbage, &kHere), "instance is");
    expect_refused(coppice_scene_close(context_, garbage), "scene is");
  }
  expect_refused(coppice_plant_close(context_, 0), "plant is 0");

  ASSERT_EQ(coppice_instances_remove(context_, other_instances, 1), COPPICE_OK);
  expect_refused(coppice_instance_move(context_, other_instances[0], &kHere), "instance has been removed");
  ASSERT_EQ(coppice_plant_close(context_, others), COPPICE_OK);
  expect_refused(coppice_plant_close(context_, others), "plant has been closed");
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
    coppice_context_desc with = desc();
    with.compute_raster = compute_raster;
    with.max_instances = max_instances;
    with.memory_budget_bytes = 1u << 20;
    log_.clear();
    ASSERT_EQ(coppice_context_create(&with, &context_), COPPICE_ERROR_INVALID_ARGUMENT);
    unsigned long long least = 0;
    const std::size_t at = log_.find("MiB (");
    ASSERT_NE(at, std::string::npos) << log_;
    ASSERT_EQ(std::sscanf(log_.c_str() + at, "MiB (%llu bytes)", &least), 1) << log_;
    log_.clear();
    with.memory_budget_bytes = least - 1;
    expect_refused(coppice_context_create(&with, &context_), "(" + std::to_string(least) + " bytes)");
    with.memory_budget_bytes = least;
    create(with);
    EXPECT_LE(stats().memory_bytes, least);
    expect_refused(coppice_set_memory_budget(context_, least - 1), std::to_string(least));
    expect_refused(coppice_set_memory_budget(context_, 0), std::to_string(least));
    EXPECT_EQ(coppice_set_memory_budget(context_, least), COPPICE_OK);
    EXPECT_EQ(stats().memory_budget_bytes, least);
    coppice_context_destroy(context_);
    context_ = nullptr;
  }
}

}  // namespace
}  // namespace coppice::test
