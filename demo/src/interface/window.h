#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <volk.h>

#include "camera.h"

struct GLFWwindow;

namespace forest {

/// How much the overlay shows; key Tab goes on to the next.
enum class OverlayDetail { line, all, nothing, count };

/// The GLFW window and the camera a person steers in it.
struct Window {
  GLFWwindow* handle = nullptr;
  std::span<const char* const> instance_extensions;
  bool steering = false;  ///< a person has taken the camera; R gives it back to the path
  OverlayDetail overlay = OverlayDetail::line;
  bool help_visible = false;     ///< H: what the keys do
  bool was_hidden = false;       ///< next_frame waited while the window was not to be seen; whoever times frames resets it
  bool wants_next_view = false;  ///< V likewise
  bool wants_wind = false;       ///< G was pressed, likewise
  bool wants_temporal = false;   ///< T was pressed: to be switched; whoever does so resets it
  bool wants_recording = false;  ///< C likewise: recording the camera's way
  bool wants_picture = false;    ///< P was pressed; whoever saves the picture resets it
  double last_x = 0;
  double last_y = 0;
  float display_frame_ms = 0;                         ///< frame time of the fastest monitor
  std::chrono::steady_clock::time_point frame_start;  ///< start of the latest frame
  std::array<int, 4> place_before_full_screen = {};   ///< x, y, width and height in screen coordinates

  Window() = default;
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
  ~Window();
};

/// Opens a window. Null where there is no display or it cannot show Vulkan; `reason` then says why.
std::unique_ptr<Window> open_window(std::uint32_t width_px, std::uint32_t height_px, std::string& reason);

/// Null without a surface extension that works. errors  Failure: the surface cannot be created
VkSurfaceKHR create_surface(const Window& window, VkInstance instance);
VkExtent2D framebuffer_size(const Window& window);
/// Waits until the display can show another frame (not every driver does so when it presents) and while the window is hidden or minimised;
/// handles events. False when the window is to be closed.
bool next_frame(Window& window);

/// Moves the pose by what keys and mouse did in the last dt_s. mouse_free: false while the overlay uses the mouse.
void steer(Window& window, Pose& pose, float dt_s, bool mouse_free);

}  // namespace forest
