#include "window.h"

#include <algorithm>
#include <array>

// volk.h came first, so GLFW declares its Vulkan functions.
#include <GLFW/glfw3.h>

#include "failure.h"

namespace forest {
namespace {

void on_key(GLFWwindow* handle, int key, int, int action, int) {
  auto& window = *static_cast<Window*>(glfwGetWindowUserPointer(handle));
  if (action != GLFW_PRESS) return;
  if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(handle, GLFW_TRUE);
  if (key == GLFW_KEY_TAB) window.overlay_visible = !window.overlay_visible;
  if (key == GLFW_KEY_C) window.wants_recording = true;
  if (key == GLFW_KEY_V) window.wants_next_view = true;
  if (key == GLFW_KEY_T) window.wants_temporal = true;
  if (key == GLFW_KEY_P) window.wants_picture = true;
  if (key == GLFW_KEY_R) window.steering = false;
}

std::string glfw_reason() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "unknown reason";
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

bool poll_window(Window& window) {
  glfwPollEvents();
  for (VkExtent2D size = framebuffer_size(window); (size.width == 0 || size.height == 0) && !glfwWindowShouldClose(window.handle);
       size = framebuffer_size(window))
    glfwWaitEvents();
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
  const glm::vec3 right = glm::normalize(glm::cross(ahead, glm::vec3(0, 1, 0)));
  const std::array<std::pair<int, glm::vec3>, 6> moves = {{{GLFW_KEY_W, ahead},
                                                           {GLFW_KEY_S, -ahead},
                                                           {GLFW_KEY_D, right},
                                                           {GLFW_KEY_A, -right},
                                                           {GLFW_KEY_E, {0, 1, 0}},
                                                           {GLFW_KEY_Q, {0, -1, 0}}}};
  const float speed_mps = kWalk_mps * (glfwGetKey(window.handle, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS ? kRun : 1);
  for (const auto& [key, direction] : moves) {
    if (glfwGetKey(window.handle, key) != GLFW_PRESS) continue;
    window.steering = true;
    pose.position += speed_mps * dt_s * direction;
  }
}

}  // namespace forest
