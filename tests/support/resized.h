#pragma once

// A struct of a program that was compiled with another header: of a smaller or larger size, in a block of its own, with canaries behind it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace coppice::test {

template <class T>
class Resized {
 public:
  /// The first `bytes` bytes of value; what a larger one has behind it is `tail`. bytes: at least 4
  Resized(const T& value, std::size_t bytes, unsigned char tail = 0) : bytes_(bytes + kCanaries, kCanary), size_(bytes) {
    std::memset(bytes_.data(), tail, std::min(bytes, bytes_.size()));
    std::memcpy(bytes_.data(), &value, std::min(bytes, sizeof(T)));
    const auto struct_size = static_cast<std::uint32_t>(bytes);
    std::memcpy(bytes_.data(), &struct_size, sizeof struct_size);
  }

  /// Only the first `bytes` bytes may be used.
  [[nodiscard]] T* get() { return reinterpret_cast<T*>(bytes_.data()); }
  /// As much of it as there is; the rest is zero.
  [[nodiscard]] T value() const {
    T value{};
    std::memcpy(static_cast<void*>(&value), bytes_.data(), std::min(size_, sizeof(T)));
    return value;
  }
  [[nodiscard]] unsigned char byte(std::size_t at) const { return bytes_[at]; }
  [[nodiscard]] bool has_canaries() const {
    return std::all_of(bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.end(),
                       [](unsigned char byte) { return byte == kCanary; });
  }

 private:
  static constexpr std::size_t kCanaries = 64;
  static constexpr unsigned char kCanary = 0xa5;
  std::vector<unsigned char> bytes_;
  std::size_t size_;
};

}  // namespace coppice::test
