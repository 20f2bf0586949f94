#include "atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace coppice::bake {
namespace {

Error io_error(const char* what, const std::filesystem::path& path, int reason) {
  return Error{Status::io, what, Error::kNoOffset, path.string() + ": " + std::strerror(reason)};
}

/// An open file, closed on every way out.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int number() const { return number_; }
  /// False, with errno, when the system could not keep what was written (network file systems say so only here).
  [[nodiscard]] bool close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

/// A temporary file beside the target, removed again unless it was renamed into place.
struct TemporaryFile {
  std::filesystem::path path;
  bool renamed = false;

  explicit TemporaryFile(std::filesystem::path p) : path(std::move(p)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (!renamed) ::unlink(path.c_str());
  }
};

/// Unique among the files this and other processes are writing now; O_EXCL catches what a killed process left behind.
std::filesystem::path temporary_path(const std::filesystem::path& target) {
  static std::atomic<unsigned> counter{0};
  const std::string name = "." + target.filename().string() + "." + std::to_string(::getpid()) + "." + std::to_string(counter++) + ".tmp";
  return target.parent_path() / name;
}

/// The process in a name made by temporary_path; 0 in any other name.
pid_t temporary_process(const std::string& name) {
  constexpr std::string_view kEnd = ".tmp";
  if (!name.starts_with('.') || !name.ends_with(kEnd)) return 0;
  const std::size_t counter_dot = name.rfind('.', name.size() - kEnd.size() - 1);
  const std::size_t process_dot = counter_dot == std::string::npos || counter_dot == 0 ? counter_dot : name.rfind('.', counter_dot - 1);
  if (process_dot == std::string::npos || process_dot == 0) return 0;
  const std::string_view digits = std::string_view(name).substr(process_dot + 1, counter_dot - process_dot - 1);
  pid_t process = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), process);
  return error == std::errc() && end == digits.data() + digits.size() && process > 0 ? process : 0;
}

Result<void> write_all(int file, std::span<const std::uint8_t> bytes, const std::filesystem::path& target) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return io_error("cannot write", target, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

/// A rename survives a power cut only once the folder itself is on disk. Some file systems cannot sync folders; the file is whole either
/// way.
void sync_folder(const std::filesystem::path& folder) {
  const Descriptor descriptor(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.number() >= 0) ::fsync(descriptor.number());
}

/// Where the bytes go: through a symbolic link to what it names, and never over something that is not a plain file.
Result<std::filesystem::path> resolve_target(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::path target = std::filesystem::is_symlink(path, error) ? std::filesystem::weakly_canonical(path, error) : path;
  if (error) target = path;
  struct stat status {};
  if (::stat(target.c_str(), &status) != 0) {
    if (errno != ENOENT) return io_error("cannot write", path, errno);
    return target;
  }
  if (S_ISDIR(status.st_mode)) return io_error("cannot write", path, EISDIR);
  if (!S_ISREG(status.st_mode)) return Error{Status::io, "cannot write", Error::kNoOffset, path.string() + ": not a plain file"};
  return target;
}

}  // namespace

Result<void> write_file_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  COPPICE_TRY(target, resolve_target(path));
  std::filesystem::path beside = temporary_path(target);
  int number = -1;
  while ((number = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) < 0 && errno == EEXIST)
    beside = temporary_path(target);
  if (number < 0) return io_error("cannot write", path, errno);
  Descriptor file(number);
  TemporaryFile temporary(beside);

  COPPICE_CHECK(write_all(file.number(), bytes, path));
  if (::fsync(file.number()) != 0) return io_error("cannot write", path, errno);
  if (!file.close()) return io_error("cannot write", path, errno);
  if (::rename(beside.c_str(), target.c_str()) != 0) return io_error("cannot write", path, errno);
  temporary.renamed = true;
  sync_folder(target.parent_path());
  return {};
}

void remove_abandoned_temporaries(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> abandoned;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const pid_t process = temporary_process(entry->path().filename().string());
    if (process > 0 && ::kill(process, 0) != 0 && errno == ESRCH) abandoned.push_back(entry->path());
  }
  for (const std::filesystem::path& file : abandoned) std::filesystem::remove(file, error);
}

Result<std::vector<std::uint8_t>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number() < 0) return io_error("cannot read", path, errno);
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) return io_error("cannot read", path, errno);

  // The size is a hint: pipes have none, and a file may grow while it is read.
  constexpr std::size_t kBlockBytes = 1 << 16;
  std::vector<std::uint8_t> bytes;
  const std::uint64_t expected_bytes = S_ISREG(status.st_mode) ? static_cast<std::uint64_t>(status.st_size) : 0;
  bytes.reserve(static_cast<std::size_t>(std::min(expected_bytes, max_bytes)) + kBlockBytes);
  while (true) {
    const std::size_t end = bytes.size();
    const auto block_bytes = static_cast<std::size_t>(std::min<std::uint64_t>(kBlockBytes, max_bytes - end));
    bytes.resize(end + block_bytes);
    const ssize_t count = ::read(file.number(), bytes.data() + end, block_bytes);
    bytes.resize(end + static_cast<std::size_t>(count > 0 ? count : 0));
    if (count == 0) return bytes;
    if (count < 0 && errno != EINTR) return io_error("cannot read", path, errno);
  }
}

}  // namespace coppice::bake
