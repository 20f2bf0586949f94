#include "output.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <system_error>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

#include "failure.h"

namespace forest {
namespace {

/// Descriptor of an open file; closed on every way out.
struct Descriptor {
  int number = -1;

  explicit Descriptor(int n) : number(n) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

void make_folder(const std::string& file) {
  std::error_code ignored;  // a folder that cannot be made shows as a file that cannot be written
  std::filesystem::create_directories(std::filesystem::path(file).parent_path(), ignored);
}

bool write_all(int number, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(number, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

void check_output(const char* option, const std::string& file) {
  make_folder(file);
  std::error_code absent;
  const bool was_there = std::filesystem::exists(file, absent);
  const Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666));
  if (descriptor.number < 0) throw Failure(std::string(option) + ": cannot write " + file + ": " + std::strerror(errno));
  if (!was_there) ::unlink(file.c_str());
}

void write_output(const std::string& file, std::string_view bytes) {
  make_folder(file);
  Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  bool written = descriptor.number >= 0 && write_all(descriptor.number, bytes);
  int reason = errno;
  if (written) {
    written = ::close(descriptor.number) == 0;
    reason = errno;
    descriptor.number = -1;
  }
  if (written) return;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(file, ignored)) std::filesystem::remove(file, ignored);
  throw Failure("cannot write " + file + ": " + std::strerror(reason));
}

void write_png(const std::string& file, std::uint32_t width, std::uint32_t height, std::span<const std::uint8_t> rgba) {
  std::vector<std::uint8_t> rgb(std::size_t{width} * height * 3);
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i)
    for (std::size_t channel = 0; channel < 3; ++channel) rgb[3 * i + channel] = rgba[4 * i + channel];
  const auto w = static_cast<int>(width);
  int bytes = 0;
  const std::unique_ptr<unsigned char, void (*)(void*)> png(
      stbi_write_png_to_mem(rgb.data(), 3 * w, w, static_cast<int>(height), 3, &bytes), std::free);
  if (!png) throw std::bad_alloc();
  write_output(file, {reinterpret_cast<const char*>(png.get()), static_cast<std::size_t>(bytes)});
}

}  // namespace forest
