#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <optional>

#include "forest.h"
#include "frame_pace.h"
#include "overlay.h"
#include "swapchain.h"
#include "watch.h"

namespace forest {

/// Everything that does not change while the program runs, but the weather.
struct World {
  Planting planting;
  Weather weather;
  Terrain terrain;
  GroundMap ground_map;
};

/// The window's side of presenting; absent when headless.
struct Screen {
  const Device& device;
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  VkExtent2D window_size = {};  ///< the framebuffer's, when the swapchain was made
  Swapchain swapchain;

  Screen(const Device& device, const Window& window);
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;
  ~Screen();
};

/// What the picture shows: a camera's view; that and one that looks back; a view's left and right eye.
enum class Panes : std::uint8_t { one, split, stereo };

/// One run of the program: a device, a forest on it, and the frames drawn so far. Members are in order of dependence.
struct Session {
  std::unique_ptr<Window> window;  ///< null when headless
  Device device;
  std::unique_ptr<Screen> screen;  ///< null when headless
  PlantTargets targets;
  Forest forest;
  World world;
  Renderer renderer;
  FrameRing ring;
  std::unique_ptr<Overlay> overlay;  ///< null when headless
  Controls controls;
  FramePace pace;
  double gusts_m = 0;             ///< how far gusts have travelled in a window, whose wind changes
  float wind_before_mps = 0;      ///< the frame before's
  glm::vec2 jitter_px = {0, 0};   ///< moves the picture, for supersampling
  std::uint32_t sample = 0;       ///< number of the sample in a supersampled picture, from 1 on; 0: frames are shown as they are
  float cuts_aside_m = 0;         ///< the picture has the cuts of an eye so far to the right
  std::uint32_t supersample = 1;  ///< along each axis, of pictures that are written
  Panes panes = Panes::one;
  std::optional<Watch> watch;  ///< absent unless asked for
  Statistics statistics;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  std::uint64_t first_measured = 1;  ///< frames from this number on are in `statistics`
  std::uint64_t last_measured = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t sampled_frame = 0;  ///< the last frame whose figures have been seen

  Session(const Options& options, std::unique_ptr<Window> window);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();  ///< waits for the GPU
};

/// Records and submits one frame; presents it where there is a window. frame_ms: what the last one took, for the overlay and the leaf
/// budget; 0 for neither
void render_frame(Session& session, const Pose& pose, float time_s, float frame_ms);

/// Renders the pose again and again until what it wants is resident, or until nothing has arrived for two seconds (the budget is full), and
/// temporal antialiasing, if it is on, has 16 frames of that.
void settle(Session& session, const Pose& pose, float time_s);

float ms_since(std::chrono::steady_clock::time_point start);

/// Before frames are timed: pipelines and caches meet their first use, and the frames in flight fill up, so that a frame's time is the
/// interval between finished frames. A GPU that has idled runs at a fraction of its clock: it has work for a second.
void warm_up(Session& session, const Pose& pose, float time_s);

/// Where and when a picture is taken: what render_frame was last given.
struct Shot {
  const Pose& pose;
  float time_s = 0;
};
/// The mean of side x side frames moved by parts of a pixel: [width * height * 4] RGBA, 0..255. Temporal antialiasing must be off.
std::vector<float> supersampled_picture(Session& session, const Shot& shot, std::uint32_t side);
/// Writes the picture without the overlay, supersampled if the session says so. errors  Failure
void save_picture(Session& session, const Shot& shot, const std::string& file);
/// Likewise, to DIR/number.png, and does not print where.
void record_picture(Session& session, const Shot& shot, const std::string& folder, std::uint32_t number);

}  // namespace forest
