#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace forest {

enum class LodMode { cut, discrete, full };
/// Colours instead of light: coppice_debug_view, in its order.
enum class DebugView { none, lod, path, overdraw, occlusion, error, residency, count };
/// How small leaves are drawn. automatic: by compute shaders, and by the hardware where the library cannot.
enum class LeafPath { automatic, compute, hardware };
/// Who lights plants: the demo, by what they write of their surfaces, or the library.
enum class Lighting { deferred, forward };

/// Where a processor does the GPU's work. With less leaves get so large that their pixels cost what their number saves.
constexpr std::uint32_t kSoftwareLeafBudget = 1'000'000;
/// Likewise; temporal antialiasing brings the detail back.
constexpr float kSoftwareRenderScale = 0.5f;
/// Likewise, in a window.
constexpr float kSoftwareFrame_ms = 33;

/// What a key does in the window: for the help of the command line and of the window, and demo/README.md.
struct WindowKey {
  const char *key, *what;
};
inline constexpr std::array kWindowKeys = {WindowKey{"drag", "look around"},
                                           WindowKey{"W A S D", "go forwards, left, back, right"},
                                           WindowKey{"Q E", "go down, up"},
                                           WindowKey{"Shift", "with those: five times as fast"},
                                           WindowKey{"R", "back to the camera's path"},
                                           WindowKey{"P", "save a picture"},
                                           WindowKey{"C", "start or end writing the camera's way to a file"},
                                           WindowKey{"T", "temporal antialiasing on or off"},
                                           WindowKey{"V", "next debug view"},
                                           WindowKey{"G", "wind on or off"},
                                           WindowKey{"H", "show or hide these keys"},
                                           WindowKey{"Tab", "show one line, everything, nothing"},
                                           WindowKey{"F11", "full screen on or off"},
                                           WindowKey{"Escape", "close"}};

/// In a window, unless --wind says otherwise.
inline constexpr float kWindowWind_mps = 4;

/// The command line of coppice-forest. Defaults are what `coppice-forest` alone does.
struct Options {
  std::vector<std::string> plants;        ///< .coppice files and folders of them; empty: those of the default folders, see find_plants
  std::string scene;                      ///< a .forest file; empty: `count` plants are placed
  std::uint32_t most_instances = 262144;  ///< maximum of a scene's plants at a time
  std::uint32_t count = 2000;
  std::uint32_t seed = 1;
  std::uint32_t width_px = 1280;
  std::uint32_t height_px = 720;
  std::optional<float> render_scale;    ///< drawn size relative to the picture, along each axis; absent: 1, or kSoftwareRenderScale
  std::optional<std::uint32_t> frames;  ///< absent: 120 headless, until closed in a window
  float frames_per_s = 0;               ///< headless: of the camera path; 0: they are spread evenly over it
  bool headless = false;
  std::string screenshot;                 ///< empty: none
  std::string camera;                     ///< turntable, front, top, walk, orbit or a keyframe file
  std::string camera_out = "camera.txt";  ///< where the window writes the camera's way
  LodMode lod = LodMode::cut;
  LeafPath path = LeafPath::automatic;
  Lighting lighting = Lighting::deferred;
  float error_px = 2;
  std::optional<std::uint32_t> leaf_budget;  ///< leaves a frame, see coppice_camera; 0: none; absent: kSoftwareLeafBudget, or on a GPU none
  std::optional<float> frame_ms;             ///< what FramePace keeps to; 0: nothing; absent: that, or in a window kSoftwareFrame_ms
  std::optional<float> wind_mps;             ///< absent: none, or in a window kWindowWind_mps
  float fog = 1;                             ///< times the density that hides the far edge
  std::uint32_t memory_mb = 256;
  std::string stats;             ///< empty: none
  std::string record;            ///< folder for every frame's picture; empty: none
  std::string compare;           ///< where to write the comparison of LoD modes; empty: none
  std::string trace;             ///< empty: none
  bool split = false;            ///< a second camera, which looks back, beside the first
  bool stereo = false;           ///< the two eyes of one view side by side
  std::optional<bool> temporal;  ///< antialiasing; absent: unless frames are to be seen one by one
  DebugView view = DebugView::none;
  bool shadows = true;            ///< shadow maps
  std::uint32_t supersample = 1;  ///< along each axis, of pictures that are written
  bool watch = false;
  bool allow_outside = false;  ///< plants of a scene may be outside its folder
  bool ignore_errors = false;  ///< headless: exit with 0 although something could not be read
  bool pass_times = false;
  bool validation = false;
  std::optional<float> gpu_wait_s;  ///< none: as the device has it
  bool doctor = false;              ///< nothing is shown: see run_doctor
  double doctor_limit_s = 60;       ///< for each of its trials
};

/// Parses argv. Returns an exit code instead when there is nothing to run: 0 after what --help, --version, --completion or --complete
/// printed, 2 after a usage error (already printed).
struct ParsedOptions {
  Options options;
  std::optional<int> exit_code;
};
ParsedOptions parse_options(int argc, char** argv);

/// This program's, with points between its numbers.
const char* version();

}  // namespace forest
