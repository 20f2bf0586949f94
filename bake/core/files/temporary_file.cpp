#include "temporary_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <regex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace coppice::bake {
namespace {

/// Holds a file for the signal handler. A process has few temporary files at a time; one too many is not in the table.
struct Slot {
  std::atomic<pid_t> owner{0};  ///< 0: free; kFilling; else the process that made the file
  int folder = -1;
  std::array<char, 64> name{};
};

constexpr pid_t kFilling = -1;
constexpr std::size_t kNoSlot = ~std::size_t{0};

// Signal handlers read it, so no destructor may run on it.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
constinit std::array<Slot, 16> slots{};
static_assert(std::atomic<pid_t>::is_always_lock_free, "signal handlers read it");

std::size_t take_slot(int folder, const std::string& name) {
  for (std::size_t i = 0; i < slots.size(); ++i) {
    pid_t free = 0;
    if (!slots[i].owner.compare_exchange_strong(free, kFilling)) continue;
    slots[i].folder = folder;
    slots[i].name.at(name.copy(slots[i].name.data(), slots[i].name.size() - 1)) = '\0';
    slots[i].owner.store(::getpid());
    return i;
  }
  return kNoSlot;
}

void free_slot(std::size_t slot) {
  if (slot != kNoSlot) slots[slot].owner.store(0);
}

/// Eight hexadecimal digits of a hash of this machine's name.
const std::string& machine_digits() {
  static const std::string digits = [] {
    std::array<char, 256> host{};
    static_cast<void>(::gethostname(host.data(), host.size() - 1));
    std::uint32_t hash = 2166136261u;  // FNV-1a
    for (const char* c = host.data(); *c != '\0'; ++c) hash = (hash ^ static_cast<unsigned char>(*c)) * 16777619u;
    std::array<char, 9> text{};
    static_cast<void>(std::snprintf(text.data(), text.size(), "%08x", hash));
    return std::string(text.data());
  }();
  return digits;
}

/// Returns ".coppice-PROCESS-NUMBER-MACHINE.tmp", unique among the files that this and other processes write now. O_EXCL catches what a
/// killed process left. The target's name is not part of it: together they could be too long for a file's name.
std::string temporary_name() {
  static std::atomic<unsigned> counter{0};
  std::string name(".coppice-");
  name.append(std::to_string(::getpid())).append("-").append(std::to_string(counter++)).append("-").append(machine_digits()).append(".tmp");
  return name;
}

/// Says who made a temporary file, by the file's name. Process 0: it is no temporary file.
struct Maker {
  pid_t process = 0;
  bool is_here = true;  ///< it was made on this machine, or its name says none
};

Maker maker_of(const std::string& name) {
  static const std::regex form(R"(\.coppice-([1-9][0-9]{0,8})-[0-9]+(?:-([0-9a-f]{8}))?\.tmp)");
  std::smatch found;
  if (!std::regex_match(name, found, form)) return {};
  return {std::stoi(found[1]), !found[2].matched || found[2] == machine_digits()};
}

/// No write takes this long.
bool is_old(const std::filesystem::path& path) {
  std::error_code gone;
  const auto written = std::filesystem::last_write_time(path, gone);
  return !gone && std::filesystem::file_time_type::clock::now() - written > std::chrono::hours(1);
}

/// Whether the file's process is gone: it does not run here, and no other container or machine that sees this folder holds the file's lock.
/// Some network file systems do not share locks between machines, so a file of another machine must be old too.
bool is_abandoned(const std::filesystem::path& path) {
  const Maker maker = maker_of(path.filename().native());
  if (maker.process == 0) return false;
  if (maker.is_here && (::kill(maker.process, 0) == 0 || errno != ESRCH)) return false;
  if (!maker.is_here && !is_old(path)) return false;
  const Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW));
  return file.number() >= 0 && ::flock(file.number(), LOCK_EX | LOCK_NB) == 0;
}

/// A rename survives a power cut only once the folder is on disk. Some file systems cannot sync folders; the file is whole either way.
void sync_folder(const Descriptor& folder) {
  const Descriptor opened(::openat(folder.number(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.number() >= 0) ::fsync(opened.number());
}

}  // namespace

Result<void> write_all(int descriptor, std::span<const std::uint8_t> bytes, const std::filesystem::path& name) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return system_error("cannot write", name, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

TemporaryFile::TemporaryFile(FilePlace target, std::string name, std::size_t slot)
    : target_(std::move(target)), name_(std::move(name)), slot_(slot) {}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : target_(std::move(other.target_)),
      name_(std::exchange(other.name_, {})),
      slot_(std::exchange(other.slot_, kNoSlot)),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

TemporaryFile::~TemporaryFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!name_.empty()) ::unlinkat(target_.folder.number(), name_.c_str(), 0);
  free_slot(slot_);
}

Result<TemporaryFile> TemporaryFile::create_beside(FilePlace target) {
  while (true) {
    std::string name = temporary_name();
    const int folder = target.folder.number();
    const std::size_t slot = take_slot(folder, name);  // comes before the file, as a signal may come between
    const int descriptor = ::openat(folder, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      TemporaryFile file(std::move(target), std::move(name), slot);
      file.descriptor_ = descriptor;
      ::flock(descriptor, LOCK_EX | LOCK_NB);  // is_abandoned tests this lock; without locks the process's number has to do
      return file;
    }
    const int reason = errno;
    free_slot(slot);
    if (reason != EEXIST) return system_error("cannot write", target.path, reason);
  }
}

TemporaryFile TemporaryFile::none(FilePlace target) {
  return TemporaryFile(std::move(target), {}, kNoSlot);
}

Result<void> TemporaryFile::write(std::span<const std::uint8_t> bytes) {
  COPPICE_CHECK(write_all(descriptor_, bytes, target_.path));
  if (::fsync(descriptor_) != 0) return system_error("cannot write", target_.path, errno);
  // The second descriptor keeps the lock until the file has its name. Without it another machine would take the file for abandoned.
  const int held = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  if (held < 0) return system_error("cannot write", target_.path, errno);
  // Network file systems report a full disk only here.
  if (::close(std::exchange(descriptor_, held)) != 0) return system_error("cannot write", target_.path, errno);
  return {};
}

Result<std::uint32_t> TemporaryFile::owner() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) return system_error("cannot write", target_.path, errno);
  return std::uint32_t{status.st_uid};
}

Result<void> TemporaryFile::publish() {
  if (name_.empty()) return {};
  const int folder = target_.folder.number();
  if (::renameat(folder, name_.c_str(), folder, target_.name.c_str()) != 0) return system_error("cannot write", target_.path, errno);
  name_.clear();
  sync_folder(target_.folder);
  return {};
}

void remove_own_temporaries() noexcept {
  const pid_t self = ::getpid();
  for (const Slot& slot : slots)
    if (slot.owner.load() == self) ::unlinkat(slot.folder, slot.name.data(), 0);
}

void end_by_signal(int signal) noexcept {
  remove_own_temporaries();
  static_cast<void>(::signal(signal, SIG_DFL));
  static_cast<void>(::raise(signal));
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

void remove_abandoned_temporaries(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> abandoned;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (is_abandoned(entry->path())) abandoned.push_back(entry->path());
  for (const std::filesystem::path& file : abandoned) std::filesystem::remove(file, error);
}

}  // namespace coppice::bake
