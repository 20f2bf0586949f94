#include "uring_io.h"

#include <liburing.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <cerrno>
#include <mutex>
#include <new>
#include <system_error>

namespace coppice {

namespace {

constexpr unsigned kEntries = 128;
constexpr unsigned kCompletions = 4096;
constexpr std::size_t kMaxBytesAtOnce = std::size_t{1} << 30;  ///< a request's length has 32 bits

struct Task {
  UringIo::Read read;
  std::size_t bytes_read = 0;
};

}  // namespace

struct UringIo::State {
  coppice_allocator allocator{};
  io_uring ring{};
  bool ring_made = false, thread_made = false;
  std::mutex mutex;  ///< guards the submission side, and orders what the waiting thread sees of a task
  pthread_t thread{};

  ~State() {
    if (thread_made) {
      submit(nullptr);
      pthread_join(thread, nullptr);
    }
    if (ring_made) io_uring_queue_exit(&ring);
  }

  /// Null ends the waiting thread.
  void submit(Task* task) {
    const std::lock_guard lock(mutex);
    io_uring_sqe* entry = io_uring_get_sqe(&ring);
    for (; entry == nullptr; entry = io_uring_get_sqe(&ring)) submit_entries();
    if (task == nullptr) {
      io_uring_prep_nop(entry);
    } else {
      const UringIo::Read& read = task->read;
      const std::size_t bytes = std::min(read.bytes - task->bytes_read, kMaxBytesAtOnce);
      io_uring_prep_read(entry, read.file, static_cast<std::uint8_t*>(read.destination) + task->bytes_read, static_cast<unsigned>(bytes),
                         read.offset + task->bytes_read);
      // Without it the kernel copies cached data at once, on the engine's thread.
      io_uring_sqe_set_flags(entry, IOSQE_ASYNC);
    }
    io_uring_sqe_set_data(entry, task);
    submit_entries();
  }

  // EBUSY: the waiting thread has not collected finished reads yet. Entries that an error leaves behind go with the next submission.
  void submit_entries() {
    for (int result = io_uring_submit(&ring); result == -EAGAIN || result == -EBUSY || result == -EINTR; result = io_uring_submit(&ring))
      sched_yield();
  }

  void run() {
    while (true) {
      io_uring_cqe* entry = nullptr;
      if (io_uring_wait_cqe(&ring, &entry) != 0) continue;
      auto* task = static_cast<Task*>(io_uring_cqe_get_data(entry));
      const int result = entry->res;
      io_uring_cqe_seen(&ring, entry);
      if (task == nullptr) return;
      { const std::lock_guard lock(mutex); }  // waits until submit() does not use the task any more
      take(task, result);
    }
  }

  void take(Task* task, int result) {
    if (result > 0) task->bytes_read += static_cast<std::size_t>(result);
    if (result == -EINTR || (result > 0 && task->bytes_read < task->read.bytes)) return submit(task);
    const Task done = *task;
    allocator.free(allocator.user, task, sizeof(Task));
    done.read.done(done.read.argument, result < 0 ? result : static_cast<std::int64_t>(done.bytes_read));
  }
};

UringIo::UringIo(std::unique_ptr<State> state) : state_(std::move(state)) {}
UringIo::~UringIo() = default;

Result<std::unique_ptr<UringIo>> UringIo::create(const coppice_allocator& allocator) {
  std::unique_ptr<State> state(new (std::nothrow) State);
  if (!state) return Error{Status::out_of_memory, "io_uring"};
  state->allocator = allocator;
  io_uring_params params{};
  params.flags = IORING_SETUP_CQSIZE;
  params.cq_entries = kCompletions;
  if (io_uring_queue_init_params(kEntries, &state->ring, &params) != 0) return Error{Status::unsupported, "io_uring"};
  state->ring_made = true;
  io_uring_probe* probe = io_uring_get_probe_ring(&state->ring);
  const bool reads = probe != nullptr && io_uring_opcode_supported(probe, IORING_OP_READ) != 0;
  io_uring_free_probe(probe);
  if (!reads) return Error{Status::unsupported, "io_uring: no reads"};
  const auto entry = [](void* argument) -> void* {
    static_cast<State*>(argument)->run();
    return nullptr;
  };
  if (const int error = pthread_create(&state->thread, nullptr, entry, state.get()); error != 0)
    return Error{Status::out_of_memory, "io_uring: no thread could be started", Error::kNoOffset, std::generic_category().message(error)};
  state->thread_made = true;
  std::unique_ptr<UringIo> io(new (std::nothrow) UringIo(std::move(state)));
  if (!io) return Error{Status::out_of_memory, "io_uring"};
  return io;
}

void UringIo::read(const Read& read) {
  const coppice_allocator& allocator = state_->allocator;
  void* memory = allocator.allocate(allocator.user, sizeof(Task), alignof(Task));
  if (memory == nullptr) return read.done(read.argument, -ENOMEM);
  state_->submit(new (memory) Task{read, 0});
}

}  // namespace coppice
