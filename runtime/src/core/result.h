#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace coppice {

/// Kinds of failure, by who can act on them. The values are those of coppice_status in coppice.h; append, never renumber.
enum class Status : std::int32_t {
  ok = 0,
  invalid_argument = 1,  ///< the caller: null, wrong size, bad handle, option out of range
  io = 2,                ///< the operating system refused a file
  bad_file = 3,          ///< the bytes are not what they claim to be
  unsupported = 4,       ///< well formed, but needs something this build does not do
  out_of_memory = 5,
  device_lost = 6,
  internal = 7,  ///< a defect of ours that was caught before it did harm
};

/// An error for a person: `what` says which field or step, `offset` where in the file, `detail` the name or value.
struct Error {
  static constexpr std::uint64_t kNoOffset = ~std::uint64_t{0};

  Status status = Status::internal;
  const char* what = "";  ///< in static storage
  std::uint64_t offset = kNoOffset;
  std::string detail = {};

  /// One line: "what 'detail' at byte offset".
  [[nodiscard]] std::string message() const {
    std::string line = what;
    if (!detail.empty()) line += ": " + detail;
    if (offset != kNoOffset) line += " (at byte " + std::to_string(offset) + ")";
    return line;
  }
};

/// A T, or the Error that prevented it. Reading the value of a failed result is a defect and traps.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(Error error) : error_(std::move(error)) {}

  explicit operator bool() const { return value_.has_value(); }
  T& operator*() & { return *checked(); }
  const T& operator*() const& { return *const_cast<Result*>(this)->checked(); }
  /// By value: `for (x : *make())` must not outlive what make() returned.
  T operator*() && { return std::move(*checked()); }
  T* operator->() { return checked(); }
  const T* operator->() const { return const_cast<Result*>(this)->checked(); }
  [[nodiscard]] const Error& error() const { return error_; }

 private:
  T* checked() {
    if (!value_) __builtin_trap();
    return &*value_;
  }

  std::optional<T> value_;
  Error error_;
};

/// Success without a value, or an Error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : failed_(true), error_(std::move(error)) {}
  explicit operator bool() const { return !failed_; }
  [[nodiscard]] const Error& error() const { return error_; }

 private:
  bool failed_ = false;
  Error error_;
};

/// Moves a value to its place. If there is none the place stays as it is and the error is returned.
template <class T>
Result<void> move_into(T& place, Result<T> value) {
  if (!value) return value.error();
  place = *std::move(value);
  return {};
}

}  // namespace coppice

#define COPPICE_CONCAT_(a, b) a##b
#define COPPICE_CONCAT(a, b) COPPICE_CONCAT_(a, b)
#define COPPICE_TRY_(temporary, name, expression) \
  auto temporary = (expression);                  \
  if (!temporary) return temporary.error();       \
  auto name = *std::move(temporary)

/// Declares `name` with the value of a Result, or returns its error from the enclosing function.
#define COPPICE_TRY(name, expression) COPPICE_TRY_(COPPICE_CONCAT(coppice_try_, __LINE__), name, expression)
/// Does the same for a Result<void>.
#define COPPICE_CHECK(expression) \
  if (auto coppice_check = (expression); !coppice_check) return coppice_check.error()
