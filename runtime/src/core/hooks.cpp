#include "hooks.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <new>

#include "printable.h"

namespace coppice {

namespace {

void* allocate_with_malloc(void*, std::size_t bytes, std::size_t align) {
  void* pointer = nullptr;
  return posix_memalign(&pointer, std::max(align, sizeof(void*)), bytes) == 0 ? pointer : nullptr;
}

void free_with_malloc(void*, void* pointer, std::size_t) {
  std::free(pointer);
}

DefaultHooks& defaults_of(void* user) {
  return *static_cast<DefaultHooks*>(user);
}

void submit_to_pool(void* user, const coppice_job* job) {
  ThreadPool& pool = *defaults_of(user).pool;
  if (job->priority == COPPICE_PRIORITY_LOW)
    pool.submit_long(job->function, job->argument);
  else
    pool.submit(job->function, job->argument);
}

std::int64_t open_file(void*, const char* path, std::uint64_t* file_bytes) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // without O_NONBLOCK a FIFO would wait for its writer
  if (file < 0) return -errno;
  struct stat status {};
  const int unknown = fstat(file, &status) != 0 ? errno : 0;
  if (unknown != 0 || !S_ISREG(status.st_mode)) {
    ::close(file);
    return -(unknown != 0 ? unknown : S_ISDIR(status.st_mode) ? EISDIR : EINVAL);
  }
  fcntl(file, F_SETFL, 0);  // io_uring would apply O_NONBLOCK to reads
  *file_bytes = static_cast<std::uint64_t>(status.st_size);
  return file;
}

void close_file(void*, std::int64_t file) {
  ::close(static_cast<int>(file));
}

struct ReadTask {
  coppice_allocator allocator{};
  int file = -1;
  std::uint64_t offset = 0;
  void* destination = nullptr;
  std::size_t bytes = 0;
  void (*done)(void* argument, std::int64_t bytes_read) = nullptr;
  void* argument = nullptr;
};

/// Returns the bytes read, fewer at the end of the file; -errno on failure.
std::int64_t read_all(const ReadTask& task) {
  std::size_t at = 0;
  while (at < task.bytes) {
    const ssize_t got =
        pread(task.file, static_cast<std::uint8_t*>(task.destination) + at, task.bytes - at, static_cast<off_t>(task.offset + at));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -errno;
    if (got == 0) break;
    at += static_cast<std::size_t>(got);
  }
  return static_cast<std::int64_t>(at);
}

void run_read(void* argument) {
  auto* pointer = static_cast<ReadTask*>(argument);
  const ReadTask task = *pointer;
  task.allocator.free(task.allocator.user, pointer, sizeof(ReadTask));
  task.done(task.argument, read_all(task));
}

void read_on_pool(void* user, std::int64_t file, std::uint64_t offset, void* destination, std::size_t bytes,
                  void (*done)(void* argument, std::int64_t bytes_read), void* argument) {
  DefaultHooks& defaults = defaults_of(user);
  void* memory = defaults.allocator.allocate(defaults.allocator.user, sizeof(ReadTask), alignof(ReadTask));
  if (memory == nullptr) {
    done(argument, -ENOMEM);
    return;
  }
  auto* task = new (memory) ReadTask{defaults.allocator, static_cast<int>(file), offset, destination, bytes, done, argument};
  defaults.pool->submit(run_read, task);
}

void read_by_uring(void* user, std::int64_t file, std::uint64_t offset, void* destination, std::size_t bytes,
                   void (*done)(void* argument, std::int64_t bytes_read), void* argument) {
  defaults_of(user).uring->read({static_cast<int>(file), offset, destination, bytes, done, argument});
}

/// The longest path that Linux opens, and the text about it.
constexpr std::size_t kMaxLineBytes = 4096 + 512;

enum class Given { none, partly, all };

template <class... Functions>
Given given(Functions... functions) {
  const int set = (0 + ... + (functions != nullptr ? 1 : 0));
  if (set == 0) return Given::none;
  return set == sizeof...(functions) ? Given::all : Given::partly;
}

}  // namespace

coppice_allocator default_allocator() {
  return {sizeof(coppice_allocator), nullptr, allocate_with_malloc, free_with_malloc};
}

Result<HookArray<char>> copied_text(std::string_view text, const coppice_allocator& allocator) {
  COPPICE_TRY(copy, HookArray<char>::allocate(allocator, text.size() + 1));
  std::ranges::copy(text, copy.data());
  return copy;
}

Result<void> check_hooks(const Hooks& hooks) {
  if (given(hooks.allocator.allocate, hooks.allocator.free) == Given::partly)
    return Error{Status::invalid_argument, "desc.allocator: one of allocate, free is null"};
  if (given(hooks.io.open, hooks.io.close, hooks.io.read) == Given::partly)
    return Error{Status::invalid_argument, "desc.io: one of open, close, read is null"};
  return {};
}

Result<HookSet> complete_hooks(const Hooks& hooks, Reading reading) {
  COPPICE_CHECK(check_hooks(hooks));
  HookSet set;
  set.hooks = hooks;
  const Given allocator = given(hooks.allocator.allocate, hooks.allocator.free);
  const Given io = given(hooks.io.open, hooks.io.close, hooks.io.read);
  const Given jobs = given(hooks.jobs.submit);
  if (allocator == Given::none) set.hooks.allocator = default_allocator();
  const auto put_in_order = [&set]() -> Result<HookSet> {
    set.order.reset(new (std::nothrow) JobOrder(set.hooks.jobs, set.hooks.allocator, now_ns));
    if (!set.order) return Error{Status::out_of_memory, "default hooks"};
    set.hooks.jobs = set.order->hook();
    return std::move(set);
  };
  if (io == Given::all && jobs == Given::all) return put_in_order();

  set.defaults.reset(new (std::nothrow) DefaultHooks);
  if (!set.defaults) return Error{Status::out_of_memory, "default hooks"};
  set.defaults->allocator = set.hooks.allocator;
  if (io == Given::none && reading == Reading::automatic)
    if (auto uring = UringIo::create(set.hooks.allocator)) set.defaults->uring = *std::move(uring);
  const bool by_uring = set.defaults->uring != nullptr;
  if (jobs == Given::none || (io == Given::none && !by_uring)) {
    COPPICE_CHECK(move_into(set.defaults->pool, ThreadPool::create(0)));
  }
  if (jobs == Given::none) set.hooks.jobs = {sizeof(coppice_jobs), set.defaults.get(), submit_to_pool};
  set.real_files = io == Given::none;
  if (io == Given::none)
    set.hooks.io = {sizeof(coppice_io), set.defaults.get(), open_file, close_file, by_uring ? read_by_uring : read_on_pool, nullptr};
  return put_in_order();
}

std::uint64_t now_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000u + static_cast<std::uint64_t>(time.tv_nsec);
}

void log_line(const coppice_log& log, coppice_log_level level, const char* format, ...) {
  if (log.write == nullptr) return;
  std::array<char, kMaxLineBytes> line{};
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line.data(), line.size(), format, arguments);
  va_end(arguments);
  // Every text that may quote a file's names or an error passes through here, because engines print it on terminals.
  if (is_printable(line.data()))
    log.write(log.user, level, line.data());
  else
    log.write(log.user, level, printable(line.data()).c_str());
}

}  // namespace coppice
