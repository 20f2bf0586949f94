#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <volk.h>

#include "camera.h"

struct GLFWwindow;

namespace forest {

/// The GLFW window and the camera a person steers in it.
struct Window {
  GLFWwindow* handle = nullptr;
  std::span<const char* const> instance_extensions;
  bool steering = false;  ///< a person has taken the camera; R gives it back to the path
  bool overlay_visible = true;
  bool wants_next_view = false;  ///< V likewise
  bool wants_temporal = false;   ///< T was pressed: to be switched; whoever does so resets it
  bool wants_recording = false;  ///< C likewise: recording the camera's way
  bool wants_picture = false;    ///< P was pressed; whoever saves the picture resets it
  double last_x = 0;
  double last_y = 0;

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
/// Handles events. False when the window is to be closed. Blocks while it is minimised.
bool poll_window(Window& window);

/// Moves the pose by what keys and mouse did in the last dt_s. mouse_free: false while the overlay uses the mouse.
void steer(Window& window, Pose& pose, float dt_s, bool mouse_free);

}  // namespace forest
