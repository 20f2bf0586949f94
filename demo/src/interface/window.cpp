#include "window.h"

#include <algorithm>
#include <array>
#include <thread>

// volk.h came first, so GLFW declares its Vulkan functions.
#include <GLFW/glfw3.h>

#include "failure.h"
#include "frame_pace.h"

namespace forest {
namespace {

std::span<GLFWmonitor*> monitors() {
  int count = 0;
  GLFWmonitor** first = glfwGetMonitors(&count);
  return {first, static_cast<std::size_t>(count)};
}

/// GLFW rounds rates to whole numbers: half a frame a second more, so that a display whose driver does wait is never kept waiting twice.
float shortest_frame_ms() {
  constexpr int kUsualRate = 60;  // where no monitor says one
  int fastest = 0;
  for (GLFWmonitor* monitor : monitors())
    if (const GLFWvidmode* mode = glfwGetVideoMode(monitor)) fastest = std::max(fastest, mode->refreshRate);
  return 1000 / (static_cast<float>(fastest > 0 ? fastest : kUsualRate) + 0.5f);
}

/// The one that the window's middle is on, or the first; null where there is none.
GLFWmonitor* monitor_of(GLFWwindow* handle) {
  int x = 0, y = 0, width = 0, height = 0;
  glfwGetWindowPos(handle, &x, &y);
  glfwGetWindowSize(handle, &width, &height);
  for (GLFWmonitor* monitor : monitors()) {
    int left = 0, top = 0;
    glfwGetMonitorPos(monitor, &left, &top);
    const GLFWvidmode* mode = glfwGetVideoMode(monitor);
    const int in_x = x + width / 2 - left, in_y = y + height / 2 - top;
    if (mode && in_x >= 0 && in_y >= 0 && in_x < mode->width && in_y < mode->height) return monitor;
  }
  return glfwGetPrimaryMonitor();
}

void switch_full_screen(Window& window) {
  auto& [x, y, width, height] = window.place_before_full_screen;
  if (glfwGetWindowMonitor(window.handle)) {
    glfwSetWindowMonitor(window.handle, nullptr, x, y, width, height, GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* monitor = monitor_of(window.handle);
  const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
  if (!mode) return;
  glfwGetWindowPos(window.handle, &x, &y);
  glfwGetWindowSize(window.handle, &width, &height);
  glfwSetWindowMonitor(window.handle, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

OverlayDetail next_detail(OverlayDetail detail) {
  return static_cast<OverlayDetail>((static_cast<int>(detail) + 1) % static_cast<int>(OverlayDetail::count));
}

void on_key(GLFWwindow* handle, int key, int, int action, int) {
  auto& window = *static_cast<Window*>(glfwGetWindowUserPointer(handle));
  if (action != GLFW_PRESS) return;
  if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(handle, GLFW_TRUE);
  if (key == GLFW_KEY_TAB) window.overlay = next_detail(window.overlay);
  if (key == GLFW_KEY_H) window.help_visible = !window.help_visible;
  if (key == GLFW_KEY_F11) switch_full_screen(window);
  if (key == GLFW_KEY_C) window.wants_recording = true;
  if (key == GLFW_KEY_V) window.wants_next_view = true;
  if (key == GLFW_KEY_T) window.wants_temporal = true;
  if (key == GLFW_KEY_G) window.wants_wind = true;
  if (key == GLFW_KEY_P) window.wants_picture = true;
  if (key == GLFW_KEY_R) window.steering = false;
}

std::string glfw_reason() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "unknown reason";
}

bool is_hidden(const Window& window) {
  const VkExtent2D size = framebuffer_size(window);
  return size.width == 0 || size.height == 0 || glfwGetWindowAttrib(window.handle, GLFW_ICONIFIED) ||
         !glfwGetWindowAttrib(window.handle, GLFW_VISIBLE);
}

}  // namespace

Window::~Window() {
  if (handle) glfwDestroyWindow(handle);
  glfwTerminate();
}

std::unique_ptr<Window> open_window(std::uint32_t width_px, std::uint32_t height_px, std::string& reason) {
  if (!glfwInit()) {
    reason = glfw_reason();
    return nullptr;
  }
  auto window = std::make_unique<Window>();
  if (!glfwVulkanSupported()) {
    reason = glfw_reason();
    return nullptr;
  }
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  window->handle = glfwCreateWindow(static_cast<int>(width_px), static_cast<int>(height_px), "Coppice forest", nullptr, nullptr);
  std::uint32_t count = 0;
  const char** names = window->handle ? glfwGetRequiredInstanceExtensions(&count) : nullptr;
  if (!names) {
    reason = glfw_reason();
    return nullptr;
  }
  window->instance_extensions = {names, count};
  window->display_frame_ms = shortest_frame_ms();
  glfwSetWindowUserPointer(window->handle, window.get());
  glfwSetKeyCallback(window->handle, on_key);
  return window;
}

VkSurfaceKHR create_surface(const Window& window, VkInstance instance) {
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  check(glfwCreateWindowSurface(instance, window.handle, nullptr, &surface), "glfwCreateWindowSurface");
  return surface;
}

VkExtent2D framebuffer_size(const Window& window) {
  int width = 0;
  int height = 0;
  glfwGetFramebufferSize(window.handle, &width, &height);
  return {static_cast<std::uint32_t>(std::max(width, 0)), static_cast<std::uint32_t>(std::max(height, 0))};
}

bool next_frame(Window& window) {
  using Clock = std::chrono::steady_clock;
  constexpr double kBetweenLooks_s = 0.25;  // where the window system does not say that the window is to be seen again
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<float, std::milli>(window.display_frame_ms));
  window.frame_start = next_start(window.frame_start, Clock::now(), period);
  std::this_thread::sleep_until(window.frame_start);
  glfwPollEvents();
  while (is_hidden(window) && !glfwWindowShouldClose(window.handle)) {
    window.was_hidden = true;
    glfwWaitEventsTimeout(kBetweenLooks_s);
  }
  return !glfwWindowShouldClose(window.handle);
}

void steer(Window& window, Pose& pose, float dt_s, bool mouse_free) {
  constexpr float kRadiansPerPixel = 0.003f;
  constexpr float kWalk_mps = 3;
  constexpr float kRun = 5;
  double x = 0;
  double y = 0;
  glfwGetCursorPos(window.handle, &x, &y);
  if (mouse_free && glfwGetMouseButton(window.handle, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS) {
    window.steering = true;
    pose.yaw_rad -= kRadiansPerPixel * static_cast<float>(x - window.last_x);
    pose.pitch_rad = std::clamp(pose.pitch_rad - kRadiansPerPixel * static_cast<float>(y - window.last_y), -1.5f, 1.5f);
  }
  window.last_x = x;
  window.last_y = y;
  const glm::vec3 ahead = forward(pose);
  const glm::vec3 side = right(pose);
  const std::array<std::pair<int, glm::vec3>, 6> moves = {{{GLFW_KEY_W, ahead},
                                                           {GLFW_KEY_S, -ahead},
                                                           {GLFW_KEY_D, side},
                                                           {GLFW_KEY_A, -side},
                                                           {GLFW_KEY_E, {0, 1, 0}},
                                                           {GLFW_KEY_Q, {0, -1, 0}}}};
  const auto pressed = [&](int key) { return glfwGetKey(window.handle, key) == GLFW_PRESS; };
  const float speed_mps = kWalk_mps * (pressed(GLFW_KEY_LEFT_SHIFT) || pressed(GLFW_KEY_RIGHT_SHIFT) ? kRun : 1);
  for (const auto& [key, direction] : moves) {
    if (!pressed(key)) continue;
    window.steering = true;
    pose.position += speed_mps * dt_s * direction;
  }
}

}  // namespace forest
