#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "coppice/coppice.h"
#include "result.h"

namespace coppice {

/// Reads files through io_uring: the kernel's threads read, one of ours waits for completions.
class UringIo {
 public:
  /// allocator  provides a few bytes per read. errors  unsupported: the kernel has no io_uring, or does not allow it; out_of_memory
  static Result<std::unique_ptr<UringIo>> create(const coppice_allocator& allocator);

  /// Before: every read is done.
  ~UringIo();
  UringIo(const UringIo&) = delete;
  UringIo& operator=(const UringIo&) = delete;

  struct Read {
    int file = -1;  ///< without O_NONBLOCK
    std::uint64_t offset = 0;
    void* destination = nullptr;
    std::size_t bytes = 0;
    void (*done)(void* argument, std::int64_t bytes_read) = nullptr;  ///< fewer bytes only at the end of the file; -errno on failure
    void* argument = nullptr;
  };
  /// Starts a read without waiting for the file. done is called on the waiting thread, or inline if the allocator hook has no memory. Any
  /// thread.
  void read(const Read& read);

 private:
  struct State;
  explicit UringIo(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace coppice
