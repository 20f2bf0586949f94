#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>

#include "camera.h"
#include "device.h"
#include "frame_uniforms.h"
#include "frames.h"
#include "ground_map.h"
#include "pass_timer.h"
#include "resources.h"
#include "shadows.h"
#include "temporal.h"
#include "terrain.h"

namespace forest {

/// What a forest looks like today: the sun, the sky and the haze. Linear radiance.
struct Weather {
  glm::vec3 sun_direction;  ///< unit, towards the sun
  glm::vec3 sun_color;
  glm::vec3 sky_color;
  glm::vec3 ground_color;
  glm::vec3 fog_color;
  glm::vec3 leaf_color;   ///< albedo, of the plants' leaves: what has fallen, and the forest beyond, have theirs from it
  float fog_density = 0;  ///< 1/m
  float exposure = 1;
};

/// Cameras side by side in a picture, at most.
constexpr std::size_t kMaxPanes = 2;

/// What a camera shows in a frame.
struct FrameView {
  VkRect2D pane = {};  ///< its part of the picture's drawn part
  glm::mat4 view_from_world;
  glm::mat4 clip_from_view;  ///< moved by jitter_px
  glm::mat4 unmoved_clip_from_world;
  glm::vec2 jitter_px = {0, 0};
  std::uint32_t temporal_frame = 0;  ///< coppice_camera's
  glm::vec3 eye;
  float time_s = 0;
  std::array<glm::vec4, 4> gusts{};  ///< FrameUniforms::gusts
  bool debug_view = false;           ///< plants show colours that are not to be lit
  bool unchanged = false;            ///< nothing but the camera can have changed since the frame before
};

/// What plants are drawn to, in this order: `scene`, or to be lit here `albedo`, `normal` and `light`; then perhaps `velocity`.
struct PlantTargets {
  bool deferred = false;  ///< lit here: coppice_surface.glsl says what is in the three
  bool velocity = false;  ///< for temporal antialiasing
};

/// Ground, sky and tone mapping, and the images they and the plants draw to.
struct Renderer {
  static constexpr VkFormat kSceneFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
  static constexpr VkFormat kAlbedoFormat = VK_FORMAT_R8G8B8A8_SRGB;
  static constexpr VkFormat kNormalFormat = VK_FORMAT_R8G8B8A8_UNORM, kLightFormat = VK_FORMAT_R8G8B8A8_UNORM;
  static constexpr VkFormat kVelocityFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
  static constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
  static constexpr VkFormat kPictureFormat = VK_FORMAT_R8G8B8A8_UNORM;  // holds sRGB-encoded values

  const Device& device;
  const Terrain& terrain;
  const GroundMap& ground_map;
  Weather weather;
  const PlantTargets targets;

  /// What frames are drawn to of `scene`, `depth` and `toned`, and what of `blended` is blended over time, from their first pixel on. What
  /// is less than the picture is enlarged to it.
  VkExtent2D drawn = {}, blends = {};
  Image scene;                  ///< linear radiance
  Image albedo, normal, light;  ///< the plants' surfaces, if the demo lights them
  Image velocity;               ///< px, and 2 in z where depth and cameras say it; there if wanted
  Image depth;                  ///< reversed
  Image toned;                  ///< display values before they are blended over time
  Image blended;                ///< display values before they are enlarged
  Image picture;                ///< what is shown and saved; in TRANSFER_SRC layout after record_tone_map

  Buffer ground_vertices;
  Buffer ground_indices;
  Image ground_map_image;
  Image ground_detail_image;
  Image ground_height_image;
  Image ground_litter_image;
  Buffer mound_indices;
  /// The set of a pane in a frame.
  struct PaneSet {
    Buffer uniforms, tufts, mounds;
    VkDescriptorSet set = VK_NULL_HANDLE;
  };
  std::array<std::array<PaneSet, kMaxPanes>, FrameRing::kSlots> panes;
  /// The matrices of the frame before.
  std::array<glm::mat4, kMaxPanes> clip_from_world_before;
  float time_before_s = 0;
  std::array<glm::vec4, 4> gusts_before{};

  Handle<VkSampler> repeat_sampler;
  Handle<VkSampler> clamp_sampler;
  Handle<VkSampler> map_sampler;  ///< texels of shadow maps as they are
  Handle<VkDescriptorSetLayout> set_layout;
  Handle<VkPipelineLayout> pipeline_layout;
  Handle<VkDescriptorPool> descriptor_pool;
  Handle<VkPipeline> light_pipeline;
  Handle<VkPipeline> ground_pipeline;
  Handle<VkPipeline> tuft_pipeline;
  Handle<VkPipeline> sky_pipeline;
  Handle<VkPipeline> tone_map_pipeline;
  Handle<VkPipeline> enlarge_pipeline;
  std::unique_ptr<PassTimer> timer;    ///< null: passes are not measured
  std::unique_ptr<Shadows> shadows;    ///< null: the ground has what the ground map says
  std::unique_ptr<Temporal> temporal;  ///< null: every frame is shown as it is

  /// extent  of all images
  Renderer(const Device& device, const Terrain& terrain, const GroundMap& ground_map, const Weather& weather, PlantTargets targets,
           VkExtent2D extent);
};

/// Replaces the images, and draws to all of them. No frame may be in flight.
void resize_renderer(Renderer& renderer, VkExtent2D extent);

/// From the next frame on draws to a share of the images' width and height, above 0 and up to 1.
void set_scale(Renderer& renderer, float scale);

/// Switches temporal antialiasing on or off. No frame may be in flight.
void set_temporal(Renderer& renderer, bool on);

/// Switches shadow maps on, or off with a size of 0. No frame may be in flight.
void set_shadows(Renderer& renderer, std::uint32_t size_px);

/// Records the scene: `draw_plants` of all views first (it may change every binding), their light, then ground, grass and sky.
/// slot   FrameRing::slot_index() of the frame: its uniforms and tufts are overwritten
/// views  at most kMaxPanes, beside each other
void record_scene(Renderer& renderer, VkCommandBuffer commands, std::size_t slot, std::span<const FrameView> views,
                  const std::function<void()>& draw_plants);

/// Records tone mapping and temporal antialiasing or enlarging to `picture`, then `draw_overlay` on top of it.
/// view          the first one given to record_scene
/// draw_overlay  may be empty
void record_tone_map(Renderer& renderer, VkCommandBuffer commands, std::size_t slot, const FrameView& view,
                     const std::function<void()>& draw_overlay);

/// The picture of the latest frame as [width * height * 4] RGBA, top row first. No frame may be in flight.
std::vector<std::uint8_t> read_picture(const Renderer& renderer);

}  // namespace forest
