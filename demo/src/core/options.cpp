#include "options.h"

#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <system_error>

#include <CLI/CLI.hpp>

#include "command_line.h"
#include "completion.h"

namespace forest {
namespace {

using coppice::command_line::kShells;

constexpr const char* kAbout =
    "A forest of streamed plants, or one of them: coppice-forest PLANT.coppice turns the camera round it. Without a display it renders "
    "headless.";

constexpr const char* kPlant = "A baked plant, to be looked at alone (--count 1), or a folder of them for a forest";

constexpr const char* kPlants =
    "Baked plants and folders of them, separated by commas [every .coppice file of out/plants in the current folder, or of plants beside "
    "the executable]";

constexpr const char* kCamera =
    "Round the plant, before it or above it; through the forest or round it; or along keyframes of a file: time_s x_m height_m z_m yaw_deg "
    "pitch_deg [fov_y_deg] a line, # starts a comment, height above the ground [walk; of one plant turntable]";

constexpr std::uint32_t kLargestSide_px = 16384;

bool parse_size(const std::string& text, Options& options) {
  const auto cross = text.find('x');
  if (cross == std::string::npos) return false;
  return CLI::detail::lexical_cast(text.substr(0, cross), options.width_px) &&
         CLI::detail::lexical_cast(text.substr(cross + 1), options.height_px) && options.width_px > 0 && options.height_px > 0 &&
         options.width_px <= kLargestSide_px && options.height_px <= kLargestSide_px;
}

/// names: "--on,!--off". What is not given keeps its value, or none: add_flag takes an optional<bool> for a number and makes it 0.
CLI::Option* add_switch(CLI::App& app, const std::string& names, std::optional<bool>& value, const std::string& help) {
  return app.add_flag_function(
      names, [&value](std::int64_t count) { value = count > 0; }, help);
}

void declare_forest(CLI::App& app, Options& options) {
  app.option_defaults()->group("The forest");
  CLI::Option* plant = app.add_option("PLANT", options.plants, kPlant)->expected(1)->type_name("A.coppice|FOLDER");
  CLI::Option* plants = app.add_option("--plants", options.plants, kPlants)->delimiter(',')->excludes(plant)->type_name("A.coppice,...");
  CLI::Option* count = app.add_option("--count", options.count, "Plant instances")->check(CLI::Range(1u, 1000000u))->capture_default_str();
  CLI::Option* scene = app.add_option("--scene", options.scene, "Stream a scene that `coppice scene` made, on flat ground")
                           ->excludes(plant)
                           ->excludes(plants)
                           ->excludes(count)
                           ->type_name("F.forest");
  app.add_option("--most-instances", options.most_instances, "Most plants of the scene at a time; where more are near, far ones stay out")
      ->check(CLI::Range(1u, 2000000u))
      ->needs(scene)
      ->capture_default_str();
  app.add_flag("--allow-outside", options.allow_outside, "Plants of the scene may be outside its folder; for scenes that you trust")
      ->needs(scene);
  app.add_option("--seed", options.seed, "Another seed, another forest")->capture_default_str();
  app.add_option("--memory-mb", options.memory_mb, "Memory budget of the plants, MiB [256, and one for every 1024 of --count]")
      ->check(CLI::Range(1u, 65536u));
  app.add_flag("--watch", options.watch, "Show plants anew when their files change");
  app.add_flag("--ignore-errors", options.ignore_errors,
               "Exit with 0 although something could not be read; errors are printed all the same. Without it a headless run exits with 1");
}

void declare_pictures(CLI::App& app, Options& options) {
  app.option_defaults()->group("Camera and pictures");
  app.add_option_function<std::string>(
         "--size",
         [&options](const std::string& text) {
           if (!parse_size(text, options)) throw CLI::ValidationError("--size", "expected WIDTHxHEIGHT, 1 to 16384 each, got " + text);
         },
         "Picture size in pixels [1280x720]")
      ->type_name("WxH");
  app.add_option(
         "--render-scale", options.render_scale,
         "Draw with this share of the picture's width and height, and enlarge; with --taa detail comes back over frames [1; without a "
         "GPU and with --taa 0.5]")
      ->check(CLI::Range(0.25f, 1.0f));
  app.add_option("--frames", options.frames,
                 "Frames to render, spread evenly over the camera path when headless [120; in a window: endless]")
      ->check(CLI::Range(1u, 10000000u));
  CLI::Option* headless = app.add_flag("--headless", options.headless, "No window");
  app.add_option(
         "--frames-per-s", options.frames_per_s,
         "Walk as a user does: so many frames in a second of the camera path, so that shadow maps are drawn as often as in a window "
         "[spread evenly over the path]")
      ->check(CLI::Range(1.0f, 1000.0f))
      ->needs(headless);
  app.add_option("--screenshot", options.screenshot, "Write the last frame, once streaming has settled")->type_name("F.png");
  app.add_option("--camera", options.camera, kCamera)->type_name("turntable|front|top|walk|orbit|FILE");
  app.add_option("--camera-out", options.camera_out, "Where key C writes the camera's way, for --camera")
      ->type_name("FILE")
      ->capture_default_str();
  app.add_option("--record", options.record, "Write every frame as a picture, 00000.png and on; frame times then say nothing")
      ->type_name("FOLDER");
  app.add_option("--fog", options.fog, "Times as much fog; 0 for clear air [1; of one plant 0]")->check(CLI::Range(0.0f, 10.0f));
  app.add_option("--wind", options.wind_mps, "Speed of the wind in m/s; 0 for still air [0; in a window 4]")
      ->check(CLI::Range(0.0f, 100.0f));
  app.add_flag("--shadows,!--no-shadows", options.shadows, "Shadow maps: plants shade the ground and each other [on]");
  CLI::Option* temporal = add_switch(app, "--taa,!--no-taa", options.temporal,
                                     "Temporal antialiasing: each frame is moved by part of a pixel and blended with those before [on, "
                                     "unless --supersample or --compare is given]");
  CLI::Option* split =
      app.add_flag("--split", options.split, "Two cameras side by side; the right one looks back. Without temporal antialiasing")
          ->excludes(temporal);
  app.add_flag("--stereo", options.stereo, "Left and right eye side by side, culled as one view. Without temporal antialiasing")
      ->excludes(temporal)
      ->excludes(split);
  app.add_option("--supersample", options.supersample,
                 "Pictures that are written are means of KxK frames moved by parts of a pixel, without temporal antialiasing")
      ->check(CLI::Range(1u, 16u))
      ->excludes(temporal)
      ->type_name("K");
}

void declare_detail(CLI::App& app, Options& options) {
  app.option_defaults()->group("Level of detail");
  app.add_option_function<std::string>(
         "--lod",
         [&options](const std::string& mode) {
           options.lod = mode == "full" ? LodMode::full : mode == "discrete" ? LodMode::discrete : LodMode::cut;
         },
         "cut: each plant by its size on screen. discrete: the nearest finer of seven levels, drawn by the hardware, to compare with. "
         "full: every leaf of every plant, the reference [cut]")
      ->check(CLI::IsMember({"cut", "discrete", "full"}))
      ->type_name("cut|discrete|full");
  app.add_option_function<std::string>(
         "--path",
         [&options](const std::string& path) {
           options.path = path == "compute" ? LeafPath::compute : path == "hardware" ? LeafPath::hardware : LeafPath::automatic;
         },
         "Who draws small leaves: compute shaders, or triangles by the hardware. auto: compute where the device does [auto]")
      ->check(CLI::IsMember({"auto", "compute", "hardware"}))
      ->type_name("auto|compute|hardware");
  const std::map<std::string, Lighting> lightings = {{"deferred", Lighting::deferred}, {"forward", Lighting::forward}};
  app.add_option("--renderer", options.lighting,
                 "Who lights plants. deferred: the demo, as an engine does, by the surfaces that they draw. forward: the library")
      ->transform(CLI::CheckedTransformer(lightings))
      ->type_name("deferred|forward")
      ->default_str("deferred");
  const std::map<std::string, DebugView> views = {{"none", DebugView::none},           {"lod", DebugView::lod},
                                                  {"path", DebugView::path},           {"overdraw", DebugView::overdraw},
                                                  {"occlusion", DebugView::occlusion}, {"error", DebugView::error},
                                                  {"residency", DebugView::residency}};
  app.add_option("--view", options.view, "Colours that show what the library does; coppice_debug_view in coppice.h says what they mean")
      ->transform(CLI::CheckedTransformer(views))
      ->type_name("none|lod|path|overdraw|occlusion|error|residency")
      ->default_str("none");
  app.add_option("--error-px", options.error_px, "Error threshold of the cut")->check(CLI::Range(0.01f, 1000.0f))->capture_default_str();
  app.add_option(
      "--leaf-budget", options.leaf_budget,
      "Leaves a frame may draw; the threshold rises until they fit. 0: as many as it asks for [1000000 without a GPU, with one 0]");
  app.add_option(
         "--frame-ms", options.frame_ms,
         "Time of a frame, to keep which the render scale, unless it is given, goes down to a quarter, and then the leaf budget. 0: both "
         "stay [0; in a window without a GPU 33]")
      ->check(CLI::Range(0.0f, 10000.0f));
}

void declare_figures(CLI::App& app, Options& options) {
  app.option_defaults()->group("Figures");
  app.add_option("--stats", options.stats, "Write statistics as JSON")->type_name("F.json");
  app.add_option("--compare", options.compare,
                 "Run cut, discrete and full over the camera path (--frames poses) and write time, leaves and error against full as JSON, "
                 "and a plot beside it, F.svg")
      ->excludes("--taa")
      ->type_name("F.json");
  app.add_option("--trace", options.trace, "Write what streaming and recording did when, for chrome://tracing or ui.perfetto.dev")
      ->type_name("F.json");
  app.add_flag("--pass-times", options.pass_times, "Measure the GPU's time by pass, which costs some of it");
  app.add_flag("--validation", options.validation, "Vulkan core and synchronization validation; messages are printed and counted");
  app.add_option(
         "--gpu-wait-s", options.gpu_wait_s,
         "The program ends with exit code 1, and says what it waited for, where the GPU takes longer for a frame [20; without a GPU "
         "600]")
      ->check(CLI::Range(0.001f, 1e6f));
}

void declare_doctor(CLI::App& app, Options& options) {
  app.option_defaults()->group("When something is wrong");
  CLI::Option* doctor = app.add_flag(
      "--doctor", options.doctor,
      "Say whether Coppice runs on this machine: list what its device has of what is needed, try each part of drawing by itself, compare "
      "its picture with the processor's, and print a text for a bug report. The exit code is 0 if all is well, else 1");
  app.add_option("--doctor-limit-s", options.doctor_limit_s, "A part that takes longer hangs")
      ->check(CLI::Range(0.1, 1e5))
      ->needs(doctor)
      ->capture_default_str();
}

/// The doctor has its own plant and pictures: whoever asks for others would wait for them in vain.
void refuse_with_doctor(const CLI::App& app) {
  if (app.count("--doctor") == 0) return;
  for (const CLI::Option* option : app.get_options())
    if (const std::string name = option->get_name(); option->count() > 0 && !name.starts_with("--doctor"))
      throw CLI::ValidationError("--doctor", "excludes " + name);
}

/// Values of options that depend on others.
void choose_defaults(const CLI::App& app, Options& options) {
  std::error_code absent;
  if (app.count("PLANT") > 0 && app.count("--count") == 0 && !std::filesystem::is_directory(options.plants.front(), absent))
    options.count = 1;
  const bool one_plant = options.count == 1 && options.scene.empty();
  if (options.camera.empty()) options.camera = one_plant ? "turntable" : "walk";
  if (one_plant && app.count("--fog") == 0) options.fog = 0;
  // An instance takes some 600 bytes of its own in a view, two panes and four maps, and 400 more while their lists grow.
  if (app.count("--memory-mb") == 0) options.memory_mb += options.count / 1024;
}

/// The keys of the window, below the options.
std::string key_table() {
  std::string text = "Keys in the window:";
  for (const WindowKey& key : kWindowKeys) {
    std::array<char, 100> line{};
    std::snprintf(line.data(), line.size(), "\n  %-32s%s", key.key, key.what);
    text += line.data();
  }
  return text;
}

}  // namespace

ParsedOptions parse_options(int argc, char** argv) {
  ParsedOptions parsed;
  CLI::App app(kAbout, "coppice-forest");
  app.formatter(coppice::command_line::help_format());
  std::string shell;
  app.footer(key_table());
  app.set_version_flag("--version", version());
  app.add_option("--completion", shell, "Print a script with which bash, zsh or fish completes these options")
      ->check(CLI::IsMember(std::vector<std::string>(kShells.begin(), kShells.end())))
      ->type_name("SHELL");
  declare_forest(app, parsed.options);
  declare_pictures(app, parsed.options);
  declare_detail(app, parsed.options);
  declare_figures(app, parsed.options);
  declare_doctor(app, parsed.options);
  try {
    if (argc > 1 && argv[1] == std::string_view(coppice::command_line::kCompleteOption)) {
      std::fputs(coppice::command_line::completions(app, {argv + 2, argv + argc}).c_str(), stdout);
      parsed.exit_code = 0;
      return parsed;
    }
    app.parse(argc, argv);
    refuse_with_doctor(app);
    choose_defaults(app, parsed.options);
    if (!shell.empty()) {
      std::fputs(coppice::command_line::completion_script(app.get_name(), shell).c_str(), stdout);
      parsed.exit_code = 0;
    }
  } catch (const CLI::ParseError& error) {
    const std::string unknown = coppice::command_line::unknown_word(app, {argv + 1, argv + argc});
    if (error.get_exit_code() != 0 && !unknown.empty())
      std::fprintf(stderr, "%s\n", unknown.c_str());
    else
      app.exit(error);
    parsed.exit_code = error.get_exit_code() == 0 ? 0 : 2;
  }
  return parsed;
}

const char* version() {
  return COPPICE_FOREST_VERSION;
}

}  // namespace forest
