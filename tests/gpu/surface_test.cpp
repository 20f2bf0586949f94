// What views of COPPICE_OUTPUT_SURFACE write: an engine that lights it by coppice_surface.glsl gets the lit picture, its user words, and
// how far each place has moved.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "compute_pass.h"
#include "frame_wind.h"
#include "path_fixture.h"
#include "reader.h"
#include "render_pass.h"
#include "srgb.h"
#include "surface_host_comp.h"

namespace coppice::test::surface_test {

constexpr std::uint32_t kSidePx = 160;
constexpr std::size_t kPixels = std::size_t{kSidePx} * kSidePx;

constexpr std::array kSurface{Color{VK_FORMAT_R8G8B8A8_SRGB, COPPICE_CONTENT_ALBEDO},
                              Color{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_NORMAL},
                              Color{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_LIGHT}, Color{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_USER},
                              Color{VK_FORMAT_R32G32B32A32_SFLOAT, COPPICE_CONTENT_VELOCITY}};

constexpr std::array kLit{Color{VK_FORMAT_R8G8B8A8_SRGB, COPPICE_CONTENT_LIT}};

PassTarget target_of(const VulkanDevice& gpu, std::span<const Color> colors) {
  return PassTarget(gpu, kSidePx, formats_of(colors));
}

/// The lighting pass of surface_host.comp.
class HostLight {
 public:
  explicit HostLight(const VulkanDevice& gpu)
      : gpu_(gpu),
        pass_(gpu, surface_host_comp_spirv,
              {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
               VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
               VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}),
        frame_(gpu, sizeof(Frame), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT),
        radiance_(gpu, kPixels * sizeof(glm::vec4), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT) {
    pass_.bind(4, frame_);
    pass_.bind(5, radiance_);
  }

