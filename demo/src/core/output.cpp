#include "output.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <system_error>
#include <utility>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

#include "failure.h"

namespace forest {
namespace {

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

Failure cannot_write(const std::string& file) {
  return Failure("cannot write " + file + ": " + std::strerror(errno));
}

/// The file itself where `file` is a link. In a folder that others write to, one that another user made may be a trap.
std::string target_of(const std::string& file) {
  const std::filesystem::path path(file), folder = path.has_parent_path() ? path.parent_path() : ".";
  struct stat link {};
  struct stat around {};
  if (::lstat(file.c_str(), &link) != 0 || !S_ISLNK(link.st_mode)) return file;
  const bool is_ours = link.st_uid == ::geteuid() || link.st_uid == 0;
  if (!is_ours && (::stat(folder.c_str(), &around) != 0 || (around.st_mode & (S_IWGRP | S_IWOTH)) != 0))
    throw Failure("cannot write " + file + ": it is a link that another user made");
  std::error_code error;
  const std::filesystem::path target = std::filesystem::weakly_canonical(path, error);
  return error ? file : target.string();
}

/// What becomes a file once it is written: a new one beside it. A device or pipe is written to itself.
class Output {
 public:
  explicit Output(const std::string& file) : file_(file) {
    make_folder(file);
    target_ = target_of(file);
    struct stat there {};
    const bool is_new = ::lstat(target_.c_str(), &there) != 0 || S_ISREG(there.st_mode);
    const std::string prefix = (std::filesystem::path(target_).parent_path() / (".coppice-forest-" + std::to_string(::getpid()))).string();
    constexpr int kFlags = O_WRONLY | O_CLOEXEC | O_NOFOLLOW, kMaxAttempts = 100;
    number_ = is_new ? -1 : ::open(target_.c_str(), kFlags | O_NONBLOCK);
    // A killed process of the same number may have left some.
    for (int i = 0; is_new && number_ < 0 && i < kMaxAttempts && (i == 0 || errno == EEXIST); ++i)
      number_ = ::open((temporary_ = prefix + "-" + std::to_string(i)).c_str(), kFlags | O_CREAT | O_EXCL, 0666);
    if (number_ < 0) throw cannot_write(file);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output() {
    if (number_ >= 0) ::close(number_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }

  /// errors  Failure
  void write(std::string_view bytes) {
    if (!write_all(number_, bytes) || ::close(std::exchange(number_, -1)) != 0) throw cannot_write(file_);
    if (!temporary_.empty() && ::rename(temporary_.c_str(), target_.c_str()) != 0) throw cannot_write(file_);
    temporary_.clear();
  }

 private:
  std::string file_, target_, temporary_;
  int number_;
};

}  // namespace

void check_output(const char* option, const std::string& file) {
  try {
    const Output tried(file);
  } catch (const Failure& failure) {
    throw Failure(std::string(option) + ": " + failure.what());
  }
}

void write_output(const std::string& file, std::string_view bytes) {
  Output(file).write(bytes);
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
