#include "io_result.h"

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <system_error>

namespace coppice {

namespace {

constexpr std::uint64_t kFirstPause_ns = 50'000'000;
constexpr std::uint64_t kLongestSleep_ns = 5'000'000;
constexpr std::uint64_t kFirstReread_ns = 5'000'000'000, kMaxReread_ns = 60'000'000'000;

/// -1 is EPERM, but also the result of a hook that knows no reason.
std::string reason_of(std::int64_t result) {
  return result < -1 && result > -4096 ? std::generic_category().message(static_cast<int>(-result)) : std::string();
}

}  // namespace

Status status_of(int reason) {
  return reason == ENOMEM ? Status::out_of_memory : Status::io;
}

Error open_error(std::int64_t result) {
  return {Status::io, "cannot open file", Error::kNoOffset, result == -EINVAL ? "not a regular file" : reason_of(result)};
}

Error read_error(std::int64_t bytes_read, std::size_t expected, std::uint64_t offset) {
  if (bytes_read < 0) return {bytes_read == -ENOMEM ? Status::out_of_memory : Status::io, "read failed", offset, reason_of(bytes_read)};
  return {Status::io, "read failed", offset, std::to_string(bytes_read) + " of " + std::to_string(expected) + " bytes"};
}

bool ReadRetry::pause(std::uint64_t now_ns) {
  if (++failed_attempts >= kReadAttempts) return false;
  again_ns = now_ns + (kFirstPause_ns << 2 * (failed_attempts - 1));
  return true;
}

void Reread::schedule(std::uint64_t now_ns, bool again) {
  if (!again) count = 0;
  if (at_ns == 0) at_ns = now_ns + std::min(kFirstReread_ns << std::min(count++, 4u), kMaxReread_ns);
}

bool Reread::take(std::uint64_t (*clock_ns)()) {
  if (at_ns == 0 || clock_ns() < at_ns) return false;
  at_ns = 0;
  return true;
}

void wait_until(std::uint64_t (*clock_ns)(), std::uint64_t until_ns) {
  for (std::uint64_t now = clock_ns(); now < until_ns; now = clock_ns()) {
    const timespec pause{0, static_cast<long>(std::min(until_ns - now, kLongestSleep_ns))};
    nanosleep(&pause, nullptr);
  }
}

void AwaitedRead::start(const coppice_io& io, std::int64_t file, std::uint64_t offset, std::span<std::uint8_t> out) {
  while (queue_.take() != nullptr) continue;
  read_ = {&queue_, offset, out};
  queue_.expect();
  io.read(io.user, file, offset, out.data(), out.size(), on_done, &read_);
}

void AwaitedRead::on_done(void* argument, std::int64_t bytes_read) {
  auto* read = static_cast<Read*>(argument);
  read->bytes_read = bytes_read;
  read->queue->push(read);
}

Result<void> AwaitedRead::result() const {
  return whole() ? Result<void>() : read_error(read_.bytes_read, read_.out.size(), read_.offset);
}

Result<void> read_now(const coppice_io& io, std::int64_t file, std::span<std::uint8_t> out, std::uint64_t (*clock_ns)()) {
  AwaitedRead read;
  ReadRetry retry;
  for (read.start(io, file, 0, out);; read.repeat(io, file)) {
    read.wait();
    if (read.whole() || !retry.pause(clock_ns())) return read.result();
    wait_until(clock_ns, retry.again_ns);
  }
}

}  // namespace coppice