  /// target: kSurface's, drawn; its images become readable. Linear, [pixels]
  std::vector<glm::vec4> light(const PassTarget& target, const Shot& shot) {
    glm::dmat4 from_view = glm::make_mat4(shot.view_from_world);
    from_view[3] = {0, 0, 0, 1};
    const Frame frame{glm::mat4(glm::inverse(glm::dmat4(glm::make_mat4(shot.clip_from_view)) * from_view)),
                      glm::make_vec3(shot.light.sun_direction), glm::make_vec3(shot.light.sun_color), glm::make_vec3(shot.light.sky_color),
                      glm::make_vec3(shot.light.ground_color)};
    std::memcpy(frame_.mapped(), &frame, sizeof frame);
    const std::array<const Image*, 4> images{target.colors[0].get(), target.colors[1].get(), target.colors[2].get(), &target.depth};
    for (std::uint32_t i = 0; i < images.size(); ++i) pass_.bind(i, *images[i]);
    submit(gpu_, [&](VkCommandBuffer cmd) {
      for (const Image* image : images) change_layout(cmd, *image, image->attachment_layout(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
      pass_.record(cmd, (kSidePx + 7) / 8, (kSidePx + 7) / 8);
      full_barrier(cmd);
    });
    std::vector<glm::vec4> radiance(kPixels);
    std::memcpy(radiance.data(), radiance_.mapped(), kPixels * sizeof(glm::vec4));
    return radiance;
  }

 private:
  struct Frame {
    glm::mat4 from_eye;
    glm::vec3 sun_direction, sun_color, sky_color, ground_color;
  };

  const VulkanDevice& gpu_;
  ComputePass pass_;
  Buffer frame_, radiance_;
};

class SurfaceTest : public PathTest<ContextTest> {
 protected:
  static coppice_placement placement(glm::vec3 at, std::uint32_t user_data) {
    coppice_placement placement = placement_at(at);
    placement.user_data = user_data;
    return placement;
  }
  void place_rows() {
    placements_ = rows();
    for (std::size_t i = 0; i < placements_.size(); ++i) placements_[i].tint[i % 3] = 0.7f;
    instances_ = add(plant_, placements_);
  }

  coppice_view create_surface_view(std::span<const Color> colors) { return create_view(view_formats(colors), COPPICE_OUTPUT_SURFACE); }

  Shot view_from(glm::vec3 eye_m) const { return make_view({.eye_m = eye_m, .width_px = kSidePx}); }

  void draw(const Shot& shot, const PassTarget& target) {
    frame_with(shot, [&](VkCommandBuffer cmd) {
      target.begin_cleared(cmd);
      record_draw(cmd, shot);
      vkCmdEndRendering(cmd);
    });
  }
  /// The shot as another view shows it once all is there.
  void draw_settled(Shot& shot, coppice_view view, const PassTarget& target) {
    shot.view = view;
    pump_until_settled(shot);
    draw(shot, target);
  }

  std::vector<coppice_instance> instances_;
  std::vector<coppice_placement> placements_;
};

/// Near, where the hardware draws, and far: the host that lights the attachments by the installed header gets what a lit view draws.
TEST_P(SurfaceTest, TheHeaderLightsItAsALitView) {
  place_rows();
  const coppice_view surface = create_surface_view(kSurface);
  HostLight host(gpu());
  for (const float distance_m : {3.0f, 8.0f, 30.0f}) {
    Shot shot = view_from({0.5f, 1.0f, distance_m});
    const PassTarget lit = target_of(gpu(), kLit), target = target_of(gpu(), kSurface);
    draw_settled(shot, view_, lit);
    const Picture expected = read_picture(gpu(), *lit.colors[0]);
    draw_settled(shot, surface, target);
    const std::vector<glm::vec4> radiance = host.light(target, shot);
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      if (radiance[i].w == 0.0f) continue;
      ++count;
      for (int channel = 0; channel < 3; ++channel) {
        const double off = 255.0f * srgb_from_linear(std::clamp(radiance[i][channel], 0.0f, 1.0f)) -
                           expected.rgba[4 * i + static_cast<std::size_t>(channel)];
        sum += off * off;
      }
    }
    EXPECT_GT(count, 500u) << distance_m;
    EXPECT_LT(std::sqrt(sum / (3.0 * static_cast<double>(count))), 2.2) << distance_m << " m";
  }
}

/// Which instance a pixel shows, to the byte, and nothing where the content is NONE.
TEST_P(SurfaceTest, ContentsComeInAnyOrder) {
  place_rows();
  constexpr std::array kOther{Color{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_USER}, Color{VK_FORMAT_R8G8B8A8_UNORM, COPPICE_CONTENT_NONE},
                              Color{VK_FORMAT_R8G8B8A8_SRGB, COPPICE_CONTENT_LIT}, Color{VK_FORMAT_R8G8B8A8_SRGB, COPPICE_CONTENT_ALBEDO}};
  Shot shot = view_from({0.5f, 1.0f, 6.0f});
  const PassTarget lit = target_of(gpu(), kLit), first = target_of(gpu(), kSurface), other = target_of(gpu(), kOther);
  draw_settled(shot, view_, lit);
  draw_settled(shot, create_surface_view(kSurface), first);
  draw_settled(shot, create_surface_view(kOther), other);
  const auto users = read_texels<std::uint32_t>(gpu(), *other.colors[0]);
  EXPECT_EQ(users, read_texels<std::uint32_t>(gpu(), *first.colors[3]));
  EXPECT_EQ(read_texels<std::uint32_t>(gpu(), *other.colors[3]), read_texels<std::uint32_t>(gpu(), *first.colors[0]));
  EXPECT_EQ(read_texels<std::uint32_t>(gpu(), *other.colors[2]), read_texels<std::uint32_t>(gpu(), *lit.colors[0]));
  const auto none = read_texels<std::uint32_t>(gpu(), *other.colors[1]);
  EXPECT_EQ(std::ranges::count(none, 0xffffffffu), static_cast<std::ptrdiff_t>(kPixels));
  const std::vector<float> depth = read_floats(gpu(), other.depth);
  std::vector<std::uint32_t> seen;
  for (std::size_t i = 0; i < kPixels; ++i) {
    EXPECT_EQ(depth[i] > 0.0f, users[i] % 0x01020304u == 0 && users[i] / 0x01020304u <= 40u) << i;
    if (depth[i] > 0.0f && std::ranges::find(seen, users[i]) == seen.end()) seen.push_back(users[i]);
  }
  EXPECT_GT(seen.size(), 5u);
}

glm::dmat4 matrix_of(const coppice_placement& placement) {
  const glm::dquat turn(placement.rotation[3], placement.rotation[0], placement.rotation[1], placement.rotation[2]);
  return glm::translate(glm::dmat4(1), glm::make_vec3(placement.position)) * glm::mat4_cast(turn) *
         glm::scale(glm::dmat4(1), glm::dvec3(placement.scale));
}

glm::dvec2 pixel_of(const Shot& shot, const glm::dvec3& world) {
  const glm::dvec4 clip =
      glm::dmat4(glm::make_mat4(shot.clip_from_view)) * glm::dmat4(glm::make_mat4(shot.view_from_world)) * glm::dvec4(world, 1.0);
  return 0.5 * kSidePx * (glm::dvec2(clip) / clip.w + 1.0);
}

/// The inverse: what a pixel shows, by its depth.
glm::dvec3 world_of(const glm::dmat4& from_clip, const glm::dvec2& pixel, float depth) {
  const glm::dvec4 place = from_clip * glm::dvec4(2.0 * pixel / double{kSidePx} - 1.0, double{depth}, 1.0);
  return glm::dvec3(place) / place.w;
}

glm::dvec2 middle_of(std::size_t pixel) {
  return {static_cast<double>(pixel % kSidePx) + 0.5, static_cast<double>(pixel / kSidePx) + 0.5};
}

/// The camera steps and turns, so that cuts change, and some instances move, turn and grow: each pixel's velocity is where its place of the
/// plant's surface was in the frame before, by the placements and cameras alone. What came is flagged.
TEST_P(SurfaceTest, VelocityIsThatOfTheSurface) {
  place_rows();
  const coppice_view surface = create_surface_view(kSurface);
  for (const float distance_m : {4.0f, 25.0f}) {
    Shot before = view_from({0.5f, 1.0f, distance_m});
    before.view = surface;
    Shot now = view_from({0.5f + 0.02f * distance_m, 1.1f, 0.9f * distance_m});
    now.view = surface;
    pump_until_settled(now);
    pump_until_settled(before);
    const std::vector<coppice_placement> then = placements_;
    const PassTarget ignored = target_of(gpu(), kSurface), target = target_of(gpu(), kSurface);
    draw(before, ignored);
    for (const std::size_t moved : {1u, 4u, 11u, 20u}) {
      coppice_placement& placement = placements_[moved];
      placement.position[0] += 0.05;
      placement.position[2] += 0.02;
      const glm::quat turn = glm::angleAxis(0.02f, glm::normalize(glm::vec3(0.3f, 1.0f, 0.2f)));
      std::ranges::copy(std::array{turn.x, turn.y, turn.z, turn.w}, placement.rotation);
      placement.scale *= 1.01f;
      move(instances_[moved], placement);
    }
    const coppice_placement came = placement({0.3f, 0.0f, 0.6f}, 0x0a0b0c0du);
    const coppice_instance added = add(plant_, came);
    draw(now, target);

    const auto users = read_texels<std::uint32_t>(gpu(), *target.colors[3]);
    const auto velocities = read_texels<glm::vec4>(gpu(), *target.colors[4]);
    const std::vector<float> depth = read_floats(gpu(), target.depth);
    const glm::dmat4 from_clip =
        glm::inverse(glm::dmat4(glm::make_mat4(now.clip_from_view)) * glm::dmat4(glm::make_mat4(now.view_from_world)));
    double worst = 0, fastest = 0;
    std::size_t counted = 0, moved = 0, new_ones = 0;
    for (std::size_t i = 0; i < kPixels; ++i) {
      if (depth[i] == 0.0f) continue;
      const glm::dvec2 at = middle_of(i);
      glm::dvec3 world = world_of(from_clip, at, depth[i]);
      EXPECT_EQ(velocities[i].z, users[i] == 0x0a0b0c0du ? 1.0f : 0.0f) << i;
      if (users[i] == 0x0a0b0c0du) {
        ++new_ones;
      } else {
        const std::size_t instance = users[i] / 0x01020304u - 1;
        ASSERT_LT(instance, placements_.size());
        const glm::dmat4 m = matrix_of(placements_[instance]), n = matrix_of(then[instance]);
        if (m != n) ++moved;
        world = glm::dvec3(n * glm::inverse(m) * glm::dvec4(world, 1.0));
      }
      const glm::dvec2 expected = at - pixel_of(before, world);
      worst = std::max(worst, glm::length(glm::dvec2(velocities[i]) - expected));
      fastest = std::max(fastest, glm::length(expected));
      ++counted;
    }
    EXPECT_LT(worst, 0.1) << distance_m << " m";
    EXPECT_GT(fastest, 4.0);
    EXPECT_GT(counted, 500u);
    EXPECT_GT(moved, 50u);
    EXPECT_GT(new_ones, 10u);
    // In the next frame all of them stand.
    draw(now, target);
    for (const glm::vec4& velocity : read_texels<glm::vec4>(gpu(), *target.colors[4])) {
      if (velocity.w == 1.0f) continue;  // the background
      ASSERT_LT(glm::length(glm::vec2(velocity)), 0.01f);
      ASSERT_EQ(velocity.z, 0.0f);
    }
    remove({&added, 1});
  }
}

coppice_wind gale(double time_s) {
  auto wind = defaults(coppice_wind_init);
  wind.direction[0] = 0.6f;
  wind.direction[2] = 0.8f;
  wind.speed = 25.0f;
  wind.time_s = time_s;
  wind.time_before_s = time_s - 0.4;
  return wind;
}

TEST_P(SurfaceTest, StillAirIsNoWindToTheBit) {
  place_rows();
  for (const float distance_m : {4.0f, 25.0f}) {
    const Shot shot = view_from({0.5f, 1.0f, distance_m});
    pump_until_settled(shot);
    const Picture expected = frame(shot);
    coppice_wind wind = gale(17.0);
    wind_ = &wind;
    EXPECT_FALSE(frame(shot).rgba == expected.rgba) << "wind moves nothing at " << distance_m;
    const Picture moved = frame(shot);
    EXPECT_TRUE(frame(shot).rgba == moved.rgba) << "the same time is the same picture";
    wind.speed = 0.0f;
    EXPECT_TRUE(frame(shot).rgba == expected.rgba) << distance_m;
    wind_ = nullptr;
  }
}

/// Where wind has moved what a pixel shows.
struct WindPixel {
  std::uint32_t user = 0;
  glm::dvec2 velocity{0.0}, expected{0.0};  ///< px since the frame before: as drawn; by coppice_wind.h on the CPU
};

/// A wind as the CPU looks it up.
PlacedWind placed(const coppice_wind& wind) {
  PlacedWind placed{.wind = wind};
  if (wind.map == nullptr) return placed;
  placed.max_map_mps = max_wind_mps({wind.map, std::size_t{2} * wind.map_width * wind.map_height});
  placed.map_address = reinterpret_cast<std::uintptr_t>(wind.map);
  return placed;
}

/// Which plants move between the two frames: so many may.
bool is_moved(std::size_t instance) {
  return instance % 8 == 0;
}
std::size_t instance_of(std::uint32_t user) {
  return user / 0x01020304u - 1;
}

/// Two frames, one in each wind; between them some plants move by step_m along x. Of each pixel that shows a plant: where its place is at
/// rest comes from the file's field, by steps; from there where it was in the frame before.
class WindOnSurface : public SurfaceTest {
 protected:
  /// What the plant's file begins with.
  Result<PlantFile> front() const {
    const std::string bytes = read_text(path_);
    return read_front({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, bytes.size());
  }

  std::vector<WindPixel> pixels_of(const coppice_wind& first, const coppice_wind& second, double step_m = 0.0) {
    place_rows();
    const coppice_view surface = create_surface_view(kSurface);
    Shot shot = view_from({0.5f, 1.0f, 8.0f});
    shot.view = surface;
    pump_until_settled(shot);
    const PassTarget ignored = target_of(gpu(), kSurface), target = target_of(gpu(), kSurface);
    wind_ = &first;
    draw(shot, ignored);
    for (std::size_t i = 0; i < instances_.size() && step_m != 0.0; ++i) {
      if (!is_moved(i)) continue;
      placements_[i].position[0] += step_m;
      move(instances_[i], placements_[i]);
    }
    wind_ = &second;
    draw(shot, target);
    const auto users = read_texels<std::uint32_t>(gpu(), *target.colors[3]);
    const auto velocities = read_texels<glm::vec4>(gpu(), *target.colors[4]);
    const std::vector<float> depth = read_floats(gpu(), target.depth);
    const glm::dmat4 view_from_world = glm::make_mat4(shot.view_from_world);
    const glm::dmat4 from_clip = glm::inverse(glm::dmat4(glm::make_mat4(shot.clip_from_view)) * view_from_world);
    const glm::dvec3 eye = glm::dvec3(glm::inverse(view_from_world)[3]);

    const Result<PlantFile> plant = front();
    std::vector<std::uint32_t> words(gpu::kWindWord + wind_word_count(wind_field(*plant)));
    pack_wind(wind_field(*plant), std::span(words).subspan(gpu::kWindWord));
    lod::CoppiceTable table{};
    table.words = words.data();
    const gpu::PlantWind field = gpu::plant_wind(table);
    const gpu::WindNow now = wind_now(placed(second), {eye.x, eye.y, eye.z}), before = wind_now(placed(first), {eye.x, eye.y, eye.z});
    std::vector<WindPixel> pixels;
    for (std::size_t i = 0; i < kPixels; ++i) {
      if (depth[i] == 0.0f) continue;
      const glm::dvec2 at = middle_of(i);
      const glm::dvec3 world = world_of(from_clip, at, depth[i]);
      const std::size_t instance = instance_of(users[i]);
      const glm::dvec3 foot = glm::make_vec3(placements_[instance].position);
      const glm::dvec3 foot_before = foot - glm::dvec3(is_moved(instance) ? step_m : 0.0, 0.0, 0.0);
      const auto vec = [](const glm::dvec3& v) { return vec3(static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)); };
      const auto offset = [&](const gpu::WindNow& when, const glm::dvec3& standing, const glm::dvec3& rest) {
        gpu::WindGradient unused;
        const gpu::Sway sway = gpu::sway_of(when, field, {0, 0, 0, 1}, vec(standing - eye), vec(standing));
        const vec3 moved = gpu::wind_offset(gpu::wind_place(table, field, vec(rest), unused), sway);
        return glm::dvec3(moved.x, moved.y, moved.z);
      };
      glm::dvec3 rest = world - foot;
      for (int step = 0; step < 8; ++step) rest = world - foot - offset(now, foot, rest);
      pixels.push_back({users[i], glm::dvec2(velocities[i]), at - pixel_of(shot, foot_before + rest + offset(before, foot_before, rest))});
    }
    return pixels;
  }
};

/// How far velocities are off what is expected, px. A leaf is moved as its stalk is, and the place that a pixel shows is not that.
struct Off {
  double worst = 0, fastest = 0, squares = 0, expected_squares = 0;
  void add(const WindPixel& pixel) {
    const double off = glm::length(pixel.velocity - pixel.expected), expected = glm::length(pixel.expected);
    worst = std::max(worst, off);
    fastest = std::max(fastest, expected);
    squares += off * off;
    expected_squares += expected * expected;
  }
  [[nodiscard]] double share() const { return std::sqrt(squares / expected_squares); }
};

TEST_P(WindOnSurface, VelocityIsThatOfTheWind) {
  Off off;
  const std::vector<WindPixel> pixels = pixels_of(gale(16.6), gale(17.0));
  for (const WindPixel& pixel : pixels) off.add(pixel);
  EXPECT_GT(pixels.size(), 500u);
  EXPECT_GT(off.fastest, 0.08);
  EXPECT_LT(off.worst, 0.05);
  EXPECT_LT(off.share(), 0.2);
}

TEST_P(WindOnSurface, WhatIsMovedInWindWasWhereTheWindOfThenHadIt) {
  Off off;
  for (const WindPixel& pixel : pixels_of(gale(16.6), gale(17.0), 2.5))
    if (is_moved(instance_of(pixel.user))) off.add(pixel);
  EXPECT_GT(off.fastest, 5.0);
  EXPECT_LT(off.worst, 0.06);
}

/// In air that is still but for what a map adds on the right: there plants move as the map's velocities change, and nowhere else.
TEST_P(WindOnSurface, AMapMovesThePlantsThatStandOnIt) {
  constexpr std::uint32_t kColumns = 5, kRows = 3;
  coppice_wind first = gale(16.6), second = gale(17.0);
  std::vector<float> before(std::size_t{2} * kColumns * kRows), now(before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    before[i] = static_cast<float>(i % 7) - 3.0f;
    now[i] = 15.0f + static_cast<float>(i % 5);
  }
  for (auto [wind, map] : {std::pair{&first, &before}, std::pair{&second, &now}}) {
    wind->speed = 0.0f;
    wind->map = map->data();
    wind->map_width = kColumns;
    wind->map_height = kRows;
    wind->map_min[0] = 0.0;
    wind->map_min[1] = -20.0;
    wind->map_max[0] = 9.0;
    wind->map_max[1] = 2.0;
  }
  Off off;
  std::size_t on_map = 0, off_map = 0;
  for (const WindPixel& pixel : pixels_of(first, second)) {
    if (placements_[instance_of(pixel.user)].position[0] < 0.0f) {
      ASSERT_LT(glm::length(pixel.velocity), 1e-3) << "px";
      ++off_map;
    } else {
      off.add(pixel);
      ++on_map;
    }
  }
  EXPECT_GT(on_map, 200u);
  EXPECT_GT(off_map, 200u);
  EXPECT_GT(off.fastest, 0.2);
  EXPECT_LT(off.worst, 0.1);
  EXPECT_LT(off.share(), 0.2);
}

/// A sphere that ends just outside the picture at rest is in view in the wind that may bring it there.
TEST_P(WindOnSurface, WhatLeansIntoViewIsDrawn) {
  const Result<PlantFile> plant = front();
  ASSERT_TRUE(plant);
  const double reach_m = max_wind_move_m(wind_field(*plant));
  ASSERT_GT(reach_m, 1e-3);
  const Shot shot = view_from({0.0f, 1.0f, 8.0f});
  const glm::dmat4 clip = glm::dmat4(glm::make_mat4(shot.clip_from_view)) * glm::dmat4(glm::make_mat4(shot.view_from_world));
  // The right plane: w - x.
  glm::dvec4 plane = glm::transpose(clip)[3] - glm::transpose(clip)[0];
  plane /= glm::length(glm::dvec3(plane));
  const glm::dvec3 middle(0.0, 0.0, -20.0);
  const double wanted_m = -(plant->plant.sphere_radius + 0.5 * reach_m);
  const glm::dvec3 center = middle + glm::dvec3(plane) * (wanted_m - glm::dot(plane, glm::dvec4(middle, 1.0)));
  const glm::vec3 at = glm::vec3(center) - glm::make_vec3(plant->plant.sphere_center);
  add(plant_, placement_at(at));
  const auto seen = [&] {
    for (int i = 0; i < 4; ++i) frame(shot);
    begin(shot);
    return view_stats().visible_instance_count;
  };
  for (int i = 0; i < 20; ++i) pump(shot);
  EXPECT_EQ(seen(), 0u);
  const coppice_wind wind = gale(17.0);
  wind_ = &wind;
  EXPECT_EQ(seen(), 1u);
}

INSTANTIATE_TEST_SUITE_P(Paths, WindOnSurface, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);
INSTANTIATE_TEST_SUITE_P(Paths, SurfaceTest, testing::Values(kHardwarePath, kComputePath, kTwoPassPath), path_name);

}  // namespace coppice::test::surface_test
