#pragma once

#include <array>
#include <string>

namespace forest {

/// What Coppice does on a device, each tried alone in a process of its own.
inline constexpr std::array kTrials = {
    "device",     // makes the device; a copy to the GPU and back has the same bytes
    "uploads",    // streams a plant to the GPU; nothing is drawn
    "selection",  // culls plants and chooses their leaves: as many as the processor
    "hardware",   // draws plants near and far as triangles: the processor's picture, as below
    "leaves",     // draws quads of some pixels with compute shaders
    "splats",     // the same of a pixel or less
    "surfaces",   // draws what an engine's own light needs: its colours, too
    "shadow_map"  // draws depth alone
};

/// The hidden option by which this program tries one by itself: `coppice-forest --doctor-trial NAME LIMIT_S`.
inline constexpr const char* kTrialOption = "--doctor-trial";

/// Tries one of kTrials and prints what the parent process reads, a line each: "say TEXT" for the user, "at TEXT" before each step, and at
/// last "result VERDICT READY_MS FRAME_MS NOTE"; without that one it failed, as its standard error output says.
/// limit_s  a signal ends the process some seconds after so long, should nobody else
/// errors  Failure: what could not be done
void run_trial(const std::string& name, double limit_s);

/// Whether that is slow: until the first right picture, and each frame then. software  a processor does the GPU's work
constexpr bool is_slow(double ready_ms, double frame_ms, bool software) {
  return ready_ms > 10'000 || frame_ms > (software ? 1000 : 100);
}

/// The step that follows, to be told should it never end.
void at(const std::string& step);

}  // namespace forest
